//! Linear least squares of many rows and some hundred unknowns, with rank, condition and inseparable unknowns.
//!
//! Rows w·(a·x) = w·y enter a triangle by Householder reflections, a block at a time: memory depends only on the number of
//! unknowns, and the normal equations are never formed. Columns are scaled to unit length; the singular values of the scaled
//! triangle give rank and condition, and the vectors of those that vanish show which unknowns the rows do not separate.
//!
//! Source: Golub, Van Loan, *Matrix Computations*, 5.3, 5.5 and 12.5 (updating a QR factorisation by rows).

use nalgebra::{DMatrix, DVector};
use std::vec;
use std::vec::Vec;

/// Singular values of the scaled columns below this share of the largest count as zero.
pub const RANK_TOLERANCE: f64 = 1e-8;
/// Share of an unknown in an unobserved direction (of the square of its length) above which it is named.
const NAMED: f64 = 0.01;
/// Rows collected before they are reflected into the triangle, as a multiple of the number of unknowns.
const BLOCK: usize = 3;

/// Rows of a fit.
#[derive(Clone, Debug)]
pub struct LinearFit {
    unknowns: usize,
    triangle: DMatrix<f64>,
    /// Rows not yet in the triangle, in sequence, right-hand side last.
    waiting: Vec<f64>,
    rows: usize,
}

/// Solution of a fit.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Solution {
    /// Values of the unknowns.
    pub values: Vec<f64>,
    /// Standard errors for rows of unit standard deviation: roots of the diagonal of (AᵀW²A)⁻¹.
    pub error_factors: Vec<f64>,
    /// Number of unknowns that the rows determine.
    pub rank: usize,
    /// Condition number of the scaled columns.
    pub condition: f64,
    /// Sum of the squared weighted residuals.
    pub squares: f64,
    /// Number of rows.
    pub rows: usize,
    /// Unknowns that the rows do not determine separately, in ascending order; empty at full rank. Otherwise the values are
    /// those of minimum norm in the scaled unknowns.
    pub unseen: Vec<usize>,
    /// Columns of the unknowns in the observed directions, S⁻¹Vᵀ without the scale: its columns' products are (AᵀW²A)⁻¹.
    observed: DMatrix<f64>,
}

impl Solution {
    /// Returns an entry of (AᵀW²A)⁻¹, the covariance of two unknowns for rows of unit standard deviation; 0 for an unknown that
    /// there is not. Cost: one product for each unknown.
    pub fn covariance_factor(&self, one: usize, other: usize) -> f64 {
        let count = self.observed.ncols();
        if one >= count || other >= count {
            return 0.0;
        }
        self.observed.column(one).dot(&self.observed.column(other))
    }

    /// Returns the covariances of all unknowns with a combination of them, for rows of unit standard deviation; `combination`
    /// has one share for each unknown. Cost: two products for each unknown.
    pub fn covariance_with(&self, combination: &[f64]) -> Vec<f64> {
        let count = self.observed.ncols();
        let shares = DVector::from_fn(count, |j, _| combination.get(j).copied().unwrap_or(0.0));
        self.observed.tr_mul(&(&self.observed * shares)).iter().copied().collect()
    }

    /// Returns the number of rows − rank.
    pub fn degrees_of_freedom(&self) -> usize {
        self.rows.saturating_sub(self.rank)
    }

    /// Returns the standard deviation of a row of unit weight; 0 without redundancy.
    pub fn sigma(&self) -> f64 {
        match self.degrees_of_freedom() {
            0 => 0.0,
            freedom => (self.squares / freedom as f64).sqrt(),
        }
    }
}

impl LinearFit {
    /// Creates a fit with this number of unknowns and no rows.
    pub fn new(unknowns: usize) -> LinearFit {
        LinearFit { unknowns, triangle: DMatrix::zeros(unknowns + 1, unknowns + 1), waiting: Vec::new(), rows: 0 }
    }

    /// Adds weight·(a·x) = weight·value; weight = 1/standard deviation. `a` may be shorter than the unknowns (zeros follow).
    pub fn add(&mut self, a: &[f64], value: f64, weight: f64) {
        let given = a.iter().copied().chain(std::iter::repeat(0.0)).take(self.unknowns);
        self.waiting.extend(given.chain([value]).map(|entry| weight * entry));
        self.rows += 1;
        if self.waiting.len() >= BLOCK * (self.unknowns + 1) * (self.unknowns + 1) {
            self.reflect();
        }
    }

    /// Reflects the waiting rows into the triangle.
    fn reflect(&mut self) {
        let size = self.unknowns + 1;
        let waiting = std::mem::take(&mut self.waiting);
        if waiting.is_empty() {
            return;
        }
        let mut stack = DMatrix::zeros(size + waiting.len() / size, size);
        stack.rows_mut(0, size).copy_from(&self.triangle);
        for (i, row) in waiting.chunks_exact(size).enumerate() {
            for (j, value) in row.iter().enumerate() {
                stack[(size + i, j)] = *value;
            }
        }
        self.triangle = stack.qr().r();
    }

