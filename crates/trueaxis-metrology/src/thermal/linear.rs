//! Linear least squares: by QR for what is reported, by normal equations for what is only compared.

use nalgebra::{DMatrix, DVector};
use std::vec::Vec;

/// A solution.
#[derive(Clone, Debug)]
pub(super) struct Solved {
    pub(super) values: DVector<f64>,
    pub(super) covariance: DMatrix<f64>,
    /// Ratio of the largest to the smallest singular value of the scaled columns.
    pub(super) condition: f64,
    /// Root mean square of what is left.
    pub(super) rms: f64,
}

/// Lengths of the columns; 1 of one that is nothing, so that it stays nothing.
fn norms(columns: &[Vec<f64>]) -> Vec<f64> {
    let norm = |column: &Vec<f64>| column.iter().map(|x| x * x).sum::<f64>().sqrt();
    columns.iter().map(norm).map(|norm| if norm > 0.0 { norm } else { 1.0 }).collect()
}

/// Solves for one value a column; `lost`: degrees of freedom of the means that were taken out, `step`: every so many rows
/// belong to one measuring point, in order of time.
///
/// What is left of neighbouring rows is not independent. With the correlation ρ of one row and the next of a point, as of a
/// first-order process, N rows are worth N (1 − ρ)/(1 + ρ); the covariance is that of so many.
pub(super) fn solve(columns: &[Vec<f64>], right: &[f64], lost: usize, step: usize) -> Option<Solved> {
    let (rows, count) = (right.len(), columns.len());
    if count == 0 || rows <= count + lost {
        return None;
    }
    let norms = norms(columns);
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
    })
}

/// Sum of squares that is left of every cycle when it is predicted from the others; `cycles` are the ends of their rows.
pub(super) fn predicted(columns: &[Vec<f64>], right: &[f64], cycles: &[usize]) -> f64 {
    let count = columns.len();
    let norms = norms(columns);
    let dot = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
    let mut parts = Vec::with_capacity(cycles.len());
    let mut from = 0;
    for &to in cycles {
        let cut = |column: usize| &columns[column][from..to];
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
            // A trace of damping, for causes of which the others have nothing.
            let mut others = DMatrix::identity(count, count) * 1e-9;
            let mut known = DVector::zeros(count);
            for part in whole(k) {
                others += &part.0;
                known += &part.1;
            }
            let values = others.cholesky().map_or_else(|| DVector::zeros(count), |factors| factors.solve(&known));
            (squares - 2.0 * values.dot(own) + values.dot(&(normal * &values))).max(0.0)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::predicted;
    use std::vec;

    #[test]
    fn a_column_of_nothing_predicts_nothing() {
        let right = [1.0, 2.0, 3.0, 2.0, 4.0, 6.0, 1.0, 2.0, 3.0];
        let cycles = [3, 6, 9];
        let useful = vec![1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 1.0, 2.0, 3.0];
        let squares = right.iter().map(|value| value * value).sum::<f64>();
        assert!((predicted(&[vec![0.0; 9]], &right, &cycles) - squares).abs() < 1e-12);
        let alone = predicted(core::slice::from_ref(&useful), &right, &cycles);
        assert!(alone > 1.0 && (predicted(&[useful, vec![0.0; 9]], &right, &cycles) - alone).abs() < 1e-12);
    }
}
