//! Forward selection of causes and their lags, with each cycle predicted from the others.

use super::LONGEST_LAG_S;
use super::basis::{Cause, Chosen, Problem};
use super::linear::{Column, predicted};
use crate::cores::*;
use nalgebra::{DMatrix, DVector};
use std::vec;
use std::vec::Vec;
use trueaxis::Axis;

/// A cause enters if it removes this share of the residual sum of squares; a bend or a part on one axis likewise.
const GAIN: f64 = 0.05;
/// Number of the most useful causes that are tried again with all lags free if none enters with the others' lags unchanged.
const AGAIN: usize = 3;
/// Lags of the grid, s: 0 and this many from 30 s to [`LONGEST_LAG_S`], equidistant in the logarithm.
const LAGS: usize = 12;
const SHORTEST_LAG_S: f64 = 30.0;
/// Steps of the golden section between two lags of the grid, to 2 %.
const STEPS: usize = 8;
/// Most Newton steps over all lags once the causes are selected; relative gain below which they end.
const ROUNDS: usize = 24;
const SETTLED: f64 = 1e-6;
/// Difference in a lag's logarithm for the numerical derivatives; largest step.
pub(super) const DIFFERENCE: f64 = 0.02;
const LARGEST_STEP: f64 = 0.5;
/// Dampings tried in a step, each ten times the previous one.
const TRIES: usize = 8;
/// Most rows that the search uses.
const MOST_ROWS: usize = 1_500;

/// Inputs of a search.
pub(super) struct Search<'p, 'r> {
    problem: &'p Problem<'r>,
    rows: Vec<usize>,
    /// Ends of the cycles among the rows.
    cycles: Vec<usize>,
    /// Drift of each axis.
    right: Vec<Vec<f64>>,
    share: f64,
}

/// Parts of a cause on an axis: independent of the lever, and proportional to it.
pub(super) type Parts = [bool; 2];

impl<'p, 'r> Search<'p, 'r> {
    /// Searches over these rows, thinned to about [`MOST_ROWS`].
    pub(super) fn new(problem: &'p Problem<'r>, rows: &[usize]) -> Self {
        // Every n-th row of each measuring point in each cycle.
        let samples = &problem.record.samples;
        let every = rows.len().div_ceil(MOST_ROWS);
        let mut seen = vec![0_usize; problem.groups.len()];
        let kept = rows.iter().copied().filter(|&row| {
            let count = &mut seen[problem.groups[row]];
            *count += 1;
            (*count - 1).is_multiple_of(every)
        });
        let kept: Vec<usize> = kept.collect();
        let share = rows.len() as f64 / kept.len().max(1) as f64;
        let rows = kept;
        let mut cycles = Vec::new();
        for k in 1..rows.len() {
            if samples[rows[k]].cycle != samples[rows[k - 1]].cycle {
                cycles.push(k);
            }
        }
        cycles.push(rows.len());
        let axes = 0..problem.record.axes.len();
        let right = axes.map(|axis| problem.centred(&rows, |row| samples[row].error_mm[axis])).collect();
        Search { problem, rows, cycles, right, share }
    }

    /// Number of given rows per row that the search uses.
    pub(super) fn share(&self) -> f64 {
        self.share
    }

    fn columns(&self, axis: Axis, chosen: &Chosen, parts: Parts) -> Vec<Column> {
        let responses = self.problem.responses(chosen);
        let mut columns = Vec::new();
        for (k, response) in responses.iter().enumerate() {
            let lone = match chosen.cause {
                Cause::Sensor(_) => None,
                Cause::Spindle => self.problem.lone[k + 1],
            };
            if parts[0] {
                columns.push(Column { values: self.problem.centred(&self.rows, |row| response[row]), lone });
            }
            if parts[1] && self.problem.levers(axis, chosen.cause) {
                let lever = |row| response[row] * self.problem.lever(axis, chosen.cause, row);
                columns.push(Column { values: self.problem.centred(&self.rows, lever), lone });
            }
        }
        columns
    }

    /// Residual sum of squares of one axis.
    fn left_of(&self, axis: usize, all: &[Chosen], parts: &[Parts]) -> f64 {
        let name = self.problem.record.axes[axis];
        let columns: Vec<Column> =
            all.iter().zip(parts).flat_map(|(chosen, parts)| self.columns(name, chosen, *parts)).collect();
        predicted(&columns, &self.right[axis], &self.cycles)
    }

    /// Residual sum of squares of all axes.
    fn left(&self, all: &[Chosen]) -> f64 {
        let parts = vec![[true; 2]; all.len()];
        (0..self.right.len()).map(|axis| self.left_of(axis, all, &parts)).sum()
    }

