//! What runs in place of the step when its tables were refused.

#![deny(clippy::indexing_slicing)]

use super::Output;
use crate::contour::{ContourError, Flags};
use crate::error::Fault;
use crate::position::Position;
use crate::real::Real;
use crate::sample::Input;
use crate::telemetry::{Record, Status};

/// Passes every command as it comes, and says in every record why it is not corrected.
///
/// For a controller that goes on without its tables: damaged, of another machine, too large
/// ([`Fault::TablesRefused`], [`Fault::CapacityTooSmall`], [`Fault::AbiMismatch`], [`Fault::PeriodMismatch`]). A command
/// that is no usable number is not passed: the last one holds, and a stop is requested. Unlike the step's, this request
/// is not latched: it ends with the next usable command.
///
/// ```
/// use trueaxis::{Bypass, Fault, Input};
/// let mut bypass = Bypass::<f64, 3>::new(Fault::TablesRefused);
/// let input = Input { command: [10.0, 20.0, 30.0], ..Input::at_rest(1_000_000) };
/// let output = bypass.step::<f64>(&input);
/// assert_eq!(output.drive, input.command);
/// assert_eq!(output.record.fault, Fault::TablesRefused);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Bypass<P, const N: usize> {
    reason: Fault,
    sequence: u32,
    /// A command was passed or held; until then there is nothing to hold.
    started: bool,
    held: [P; N],
}

impl<P: Position, const N: usize> Bypass<P, N> {
    /// With the reason that goes into every record.
    pub fn new(reason: Fault) -> Self {
        Bypass { reason, sequence: 0, started: false, held: [P::default(); N] }
    }

    /// The reason.
    pub fn reason(&self) -> Fault {
        self.reason
    }

    /// One servo cycle: `drive = command`, `feedback` as read, nothing measured.
    #[inline]
    pub fn step<R: Real>(&mut self, input: &Input<P, N>) -> Output<R, P, N> {
        let usable = input.command.iter().all(|command| command.is_usable());
        if usable {
            self.held = input.command;
        } else if !self.started {
            // Nothing was ever commanded: stay where the machine stands.
            for (held, reading) in self.held.iter_mut().zip(&input.feedback) {
                *held = if reading.is_usable() { *reading } else { P::default() };
            }
        }
        let record = Record {
            sequence: self.sequence,
            machine_id: 0,
            tables_crc: 0,
            fault: self.reason,
            fault_axis: 0,
            status: Status::default().with(Status::STOP_REQUEST, !usable),
            limited: 0,
            at_edge: 0,
            command: self.held,
            feedback: input.feedback,
            correction: [R::ZERO; N],
            tip: ContourError::none(),
            encoder: ContourError::none(),
            orientation: R::ZERO,
            orientation_flags: Flags::NOT_FOUND,
        };
        self.sequence = self.sequence.wrapping_add(1);
        self.started = true;
        Output { drive: self.held, feedback: input.feedback, record }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::telemetry::Frame;

    #[test]
    fn every_record_says_why() {
        for reason in [Fault::TablesRefused, Fault::CapacityTooSmall, Fault::AbiMismatch, Fault::PeriodMismatch] {
            let mut bypass = Bypass::<f64, 3>::new(reason);
            for cycle in 0..3 {
                let command = [f64::from(cycle), -2.0, 3.0];
                let input = Input { command, feedback: command, homed: true, enable: true, ..Input::at_rest(1000) };
                let output = bypass.step::<f64>(&input);
                assert_eq!((output.drive, output.feedback), (command, command));
                let mut bytes = [0; crate::telemetry::FRAME_BYTES];
                let frame = Frame::decode(Frame::of(&output.record).encode(&mut bytes).unwrap()).unwrap();
                assert_eq!((frame.fault, frame.sequence, frame.machine_id), (reason, cycle as u32, 0));
                assert!(reason.refuses() && !output.stop_requested());
            }
        }
    }

    #[test]
    fn a_command_that_is_no_number_is_held() {
        let mut bypass = Bypass::<f64, 3>::new(Fault::TablesRefused);
        let at = |x: f64| Input { command: [x, 0.0, 0.0], feedback: [7.0, 0.0, f64::NAN], ..Input::at_rest(1000) };
        assert_eq!(bypass.step::<f64>(&at(f64::NAN)).drive, [7.0, 0.0, 0.0]);
        assert_eq!(bypass.step::<f64>(&at(3.0)).drive, [3.0, 0.0, 0.0]);
        let held = bypass.step::<f64>(&at(f64::INFINITY));
        assert_eq!(held.drive, [3.0, 0.0, 0.0]);
        assert!(held.stop_requested());
        assert!(!bypass.step::<f64>(&at(4.0)).stop_requested());
        // The number of cycles wraps; what is held does not.
        bypass.sequence = u32::MAX;
        bypass.step::<f64>(&at(5.0));
        let held = bypass.step::<f64>(&at(f64::NAN));
        assert_eq!((held.record.sequence, held.drive), (0, [5.0, 0.0, 0.0]));
    }
}
