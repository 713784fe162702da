//! Positions at the boundary of the step: doubles on a host, integers on cores with slow doubles.

use crate::real::{Real, Sealed};
use core::fmt::Debug;
use serde::{Deserialize, Serialize};

/// A coordinate that is exact over the whole travel; the step computes with differences of two of them.
///
/// Unit: mm for linear axes, degrees for rotary ones. Sealed: `f64` and [`Nanometres`] only.
pub trait Position: Sealed + Copy + Debug + Default + PartialEq + PartialOrd + Send + Sync + 'static {
    /// A correction as a position offset: exactly the difference between a drive position and its command.
    type Offset: Copy + Debug + Default + PartialEq + Send + Sync;
    /// A distance in steps of the position, for comparisons.
    type Reach: Copy + Debug + Default + PartialEq + PartialOrd + Send + Sync;
    /// A step of the position in mm (deg): 1 for doubles.
    const STEP: f64;
    /// The nearest position to `x` (mm or deg); a value out of range becomes a position that is not usable.
    fn of(x: f64) -> Self;
    /// The nearest usable position to a limit of the machine (mm or deg).
    fn nearest(x: f64) -> Self {
        Self::of(x)
    }
    /// The farthest usable position that does not exceed the end of a range (mm or deg), `upper` or lower.
    fn within_end(end: f64, upper: bool) -> Self {
        let nearest = Self::nearest(end);
        let beyond = if upper { nearest.to_f64() > end } else { nearest.to_f64() < end };
        match (beyond, upper) {
            (false, _) => nearest,
            (true, true) => Self::nearest(end - Self::STEP),
            (true, false) => Self::nearest(end + Self::STEP),
        }
    }
    /// The largest correction that is a whole number of steps and not above a limit (mm or deg), at least a step; for
    /// doubles the limit itself. A limit that rounding leaves up to 1e-6 of a step low counts as whole.
    fn whole_steps(limit: f64) -> f64 {
        limit
    }
    /// As a double (mm or deg).
    fn to_f64(self) -> f64;
    /// `self - origin`, rounded once.
    fn since<R: Real>(self, origin: Self) -> R;
    /// [`Position::since`] for two near positions, or if only their order counts: integers saturate at ±2.147 m, for
    /// which a Cortex-M4F has an instruction.
    #[inline(always)]
    fn since_near<R: Real>(self, origin: Self) -> R {
        self.since(origin)
    }
    /// `self + d`, rounded once.
    fn plus<R: Real>(self, d: R) -> Self;
    /// `self - origin` reduced by whole turns to 0 (inclusive) … 360 degrees; the reduction itself is exact, so that an
    /// angle and the same angle many turns later give the same result. Valid for |self| up to 7e11 degrees.
    fn turn_since<R: Real>(self, origin: Self) -> R;
    /// Rounds a correction of `d` mm (deg) to an offset. Zero adds nothing to a position, not even a sign.
    fn offset<R: Real>(d: R) -> Self::Offset;
    /// `self + offset`; an integer saturates.
    fn moved(self, offset: Self::Offset) -> Self;
    /// `self - offset`; an integer saturates.
    fn moved_back(self, offset: Self::Offset) -> Self;
    /// A distance of `d` mm (deg), rounded to whole steps; the longest possible one if `d` is beyond the range.
    fn reach(d: f64) -> Self::Reach;
    /// [`Position::reach`] of a distance in the step's scalar; an integer is rounded towards zero.
    fn reach_of<R: Real>(d: R) -> Self::Reach;
    /// The sum of two distances; an integer saturates.
    fn farther(distance: Self::Reach, more: Self::Reach) -> Self::Reach;
    /// |self − other|, exact in integers, even for positions at opposite ends. NaN if a double is NaN, so that every
    /// comparison with a reach is false.
    fn apart(self, other: Self) -> Self::Reach;
    /// `self - low` in steps, and whether it lies in 0 … `reach`: one comparison of integers. Outside that range the
    /// distance is meaningless. `low` and `reach` together must stay below 2.147 m, and so must `reach` alone.
    fn steps_above<R: Real>(self, low: Self, reach: Self::Reach) -> (R, bool);
    /// What [`Position::phase`] needs of a period of `length` mm (deg), from 0.001 on.
    #[doc(hidden)]
    fn rate(length: f64) -> u64;
    /// Place within a period, 0 at machine zero, in units of 2⁻³² of the period; it wraps with the period.
    #[doc(hidden)]
    fn phase(self, rate: u64) -> u32;
    /// Whether it lies from the first of two limits to the second, both included.
    #[inline(always)]
    fn is_within(self, [low, high]: &[Self; 2]) -> bool {
        self >= *low && self <= *high
    }
    /// Whether a machine can use it: not infinite, NaN or beyond 1e9 (so that no later product overflows), and not at an
    /// end of its range, where integers saturate.
    fn is_usable(self) -> bool;
}

