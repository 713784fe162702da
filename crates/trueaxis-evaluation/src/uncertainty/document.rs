//! Uncertainty of the corrected position, as a document.

use super::terms::Terms;
use serde::Serialize;
use serde_json::{Map, Value};
use trueaxis::machine::{AXES, Axis};
use trueaxis_metrology::uncertainty::{Contribution, Covariance, half_width};
use trueaxis_tables::Machine;

/// Difference above which the document reports that the two methods disagree: a share of the radius, plus a length that no
/// instrument resolves, µm.
const DIFFERENCE: f64 = 0.05;
const NOTHING_UM: f64 = 0.01;

/// The JSON document.
#[derive(Clone, Debug, Serialize)]
pub struct UncertaintyDocument {
    /// Name of the machine.
    pub machine: String,
    /// Requested coverage.
    pub confidence_percent: f64,
    /// Tip from the last tool-side frame.
    pub tool_mm: [f64; 3],
    /// Ends of the working volume by letter.
    pub volume_mm: Map<String, Value>,
    /// Positions of the rotary axes over the working volume.
    pub pose_deg: Map<String, Value>,
    /// Number of grid points over the working volume.
    pub points: usize,
    /// Root mean square over the grid of the standard uncertainty of the position, √tr Σ.
    pub standard_rms_um: f64,
    /// The point with the largest radius.
    pub worst: AtPoint,
    /// The requested position.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<AtPoint>,
    /// Contributions, largest share first.
    pub contributions: Vec<Share>,
    /// Keys that are not stated and count as zero.
    pub not_stated: Vec<String>,
    /// Number of machines drawn for the check.
    pub trials: usize,
    /// Seed of the draws.
    pub seed: u64,
    /// Remarks on the result.
    pub warnings: Vec<String>,
    /// Radii in the plane of X and Y through the worst point, µm: rows along Y.
    #[serde(skip)]
    pub layer: Vec<Vec<f64>>,
    /// Low and high end of X, Y, Z, mm.
    #[serde(skip)]
    pub ranges: [[f64; 2]; 3],
    /// Coverage, 0 … 1.
    #[serde(skip)]
    pub coverage: f64,
    /// Deviations drawn at the worst point, µm.
    #[serde(skip)]
    pub drawn_um: Vec<[f64; 3]>,
}

/// Uncertainty of the corrected position at a point, by both methods.
#[derive(Clone, Debug, Serialize)]
pub struct AtPoint {
    /// Position by letter, mm and degrees.
    pub at: Map<String, Value>,
    /// First-order result, from the derivatives.
    pub jacobian: Spread,
    /// Result from the machines drawn.
    pub monte_carlo: Spread,
    /// Radius from the machines drawn over the first-order radius, minus 1.
    pub difference: f64,
}

/// Spread of the position along X, Y, Z in machine directions.
#[derive(Clone, Debug, Serialize)]
pub struct Spread {
    /// Standard uncertainties.
    pub standard_um: [f64; 3],
    /// Coverage factors; null for the machines drawn.
    pub factor: Option<[f64; 3]>,
    /// Effective degrees of freedom; null if infinite.
    pub degrees_of_freedom: Option<[Option<f64>; 3]>,
    /// Expanded uncertainties: half-widths of intervals of the requested coverage.
    pub expanded_um: [f64; 3],
    /// Radius of the sphere that contains the position with that coverage.
    pub radius_um: f64,
}

/// Contribution of a quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Share {
    /// Name of the quantity.
    pub term: String,
    /// Root mean square over the working volume of its contribution to the standard uncertainty, by itself.
    pub rms_um: f64,
    /// Share of the variance over the working volume: of a correlated quantity with half of what it has in common with each
    /// other one, which may be negative. All shares add up to 1.
    pub share: f64,
    /// Contribution at the worst point, by itself.
    pub worst_um: f64,
}

/// Number of steps of a distribution.
const STEPS: usize = 100;

impl UncertaintyDocument {
    /// Distances of the tip from its ideal place at the worst point, µm, for the machines drawn: the smallest, the largest,
    /// and those between in steps of a hundredth of the machines.
    pub fn distances_um(&self) -> Vec<f64> {
        let mut all: Vec<f64> = self.drawn_um.iter().map(|[x, y, z]| (x * x + y * y + z * z).sqrt()).collect();
        all.sort_unstable_by(f64::total_cmp);
        let last = all.len().saturating_sub(1);
        (0..=STEPS).filter_map(|step| all.get(step * last / STEPS).copied()).collect()
    }
}

