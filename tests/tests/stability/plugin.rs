//! The step with only contour feedback.

use super::campaign::Track;
use trueaxis::Dynamics;
use trueaxis::contour::Method;
use trueaxis::machine::{DriveFigures, DynamicSettings, FeedbackSettings, Limits, MachineSettings};
use trueaxis::telemetry::Status;
use trueaxis::{Config, ConfigError, HostServo, Row, State};
use trueaxis_testing::machine::Machine;
use trueaxis_tests::course::Command;

/// Limits that no plant of the campaign reaches, so that only the loop is tested.
pub(crate) const WIDE: Limits = Limits { magnitude: 1.0, slope_per_s: 100.0, acceleration_per_s2: 100_000.0 };

/// A machine with a drive on every axis and contour feedback; `limits`, or else the default limits.
pub(crate) fn machine(
    drive: DriveFigures,
    [proportional, integral_per_s]: [f64; 2],
    watch_mm: f64,
    limits: Option<Limits>,
) -> MachineSettings {
    let feedback = FeedbackSettings { proportional, integral_per_s, watch_mm, max_feed_per_s: 500.0 };
    Machine::three_axis()
        .each(|axis| {
            axis.servo.drive = Some(drive);
            if let Some(limits) = limits {
                axis.joint = axis.travel.map(|end| end + limits.magnitude.copysign(end));
                axis.limits = limits;
                axis.servo.dynamic = Some(DynamicSettings { limits, ..DynamicSettings::with_defaults(axis.axis) });
            }
        })
        .with(|machine| machine.contour.feedback = Some(feedback))
        .settings()
}

/// Builds the servo loop.
pub(crate) fn servo(machine: &MachineSettings, period_s: f64) -> Result<HostServo<'static, 3>, ConfigError> {
    let period_ns = (period_s * 1e9).round() as u32;
    let config = Config {
        machine,
        grids: &[],
        machine_id: 0,
        tables_crc: 0,
        period_ns,
        inverse_passes: 1,
        method: Method::Guarded,
    };
    config.build(|_| None::<&[Row]>, Default::default())
}

/// A servo loop on a track.
pub(crate) struct Plugin<'s> {
    servo: &'s HostServo<'static, 3>,
    track: &'s Track,
    state: State<f64, f64, 3>,
    /// Cycle from which the watch had switched the feedback off.
    pub(crate) out_since: Option<usize>,
    cycle: usize,
    /// Parts of the dynamic correction.
    pub(crate) parts: Dynamics,
}

impl<'s> Plugin<'s> {
    pub(crate) fn new(servo: &'s HostServo<'static, 3>, track: &'s Track) -> Plugin<'s> {
        Plugin { servo, track, state: servo.start(), out_since: None, cycle: 0, parts: Dynamics::ALL }
    }

    /// Drive positions of a cycle.
    pub(crate) fn drive(&mut self, command: &Command, [x, y]: [f64; 2]) -> [f64; 2] {
        let mut input = self.servo.input(command.at, [x, y, command.at[2]]);
        input.dynamics = self.parts;
        let path = self.track.course.path();
        let output = self.servo.step(&mut self.state, &input, path.on(command.reference), ());
        if output.record.status.has(Status::FEEDBACK_OUT) {
            self.out_since.get_or_insert(self.cycle);
        } else {
            assert_eq!(self.out_since, None, "the feedback stays out");
        }
        self.cycle += 1;
        [output.drive[0], output.drive[1]]
    }
}