impl Position for f64 {
    type Offset = f64;
    type Reach = f64;
    const STEP: f64 = 1.0;
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
        // 360 n is exact, and so is the subtraction of nearby values; the quotient may be off by at most one turn.
        let angle = self - origin;
        let rest = angle - 360.0 * f64::from((angle * (1.0 / 360.0)) as i32);
        let rest = if rest < 0.0 { rest + 360.0 } else { rest };
        R::of(if rest >= 360.0 { rest - 360.0 } else { rest })
    }
    #[inline(always)]
    fn offset<R: Real>(d: R) -> f64 {
        // x + −0 is x, for x = −0 too.
        if d == R::ZERO { -0.0 } else { d.to_f64() }
    }
    #[inline(always)]
    fn moved(self, offset: f64) -> f64 {
        self + offset
    }
    #[inline(always)]
    fn moved_back(self, offset: f64) -> f64 {
        // self − offset, except that −0 stays −0.
        -(-self + offset)
    }
    #[inline(always)]
    fn reach(d: f64) -> f64 {
        d
    }
    #[inline(always)]
    fn reach_of<R: Real>(d: R) -> f64 {
        d.to_f64()
    }
    #[inline(always)]
    fn farther(distance: f64, more: f64) -> f64 {
        distance + more
    }
    #[inline(always)]
    fn apart(self, other: f64) -> f64 {
        (self - other).abs()
    }
    #[inline(always)]
    fn steps_above<R: Real>(self, low: f64, reach: f64) -> (R, bool) {
        let distance = self - low;
        (R::of(distance), (distance >= 0.0) & (distance <= reach))
    }
    /// The bits of 1/length.
    #[inline(always)]
    fn rate(length: f64) -> u64 {
        (1.0 / length).to_bits()
    }
    #[inline(always)]
    fn phase(self, rate: u64) -> u32 {
        let periods = self * f64::from_bits(rate);
        let part = periods - f64::from(periods as i32);
        // A negative part wraps.
        ((part * (1_u32 << 31) as f64) as i32 as u32) << 1
    }
    #[inline(always)]
    fn is_usable(self) -> bool {
        self.abs() <= 1e9
    }
}

/// A position in whole nanometres, ±2.147 m; on a rotary axis in 1e-6 degree, ±2147 degrees.
///
/// Nothing wraps: a value beyond the range saturates at `i32::MIN` or `i32::MAX`, and neither is usable.
///
/// For cores without a double-precision unit: on a Cortex-M4F a subtraction of doubles costs about 120 instructions,
/// one of these a single instruction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Nanometres(pub i32);

impl Sealed for Nanometres {}

