//! The programmed path as points for drawing.

use crate::program::Curve;
use crate::scenario::Scenario;
use glam::DVec3;

/// A point of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnPoint {
    /// Position in machine coordinates (with rotary axes: in workpiece coordinates), mm.
    pub position_mm: [f64; 3],
    /// Program line.
    pub line: u32,
    /// Whether the move cuts rather than positions at rapid.
    pub cutting: bool,
}

/// Returns both ends of every straight move; other moves are divided into about `parts` stretches equal in the curve's
/// parameter.
///
/// Cost: one evaluation of the curve per point.
pub fn drawn(scenario: &Scenario, parts: u32) -> Vec<DrawnPoint> {
    let origin = DVec3::from(scenario.origin_mm);
    let mut points = Vec::new();
    for step in &scenario.program.moves {
        let straight = matches!(step.curve, Curve::Line { .. }) && !scenario.five_axis;
        let breaks = step.curve.breaks();
        // A spline has many pieces, some of them short.
        let parts = if straight { 1 } else { parts.div_ceil(breaks.len() as u32 - 1).max(4) };
        for (piece, ends) in breaks.windows(2).enumerate() {
            points.extend((u32::from(piece > 0)..=parts).map(|i| {
                let u = ends[0] + (ends[1] - ends[0]) * f64::from(i) / f64::from(parts);
                let position = match scenario.five_axis {
                    true => scenario.placement.place(step, u).tip,
                    false => DVec3::from(step.curve.position(u)) + origin,
                };
                DrawnPoint { position_mm: position.to_array(), line: step.line, cutting: !step.rapid }
            }));
        }
    }
    points
}
