//! Samples of a cycle, and the sinks that receive them.

use trueaxis::contour::{Flags, Reference};
use trueaxis::machine::AXES;

/// Command of a cycle, common to all machines of a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moment {
    /// Cycle, counted from the start of the program.
    pub cycle: u64,
    /// Time of the cycle, s.
    pub time_s: f64,
    /// Program line.
    pub line: u32,
    /// Whether the move cuts rather than positions at rapid.
    pub cutting: bool,
    /// Arc length along the program, mm.
    pub length_mm: f64,
    /// Programmed point in machine coordinates (with rotary axes: in workpiece coordinates), mm.
    pub nominal_mm: [f64; 3],
    /// Programmed A, B, C, degrees.
    pub rotary_deg: [f64; 3],
    /// Index into [`Program::moves`](crate::program::Program).
    pub move_index: usize,
    /// Parameter on the curve of that move.
    pub u: f64,
}

/// Parts of the dynamic correction in a cycle, µm and µrad; axes in the order X, Y, Z, A, B, C. All zero on a machine that is
/// driven without it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DynamicSample {
    /// Sent: the sum of the parts, limited.
    pub sent: [f32; AXES],
    /// Wanted feed-forward against friction, following error and acceleration error.
    pub feed_forward: [f32; AXES],
    /// Wanted contour feedback.
    pub feedback: [f32; AXES],
    /// Wanted correction of acceleration cross-talk.
    pub crosstalk: [f32; AXES],
}

/// Result of a cycle on one machine. Axes in the order X, Y, Z, A, B, C; zero for those that the machine does not have.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sample {
    /// Deviation of the true tip from the nearest point of the path, µm.
    pub deviation_um: [f32; 3],
    /// Angle between the true tool direction and the programmed one, µrad.
    pub orientation_urad: f32,
    /// Orientation error that the step reports, µrad.
    pub estimated_orientation_urad: f32,
    /// Contour error that the plugin reports for the estimated tip, µm.
    pub estimated_um: f32,
    /// `estimated_um` as a vector, tip − foot, in machine directions; `None` while the foot is unknown or the path has ended.
    pub contour_um: Option<[f32; 3]>,
    /// Flags of the foot.
    pub contour_flags: Flags,
    /// Contour error that the plugin reports for the plain encoder position, µm.
    pub encoder_um: f64,
    /// Arc length from the tip's foot to the reference, µm.
    pub lag_um: f64,
    /// Command as input to the step, mm and degrees.
    pub command: [f64; AXES],
    /// Command sent to the drives, mm and degrees.
    pub drive: [f64; AXES],
    /// Reading as input to the step, mm and degrees.
    pub feedback: [f64; AXES],
    /// Traversed share of each axis' lost motion, 0 after positive travel to 1 after negative travel.
    pub reverse: [f64; AXES],
    /// Geometric correction sent, µm and µrad.
    pub correction: [f32; AXES],
    /// Dynamic correction.
    pub dynamic: DynamicSample,
    /// Factors in use on the identified Coulomb friction and pre-sliding; 0 for an axis whose friction does not adapt.
    pub friction: [[f32; 2]; AXES],
    /// Fault code.
    pub fault: u8,
    /// State bits.
    pub status: u8,
    /// One bit per axis of the step: set if its correction differs from the wanted one.
    pub limited: u8,
    /// One bit per axis of the step: set if its table is clamped to its edge value.
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
    /// Whether the machine still settles at the first point, before the program's first cycle.
    pub settling: bool,
    /// Commanded positions in the step's order, mm and degrees.
    pub command: &'i [f64],
    /// Readings in the step's order, mm and degrees.
    pub feedback: &'i [f64],
    /// Time since the last cycle, ns.
    pub elapsed_ns: u32,
    /// Reference on the path.
    pub reference: Reference<f64>,
}

/// Receives every cycle of a run as it is simulated; the run keeps none.
pub trait Sink {
    /// Called for each cycle, in order; one entry per machine in the order requested, `None` once it has stopped.
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

/// Several sinks, nested: the last is called last before a step and first after it.
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