impl Position for Nanometres {
    type Offset = i32;
    type Reach = u32;
    const STEP: f64 = 1e-6;
    #[inline(always)]
    fn of(x: f64) -> Nanometres {
        // NaN must not become a position: the cast would make it zero.
        if x.is_nan() { Nanometres(i32::MIN) } else { Nanometres(libm::rint(x * 1e6) as i32) }
    }
    fn nearest(x: f64) -> Nanometres {
        Nanometres(Nanometres::of(x).0.clamp(i32::MIN + 1, i32::MAX - 1))
    }
    fn whole_steps(limit: f64) -> f64 {
        libm::floor(limit * 1e6 + 1e-6).max(1.0) / 1e6
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
    // Only with rotary_axes.
    #[inline(always)]
    fn turn_since<R: Real>(self, origin: Nanometres) -> R {
        let angle = i64::from(self.0) - i64::from(origin.0);
        R::of_i32(angle.rem_euclid(360_000_000) as i32) * R::of(1e-6)
    }
    #[inline(always)]
    fn offset<R: Real>(d: R) -> i32 {
        let half = if d < R::ZERO { -R::HALF } else { R::HALF };
        (d * R::of(1e6) + half).to_i32()
    }
    #[inline(always)]
    fn moved(self, offset: i32) -> Nanometres {
        Nanometres(self.0.saturating_add(offset))
    }
    #[inline(always)]
    fn moved_back(self, offset: i32) -> Nanometres {
        Nanometres(self.0.saturating_sub(offset))
    }
    #[inline(always)]
    fn reach(d: f64) -> u32 {
        libm::rint(d * 1e6) as u32
    }
    #[inline(always)]
    fn reach_of<R: Real>(d: R) -> u32 {
        (d * R::of(1e6)).to_u32()
    }
    #[inline(always)]
    fn farther(distance: u32, more: u32) -> u32 {
        distance.saturating_add(more)
    }
    #[inline(always)]
    fn apart(self, other: Nanometres) -> u32 {
        self.0.abs_diff(other.0)
    }
    #[inline(always)]
    fn steps_above<R: Real>(self, low: Nanometres, reach: u32) -> (R, bool) {
        let distance = self.0.wrapping_sub(low.0) as u32;
        (R::of_i32(distance as i32), distance <= reach)
    }
    /// Periods in a step, in units of 2⁻⁶⁴.
    fn rate(length: f64) -> u64 {
        libm::rint((1_u64 << 32) as f64 * (1_u64 << 32) as f64 * 1e-6 / length) as u64
    }
    #[inline(always)]
    fn phase(self, rate: u64) -> u32 {
        ((i64::from(self.0) as u64).wrapping_mul(rate) >> 32) as u32
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
    fn unrepresentable_values_are_not_usable() {
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
        /// Compared with 64-bit integers, over the whole range, the ends more often.
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

    proptest! {
        #[test]
        fn an_offset_is_what_a_correction_adds(a in any_position(), d in -5.0..5.0f64) {
            for position in [Nanometres(a), Nanometres(0)] {
                let offset = Nanometres::offset(d);
                prop_assert_eq!(position.moved(offset), position.plus(d));
                if position.moved(offset).is_usable() {
                    prop_assert_eq!(position.moved(offset).moved_back(offset), position);
                }
            }
            for position in [f64::from(a), 0.0, -0.0] {
                prop_assert_eq!(position.moved(f64::offset(d)), position + d);
                prop_assert_eq!(position.moved_back(f64::offset(d)), position - d);
                for zero in [0.0, -0.0] {
                    prop_assert_eq!(position.moved(f64::offset(zero)).to_bits(), position.to_bits());
                    prop_assert_eq!(position.moved_back(f64::offset(zero)).to_bits(), position.to_bits());
                }
            }
        }

        #[test]
        fn windows_are_exact(a in any_position(), low in any_position(), reach in any::<u32>()) {
            let truth = i64::from(a) - i64::from(low);
            prop_assert_eq!(Nanometres(a).apart(Nanometres(low)), truth.unsigned_abs() as u32);
            let reach = reach.min(low.abs_diff(i32::MAX)) >> 1;
            let (steps, inside) = Nanometres(a).steps_above::<f64>(Nanometres(low), reach);
            prop_assert_eq!(inside, truth >= 0 && truth <= i64::from(reach));
            if inside {
                prop_assert_eq!(steps, truth as f64);
            }
            let (steps, inside) = f64::from(a).steps_above::<f64>(f64::from(low), f64::from(reach));
            prop_assert_eq!((steps, inside), (truth as f64, truth >= 0 && truth <= i64::from(reach)));
        }
    }

    fn any_position() -> impl Strategy<Value = i32> {
        prop_oneof![any::<i32>(), -1000..1000i32, Just(i32::MAX), Just(i32::MIN), Just(i32::MAX - 1)]
    }
}
