//! The low-pass Q: Gaussian and symmetric, so zero-phase.

use std::vec::Vec;

/// Returns the transmission of a wavelength: Q(λ) = 2^−(λ_c/λ)², one half at the cut-off, as in ISO 16610-21.
pub fn transmission(wavelength: f64, cutoff: f64) -> f64 {
    let ratio = cutoff / wavelength;
    libm::exp2(-ratio * ratio)
}

/// Filters each direction of a series of values `spacing` apart; the series is zero beyond its ends.
///
/// The weights are `exp(−π² x²/(ln 2 λ_c²))` up to one cut-off on either side, where they have fallen to 10⁻⁶, normalized. A
/// sum, unlike a transform, does not wrap around at the ends, and takes the same time for each node.
pub fn low_pass(values: &[[f64; 3]], spacing: f64, cutoff: f64) -> Vec<[f64; 3]> {
    let reach = (cutoff / spacing).floor() as usize;
    let weight = |k: usize| {
        let x = core::f64::consts::PI * k as f64 * spacing / cutoff;
        libm::exp(-x * x / core::f64::consts::LN_2)
    };
    let side: Vec<f64> = (1..=reach).map(weight).collect();
    let total = 1.0 + 2.0 * side.iter().sum::<f64>();
    let at = |k: Option<usize>| k.and_then(|k| values.get(k)).copied().unwrap_or_default();
    let filtered = |k: usize| {
        let mut sum = at(Some(k));
        for (weight, away) in side.iter().zip(1..) {
            let (before, after) = (at(k.checked_sub(away)), at(k.checked_add(away)));
            for ((sum, before), after) in sum.iter_mut().zip(before).zip(after) {
                *sum += weight * (before + after);
            }
        }
        sum.map(|sum| sum / total)
    };
    (0..values.len()).map(filtered).collect()
}