    /// The best lag of cause `which`, on the grid or in `between`, and the residual sum of squares there.
    fn best_lag(&self, all: &[Chosen], which: usize, between: Option<[f64; 2]>) -> (f64, f64) {
        // The columns of the others do not change.
        let parts = [true; 2];
        let kept: Vec<Vec<Column>> = (self.problem.record.axes.iter())
            .map(|axis| {
                let others = all.iter().enumerate().filter(|(k, _)| *k != which);
                others.flat_map(|(_, chosen)| self.columns(*axis, chosen, parts)).collect()
            })
            .collect();
        let at = |lag_s: f64| {
            let chosen = Chosen { lag_s, ..all[which].clone() };
            let axes = self.problem.record.axes.iter().zip(&kept).zip(&self.right);
            axes.map(|((axis, others), right)| {
                let mut columns = self.columns(*axis, &chosen, parts);
                columns.extend(others.iter().cloned());
                predicted(&columns, right, &self.cycles)
            })
            .sum::<f64>()
        };
        let ratio = (LONGEST_LAG_S / SHORTEST_LAG_S).powf(1.0 / (LAGS - 1) as f64);
        let Some([mut low, mut high]) = between else {
            let grid = core::iter::once(0.0).chain((0..LAGS).map(|k| SHORTEST_LAG_S * ratio.powi(k as i32)));
            return grid
                .map(|lag| (lag, at(lag)))
                .fold((0.0, f64::INFINITY), |best, next| if next.1 < best.1 { next } else { best });
        };
        let inner = |low: f64, high: f64| [high / (high / low).powf(0.618_034), low * (high / low).powf(0.618_034)];
        let mut tried = inner(low, high).map(|lag| (lag, at(lag)));
        for _ in 0..STEPS {
            if tried[0].1 < tried[1].1 {
                high = tried[1].0;
                let lag = inner(low, high)[0];
                tried = [(lag, at(lag)), tried[0]];
            } else {
                low = tried[0].0;
                let lag = inner(low, high)[1];
                tried = [tried[1], (lag, at(lag))];
            }
        }
        if tried[0].1 < tried[1].1 { tried[0] } else { tried[1] }
    }

    /// The causes that improve the prediction, in the order in which they entered, and the sum of squares before and after;
    /// calls `on_cause` with each cause.
    pub(super) fn causes(&self, on_cause: &mut dyn FnMut(Cause)) -> (Vec<Chosen>, [f64; 2]) {
        let nothing = self.left(&[]);
        let (mut all, mut left) = (Vec::<Chosen>::new(), nothing);
        loop {
            let missing: Vec<Cause> = self
                .problem
                .causes()
                .into_iter()
                .filter(|cause| all.iter().all(|known| known.cause != *cause))
                .collect();
            let tried = missing.par_iter().map(|cause| {
                let mut all = all.clone();
                all.push(Chosen { cause: *cause, lag_s: 0.0, bends_c: Vec::new() });
                let (lag_s, left) = self.best_lag(&all, all.len() - 1, None);
                (Chosen { lag_s, cause: *cause, bends_c: Vec::new() }, left)
            });
            let mut tried: Vec<(Chosen, f64)> = tried.collect();
            crate::order::sort_by_number(&mut tried, |one| one.1);
            let with = |chosen: &Chosen, all: &[Chosen]| all.iter().chain([chosen]).cloned().collect::<Vec<Chosen>>();
            let enough = |found: f64, left: f64| found < (1.0 - GAIN) * left;
            let found = match tried.first() {
                Some((chosen, found)) if enough(*found, left) => {
                    let mut with = with(chosen, &all);
                    let found = self.refine(&mut with, *found);
                    Some((with, found))
                }
                // No cause enters with the lags unchanged. But it may enter once the causes that acted in its place have other
                // lags. All lags are therefore optimised again, first without the new cause, then with it.
                _ => {
                    left = self.settle(&mut all, left);
                    let again = tried.iter().take(AGAIN).map(|(chosen, _)| {
                        let mut with = with(chosen, &all);
                        let found = self.left(&with);
                        let found = self.settle(&mut with, found);
                        (with, found)
                    });
                    again.min_by(|one, other| one.1.total_cmp(&other.1)).filter(|(_, found)| enough(*found, left))
                }
            };
            let Some((with, found)) = found else { break };
            if let Some(chosen) = with.last() {
                on_cause(chosen.cause);
            }
            (all, left) = (with, found);
        }
        let bent = self.bend(&mut all, left);
        if bent < left {
            left = self.settle(&mut all, bent);
        }
        (all, [nothing, left])
    }

