//! Conversion of a cycle's results to its sample.

use super::cell::{Cell, Measured, Stepped};
use super::sample::Sample;
use trueaxis::contour::Flags;
use trueaxis::machine::AXES;
use trueaxis::telemetry::Record;
use trueaxis::{Fault, ServoLoop};

impl<const N: usize> Cell<N> {
    /// Contour error of the estimated tip in machine directions, µm.
    fn contour(&self, record: &Record<f64, f64, N>) -> Option<[f32; 3]> {
        let off = [Flags::NOT_FOUND, Flags::SEARCHING, Flags::COLD, Flags::AT_END, Flags::REFERENCE];
        if record.fault != Fault::None || off.iter().any(|flag| record.tip.flags.has(*flag)) {
            return None;
        }
        let vector = record.tip.vector;
        let in_machine = self.kinematics.as_ref().map_or(vector, |kinematics| {
            let mut joints = [0.0; AXES];
            for (axis, position) in self.axes.iter().zip(&record.feedback) {
                joints[axis.index()] = *position;
            }
            kinematics.to_bed(&joints, vector)
        });
        Some((1e3 * in_machine).as_vec3().to_array())
    }

    /// The sample of a cycle, with the true error.
    pub(super) fn sample(
        &self,
        measured: &Measured<N>,
        stepped: &Stepped<N>,
        servo: &ServoLoop<'_, f64, f64, N>,
    ) -> Sample {
        let Stepped { output, orientation } = stepped;
        let record = &output.record;
        let mut sample = Sample {
            deviation_um: (1e3 * measured.tip).as_vec3().to_array(),
            orientation_urad: (1e6 * measured.angle) as f32,
            estimated_orientation_urad: (orientation.angle * 1e6) as f32,
            estimated_um: (record.tip.error * 1e3) as f32,
            contour_um: self.contour(record),
            contour_flags: record.tip.flags,
            encoder_um: record.encoder.error * 1e3,
            lag_um: record.tip.lag * 1e3,
            fault: record.fault as u8,
            status: record.status.0,
            limited: record.limited,
            at_edge: record.at_edge,
            ..Sample::default()
        };
        for (k, axis) in self.axes.iter().enumerate() {
            let i = axis.index();
            sample.command[i] = record.command[k];
            sample.drive[i] = output.drive[k];
            sample.feedback[i] = record.feedback[k];
            sample.reverse[i] = measured.reverse[k];
            // mm to µm, degrees to µrad.
            let micro = |value: f64| if axis.is_rotary() { value.to_radians() * 1e6 } else { value * 1e3 } as f32;
            sample.correction[i] = micro(record.correction[k]);
            if let Some(parts) = &record.dynamic {
                sample.dynamic.sent[i] = micro(parts.sent[k]);
                sample.dynamic.feed_forward[i] = micro(parts.feed_forward[k]);
                sample.dynamic.feedback[i] = micro(parts.feedback[k]);
                sample.dynamic.crosstalk[i] = micro(parts.crosstalk[k]);
            }
            if let Some(factors) = servo.friction_factors(&self.state, k) {
                sample.friction[i] = factors.map(|factor| factor as f32);
            }
        }
        sample
    }
}
