//! Probe readings at equal times become readings at equal angles of the surface.
//!
//! θ = α + β, the angle over the surface, is known in every cycle from the encoders of spindle and arm. Whenever it has
//! passed one of the N points of a revolution, the three readings there follow from the last three cycles by a parabola
//! through them:
//!
//! ```text
//! h(θ_n) = Σ w_i h_i      w_i = Π_{j≠i} x_j/(x_j − x_i)      x_i = θ_i − θ_n
//! ```
//!
//! Error of harmonic k of amplitude A at a spacing δ: 0.064 (kδ)³ A, with eight cycles to a point at N = 1024 and k = 50
//! 3.6e-6 A. The angles need not be equidistant: a changing speed changes nothing. Cycles in which the surface moved by
//! less than 1/64 of a point are passed over, so that no difference of angles is ever near zero.

#![deny(clippy::indexing_slicing)]

use super::Probes;
use super::angles::Gain;
use super::counter::{ArmCounter, SpindleCounter, SpindleState};
use super::flags::GaugeFlags;
use super::settings::GaugeSettings;
use crate::real::Real;

/// Points that θ may pass in one cycle; beyond, the readings say too little about the surface between them.
pub(super) const POINTS_PER_CYCLE: usize = 2;

/// Immutable half.
#[derive(Clone, Copy, Debug)]
pub(super) struct Resampler<R, const N: usize> {
    spindle: SpindleCounter,
    arm: Option<ArmCounter>,
    range: [[R; 2]; 3],
    scale: [[R; 2]; 3],
    weights: [R; 2],
    patience: u32,
}

/// State from cycle to cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct ResamplerState<R> {
    spindle: SpindleState,
    /// The last two cycles that count, the older one first.
    theta: [u32; 2],
    readings: [[R; 3]; 2],
    /// Number of them.
    known: u8,
    /// Counts cycles, wrapping.
    pub(super) clock: u32,
    /// The cycle in which a point was passed last.
    passed: u32,
    /// Angles of this cycle, where they are known.
    pub(super) angles: Option<Angles>,
}

impl<R: Real> ResamplerState<R> {
    pub(super) const fn new() -> Self {
        ResamplerState {
            spindle: SpindleState::NEW,
            theta: [0; 2],
            readings: [[R::ZERO; 3]; 2],
            known: 0,
            clock: 0,
            passed: 0,
            angles: None,
        }
    }
}

/// Angles of a cycle, in 2^−32 turns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Angles {
    pub(super) theta: u32,
    pub(super) alpha: u32,
    pub(super) beta: i32,
}

/// Readings at one point of the revolution, µm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point<R> {
    pub(super) index: usize,
    pub(super) h1: R,
    pub(super) h2: R,
    /// h1 + k2 h2 + k3 h3.
    pub(super) sum: R,
}

impl<R: Real, const N: usize> Resampler<R, N> {
    /// Of settings that have been checked.
    pub(super) fn new(settings: &GaugeSettings, gain: &Gain, period_s: f64) -> Self {
        Resampler {
            spindle: SpindleCounter::new(&settings.spindle),
            arm: settings.arm.as_ref().map(ArmCounter::new),
            range: settings.probes.map(|probe| probe.range.map(R::of)),
            scale: settings.probes.map(|probe| [R::of(probe.gain_um), R::of(probe.zero)]),
            weights: [R::of(gain.k2()), R::of(gain.k3())],
            patience: (settings.stop_s / period_s) as u32,
        }
    }

    /// The shift that makes an index of an angle.
    const SHIFT: u32 = u32::BITS - N.trailing_zeros();
    /// One point, in 2^−32 turns.
    const WIDTH: i32 = 1 << Self::SHIFT;