    /// Optimises all lags together until they converge: one at a time they stop on the ridge along which a lag trades off
    /// against another and against the curves.
    ///
    /// Newton's method on the logarithms of the lags with numerical derivatives, damped if it does not descend (Marquardt).
    fn settle(&self, all: &mut [Chosen], mut left: f64) -> f64 {
        left = self.refine(all, left);
        let mut damping = 1e-3;
        let free: Vec<usize> = (0..all.len()).filter(|which| all[*which].lag_s >= SHORTEST_LAG_S).collect();
        let moved = |all: &[Chosen], steps: &[(usize, f64)]| {
            let mut moved = all.to_vec();
            for &(which, step) in steps {
                let lag = &mut moved[which].lag_s;
                *lag = (*lag * step.clamp(-LARGEST_STEP, LARGEST_STEP).exp()).clamp(SHORTEST_LAG_S, LONGEST_LAG_S);
            }
            moved
        };
        let rounds = if free.is_empty() { 0 } else { ROUNDS };
        for _ in 0..rounds {
            let before = left;
            let (gradient, curvature) = Self::derivatives(&free, left, |steps| self.left(&moved(all, steps)));
            for _ in 0..TRIES {
                let damped = &curvature + DMatrix::from_diagonal(&curvature.diagonal().map(|c| damping * c.abs()));
                let step = damped.cholesky().map(|factors| -factors.solve(&gradient));
                let tried = step.map(|step| {
                    let steps: Vec<(usize, f64)> = free.iter().copied().zip(step.iter().copied()).collect();
                    moved(all, &steps)
                });
                let found = tried.as_ref().map_or(f64::INFINITY, |tried| self.left(tried));
                if let Some(tried) = tried.filter(|_| found < left) {
                    all.clone_from_slice(&tried);
                    left = found;
                    damping *= 0.1;
                    break;
                }
                damping *= 10.0;
            }
            if before - left <= SETTLED * left {
                break;
            }
        }
        left
    }

    /// Gradient and Hessian of the residual sum of squares; `at` evaluates it for steps of the lags' logarithms.
    fn derivatives<At: Fn(&[(usize, f64)]) -> f64 + Sync>(
        free: &[usize],
        left: f64,
        at: At,
    ) -> (DVector<f64>, DMatrix<f64>) {
        let count = free.len();
        // Each lag up, each down, and each pair up.
        let pairs: Vec<(usize, usize)> = (0..count).flat_map(|i| (0..=i).map(move |j| (i, j))).collect();
        let up: Vec<f64> = free.par_iter().map(|which| at(&[(*which, DIFFERENCE)])).collect();
        let down: Vec<f64> = free.par_iter().map(|which| at(&[(*which, -DIFFERENCE)])).collect();
        let both: Vec<f64> = (pairs.par_iter())
            .map(|&(i, j)| if i == j { 0.0 } else { at(&[(free[i], DIFFERENCE), (free[j], DIFFERENCE)]) })
            .collect();
        let gradient = DVector::from_fn(count, |i, _| (up[i] - down[i]) / (2.0 * DIFFERENCE));
        let mut curvature = DMatrix::zeros(count, count);
        for (&(i, j), both) in pairs.iter().zip(&both) {
            let second = if i == j { up[i] + down[i] - 2.0 * left } else { both - up[i] - up[j] + left };
            curvature[(i, j)] = second / (DIFFERENCE * DIFFERENCE);
            curvature[(j, i)] = curvature[(i, j)];
        }
        (gradient, curvature)
    }

    /// Refines each lag separately between its neighbours of the grid; returns the residual sum of squares.
    fn refine(&self, all: &mut [Chosen], mut left: f64) -> f64 {
        for which in 0..all.len() {
            let lag = all[which].lag_s.max(10.0);
            let (lag_s, found) = self.best_lag(all, which, Some([lag / 2.0, (2.0 * lag).min(LONGEST_LAG_S)]));
            if found < left {
                all[which].lag_s = lag_s;
                left = found;
            }
        }
        left
    }

    /// Adds bends in the middle of each sensor's range if they improve the prediction.
    fn bend(&self, all: &mut [Chosen], mut left: f64) -> f64 {
        for which in 0..all.len() {
            let Cause::Sensor(sensor) = all[which].cause else { continue };
            let [low, high] = super::span(self.problem.record.readings(sensor));
            let mut bent = all.to_vec();
            bent[which].bends_c = vec![0.5 * (low + high)];
            let found = self.left(&bent);
            if found < (1.0 - GAIN) * left {
                all[which] = bent[which].clone();
                left = found;
            }
        }
        left
    }

    /// Selects the parts of each cause on an axis: removes those that do not improve the prediction, the least useful first.
    pub(super) fn parts(&self, axis: usize, all: &[Chosen]) -> Vec<Parts> {
        let name = self.problem.record.axes[axis];
        let mut parts: Vec<Parts> = all.iter().map(|chosen| [true, self.problem.levers(name, chosen.cause)]).collect();
        let mut left = self.left_of(axis, all, &parts);
        loop {
            let one = (0..all.len()).flat_map(|which| [(which, 0), (which, 1)]);
            let tried = one.filter(|(which, part)| parts[*which][*part]).map(|(which, part)| {
                let mut fewer = parts.clone();
                fewer[which][part] = false;
                (self.left_of(axis, all, &fewer), fewer)
            });
            let best = tried.min_by(|one, other| one.0.total_cmp(&other.0));
            let Some((found, fewer)) = best.filter(|(found, _)| *found <= left * (1.0 + 0.2 * GAIN)) else { break };
            (left, parts) = (left.min(found), fewer);
        }
        parts
    }
}
