//! Last stage: converts the wanted correction to drive commands and to the feedback that the host receives.

#![deny(clippy::indexing_slicing)]

use crate::error::ConfigError;
use crate::limiter::{Limiter, LimiterState};
use crate::machine::{AxisOrder, Limits, MachineSettings};
use crate::position::Position;
use crate::real::Real;
use crate::sample::{Sample, Verdict};
use crate::telemetry::Status;

/// Limiters and joint ranges: immutable.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OutputStage<R, P, const N: usize> {
    limiters: [Limiter<R>; N],
    joint: [[P; 2]; N],
    /// Whether a correction that no limit binds keeps every command within its travel inside the joint's range.
    roomy: bool,
}

/// Corrections and positions sent last.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OutputState<R, P: Position, const N: usize> {
    limited: [LimiterState<R>; N],
    /// The corrections as position offsets.
    offsets: [P::Offset; N],
    drive: [P; N],
    /// Whether all axes have locked on ([`LimiterState::is_locked`]).
    locked: bool,
}

impl<R: Real, P: Position, const N: usize> OutputState<R, P, N> {
    pub(crate) fn new() -> Self {
        let none = P::offset(R::ZERO);
        let limited = [LimiterState::default(); N];
        OutputState { limited, offsets: [none; N], drive: [P::default(); N], locked: true }
    }

    /// The drive positions sent last.
    pub(crate) fn drive(&self) -> &[P; N] {
        &self.drive
    }

    /// The corrections sent last, mm (deg).
    #[inline(always)]
    pub(crate) fn sent(&self) -> [R; N] {
        self.limited.map(|limited| limited.sent())
    }

    /// The corrections sent last, as position offsets.
    pub(crate) fn offsets(&self) -> &[P::Offset; N] {
        &self.offsets
    }

    pub(crate) fn offsets_mut(&mut self) -> &mut [P::Offset; N] {
        &mut self.offsets
    }
}

/// Destinations of a cycle's output.
pub(crate) struct Outlets<'o, R, P, const N: usize> {
    pub(crate) drive: &'o mut [P; N],
    pub(crate) feedback: &'o mut [P; N],
    pub(crate) correction: &'o mut [R; N],
}

/// Flags of a cycle's output.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Applied {
    /// One bit for every axis whose correction differs from the wanted one.
    pub(crate) limited: u8,
    /// Slot of an axis that would leave its joint's range: the output holds, and the command was not accepted.
    pub(crate) outside: Option<u8>,
    /// Bits to add to the status.
    pub(crate) status: Status,
}

/// Limits of an axis that the machine does not have: it is never corrected, so any positive numbers will do.
const ABSENT: Limits = Limits { magnitude: 1.0, slope_per_s: 1.0, acceleration_per_s2: 1e3 };

/// Upper bound on the rounding of positions, mm (deg).
const ROUNDING: f64 = 1e-5;

impl<R: Real, P: Position, const N: usize> OutputStage<R, P, N> {
    pub(crate) fn new(order: &AxisOrder<N>, machine: &MachineSettings, period_s: f64) -> Result<Self, ConfigError> {
        let idle = Limiter::<R>::new(&ABSENT, 1e-3)?;
        let anywhere = [f64::MIN, f64::MAX].map(P::nearest);
        let mut stage = OutputStage { limiters: [idle; N], joint: [anywhere; N], roomy: true };
        let settings = order.settings(machine);
        for ((settings, limiter), joint) in settings.into_iter().zip(&mut stage.limiters).zip(&mut stage.joint) {
            if let Some(settings) = settings {
                // The sent correction is rounded to a step: neither limit nor range may lie between two steps.
                let limits = Limits { magnitude: P::whole_steps(settings.limits.magnitude), ..settings.limits };
                *limiter = Limiter::new(&limits, period_s).map_err(|error| error.on(settings.axis))?;
                let [least, most] = settings.joint;
                *joint = [P::within_end(least, false), P::within_end(most, true)];
                // Compared as rounded positions: integers may end before the travel does.
                let ([low, high], [least, most]) =
                    (settings.travel.map(|end| P::nearest(end).to_f64()), joint.map(P::to_f64));
                let room = ROUNDING + limiter.open().to_f64();
                stage.roomy &= low - room >= least && high + room <= most;
            }
        }
        Ok(stage)
    }

