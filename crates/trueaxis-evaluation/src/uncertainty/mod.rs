//! Uncertainty of the corrected position: the uncertainty of a machine's figures, propagated to the tip.
//!
//! ```text
//! d(q) = Σ_k s_k(q) z_k           z_k of unit variance, independent but for stated coefficients r_kl
//! Σ = Σ_kl r_kl s_k s_lᵀ          share of k in the variance: s_k · Σ_l r_kl s_l, over all
//! s = J_i (a + b (q_i − q_0))     along an axis: scale, temperature, lost motion, scatter of approaches; summed where common
//! s = J_ic √(Σ_j (w_j(q_i) u_j)²) points of a column c of axis i, w_j the derivative of the interpolation
//! s = J_l u                       location errors
//! ```
//!
//! J are the derivatives of the first-order error model (METHODS: the 21 errors and the location errors) with respect to its
//! errors. The model is linear in them, so each derivative is the response to one unit of the error. A seeded Monte Carlo
//! through the exact geometry accompanies this first-order result: it draws machines from the uncertainties, corrects them
//! with the unchanged tables, and subtracts the residual of the stated machine. All axes travel in negative direction, where
//! lost motion has an effect.
//!
//! The result excludes residuals of other origin (levers that nine terms omit, limits).
//!
//! Sources: JCGM 100:2008, 5.1.2; JCGM 101:2008, clause 7; ISO/TR 230-9:2005 for the terms of an instrument.

mod bands;
mod correlated;
mod covariance;
mod document;
pub(crate) mod monte_carlo;
mod options;
mod sensitivity;
mod shown;
pub(crate) mod terms;

pub use bands::{band_factor, expanded};
pub use covariance::{CovarianceDocument, Estimate};
pub use document::{AtPoint, Share, Spread, UncertaintyDocument};
pub use options::Options;
pub use terms::{per_length, reading};

use crate::field::Points;
use crate::field::grid::Grid;
use anyhow::Result;
use document::{at_point, letters};
use sensitivity::Responses;
use serde_json::Map;
use terms::Terms;
use trueaxis::machine::AXES;
use trueaxis_metrology::uncertainty::{Contribution, Covariance};
use trueaxis_tables::Machine;
use trueaxis_tables::uncertainty::Uncertainties;

/// The uncertainty of the corrected position at a point and over the working volume.
///
/// Cost: one evaluation of the model per term and grid point; one geometry of the machine per trial.
///
/// # Errors
/// Nothing stated; options outside their ranges; a machine that the model refuses.
pub fn evaluate(machine: &Machine, stated: &Uncertainties, options: &Options) -> Result<UncertaintyDocument> {
    options.check(machine)?;
    let terms = Terms::new(machine, stated)?;
    let mut grid = Grid::new(machine, Points::Every(options.points))?;
    for ((range, given), points) in grid.range.iter_mut().zip(options.volume_mm).zip(grid.points) {
        if let (Some(given), 2..) = (given, points) {
            *range = given;
        }
    }
    let mut pose = [0.0; AXES];
    for (axis, degrees) in &options.pose_deg {
        pose[axis.index()] = *degrees;
    }
    let mut places: Vec<[f64; AXES]> = (0..grid.count())
        .map(|index| {
            let mut at = pose;
            at[..3].copy_from_slice(&grid.at(index));
            at
        })
        .collect();
    let over_volume = places.len();
    places.extend(options.at);
    let responses = Responses::of(machine, &terms, &places)?;
    let contributions: Vec<Vec<Contribution>> =
        (0..places.len()).map(|place| responses.contributions(machine, &terms, place, &places[place])).collect();
    let covariances: Vec<Covariance> =
        contributions.iter().map(|all| Covariance::of(all, &terms.correlated.terms)).collect();
    let radii: Vec<f64> = covariances.iter().map(|covariance| covariance.radius(options.coverage)).collect();
    let worst = (0..over_volume).max_by(|a, b| radii[*a].total_cmp(&radii[*b])).unwrap_or(0);
    let wanted: Vec<usize> = std::iter::once(worst).chain(options.at.map(|_| over_volume)).collect();
    let drawn_at: Vec<[f64; AXES]> = wanted.iter().map(|place| places[*place]).collect();
    let drawn = monte_carlo::draw(machine, &terms, &drawn_at, options)?;
    let mut found = wanted
        .iter()
        .zip(&drawn)
        .map(|(place, drawn)| at_point(machine, &places[*place], &covariances[*place], drawn, options.coverage));
    let worst_point = found.next().ok_or_else(|| anyhow::anyhow!("found no point, needed a working volume"))?;
    let at = found.next();
    let mut warnings = terms.warnings.clone();
    for point in std::iter::once(&worst_point).chain(&at) {
        warnings.extend(point.disagreement());
    }
    warnings.dedup();
    let volume_mm = machine
        .settings
        .axes
        .iter()
        .filter(|own| !own.axis.is_rotary())
        .map(|own| (own.axis.letter().to_string(), serde_json::json!(grid.range[own.axis.index()])));
    let variance = |covariance: &Covariance| covariance.standard().iter().map(|own| own * own).sum::<f64>();
    let whole: f64 = covariances[..over_volume].iter().map(variance).sum();
    let [nx, ny, _] = grid.points;
    let layer = worst / (nx * ny);
    Ok(UncertaintyDocument {
        machine: machine.settings.name.to_string(),
        confidence_percent: 100.0 * options.coverage,
        tool_mm: machine.settings.tool_mm,
        volume_mm: volume_mm.collect::<Map<_, _>>(),
        pose_deg: letters(machine, &pose, |axis| axis.is_rotary()),
        points: over_volume,
        standard_rms_um: 1e3 * (whole / over_volume as f64).sqrt(),
        worst: worst_point,
        at,
        contributions: document::shares(&terms, &contributions[..over_volume], &contributions[worst]),
        not_stated: terms.not_stated.clone(),
        trials: options.trials,
        seed: options.seed,
        warnings,
        layer: (0..ny).map(|j| (0..nx).map(|i| 1e3 * radii[layer * nx * ny + j * nx + i]).collect()).collect(),
        ranges: grid.range,
        coverage: options.coverage,
        drawn_um: drawn.into_iter().next().unwrap_or_default().iter().map(|d| d.map(|mm| 1e3 * mm)).collect(),
    })
}
