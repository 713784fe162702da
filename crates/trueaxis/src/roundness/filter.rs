//! Gaussian filter of ISO 16610-21, applied by harmonics.

use crate::error::{ConfigError, Field};

/// Cut-offs listed in ISO 12181-2, undulations per revolution.
pub const CUT_OFFS: [u16; 4] = [15, 50, 150, 500];

/// Transmission of harmonic k: H(k) = 2^−(k/k_c)², one half at the cut-off k_c.
pub fn transmission(harmonic: usize, cut_off: u16) -> f64 {
    let ratio = harmonic as f64 / f64::from(cut_off);
    libm::exp2(-ratio * ratio)
}

/// Whether N points satisfy ISO 12181-2, which requires seven points per undulation at the cut-off: N >= 7 k_c.
pub fn has_enough_points(points: usize, cut_off: u16) -> bool {
    points >= 7 * usize::from(cut_off)
}

/// Refuses any cut-off that is not in [`CUT_OFFS`].
///
/// # Errors
/// Any other cut-off.
pub fn check(cut_off: u16) -> Result<(), ConfigError> {
    if CUT_OFFS.contains(&cut_off) {
        return Ok(());
    }
    Err(ConfigError::new(Field::Filter, f64::from(cut_off), "a cut-off of 15, 50, 150 or 500 UPR"))
}
