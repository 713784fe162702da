//! Six errors of a rotary axis from ball measurements while the control holds the tool tip (RTCP).
//!
//! A ball is mounted at the position of the tool tip. With RTCP on, the linear axes keep its centre in place while one rotary
//! axis turns; three gauges measure how far the centre has moved. Three or more set-ups with different levers separate the six
//! errors of the axis, independently at each angle.
//!
//! **Rows.** L is the vertical and H the horizontal distance of the ball's centre from the intersection of the rotary axes: at
//! axis position 0 the centre is L below it and H beside it. The deviation d (mm) of the centre, actual − ideal in machine
//! directions, is a twist about that intersection: d = e + w × p, e = (X, Y, Z) and w = (α, β, γ) in the frame of the axis'
//! carrier. For the axis C at angle C, p = R_z(C) (0, H, −L), and for A at angle A, p = R_x(A) (0, H, −L):
//!
//! ```text
//! C:  dx = X − L β − H cos C · γ                    A:  dx = X + (−L cos A + H sin A) β − (H cos A + L sin A) γ
//!     dy = Y + L α − H sin C · γ                        dy = Y + (L cos A − H sin A) α
//!     dz = Z + H cos C · α + H sin C · β                dz = Z + (H cos A + L sin A) α
//! ```
//!
//! For B, H is measured along +X: p = R_y(B) (H, 0, −L). The carrier must be parallel to the machine (C at 0 while A is
//! measured); otherwise the deviations must be rotated into its frame first.
//!
//! [`solve_angle`] solves one angle; it needs neither allocator nor `std`, and about 3 KiB of stack. With `std`, [`identify`]
//! solves a whole test: it pools the residual over the angles, gives standard errors, and can fit a constant offset per set-up
//! ([`Offsets::Free`]).
//!
//! All problems are solved by QR factorisation of scaled columns; the normal equations, which square the condition, are never
//! formed. Errors are those of the tool relative to the workpiece, as in error tables.
//!
//! # Example
//!
//! ```
//! use trueaxis::Axis;
//! use trueaxis_metrology::identification::{Ball, Observation, lever, solve_angle};
//!
//! // C tilts by 20 µrad about X at 30 degrees, and nothing else.
//! let angle = 30f64.to_radians();
//! let balls = [(250.0, 60.0), (250.0, 160.0), (350.0, 60.0)];
//! let seen = balls.map(|(vertical_mm, horizontal_mm)| {
//!     let ball = Ball { vertical_mm, horizontal_mm };
//!     let [_, y, z] = lever(Axis::C, angle, ball).unwrap();
//!     Observation { ball, deviation_mm: [0.0, -20e-6 * z, 20e-6 * y] }
//! });
//! let found = solve_angle(Axis::C, angle, &seen)?;
//! assert!((found.errors[3] - 20e-6).abs() < 1e-12 && found.errors[0].abs() < 1e-9);
//! # Ok::<(), trueaxis_metrology::identification::IdentificationRefusal>(())
//! ```
//!
//! Source: CN105479268A (rows, three set-ups an angle); Golub and Van Loan, Matrix Computations, 4th ed., sections 5.2 and
//! 5.3 (Householder QR, scaling), 6.5 (updating by rows).

mod angle;
mod ball;
#[cfg(feature = "std")]
mod ball_test;
#[cfg(feature = "std")]
mod free_offsets;
mod refused;

pub use angle::{AngleSolution, CONDITION_LIMIT, solve_angle};
#[cfg(feature = "std")]
pub use ball::{AngleReadings, BallTest};
pub use ball::{Ball, Observation, lever};
#[cfg(feature = "std")]
pub use ball_test::{Identified, IdentifiedAngle, Location, Offsets, identify};
pub use refused::IdentificationRefusal;

#[cfg(test)]
mod tests;
