//! Squareness and scale from the slopes of the four diagonals.

use super::Test;
use crate::linear_fit::LinearFit;
use std::vec::Vec;

/// A value and its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Term {
    /// The value, rad or 1.
    pub value: f64,
    /// Standard error of the value.
    pub standard_error: f64,
}

/// Results from the four slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Volume {
    /// A0Z, B0Z, C0Y, rad.
    pub squareness: [Term; 3],
    /// u_x² s_x + u_y² s_y + u_z² s_z: the scale along a diagonal without squareness.
    pub scale: Term,
    /// Slopes of the diagonals.
    pub slopes: [Term; 4],
    /// Condition number of the four equations.
    pub condition: f64,
    /// Rank; 4 if all unknowns are determined.
    pub rank: usize,
}

/// Slopes by least squares over the targets on each diagonal, then four equations for four unknowns.
///
/// Standard errors use the larger of the scatter of repeated runs and that of the slopes' residuals.
pub(super) fn volume(test: &Test) -> Volume {
    let slopes = std::array::from_fn(|k| slope(test, k));
    let mut fit = LinearFit::new(4);
    for (own, slope) in test.diagonals.iter().zip(&slopes) {
        let [x, y, z] = own.unit;
        fit.add(&[-y * z, x * z, -x * y, 1.0], slope.value, 1.0);
    }
    let found = fit.solve();
    // The slopes have different weights: variances need the inverse, which for four equations is the solution for unit slopes.
    let term = |unknown: usize| Term { value: found.values[unknown], standard_error: 0.0 };
    let mut terms = [term(0), term(1), term(2), term(3)];
    for k in 0..4 {
        let mut unit = LinearFit::new(4);
        for (i, own) in test.diagonals.iter().enumerate() {
            let [x, y, z] = own.unit;
            unit.add(&[-y * z, x * z, -x * y, 1.0], f64::from(u8::from(i == k)), 1.0);
        }
        for (term, share) in terms.iter_mut().zip(unit.solve().values) {
            term.standard_error = term.standard_error.hypot(share * slopes[k].standard_error);
        }
    }
    let [a0z, b0z, c0y, scale] = terms;
    Volume { squareness: [a0z, b0z, c0y], scale, slopes, condition: found.condition, rank: found.rank }
}

fn slope(test: &Test, k: usize) -> Term {
    let targets: Vec<_> = test.on(k).collect();
    let mut fit = LinearFit::new(2);
    for target in &targets {
        fit.add(&[1.0, target.along_mm], target.mean(), 1.0);
    }
    let found = fit.solve();
    let runs = test.readings.iter().filter(|reading| reading.diagonal == k).count() as f64;
    let per_target = (runs / test.diagonals[k].targets.len() as f64).max(1.0);
    let repeats = test.sigma_mm.map_or(0.0, |sigma| sigma / per_target.sqrt());
    Term { value: found.values[1], standard_error: found.error_factors[1] * found.sigma().max(repeats) }
}
