//! Second stage: the work on a whole revolution, some units a cycle.

use super::work::{Task, Use};
use super::{Roundness, RoundnessState};
use crate::real::Real;

impl<R: Real, const N: usize> Roundness<R, N> {
    /// Second stage: the units of work of a cycle; true when a revolution has just been evaluated.
    #[inline]
    pub fn work(&self, state: &mut RoundnessState<R, N>) -> bool {
        if self.units_per_cycle == 1 { self.unit(state) } else { self.units(state) }
    }

    #[inline(never)]
    fn units(&self, state: &mut RoundnessState<R, N>) -> bool {
        let mut finished = false;
        for _ in 0..self.units_per_cycle {
            finished |= self.unit(state);
        }
        finished
    }

    /// One unit. Every task is a function of its own, so that nothing is prepared before it is known which one it is.
    #[inline(never)]
    fn unit(&self, state: &mut RoundnessState<R, N>) -> bool {
        match state.work.task {
            Task::Idle => false,
            Task::Forward => self.forward(state),
            Task::Spread(Use::Profile) => self.spread_profile(state),
            Task::Spread(of) => self.spread(state, of),
            Task::Inverse(of) => self.inverse(state, of),
            Task::Arm => self.compare_arm(state),
            Task::Orbit => self.orbit(state),
            Task::Evaluate => self.evaluate(state),
            Task::Express => self.express(state),
            Task::Judge => self.judge(state),
            Task::Commit => self.commit(state),
            Task::Clear => self.zero(state),
            Task::Range => self.measure(state),
            Task::Linkage => self.link(state),
            Task::Level => self.level(state),
            Task::Turn => self.finish(state),
        }
    }

    #[inline(never)]
    fn forward(&self, state: &mut RoundnessState<R, N>) -> bool {
        let (work, sum) = (&mut state.work, &mut state.sums[state.worked & 1]);
        if work.forward(&self.plan, sum) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn spread_profile(&self, state: &mut RoundnessState<R, N>) -> bool {
        let (work, sum) = (&mut state.work, &mut state.sums[state.worked & 1]);
        if work.spread_profile(&self.plan, sum) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn spread(&self, state: &mut RoundnessState<R, N>, of: Use) -> bool {
        let (work, sum) = (&mut state.work, &mut state.sums[state.worked & 1]);
        if work.spread(&self.plan, sum, self.plan.multipliers(of)) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn inverse(&self, state: &mut RoundnessState<R, N>, of: Use) -> bool {
        let work = &mut state.work;
        if work.inverse(&self.plan, of) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn compare_arm(&self, state: &mut RoundnessState<R, N>) -> bool {
        let (work, revolution) = state.work_and_revolution();
        if work.compare_arm(revolution) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn orbit(&self, state: &mut RoundnessState<R, N>) -> bool {
        let (work, revolution) = state.work_and_revolution();
        if work.orbit(&self.plan, revolution) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn evaluate(&self, state: &mut RoundnessState<R, N>) -> bool {
        let work = &mut state.work;
        if work.evaluate(&self.plan) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn express(&self, state: &mut RoundnessState<R, N>) -> bool {
        let work = &mut state.work;
        if work.express(&self.plan) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn judge(&self, state: &mut RoundnessState<R, N>) -> bool {
        let work = &mut state.work;
        if work.judge(self.infeed.as_ref()) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn commit(&self, state: &mut RoundnessState<R, N>) -> bool {
        let work = &mut state.work;
        if work.commit(self.infeed.as_ref()) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn zero(&self, state: &mut RoundnessState<R, N>) -> bool {
        let work = &mut state.work;
        if work.zero() {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn measure(&self, state: &mut RoundnessState<R, N>) -> bool {
        let work = &mut state.work;
        if work.measure(&self.plan) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn link(&self, state: &mut RoundnessState<R, N>) -> bool {
        let work = &mut state.work;
        if work.link(&self.plan) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn level(&self, state: &mut RoundnessState<R, N>) -> bool {
        if state.work.level(&mut state.sums[state.worked & 1]) {
            state.work.end();
        }
        false
    }

    /// From one task to the next; true when it was the last of a revolution.
    #[inline(never)]
    fn finish(&self, state: &mut RoundnessState<R, N>) -> bool {
        let finished = state.work.finish(&self.plan);
        if finished {
            state.latest = state.work.result;
            state.counts.evaluated = state.counts.evaluated.wrapping_add(1);
        }
        finished
    }
}
