//! Six errors at one angle, in fixed memory.

#![deny(clippy::indexing_slicing)]

use super::ball::{Ball, Observation, lever, rows};
use super::refused::IdentificationRefusal;
use nalgebra::{Matrix6, SMatrix, Vector6};
use trueaxis::Axis;
use trueaxis::machine::Twist;

/// Largest condition number of the scaled columns that is accepted.
///
/// Above it the errors are ten thousand times less accurate than the gauge's readings; balls 250 mm from the axis are then
/// closer than about 0.03 mm to one line (three of them over 100 mm).
pub const CONDITION_LIMIT: f64 = 1e4;

/// Bound on the iteration for the singular values; six converge in about a dozen sweeps.
pub(super) const SWEEPS: usize = 1000;

/// Errors of a rotary axis at one angle, with their standard errors and condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngleSolution {
    /// X Y Z in mm, α β γ in rad: actual − ideal, tool relative to workpiece, in the carrier's directions.
    pub errors: Twist,
    /// Standard errors for readings of 1 mm standard deviation: the root of the diagonal of (AᵀA)⁻¹, mm/mm and rad/mm.
    pub standard_error_factors: Twist,
    /// (AᵀA)⁻¹: the covariance of the errors for readings of 1 mm standard deviation.
    pub covariance_factors: [Twist; 6],
    /// Numerical rank of the scaled columns; 6 in every solution.
    pub rank: u8,
    /// Condition number of the scaled columns, at most [`CONDITION_LIMIT`].
    pub condition: f64,
    /// Sum of the squared residuals, mm².
    pub squared_residuals_mm2: f64,
    /// Number of readings: three per set-up.
    pub readings: usize,
}

impl AngleSolution {
    /// Returns the root mean square of the residuals, mm.
    pub fn residual_mm(&self) -> f64 {
        libm::sqrt(self.squared_residuals_mm2 / self.readings.max(1) as f64)
    }

    /// Returns the number of readings in excess of the six errors.
    pub fn degrees_of_freedom(&self) -> usize {
        self.readings.saturating_sub(6)
    }
}

