//! Fit of a ball to touches.

use super::CalibrationRefusal;
use super::network::{Network, Unknown};
use super::surface::{Surface, Touch};
use std::vec::Vec;

/// A ball's centre, and the sum of its radius and the tip's.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BallFit {
    /// Centre, mm.
    pub centre_mm: [f64; 3],
    /// Standard errors of the centre, mm.
    pub standard_errors_mm: [f64; 3],
    /// Sum of the ball's radius and the tip's effective radius, mm.
    pub radius_mm: f64,
    /// Standard error of that sum, mm; 0 if the sum is known.
    pub radius_standard_error_mm: f64,
    /// Standard deviation of a touch, mm.
    pub sigma_mm: f64,
    /// Residual of each touch, mm, positive outside.
    pub residuals_mm: Vec<f64>,
    /// Condition number of the scaled columns.
    pub condition: f64,
}

/// Fits a ball to centres of the tip: min Σ (|p − c| − ρ)².
///
/// `near_mm`: approximate centre; `radius_mm`: initial ρ, the sum of the ball's radius and the tip's; `known`: whether this ρ
/// is exact. `repeatability_mm`: stated standard deviation of a touch, used for the standard errors unless the touches exceed
/// the unknowns by at least 20. Cost: some microseconds per touch.
///
/// # Errors
/// Fewer than three touches (four if ρ is unknown), or touches that leave a direction undetermined.
pub fn fit_ball(
    points_mm: &[[f64; 3]],
    near_mm: [f64; 3],
    radius_mm: f64,
    known: bool,
    repeatability_mm: f64,
) -> Result<BallFit, CalibrationRefusal> {
    let free = |start| Unknown { start, uncertainty: None };
    let exact = |start| Unknown { start, uncertainty: Some(1e-9) };
    let [x, y, z] = near_mm;
    let radius = if known { exact(2.0 * radius_mm) } else { free(2.0 * radius_mm) };
    let unknowns = Vec::from([free(x), free(y), free(z), radius, exact(0.0)]);
    let surface = Surface::Ball { diameter: 3, origin: 0, offset: [0.0; 3], turn: None, own: None, length: None };
    let touches = points_mm.iter().map(|&tip_mm| Touch {
        tip_mm,
        surface: surface.clone(),
        response: Vec::new(),
        drift: Vec::new(),
        own_tip: None,
        weight: 1.0,
    });
    let touches = touches.collect();
    let found = Network { unknowns, terms: 0, tip: 4, touches, repeatability_mm }.solve()?;
    Ok(BallFit {
        centre_mm: std::array::from_fn(|k| found.values[k]),
        standard_errors_mm: std::array::from_fn(|k| found.standard_errors[k]),
        radius_mm: 0.5 * found.values[3],
        radius_standard_error_mm: if known { 0.0 } else { 0.5 * found.standard_errors[3] },
        sigma_mm: found.sigma_mm,
        residuals_mm: found.residuals_mm,
        condition: found.condition,
    })
}
