//! Models of the deviations in a plane, linear in their unknowns.

use trueaxis_metrology::circles::hull;
use trueaxis_metrology::linear_fit::{LinearFit, Solution};
use trueaxis_metrology::volumetric::hats;

/// A point of the plane: u along the first free axis, v along the second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlanePoint {
    pub(super) line: u32,
    /// Commanded position, mm.
    pub(super) at: [f64; 2],
    /// Actual minus commanded position, without the rest of the machine, mm.
    pub(super) off: [f64; 2],
    /// Reciprocal standard uncertainty.
    pub(super) weight: f64,
}

/// A model of the deviations; each contains the placement of the plate.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Model {
    /// The placement alone: two shifts and a rotation.
    Rigid,
    /// A polynomial of this total degree for each direction; degree 1 is affine.
    Map(usize),
    /// A function of u and one of v for each direction, linear between these nodes: four tables. On a line along u, where v has one
    /// node, two tables.
    Tables([Vec<f64>; 2]),
}

impl Model {
    pub(super) fn name(&self) -> String {
        match self {
            Model::Rigid => "placement alone".into(),
            Model::Map(1) => "affine".into(),
            Model::Map(degree) => format!("map of degree {degree}"),
            Model::Tables([u, v]) if v.len() == 1 && u.len() == 2 => "scale".into(),
            Model::Tables([u, v]) if v.len() == 1 => format!("tables of {} nodes", u.len()),
            Model::Tables([u, v]) => format!("tables of {} and {} nodes", u.len(), v.len()),
        }
    }

    /// Number of unknowns of both directions.
    pub(super) fn unknowns(&self) -> usize {
        match self {
            Model::Rigid => 3,
            Model::Map(degree) => (degree + 1) * (degree + 2),
            Model::Tables([u, v]) => 2 * (u.len() + v.len() - 1),
        }
    }

    /// Functions of a position whose combination is the deviation along u or v. `ends`: range of the points.
    pub(super) fn terms(&self, at: [f64; 2], ends: [[f64; 2]; 2]) -> Vec<f64> {
        match self {
            Model::Rigid => vec![1.0, at[0], at[1]],
            Model::Map(degree) => {
                let [u, v] = [0, 1].map(|k| {
                    let [low, high] = ends[k];
                    legendre((2.0 * at[k] - low - high) / (high - low), *degree)
                });
                (0..=*degree).flat_map(|i| v[..=degree - i].iter().map(|q| u[i] * q).collect::<Vec<_>>()).collect()
            }
            Model::Tables(nodes) => {
                let mut terms = vec![0.0; nodes[0].len() + nodes[1].len()];
                for (k, start) in [(0, 0), (1, nodes[0].len())].into_iter().filter(|(k, _)| nodes[*k].len() > 1) {
                    for (node, share) in hats(&nodes[k], at[k]) {
                        terms[start + node] += share;
                    }
                }
                // A constant belongs to the first table: without one node of the second they are independent.
                terms.pop();
                terms
            }
        }
    }
}

/// Legendre polynomials of degree 0 to `degree`: nearly orthogonal over points spread between −1 and 1.
fn legendre(t: f64, degree: usize) -> Vec<f64> {
    let mut values = vec![1.0, t];
    for n in 1..degree {
        let k = n as f64;
        values.push(((2.0 * k + 1.0) * t * values[n] - k * values[n - 1]) / (k + 1.0));
    }
    values
}

/// A model fitted to points.
#[derive(Clone, Debug)]
pub(super) struct Fitted {
    pub(super) model: Model,
    pub(super) ends: [[f64; 2]; 2],
    hull: Vec<[f64; 2]>,
    values: [Vec<f64>; 2],
    /// One direction's solution: both have the same rows, hence the same covariance.
    solution: Solution,
    /// Number of unknowns of both directions that the points determine.
    pub(super) rank: usize,
    /// Standard deviation of a reading of unit weight.
    pub(super) sigma: f64,
    pub(super) degrees_of_freedom: usize,
}

