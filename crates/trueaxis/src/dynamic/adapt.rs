//! Factors on the identified friction figures: they follow what reversals leave, and never leave their interval.
//!
//! An axis with `adapt` = b uses the Coulomb friction F_c p and the pre-sliding z/r in place of the identified F_c and z.
//! With l the relative error of a figure as found at a reversal,
//!
//! ```text
//! p  <- p + clamp(p l/2, ±0.05), clamped to [1 − b, 1 + b]              of Coulomb friction
//! r  <- r − clamp(r l/2, ±0.05), clamped to [1/(1 + b), 1/(1 − b)]      of pre-sliding
//! ```
//!
//! The law clamps again where it uses a factor, so that |figure − identified| <= b · identified holds for all bit
//! patterns of state and input, and across an exchange for a machine with another interval. `tests/proofs` proves it on
//! the compiler's code. The interval is rounded inwards.

#![deny(clippy::indexing_slicing)]

use crate::real::Real;

/// Share of the error found that is corrected at a reversal.
const GAIN: f64 = 0.5;
/// Largest change of a factor at a reversal.
const STEP: f64 = 0.05;

/// A factor on an identified figure.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub(super) struct Factor<R> {
    value: R,
}

impl<R: Real> Default for Factor<R> {
    /// The identified figure.
    fn default() -> Self {
        Factor { value: R::ONE }
    }
}

/// Interval of a factor, and its largest change.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub(super) struct Bounds<R> {
    low: R,
    high: R,
    step: R,
}

impl<R: Real> Bounds<R> {
    fn new(low: f64, high: f64) -> Self {
        Bounds { low: R::of(low), high: R::of(high), step: R::of(STEP) }
    }

    /// The factor that the law uses.
    #[inline(always)]
    pub(super) fn used(&self, factor: &Factor<R>) -> R {
        factor.value.limit(self.low, self.high)
    }

    /// Moves the factor by a share of `error`, up to its largest change, within the interval; an error that is not
    /// finite moves nothing.
    #[inline(always)]
    pub(super) fn follow(&self, factor: &mut Factor<R>, error: R) {
        if error.is_finite() {
            let step = (R::of(GAIN) * error).limit(-self.step, self.step);
            factor.value = (self.used(factor) + step).limit(self.low, self.high);
        }
    }
}

/// Intervals of an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Intervals<R> {
    /// Of Coulomb friction.
    pub(super) level: Bounds<R>,
    /// Of 1/z.
    pub(super) rate: Bounds<R>,
}

impl<R: Real> Intervals<R> {
    /// The intervals of an axis whose figures may leave the identified ones by the share b, 0 to 0.9.
    pub(super) fn new(share: f64) -> Self {
        // So that rounding leads no end out of the interval, nor a reciprocal.
        let share = (share - 2.0 * R::EPSILON.to_f64()).max(0.0);
        Intervals {
            level: Bounds::new(1.0 - share, 1.0 + share),
            rate: Bounds::new(1.0 / (1.0 + share), 1.0 / (1.0 - share)),
        }
    }
}

impl<R: Real> Intervals<R> {
    /// The factors in use, of Coulomb friction and of z.
    pub(super) fn used(&self, factors: &Factors<R>) -> [R; 2] {
        [self.level.used(&factors.level), R::ONE / self.rate.used(&factors.rate)]
    }
}

/// Factors of an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factors<R> {
    /// Of Coulomb friction.
    pub(super) level: Factor<R>,
    /// Of 1/z.
    pub(super) rate: Factor<R>,
}

impl<R: Real> Default for Factors<R> {
    /// The identified figures.
    fn default() -> Self {
        Factors { level: Factor::default(), rate: Factor::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn inside(share: f64, factors: &Factors<f32>) -> bool {
        let intervals = Intervals::<f32>::new(share);
        let level = f64::from(intervals.level.used(&factors.level));
        let rate = f64::from(intervals.rate.used(&factors.rate));
        (level - 1.0).abs() <= share && (1.0 / rate - 1.0).abs() <= share
    }

    #[test]
    fn intervals_are_rounded_inwards_and_contain_the_identified_figure() {
        for k in 0..=9000 {
            let share = f64::from(k) * 1e-4;
            let one = Factors::default();
            let intervals = Intervals::<f32>::new(share);
            assert_eq!((intervals.level.used(&one.level), intervals.rate.used(&one.rate)), (1.0, 1.0), "{share}");
            for extreme in [f32::MIN, f32::MAX, f32::NAN] {
                let factors = Factors { level: Factor { value: extreme }, rate: Factor { value: extreme } };
                assert!(inside(share, &factors), "{share} {extreme}");
            }
        }
    }

    proptest! {
        /// Whatever the errors are and whatever the state held before, no figure leaves its interval or moves faster than
        /// stated.
        #[test]
        fn no_error_moves_a_figure_out_of_its_interval(
            share in 0.0..0.9,
            bits in any::<[u32; 2]>(),
            errors in prop::collection::vec(any::<u32>(), 1..100),
        ) {
            let intervals = Intervals::<f32>::new(share);
            let [level, rate] = bits.map(|bits| Factor { value: f32::from_bits(bits) });
            let mut factors = Factors { level, rate };
            for bits in errors {
                let error = f32::from_bits(bits);
                let before = intervals.level.used(&factors.level);
                intervals.level.follow(&mut factors.level, error);
                intervals.rate.follow(&mut factors.rate, error);
                prop_assert!(inside(share, &factors));
                let change = intervals.level.used(&factors.level) - before;
                prop_assert!(change.abs() <= 0.05 + 2e-7 && change * error >= 0.0 || error.is_nan());
            }
        }
    }
}
