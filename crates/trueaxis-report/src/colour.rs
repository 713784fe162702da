//! Colours, identical in every figure; they remain distinct for colour-blind readers and in grey print.

/// A colour in sRGB: red, green, blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour(pub u8, pub u8, pub u8);

/// Measured profiles and points.
pub const MEASURED: Colour = Colour(31, 36, 48);
/// The programmed path and reference circles.
pub const NOMINAL: Colour = Colour(107, 114, 128);
/// Scales, single revolutions, residuals.
pub const GREY: Colour = Colour(150, 156, 165);
/// Without compensation.
pub const UNCOMPENSATED: Colour = Colour(213, 94, 0);
/// With compensation.
pub const COMPENSATED: Colour = Colour(0, 90, 170);
/// Perfect geometry.
pub const SERVO: Colour = Colour(0, 140, 100);
/// Corrections and latencies, which belong to no run.
pub const NEUTRAL: Colour = Colour(92, 72, 150);
/// A fourth curve beside the three of [`AXES`]; the full run.
pub const FOURTH: Colour = Colour(130, 70, 160);
/// Limits, budgets, periods, suppressed harmonics.
pub const LIMIT: Colour = Colour(160, 20, 40);
/// Directions X, Y and Z.
pub const AXES: [Colour; 3] = [COMPENSATED, UNCOMPENSATED, SERVO];

pub(crate) const TEXT: Colour = Colour(51, 56, 64);
pub(crate) const MESH: Colour = Colour(228, 231, 235);
pub(crate) const EDGE: Colour = Colour(120, 126, 135);
pub(crate) const WHITE: Colour = Colour(255, 255, 255);