    /// Takes a cycle's readings; `Some(points that θ has passed)` where the cycle counts, then
    /// [`Resampler::keep`] has to follow. What is wrong is added to the flags.
    #[inline(always)]
    pub(super) fn update(
        &self,
        state: &mut ResamplerState<R>,
        probes: &Probes<R>,
        flags: &mut GaugeFlags,
    ) -> Option<usize> {
        state.clock = state.clock.wrapping_add(1);
        let alpha = self.spindle.update(&mut state.spindle, probes.spindle, probes.index, flags);
        let beta = match &self.arm {
            None => Some(0),
            Some(arm) => arm.angle(probes.arm),
        };
        let (Some(alpha), Some(beta)) = (alpha, beta) else {
            return self.lose(state, beta, flags);
        };
        let theta = alpha.wrapping_add_signed(beta);
        state.angles = Some(Angles { theta, alpha, beta });
        if state.clock.wrapping_sub(state.passed) > self.patience {
            flags.set(GaugeFlags::STOPPED);
        }
        let mut sound = true;
        for (reading, [low, high]) in probes.readings.iter().zip(&self.range) {
            // False for what is not a number.
            sound &= *reading >= *low && *reading <= *high;
        }
        if !sound {
            flags.set(GaugeFlags::PROBE_RANGE);
            (state.known, state.passed) = (0, state.clock);
            return None;
        }
        let [_, last] = state.theta;
        let moved = theta.wrapping_sub(last) as i32;
        if state.known > 0 && (moved < (Self::WIDTH >> 6) || moved > Self::WIDTH * POINTS_PER_CYCLE as i32) {
            return Self::irregular(state, moved, flags);
        }
        if state.known < 2 {
            return Some(0);
        }
        Some((theta >> Self::SHIFT).wrapping_sub(last >> Self::SHIFT) as usize & (N - 1))
    }

    /// θ is unknown.
    #[inline(never)]
    fn lose(&self, state: &mut ResamplerState<R>, beta: Option<i32>, flags: &mut GaugeFlags) -> Option<usize> {
        if beta.is_none() {
            flags.set(GaugeFlags::ARM);
        }
        (state.known, state.angles, state.passed) = (0, None, state.clock);
        None
    }

    /// θ stands, turns back, or runs too fast to be sampled.
    #[inline(never)]
    fn irregular(state: &mut ResamplerState<R>, moved: i32, flags: &mut GaugeFlags) -> Option<usize> {
        if moved > 0 && moved >= Self::WIDTH {
            flags.set(GaugeFlags::TOO_FAST);
            (state.known, state.passed) = (0, state.clock);
            return Some(0);
        }
        if moved < -Self::WIDTH {
            flags.set(GaugeFlags::REVERSED);
            state.known = 0;
        }
        None
    }

    /// Readings at the next point after `angle`, which θ has passed in this cycle; moves `angle` there.
    #[inline(always)]
    pub(super) fn point(
        &self,
        state: &mut ResamplerState<R>,
        theta: u32,
        readings: &[R; 3],
        angle: &mut u32,
    ) -> Point<R> {
        state.passed = state.clock;
        *angle = (*angle & (Self::WIDTH as u32).wrapping_neg()).wrapping_add(Self::WIDTH as u32);
        let at = |other: u32| R::of_i32(other.wrapping_sub(*angle) as i32);
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
        Point { index: (*angle >> Self::SHIFT) as usize, h1: first, h2: second, sum: first + k2 * second + k3 * third }
    }

    /// θ in the last cycle that counts.
    #[inline(always)]
    pub(super) fn last(state: &ResamplerState<R>) -> u32 {
        state.theta[1]
    }

    /// Keeps the cycle for the points to come.
    #[inline(always)]
    pub(super) fn keep(state: &mut ResamplerState<R>, readings: &[R; 3]) {
        let theta = state.angles.map_or(0, |angles| angles.theta);
        state.theta = [state.theta[1], theta];
        state.readings = [state.readings[1], *readings];
        state.known = (state.known + 1).min(2);
    }
}