    /// Solves the fit.
    ///
    /// Cost: one singular value decomposition of the triangle. If any row has a value that is not finite, all values are NaN
    /// and the rank is 0.
    pub fn solve(mut self) -> Solution {
        self.reflect();
        let n = self.unknowns;
        let mut factor = self.triangle.view((0, 0), (n, n)).into_owned();
        let right: DVector<f64> = self.triangle.view((0, n), (n, 1)).column(0).into_owned();
        let rest = self.triangle[(n, n)];
        if !self.triangle.iter().all(|value| value.is_finite()) {
            let nothing = vec![f64::NAN; n];
            return Solution {
                error_factors: nothing.clone(),
                values: nothing,
                rank: 0,
                condition: f64::INFINITY,
                squares: f64::NAN,
                rows: self.rows,
                unseen: (0..n).collect(),
                observed: DMatrix::zeros(0, 0),
            };
        }
        let lengths: Vec<f64> = (0..n).map(|j| factor.column(j).norm()).collect();
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        // A column of zeros, or of rounding errors, is not scaled up: the rank reveals it.
        let lengths: Vec<f64> = lengths
            .into_iter()
            .map(|length| if length > f64::EPSILON * longest { length } else { longest.max(f64::MIN_POSITIVE) })
            .collect();
        for (j, length) in lengths.iter().enumerate() {
            factor.column_mut(j).scale_mut(1.0 / length);
        }
        let svd = factor.svd(true, true);
        let (singular, u, v_t) = (&svd.singular_values, svd.u.as_ref(), svd.v_t.as_ref());
        let largest = singular.iter().copied().fold(0.0, f64::max);
        let seen = |value: f64| value > RANK_TOLERANCE * largest;
        let mut values = vec![0.0; n];
        let mut observed = DMatrix::zeros(n, n);
        let mut unseen = vec![0.0; n];
        let mut squares = rest * rest;
        if let (Some(u), Some(v_t)) = (u, v_t) {
            for (k, &value) in singular.iter().enumerate() {
                let along = u.column(k).dot(&right);
                for j in 0..n {
                    let part = v_t[(k, j)];
                    if seen(value) {
                        values[j] += part * along / value / lengths[j];
                        observed[(k, j)] = part / value / lengths[j];
                    } else {
                        unseen[j] += part * part;
                    }
                }
                if !seen(value) {
                    squares += along * along;
                }
            }
        }
        let smallest = singular.iter().copied().fold(f64::INFINITY, f64::min);
        Solution {
            values,
            error_factors: observed.column_iter().map(|column| column.norm_squared().sqrt()).collect(),
            rank: singular.iter().filter(|value| seen(**value)).count(),
            condition: if smallest > 0.0 { largest / smallest } else { f64::INFINITY },
            squares,
            rows: self.rows,
            unseen: (0..n).filter(|&j| unseen[j] > NAMED).collect(),
            observed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line through four points: y = 1 + 2 t with residuals ±0.1, by hand.
    #[test]
    fn a_line_by_hand() {
        let mut fit = LinearFit::new(2);
        for (t, y) in [(0.0, 1.1), (1.0, 2.9), (2.0, 4.9), (3.0, 7.1)] {
            fit.add(&[1.0, t], y, 1.0);
        }
        let found = fit.solve();
        assert!((found.values[0] - 1.0).abs() < 1e-14 && (found.values[1] - 2.0).abs() < 1e-14, "{found:?}");
        assert!((found.squares - 0.04).abs() < 1e-14 && found.rank == 2 && found.unseen.is_empty());
        // Var(slope) = 1/Σ(t − t̄)² = 1/5, Var(intercept) = 1/4 + 1.5²/5.
        assert!((found.error_factors[1] - 0.2_f64.sqrt()).abs() < 1e-14);
        assert!((found.error_factors[0] - 0.7_f64.sqrt()).abs() < 1e-14);
        assert!((found.sigma() - 0.02_f64.sqrt()).abs() < 1e-14);
        // Cov(intercept, slope) = −t̄/Σ(t − t̄)².
        assert!((found.covariance_factor(0, 1) + 0.3).abs() < 1e-14 && found.covariance_factor(0, 2) == 0.0);
        assert!((found.covariance_factor(0, 0) - 0.7).abs() < 1e-14);
        // The line at t̄ has variance 1/4 and no covariance with the slope.
        let middle = found.covariance_with(&[1.0, 1.5]);
        assert!((middle[0] - 0.25).abs() < 1e-14 && middle[1].abs() < 1e-14);
    }

    /// Many blocks give the same result as one, and weights act like repetitions.
    #[test]
    fn blocks_and_weights() {
        let rows = |k: usize| [1.0, (k as f64 * 0.7).sin(), (k as f64 * 0.3).cos()];
        let value = |k: usize| (k as f64 * 1.3).sin();
        let (mut one, mut four) = (LinearFit::new(3), LinearFit::new(3));
        for k in 0..200 {
            one.add(&rows(k), value(k), 2.0);
            for _ in 0..4 {
                four.add(&rows(k), value(k), 1.0);
            }
        }
        let (one, four) = (one.solve(), four.solve());
        for j in 0..3 {
            assert!((one.values[j] - four.values[j]).abs() < 1e-13);
            assert!((one.error_factors[j] - four.error_factors[j]).abs() < 1e-13);
        }
    }

    /// Two equal columns: the rank is one less, both are named, the third is not, and the values have minimum norm.
    #[test]
    fn indistinguishable_columns_are_named() {
        let mut fit = LinearFit::new(4);
        for k in 0..10 {
            let t = f64::from(k);
            fit.add(&[1.0, t, 1.0, 0.0], 3.0 + t, 1.0);
        }
        let found = fit.solve();
        assert_eq!((found.rank, found.unseen.as_slice()), (2, &[0, 2, 3][..]));
        assert!((found.values[0] - 1.5).abs() < 1e-12 && (found.values[2] - 1.5).abs() < 1e-12);
        assert!((found.values[1] - 1.0).abs() < 1e-12);
    }
}
