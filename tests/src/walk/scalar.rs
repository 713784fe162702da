//! Scalars and positions in the form that the walk compares and draws.

use super::dice::Dice;
use trueaxis::{Nanometres, Position, Real};

/// A scalar that exposes its bits.
pub(super) trait Scalar: Real {
    /// The stored bits.
    fn bits(self) -> u64;
}

impl Scalar for f64 {
    #[inline(always)]
    fn bits(self) -> u64 {
        self.to_bits()
    }
}

impl Scalar for f32 {
    #[inline(always)]
    fn bits(self) -> u64 {
        u64::from(self.to_bits())
    }
}

/// A position that exposes its bits and can be drawn with invalid values.
pub(super) trait Place: Position {
    /// Step of integer positions, mm (deg); 0 for doubles.
    const GRAIN: f64;
    /// The stored bits.
    fn bits(self) -> u64;
    /// Any value: ends of the range, NaN, subnormal and random bits.
    fn wild(dice: &mut Dice) -> Self;
}

impl Place for f64 {
    const GRAIN: f64 = 0.0;
    #[inline(always)]
    fn bits(self) -> u64 {
        self.to_bits()
    }
    fn wild(dice: &mut Dice) -> f64 {
        const WILD: [f64; 14] = [
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            1e308,
            -1e308,
            f64::MAX,
            f64::MIN_POSITIVE / 4.0,
            -5e-324,
            -0.0,
            1e9,
            -1.000_000_1e9,
            999_999_999.5,
            -2147.5,
            4_294_967_296.0,
        ];
        if dice.one_in(4) { f64::from_bits(dice.bits()) } else { dice.one_of(&WILD) }
    }
}

impl Place for Nanometres {
    const GRAIN: f64 = 1e-6;
    #[inline(always)]
    fn bits(self) -> u64 {
        u64::from(self.0 as u32)
    }
    fn wild(dice: &mut Dice) -> Nanometres {
        const WILD: [i32; 8] = [i32::MIN, i32::MIN + 1, i32::MIN + 2, i32::MAX, i32::MAX - 1, i32::MAX - 2, 0, -1];
        Nanometres(if dice.one_in(4) { dice.bits() as i32 } else { dice.one_of(&WILD) })
    }
}
