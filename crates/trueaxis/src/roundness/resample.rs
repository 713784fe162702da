//! Converts probe readings at equal times to readings at equal angles of the surface.
//!
//! θ = α + β, the angle over the surface, is known in every cycle from the encoders of spindle and arm. When it has passed one
//! of the N points of a revolution, a parabola through the last three cycles gives the three readings there:
//!
//! ```text
//! h(θ_n) = Σ w_i h_i      w_i = Π_{j≠i} x_j/(x_j − x_i)      x_i = θ_i − θ_n
//! ```
//!
//! Error of harmonic k of amplitude A at a spacing δ: 0.064 (kδ)³ A; with eight cycles to a point at N = 1024 and k = 50,
//! 3.6e-6 A. The angles need not be equidistant, so a changing speed makes no difference. Cycles in which the surface moved by
//! less than 1/64 of a point are skipped, so that no difference of angles is ever near zero.

#![deny(clippy::indexing_slicing)]

use super::Probes;
use super::angles::Gain;
use super::counter::{ArmCounter, SpindleCounter, SpindleState};
use super::flags::GaugeFlags;
use super::settings::GaugeSettings;
use crate::real::Real;

/// Most points that θ may pass in one cycle; beyond, the readings do not determine the surface between them.
pub(super) const POINTS_PER_CYCLE: usize = 2;

/// Immutable half.
#[derive(Clone, Copy, Debug)]
pub(super) struct Resampler<R, const N: usize> {
    spindle: SpindleCounter,
    arm: Option<ArmCounter>,
    /// Middle of every probe's range, and the square of a distance from it within which all readings are in range.
    middle: [R; 3],
    room: R,
    range: [[R; 2]; 3],
    scale: [[R; 2]; 3],
    weights: [R; 2],
    patience: u32,
}

/// State from cycle to cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ResamplerState<R> {
    spindle: SpindleState,
    /// Counts from α = 0 below which the next cycle may be a normal one; 0 if it needs the full check.
    pub(super) plain: u32,
    /// Cycles left until the spindle counts as stopped, unless θ passes a point.
    left: u32,
    /// θ and readings in the last two accepted cycles, the older one first.
    theta: [u32; 2],
    readings: [[R; 3]; 2],
    /// Number of those cycles, at most 2.
    known: u8,
    /// θ in this cycle, if known.
    here: u32,
    is_known: bool,
    /// Cycles up to the last point, and cycles in which the spindle did not turn, wrapping.
    clock: u32,
}

impl<R: Real> ResamplerState<R> {
    pub(super) const fn new() -> Self {
        ResamplerState {
            spindle: SpindleState::NEW,
            plain: 0,
            left: 0,
            theta: [0; 2],
            readings: [[R::ZERO; 3]; 2],
            known: 0,
            here: 0,
            is_known: false,
            clock: 0,
        }
    }

    /// θ in this cycle, if known.
    #[inline(always)]
    pub(super) fn theta(&self) -> Option<u32> {
        self.is_known.then_some(self.here)
    }

    /// α in this cycle from its β.
    #[inline(always)]
    pub(super) fn alpha(&self, beta: i32) -> u32 {
        self.here.wrapping_add_signed(beta.wrapping_neg())
    }
}

/// Result of the quick check of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum QuickCheck {
    /// The cycle needs the full check; the state is unchanged.
    NeedsFullCheck,
    /// A normal cycle between two points: completely handled.
    Between,
    /// A normal cycle in which θ has passed one point or two; [`Resampler::keep`] must follow.
    Passed {
        /// β in 2^−32 turns.
        beta: i32,
    },
}

/// A cycle accepted by the full check: [`Resampler::gather`] must follow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Counted {
    /// β in 2^−32 turns.
    pub(super) beta: i32,
    /// Whether θ has passed one point or two.
    pub(super) passed: bool,
}

/// Readings at one point of the revolution, µm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point<R> {
    pub(super) h1: R,
    pub(super) h2: R,
    /// h1 + k2 h2 + k3 h3.
    pub(super) sum: R,
}

impl<R: Real, const N: usize> Resampler<R, N> {
    /// Builds the resampler from checked settings.
    pub(super) fn new(settings: &GaugeSettings, gain: &Gain, period_s: f64) -> Self {
        let (mut middle, mut room) = ([R::ZERO; 3], f64::INFINITY);
        for (middle, probe) in middle.iter_mut().zip(&settings.probes) {
            // Uses the limits as they are compared, with a margin for their rounding.
            let [low, high] = probe.range.map(|limit| R::of(limit).to_f64());
            *middle = R::of(0.5 * (low + high));
            let clear = 1e-6 * libm::fmax(libm::fabs(low), libm::fabs(high));
            room = libm::fmin(room, libm::fmin(high - middle.to_f64(), middle.to_f64() - low) - clear);
        }
        let room = libm::fmax(room, 0.0);
        Resampler {
            spindle: SpindleCounter::new(&settings.spindle),
            arm: settings.arm.as_ref().map(ArmCounter::new),
            middle,
            room: R::of(room * room * (1.0 - 1e-5)),
            range: settings.probes.map(|probe| probe.range.map(R::of)),
            scale: settings.probes.map(|probe| [R::of(probe.gain_um), R::of(probe.zero)]),
            weights: [R::of(gain.k2()), R::of(gain.k3())],
            patience: (settings.stop_s / period_s) as u32,
        }
    }

