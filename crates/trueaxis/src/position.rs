//! Positions at the boundary of the step: doubles on a host, integers where doubles are slow.

use crate::real::Real;
use core::fmt::Debug;
use serde::{Deserialize, Serialize};

/// A coordinate that is exact over the whole travel; the step computes with differences of two of them.
///
/// Unit: mm for linear axes, degrees for rotary ones.
pub trait Position: Copy + Debug + Default + PartialEq + PartialOrd + Send + Sync + 'static {
    /// The nearest position to `x` (mm or deg); a value out of range becomes a position that is not usable.
    fn of(x: f64) -> Self;
    /// The nearest usable position to a limit of the machine (mm or deg).
    fn nearest(x: f64) -> Self {
        Self::of(x)
    }
    /// As a double (mm or deg).
    fn to_f64(self) -> f64;
    /// `self - origin`, rounded once.
    fn since<R: Real>(self, origin: Self) -> R;
    /// The same where the two are near each other, or only their order counts: integers saturate at ±2.147 m, for which a
    /// Cortex-M4F has an instruction.
    #[inline(always)]
    fn since_near<R: Real>(self, origin: Self) -> R {
        self.since(origin)
    }
    /// `self + d`, rounded once.
    fn plus<R: Real>(self, d: R) -> Self;
    /// `self - origin` reduced by whole turns to 0 (inclusive) … 360 degrees; the reduction itself is exact, so that
    /// an angle and the same angle after many turns give the same result. Meant for |self| up to 7e11 degrees.
    fn turn_since<R: Real>(self, origin: Self) -> R;
    /// A number a machine can mean: neither infinite nor NaN nor beyond 1e9 (so that no later product overflows), nor
    /// at an end of its range, where integers saturate.
    fn is_usable(self) -> bool;
}

impl Position for f64 {
    #[inline(always)]
    fn of(x: f64) -> f64 {
        x
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn since<R: Real>(self, origin: f64) -> R {
        R::of(self - origin)
    }
    #[inline(always)]
    fn plus<R: Real>(self, d: R) -> f64 {
        self + d.to_f64()
    }
    #[inline(always)]
    fn turn_since<R: Real>(self, origin: f64) -> R {
        // 360 n is exact and the subtraction of nearby values too; the quotient may be off by one turn, never by more.
        let angle = self - origin;
        let rest = angle - 360.0 * f64::from((angle * (1.0 / 360.0)) as i32);
        let rest = if rest < 0.0 { rest + 360.0 } else { rest };
        R::of(if rest >= 360.0 { rest - 360.0 } else { rest })
    }
    #[inline(always)]
    fn is_usable(self) -> bool {
        self.abs() <= 1e9
    }
}

/// A position in whole nanometres, ±2.147 m; of a rotary axis in 1e-6 degree, ±2147 degrees.
///
/// Nothing wraps: a value beyond the range saturates at `i32::MIN` or `i32::MAX`, and neither is usable.
///
/// For cores without a double-precision unit: an f64 subtraction costs about 120 instructions on a Cortex-M4F, this one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Nanometres(pub i32);

impl Position for Nanometres {
    #[inline(always)]
    fn of(x: f64) -> Nanometres {
        // Not a number must not become a position: the cast would make it zero.
        if x.is_nan() { Nanometres(i32::MIN) } else { Nanometres(libm::rint(x * 1e6) as i32) }
    }
    fn nearest(x: f64) -> Nanometres {
        Nanometres(Nanometres::of(x).0.clamp(i32::MIN + 1, i32::MAX - 1))
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self.0) / 1e6
    }
    #[inline(always)]
    fn since<R: Real>(self, origin: Nanometres) -> R {
        let difference = match self.0.checked_sub(origin.0) {
            Some(difference) => R::of_i32(difference),
            // Beyond 2.147 m: in two parts, each exact.
            None => R::of_i32((self.0 >> 1) - (origin.0 >> 1)) * R::TWO + R::of_i32((self.0 & 1) - (origin.0 & 1)),
        };
        difference * R::of(1e-6)
    }
    #[inline(always)]
    fn since_near<R: Real>(self, origin: Nanometres) -> R {
        R::of_i32(self.0.saturating_sub(origin.0)) * R::of(1e-6)
    }
    #[inline(always)]
    fn plus<R: Real>(self, d: R) -> Nanometres {
        let half = if d < R::ZERO { -R::HALF } else { R::HALF };
        Nanometres(self.0.saturating_add((d * R::of(1e6) + half).to_i32()))
    }
    #[inline(always)]
    fn turn_since<R: Real>(self, origin: Nanometres) -> R {
        let angle = i64::from(self.0) - i64::from(origin.0);
        R::of_i32(angle.rem_euclid(360_000_000) as i32) * R::of(1e-6)
    }
    #[inline(always)]
    fn is_usable(self) -> bool {
        self.0.wrapping_sub(i32::MAX) as u32 > 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_integers_cannot_say_is_not_usable() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 2_147.483_647, -2_147.483_648, 1e300] {
            assert!(!Nanometres::of(x).is_usable(), "{x}");
            assert!(Nanometres::nearest(x).is_usable(), "{x}");
        }
        for nanometres in [0, 1, -1, i32::MAX - 1, i32::MIN + 1] {
            assert!(Nanometres(nanometres).is_usable(), "{nanometres}");
            assert_eq!(Nanometres::nearest(f64::from(nanometres) * 1e-6), Nanometres(nanometres));
        }
    }

    proptest! {
        /// Against 64-bit integers, over the whole range, with the ends more often.
        #[test]
        fn differences_are_exact(a in any_position(), b in any_position()) {
            let truth = i64::from(a) - i64::from(b);
            prop_assert_eq!(Nanometres(a).since::<f64>(Nanometres(b)), truth as f64 * 1e-6);
            let single = f64::from(Nanometres(a).since::<f32>(Nanometres(b)));
            prop_assert!((single - truth as f64 * 1e-6).abs() <= 1.5e-7 * (truth as f64 * 1e-6).abs());
            let near = truth.clamp(i64::from(i32::MIN), i64::from(i32::MAX));
            prop_assert_eq!(Nanometres(a).since_near::<f64>(Nanometres(b)), near as f64 * 1e-6);
        }
    }

    fn any_position() -> impl Strategy<Value = i32> {
        prop_oneof![any::<i32>(), -1000..1000i32, Just(i32::MAX), Just(i32::MIN), Just(i32::MAX - 1)]
    }
}
