//! Second stage: the work on a whole revolution, some slices a cycle.

use super::work::{ARM_CHECKS, POINTS_PER_SLICE, Plan, Task, Use};
use super::{Gauge, GaugeState};
use crate::real::Real;

/// A row for every task: its pattern, a name, the slices that it takes at most in a revolution under a plan, and one
/// slice of it, true when that was the last.
///
/// Every task becomes a function of its own, so that nothing is prepared before it is known which one it is. A table of
/// functions would do the same by an indirect call, which the bound of the stack could not follow.
macro_rules! tasks {
    (|$gauge:ident, $plan:ident, $state:ident|
     $($task:pat => $name:ident($($of:ident)?), $slices:expr, $slice:block)*) => {
        impl<R: Real, const N: usize> Gauge<R, N> {
            /// One slice; true when a revolution has just been evaluated.
            #[inline(never)]
            fn slice(&self, state: &mut GaugeState<R, N>) -> bool {
                match state.work.task {
                    Task::Idle => false,
                    $($task => self.$name(state $(, $of)?),)*
                    Task::Switch => self.finish(state),
                }
            }

            $(#[inline(never)]
            fn $name(&self, $state: &mut GaugeState<R, N> $(, $of: Use)?) -> bool {
                let ($gauge, $plan) = (self, &self.plan);
                // Not every task needs both.
                let _ = ($gauge, $plan);
                if $slice {
                    $state.work.end();
                }
                false
            })*
        }

        impl<R: Real, const N: usize> Plan<R, N> {
            /// Slices that one revolution takes at most.
            pub(super) fn slices(&self) -> usize {
                let $plan = self;
                SWITCHES $(+ $slices)*
            }
        }
    };
}

tasks! { |gauge, plan, state|
    Task::Linkage => link(), of_arm::<R, N>(plan, N), {
        state.work.link(plan)
    }
    Task::Level => level(), N / POINTS_PER_SLICE, {
        state.work.level(&mut state.sums[state.worked & 1])
    }
    Task::Forward => forward(), pass::<N>(), {
        let (work, sum) = (&mut state.work, &mut state.sums[state.worked & 1]);
        work.forward(plan, sum)
    }
    Task::Spread(Use::Profile) => spread_profile(), N / 4, {
        let (work, sum) = (&mut state.work, &mut state.sums[state.worked & 1]);
        work.spread_profile(plan, sum)
    }
    Task::Spread(of) => spread(of), plan.other_uses() * (N / 4), {
        let (work, sum) = (&mut state.work, &mut state.sums[state.worked & 1]);
        work.spread(plan, sum, plan.multipliers(of))
    }
    Task::Inverse(of) => inverse(of), (1 + plan.other_uses()) * pass::<N>(), {
        state.work.inverse(plan, of)
    }
    Task::Arm => compare_arm(), of_arm::<R, N>(plan, ARM_CHECKS), {
        let (work, revolution) = state.work_and_revolution();
        work.compare_arm(revolution)
    }
    Task::Orbit => orbit(), N, {
        let (work, revolution) = state.work_and_revolution();
        work.orbit(plan, revolution)
    }
    Task::Evaluate => evaluate(), N, {
        state.work.evaluate(plan)
    }
    Task::Express => express(), N, {
        state.work.express(plan)
    }
    Task::Judge => judge(), of_infeed::<R, N>(plan), {
        state.work.judge(gauge.infeed.as_ref())
    }
    Task::Commit => commit(), of_infeed::<R, N>(plan), {
        state.work.commit(gauge.infeed.as_ref())
    }
    // Another part: no work on a revolution.
    Task::Clear => zero(), 0, {
        state.work.zero()
    }
    Task::Range => measure(), N / POINTS_PER_SLICE, {
        state.work.measure(plan)
    }
}

/// Switches from one task to the next, at most.
const SWITCHES: usize = 19;

/// Slices of one pass of a transform.
const fn pass<const N: usize>() -> usize {
    let half = N / 2;
    let logarithm = half.ilog2() as usize;
    half / 4 * (logarithm / 2) + half / 8 * (logarithm % 2)
}

fn of_arm<R, const N: usize>(plan: &Plan<R, N>, slices: usize) -> usize {
    if plan.has_arm { slices } else { 0 }
}

fn of_infeed<R, const N: usize>(plan: &Plan<R, N>) -> usize {
    if plan.infeed.is_some() { N / POINTS_PER_SLICE } else { 0 }
}

impl<R, const N: usize> Plan<R, N> {
    /// Uses of the spectrum beside the profile.
    fn other_uses(&self) -> usize {
        [self.shifted.is_some(), self.infeed.is_some(), self.filtered.is_some()]
            .into_iter()
            .filter(|used| *used)
            .count()
    }
}

impl<R: Real, const N: usize> Gauge<R, N> {
    /// Second stage: the slices of a cycle; true when a revolution has just been evaluated.
    #[inline]
    pub fn work(&self, state: &mut GaugeState<R, N>) -> bool {
        if self.slices_per_cycle == 1 { self.slice(state) } else { self.slices(state) }
    }

    #[inline(never)]
    fn slices(&self, state: &mut GaugeState<R, N>) -> bool {
        let mut finished = false;
        for _ in 0..self.slices_per_cycle {
            finished |= self.slice(state);
        }
        finished
    }

    /// From one task to the next; true when it was the last of a revolution.
    #[inline(never)]
    fn finish(&self, state: &mut GaugeState<R, N>) -> bool {
        let finished = state.work.finish(&self.plan);
        if finished {
            state.latest = state.work.result;
            state.counts.evaluated = state.counts.evaluated.wrapping_add(1);
        }
        finished
    }
}
