//! Limits of a correction in the units of a sample.

use serde::Serialize;
use trueaxis::machine::AxisSettings;

/// Limits of an axis' correction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CorrectionLimits {
    /// Largest correction, µm (rotary: µrad).
    pub magnitude: f64,
    /// Largest rate of change, mm/s (mrad/s).
    pub slope: f64,
    /// Largest acceleration, m/s² (rad/s²).
    pub acceleration: f64,
}

impl CorrectionLimits {
    /// The limits of an axis.
    pub fn of(axis: &AxisSettings) -> CorrectionLimits {
        // mm to µm, mm/s, m/s²; degrees to µrad, mrad/s, rad/s².
        let one = if axis.axis.is_rotary() { 1e3_f64.to_radians() } else { 1.0 };
        CorrectionLimits {
            magnitude: axis.limits.magnitude * one * 1e3,
            slope: axis.limits.slope_per_s * one,
            acceleration: axis.limits.acceleration_per_s2 * one * 1e-3,
        }
    }
}
