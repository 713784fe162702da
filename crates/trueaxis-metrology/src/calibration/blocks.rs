//! Least squares in which most unknowns are in few rows, as the places of a plate's balls are: these are eliminated first.
//!
//! The rows of a group of such unknowns are triangularised for them, which leaves fewer rows for the unknowns in common:
//!
//! ```text
//! Qᵀ [G  C | b] = [R  S | r]        R x_g = r − S x_c
//!                 [0  C'| b']       rows of x_c alone
//! ```
//!
//! With T = R⁻¹ S and the covariance K of x_c, the covariance of the groups is T K Tᵀ + R⁻¹ R⁻ᵀ, and −T K with x_c. Source:
//! Björck, Numerical Methods for Least Squares Problems, section 6.3 (block angular problems).

use nalgebra::{DMatrix, DVector};
use std::vec;
use std::vec::Vec;

/// Most rows that know an unknown of a group.
const FEW_ROWS: usize = 24;
/// Most unknowns of a group.
const FEW: usize = 6;
/// Most steps of the iteration for a largest eigenvalue, and the relative change that ends it.
const STEPS: usize = 300;
const SAME: f64 = 1e-9;

/// Solution, (AᵀA)⁻¹ and condition number.
pub(super) struct Eliminated {
    pub(super) values: DVector<f64>,
    pub(super) covariance: DMatrix<f64>,
    pub(super) condition: f64,
}

/// A group: its columns, its triangle's inverse, T and r.
struct Group {
    columns: Vec<usize>,
    inverse: DMatrix<f64>,
    coupling: DMatrix<f64>,
    right: DVector<f64>,
}

/// Minimises |A x − b| for a matrix with columns of length 1; `None` if it has no groups, nothing but groups, or is singular.
pub(super) fn solve(matrix: &DMatrix<f64>, right: &DVector<f64>, condition: Option<f64>) -> Option<Eliminated> {
    let groups = groups(matrix);
    let mut group_of_row: Vec<Option<usize>> = vec![None; matrix.nrows()];
    let mut is_common = vec![true; matrix.ncols()];
    for (group, columns) in groups.iter().enumerate() {
        for column in columns {
            is_common[*column] = false;
            rows(matrix, *column).for_each(|row| group_of_row[row] = Some(group));
        }
    }
    let common: Vec<usize> = (0..matrix.ncols()).filter(|column| is_common[*column]).collect();
    let mut rows_of: Vec<Vec<usize>> = vec![Vec::new(); groups.len()];
    let mut left: Vec<(Vec<f64>, f64)> = Vec::new();
    for (row, group) in group_of_row.iter().enumerate() {
        match group {
            Some(group) => rows_of[*group].push(row),
            None => left.push((common.iter().map(|column| matrix[(row, *column)]).collect(), right[row])),
        }
    }
    let mut eliminated = Vec::with_capacity(groups.len());
    for (columns, rows) in groups.into_iter().zip(&rows_of) {
        let count = columns.len();
        if rows.len() < count {
            return None;
        }
        let own = DMatrix::from_fn(rows.len(), count, |row, column| matrix[(rows[row], columns[column])]);
        let mut rest = DMatrix::from_fn(rows.len(), common.len() + 1, |row, column| match common.get(column) {
            Some(column) => matrix[(rows[row], *column)],
            None => right[rows[row]],
        });
        let qr = own.qr();
        qr.q_tr_mul(&mut rest);
        let inverse = inverse(&qr.r())?;
        let upper = rest.rows(0, count);
        let coupling = &inverse * upper.columns(0, common.len());
        let right = &inverse * upper.column(common.len());
        for row in count..rest.nrows() {
            left.push((rest.row(row).iter().take(common.len()).copied().collect(), rest[(row, common.len())]));
        }
        eliminated.push(Group { columns, inverse, coupling, right });
    }
    if eliminated.is_empty() || common.is_empty() || left.len() < common.len() {
        return None;
    }
    let reduced = DMatrix::from_fn(left.len(), common.len(), |row, column| left[row].0[column]);
    let mut projected = DVector::from_iterator(left.len(), left.iter().map(|(_, value)| *value));
    let qr = reduced.qr();
    qr.q_tr_mul(&mut projected);
    let triangle = inverse(&qr.r())?;
    let of_common = &triangle * projected.rows(0, common.len());
    let known = &triangle * triangle.transpose();

    let mut values = DVector::zeros(matrix.ncols());
    let mut covariance = DMatrix::zeros(matrix.ncols(), matrix.ncols());
    for (row, place) in common.iter().enumerate() {
        values[*place] = of_common[row];
        common.iter().enumerate().for_each(|(column, other)| covariance[(*place, *other)] = known[(row, column)]);
    }
    for group in &eliminated {
        let own = &group.right - &group.coupling * &of_common;
        let with_common = &group.coupling * &known;
        let alone = &group.inverse * group.inverse.transpose();
        for (row, place) in group.columns.iter().enumerate() {
            values[*place] = own[row];
            for (column, other) in common.iter().enumerate() {
                covariance[(*place, *other)] = -with_common[(row, column)];
                covariance[(*other, *place)] = -with_common[(row, column)];
            }
            for (column, other) in group.columns.iter().enumerate() {
                covariance[(*place, *other)] = alone[(row, column)];
            }
        }
        for other in &eliminated {
            let between = &with_common * other.coupling.transpose();
            for (row, place) in group.columns.iter().enumerate() {
                for (column, place_of_other) in other.columns.iter().enumerate() {
                    covariance[(*place, *place_of_other)] += between[(row, column)];
                }
            }
        }
    }
    let condition = match condition {
        Some(condition) => condition,
        None => (largest(matrix.ncols(), |x| matrix.tr_mul(&(matrix * x)))
            * largest(matrix.ncols(), |x| &covariance * x))
        .sqrt(),
    };
    condition.is_finite().then_some(Eliminated { values, covariance, condition })
}

