//! Comparison of the models by their predictions of held-out points.

use super::Lie;
use super::model::{Fitted, Model, PlanePoint, fit};
use trueaxis_metrology::order::ascending;
use trueaxis_metrology::uncertainty::Draws;

/// Number of parts; each is predicted by a fit to the others.
const FOLDS: usize = 10;
/// Highest degree of a map.
const MOST_DEGREE: usize = 8;
/// Numbers of evenly spaced nodes that are tried for the tables.
const NODES: [usize; 7] = [3, 5, 7, 9, 11, 15, 21];
/// Most levels of the points that become nodes.
const MOST_LEVELS: usize = 41;

/// A model with its fit and its predictions of held-out points.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub(super) fitted: Fitted,
    /// Residual of every point in the fit to the other parts, mm; `None` if the points do not determine the model.
    pub(super) held_out: Option<Vec<[f64; 2]>>,
}

/// Mean of the squared lengths over the points, by their weights.
pub(super) fn mean_square(points: &[PlanePoint], of: impl Iterator<Item = f64>) -> f64 {
    let weights: f64 = points.iter().map(|point| point.weight.powi(2)).sum();
    points.iter().zip(of).map(|(point, value)| point.weight.powi(2) * value).sum::<f64>() / weights
}

pub(super) fn square([u, v]: [f64; 2]) -> f64 {
    u * u + v * v
}

/// Part of every point. The parts are drawn at random, by a fixed seed in the order of the positions: the result does not
/// depend on the order of the rows, and no part is a whole row of a lattice. Each part is spread over the whole plate, as
/// the correction is used between the measured points and not beyond them.
fn parts(points: &[PlanePoint]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|a, b| {
        let [a, b] = [a, b].map(|i| points[*i].at);
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
    });
    let mut draws = Draws::new(1, 0);
    let drawn: Vec<f64> = order.iter().map(|_| draws.normal()).collect();
    let mut parts = vec![0; points.len()];
    for (rank, at) in ascending(&drawn).into_iter().enumerate() {
        parts[order[at]] = rank % FOLDS.min(points.len());
    }
    parts
}

/// Residuals of points that each fit lacks.
fn held_out(model: &Model, ends: [[f64; 2]; 2], points: &[PlanePoint], parts: &[usize]) -> Vec<[f64; 2]> {
    let mut left = vec![[0.0; 2]; points.len()];
    for part in 0..FOLDS {
        let kept = points.iter().zip(parts).filter(|(_, own)| **own != part).map(|(point, _)| *point);
        let fitted = fit(model, ends, &kept.collect::<Vec<_>>());
        for ((left, point), _) in left.iter_mut().zip(points).zip(parts).filter(|(_, own)| **own == part) {
            *left = fitted.left(point);
        }
    }
    left
}

impl Fitted {
    /// Residual of a point, mm.
    pub(super) fn left(&self, point: &PlanePoint) -> [f64; 2] {
        let model = self.at(point.at);
        [0, 1].map(|k| point.off[k] - model[k])
    }
}

/// Fits a model and predicts the held-out points by it.
pub(super) fn candidate(model: &Model, ends: [[f64; 2]; 2], points: &[PlanePoint], parts: &[usize]) -> Candidate {
    let fitted = fit(model, ends, points);
    let determined = fitted.rank == model.unknowns() && fitted.degrees_of_freedom > 0;
    Candidate { held_out: determined.then(|| held_out(model, ends, points, parts)), fitted }
}

/// All models that the points may determine; `nodes`: numbers of nodes of the tables, instead of those that are tried.
fn models(points: &[PlanePoint], ends: [[f64; 2]; 2], lie: Lie, nodes: Option<[usize; 2]>) -> Vec<Model> {
    let even = |counts: [usize; 2]| {
        [0, 1].map(|k| {
            let ([low, high], cells) = (ends[k], (counts[k] - 1) as f64);
            (0..counts[k]).map(|node| low + (high - low) * node as f64 / cells).collect::<Vec<f64>>()
        })
    };
    let levels = [0, 1].map(|k| {
        let mut levels: Vec<f64> = points.iter().map(|point| point.at[k]).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup_by(|next, kept| *next - *kept < 1e-6 * (ends[k][1] - ends[k][0]));
        levels
    });
    let mut models = vec![Model::Rigid];
    match lie {
        Lie::Plane(_) => models.extend((1..=MOST_DEGREE).map(Model::Map)),
        Lie::Line(_) => models.push(Model::Tables(even([2; 2]))),
        // Tables and maps belong to axes.
        Lie::Inclined(..) => return vec![Model::Rigid, Model::Map(1)],
    }
    match nodes {
        Some(counts) => models.push(Model::Tables(even(counts))),
        None => {
            models.extend(NODES.map(|count| Model::Tables(even([count; 2]))));
            if levels.iter().all(|levels| levels.len() <= MOST_LEVELS) {
                models.push(Model::Tables(levels));
            }
        }
    }
    if let Lie::Line(_) = lie {
        for model in &mut models {
            if let Model::Tables([_, across]) = model {
                across.truncate(1);
            }
        }
    }
    // With fewer than two readings for an unknown a fit follows the noise.
    models.retain(|model| model.unknowns() <= points.len());
    models
}

/// All models with their predictions, and the index of the chosen one: the fewest unknowns of those whose mean square exceeds
/// the smallest by no more than one standard error of the difference. With the same points predicted by both, most of the
/// scatter cancels in that difference.
///
/// Source: T. Hastie, R. Tibshirani, J. Friedman, *The Elements of Statistical Learning*, 7.10 (one-standard-error rule).
pub(super) fn select(
    points: &[PlanePoint],
    ends: [[f64; 2]; 2],
    lie: Lie,
    nodes: Option<[usize; 2]>,
) -> (Vec<Candidate>, Option<usize>) {
    let parts = parts(points);
    let all: Vec<Candidate> =
        models(points, ends, lie, nodes).iter().map(|model| candidate(model, ends, points, &parts)).collect();
    let squares: Vec<Option<Vec<f64>>> =
        all.iter().map(|of| Some(of.held_out.as_ref()?.iter().copied().map(square).collect())).collect();
    let mean = |of: &[f64]| mean_square(points, of.iter().copied());
    let best = squares.iter().flatten().min_by(|a, b| mean(a).total_cmp(&mean(b)));
    let within = |of: &[f64], best: &[f64]| {
        let excess: Vec<f64> = of.iter().zip(best).map(|(one, other)| one - other).collect();
        let mean = mean(&excess);
        let variance = mean_square(points, excess.iter().map(|value| (value - mean).powi(2)));
        mean <= (variance / points.len() as f64).sqrt()
    };
    let chosen = best.and_then(|best| {
        let near = (0..all.len()).filter(|i| squares[*i].as_ref().is_some_and(|own| within(own, best)));
        near.min_by_key(|i| all[*i].fitted.model.unknowns())
    });
    (all, chosen)
}

/// The chosen model for these points alone, fitted and predicted: what `own` terms would leave.
pub(super) fn of_model(model: &Model, ends: [[f64; 2]; 2], points: &[PlanePoint]) -> Candidate {
    candidate(model, ends, points, &parts(points))
}