    /// The shift from an angle to an index.
    const SHIFT: u32 = u32::BITS - N.trailing_zeros();
    /// One point, in 2^−32 turns.
    const WIDTH: i32 = 1 << Self::SHIFT;

    /// Handles nearly every cycle: first runs every test, and changes nothing if any of them fails.
    #[inline(always)]
    pub(super) fn quick_check(&self, state: &mut ResamplerState<R>, probes: &Probes<R>) -> QuickCheck {
        let (raw, in_turn) = self.spindle.read(&state.spindle, probes.spindle);
        let alpha = self.spindle.angle(in_turn);
        if in_turn >= state.plain {
            return QuickCheck::NeedsFullCheck;
        }
        let Some(left) = state.left.checked_sub(1) else { return QuickCheck::NeedsFullCheck };
        let mut beta = 0;
        if let Some(arm) = &self.arm {
            match arm.angle(probes.arm) {
                Some(angle) if self.spindle.follows(&state.spindle, raw) => beta = angle,
                _ => return QuickCheck::NeedsFullCheck,
            }
        }
        let [[h1, h2, h3], [m1, m2, m3]] = [&probes.readings, &self.middle];
        let [h1, h2, h3] = [*h1 - *m1, *h2 - *m2, *h3 - *m3];
        let theta = alpha.wrapping_add_signed(beta);
        let [_, last] = state.theta;
        let moved = theta.wrapping_sub(last) as i32;
        let between = (theta ^ last) >> Self::SHIFT == 0;
        // False for NaN.
        let sound = h1 * h1 + h2 * h2 + h3 * h3 <= self.room;
        if !sound {
            return QuickCheck::NeedsFullCheck;
        }
        // Within a point no jump is possible.
        if !(between || Self::is_regular(moved) && self.spindle.follows(&state.spindle, raw)) {
            return QuickCheck::NeedsFullCheck;
        }
        SpindleCounter::follow(&mut state.spindle, raw);
        (state.left, state.here) = (left, theta);
        if !between {
            return QuickCheck::Passed { beta };
        }
        if moved >= Self::WIDTH >> 6 {
            Self::keep(state, &probes.readings);
        }
        QuickCheck::Between
    }

    /// Number of points between the last accepted cycle and this one.
    #[inline(always)]
    pub(super) fn passed(state: &ResamplerState<R>) -> usize {
        let [_, last] = state.theta;
        (state.here >> Self::SHIFT).wrapping_sub(last >> Self::SHIFT) as usize & (N - 1)
    }

    /// Index of the last point up to this cycle.
    #[inline(always)]
    pub(super) fn index(state: &ResamplerState<R>) -> usize {
        (state.here >> Self::SHIFT) as usize
    }

    /// Whether a cycle's motion is large enough to compute a point, and not too large.
    #[inline(always)]
    fn is_regular(moved: i32) -> bool {
        moved >= Self::WIDTH >> 6 && moved <= Self::WIDTH * POINTS_PER_CYCLE as i32
    }

    /// Processes a cycle's readings and adds flags for any fault. [`Resampler::settle`] comes last.
    pub(super) fn full_check(
        &self,
        state: &mut ResamplerState<R>,
        probes: &Probes<R>,
        flags: &mut GaugeFlags,
    ) -> Option<Counted> {
        if !state.spindle.started {
            state.left = self.patience;
        }
        let stopped = state.left == 0;
        if stopped {
            state.clock = state.clock.wrapping_add(1);
        } else {
            state.left -= 1;
        }
        let alpha = self.spindle.update(&mut state.spindle, probes.spindle, probes.index, flags);
        let beta = match &self.arm {
            None => Some(0),
            Some(arm) => arm.angle(probes.arm),
        };
        state.is_known = false;
        let (Some(alpha), Some(beta)) = (alpha, beta) else {
            if beta.is_none() {
                flags.set(GaugeFlags::ARM);
            }
            self.restart(state);
            return None;
        };
        let theta = alpha.wrapping_add_signed(beta);
        (state.here, state.is_known) = (theta, true);
        if stopped {
            flags.set(GaugeFlags::STOPPED);
        }
        let mut sound = true;
        for (reading, [low, high]) in probes.readings.iter().zip(&self.range) {
            // False for NaN.
            sound &= *reading >= *low && *reading <= *high;
        }
        if !sound {
            flags.set(GaugeFlags::PROBE_RANGE);
            self.restart(state);
            return None;
        }
        let [_, last] = state.theta;
        let moved = theta.wrapping_sub(last) as i32;
        if state.known > 0 && !Self::is_regular(moved) {
            return self.irregular(state, moved, flags).then_some(Counted { beta, passed: false });
        }
        Some(Counted { beta, passed: state.known == 2 && Self::passed(state) > 0 })
    }

