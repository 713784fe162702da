//! Position of the ball, and the readings there.

#![deny(clippy::indexing_slicing)]

#[cfg(feature = "std")]
use std::vec::Vec;
use trueaxis::Axis;

/// Centre of the ball at position 0 of the measured axis, from the intersection of the rotary axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// L, mm, positive downward (−Z).
    pub vertical_mm: f64,
    /// H, mm, positive along +Y for A and C, along +X for B.
    pub horizontal_mm: f64,
}

/// One reading of the three gauges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// The set-up.
    pub ball: Ball,
    /// Deviation of the ball's centre, actual − ideal, tool relative to workpiece, X Y Z in mm.
    pub deviation_mm: [f64; 3],
}

/// Returns the lever of the ball's centre at an angle of the axis, mm in the carrier's directions; `None` for a linear axis.
///
/// A: R_x (0, H, −L); B: R_y (H, 0, −L); C: R_z (0, H, −L); `angle_rad` is right-handed about the axis.
pub fn lever(axis: Axis, angle_rad: f64, ball: Ball) -> Option<[f64; 3]> {
    let (sin, cos) = libm::sincos(angle_rad);
    let (l, h) = (ball.vertical_mm, ball.horizontal_mm);
    match axis {
        Axis::A => Some([0.0, h * cos + l * sin, h * sin - l * cos]),
        Axis::B => Some([h * cos - l * sin, 0.0, -h * sin - l * cos]),
        Axis::C => Some([-h * sin, h * cos, -l]),
        Axis::X | Axis::Y | Axis::Z => None,
    }
}

/// Coefficients of X Y Z α β γ in the three rows of a lever, d = e + w × p.
pub(super) fn rows([x, y, z]: [f64; 3]) -> [[f64; 6]; 3] {
    [[1.0, 0.0, 0.0, 0.0, z, -y], [0.0, 1.0, 0.0, -z, 0.0, x], [0.0, 0.0, 1.0, y, -x, 0.0]]
}

/// Readings of all set-ups at one angle.
#[cfg(feature = "std")]
#[derive(Clone, Debug, PartialEq)]
pub struct AngleReadings {
    /// Angle of the axis, rad, right-handed about it.
    pub angle_rad: f64,
    /// Deviations of the ball's centre, actual − ideal in mm, in the order of the set-ups.
    pub deviations_mm: Vec<[f64; 3]>,
}

/// A ball test of one rotary axis: every set-up measured at every angle.
#[cfg(feature = "std")]
#[derive(Clone, Debug, PartialEq)]
pub struct BallTest {
    /// The axis that turns.
    pub axis: Axis,
    /// The set-ups, three or more.
    pub balls: Vec<Ball>,
    /// The angles.
    pub angles: Vec<AngleReadings>,
}
