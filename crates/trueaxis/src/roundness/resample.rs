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
use super::flags::Flags;
use super::settings::RoundnessSettings;
use crate::real::Real;

/// Points that θ may pass in one cycle; beyond, the readings say too little about the surface between them.
pub(super) const MOST_POINTS: usize = 2;

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

/// What a cycle hands to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct ResamplerState<R> {
    spindle: SpindleState,
    /// The last two cycles that count, the older one first.
    theta: [u32; 2],
    readings: [[R; 3]; 2],
    /// How many of them there are.
    known: u8,
    /// Cycles since a point was passed.
    quiet: u32,
    /// θ and α of the last cycle in which they were known.
    angles: Option<Angles>,
    /// Change of θ per cycle, smoothed.
    speed: R,
}

impl<R: Real> ResamplerState<R> {
    pub(super) const fn new() -> Self {
        ResamplerState {
            spindle: SpindleState::NEW,
            theta: [0; 2],
            readings: [[R::ZERO; 3]; 2],
            known: 0,
            quiet: 0,
            angles: None,
            speed: R::ZERO,
        }
    }

    /// θ, α and β of this cycle, where they are known.
    #[inline(always)]
    pub(super) fn angles(&self) -> Option<Angles> {
        self.angles
    }

    /// Change of θ per cycle, in units of 2^−32 turns.
    #[inline(always)]
    pub(super) fn speed(&self) -> R {
        self.speed
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
    pub(super) place: usize,
    pub(super) h1: R,
    pub(super) h2: R,
    /// h1 + k2 h2 + k3 h3.
    pub(super) sum: R,
}

/// The points that θ has passed in a cycle, in their order.
pub(super) type Passed<R> = [Option<Point<R>>; MOST_POINTS];

impl<R: Real, const N: usize> Resampler<R, N> {
    /// Of settings that have been checked.
    pub(super) fn new(settings: &RoundnessSettings, gain: &Gain, period_s: f64) -> Self {
        Resampler {
            spindle: SpindleCounter::new(&settings.spindle),
            arm: settings.arm.as_ref().map(ArmCounter::new),
            range: settings.probes.map(|probe| probe.range.map(R::of)),
            scale: settings.probes.map(|probe| [R::of(probe.gain_um), R::of(probe.zero)]),
            weights: [R::of(gain.k2()), R::of(gain.k3())],
            patience: (settings.stop_s / period_s) as u32,
        }
    }

    /// The shift that makes a place of an angle.
    const SHIFT: u32 = u32::BITS - N.trailing_zeros();

    /// Takes a cycle's readings; gives the points passed, adds what is wrong to the flags.
    #[inline(always)]
    pub(super) fn update(&self, state: &mut ResamplerState<R>, probes: &Probes<R>, flags: &mut Flags) -> Passed<R> {
        let mut sound = true;
        for (reading, [low, high]) in probes.readings.iter().zip(&self.range) {
            // False for what is not a number.
            sound &= *reading >= *low && *reading <= *high;
        }
        if !sound {
            flags.set(Flags::PROBE_RANGE);
        }
        let alpha = self.spindle.update(&mut state.spindle, probes.spindle, probes.index, flags);
        let beta = match &self.arm {
            None => Some(0),
            Some(arm) => arm.angle(probes.arm),
        };
        if beta.is_none() {
            flags.set(Flags::ARM);
        }
        let (Some(alpha), Some(beta)) = (alpha, beta) else {
            *state = ResamplerState { spindle: state.spindle, ..ResamplerState::new() };
            return [None; MOST_POINTS];
        };
        let theta = alpha.wrapping_add_signed(beta);
        if let Some(last) = state.angles {
            let change = R::of_i32(theta.wrapping_sub(last.theta) as i32);
            state.speed += (change - state.speed) * R::of(1.0 / 64.0);
        }
        state.angles = Some(Angles { theta, alpha, beta });
        state.quiet = state.quiet.saturating_add(1);
        if state.quiet > self.patience {
            flags.set(Flags::STOPPED);
        }
        if !sound {
            state.known = 0;
            return [None; MOST_POINTS];
        }
        self.advance(state, theta, probes.readings, flags)
    }

    #[inline(always)]
    fn advance(&self, state: &mut ResamplerState<R>, theta: u32, readings: [R; 3], flags: &mut Flags) -> Passed<R> {
        let mut passed = [None; MOST_POINTS];
        let width = 1i32 << Self::SHIFT;
        let [before, last] = state.theta;
        let moved = theta.wrapping_sub(last) as i32;
        if state.known > 0 {
            if moved < (width >> 6) {
                if moved < -width {
                    flags.set(Flags::REVERSED);
                    state.known = 0;
                }
                return passed;
            }
            if moved > width * MOST_POINTS as i32 {
                flags.set(Flags::TOO_FAST);
                state.known = 0;
            }
        }
        if state.known > 1 {
            let count = (theta >> Self::SHIFT).wrapping_sub(last >> Self::SHIFT) as usize & (N - 1);
            let mut point = last;
            for (slot, _) in passed.iter_mut().zip(0..count) {
                point = (point & (width as u32).wrapping_neg()).wrapping_add(width as u32);
                let at = |angle: u32| R::of_i32(angle.wrapping_sub(point) as i32);
                let x = [at(before), at(last), at(theta)];
                let place = (point >> Self::SHIFT) as usize;
                *slot = Some(self.point(place, x, [&state.readings[0], &state.readings[1], &readings]));
                state.quiet = 0;
            }
        }
        state.theta = [last, theta];
        state.readings = [state.readings[1], readings];
        state.known = (state.known + 1).min(2);
        passed
    }

    /// The parabola through three cycles, at x = 0.
    #[inline(always)]
    fn point(&self, place: usize, [x0, x1, x2]: [R; 3], [h0, h1, h2]: [&[R; 3]; 3]) -> Point<R> {
        let w0 = (x1 * x2) / ((x1 - x0) * (x2 - x0));
        let w1 = (x0 * x2) / ((x0 - x1) * (x2 - x1));
        let w2 = R::ONE - w0 - w1;
        let mut values = [R::ZERO; 3];
        let rows = h0.iter().zip(h1).zip(h2).zip(&self.scale);
        for (value, (((a, b), c), [gain, zero])) in values.iter_mut().zip(rows) {
            *value = *gain * (w0 * *a + w1 * *b + w2 * *c - *zero);
        }
        let [first, second, third] = values;
        let [k2, k3] = self.weights;
        Point { place, h1: first, h2: second, sum: first + k2 * second + k3 * third }
    }
}
