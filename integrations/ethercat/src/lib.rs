//! One cycle of drives in cyclic synchronous position mode (CiA 402), with the trueaxis step inside.
//!
//! [`Cycle::run`] reads the inputs of a returned frame and fills the outputs of the next one. It depends on no main
//! device: the example `servo` calls it with ethercrab, the tests with a simulated process image.
//!
//! | event | reaction |
//! |---|---|
//! | a frame is lost, or its working counter is too low | the readings are old: the correction freezes, commands pass |
//! | [`LOST_MAX`] frames are lost in a row | quick stop, until [`Cycle::reset`] |
//! | a cycle is late or early by more than a quarter, by the distributed clock | the correction freezes in that cycle |
//! | a drive reports a fault | quick stop of all drives |
//! | a command is not a number, jumps or leaves the travel | the step holds; quick stop of all drives |

use trueaxis::{Bypass, Fault, HostServo, Output, State, Tcomp, WrappingCounter};

/// Axes of the machine: X, Y, Z.
pub const AXES: usize = 3;
/// Cycle of the process image and of the distributed clock, ns.
pub const PERIOD_NS: u32 = 1_000_000;
/// Frames that may be lost in a row before the machine stops.
pub const LOST_MAX: u32 = 3;
/// Number of bytes in a drive's outputs, which are the control word (0x6040, u16) and the target position (0x607A,
/// i32), and in its inputs, the status word (0x6041, u16) and the position (0x6064, i32). Little-endian, in the order
/// of the PDO mapping.
pub const IMAGE_BYTES: usize = 6;

const QUICK_STOP: u16 = 0x0002;

/// Outcome of a cycle's frame.
#[derive(Clone, Copy, Debug)]
pub enum Frame {
    /// The frame returned, and all inputs are new. Time of the reference clock, ns.
    Received { system_time_ns: u64 },
    /// The frame did not return, or a drive did not answer. The inputs are those of an earlier cycle.
    Lost,
}

/// Reason for the stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// Too many frames lost in a row.
    Frames,
    /// The drive with this index reports a fault.
    Drive(usize),
    /// The step refused a command.
    Command(Fault),
}

/// Result of a cycle.
#[derive(Debug)]
pub struct Report {
    /// Whether all drives follow their targets.
    pub running: bool,
    /// Reason for the quick stop, latched until [`Cycle::reset`].
    pub stop: Option<Stop>,
    /// The step's report: correction, status, fault.
    pub output: Output<f64, f64, AXES>,
}

enum Step<'a> {
    Corrected(&'a HostServo<'a, AXES>, Box<State<f64, f64, AXES>>),
    Bypass(Bypass<f64, AXES>),
}

/// State passed from one cycle to the next.
pub struct Cycle<'a> {
    step: Step<'a>,
    counts_per_mm: f64,
    time_ns: Option<u64>,
    lost: u32,
    counters: [WrappingCounter; AXES],
    /// Positions in counts, extended beyond the drives' 32 bits.
    position: [i64; AXES],
    target: [i64; AXES],
    running: bool,
    stop: Option<Stop>,
    reset: bool,
}

/// Reads the bytes of a `.tcomp` file and checks them. The error is one line with the reason for the refusal.
pub fn tables(file: &[u8]) -> Result<Tcomp<'_>, String> {
    Tcomp::parse(file).map_err(|error| format!("trueaxis: {error}; running uncompensated"))
}

impl<'a> Cycle<'a> {
    /// Creates a cycle that corrects with these tables.
    pub fn new(servo: &'a HostServo<'a, AXES>, counts_per_mm: f64) -> Self {
        Self::of(Step::Corrected(servo, Box::new(servo.start())), counts_per_mm)
    }

    /// Creates a cycle that passes commands unchanged and reports the reason in every record.
    pub fn uncompensated(reason: Fault, counts_per_mm: f64) -> Self {
        Self::of(Step::Bypass(Bypass::new(reason)), counts_per_mm)
    }

    fn of(step: Step<'a>, counts_per_mm: f64) -> Self {
        Cycle {
            step,
            counts_per_mm,
            time_ns: None,
            lost: 0,
            counters: [WrappingCounter::BITS_32; AXES],
            position: [0; AXES],
            target: [0; AXES],
            running: false,
            stop: None,
            reset: false,
        }
    }

