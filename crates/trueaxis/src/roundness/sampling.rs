//! First stage: a cycle's readings become points of a revolution, points become whole revolutions.

use super::resample::{Angles, POINTS_PER_CYCLE, Resampler};
use super::state::{GaugeState, Sampling};
use super::work::{ARM_CHECKS, Beginning, Outcome};
use super::{Followed, Gauge, GaugeFlags, Probes};
use crate::real::Real;

impl<R: Real, const N: usize> Gauge<R, N> {
    /// First stage: a cycle's readings, resampled; gives what it met.
    #[inline]
    pub fn sample(&self, state: &mut GaugeState<R, N>, probes: &Probes<R>, followed: Followed) -> GaugeFlags {
        if probes.new_part {
            state.work.clear();
            state.sampling = Sampling::NEW;
            state.latest = Outcome::NONE;
        }
        let mut flags = GaugeFlags::default();
        let passed = self.resampler.update(&mut state.resampler, probes, &mut flags);
        if flags.discards() && state.sampling.running {
            state.sampling.running = false;
            state.counts.discarded = state.counts.discarded.wrapping_add(1);
        }
        if followed != Followed::Whole || probes.idle {
            state.sampling.count(followed == Followed::Limited && !probes.idle);
        }
        if let Some(points) = passed {
            if points > 0 {
                self.pass(state, &probes.readings, points, &mut flags);
            }
            Resampler::<R, N>::keep(&mut state.resampler, &probes.readings);
        }
        flags
    }

    /// θ has passed a point, or two.
    #[inline(never)]
    fn pass(&self, state: &mut GaugeState<R, N>, readings: &[R; 3], points: usize, flags: &mut GaugeFlags) {
        let Some(Angles { theta, alpha, beta }) = state.resampler.angles else { return };
        state.sampling.time(alpha, state.resampler.clock);
        let mut angle = Resampler::<R, N>::last(&state.resampler);
        for _ in 0..points.min(POINTS_PER_CYCLE) {
            let point = self.resampler.point(&mut state.resampler, theta, readings, &mut angle);
            if point.index == 0 {
                self.turn(state, flags);
            }
            if !state.sampling.running {
                continue;
            }
            let revolution = &mut state.revolutions[!state.worked & 1];
            let n = point.index & (N - 1);
            revolution.first[n] = point.h1;
            revolution.second[n] = point.h2;
            state.sums[!state.worked & 1][n] = point.sum;
            state.sampling.total += point.sum;
            if n & (N / ARM_CHECKS - 1) == 0 {
                revolution.beta[(n / (N / ARM_CHECKS)) & (ARM_CHECKS - 1)] = beta;
            }
            state.sampling.points = state.sampling.points.wrapping_add(1);
        }
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
            // A quarter of the time, and a cycle of rounding at either end.
            if sampling.most > sampling.fewest.saturating_add(sampling.fewest / 4).saturating_add(2) {
                of_revolution.set(GaugeFlags::SPEED);
            }
            let few = state.resampler.clock.wrapping_sub(sampling.began) / 64;
            let limited = sampling.limited > few;
            // The drift of this revolution is that between two means: only where it is steady.
            let drift = sampling.before.map(|before| mean - before);
            let change = match (drift, state.drift) {
                (Some(drift), Some(before)) => (drift - before).abs() - (drift * R::of(0.25)).abs(),
                _ => R::ZERO,
            };
            let steady = drift.is_some() && change <= self.plan.steady;
            state.drift = drift;
            if self.infeed.is_some() && (limited || sampling.unheard > few || !steady) {
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
            began: state.resampler.clock,
            ..Sampling::NEW
        };
    }
}
