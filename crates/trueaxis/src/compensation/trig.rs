//! Sine and cosine of a nominal rotary pose, and the angle of a direction, without libm.

use crate::real::Real;

/// Cosine and sine of an angle in degrees to 2e-9: accurate enough to rotate errors of micrometres, at half the cost of
/// [`cos_sin_deg`], with the same range and reduction.
#[inline(always)]
pub(super) fn coarse_cos_sin_deg<R: Real>(angle: R) -> (R, R) {
    let (quarter, x) = reduced(angle);
    let z = x * x;
    let [_, s3, s5, s7, s9, ..] = SIN.map(R::of);
    let [c2, c4, c6, c8, c10, ..] = COS.map(R::of);
    let sin = x + x * z * (s3 + z * (s5 + z * (s7 + z * s9)));
    let cos = R::ONE + z * (c2 + z * (c4 + z * (c6 + z * (c8 + z * c10))));
    in_quadrant(quarter, cos, sin)
}

/// Cosine and sine of an angle in degrees.
///
/// Reduced to ±45° by quadrants, then Taylor polynomials to the 16th power: error below 2e-16 plus rounding (f64), one
/// unit in the last place (f32). Range |angle| <= 1e6 degrees. Cost: about 40 instructions; libm needs over a thousand on
/// a single-precision core.
#[inline]
pub fn cos_sin_deg<R: Real>(angle: R) -> (R, R) {
    let (quarter, x) = reduced(angle);
    let z = x * x;
    let series = |coefficients: [f64; 8]| coefficients.into_iter().rev().fold(R::ZERO, |sum, c| sum * z + R::of(c));
    in_quadrant(quarter, R::ONE + z * series(COS), x * series(SIN))
}

/// The nearest multiple of 90 degrees, and the remainder in rad.
#[inline(always)]
fn reduced<R: Real>(angle: R) -> (i32, R) {
    let quarter = (angle * R::of(1.0 / 90.0) + if angle < R::ZERO { -R::HALF } else { R::HALF }).to_i32();
    (quarter, (angle - R::of_i32(quarter) * R::of(90.0)) * R::of(core::f64::consts::PI / 180.0))
}

/// Cosine and sine after `quarter` more quarter turns.
#[inline(always)]
fn in_quadrant<R: Real>(quarter: i32, cos: R, sin: R) -> (R, R) {
    match quarter & 3 {
        0 => (cos, sin),
        1 => (-sin, cos),
        2 => (-cos, -sin),
        _ => (sin, -cos),
    }
}

/// Angle of the point (x, y), −π … π rad; 0 at the origin.
///
/// |t| = smaller/larger is reduced to |t| <= 0.4375 about 0, 1/2 or 1, then t + t³ P(t²) with P the Chebyshev approximation
/// of degree 10 (error below 1e-16 of P): within 1e-15 rad (f64), 3e-7 rad (f32). |x|, |y| below a third of the largest number.
/// Cost: one division and about 60 instructions.
#[inline]
pub fn atan2<R: Real>(y: R, x: R) -> R {
    let steep = y.abs() > x.abs();
    let (low, high) = if steep { (x.abs(), y.abs()) } else { (y.abs(), x.abs()) };
    if high == R::ZERO {
        return R::ZERO;
    }
    let (offset, above, below) = if low * R::of(16.0) < high * R::of(7.0) {
        (0.0, low, high)
    } else if low * R::of(16.0) < high * R::of(11.0) {
        (ATAN_HALF, low * R::TWO - high, high * R::TWO + low)
    } else {
        (core::f64::consts::FRAC_PI_4, low - high, low + high)
    };
    let t = above / below;
    let z = t * t;
    let series = ATAN.into_iter().rev().fold(R::ZERO, |sum, c| sum * z + R::of(c));
    let angle = R::of(offset) + (t + t * z * series);
    let angle = if steep { R::of(core::f64::consts::FRAC_PI_2) - angle } else { angle };
    let angle = if x < R::ZERO { R::of(core::f64::consts::PI) - angle } else { angle };
    if y < R::ZERO { -angle } else { angle }
}

const ATAN_HALF: f64 = 0.463_647_609_000_806_1;
const ATAN: [f64; 11] = [
    -0.333_333_333_333_333_236_18,
    0.199_999_999_999_877_131_11,
    -0.142_857_142_831_383_839_78,
    0.111_111_108_998_216_276_12,
    -0.090_909_001_686_684_516_794,
    0.076_920_867_891_197_352_516,
    -0.066_632_322_368_162_553_807,
    0.058_476_697_567_996_260_574,
    -0.050_336_850_838_998_954_539,
    0.037_818_548_546_414_579_39,
    -0.017_539_916_204_913_773_703,
];
const SIN: [f64; 8] = [
    1.0,
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
];
const COS: [f64; 8] = [
    -1.0 / 2.0,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_libm() {
        let mut worst = 0.0_f64;
        for i in -40_000..40_000 {
            let angle = f64::from(i) * 0.018_37;
            let (c, s) = cos_sin_deg(angle);
            let (lc, ls) = (libm::cos(angle.to_radians()), libm::sin(angle.to_radians()));
            worst = worst.max((c - lc).abs()).max((s - ls).abs());
        }
        // 735 degrees in radians is itself rounded to 1e-15.
        assert!(worst < 2e-15, "{worst:e}");
        assert_eq!(cos_sin_deg(90.0_f64), (0.0, 1.0));
        assert_eq!(cos_sin_deg(-180.0_f32), (-1.0, 0.0));
    }

    #[test]
    fn the_angle_agrees_with_libm() {
        let (mut worst, mut worst_single) = (0.0_f64, 0.0_f64);
        for i in -200_000..=200_000 {
            // The whole circle, distances over nine decades.
            let (turn, reach) = (f64::from(i) * 1.570_9e-5, libm::exp(f64::from(i % 97) * 0.1));
            let (y, x) = (reach * libm::sin(turn), reach * libm::cos(turn));
            worst = worst.max((atan2(y, x) - libm::atan2(y, x)).abs());
            let (y, x) = (y as f32, x as f32);
            let exact = libm::atan2(f64::from(y), f64::from(x));
            worst_single = worst_single.max((f64::from(atan2(y, x)) - exact).abs());
        }
        assert!(worst < 1e-15, "{worst:e}");
        assert!(worst_single < 3e-7, "{worst_single:e}");
        for small in [1e-3, 1e-9, 1e-200] {
            assert!((atan2(small, 1.0_f64) / libm::atan(small) - 1.0).abs() < 4e-16);
        }
        assert_eq!(atan2(0.0, 0.0_f64), 0.0);
        assert_eq!(atan2(0.0, -2.0_f64), core::f64::consts::PI);
        assert_eq!(atan2(-3.0, 0.0_f32), -core::f32::consts::FRAC_PI_2);
        assert!(atan2(f64::NAN, 1.0).is_nan() && atan2(1.0, f64::NAN).is_nan());
    }
}
