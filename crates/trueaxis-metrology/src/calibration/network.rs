//! The network of all touches.

use super::Refused;
use super::least_squares::{Solved, solve};
use super::surface::Touch;
use nalgebra::{DMatrix, DVector};
use std::vec::Vec;

/// Most steps of the iteration; places that are a millimetre off settle in four.
const STEPS: usize = 12;
/// A step below this, mm or rad, ends it.
const SETTLED: f64 = 1e-10;
/// Largest residual of a touch, mm, for which a step counts as settled.
const OFF: f64 = 1.0;
/// Least repeatability that is found, mm.
const LEAST: f64 = 1e-9;
/// Degrees of freedom from which the repeatability that is found takes the place of the one that is stated.
const POOLED: f64 = 20.0;
/// Most times that it is pooled: weights change what is left, and what is left changes the weights.
const POOLINGS: usize = 4;
/// A repeatability that changes by less than this share is the same.
const SAME: f64 = 0.01;

/// Something that is not known, or only within its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unknown {
    /// Value to begin with, mm, rad or 1; the known value where there is an uncertainty.
    pub start: f64,
    /// Standard uncertainty of that value; none where nothing is known.
    pub uncertainty: Option<f64>,
}

/// Touches, and what is unknown of machine, probe and artefacts.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    /// All unknowns, the terms of the machine first.
    pub unknowns: Vec<Unknown>,
    /// How many of them are terms of the machine.
    pub terms: usize,
    /// Index of the tip's radius.
    pub tip: usize,
    /// The touches.
    pub touches: Vec<Touch>,
    /// Standard deviation of a touch as stated, mm.
    pub repeatability_mm: f64,
}

/// What the network tells.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Solution {
    /// Values of all unknowns.
    pub values: Vec<f64>,
    /// Their standard errors.
    pub standard_errors: Vec<f64>,
    /// Covariance of the terms of the machine, row by row.
    pub covariance: Vec<Vec<f64>>,
    /// What is left of every touch, mm, positive where it lies outside the surface.
    pub residuals_mm: Vec<f64>,
    /// Standard deviation of a touch, from what is left, mm.
    pub sigma_mm: f64,
    /// Touches less unknowns as far as the touches tell them: what [`Solution::sigma_mm`] rests on.
    pub degrees_of_freedom: usize,
    /// Condition number of the scaled columns.
    pub condition: f64,
    /// Unknowns, all of which are told apart.
    pub rank: usize,
    /// Root mean square of what the terms move the touches across their surfaces, mm.
    pub signal_mm: f64,
}

impl Network {
    /// Solves for all unknowns.
    ///
    /// The touches weigh by the repeatability, which is pooled from what is left as soon as that has 20 degrees of freedom;
    /// known sizes by their uncertainty. Cost: a QR of touches × unknowns a step, four steps as a rule.
    ///
    /// # Errors
    /// [`Refused`].
    pub fn solve(&self) -> Result<Solution, Refused> {
        self.weighed(POOLED, LEAST)
    }

    /// Solves with the repeatability as stated, for touches that nobody has made yet: what is left of them is rounding and
    /// says nothing of the probe. Cost as [`Network::solve`].
    ///
    /// # Errors
    /// [`Refused`].
    pub fn foresee(&self) -> Result<Solution, Refused> {
        self.weighed(f64::INFINITY, LEAST)
    }

    /// As [`Network::solve`], but with the repeatability as stated where what is found is smaller: touches that happen to agree
    /// make nothing more significant.
    pub(super) fn solve_with_care(&self) -> Result<Solution, Refused> {
        self.weighed(POOLED, self.repeatability_mm)
    }

    /// Solves; from `pooled` degrees of freedom on by the repeatability that is found, `least` at least, mm.
    fn weighed(&self, pooled: f64, least: f64) -> Result<Solution, Refused> {
        let known = self.unknowns.iter().filter(|unknown| unknown.uncertainty.is_some()).count();
        let count = self.unknowns.len();
        if self.touches.len() + known < count {
            return Err(Refused::TooFew { found: self.touches.len(), needed: count - known });
        }
        let whole = |touch: &Touch| touch.tip_mm.iter().chain(touch.response.iter().flatten()).all(|v| v.is_finite());
        if let Some(touch) = self.touches.iter().position(|touch| !whole(touch)) {
            return Err(Refused::NotFinite { touch });
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

    /// Degrees of freedom of the touches: r = n − p + Σ s_k²/u_k² over what is known within u_k.
    ///
    /// A size that the touches tell better than its certificate (s_k ≪ u_k) costs one of them as any unknown does; one that
    /// they tell nothing of (s_k = u_k) costs none. Source: Förstner, Zeitschrift für Vermessungswesen 104 (1979).
    fn redundancy(&self, solved: &Solved) -> f64 {
        let share = |(index, unknown): (usize, &Unknown)| {
            let uncertainty = unknown.uncertainty?.max(1e-12);
            Some((solved.covariance[(index, index)] / (uncertainty * uncertainty)).min(1.0))
        };
        let known: f64 = self.unknowns.iter().enumerate().filter_map(share).sum();
        self.touches.len() as f64 - self.unknowns.len() as f64 + known
    }

    fn settle(&self, values: &mut [f64], sigma: f64, mut condition: Option<f64>) -> Result<Solved, Refused> {
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
        last.filter(|_| residual_mm.abs() < OFF).ok_or(Refused::Unsettled { touch, residual_mm })
    }

    fn step(&self, values: &[f64], sigma: f64, condition: Option<f64>) -> Result<Solved, Refused> {
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
        solve(matrix, &right, condition).map_err(|combinations| Refused::NotApart { combinations })
    }

    fn residuals(&self, values: &[f64]) -> Vec<f64> {
        self.touches.iter().map(|touch| touch.row(values, self.tip).residual).collect()
    }

    /// Movement of the touches across their surfaces by the terms, root mean square, mm.
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