/// Solves the errors of `axis` at `angle_rad` by least squares from three or more set-ups.
///
/// min Σ |e + w × p − d|². The columns are scaled to unit length; readings enter a triangle of seven columns three rows at a
/// time by Householder reflections, so that any number of set-ups needs the same 10 × 7 numbers. Exact readings are reproduced
/// within 1e-13 of the largest times the condition number. Cost: about 500 multiplications per set-up, and one singular value
/// decomposition of 6 × 6.
///
/// # Errors
/// A linear axis, fewer than three set-ups, values that are not finite, and set-ups that cannot separate the six errors.
pub fn solve_angle(
    axis: Axis,
    angle_rad: f64,
    observations: &[Observation],
) -> Result<AngleSolution, IdentificationRefusal> {
    if !axis.is_rotary() {
        return Err(IdentificationRefusal::NotRotary(axis));
    }
    if observations.len() < 3 {
        return Err(IdentificationRefusal::TooFewSetUps { found: observations.len() });
    }
    let levers = || {
        let of = move |seen: &Observation| lever(axis, angle_rad, seen.ball).unwrap_or_default();
        observations.iter().map(move |seen| (rows(of(seen)), seen.deviation_mm))
    };
    let mut squares = [0.0; 6];
    for (set_up, (rows, deviation)) in levers().enumerate() {
        for row in rows {
            for (square, value) in squares.iter_mut().zip(row) {
                *square += value * value;
            }
        }
        if !squares.iter().chain(&deviation).all(|value| value.is_finite()) {
            return Err(IdentificationRefusal::NotFinite { set_up });
        }
    }
    // A zero column (balls on the axis itself) is not scaled: the rank reveals it.
    let lengths = squares.map(|square| if square > 0.0 { libm::sqrt(square) } else { 1.0 });
    let mut triangle = SMatrix::<f64, 7, 7>::zeros();
    for (rows, deviation) in levers() {
        let mut stack = SMatrix::<f64, 10, 7>::zeros();
        stack.fixed_view_mut::<7, 7>(0, 0).copy_from(&triangle);
        for (i, (row, value)) in rows.into_iter().zip(deviation).enumerate() {
            let scaled = row.into_iter().zip(lengths).map(|(value, length)| value / length).chain([value]);
            for (slot, value) in stack.row_mut(7 + i).iter_mut().zip(scaled) {
                *slot = value;
            }
        }
        triangle = stack.qr().r();
    }
    let factor: Matrix6<f64> = triangle.fixed_view::<6, 6>(0, 0).into_owned();
    let right: Vector6<f64> = triangle.fixed_view::<6, 1>(0, 6).into_owned();
    let left_over: f64 = triangle.fixed_view::<1, 1>(6, 6).x;
    let singular =
        factor.try_svd(false, false, f64::EPSILON, SWEEPS).ok_or(IdentificationRefusal::NoConvergence)?.singular_values;
    let (largest, smallest) = (singular.max(), singular.min());
    let rank = singular.iter().filter(|&&value| value * CONDITION_LIMIT >= largest).count() as u8;
    let condition = if smallest > f64::EPSILON * largest { largest / smallest } else { f64::INFINITY };
    let (true, Some(scaled), Some(inverse)) =
        (rank == 6, factor.solve_upper_triangular(&right), factor.solve_upper_triangular(&Matrix6::identity()))
    else {
        let (along_mm, off_mm) = extent(observations.iter().map(|seen| seen.ball));
        return Err(IdentificationRefusal::Collinear { along_mm, off_mm, rank, condition });
    };
    let mut errors = [0.0; 6];
    let mut standard_error_factors = [0.0; 6];
    let solved = scaled.iter().zip(inverse.row_iter()).zip(lengths);
    for ((error, factor), ((value, row), length)) in errors.iter_mut().zip(&mut standard_error_factors).zip(solved) {
        *error = value / length;
        *factor = libm::sqrt(row.iter().map(|value| value * value).sum()) / length;
    }
    // R⁻¹R⁻ᵀ of the scaled columns.
    let scaled = inverse * inverse.transpose();
    let mut covariance_factors = [[0.0; 6]; 6];
    for ((row, length), scaled) in covariance_factors.iter_mut().zip(lengths).zip(scaled.row_iter()) {
        for ((entry, other), scaled) in row.iter_mut().zip(lengths).zip(scaled.iter()) {
            *entry = scaled / (length * other);
        }
    }
    Ok(AngleSolution {
        errors,
        standard_error_factors,
        covariance_factors,
        rank,
        condition,
        squared_residuals_mm2: left_over * left_over,
        readings: 3 * observations.len(),
    })
}

/// Extent of the points along their best-fitting line, and the largest distance from it, mm.
fn extent(balls: impl Iterator<Item = Ball> + Clone) -> (f64, f64) {
    let count = balls.clone().count().max(1) as f64;
    let points = balls.map(|ball| [ball.vertical_mm, ball.horizontal_mm]);
    let [l, h] = points.clone().fold([0.0, 0.0], |sum, [l, h]| [sum[0] + l / count, sum[1] + h / count]);
    let centred = points.map(|point| [point[0] - l, point[1] - h]);
    let [a, b, c] = centred.clone().fold([0.0; 3], |sum, [x, y]| [sum[0] + x * x, sum[1] + x * y, sum[2] + y * y]);
    let (sin, cos) = libm::sincos(0.5 * libm::atan2(2.0 * b, a - c));
    let (mut low, mut high, mut off) = (0f64, 0f64, 0f64);
    for [x, y] in centred {
        let along = x * cos + y * sin;
        low = low.min(along);
        high = high.max(along);
        off = off.max(libm::fabs(y * cos - x * sin));
    }
    (high - low, off)
}
