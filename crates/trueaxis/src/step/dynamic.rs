//! The dynamic correction's place in a cycle: after the contour error, before the limiters of the axes.

#![deny(clippy::indexing_slicing)]

use super::{ServoLoop, State};
use crate::compensation::Direction;
use crate::contour::Flags;
use crate::dynamic::{DynamicParts, DynamicStage, DynamicState, Dynamics, Moment};
use crate::error::Fault;
use crate::output::{Applied, Outlets, OutputState};
use crate::position::Position;
use crate::real::Real;
use crate::sample::{Sample, Verdict};
use crate::telemetry::Record;

impl<R: Real, P: Position, const N: usize> ServoLoop<'_, R, P, N> {
    /// Command plus the geometric correction sent last.
    #[inline(always)]
    pub(super) fn place(&self, state: &State<R, P, N>, command: &[P; N]) -> [P; N] {
        let offsets = match self.dynamic() {
            None => state.output.offsets(),
            Some(_) => state.geometric_offsets(),
        };
        let mut place = *command;
        for (place, offset) in place.iter_mut().zip(offsets) {
            *place = place.moved(*offset);
        }
        place
    }

    /// Exchanges the geometric correction sent last.
    // Only with periods.
    pub(super) fn exchange_offsets(&self, state: &mut State<R, P, N>, offsets: &mut [P::Offset; N]) {
        let is_dynamic = self.dynamic().is_some() && state.dynamic.is_for(state.sequence);
        let own = if is_dynamic { state.dynamic.offsets_mut() } else { state.output.offsets_mut() };
        core::mem::swap(own, offsets);
    }

    /// The dynamic correction; `None` if no part of it is configured.
    #[inline(always)]
    pub(super) fn dynamic(&self) -> Option<&DynamicStage<R, P, N>> {
        self.dynamic.as_ref().inspect(|stage| stage.exists())
    }

    /// Command plus geometric correction of the last cycle: the targets of the drives without the dynamic correction.
    #[inline(always)]
    pub(super) fn targets<'s>(
        &self,
        output: &'s OutputState<R, P, N>,
        dynamic: &'s DynamicState<R, P, N>,
        cycle: u32,
    ) -> &'s [P; N] {
        match self.dynamic() {
            None => output.drive(),
            Some(_) => geometric_targets(output, dynamic, cycle),
        }
    }

    /// Factors on the identified Coulomb friction and pre-sliding of the axis in a slot (0 = X), as they are in use; `None` if
    /// the friction of that axis does not adapt.
    pub fn friction_factors(&self, state: &State<R, P, N>, slot: usize) -> Option<[R; 2]> {
        self.dynamic()?.factors(&state.dynamic, slot)
    }

    /// The fault of an axis whose friction adapts, and its slot.
    #[inline(always)]
    pub(super) fn friction_fault(&self, state: &State<R, P, N>) -> Option<(Fault, u8)> {
        self.dynamic().filter(|stage| stage.adapts()).and_then(|_| state.dynamic.friction_fault())
    }

    /// Runs the output stage with the dynamic correction added to the wanted one.
    // Only with dynamic.
    #[inline(never)]
    pub(super) fn apply_dynamic(
        &self,
        stage: &DynamicStage<R, P, N>,
        state: &mut State<R, P, N>,
        sample: &Sample<P, N>,
        geometric: &[R; N],
        error: R::Vec3,
        (drive, feedback): (&mut [P; N], &mut [P; N]),
        record: &mut Record<R, P, N>,
    ) -> Applied {
        if !state.dynamic.is_for(state.sequence) {
            state.dynamic.begin(state.output.sent(), state.output.offsets(), state.output.drive());
        }
        self.take_up(stage, state, sample);
        let mut ramping = 0;
        if !sample.first {
            ramping = stage.ramp(state.dynamic.ramped_mut(), geometric, sample);
        }
        let mut wanted = state.dynamic.ramped_mut().map(|ramped| ramped.sent());
        let usable = record.tip.flags == Flags::BRACKETED;
        let moment = Moment {
            geometric: &wanted,
            bands: &self.bands,
            error: usable.then(|| error.into()),
            limited: state.limited,
            late: sample.fault == Fault::LateCycle,
        };
        let before = state.dynamic.sent();
        let parts = record.dynamic.get_or_insert_with(DynamicParts::none);
        let limited = stage.act(&mut state.dynamic, sample, &moment, parts);
        for (wanted, sent) in wanted.iter_mut().zip(&parts.sent) {
            *wanted += *sent;
        }
        let outlets = Outlets { drive, feedback, correction: &mut record.correction };
        let mut applied = self.output.apply(&mut state.output, sample, &wanted, false, outlets);
        let held = applied.outside.is_some() || (sample.verdict.holds() && !sample.first);
        if applied.outside.is_some() {
            state.dynamic.take_back(before);
            parts.sent = before;
        } else {
            applied.limited |= limited | ramping;
        }
        state.dynamic.settle(state.output.sent(), (!held).then_some(sample.command), state.sequence);
        record.correction = *state.dynamic.geometric();
        applied.status = state.dynamic.led_out();
        applied
    }

    /// Reverses the axes that take up their lost motion from the command: at the second change in the new direction, so
    /// that a command that dithers at rest reverses none.
    // Only with dynamic.
    #[inline(always)]
    fn take_up(&self, stage: &DynamicStage<R, P, N>, state: &mut State<R, P, N>, sample: &Sample<P, N>) {
        let Some(takes_up) = stage.takes_up() else { return };
        if sample.verdict != Verdict::Active || sample.first || !sample.input.dynamics.has(Dynamics::TAKE_UP) {
            return;
        }
        let commanded = state.sample.commanded();
        let drives = *state.dynamic.drive();
        let drives = drives.iter().zip(&self.bands);
        let axes = takes_up.into_iter().zip(&mut state.reversal).zip(drives);
        let ways = sample.command.iter().zip(&commanded).zip(state.dynamic.trend_mut());
        for (((takes_up, reversal), (drive, band)), ((command, last), trend)) in axes.zip(ways) {
            let way: R = command.since_near(*last);
            let before = core::mem::replace(trend, way);
            let against = match reversal.direction() {
                Direction::POSITIVE => way < R::ZERO && before < R::ZERO,
                _ => way > R::ZERO && before > R::ZERO,
            };
            if takes_up && against {
                reversal.turn(*drive, *band);
            }
        }
    }
}

impl<R: Real, P: Position, const N: usize> State<R, P, N> {
    /// Geometric corrections sent last. Out of line, so that a loop without dynamic correction pays only a branch.
    // Only with dynamic.
    #[inline(never)]
    fn geometric_offsets(&self) -> &[P::Offset; N] {
        if self.dynamic.is_for(self.sequence) { self.dynamic.offsets() } else { self.output.offsets() }
    }
}

/// Drive positions with these corrections. After cycles of a loop without dynamic correction, everything sent is
/// geometric.
// Only with dynamic.
#[inline(never)]
fn geometric_targets<'s, R: Real, P: Position, const N: usize>(
    output: &'s OutputState<R, P, N>,
    dynamic: &'s DynamicState<R, P, N>,
    cycle: u32,
) -> &'s [P; N] {
    if dynamic.is_for(cycle) { dynamic.drive() } else { output.drive() }
}
