//! Last stage: from the wanted correction to drive commands and to the feedback that the host sees.

#![deny(clippy::indexing_slicing)]

use crate::error::ConfigError;
use crate::limiter::{Limiter, LimiterState};
use crate::machine::{AxisOrder, Limits, MachineSettings};
use crate::position::Position;
use crate::real::Real;
use crate::sample::{Sample, Verdict};

/// Limiters and joint ranges: immutable.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OutputStage<R, P, const N: usize> {
    limiters: [Limiter<R>; N],
    joint: [[P; 2]; N],
}

/// Positions and corrections sent last.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OutputState<R, P, const N: usize> {
    limited: [LimiterState<R>; N],
    drive: [P; N],
}

impl<R: Real, P: Position, const N: usize> OutputState<R, P, N> {
    pub(crate) fn new() -> Self {
        OutputState { limited: [LimiterState::default(); N], drive: [P::default(); N] }
    }

    /// Nothing of this cycle is sent: drives and corrections stay what they were `before` it.
    #[cold]
    fn take_back(&mut self, feedback: [P; N], before: [R; N], outside: u8) -> Applied<R, P, N> {
        self.limited = before.map(LimiterState::at_rest);
        Applied { drive: self.drive, feedback, correction: before, limited: 0, outside: Some(outside) }
    }

    /// The drive positions sent last.
    pub(crate) fn drive(&self) -> &[P; N] {
        &self.drive
    }

    /// The corrections sent last, as positions add them.
    #[inline(always)]
    pub(crate) fn offsets(&self) -> [P::Offset; N] {
        self.limited.map(|limited| P::offset(limited.sent()))
    }

    /// Drive positions for a command with the corrections sent last.
    pub(crate) fn drive_at(&self, command: &[P; N]) -> [P; N] {
        let mut drive = *command;
        for (drive, limited) in drive.iter_mut().zip(&self.limited) {
            *drive = plus(*drive, limited.sent());
        }
        drive
    }
}

/// Output of a cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Applied<R, P, const N: usize> {
    pub(crate) drive: [P; N],
    pub(crate) feedback: [P; N],
    pub(crate) correction: [R; N],
    /// A bit for every axis whose correction differs from the wanted one.
    pub(crate) limited: u8,
    /// Slot of an axis that would leave its joint's range: the output holds, and the command was not accepted.
    pub(crate) outside: Option<u8>,
}

/// Limits of an axis that the machine does not have: it is never corrected, any positive numbers do.
const ABSENT: Limits = Limits { magnitude: 1.0, slope_per_s: 1.0, acceleration_per_s2: 1e3 };

impl<R: Real, P: Position, const N: usize> OutputStage<R, P, N> {
    pub(crate) fn new(order: &AxisOrder<N>, machine: &MachineSettings, period_s: f64) -> Result<Self, ConfigError> {
        let idle = Limiter::new(&ABSENT, 1e-3)?;
        let mut stage = OutputStage { limiters: [idle; N], joint: [[P::nearest(f64::MIN), P::nearest(f64::MAX)]; N] };
        let settings = order.settings(machine);
        for ((settings, limiter), joint) in settings.into_iter().zip(&mut stage.limiters).zip(&mut stage.joint) {
            if let Some(settings) = settings {
                *limiter = Limiter::new(&settings.limits, period_s).map_err(|error| error.on(settings.axis))?;
                *joint = settings.joint.map(P::nearest);
            }
        }
        Ok(stage)
    }

    /// Command plus limited correction, held where necessary; feedback without the correction. The output is decided
    /// before anything is remembered: where the output holds, drive and correction of the last cycle stay.
    #[inline(always)]
    pub(crate) fn apply(
        &self,
        state: &mut OutputState<R, P, N>,
        sample: &Sample<P, N>,
        wanted: &[R; N],
    ) -> Applied<R, P, N> {
        // The reading of this cycle answers the correction sent before it.
        let mut feedback = sample.feedback;
        let mut before = [R::ZERO; N];
        for ((feedback, before), limited) in feedback.iter_mut().zip(&mut before).zip(&state.limited) {
            *before = limited.sent();
            *feedback = plus(*feedback, -limited.sent());
        }

        let mut flags = 0u8;
        match sample.verdict {
            _ if sample.first => {}
            Verdict::Active => {
                let mut bit = 1u8;
                for ((limiter, limited), wanted) in self.limiters.iter().zip(&mut state.limited).zip(wanted) {
                    if limiter.follow(limited, *wanted) {
                        flags |= bit;
                    }
                    bit = bit.wrapping_shl(1);
                }
            }
            Verdict::Inactive => flags = self.withdraw(state),
            Verdict::Freeze => self.limiters.iter().zip(&mut state.limited).for_each(|(l, limited)| l.freeze(limited)),
            Verdict::Hold | Verdict::Nowhere => {
                self.limiters.iter().zip(&mut state.limited).for_each(|(l, limited)| l.hold(limited));
            }
        }

        let mut drive = sample.command;
        let mut correction = [R::ZERO; N];
        for ((drive, limited), correction) in drive.iter_mut().zip(&state.limited).zip(&mut correction) {
            *correction = limited.sent();
            *drive = plus(*drive, limited.sent());
        }
        match sample.verdict {
            _ if sample.first => {}
            Verdict::Hold | Verdict::Nowhere => drive = state.drive,
            Verdict::Active | Verdict::Freeze => {
                if let Some(slot) = self.outside(&drive) {
                    return state.take_back(feedback, before, slot);
                }
            }
            Verdict::Inactive => {}
        }
        state.drive = drive;
        Applied { drive, feedback, correction, limited: flags, outside: None }
    }

    /// The corrections go back to zero; a bit for every axis where there is one left.
    #[cold]
    #[inline(never)]
    fn withdraw(&self, state: &mut OutputState<R, P, N>) -> u8 {
        let mut flags = 0;
        for (slot, (limiter, limited)) in self.limiters.iter().zip(&mut state.limited).enumerate() {
            flags |= u8::from(limiter.follow(limited, R::ZERO)) << (slot & 7);
        }
        flags
    }

    #[inline(always)]
    fn outside(&self, drive: &[P; N]) -> Option<u8> {
        let mut place = 0u8;
        for (drive, [low, high]) in drive.iter().zip(&self.joint) {
            if *drive < *low || *drive > *high {
                return Some(place);
            }
            place = place.wrapping_add(1);
        }
        None
    }
}

/// A zero correction passes a position bit for bit, negative zero included.
#[inline(always)]
fn plus<R: Real, P: Position>(position: P, correction: R) -> P {
    if correction == R::ZERO { position } else { position.plus(correction) }
}