    /// Releases a stop in the next cycle. The command must then be at the machine's position.
    pub fn reset(&mut self) {
        self.stop = None;
        self.reset = true;
    }

    /// Positions of the drives, mm. Commands must start from them.
    pub fn position(&self) -> [f64; AXES] {
        self.position.map(|counts| counts as f64 / self.counts_per_mm)
    }

    /// Runs one cycle. `command` is in mm; inputs and outputs of each drive are laid out as in [`IMAGE_BYTES`].
    ///
    /// Until all drives follow, it ignores the command and sends each drive its own position as the target.
    pub fn run(
        &mut self,
        frame: Frame,
        inputs: &[[u8; IMAGE_BYTES]; AXES],
        command: [f64; AXES],
        outputs: &mut [[u8; IMAGE_BYTES]; AXES],
    ) -> Report {
        let elapsed_ns = self.elapsed(frame);
        let status: [u16; AXES] = inputs.map(|[low, high, ..]| u16::from_le_bytes([low, high]));
        let mut alarm = if self.lost > 0 { 0b111 } else { 0 };
        if self.lost == 0 {
            for (drive, [_, _, a, b, c, d]) in inputs.iter().enumerate() {
                match self.counters[drive].follow(u32::from_le_bytes([*a, *b, *c, *d])) {
                    Some(position) => self.position[drive] = position,
                    None => alarm |= 1 << drive,
                }
            }
            self.running = status.iter().all(|status| status & 0x6f == 0x27);
            if let Some(drive) = status.iter().position(|status| status & 0x4f == 0x08 || status & 0x4f == 0x0f) {
                self.stop = self.stop.or(Some(Stop::Drive(drive)));
            }
        } else if self.lost >= LOST_MAX {
            self.stop = self.stop.or(Some(Stop::Frames));
        }

        let follow = self.running && self.stop.is_none();
        let feedback = self.position();
        let mut input = trueaxis::Input::at_rest(PERIOD_NS);
        input.command = if follow { command } else { feedback };
        input.feedback = feedback;
        input.encoder_alarm = alarm;
        input.elapsed_ns = elapsed_ns;
        input.homed = true; // absolute encoders
        input.enable = follow;
        input.reset = core::mem::take(&mut self.reset);
        let output = match &mut self.step {
            Step::Corrected(servo, state) => servo.step(state, &input, (), ()),
            Step::Bypass(bypass) => bypass.step(&input),
        };
        if follow && output.stop_requested() {
            self.stop = Some(Stop::Command(output.record.fault));
        }

        if follow && self.stop.is_none() && output.has_drive() {
            self.target = output.drive.map(|mm| (mm * self.counts_per_mm).round() as i64);
        } else if self.lost == 0 {
            self.target = self.position;
        }
        for ((image, target), status) in outputs.iter_mut().zip(self.target).zip(status) {
            let control = if self.stop.is_some() { QUICK_STOP } else { towards_operation(status) };
            image[..2].copy_from_slice(&control.to_le_bytes());
            // The target wraps at 32 bits, like the drive's position.
            image[2..].copy_from_slice(&(target as i32).to_le_bytes());
        }
        Report { running: follow, stop: self.stop, output }
    }

    /// Time since the last cycle by the reference clock, or the nominal period if the frame was lost. A clock that was
    /// set back, or ahead by more than 4.29 s, makes the cycle late.
    fn elapsed(&mut self, frame: Frame) -> u32 {
        let Frame::Received { system_time_ns } = frame else {
            self.lost += 1;
            return PERIOD_NS;
        };
        // Subtract the time of the lost frames, which does not belong to this cycle.
        let missed = u64::from(self.lost) * u64::from(PERIOD_NS);
        let before = self.time_ns.replace(system_time_ns);
        self.lost = 0;
        let Some(before) = before else { return PERIOD_NS };
        let elapsed = system_time_ns.checked_sub(before).map(|elapsed| elapsed.saturating_sub(missed));
        elapsed.and_then(|elapsed| u32::try_from(elapsed).ok()).unwrap_or(u32::MAX)
    }
}

/// The control word that brings a drive one state closer to operation (CiA 402).
fn towards_operation(status: u16) -> u16 {
    match status & 0x6f {
        0x21 => 0x0007,        // ready: switch on
        0x23 | 0x27 => 0x000f, // switched on: enable; and stay so
        _ => 0x0006,           // shut down: to ready
    }
}
