//! Second stage: the work on a whole revolution, some slices per cycle.

use super::plan::{Plan, Task};
use super::transform::{forward_slice, inverse_slice, quarter, slices, slices_of_twos, twos_slice};
use super::work::{ARM_CHECKS, POINTS_PER_SLICE, Work};
use super::{Gauge, GaugeState};
use crate::real::Real;

/// One row per task: its pattern, a name, its number of slices, the most times it occurs in a revolution under a plan,
/// and its slice at an index. Slices count down.
///
/// Every task becomes a separate function, so that the code prepares nothing before the task is known. A table of
/// functions would do the same by an indirect call, which the stack-bound analysis could not follow.
macro_rules! tasks {
    (|$gauge:ident, $plan:ident, $state:ident, $at:ident|
     $($task:ident => $name:ident, $slices:expr, $times:expr, $slice:expr;)*) => {
        impl<R: Real, const N: usize> Gauge<R, N> {
            /// Computes one slice; returns true when a revolution has just been evaluated.
            #[inline(always)]
            fn slice(&self, state: &mut GaugeState<R, N>) -> bool {
                let Some(at) = state.work.left.checked_sub(1) else {
                    return !state.work.is_idle() && self.finish(state);
                };
                state.work.left = at;
                match state.work.task {
                    Task::Idle => {}
                    $(Task::$task => self.$name(state, at),)*
                }
                false
            }

            $(#[inline(never)]
            fn $name(&self, $state: &mut GaugeState<R, N>, $at: usize) {
                let ($gauge, $plan) = (self, &self.plan);
                // Most tasks need only some of these.
                let _ = ($gauge, $plan, $at);
                $slice
            })*
        }

        impl<R: Real, const N: usize> Plan<R, N> {
            /// Slices of a task.
            pub(super) fn slices_of(task: Task) -> usize {
                match task {
                    Task::Idle => 0,
                    $(Task::$task => $slices,)*
                }
            }

            /// Most slices that one revolution takes, including one for each change of task.
            pub(super) fn slices(&self) -> usize {
                let $plan = self;
                [$(($slices, $times)),*].iter().filter(|(slices, _)| *slices > 0).map(|(slices, times)| (slices + 1) * times).sum()
            }
        }
    };
}

