//! Constant offsets of the set-ups, solved together with the errors of all angles.
//!
//! ```text
//! d_sk = e_k + w_k × p_sk + o_s        angle k, set-up s;  A_k x_k + o = d_k  with x_k = (e_k, w_k)
//! ```
//!
//! Householder reflections of A_k eliminate x_k from all rows except six. The remaining rows of all angles form a
//! least-squares problem for the offsets only, whose triangle is updated angle by angle. That problem has a null space of 3
//! (C) or 5 (A, B) dimensions; the minimum-norm solution is shifted along the null space until it satisfies the convention of
//! `Offsets::Free`. Work and memory grow linearly with the number of angles, not with its cube and square.

use super::angle::{CONDITION_LIMIT, SWEEPS};
use super::ball::{AngleReadings, BallTest, lever, rows};
use super::refused::IdentificationRefusal;
use nalgebra::{DMatrix, DVector, QR};
use std::{vec, vec::Vec};
use trueaxis::Axis;
use trueaxis::machine::Twist;

/// Steps of iterative refinement; each gains as many digits as the decomposition has.
const REFINEMENTS: usize = 3;

/// One angle of the joint solution.
pub(super) struct Solved {
    pub(super) errors: Twist,
    pub(super) standard_error_factors: Twist,
    pub(super) covariance_factors: [Twist; 6],
    pub(super) residual_mm: f64,
}

/// The joint solution.
pub(super) struct Free {
    pub(super) angles: Vec<Solved>,
    pub(super) offsets_mm: Vec<[f64; 3]>,
    pub(super) squared_residuals_mm2: f64,
    pub(super) degrees_of_freedom: usize,
    pub(super) null_space: usize,
}

/// One angle after elimination of its six errors: x = own − through · o.
struct Eliminated {
    own: DVector<f64>,
    /// R⁻¹ Q₁ᵀ, 6 × 3S.
    through: DMatrix<f64>,
    /// R⁻¹ R⁻ᵀ, 6 × 6.
    scatter: DMatrix<f64>,
    /// The functionals that the convention sets to zero, summed over the angles; one row each.
    gauge: DMatrix<f64>,
}

/// Solves all angles with one free offset per set-up; the readings have been checked and each angle has full rank.
pub(super) fn with_free_offsets(test: &BallTest) -> Result<Free, IdentificationRefusal> {
    let size = 3 * test.balls.len();
    let needed = if test.axis == Axis::C { 3 } else { 5 };
    let mut eliminated = Vec::with_capacity(test.angles.len());
    let mut triangle = DMatrix::<f64>::zeros(size + 1, size + 1);
    for readings in &test.angles {
        let (angle, rest) = eliminate(test, readings, needed)?;
        let mut stack = DMatrix::zeros(size + 1 + size - 6, size + 1);
        stack.rows_mut(0, size + 1).copy_from(&triangle);
        stack.rows_mut(size + 1, size - 6).copy_from(&rest);
        triangle = QR::new(stack).r();
        eliminated.push(angle);
    }

    let right = triangle.view((0, size), (size, 1)).into_owned();
    let left_over = triangle[(size, size)];
    let matrix = triangle.view((0, 0), (size, size)).into_owned();
    let svd = matrix.clone().try_svd(true, true, f64::EPSILON, SWEEPS).ok_or(IdentificationRefusal::NoConvergence)?;
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Err(IdentificationRefusal::NoConvergence) };
    let floor = svd.singular_values.max() / CONDITION_LIMIT;
    let unseen: Vec<usize> = (0..size).filter(|&i| svd.singular_values[i] <= floor).collect();
    let readings = size * test.angles.len();
    let unknowns = (6 * test.angles.len() + size).saturating_sub(needed);
    if unseen.len() != needed || readings <= unknowns {
        return Err(IdentificationRefusal::Offsets { found: unseen.len(), needed });
    }
    let inverse_singular = svd.singular_values.map(|value| if value > floor { 1.0 / value } else { 0.0 });
    let root = v_t.tr_mul(&DMatrix::from_diagonal(&inverse_singular));
    let scatter = &root * root.transpose();
    // The factors of the decomposition may be off by far more than rounding: solutions with them are refined.
    let pseudo_inverse = &root * u.transpose();
    let mut offsets = &pseudo_inverse * &right;
    let mut null = DMatrix::from_fn(size, needed, |i, j| v_t[(unseen[j], i)]);
    for _ in 0..REFINEMENTS {
        offsets += &pseudo_inverse * (&right - &matrix * &offsets);
        null -= &pseudo_inverse * (&matrix * &null);
    }

    // The functionals of the minimum-norm solution, and their derivatives along the null space.
    let mut value = DVector::<f64>::zeros(needed);
    let mut slope = DMatrix::<f64>::zeros(needed, needed);
    let mut through = DMatrix::<f64>::zeros(needed, size);
    let mut own = DMatrix::<f64>::zeros(needed, needed);
    for angle in &eliminated {
        value += &angle.gauge * (&angle.own - &angle.through * offsets.column(0));
        through += &angle.gauge * &angle.through;
        own += &angle.gauge * &angle.scatter * angle.gauge.transpose();
    }
    slope -= &through * &null;
    let turn = slope.full_piv_lu().try_inverse().ok_or(IdentificationRefusal::Offsets { found: needed + 1, needed })?;
    let offsets = offsets.column(0) - &null * (&turn * value);
    let spread = own + &through * &scatter * through.transpose();

    let mut squares = left_over * left_over;
    let mut angles = Vec::with_capacity(eliminated.len());
    squares += unseen.iter().map(|&i| u.column(i).dot(&right.column(0)).powi(2)).sum::<f64>();
    for (angle, readings) in eliminated.iter().zip(&test.angles) {
        let found = &angle.own - &angle.through * &offsets;
        // x = x₀ − G T Σ g_j x₀_j, with G = −through · null: the covariance of the three together.
        let back = &angle.through * &null * &turn;
        let cross = &angle.gauge * &angle.scatter + &through * &scatter * angle.through.transpose();
        let mixed = &back * cross;
        let covariance = &angle.scatter
            + &angle.through * &scatter * angle.through.transpose()
            + &mixed
            + mixed.transpose()
            + &back * &spread * back.transpose();
        let errors: Twist = std::array::from_fn(|i| found[i]);
        angles.push(Solved {
            errors,
            standard_error_factors: std::array::from_fn(|i| covariance[(i, i)].max(0.0).sqrt()),
            covariance_factors: std::array::from_fn(|i| std::array::from_fn(|j| covariance[(i, j)])),
            residual_mm: residual(test, readings.angle_rad, &readings.deviations_mm, &errors, &offsets),
        });
    }
    let offsets_mm = (0..test.balls.len()).map(|s| std::array::from_fn(|i| offsets[3 * s + i])).collect();
    Ok(Free {
        angles,
        offsets_mm,
        squared_residuals_mm2: squares,
        degrees_of_freedom: readings - unknowns,
        null_space: unseen.len(),
    })
}

