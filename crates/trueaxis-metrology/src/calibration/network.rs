//! The network of all touches.

use super::CalibrationRefusal;
use super::least_squares::{Solved, solve};
use super::surface::{Row, Touch, dot};
use nalgebra::{DMatrix, DVector};
use std::vec::Vec;

/// Most steps of the iteration; positions that are a millimetre off converge in four.
const STEPS: usize = 12;
/// A step below this, mm or rad, ends the iteration.
const SETTLED: f64 = 1e-10;
/// Largest residual of a touch, mm, for which the iteration counts as converged.
const OFF: f64 = 1.0;
/// Lower bound on the repeatability found, mm.
const LEAST: f64 = 1e-9;
/// Degrees of freedom from which the repeatability found replaces the stated one.
const POOLED: f64 = 20.0;
/// Most poolings: weights change the residuals, and the residuals change the weights.
const POOLINGS: usize = 4;
/// Relative change of the repeatability below which pooling ends.
const SAME: f64 = 0.01;

/// A quantity that is unknown, or known within an uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unknown {
    /// Initial value, mm, rad or 1; with an uncertainty, the known value.
    pub start: f64,
    /// Standard uncertainty of that value; `None` for an initial value only.
    pub uncertainty: Option<f64>,
}

/// Touches, and the unknowns of machine, probe and artefacts.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    /// All unknowns, the terms of the machine first.
    pub unknowns: Vec<Unknown>,
    /// Number of machine terms among them.
    pub terms: usize,
    /// Index of the radius of the tip, except that of touches with their own.
    pub tip: usize,
    /// The touches.
    pub touches: Vec<Touch>,
    /// Stated standard deviation of a touch, mm.
    pub repeatability_mm: f64,
}

/// Solution of the network.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Solution {
    /// Values of all unknowns.
    pub values: Vec<f64>,
    /// Standard errors of the values.
    pub standard_errors: Vec<f64>,
    /// Covariance of the terms of the machine, row by row.
    pub covariance: Vec<Vec<f64>>,
    /// Residual of each touch, mm, positive outside the surface.
    pub residuals_mm: Vec<f64>,
    /// Standard deviation of a touch, from the residuals, mm.
    pub sigma_mm: f64,
    /// Number of touches − unknowns, counting each unknown as far as the touches determine it: the basis of
    /// [`Solution::sigma_mm`].
    pub degrees_of_freedom: usize,
    /// Condition number of the scaled columns.
    pub condition: f64,
    /// Number of unknowns, all of which are determined.
    pub rank: usize,
    /// Root mean square of the touches' movement across their surfaces due to the terms, mm.
    pub signal_mm: f64,
}

/// What the terms of a network show of other quantities.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// Terms (rows) per unit of each quantity (columns).
    pub design: Vec<Vec<f64>>,
    /// Covariance of the terms, row by row.
    pub covariance: Vec<Vec<f64>>,
}

impl Solution {
    /// Degrees of freedom of the standard errors: infinite where these follow from the stated repeatability, below 20 of
    /// [`Solution::degrees_of_freedom`].
    pub fn error_degrees_of_freedom(&self) -> f64 {
        let of_residuals = self.degrees_of_freedom as f64;
        if of_residuals < POOLED { f64::INFINITY } else { of_residuals }
    }
}

impl Network {
    /// Solves for all unknowns.
    ///
    /// Touches are weighted by the repeatability, which is pooled from the residuals once these have 20 degrees of freedom;
    /// known sizes are weighted by their uncertainty. Cost: a QR of touches × unknowns per step, usually four steps; from 200
    /// unknowns on, those in few touches are eliminated first, and the QR is one of the others.
    ///
    /// # Errors
    /// [`CalibrationRefusal`].
    pub fn solve(&self) -> Result<Solution, CalibrationRefusal> {
        self.weighed(POOLED, LEAST)
    }

    /// Solves with the stated repeatability, for planned touches: their residuals are rounding and say nothing about the
    /// probe. Cost as [`Network::solve`].
    ///
    /// # Errors
    /// [`CalibrationRefusal`].
    pub fn foresee(&self) -> Result<Solution, CalibrationRefusal> {
        self.weighed(f64::INFINITY, LEAST)
    }