    /// Sends command plus limited correction, held if necessary, and the feedback without the correction. The decision
    /// precedes every change of state: a held output keeps drive and correction of the last cycle. While a reading is
    /// refused, the correction `freezes`, or continues to the wanted one.
    #[inline(always)]
    pub(crate) fn apply(
        &self,
        state: &mut OutputState<R, P, N>,
        sample: &Sample<P, N>,
        wanted: &[R; N],
        freezes: bool,
        output: Outlets<'_, R, P, N>,
    ) -> Applied {
        // The reading of this cycle responds to the correction sent before it.
        for ((to, reading), offset) in output.feedback.iter_mut().zip(sample.feedback).zip(&state.offsets) {
            *to = reading.moved_back(*offset);
        }
        let Some(next) = self.unlimited(state, sample, wanted) else {
            return self.apply_limited(state, sample, (wanted, freezes), output.drive, output.correction);
        };
        *state = next;
        (*output.drive, *output.correction) = (next.drive, *wanted);
        Applied { limited: 0, outside: None, status: Status(0) }
    }

    /// The state that sends the wanted corrections unchanged, if no limit binds and no check fails.
    #[inline(always)]
    fn unlimited(
        &self,
        state: &OutputState<R, P, N>,
        sample: &Sample<P, N>,
        wanted: &[R; N],
    ) -> Option<OutputState<R, P, N>> {
        if sample.verdict != Verdict::Active || sample.first || !sample.due || !state.locked {
            return None;
        }
        for ((limiter, limited), wanted) in self.limiters.iter().zip(&state.limited).zip(wanted) {
            if !limiter.follows(limited, *wanted) {
                return None;
            }
        }
        let mut next = *state;
        let axes = next.limited.iter_mut().zip(&mut next.offsets).zip(&mut next.drive);
        for (((limited, offset), drive), (wanted, command)) in axes.zip(wanted.iter().zip(sample.command)) {
            *limited = limited.passed(*wanted);
            *offset = P::offset(*wanted);
            *drive = command.moved(*offset);
        }
        (self.roomy || self.outside(&next.drive).is_none()).then_some(next)
    }

    /// [`OutputStage::apply`] if a limit binds, the step corrects nothing or the output holds.
    #[inline(never)]
    fn apply_limited(
        &self,
        state: &mut OutputState<R, P, N>,
        sample: &Sample<P, N>,
        (wanted, freezes): (&[R; N], bool),
        to_drive: &mut [P; N],
        correction: &mut [R; N],
    ) -> Applied {
        let before = state.limited;
        let mut flags = 0u8;
        match sample.verdict {
            _ if sample.first => {}
            Verdict::Active => flags = self.follow(state, wanted, sample.due),
            Verdict::Freeze if !freezes => flags = self.follow(state, wanted, sample.due),
            Verdict::Inactive => flags = self.follow(state, &[R::ZERO; N], sample.due),
            Verdict::Freeze if !sample.due => {}
            Verdict::Freeze => self.limiters.iter().zip(&mut state.limited).for_each(|(l, limited)| l.freeze(limited)),
            Verdict::Hold | Verdict::NoOutput => {
                self.limiters.iter().zip(&mut state.limited).for_each(|(l, limited)| l.hold(limited));
            }
        }
        let mut outside = None;
        if sample.first || !sample.verdict.holds() {
            let mut offsets = state.offsets;
            let mut drive = *sample.command;
            for ((drive, offset), limited) in drive.iter_mut().zip(&mut offsets).zip(&state.limited) {
                *offset = P::offset(limited.sent());
                *drive = drive.moved(*offset);
            }
            if !sample.first && sample.verdict != Verdict::Inactive {
                outside = self.outside(&drive);
            }
            match outside {
                None => (state.drive, state.offsets) = (drive, offsets),
                // The stage sends nothing of this cycle: drives and corrections keep their previous values.
                Some(_) => {
                    state.limited = before.map(|limited| LimiterState::at_rest(limited.sent()));
                    flags = 0;
                }
            }
        }
        state.locked = state.limited.iter().all(LimiterState::is_locked);
        *to_drive = state.drive;
        *correction = state.limited.map(|limited| limited.sent());
        Applied { limited: flags, outside, status: Status(0) }
    }

    /// Moves the corrections towards the wanted ones if they are `due`; returns one bit for every axis with a remaining
    /// difference.
    fn follow(&self, state: &mut OutputState<R, P, N>, wanted: &[R; N], due: bool) -> u8 {
        let mut flags = 0;
        let axes = self.limiters.iter().zip(&mut state.limited).zip(wanted);
        for (slot, ((limiter, limited), wanted)) in axes.enumerate() {
            flags |= u8::from(limiter.follow_when(due, limited, *wanted)) << (slot & 7);
        }
        flags
    }

    #[inline(always)]
    fn outside(&self, drive: &[P; N]) -> Option<u8> {
        drive.iter().zip(&self.joint).position(|(drive, joint)| !drive.is_within(joint)).map(|slot| slot as u8)
    }
}