/// Least squares of a model over points.
pub(super) fn fit(model: &Model, ends: [[f64; 2]; 2], points: &[PlanePoint]) -> Fitted {
    let hull = hull(&points.iter().map(|point| point.at).collect::<Vec<_>>());
    let (values, solution, rank, squares) = if *model == Model::Rigid {
        let mut fit = LinearFit::new(3);
        for PlanePoint { at: [u, v], off, weight, .. } in points {
            fit.add(&[1.0, 0.0, -v], off[0], *weight);
            fit.add(&[0.0, 1.0, *u], off[1], *weight);
        }
        let found = fit.solve();
        let [shift_u, shift_v, turn] = [0, 1, 2].map(|k| found.values[k]);
        ([vec![shift_u, 0.0, -turn], vec![shift_v, turn, 0.0]], found.clone(), found.rank, found.squares)
    } else {
        let [u, v] = [0, 1].map(|k| {
            let mut fit = LinearFit::new(model.unknowns() / 2);
            points.iter().for_each(|point| fit.add(&model.terms(point.at, ends), point.off[k], point.weight));
            fit.solve()
        });
        let (rank, squares) = (u.rank + v.rank, u.squares + v.squares);
        ([u.values.clone(), v.values], u, rank, squares)
    };
    let degrees_of_freedom = (2 * points.len()).saturating_sub(rank);
    let sigma = (squares / degrees_of_freedom.max(1) as f64).sqrt();
    Fitted { model: model.clone(), ends, hull, values, solution, rank, sigma, degrees_of_freedom }
}

impl Fitted {
    /// The deviation at a position, mm. Beyond the points affine terms and tables hold the value of their end, and a map that of
    /// the nearest place within the points' convex hull: a polynomial diverges there.
    pub(super) fn at(&self, at: [f64; 2]) -> [f64; 2] {
        self.followed(at, 0.0)
    }

    /// Like [`at`](Fitted::at), with a map followed this far beyond the hull, mm.
    pub(super) fn followed(&self, at: [f64; 2], beyond_mm: f64) -> [f64; 2] {
        let held = match self.model {
            Model::Map(2..) => held(&self.hull, at, beyond_mm),
            Model::Map(_) => [0, 1].map(|k| at[k].clamp(self.ends[k][0], self.ends[k][1])),
            Model::Rigid | Model::Tables(_) => at,
        };
        let terms = self.model.terms(held, self.ends);
        [0, 1].map(|k| product(&terms, &self.values[k]))
    }

    /// A combination of the two strains and the shear of an affine model, and its standard error.
    pub(super) fn strain(&self, [along_u, along_v, shear]: [f64; 3]) -> [f64; 2] {
        let gradient = |k: usize| -> Vec<f64> {
            let [low, high] = self.ends[k];
            let mut at = self.ends.map(|[low, _]| low);
            let from = self.model.terms(at, self.ends);
            at[k] = high;
            let to = self.model.terms(at, self.ends);
            to.iter().zip(from).map(|(to, from)| (to - from) / (high - low)).collect()
        };
        let [over_u, over_v] = [0, 1].map(gradient);
        let sum =
            |one: f64, other: f64| over_u.iter().zip(&over_v).map(|(u, v)| one * u + other * v).collect::<Vec<_>>();
        let [[u, error_u], [v, error_v]] =
            [self.combined(0, &sum(along_u, shear)), self.combined(1, &sum(shear, along_v))];
        [u + v, error_u.hypot(error_v)]
    }

    /// Value of a combination of a direction's unknowns, mm, and its standard error.
    pub(super) fn combined(&self, direction: usize, combination: &[f64]) -> [f64; 2] {
        let variance = product(combination, &self.solution.covariance_with(combination));
        [product(combination, &self.values[direction]), self.sigma * variance.max(0.0).sqrt()]
    }
}

fn product(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| a * b).sum()
}

/// The position itself within the hull or up to `beyond` outside it; otherwise the nearest one that is.
fn held(hull: &[[f64; 2]], at: [f64; 2], beyond: f64) -> [f64; 2] {
    let [u, v] = at;
    let (mut outside, mut nearest, mut distance) = (false, at, f64::INFINITY);
    for (from, to) in hull.iter().zip(hull.iter().cycle().skip(1)) {
        let (along, across) = ([to[0] - from[0], to[1] - from[1]], [u - from[0], v - from[1]]);
        outside |= along[0] * across[1] < along[1] * across[0];
        let share = product(&along, &across) / product(&along, &along);
        let foot = [0, 1].map(|k| from[k] + share.clamp(0.0, 1.0) * along[k]);
        let away = (u - foot[0]).hypot(v - foot[1]);
        if away < distance {
            (nearest, distance) = (foot, away);
        }
    }
    if !outside || distance <= beyond {
        return at;
    }
    [0, 1].map(|k| nearest[k] + beyond / distance * (at[k] - nearest[k]))
}