    /// Combinations of unknowns that the touches leave free at the start values, also with fewer touches than unknowns; as in
    /// [`CalibrationRefusal::NotApart`].
    pub fn free(&self) -> Vec<Vec<(usize, f64)>> {
        let start: Vec<f64> = self.unknowns.iter().map(|unknown| unknown.start).collect();
        match self.step(&start, self.repeatability_mm, None) {
            Err(CalibrationRefusal::NotApart { combinations }) => combinations,
            _ => Vec::new(),
        }
    }

    /// Like [`Network::solve`], but never below the stated repeatability: touches that happen to agree must not make anything
    /// more significant.
    pub(super) fn solve_with_care(&self) -> Result<Solution, CalibrationRefusal> {
        self.weighed(POOLED, self.repeatability_mm)
    }

    /// Solves; from `pooled` degrees of freedom on with the repeatability found, but not below `least`, mm.
    fn weighed(&self, pooled: f64, least: f64) -> Result<Solution, CalibrationRefusal> {
        let known = self.unknowns.iter().filter(|unknown| unknown.uncertainty.is_some()).count();
        let count = self.unknowns.len();
        if self.touches.len() + known < count {
            return Err(CalibrationRefusal::TooFew { found: self.touches.len(), needed: count - known });
        }
        let whole = |touch: &Touch| touch.tip_mm.iter().chain(touch.response.iter().flatten()).all(|v| v.is_finite());
        if let Some(touch) = self.touches.iter().position(|touch| !whole(touch)) {
            return Err(CalibrationRefusal::NotFinite { touch });
        }
        let mut values: Vec<f64> = self.unknowns.iter().map(|unknown| unknown.start).collect();
        let mut sigma = self.repeatability_mm;
        let mut solved = self.settle(&mut values, sigma, None)?;
        let mut residuals = self.residuals(&values);
        let mut redundancy = self.redundancy(&solved);
        for pooling in 0..POOLINGS {
            if redundancy < pooled {
                break;
            }
            let squares: f64 = residuals.iter().map(|residual| residual * residual).sum();
            let found = (squares / redundancy).sqrt().max(least);
            if pooling > 0 && (found / sigma - 1.0).abs() < SAME {
                break;
            }
            sigma = found;
            solved = self.settle(&mut values, sigma, Some(solved.condition))?;
            residuals = self.residuals(&values);
            redundancy = self.redundancy(&solved);
        }
        let deviation = |index: usize| solved.covariance[(index, index)].max(0.0).sqrt();
        let terms = 0..self.terms;
        Ok(Solution {
            signal_mm: self.signal(&values),
            standard_errors: (0..count).map(deviation).collect(),
            covariance: terms
                .clone()
                .map(|row| terms.clone().map(|column| solved.covariance[(row, column)]).collect())
                .collect(),
            values,
            residuals_mm: residuals,
            sigma_mm: sigma,
            degrees_of_freedom: redundancy.max(0.0).round() as usize,
            condition: solved.condition,
            rank: count,
        })
    }

    /// What the solution's terms would show of other movements of the tip, linearised where the network starts:
    /// `moved[k][touch]` is the movement by quantity k, mm. Rows: terms; columns: quantities. Also the covariance of the terms
    /// by repeatability and known sizes.
    ///
    /// # Errors
    /// As [`Network::foresee`].
    pub fn shown(&self, moved: &[Vec<[f64; 3]>]) -> Result<Shown, CalibrationRefusal> {
        let values: Vec<f64> = self.unknowns.iter().map(|unknown| unknown.start).collect();
        let sigma = self.repeatability_mm;
        let solved = self.step(&values, sigma, None)?;
        let rows: Vec<_> = self.touches.iter().map(|touch| touch.row(&values, self.tip)).collect();
        // Weight of every touch in every term: (AᵀA)⁻¹Aᵀ.
        let weight = |term: usize, row: &Row| -> f64 {
            let parts = row.derivatives.iter().map(|(unknown, value)| solved.covariance[(term, *unknown)] * value);
            parts.sum::<f64>() / (sigma * sigma)
        };
        let weights = (0..self.terms).map(|term| rows.iter().map(|row| weight(term, row)).collect::<Vec<_>>());
        let across = |touches: &[[f64; 3]]| rows.iter().zip(touches).map(|(row, by)| dot(row.across, *by)).collect();
        let moved: Vec<Vec<f64>> = moved.iter().map(|touches| across(touches)).collect();
        let sum = |weights: &[f64], moved: &[f64]| weights.iter().zip(moved).map(|(w, by)| w * by).sum::<f64>();
        let design = weights.map(|weights| moved.iter().map(|of| sum(&weights, of)).collect()).collect();
        let entry = |row: usize| (0..self.terms).map(|column| solved.covariance[(row, column)]).collect();
        Ok(Shown { design, covariance: (0..self.terms).map(entry).collect() })
    }

