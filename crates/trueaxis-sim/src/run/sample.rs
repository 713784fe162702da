//! Samples of a cycle, and the sinks that take them.

use trueaxis::contour::{Flags, Reference};
use trueaxis::machine::AXES;

/// Command of a cycle, the same on every machine of a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moment {
    /// Counted from the start of the program.
    pub cycle: u64,
    /// The same as time, s.
    pub time_s: f64,
    /// Program line.
    pub line: u32,
    /// Cutting, not positioning at rapid.
    pub cutting: bool,
    /// Arc length along the program, mm.
    pub length_mm: f64,
    /// Programmed point in machine coordinates (with rotary axes: in workpiece coordinates), mm.
    pub nominal_mm: [f64; 3],
    /// A, B, C programmed, degrees.
    pub rotary_deg: [f64; 3],
}

/// Parts of the dynamic correction in a cycle, µm and µrad; axes in the order X, Y, Z, A, B, C. All zero on a machine that
/// is driven without.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DynamicSample {
    /// Sent: the sum of the parts, limited.
    pub sent: [f32; AXES],
    /// Wanted against friction, following error and the error of acceleration.
    pub feed_forward: [f32; AXES],
    /// Wanted by the contour feedback.
    pub feedback: [f32; AXES],
    /// Wanted against acceleration cross-talk.
    pub crosstalk: [f32; AXES],
}

/// Result of a cycle on one machine. Axes in the order X, Y, Z, A, B, C; zero for those that the machine does not have.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sample {
    /// True tip from the nearest point of the path, µm.
    pub deviation_um: [f32; 3],
    /// Angle of the true tool direction from the programmed one, µrad.
    pub orientation_urad: f32,
    /// The same as the step reports it, µrad.
    pub estimated_orientation_urad: f32,
    /// Contour error that the plugin reports for the estimated tip, µm.
    pub estimated_um: f32,
    /// The same as a vector, tip − foot, in machine directions; none while the foot is not known or the path has ended.
    pub contour_um: Option<[f32; 3]>,
    /// Flags of its foot.
    pub contour_flags: Flags,
    /// Contour error that it reports for the plain encoder position, µm.
    pub encoder_um: f64,
    /// Arc length from the tip's foot to the reference, µm.
    pub lag_um: f64,
    /// Command as the step took it, mm and degrees.
    pub command: [f64; AXES],
    /// Command sent to the drives, mm and degrees.
    pub drive: [f64; AXES],
    /// Reading as the step took it, mm and degrees.
    pub feedback: [f64; AXES],
    /// Correction of geometry sent, µm and µrad.
    pub correction: [f32; AXES],
    /// Dynamic correction.
    pub dynamic: DynamicSample,
    /// Fault code.
    pub fault: u8,
    /// State bits.
    pub status: u8,
    /// A bit for every axis of the step whose correction differs from the wanted one.
    pub limited: u8,
    /// A bit for every axis of the step whose table is clamped to its edge value.
    pub at_edge: u8,
}

impl Sample {
    /// |deviation|, µm.
    pub fn error_um(&self) -> f32 {
        let [x, y, z] = self.deviation_um;
        (x * x + y * y + z * z).sqrt()
    }
}

/// Inputs of the step in a cycle.
#[derive(Clone, Copy, Debug)]
pub struct Given<'i> {
    /// Index of the machine among those of the run.
    pub machine: usize,
    /// The machine still settles at the first point, before the program's first cycle.
    pub settling: bool,
    /// Commanded positions in the step's order, mm and degrees.
    pub command: &'i [f64],
    /// Readings in the same order.
    pub feedback: &'i [f64],
    /// Time since the last cycle, ns.
    pub elapsed_ns: u32,
    /// Reference on the path.
    pub reference: Reference<f64>,
}

/// Takes every cycle of a run as it comes; the run itself keeps none.
pub trait Sink {
    /// A cycle, in order; one entry a machine in the order in which they were asked for, `None` where it has stopped.
    fn cycle(&mut self, moment: &Moment, machines: &[Option<&Sample>]);

    /// Called immediately before each step, settling included.
    fn before_step(&mut self, _given: &Given<'_>) {}

    /// Called immediately after each step.
    fn after_step(&mut self) {}
}

/// Drops everything.
impl Sink for () {
    fn cycle(&mut self, _moment: &Moment, _machines: &[Option<&Sample>]) {}
}

impl<F: FnMut(&Moment, &[Option<&Sample>])> Sink for F {
    fn cycle(&mut self, moment: &Moment, machines: &[Option<&Sample>]) {
        self(moment, machines);
    }
}

/// Several sinks, each within the ones before: the last is called last before a step and first after it.
impl Sink for Vec<&mut (dyn Sink + '_)> {
    fn cycle(&mut self, moment: &Moment, machines: &[Option<&Sample>]) {
        self.iter_mut().for_each(|sink| sink.cycle(moment, machines));
    }

    fn before_step(&mut self, given: &Given<'_>) {
        self.iter_mut().for_each(|sink| sink.before_step(given));
    }

    fn after_step(&mut self) {
        self.iter_mut().rev().for_each(|sink| sink.after_step());
    }
}
