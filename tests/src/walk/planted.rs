//! Defects planted into outputs, to test the contract itself.

use super::rule::Rule;
use super::scalar::{Place, Scalar};
use trueaxis::telemetry::Status;
use trueaxis::{Fault, Input, Output};

/// A defect of an output, applied from some cycle wherever it fits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Planted {
    /// No defect.
    #[default]
    Nothing,
    /// A cycle is not counted.
    SequenceSkips,
    /// The CRC of the tables belongs to others.
    ForeignTables,
    /// A correction is NaN.
    NotANumber,
    /// The last bit of a drive changes while the output holds.
    HoldMoves,
    /// The last bit of a correction changes while the output holds.
    HoldRecordMoves,
    /// A drive is off by one bit.
    DriveOff,
    /// The host's feedback is off by one bit.
    FeedbackOff,
    /// Correction and drive move slightly faster than the slope, or brake slightly harder.
    TooSharp,
    /// A correction is far above the magnitude.
    TooLarge,
    /// A latched stop is dropped.
    StopForgotten,
    /// A stop is requested without a cause.
    StopInvented,
    /// The fault's axis is the next one.
    WrongAxis,
    /// A bad reading is not reported.
    FreezeForgotten,
    /// A bad reading is reported as accepted.
    ReadingAccepted,
    /// The contour error is reported without being measured.
    ErrorInvented,
    /// The command in force is a different one.
    CommandChanged,
    /// The bits of limited axes are missing while switched off.
    LimitedForgotten,
}

impl Planted {
    /// All defects, each with the rules of which one must find it.
    pub const ALL: &'static [(Planted, &'static [Rule])] = &[
        (Planted::SequenceSkips, &[Rule::Sequence]),
        (Planted::ForeignTables, &[Rule::Identity]),
        (Planted::NotANumber, &[Rule::Finite]),
        (Planted::HoldMoves, &[Rule::Hold]),
        (Planted::HoldRecordMoves, &[Rule::Hold]),
        (Planted::DriveOff, &[Rule::DriveIsSum]),
        (Planted::FeedbackOff, &[Rule::FeedbackIsMeasured]),
        (Planted::TooSharp, &[Rule::Acceleration]),
        (Planted::TooLarge, &[Rule::Magnitude]),
        (Planted::StopForgotten, &[Rule::Latches]),
        (Planted::StopInvented, &[Rule::StopsOnlyWhenDue]),
        (Planted::WrongAxis, &[Rule::Stops]),
        (Planted::FreezeForgotten, &[Rule::Reading]),
        (Planted::ReadingAccepted, &[Rule::ReadingInForce]),
        (Planted::ErrorInvented, &[Rule::ContourReported]),
        (Planted::CommandChanged, &[Rule::CommandInForce]),
        (Planted::LimitedForgotten, &[Rule::LimitedReported]),
    ];

    /// Applies the defect.
    #[inline(always)]
    pub(super) fn spoil<R: Scalar, P: Place, const N: usize>(
        self,
        output: &mut Output<R, P, N>,
        input: &Input<P, N>,
        cycle: u64,
    ) {
        if self != Planted::Nothing && cycle > 100 {
            self.spoil_late(output, input, cycle);
        }
    }

    #[inline(never)]
    fn spoil_late<R: Scalar, P: Place, const N: usize>(
        self,
        output: &mut Output<R, P, N>,
        input: &Input<P, N>,
        cycle: u64,
    ) {
        let held = output.stop_requested();
        let record = &mut output.record;
        let active = record.status.has(Status::ACTIVE);
        // The smallest change that the type can express.
        let bit = |place: P| P::of(place.to_f64() * (1.0 + f64::EPSILON)).plus(R::of(P::GRAIN));
        let size = record.correction[0].to_f64();
        match self {
            Planted::SequenceSkips => record.sequence = record.sequence.wrapping_add(u32::from(cycle == 300)),
            Planted::ForeignTables => record.tables_crc ^= u32::from(active) << 7,
            Planted::NotANumber if active => record.correction[1] = R::of(f64::NAN),
            Planted::HoldMoves if held => output.drive[0] = bit(output.drive[0]),
            Planted::HoldRecordMoves if held => record.correction[0] = R::of(size + 1e-6 * (1.0 + size.abs())),
            Planted::DriveOff if active => output.drive[0] = bit(output.drive[0]),
            Planted::FeedbackOff if active => output.feedback[0] = bit(output.feedback[0]),
            Planted::TooSharp if active && cycle.is_multiple_of(50) => {
                record.correction[0] = R::of(size + 0.5 * (size.abs() + 1e-4));
                output.drive[0] = input.command[0].moved(P::offset(record.correction[0]));
            }
            Planted::TooLarge if active => {
                record.correction[0] = R::of(20.0);
                output.drive[0] = input.command[0].moved(P::offset(record.correction[0]));
            }
            Planted::StopForgotten if held && cycle.is_multiple_of(5) => record.status = Status::ACTIVE,
            Planted::StopInvented if active => {
                (record.status, record.fault) = (Status::STOP_REQUEST, Fault::CommandJump);
            }
            Planted::WrongAxis if held => record.fault_axis = (record.fault_axis + 1) % N as u8,
            Planted::FreezeForgotten if record.status.has(Status::FROZEN) => {
                (record.status, record.fault) = (Status::ACTIVE, Fault::None);
            }
            Planted::ReadingAccepted if record.status.has(Status::FROZEN) => {
                if let Some(k) = (0..N).find(|k| input.feedback[*k].is_usable()) {
                    record.feedback[k] = bit(record.feedback[k]);
                }
            }
            Planted::ErrorInvented if held => record.status.0 |= Status::CONTOUR.0,
            Planted::CommandChanged if active => record.command[2] = bit(record.command[2]),
            Planted::LimitedForgotten if !active && !held && !record.status.has(Status::FROZEN) => record.limited ^= 1,
            _ => {}
        }
    }
}