    /// Degrees of freedom of the touches: r = n − p + Σ s_k²/u_k² over the quantities known within u_k.
    ///
    /// A size that the touches determine better than its certificate (s_k ≪ u_k) costs one degree of freedom like any unknown;
    /// one that they do not determine (s_k = u_k) costs none. Source: Förstner, Zeitschrift für Vermessungswesen 104 (1979).
    fn redundancy(&self, solved: &Solved) -> f64 {
        let share = |(index, unknown): (usize, &Unknown)| {
            let uncertainty = unknown.uncertainty?.max(1e-12);
            Some((solved.covariance[(index, index)] / (uncertainty * uncertainty)).min(1.0))
        };
        let known: f64 = self.unknowns.iter().enumerate().filter_map(share).sum();
        self.touches.len() as f64 - self.unknowns.len() as f64 + known
    }

    fn settle(&self, values: &mut [f64], sigma: f64, mut condition: Option<f64>) -> Result<Solved, CalibrationRefusal> {
        let mut last = None;
        for _ in 0..STEPS {
            let solved = self.step(values, sigma, condition)?;
            condition = Some(solved.condition);
            values.iter_mut().zip(&solved.values).for_each(|(value, step)| *value += step);
            let step = solved.values.amax();
            last = Some(solved);
            if step < SETTLED || !step.is_finite() {
                break;
            }
        }
        let (touch, residual_mm) = self
            .residuals(values)
            .into_iter()
            .enumerate()
            .fold((0, 0.0), |worst: (usize, f64), one| if one.1.abs() > worst.1.abs() { one } else { worst });
        last.filter(|_| residual_mm.abs() < OFF).ok_or(CalibrationRefusal::Unsettled { touch, residual_mm })
    }

    fn step(&self, values: &[f64], sigma: f64, condition: Option<f64>) -> Result<Solved, CalibrationRefusal> {
        let count = self.unknowns.len();
        let known: Vec<(usize, f64, f64)> = self
            .unknowns
            .iter()
            .enumerate()
            .filter_map(|(index, unknown)| {
                let uncertainty = unknown.uncertainty?.max(1e-12);
                Some((index, (unknown.start - values[index]) / uncertainty, 1.0 / uncertainty))
            })
            .collect();
        let rows = (self.touches.len() + known.len()).max(count);
        let mut matrix = DMatrix::zeros(rows, count);
        let mut right = DVector::zeros(rows);
        for (index, touch) in self.touches.iter().enumerate() {
            let row = touch.row(values, self.tip);
            right[index] = -row.residual / sigma;
            for (unknown, derivative) in row.derivatives {
                matrix[(index, unknown)] += derivative / sigma;
            }
        }
        for (index, (unknown, away, weight)) in known.into_iter().enumerate() {
            matrix[(self.touches.len() + index, unknown)] = weight;
            right[self.touches.len() + index] = away;
        }
        solve(matrix, &right, condition).map_err(|combinations| CalibrationRefusal::NotApart { combinations })
    }

    fn residuals(&self, values: &[f64]) -> Vec<f64> {
        self.touches.iter().map(|touch| touch.row(values, self.tip).residual).collect()
    }

    /// Root mean square movement of the touches across their surfaces due to the terms, mm.
    fn signal(&self, values: &[f64]) -> f64 {
        let squares: f64 = self
            .touches
            .iter()
            .map(|touch| {
                let row = touch.row(values, self.tip);
                let moved: f64 = row
                    .derivatives
                    .iter()
                    .filter(|(unknown, _)| *unknown < self.terms)
                    .map(|(unknown, derivative)| derivative * values[*unknown])
                    .sum();
                moved * moved
            })
            .sum();
        (squares / self.touches.len().max(1) as f64).sqrt()
    }
}
