//! Linear least squares: by QR for reported results, by normal equations for comparisons.

use nalgebra::{DMatrix, DVector};
use std::vec::Vec;

/// A solution.
#[derive(Clone, Debug)]
pub(super) struct Solved {
    pub(super) values: DVector<f64>,
    pub(super) covariance: DMatrix<f64>,
    /// Ratio of the largest to the smallest singular value of the scaled columns.
    pub(super) condition: f64,
    /// Root mean square of the residuals.
    pub(super) rms: f64,
    /// Variance of a row, inflated so that correlated rows can be treated as independent.
    pub(super) variance: f64,
}

/// A column of the linear problem.
#[derive(Clone, Debug)]
pub(super) struct Column {
    pub(super) values: Vec<f64>,
    /// Index, among the fitted cycles from 0, of the only cycle that determines this column; no other cycle predicts it.
    pub(super) lone: Option<usize>,
}

/// Lengths of the columns; 1 for a zero column, so that it stays zero.
fn norms<'c>(columns: impl Iterator<Item = &'c [f64]>) -> Vec<f64> {
    let norm = |column: &[f64]| column.iter().map(|x| x * x).sum::<f64>().sqrt();
    columns.map(norm).map(|norm| if norm > 0.0 { norm } else { 1.0 }).collect()
}

/// Solves for one value per column. `lost`: degrees of freedom of the subtracted means; `step`: number of measuring points, so
/// that rows `step` apart are consecutive rows of one point.
///
/// The residuals of neighbouring rows are correlated. With the correlation ρ between consecutive rows of a point, as in a
/// first-order process, N rows carry the information of N (1 − ρ)/(1 + ρ) independent ones; the covariance accounts for this.
pub(super) fn solve(columns: &[Vec<f64>], right: &[f64], lost: usize, step: usize) -> Option<Solved> {
    let (rows, count) = (right.len(), columns.len());
    if count == 0 || rows <= count + lost {
        return None;
    }
    let norms = norms(columns.iter().map(Vec::as_slice));
    let matrix = DMatrix::from_fn(rows, count, |row, column| columns[column][row] / norms[column]);
    let right = DVector::from_column_slice(right);
    let singular = matrix.singular_values();
    let condition = singular.max() / singular.min().max(1e-300);
    let qr = matrix.clone().qr();
    let triangle = qr.r();
    let scaled = triangle.solve_upper_triangular(&(qr.q().transpose() * &right))?;
    let left = &right - matrix * &scaled;
    let squares = left.norm_squared();
    let along: f64 = (step..rows).map(|row| left[row] * left[row - step]).sum();
    let rho = (along / squares.max(1e-300)).clamp(0.0, 0.98);
    let variance = squares / (rows - count - lost) as f64 * (1.0 + rho) / (1.0 - rho);
    let inverse = triangle.try_inverse()?;
    let covariance = &inverse * inverse.transpose() * variance;
    Some(Solved {
        values: DVector::from_fn(count, |k, _| scaled[k] / norms[k]),
        covariance: DMatrix::from_fn(count, count, |i, j| covariance[(i, j)] / (norms[i] * norms[j])),
        condition,
        rms: (squares / rows as f64).sqrt(),
        variance,
    })
}

/// Residual sum of squares when each cycle is predicted from the others; `cycles` are the ends of their rows.
///
/// If only one cycle determines a column, the others cannot predict it: its value is fitted to that cycle, with all other
/// values as predicted. Without this value its cause would appear not to predict, and other causes with wrong lags would
/// replace it.
pub(super) fn predicted(columns: &[Column], right: &[f64], cycles: &[usize]) -> f64 {
    let count = columns.len();
    let norms = norms(columns.iter().map(|column| column.values.as_slice()));
    let dot = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
    let mut parts = Vec::with_capacity(cycles.len());
    let mut from = 0;
    for &to in cycles {
        let cut = |column: usize| &columns[column].values[from..to];
        let mut normal = DMatrix::zeros(count, count);
        for i in 0..count {
            for j in 0..=i {
                normal[(i, j)] = dot(cut(i), cut(j)) / (norms[i] * norms[j]);
                normal[(j, i)] = normal[(i, j)];
            }
        }
        let own = &right[from..to];
        parts.push((normal, DVector::from_fn(count, |k, _| dot(cut(k), own) / norms[k]), dot(own, own)));
        from = to;
    }
    let whole = |k: usize| parts.iter().enumerate().filter(move |(other, _)| *other != k).map(|(_, part)| part);
    (0..parts.len())
        .map(|k| {
            let (normal, own, squares) = &parts[k];
            // Slight damping, for columns that the other cycles do not contain.
            let mut others = DMatrix::identity(count, count) * 1e-9;
            let mut known = DVector::zeros(count);
            for part in whole(k) {
                others += &part.0;
                known += &part.1;
            }
            let mut values = others.cholesky().map_or_else(|| DVector::zeros(count), |factors| factors.solve(&known));
            let lone: Vec<usize> = (0..count).filter(|column| columns[*column].lone == Some(k)).collect();
            if !lone.is_empty() {
                let rest = own - normal * &values;
                let matrix = DMatrix::from_fn(lone.len(), lone.len(), |i, j| {
                    normal[(lone[i], lone[j])] + if i == j { 1e-9 } else { 0.0 }
                });
                let right = DVector::from_fn(lone.len(), |i, _| rest[lone[i]]);
                if let Some(steps) = matrix.cholesky().map(|factors| factors.solve(&right)) {
                    lone.iter().zip(steps.iter()).for_each(|(column, step)| values[*column] += step);
                }
            }
            (squares - 2.0 * values.dot(own) + values.dot(&(normal * &values))).max(0.0)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::{Column, predicted};
    use std::vec;
    use std::vec::Vec;

    fn column(values: Vec<f64>, lone: Option<usize>) -> Column {
        Column { values, lone }
    }

    #[test]
    fn a_column_of_nothing_predicts_nothing() {
        let right = [1.0, 2.0, 3.0, 2.0, 4.0, 6.0, 1.0, 2.0, 3.0];
        let cycles = [3, 6, 9];
        let useful = column(vec![1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 1.0, 2.0, 3.0], None);
        let nothing = column(vec![0.0; 9], None);
        let squares = right.iter().map(|value| value * value).sum::<f64>();
        assert!((predicted(core::slice::from_ref(&nothing), &right, &cycles) - squares).abs() < 1e-12);
        let alone = predicted(core::slice::from_ref(&useful), &right, &cycles);
        assert!(alone > 1.0 && (predicted(&[useful, nothing], &right, &cycles) - alone).abs() < 1e-12);
    }

    /// Three cycles of 2 a; the second also contains 5 b, which the others lack.
    #[test]
    fn a_cause_in_one_cycle_is_fitted_there_with_the_rest_as_in_the_others() {
        let (a, b) = ([1.0, 2.0, 3.0], [1.0, 1.0, -1.0]);
        let right: Vec<f64> = (0..9).map(|k| 2.0 * a[k % 3] + if k / 3 == 1 { 5.0 * b[k % 3] } else { 0.0 }).collect();
        let own: Vec<f64> = (0..9).map(|k| if k / 3 == 1 { b[k % 3] } else { 0.0 }).collect();
        let all = column((0..9).map(|k| a[k % 3]).collect(), None);
        let left = |lone| predicted(&[all.clone(), column(own.clone(), lone)], &right, &[3, 6, 9]);
        assert!(left(Some(1)) < 1e-12);
        assert!(
            (left(None) - 75.0).abs() < 1e-6,
            "cycles without the cause predict nothing of it, so all of it remains"
        );
    }
}
