//! First stage: a cycle's readings become points of a revolution, and the points become whole revolutions.

use super::resample::{Counted, POINTS_PER_CYCLE, QuickCheck, Resampler};
use super::state::{GaugeState, Sampling};
use super::work::{ARM_CHECKS, Beginning, Outcome};
use super::{Followed, Gauge, GaugeFlags, Probes};
use crate::real::Real;

impl<R: Real, const N: usize> Gauge<R, N> {
    /// First stage: resamples a cycle's readings and returns the events found.
    #[inline]
    pub fn sample(&self, state: &mut GaugeState<R, N>, probes: &Probes<R>, followed: Followed) -> GaugeFlags {
        if probes.new_part | probes.idle | probes.index.is_some() | (followed != Followed::Whole) {
            return self.sample_with_full_check(state, probes, followed);
        }
        match self.resampler.quick_check(&mut state.resampler, probes) {
            QuickCheck::Between => GaugeFlags::default(),
            QuickCheck::Passed { beta } => self.pass(state, &probes.readings, beta),
            QuickCheck::NeedsFullCheck => self.sample_with_full_check(state, probes, followed),
        }
    }

    /// Handles any cycle, with the full check.
    #[inline(never)]
    fn sample_with_full_check(
        &self,
        state: &mut GaugeState<R, N>,
        probes: &Probes<R>,
        followed: Followed,
    ) -> GaugeFlags {
        if probes.new_part {
            state.work.clear();
            state.sampling = Sampling::NEW;
            state.latest = Outcome::NONE;
        }
        let mut flags = GaugeFlags::default();
        let passed = self.resampler.full_check(&mut state.resampler, probes, &mut flags);
        if flags.discards() && state.sampling.running {
            state.sampling.running = false;
            state.counts.discarded = state.counts.discarded.wrapping_add(1);
        }
        if followed != Followed::Whole || probes.idle {
            state.sampling.count(followed == Followed::Limited && !probes.idle);
        }
        if let Some(Counted { beta, passed }) = passed {
            if passed {
                self.points(state, &probes.readings, beta, &mut flags);
            }
            Resampler::<R, N>::gather(&mut state.resampler, &probes.readings);
        }
        self.resampler.settle(&mut state.resampler);
        flags
    }

    /// Handles a normal cycle in which θ has passed one point or two.
    #[inline(never)]
    fn pass(&self, state: &mut GaugeState<R, N>, readings: &[R; 3], beta: i32) -> GaugeFlags {
        let alpha = state.resampler.alpha(beta);
        let index = Resampler::<R, N>::index(&state.resampler);
        let next = Resampler::<R, N>::passed(&state.resampler) == 1 && index != 0;
        let mut flags = GaugeFlags::default();
        if next && state.sampling.running && state.sampling.is_timed(alpha) {
            self.point(state, readings, index, beta);
        } else {
            self.points(state, readings, beta, &mut flags);
        }
        Resampler::<R, N>::keep(&mut state.resampler, readings);
        flags
    }

    /// Handles the points that θ has passed, including the events at each quarter turn and each whole turn.
    #[inline(never)]
    fn points(&self, state: &mut GaugeState<R, N>, readings: &[R; 3], beta: i32, flags: &mut GaugeFlags) {
        let alpha = state.resampler.alpha(beta);
        if !state.sampling.is_timed(alpha) {
            state.sampling.time(alpha, self.resampler.clock(&state.resampler));
        }
        let (last, passed) = (Resampler::<R, N>::index(&state.resampler), Resampler::<R, N>::passed(&state.resampler));
        for back in (0..passed.min(POINTS_PER_CYCLE)).rev() {
            let index = last.wrapping_sub(back) & (N - 1);
            if index == 0 {
                self.turn(state, flags);
            }
            self.point(state, readings, index, beta);
        }
    }

    /// Handles one point that θ has passed.
    #[inline(always)]
    fn point(&self, state: &mut GaugeState<R, N>, readings: &[R; 3], index: usize, beta: i32) {
        let point = self.resampler.point(&mut state.resampler, readings, index);
        if !state.sampling.running {
            return;
        }
        let n = index & (N - 1);
        let revolution = &mut state.revolutions[!state.worked & 1];
        revolution.first[n] = point.h1;
        revolution.second[n] = point.h2;
        state.sums[!state.worked & 1][n] = point.sum;
        state.sampling.total += point.sum;
        if n & (N / ARM_CHECKS - 1) == 0 {
            revolution.beta[(n / (N / ARM_CHECKS)) & (ARM_CHECKS - 1)] = beta;
        }
        state.sampling.points = state.sampling.points.wrapping_add(1);
    }

    /// θ passes zero: a revolution ends, the next begins.
    #[inline(never)]
    fn turn(&self, state: &mut GaugeState<R, N>, flags: &mut GaugeFlags) {
        let sampling = state.sampling;
        let (mut before, mut skipped) = (None, GaugeFlags::default());
        if sampling.running && sampling.points == N {
            let mean = sampling.total * R::of(1.0 / N as f64);
            before = Some(mean);
            state.counts.sampled = state.counts.sampled.wrapping_add(1);
            let mut of_revolution = GaugeFlags::default();
            // A quarter of the time, plus a cycle of rounding at either end.
            if sampling.most > sampling.fewest.saturating_add(sampling.fewest / 4).saturating_add(2) {
                of_revolution.set(GaugeFlags::SPEED);
            }
            let clock = self.resampler.clock(&state.resampler);
            let few = clock.wrapping_sub(sampling.began) / 64;
            let limited = sampling.limited > few;
            // The drift of this revolution is the difference between two means, which is valid only if it is steady.
            let drift = sampling.before.map(|before| mean - before);
            let change = match (drift, state.drift) {
                (Some(drift), Some(before)) => (drift - before).abs() - (drift * R::of(0.25)).abs(),
                _ => R::ZERO,
            };
            let steady = drift.is_some() && change <= self.plan.steady;
            state.drift = drift;
            if self.infeed.is_some() && (limited || sampling.ineffective > few || !steady) {
                of_revolution.set(GaugeFlags::INFEED_FROZEN);
            }
            flags.set(of_revolution);
            of_revolution.set(sampling.flags);
            if state.work.is_idle() {
                state.worked ^= 1;
                let drift = drift.unwrap_or(R::ZERO);
                let beginning =
                    Beginning { revolution: state.counts.sampled, flags: of_revolution, limited, mean, drift };
                state.work.begin(&self.plan, beginning);
            } else {
                state.counts.skipped = state.counts.skipped.wrapping_add(1);
                flags.set(GaugeFlags::SKIPPED);
                skipped = GaugeFlags::SKIPPED;
            }
        }
        state.sampling = Sampling {
            running: !flags.discards(),
            flags: skipped,
            before,
            began: self.resampler.clock(&state.resampler),
            ..Sampling::NEW
        };
    }
}
