//! Sine and cosine of a nominal rotary pose without libm.

use crate::real::Real;

/// Cosine and sine of an angle in degrees.
///
/// Reduced to ±45° by quadrants, then Taylor polynomials to the 16th power: error below 2e-16 plus rounding (f64), one
/// unit in the last place (f32). Range |angle| <= 1e6 degrees. Cost: about 40 instructions where libm's take over a
/// thousand on a single-precision core.
#[inline]
pub fn cos_sin_deg<R: Real>(angle: R) -> (R, R) {
    let quarter = (angle * R::of(1.0 / 90.0) + if angle < R::ZERO { -R::HALF } else { R::HALF }).to_i32();
    let x = (angle - R::of_i32(quarter) * R::of(90.0)) * R::of(core::f64::consts::PI / 180.0);
    let z = x * x;
    let series = |coefficients: [f64; 8]| coefficients.into_iter().rev().fold(R::ZERO, |sum, c| sum * z + R::of(c));
    let sin = x * series(SIN);
    let cos = R::ONE + z * series(COS);
    match quarter & 3 {
        0 => (cos, sin),
        1 => (-sin, cos),
        2 => (-cos, -sin),
        _ => (sin, -cos),
    }
}

/// Angle of the vector (x, y), rad.
#[inline]
pub fn atan2<R: Real>(y: R, x: R) -> R {
    R::of(libm::atan2(y.to_f64(), x.to_f64()))
}

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
}