    /// After the full check: determines whether the next cycle may use the quick check.
    pub(super) fn settle(&self, state: &mut ResamplerState<R>) {
        let is_plain = state.known == 2 && state.is_known;
        state.plain = if is_plain { self.spindle.plain(&state.spindle) } else { 0 };
    }

    /// Discards all cycles before this one.
    fn restart(&self, state: &mut ResamplerState<R>) {
        state.known = 0;
        self.rest(state);
    }

    /// Restarts the time that the spindle has to pass a point.
    #[inline(always)]
    fn rest(&self, state: &mut ResamplerState<R>) {
        state.clock = self.clock(state);
        state.left = self.patience;
    }

    /// Number of cycles so far, wrapping.
    #[inline(always)]
    pub(super) fn clock(&self, state: &ResamplerState<R>) -> u32 {
        state.clock.wrapping_add(self.patience.wrapping_sub(state.left))
    }

    /// Handles a θ that stops, turns back, or runs too fast to be sampled; returns true if the cycle is accepted.
    fn irregular(&self, state: &mut ResamplerState<R>, moved: i32, flags: &mut GaugeFlags) -> bool {
        if moved > 0 && moved >= Self::WIDTH {
            flags.set(GaugeFlags::TOO_FAST);
            self.restart(state);
            return true;
        }
        if moved < -Self::WIDTH {
            flags.set(GaugeFlags::REVERSED);
            state.known = 0;
        }
        false
    }

    /// Readings at a point that θ has passed in this cycle.
    #[inline(always)]
    pub(super) fn point(&self, state: &mut ResamplerState<R>, readings: &[R; 3], index: usize) -> Point<R> {
        self.rest(state);
        let (angle, theta) = ((index as u32) << Self::SHIFT, state.here);
        let at = |other: u32| R::of_i32(other.wrapping_sub(angle) as i32);
        let [before, last] = state.theta;
        let (x0, x1, x2) = (at(before), at(last), at(theta));
        let w0 = (x1 * x2) / ((x1 - x0) * (x2 - x0));
        let w1 = (x0 * x2) / ((x0 - x1) * (x2 - x1));
        let w2 = R::ONE - w0 - w1;
        let [h0, h1] = &state.readings;
        let mut values = [R::ZERO; 3];
        for (value, (((a, b), c), [gain, zero])) in
            values.iter_mut().zip(h0.iter().zip(h1).zip(readings).zip(&self.scale))
        {
            *value = *gain * (w0 * *a + w1 * *b + w2 * *c - *zero);
        }
        let [first, second, third] = values;
        let [k2, k3] = self.weights;
        Point { h1: first, h2: second, sum: first + k2 * second + k3 * third }
    }

    /// Stores the cycle and counts it as known.
    pub(super) fn gather(state: &mut ResamplerState<R>, readings: &[R; 3]) {
        Self::keep(state, readings);
        state.known = (state.known + 1).min(2);
    }

    /// Stores the cycle for the next points.
    #[inline(always)]
    pub(super) fn keep(state: &mut ResamplerState<R>, readings: &[R; 3]) {
        let ([_, theta], [_, before]) = (state.theta, state.readings);
        state.theta = [theta, state.here];
        state.readings = [before, *readings];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From every point to every other, at the ends of both, for up to 512 points; for more points, from every 37th.
    #[test]
    fn every_angle_has_its_point_and_every_pair_its_distance() {
        fn points<const N: usize>(stride: usize) {
            let mut state = ResamplerState::<f32>::new();
            let width = ((1u64 << 32) / N as u64) as u32;
            for last in (0..N as u32).step_by(stride) {
                for here in 0..N as u32 {
                    let forward = (here.wrapping_sub(last) as usize) % N;
                    for (from, to) in [(0, width - 1), (width - 1, 0)] {
                        (state.theta, state.here) = ([0, last * width + from], here * width + to);
                        assert_eq!(Resampler::<f32, N>::index(&state), here as usize);
                        assert_eq!(Resampler::<f32, N>::passed(&state), forward, "{N}: {last} to {here}");
                    }
                }
            }
        }
        points::<64>(1);
        points::<128>(1);
        points::<256>(1);
        points::<512>(1);
        points::<1024>(37);
        points::<2048>(37);
        points::<4096>(37);
    }
}
