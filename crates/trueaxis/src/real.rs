//! The scalar of the step: `f32` or `f64`, one generic code path.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Supertrait of [`Real`] and of [`Position`](crate::Position) that no other crate can name, and so not implement.
pub trait Sealed {}
impl Sealed for f32 {}
impl Sealed for f64 {}

/// A hardware float in which the step computes.
///
/// Contains only operations that cannot panic, allocate or call a transcendental function; results are identical on every
/// target (the square root is correctly rounded). Sealed: `f32` and `f64` only, so that operations may be added.
pub trait Real:
    Sealed
    + Copy
    + Debug
    + Default
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + Send
    + Sync
    + 'static
{
    /// glam's vector of this scalar, used for points and directions in the public interface.
    type Vec3: Copy + Debug + Default + PartialEq + From<[Self; 3]> + Into<[Self; 3]> + Send + Sync + 'static;

    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// 1/2.
    const HALF: Self;
    /// 2.
    const TWO: Self;
    /// 3.
    const THREE: Self;
    /// Difference between 1 and the next larger value.
    const EPSILON: Self;
    /// Largest finite value.
    const MAX: Self;

    /// Rounds a double to this scalar.
    fn of(x: f64) -> Self;
    /// Widens to a double, exactly.
    fn to_f64(self) -> f64;
    /// Small integer to scalar.
    fn of_i32(i: i32) -> Self;
    /// Truncates toward zero; saturates at the ends of `i32`; NaN gives 0.
    fn to_i32(self) -> i32;
    /// Truncates; saturates at the ends of `u32`; NaN gives 0.
    fn to_u32(self) -> u32;
    /// Stores an index as the bits of a scalar.
    fn of_index(index: u16) -> Self;
    /// Reads the index that [`Real::of_index`] stored; no arithmetic, one load.
    fn to_index(self) -> usize;
    /// Stores a word as the bits of a scalar, which is only moved: it may be a NaN.
    #[doc(hidden)]
    fn of_word(word: u32) -> Self;
    /// Reads the word that [`Real::of_word`] stored.
    #[doc(hidden)]
    fn to_word(self) -> u32;
    /// Square root; 0 for arguments that are not positive.
    fn sqrt(self) -> Self;
    /// Square root of a value that cannot be negative, such as a sum of squares: without a test.
    fn root(self) -> Self;
    /// Two [`Real::root`]s at once: fewer instructions where the compiler cannot arrange them.
    fn roots(squares: [Self; 2]) -> [Self; 2];
    /// |x|, one instruction.
    fn abs(self) -> Self;
    /// `self + a b`, rounded twice; once with the feature `fma` on a processor that has the instruction.
    fn add_product(self, a: Self, b: Self) -> Self;
    /// Whether it is neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// Whether it lies in 0 to 1, by one comparison of its bits; `false` for −0.
    fn is_in_unit(self) -> bool;
    /// The smaller one; `other` if `self` is NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    /// The larger one; `other` if `self` is NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    /// `self` limited to `low..=high`; `low` if `self` is NaN. Unlike `core`'s `clamp`, it cannot panic.
    #[inline(always)]
    fn limit(self, low: Self, high: Self) -> Self {
        Self::min(Self::max(self, low), high)
    }
}

macro_rules! real {
    ($t:ty, $vector:ty, $root:expr, $roots:expr) => {
        impl Real for $t {
            type Vec3 = $vector;
            const ZERO: $t = 0.0;
            const ONE: $t = 1.0;
            const HALF: $t = 0.5;
            const TWO: $t = 2.0;
            const THREE: $t = 3.0;
            const EPSILON: $t = <$t>::EPSILON;
            const MAX: $t = <$t>::MAX;
            #[inline(always)]
            fn of(x: f64) -> $t {
                x as $t
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                self.into()
            }
            #[inline(always)]
            fn of_i32(i: i32) -> $t {
                i as $t
            }
            #[inline(always)]
            fn to_i32(self) -> i32 {
                self as i32
            }
            #[inline(always)]
            fn to_u32(self) -> u32 {
                self as u32
            }
            #[inline(always)]
            fn of_index(index: u16) -> $t {
                <$t>::from_bits(index.into())
            }
            #[inline(always)]
            fn to_index(self) -> usize {
                usize::from(self.to_bits() as u16)
            }
            #[inline(always)]
            fn of_word(word: u32) -> $t {
                <$t>::from_bits(word.into())
            }
            #[inline(always)]
            fn to_word(self) -> u32 {
                self.to_bits() as u32
            }
            #[inline(always)]
            fn sqrt(self) -> $t {
                if self > 0.0 { $root(self) } else { 0.0 }
            }
            #[inline(always)]
            fn root(self) -> $t {
                $root(self)
            }
            #[inline(always)]
            fn roots(squares: [$t; 2]) -> [$t; 2] {
                $roots(squares)
            }
            #[inline(always)]
            fn abs(self) -> $t {
                <$t>::abs(self)
            }
            #[inline(always)]
            fn add_product(self, a: $t, b: $t) -> $t {
                #[cfg(all(feature = "fma", any(target_feature = "fma", target_arch = "aarch64")))]
                return a.mul_add(b, self);
                #[cfg(not(all(feature = "fma", any(target_feature = "fma", target_arch = "aarch64"))))]
                return self + a * b;
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                <$t>::is_finite(self)
            }
            #[inline(always)]
            fn is_in_unit(self) -> bool {
                // Bits ascend with the numbers; negative numbers and NaN are above them.
                self.to_bits() <= <$t>::to_bits(1.0)
            }
        }
    };
}

real!(f64, glam::DVec3, trueaxis_sqrt::sqrt_f64, |squares: [f64; 2]| squares.map(trueaxis_sqrt::sqrt_f64));
real!(f32, glam::Vec3, trueaxis_sqrt::sqrt_f32, trueaxis_sqrt::sqrt_two_f32);