fn rows(matrix: &DMatrix<f64>, column: usize) -> impl Iterator<Item = usize> {
    matrix.column(column).into_iter().enumerate().filter(|(_, value)| **value != 0.0).map(|(row, _)| row)
}

/// Columns of few rows that share no row with such a column of another group.
fn groups(matrix: &DMatrix<f64>) -> Vec<Vec<usize>> {
    let mut group: Vec<usize> = (0..matrix.ncols()).collect();
    let mut first_of_row: Vec<Option<usize>> = vec![None; matrix.nrows()];
    let is_local: Vec<bool> =
        (0..matrix.ncols()).map(|column| rows(matrix, column).take(FEW_ROWS + 1).count() <= FEW_ROWS).collect();
    let root = |group: &[usize], mut column: usize| {
        while group[column] != column {
            column = group[column];
        }
        column
    };
    for column in (0..matrix.ncols()).filter(|column| is_local[*column]) {
        for row in rows(matrix, column) {
            match first_of_row[row] {
                Some(other) => {
                    let (one, other) = (root(&group, column), root(&group, other));
                    group[one.max(other)] = one.min(other);
                }
                None => first_of_row[row] = Some(column),
            }
        }
    }
    let mut groups: Vec<Vec<usize>> = vec![Vec::new(); matrix.ncols()];
    (0..matrix.ncols()).filter(|column| is_local[*column]).for_each(|column| groups[root(&group, column)].push(column));
    groups.into_iter().filter(|columns| (1..=FEW).contains(&columns.len())).collect()
}

fn inverse(triangle: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let inverse = triangle.solve_upper_triangular(&DMatrix::identity(triangle.nrows(), triangle.nrows()))?;
    inverse.iter().all(|value| value.is_finite()).then_some(inverse)
}

/// Largest eigenvalue of a positive matrix, from its products.
fn largest(count: usize, product: impl Fn(&DVector<f64>) -> DVector<f64>) -> f64 {
    // Not orthogonal to a vector of a symmetric problem.
    let mut x = DVector::from_fn(count, |index, _| 1.0 + 0.1 * (index % 7) as f64).normalize();
    let mut found = 0.0;
    for _ in 0..STEPS {
        let next = product(&x);
        let now = x.dot(&next);
        x = next.normalize();
        if (now - found).abs() <= SAME * now {
            return now;
        }
        found = now;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::solve;
    use nalgebra::{DMatrix, DVector};

    /// Forty groups of two unknowns in six rows each, three unknowns in common, five rows without a group.
    #[test]
    fn elimination_gives_what_the_whole_problem_gives() {
        let (groups, common) = (40, 3);
        let (count, rows) = (2 * groups + common, 6 * groups + 5);
        // Not a sine alone, of which any three are dependent.
        let value = |seed: usize| ((12.9898 * seed as f64).sin() * 43_758.545_3).fract();
        let mut matrix = DMatrix::zeros(rows, count);
        for row in 0..rows {
            (0..common).for_each(|column| matrix[(row, 7 + column)] = value(1 + 31 * row + column));
            if row < 6 * groups {
                for k in 0..2 {
                    // The common columns stand among the others.
                    let place = 2 * (row / 6) + k;
                    matrix[(row, if place < 7 { place } else { place + common })] = value(5 + 17 * row + k);
                }
            }
        }
        for mut column in matrix.column_iter_mut() {
            column.normalize_mut();
        }
        let right = DVector::from_fn(rows, |row, _| value(3 + 7 * row));
        let found = solve(&matrix, &right, None).unwrap();
        let normal = matrix.tr_mul(&matrix);
        let covariance = normal.clone().try_inverse().unwrap();
        let values = &covariance * matrix.tr_mul(&right);
        assert!((found.values - values).amax() < 1e-10);
        assert!((found.covariance - &covariance).amax() < 1e-10);
        let singular = matrix.clone().svd(false, false).singular_values;
        let condition = singular.max() / singular.min();
        assert!((found.condition / condition - 1.0).abs() < 1e-3, "{} {condition}", found.condition);
        // A column twice.
        let last = matrix.column(8).into_owned();
        matrix.set_column(9, &last);
        assert!(solve(&matrix, &right, None).is_none_or(|found| found.condition > 1e7));
        assert!(solve(&DMatrix::identity(4, 4), &DVector::zeros(4), None).is_none());
    }
}
