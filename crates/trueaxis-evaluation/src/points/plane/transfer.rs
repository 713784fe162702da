//! Whether the terms of one record help another: two plates, or one on two days.

use super::model::{Fitted, Model, PlanePoint, fit};
use super::selection::{mean_square, of_model, square};
use serde::Serialize;
use trueaxis_report::number::significant;

/// Level of the test: the chance of calling terms transferable that do nothing for the other record.
pub const LEVEL: f64 = 0.05;
/// Most halvings of the other record into areas of equally many points.
const HALVINGS: u32 = 4;

/// Result of the test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Transfer {
    /// Name of the other record.
    pub record: String,
    /// Number of its points.
    pub points: usize,
    /// Its deviations after a rigid alignment, root mean square, µm.
    pub before_um: f64,
    /// The same after the terms are subtracted, µm.
    pub after_um: f64,
    /// Held-out residual of the same model fitted to this record itself, µm; null if the record does not determine it.
    pub own_um: Option<f64>,
    /// Number of areas.
    pub areas: usize,
    /// Probability of so large a reduction if the terms do nothing.
    pub p: f64,
    /// Largest p at which the terms count as transferable.
    pub level: f64,
    /// Whether the terms transfer.
    pub transfers: bool,
}

/// Applies the fitted terms to the points of another record, and aligns these rigidly with and without them.
///
/// The test is a permutation of signs: the reductions of the squared residuals are summed over areas, as errors of neighbouring
/// points are alike and only areas are independent. If the terms did nothing, every area could as well have the opposite sign;
/// p is the share of all sign patterns whose sum is at least the observed one.
pub(super) fn test(fitted: &Fitted, points: &[PlanePoint], record: &str) -> Transfer {
    let squares = |points: &[PlanePoint]| -> Vec<f64> {
        let rigid = fit(&Model::Rigid, fitted.ends, points);
        points.iter().map(|point| square(rigid.left(point))).collect()
    };
    let taken_off: Vec<PlanePoint> =
        points.iter().map(|point| PlanePoint { off: fitted.left(point), ..*point }).collect();
    let (before, after) = (squares(points), squares(&taken_off));
    let halvings = HALVINGS.min(points.len().ilog2());
    let areas = areas((0..points.len()).collect(), points, halvings);
    let sums: Vec<f64> = areas
        .iter()
        .map(|area| area.iter().map(|&i| points[i].weight.powi(2) * (before[i] - after[i])).sum())
        .collect();
    let observed: f64 = sums.iter().sum();
    let patterns = 1_u32 << sums.len();
    let rounding = 1e-9 * sums.iter().map(|sum| sum.abs()).sum::<f64>();
    let as_large = (0..patterns).filter(|pattern| {
        let signed = sums.iter().enumerate().map(|(k, sum)| if pattern >> k & 1 == 1 { -sum } else { *sum });
        signed.sum::<f64>() >= observed - rounding
    });
    let p = as_large.count() as f64 / f64::from(patterns);
    let rms = |of: &[f64]| 1e3 * mean_square(points, of.iter().copied()).sqrt();
    let own = of_model(&fitted.model, super::ends(points), points).held_out;
    let own: Option<Vec<f64>> = own.map(|left| left.into_iter().map(square).collect());
    Transfer {
        record: record.into(),
        points: points.len(),
        before_um: rms(&before),
        after_um: rms(&after),
        own_um: own.map(|own| rms(&own)),
        areas: sums.len(),
        p,
        level: LEVEL,
        transfers: p <= LEVEL,
    }
}

/// Areas of equally many points: halved across their longer side, again and again.
fn areas(mut own: Vec<usize>, points: &[PlanePoint], halvings: u32) -> Vec<Vec<usize>> {
    if halvings == 0 {
        return vec![own];
    }
    let side = |k: usize| {
        let [low, high] = crate::points::found::range(own.iter().map(|i| points[*i].at[k]));
        high - low
    };
    let k = usize::from(side(1) > side(0));
    own.sort_by(|a, b| points[*a].at[k].total_cmp(&points[*b].at[k]));
    let rest = own.split_off(own.len() / 2);
    [areas(own, points, halvings - 1), areas(rest, points, halvings - 1)].concat()
}

impl Transfer {
    /// The result in a sentence.
    pub fn sentence(&self) -> String {
        let (verdict, end) =
            if self.transfers { ("transfer", "") } else { ("do not transfer", ": nothing is written") };
        let [before, after] = [self.before_um, self.after_um].map(|um| significant(um, 3));
        format!(
            "the terms {verdict} to {}: they take its residuals from {before} to {after} µm RMS (sign test over {} areas: p {}, \
             needed at most {}){end}",
            self.record,
            self.areas,
            significant(self.p, 2),
            self.level
        )
    }
}