/// Positions by letter.
pub(super) fn letters(machine: &Machine, at: &[f64; AXES], keep: impl Fn(Axis) -> bool) -> Map<String, Value> {
    let axes = machine.settings.step_axes().filter(|axis| keep(*axis));
    axes.map(|axis| (axis.letter().to_string(), Value::from(at[axis.index()]))).collect()
}

pub(super) fn at_point(
    machine: &Machine,
    at: &[f64; AXES],
    covariance: &Covariance,
    drawn: &[[f64; 3]],
    coverage: f64,
) -> AtPoint {
    let (standard, factor) = (covariance.standard(), covariance.factors(coverage));
    let jacobian = Spread {
        standard_um: standard.map(|mm| 1e3 * mm),
        factor: Some(factor),
        degrees_of_freedom: Some(covariance.degrees_of_freedom.map(|nu| nu.is_finite().then_some(nu))),
        expanded_um: std::array::from_fn(|i| 1e3 * factor[i] * standard[i]),
        radius_um: 1e3 * covariance.radius(coverage),
    };
    let count = drawn.len().max(1) as f64;
    let root = |i: usize| (drawn.iter().map(|d| d[i] * d[i]).sum::<f64>() / count).sqrt();
    let monte_carlo = Spread {
        standard_um: std::array::from_fn(|i| 1e3 * root(i)),
        factor: None,
        degrees_of_freedom: None,
        expanded_um: std::array::from_fn(|i| 1e3 * half_width(drawn.iter().map(|d| d[i]), coverage)),
        radius_um: 1e3 * half_width(drawn.iter().map(|[x, y, z]| (x * x + y * y + z * z).sqrt()), coverage),
    };
    let difference = monte_carlo.radius_um / jacobian.radius_um.max(f64::MIN_POSITIVE) - 1.0;
    AtPoint { at: letters(machine, at, |_| true), jacobian, monte_carlo, difference }
}

impl AtPoint {
    /// The position as text.
    pub fn place(&self) -> String {
        let parts = self.at.iter().map(|(letter, value)| format!("{letter} {value}"));
        parts.collect::<Vec<_>>().join(", ")
    }

    /// A sentence if the two methods disagree.
    pub(super) fn disagreement(&self) -> Option<String> {
        let [first, drawn] = [&self.jacobian, &self.monte_carlo].map(|spread| spread.radius_um);
        let differs = (drawn - first).abs() > DIFFERENCE * first + NOTHING_UM;
        differs.then(|| {
            format!(
                "at {} the methods differ: {first:.3} µm by derivatives, {drawn:.3} µm by machines drawn. Trust the second: \
                 it includes few degrees of freedom, cosine errors and products of errors",
                self.place()
            )
        })
    }
}

pub(super) fn shares(terms: &Terms, volume: &[Vec<Contribution>], worst: &[Contribution]) -> Vec<Share> {
    let variance = |term: usize| volume.iter().filter_map(|all| all.get(term)).map(Contribution::variance).sum::<f64>();
    let variances: Vec<f64> = (0..terms.all.len()).map(variance).collect();
    let parts = parts(terms, volume);
    let whole: f64 = parts.iter().sum();
    let mut shares: Vec<Share> = terms
        .all
        .iter()
        .zip(variances.into_iter().zip(parts))
        .zip(worst)
        .map(|((term, (variance, part)), worst)| Share {
            term: term.name.clone(),
            rms_um: 1e3 * (variance / volume.len().max(1) as f64).sqrt(),
            share: if whole > 0.0 { part / whole } else { 0.0 },
            worst_um: 1e3 * worst.variance().sqrt(),
        })
        .collect();
    trueaxis_metrology::order::sort_by_number(&mut shares, |one| -one.share);
    shares
}

/// Parts of all terms in the variance: s · Σ r s.
fn parts(terms: &Terms, volume: &[Vec<Contribution>]) -> Vec<f64> {
    let mut parts = vec![0.0; terms.all.len()];
    for all in volume {
        for along in 0..3 {
            let own: Vec<f64> = all.iter().map(|one| one.vector[along]).collect();
            let common = terms.correlated.terms.times(&own);
            parts.iter_mut().zip(own.iter().zip(common)).for_each(|(part, (own, common))| *part += own * common);
        }
    }
    parts
}