tasks! { |gauge, plan, state, at|
    Linkage => link, N, usize::from(plan.has_arm), state.work.link(plan, at);
    Level => level, N / POINTS_PER_SLICE, 1, state.work.level(&mut state.sums[state.worked & 1], at);
    Forward0 => forward_0, slices::<N>(0), 1, forward(plan, &mut state.sums[state.worked & 1], at, 0);
    Forward1 => forward_1, slices::<N>(1), 1, forward(plan, &mut state.sums[state.worked & 1], at, 1);
    Forward2 => forward_2, slices::<N>(2), 1, forward(plan, &mut state.sums[state.worked & 1], at, 2);
    Forward3 => forward_3, slices::<N>(3), 1, forward(plan, &mut state.sums[state.worked & 1], at, 3);
    Forward4 => forward_4, slices::<N>(4), 1, forward(plan, &mut state.sums[state.worked & 1], at, 4);
    ForwardTwos => forward_twos, slices_of_twos::<N>(), 1, twos_slice(&mut state.sums[state.worked & 1], at);
    SpreadShifted => spread_shifted, N / 4, used(&plan.shifted), {
        state.work.spread(plan, &state.sums[state.worked & 1], plan.shifted.as_ref(), at)
    };
    SpreadProfile => spread_profile, N / 4, 1, {
        state.work.spread_profile(plan, &state.sums[state.worked & 1], at)
    };
    SpreadInfeed => spread_infeed, N / 4, used(&plan.infeed), {
        state.work.spread(plan, &state.sums[state.worked & 1], plan.infeed.as_ref(), at)
    };
    SpreadFiltered => spread_filtered, N / 4, used(&plan.filtered), {
        state.work.spread(plan, &state.sums[state.worked & 1], plan.filtered.as_ref(), at)
    };
    Harmonics => keep_harmonic, Work::<R, N>::AMPLITUDES, 1, state.work.keep_harmonic(plan, at);
    InverseTwos => inverse_twos, slices_of_twos::<N>(), plan.uses(), twos_slice(state.work.buffer(), at);
    Inverse4 => inverse_4, slices::<N>(4), plan.uses(), inverse(plan, state.work.buffer(), at, 4);
    Inverse3 => inverse_3, slices::<N>(3), plan.uses(), inverse(plan, state.work.buffer(), at, 3);
    Inverse2 => inverse_2, slices::<N>(2), plan.uses(), inverse(plan, state.work.buffer(), at, 2);
    Inverse1 => inverse_1, slices::<N>(1), plan.uses(), inverse(plan, state.work.buffer(), at, 1);
    Inverse0 => inverse_0, slices::<N>(0), plan.uses(), inverse(plan, state.work.buffer(), at, 0);
    Arm => compare_arm, ARM_CHECKS, usize::from(plan.has_arm), {
        let (work, revolution) = state.work_and_revolution();
        work.compare_arm(revolution, at)
    };
    Orbit => orbit, N, 1, {
        let (work, revolution) = state.work_and_revolution();
        work.orbit(plan, revolution, at)
    };
    Open => open, 1, 1, state.work.open();
    Evaluate => evaluate, N, 1, state.work.evaluate(plan, at);
    Scale => scale, 1, 1, state.work.scale();
    Express => express, N, 1, state.work.express(plan, at);
    Close => close, 1, 1, state.work.close();
    Judge => judge, N / POINTS_PER_SLICE, used(&plan.infeed), state.work.judge(gauge.infeed.as_ref(), at);
    Commit => commit, N / POINTS_PER_SLICE, used(&plan.infeed), state.work.commit(gauge.infeed.as_ref(), at);
    // For a new part: not included in the work on a revolution.
    Clear => zero, N / POINTS_PER_SLICE, 0, state.work.zero(at);
    Range => measure, N / POINTS_PER_SLICE, 1, state.work.measure(plan, at);
}

/// Computes one slice of a stage of the forward transform.
#[inline(always)]
fn forward<R: Real, const N: usize>(plan: &Plan<R, N>, sum: &mut [R; N], at: usize, stage: usize) {
    if slices::<N>(stage) > 0 {
        forward_slice(sum, &plan.circle, at, quarter::<N>(stage));
    }
}

/// Computes one slice of a stage of an inverse transform.
#[inline(always)]
fn inverse<R: Real, const N: usize>(plan: &Plan<R, N>, buffer: &mut [R; N], at: usize, stage: usize) {
    if slices::<N>(stage) > 0 {
        inverse_slice(buffer, &plan.circle, at, quarter::<N>(stage));
    }
}

/// 1 if a plan has this use of the spectrum, otherwise 0.
fn used<T>(of: &Option<T>) -> usize {
    usize::from(of.is_some())
}

impl<R: Real, const N: usize> Plan<R, N> {
    /// Number of uses of the spectrum, including the profile.
    fn uses(&self) -> usize {
        1 + used(&self.shifted) + used(&self.infeed) + used(&self.filtered)
    }
}

impl<R: Real, const N: usize> Gauge<R, N> {
    /// Second stage: computes the slices of a cycle; returns true when a revolution has just been evaluated.
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

    /// Moves from one task to the next; returns true when it was the last of a revolution.
    #[inline(never)]
    fn finish(&self, state: &mut GaugeState<R, N>) -> bool {
        let finished = state.work.finish(&self.plan, self.infeed.as_ref());
        if finished {
            state.latest = state.work.result;
            state.counts.evaluated = state.counts.evaluated.wrapping_add(1);
        }
        finished
    }
}
