//! A whole test of an axis: all angles, with a pooled residual.

use super::angle::solve_angle;
use super::ball::{BallTest, Observation};
use super::free_offsets::{Solved, with_free_offsets};
use super::refused::IdentificationRefusal;
use std::vec::Vec;
use trueaxis::Axis;
use trueaxis::machine::Twist;

/// Knowledge of the gauges' zero in each set-up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Offsets {
    /// Readings are deviations from the ball's ideal position: no offset is free.
    #[default]
    Known,
    /// Each set-up has one unknown offset for all angles, constant in machine directions (the gauges were re-zeroed).
    ///
    /// Not all errors are then observable. A convention fixes the rest: ΣX = ΣY = ΣZ = 0 over the angles; for A also the
    /// patterns β = −k1 cos A + k2 sin A, γ = −k1 sin A − k2 cos A, at their minimum norm (for B α = k1 sin B − k2 cos B, γ =
    /// k1 cos B + k2 sin B). These patterns rotate with the axis, so that every ball keeps a constant deviation.
    Free,
}

/// Whether the errors found include the location errors of the axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Location {
    /// The errors include them: means over the circle are retained, and a table with these errors must not be combined with
    /// location errors in the machine's settings.
    Inside,
    /// The constant part of X Y Z is removed, for A and B also the tilt that rotates with the axis; constant α β γ remain as
    /// far as that convention leaves them.
    Removed,
}

/// Errors at one angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IdentifiedAngle {
    /// Angle of the axis, rad.
    pub angle_rad: f64,
    /// X Y Z in mm, α β γ in rad.
    pub errors: Twist,
    /// Standard errors of `errors`, from the pooled sigma; mm and rad.
    pub standard_errors: Twist,
    /// Covariance of `errors` of this angle. With [`Offsets::Known`] the errors of different angles are independent, apart from
    /// the common sigma; with [`Offsets::Free`] they are correlated by the offsets and the convention, which it includes, but it
    /// does not show the covariance of one angle with another.
    pub covariance: [Twist; 6],
    /// Numerical rank of the scaled columns.
    pub rank: u8,
    /// Condition number of the scaled columns.
    pub condition: f64,
    /// Root mean square of the residuals, mm.
    pub residual_mm: f64,
}

/// Errors of an axis over its angles.
#[derive(Clone, Debug, PartialEq)]
pub struct Identified {
    /// The axis.
    pub axis: Axis,
    /// Results in the order of the test's angles.
    pub angles: Vec<IdentifiedAngle>,
    /// Standard deviation of one reading, from the residuals of all angles together, mm.
    ///
    /// One angle of three set-ups has only three degrees of freedom: in nine cases of ten the sigma of one angle is 0.34 to
    /// 1.6 times the true one, otherwise it is worse.
    pub sigma_mm: f64,
    /// Number of readings in excess of the unknowns.
    pub degrees_of_freedom: usize,
    /// Whether the errors include location errors.
    pub location: Location,
    /// Fitted offsets, mm, one per set-up; empty with [`Offsets::Known`].
    pub offsets_mm: Vec<[f64; 3]>,
    /// Number of combinations of errors and offsets that no reading observes, found numerically and fixed by the convention; 0
    /// with [`Offsets::Known`].
    pub null_space: usize,
}

/// Identifies the errors of the axis at all angles of a test.
///
/// With [`Offsets::Known`] each angle is [`solve_angle`]; with [`Offsets::Free`] all angles and the offsets form one
/// least-squares problem, decomposed by eliminating the six errors of each angle. Standard errors come from the residual
/// pooled over all angles.
///
/// # Errors
/// All refusals of [`solve_angle`], an angle without a reading for every set-up, and free offsets that the angles cannot
/// separate from errors.
pub fn identify(test: &BallTest, offsets: Offsets) -> Result<Identified, IdentificationRefusal> {
    if test.angles.is_empty() {
        return Err(IdentificationRefusal::NoAngles);
    }
    let mut angles = Vec::with_capacity(test.angles.len());
    let mut factors = Vec::with_capacity(test.angles.len());
    let (mut squares, mut degrees_of_freedom) = (0.0, 0);
    for (angle, readings) in test.angles.iter().enumerate() {
        if readings.deviations_mm.len() != test.balls.len() {
            return Err(IdentificationRefusal::Readings {
                angle,
                found: readings.deviations_mm.len(),
                needed: test.balls.len(),
            });
        }
        let pairs = test.balls.iter().zip(&readings.deviations_mm);
        let seen: Vec<Observation> = pairs.map(|(&ball, &deviation_mm)| Observation { ball, deviation_mm }).collect();
        let found = solve_angle(test.axis, readings.angle_rad, &seen)?;
        squares += found.squared_residuals_mm2;
        degrees_of_freedom += found.degrees_of_freedom();
        factors.push((found.standard_error_factors, found.covariance_factors));
        angles.push(IdentifiedAngle {
            angle_rad: readings.angle_rad,
            errors: found.errors,
            standard_errors: [0.0; 6],
            covariance: [[0.0; 6]; 6],
            rank: found.rank,
            condition: found.condition,
            residual_mm: found.residual_mm(),
        });
    }
    let mut identified = Identified {
        axis: test.axis,
        angles,
        sigma_mm: 0.0,
        degrees_of_freedom,
        location: Location::Inside,
        offsets_mm: Vec::new(),
        null_space: 0,
    };
    if offsets == Offsets::Free {
        let free = with_free_offsets(test)?;
        squares = free.squared_residuals_mm2;
        identified.degrees_of_freedom = free.degrees_of_freedom;
        identified.location = Location::Removed;
        identified.offsets_mm = free.offsets_mm;
        identified.null_space = free.null_space;
        for (angle, solved) in identified.angles.iter_mut().zip(&free.angles) {
            angle.errors = solved.errors;
            angle.residual_mm = solved.residual_mm;
        }
        let both = |solved: Solved| (solved.standard_error_factors, solved.covariance_factors);
        factors = free.angles.into_iter().map(both).collect();
    }
    identified.sigma_mm = (squares / identified.degrees_of_freedom.max(1) as f64).sqrt();
    let sigma = identified.sigma_mm;
    for (angle, (errors, covariance)) in identified.angles.iter_mut().zip(factors) {
        angle.standard_errors = errors.map(|factor| factor * sigma);
        angle.covariance = covariance.map(|row| row.map(|factor| factor * sigma * sigma));
    }
    Ok(identified)
}
