//! Linear least squares by QR of scaled columns, with covariance and condition number.

use super::blocks::{self, Eliminated};
use nalgebra::{DMatrix, DVector};
use std::vec::Vec;

/// Condition number of the scaled columns beyond which a combination counts as unobserved.
pub(super) const CONDITION_LIMIT: f64 = 1e7;
/// Number of unknowns from which those in few rows are eliminated first.
const MANY: usize = 200;
/// Share of the limit up to which the condition number of an elimination, which is iterated, counts.
const ITERATED: f64 = 0.1;
/// Parts of a combination below this share of the largest are omitted.
const SAID: f64 = 0.05;

/// A solution.
pub(super) struct Solved {
    pub(super) values: DVector<f64>,
    /// (AᵀA)⁻¹.
    pub(super) covariance: DMatrix<f64>,
    pub(super) condition: f64,
}

/// Unknowns of an unobserved combination with their shares.
pub(super) type Combination = Vec<(usize, f64)>;

/// Minimises |A x − b|. `condition`: condition number of A if already known, to skip the singular values.
///
/// # Errors
/// The combinations of columns that A maps to zero.
pub(super) fn solve(
    mut matrix: DMatrix<f64>,
    right: &DVector<f64>,
    condition: Option<f64>,
) -> Result<Solved, Vec<Combination>> {
    let count = matrix.ncols();
    let lengths: Vec<f64> = matrix
        .column_iter()
        .map(|column| column.norm())
        .map(|length| if length > 0.0 { length } else { 1.0 })
        .collect();
    for (mut column, length) in matrix.column_iter_mut().zip(&lengths) {
        column /= *length;
    }
    let unscaled = |scaled: DVector<f64>, mut covariance: DMatrix<f64>, condition: f64| {
        for row in 0..count {
            for column in 0..count {
                covariance[(row, column)] /= lengths[row] * lengths[column];
            }
        }
        let values = DVector::from_iterator(count, scaled.iter().zip(&lengths).map(|(value, length)| value / length));
        Solved { values, covariance, condition }
    };
    if count >= MANY
        && let Some(Eliminated { values, covariance, condition }) = blocks::solve(&matrix, right, condition)
        && condition < ITERATED * CONDITION_LIMIT
    {
        return Ok(unscaled(values, covariance, condition));
    }
    let qr = matrix.qr();
    let triangle = qr.r();
    let condition = match condition {
        Some(known) => known,
        None => seen(&triangle)?,
    };
    let mut projected = right.clone();
    qr.q_tr_mul(&mut projected);
    let projected = projected.rows(0, count).into_owned();
    let all = || (0..count).map(|index| Vec::from([(index, 1.0)])).collect::<Vec<_>>();
    let (Some(scaled), Some(inverse)) = (
        triangle.solve_upper_triangular(&projected),
        triangle.solve_upper_triangular(&DMatrix::identity(count, count)),
    ) else {
        return Err(all());
    };
    let covariance = &inverse * inverse.transpose();
    Ok(unscaled(scaled, covariance, condition))
}

/// Condition number of a triangle; fails with its unobserved combinations.
fn seen(triangle: &DMatrix<f64>) -> Result<f64, Vec<Combination>> {
    let svd = triangle.clone().svd(false, true);
    let (largest, smallest) = (svd.singular_values.max(), svd.singular_values.min());
    let unseen: Vec<Combination> = svd
        .singular_values
        .iter()
        .enumerate()
        .filter(|(_, value)| **value * CONDITION_LIMIT < largest)
        .filter_map(|(index, _)| Some(said(&svd.v_t.as_ref()?.row(index).iter().copied().collect::<Vec<f64>>())))
        .collect();
    if unseen.is_empty() { Ok(largest / smallest) } else { Err(unseen) }
}

/// The parts above [`SAID`], scaled so that the largest is ±1.
fn said(vector: &[f64]) -> Combination {
    let largest = vector.iter().fold(0.0, |largest: f64, part| largest.max(part.abs())).max(f64::MIN_POSITIVE);
    let shares = vector.iter().map(|part| part / largest).enumerate();
    shares.filter(|(_, share)| share.abs() >= SAID).collect()
}