/// Eliminates the six errors of an angle from its equations: returns their part, and the rows that remain for the offsets.
fn eliminate(
    test: &BallTest,
    readings: &AngleReadings,
    needed: usize,
) -> Result<(Eliminated, DMatrix<f64>), IdentificationRefusal> {
    let size = 3 * test.balls.len();
    let mut design = DMatrix::<f64>::zeros(size, 6);
    let mut right = DMatrix::<f64>::identity(size, size + 1);
    for (s, (&ball, deviation)) in test.balls.iter().zip(&readings.deviations_mm).enumerate() {
        let arm = lever(test.axis, readings.angle_rad, ball).ok_or(IdentificationRefusal::NotRotary(test.axis))?;
        for (i, (row, value)) in rows(arm).into_iter().zip(deviation).enumerate() {
            right[(3 * s + i, size)] = *value;
            for (j, coefficient) in row.into_iter().enumerate() {
                design[(3 * s + i, j)] = coefficient;
            }
        }
    }
    let lengths: Vec<f64> = design.column_iter().map(|column| column.norm()).collect();
    for (mut column, length) in design.column_iter_mut().zip(&lengths) {
        column /= *length;
    }
    let factors = QR::new(design);
    factors.q_tr_mul(&mut right);
    let mut inverse = factors
        .r()
        .solve_upper_triangular(&DMatrix::identity(6, 6))
        .ok_or(IdentificationRefusal::Offsets { found: size, needed })?;
    for (mut row, length) in inverse.row_iter_mut().zip(&lengths) {
        row /= *length;
    }
    let solved = &inverse * right.rows(0, 6);
    let angle = Eliminated {
        own: solved.column(size).into_owned(),
        through: solved.columns(0, size).into_owned(),
        scatter: &inverse * inverse.transpose(),
        gauge: gauge(test.axis, readings.angle_rad),
    };
    Ok((angle, right.rows(6, size - 6).into_owned()))
}

/// Rows that the convention sets to zero in sum over the angles: X, Y, Z, and the product with each pattern.
fn gauge(axis: Axis, angle_rad: f64) -> DMatrix<f64> {
    let (sin, cos) = libm::sincos(angle_rad);
    let mut rows = vec![[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]];
    match axis {
        Axis::A => rows.extend([[0.0, 0.0, 0.0, 0.0, -cos, -sin], [0.0, 0.0, 0.0, 0.0, sin, -cos]]),
        Axis::B => rows.extend([[0.0, 0.0, 0.0, sin, 0.0, cos], [0.0, 0.0, 0.0, -cos, 0.0, sin]]),
        _ => {}
    }
    DMatrix::from_row_iterator(rows.len(), 6, rows.into_iter().flatten())
}

/// Root mean square of an angle's residuals, mm.
fn residual(
    test: &BallTest,
    angle_rad: f64,
    deviations_mm: &[[f64; 3]],
    errors: &Twist,
    offsets: &DVector<f64>,
) -> f64 {
    let mut squares = 0.0;
    for (s, (&ball, deviation)) in test.balls.iter().zip(deviations_mm).enumerate() {
        let arm = lever(test.axis, angle_rad, ball).unwrap_or_default();
        for (i, (row, value)) in rows(arm).into_iter().zip(deviation).enumerate() {
            let model: f64 = row.iter().zip(errors).map(|(coefficient, error)| coefficient * error).sum();
            squares += (value - model - offsets[3 * s + i]).powi(2);
        }
    }
    (squares / (3 * deviations_mm.len().max(1)) as f64).sqrt()
}
