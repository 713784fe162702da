//! Adaptation of the friction figures: takes the windows after reversals, moves the factors, and finds what is no slow change.
//!
//! Two findings are faults, not changes to follow: a friction whose sign is reversed at three reversals in a row (wrong
//! sign of a reading, of a drive figure), and an axis that sticks and slips, at least three times in each of two windows in a
//! row. The axis then returns to its identified figures and stays there until a reset.

#![deny(clippy::indexing_slicing)]

use super::adapt::Factors;
use super::adapted::Adapted;
use super::feed_forward::{Drift, FeedForward};
use super::spike::{Left, Motion, Probe, SATURATED, Seen, Spike};
use super::state::DynamicState;
use crate::error::Fault;
use crate::position::Position;
use crate::real::Real;
use crate::sample::Sample;

/// Reversals in a row with the sign of friction reversed.
const REVERSED: u8 = 3;
/// Share of the friction in use by which it has to be reversed.
const BEYOND: f64 = 0.25;
/// Windows in a row with stick-slip.
const STUCK: u8 = 2;

/// Immutable half: the axes that adapt.
#[derive(Clone, Copy, Debug)]
pub(super) struct Adaptation<R, const N: usize> {
    pub(super) probes: [Option<Probe<R>>; N],
}

impl<R: Real, const N: usize> Adaptation<R, N> {
    /// Takes a cycle; `follows`: in which the readings show what was sent. `laws`: those of the axes.
    #[inline(never)]
    pub(super) fn cycle<P: Position>(
        &self,
        laws: [&FeedForward<R>; N],
        state: &mut DynamicState<R, P, N>,
        sample: &Sample<P, N>,
        changes: &[R; N],
        follows: bool,
    ) {
        if sample.input.reset {
            state.adapted.clear();
        }
        if !follows || state.adapted.frozen || state.adapted.fault != Fault::None {
            state.adapted.spike.end();
            return;
        }
        let slot = usize::from(state.adapted.spike.slot);
        let probe = self.probes.get(slot).and_then(Option::as_ref);
        if !state.adapted.spike.is_taken() && self.begins(&laws, state, sample, changes) {
            return;
        }
        if let (false, Some(probe), Some(law)) = (state.adapted.spike.is_free(), probe, laws.get(slot)) {
            advance(probe, law, state, sample, changes);
        }
    }

    /// Begins a window if an axis reverses, the axis behind the last one first.
    #[inline(always)]
    fn begins<P: Position>(
        &self,
        laws: &[&FeedForward<R>; N],
        state: &mut DynamicState<R, P, N>,
        sample: &Sample<P, N>,
        changes: &[R; N],
    ) -> bool {
        let (mut first, mut behind) = (None, None);
        let axes = self.probes.iter().zip(laws).zip(state.drift.iter().zip(changes));
        for (slot, ((probe, law), (drift, change))) in axes.enumerate() {
            if probe.is_some() && reverses(law, drift, *change) {
                first = first.or(Some(slot));
                let is_behind = slot > usize::from(state.adapted.spike.slot);
                behind = behind.or(is_behind.then_some(slot));
            }
        }
        let Some(slot) = behind.or(first) else { return false };
        let (Some(Some(probe)), Some(law)) = (self.probes.get(slot), laws.get(slot)) else { return false };
        let (Some(drift), Some(motion)) = (state.drift.get(slot), motion(state, sample, changes, slot)) else {
            return false;
        };
        state.adapted.spike = Spike::at_reversal(slot as u8, probe, law, drift, &motion);
        true
    }
}

/// Moves the window in progress by a cycle.
#[inline(never)]
fn advance<R: Real, P: Position, const N: usize>(
    probe: &Probe<R>,
    law: &FeedForward<R>,
    state: &mut DynamicState<R, P, N>,
    sample: &Sample<P, N>,
    changes: &[R; N],
) {
    let slot = usize::from(state.adapted.spike.slot);
    let Some(motion) = motion(state, sample, changes, slot) else { return };
    let Adapted { spike, reversed, stuck, fault, slot: at, .. } = &mut state.adapted;
    let (Some(drift), Some(reversed), Some(stuck)) =
        (state.drift.get_mut(slot), reversed.get_mut(slot), stuck.get_mut(slot))
    else {
        return;
    };
    let seen = spike.advance(probe, law, drift, &motion);
    match seen {
        Seen::Nothing => return,
        Seen::Lost => return spike.end(),
        Seen::Spike(left) => {
            let is_reversed = left.is_clear && left.level < R::of(-1.0 - BEYOND);
            *reversed = if is_reversed { reversed.saturating_add(1) } else { 0 };
            if !is_reversed {
                follow(law, drift, &left, motion.way);
            }
        }
        Seen::Ended(sticks) => {
            *stuck = if sticks { stuck.saturating_add(1) } else { 0 };
            spike.end();
        }
    }
    *fault = match (*reversed, *stuck) {
        (REVERSED.., _) => Fault::FrictionReversed,
        (_, STUCK..) => Fault::StickSlip,
        _ => return,
    };
    *at = spike.slot;
    drift.factors = Factors::default();
    spike.end();
}

/// Whether an axis has just reversed, with friction saturated until then.
#[inline(always)]
fn reverses<R: Real>(law: &FeedForward<R>, drift: &Drift<R>, change: R) -> bool {
    let way = drift.velocity();
    let before = way - change;
    way * before <= R::ZERO && way != R::ZERO && {
        let travel = law.travel(drift, law.ahead(way, change));
        let friction = drift.friction() * (R::ONE + travel.abs()) - travel;
        friction * way < R::ZERO && friction.abs() >= R::of(SATURATED)
    }
}

/// Moves the factors of an axis by what a spike shows.
fn follow<R: Real>(law: &FeedForward<R>, drift: &mut Drift<R>, left: &Left<R>, way: R) {
    let Some(intervals) = law.intervals() else { return };
    let (level, rate) = (intervals.level.used(&drift.factors.level), intervals.rate.used(&drift.factors.rate));
    let before = law.sliding(drift, way);
    if left.is_clear {
        intervals.level.follow(&mut drift.factors.level, left.level * level);
    }
    intervals.rate.follow(&mut drift.factors.rate, -left.presliding * rate);
    // The drive already supplies the force: only the model of it changes.
    let after = law.sliding(drift, way);
    drift.shift((after - before) * drift.friction(), intervals.level.used(&drift.factors.level) / level);
}

/// Motion of an axis.
#[inline(always)]
fn motion<R: Real, P: Position, const N: usize>(
    state: &DynamicState<R, P, N>,
    sample: &Sample<P, N>,
    changes: &[R; N],
    slot: usize,
) -> Option<Motion<R, P>> {
    Some(Motion {
        drive: *state.drive().get(slot)?,
        dynamic: state.limited.get(slot)?.sent(),
        reading: *sample.feedback.get(slot)?,
        way: state.drift.get(slot)?.velocity(),
        change: *changes.get(slot)?,
    })
}
