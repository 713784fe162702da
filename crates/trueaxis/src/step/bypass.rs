//! Replacement for the step after its tables were refused.

#![deny(clippy::indexing_slicing)]

use super::Output;
use crate::error::Fault;
use crate::position::Position;
use crate::real::Real;
use crate::sample::Input;
use crate::telemetry::{Record, Status};

/// Passes every command unchanged, and states in every record why it is not corrected.
///
/// For a controller that continues without its tables: damaged, of another machine, too large
/// ([`Fault::TablesRefused`], [`Fault::CapacityTooSmall`], [`Fault::AbiMismatch`], [`Fault::PeriodMismatch`]). It does
/// not pass an unusable command: it holds the last one and requests a stop. Unlike the step's, this request is not
/// latched: it ends with the next usable command. Before the first usable command it holds the position of the machine;
/// until every axis has been read it has no such position, and gives no output ([`Output::has_drive`]).
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
    /// One bit for every axis whose position to hold is known.
    known: u8,
    held: [P; N],
    /// Last usable reading of every axis that has been read; the held position of the others.
    feedback: [P; N],
    read: [bool; N],
}

impl<P: Position, const N: usize> Bypass<P, N> {
    /// Creates a bypass with the reason that goes into every record.
    pub fn new(reason: Fault) -> Self {
        let zero = [P::default(); N];
        Bypass { reason, sequence: 0, known: 0, held: zero, feedback: zero, read: [false; N] }
    }

    /// The reason.
    pub fn reason(&self) -> Fault {
        self.reason
    }

    /// Runs one servo cycle: `drive = command`, `feedback` is the last usable reading, nothing is measured.
    #[inline]
    pub fn step<R: Real>(&mut self, input: &Input<P, N>) -> Output<R, P, N> {
        let usable = input.command.iter().all(|command| command.is_usable());
        let whole = u8::MAX >> 8usize.saturating_sub(N).min(7);
        if usable {
            (self.held, self.known) = (input.command, whole);
        } else if self.known != whole {
            self.hold_position(input);
        }
        let readings = self.feedback.iter_mut().zip(&mut self.read).zip(self.held.iter().zip(&input.feedback));
        for ((feedback, read), (held, reading)) in readings {
            if reading.is_usable() {
                (*feedback, *read) = (*reading, true);
            } else if !*read {
                *feedback = *held;
            }
        }
        let record = Record {
            sequence: self.sequence,
            fault: self.reason,
            status: Status::default().with(Status::STOP_REQUEST, !usable).with(Status::NO_OUTPUT, self.known != whole),
            command: self.held,
            feedback: self.feedback,
            ..Record::none()
        };
        self.sequence = self.sequence.wrapping_add(1);
        Output { drive: self.held, feedback: self.feedback, record }
    }

    /// Before the first command: holds the position of the machine once every axis has been read.
    #[cold]
    fn hold_position(&mut self, input: &Input<P, N>) {
        let mut bit = 1u8;
        for (held, reading) in self.held.iter_mut().zip(&input.feedback) {
            if reading.is_usable() && input.encoder_alarm & bit == 0 {
                *held = *reading;
                self.known |= bit;
            }
            bit = bit.wrapping_shl(1);
        }
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
        let at = |x: f64| Input { command: [x, 0.0, 0.0], feedback: [7.0, 1.0, 2.0], ..Input::at_rest(1000) };
        assert_eq!(bypass.step::<f64>(&at(f64::NAN)).drive, [7.0, 1.0, 2.0]);
        assert_eq!(bypass.step::<f64>(&at(3.0)).drive, [3.0, 0.0, 0.0]);
        let held = bypass.step::<f64>(&at(f64::INFINITY));
        assert_eq!(held.drive, [3.0, 0.0, 0.0]);
        assert!(held.stop_requested());
        assert!(!bypass.step::<f64>(&at(4.0)).stop_requested());
        // The number of cycles wraps; the held positions stay.
        bypass.sequence = u32::MAX;
        bypass.step::<f64>(&at(5.0));
        let held = bypass.step::<f64>(&at(f64::NAN));
        assert_eq!((held.record.sequence, held.drive), (0, [5.0, 0.0, 0.0]));
    }

    #[test]
    fn nothing_goes_out_before_a_command_or_every_reading_is_known() {
        let mut bypass = Bypass::<f64, 3>::new(Fault::TablesRefused);
        let at =
            |feedback, encoder_alarm| Input { command: [f64::NAN; 3], feedback, encoder_alarm, ..Input::at_rest(1000) };
        for feedback in [[f64::NAN; 3], [5.0, f64::INFINITY, 1e10]] {
            let out = bypass.step::<f64>(&at(feedback, 0));
            assert!(!out.has_drive() && out.stop_requested());
            assert!(out.record.feedback.iter().chain(&out.feedback).all(|x| x.is_finite()));
        }
        assert!(!bypass.step::<f64>(&at([6.0, 7.0, 8.0], 0b100)).has_drive());
        // X can no longer be read, so its last reading counts.
        let out = bypass.step::<f64>(&at([f64::NAN, 7.5, 8.0], 0));
        assert!(out.has_drive() && out.stop_requested());
        assert_eq!((out.drive, out.record.command), ([6.0, 7.5, 8.0], [6.0, 7.5, 8.0]));
        assert_eq!(bypass.step::<f64>(&at([9.0; 3], 0)).drive, [6.0, 7.5, 8.0]);
        // A usable command needs no reading.
        let mut bypass = Bypass::<f64, 3>::new(Fault::TablesRefused);
        let out = bypass.step::<f64>(&Input { command: [1.0, 2.0, 3.0], ..at([f64::NAN; 3], 0) });
        assert!(out.has_drive() && !out.stop_requested());
        assert_eq!((out.drive, out.feedback), ([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]));
    }
}
