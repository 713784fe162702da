//! First stage: turns command and encoder readings into finite, plausible positions, or reports a fault.

#![deny(clippy::indexing_slicing)]

mod encoder;
mod ratio;
mod sampler;

pub use encoder::{EncoderScale, WrappingCounter};
pub use sampler::{READING_MARGIN, STILL_STEPS};
pub(crate) use sampler::{SampleState, Sampler};

use crate::dynamic::Dynamics;
use crate::error::Fault;
use crate::position::Position;
use crate::telemetry::Status;

/// Input of a servo cycle.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Input<P, const N: usize> {
    /// Commanded positions, uncorrected, mm (rotary: degrees).
    pub command: [P; N],
    /// Raw encoder positions, mm (degrees). A reading that is NaN, beyond 1e9 or, in integers, at an end of their range
    /// is a dropout.
    pub feedback: [P; N],
    /// One bit for every axis whose encoder interface reports an alarm.
    pub encoder_alarm: u8,
    /// Time since the last cycle in nanoseconds, as the host measured or knows it.
    ///
    /// [`Fault::LateCycle`], correction frozen, if it is more than a quarter off the period or if the corrections must
    /// pause. They pause if too little time has passed since they last moved; with e this time, T 0.999 of the period
    /// and t the accumulated time,
    ///
    /// ```text
    /// t <- min(t + e, 2 T − 1 ns)      t >= T: they move by a cycle's worth, t <- t − T;  else they do not move
    /// ```
    ///
    /// so that over any time they move by at most what their slope allows in it plus one cycle's worth. Afterwards they
    /// continue at the velocity they had. 0: no time has passed and nothing moves. The value in the first cycle is
    /// ignored.
    pub elapsed_ns: u32,
    /// Whether all axes are homed, so that positions are machine positions.
    pub homed: bool,
    /// Whether the host wants compensation.
    pub enable: bool,
    /// Releases a latched stop request (on its rising edge, near the held position).
    pub reset: bool,
    /// Why a stage before the step ([`crate::ServoLoop::rtcp`]) has no command for this cycle: the output then holds,
    /// whatever `command` contains. Otherwise `Refusal::NONE`.
    #[doc(hidden)]
    pub refusal: Refusal,
    /// Parts of the dynamic correction that the host wants; parts that are not configured stay off.
    pub dynamics: Dynamics,
    /// Learned correction of X, Y and Z at this point of the program, mm, as a position counted from 0. An unusable
    /// position counts as zero.
    pub learned: [P; 3],
}

/// A command rejected before the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Refusal {
    /// The reason; [`Fault::None`] if the command was not rejected.
    pub fault: Fault,
    /// Slot of the axis at fault.
    pub slot: u8,
}

impl Refusal {
    /// No command was rejected.
    pub const NONE: Refusal = Refusal { fault: Fault::None, slot: 0 };
}

impl<P: Position, const N: usize> Input<P, N> {
    /// All axes at zero, neither homed nor enabled, the cycle on time: defaults for the other fields.
    pub fn at_rest(period_ns: u32) -> Self {
        Input {
            command: [P::default(); N],
            feedback: [P::default(); N],
            encoder_alarm: 0,
            elapsed_ns: period_ns,
            homed: false,
            enable: false,
            reset: false,
            refusal: Refusal::NONE,
            dynamics: Dynamics::ALL,
            learned: [P::default(); 3],
        }
    }
}

/// How the step treats a cycle, decided from its sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Verdict {
    /// Not homed or not enabled: the correction returns to zero.
    Inactive = 0,
    /// Homed, enabled, plausible.
    Active = Status::ACTIVE.0,
    /// The correction freezes; the command passes.
    Freeze = Status::FROZEN.0,
    /// The output holds.
    Hold = Status::STOP_REQUEST.0,
    /// The output would hold, but no command was ever usable and some axis has not been read yet: the step gives no
    /// output.
    NoOutput = Status::STOP_REQUEST.0 | Status::NO_OUTPUT.0,
}

impl Verdict {
    /// The corresponding bits of the status.
    #[inline(always)]
    pub(crate) fn status(self) -> Status {
        Status(self as u8)
    }

    /// Whether the drives receive nothing new.
    #[inline(always)]
    pub(crate) fn holds(self) -> bool {
        matches!(self, Verdict::Hold | Verdict::NoOutput)
    }
}

/// Positions that the rest of the step trusts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample<'s, P, const N: usize> {
    pub(crate) command: &'s [P; N],
    pub(crate) feedback: &'s [P; N],
    pub(crate) verdict: Verdict,
    pub(crate) fault: Fault,
    /// Slot of the axis at fault.
    pub(crate) axis: u8,
    /// Whether the corrections may move in this cycle: a period has passed since they last moved
    /// ([`Input::elapsed_ns`]).
    pub(crate) due: bool,
    /// Whether no earlier command was accepted.
    pub(crate) first: bool,
    /// Whether the positions are machine positions.
    pub(crate) homed: bool,
    /// The unmodified input, for fields that only one stage reads.
    pub(crate) input: &'s Input<P, N>,
}

impl<'s, P, const N: usize> Sample<'s, P, N> {
    /// The sample of a cycle that passed every check.
    #[inline(always)]
    pub(crate) fn calm(input: &'s Input<P, N>) -> Self {
        Sample {
            command: &input.command,
            feedback: &input.feedback,
            verdict: Verdict::Active,
            fault: Fault::None,
            axis: 0,
            due: true,
            first: false,
            homed: true,
            input,
        }
    }
}

#[cfg(test)]
mod tests;
