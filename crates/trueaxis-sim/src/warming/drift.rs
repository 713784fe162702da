//! Drift of the tip from the bodies' temperatures: lengths, their expansion, and levers.

use super::bodies::{Bodies, Node};

/// Expansion of steel and iron, and of glass scales, 1/K.
const STEEL: f64 = 11.5e-6;
const GLASS: f64 = 8.0e-6;

/// Error of the tool relative to the workpiece, actual − ideal, mm, at X, Y, Z and with a tool of a given length, mm; zero
/// with all bodies at 20 °C.
pub(super) fn drift(bodies: &Bodies, [x, _, z, tool_mm]: [f64; 4]) -> [f64; 3] {
    let over = |node: Node| bodies.of(node) - 20.0;
    let (front, back) = (over(Node::ColumnFront), over(Node::ColumnBack));
    let head = 0.6 * over(Node::HeadCore) + 0.4 * over(Node::HeadSkin);
    // The column, 700 mm high and 480 mm deep, bends if its front is warmer; the nose tilts with the gradient in the head.
    let bend = STEEL * (front - back) / 480.0;
    let tilt = bend * 700.0 + 0.6e-6 * (over(Node::NoseCore) - over(Node::HeadSkin));
    // X: a ball screw instead of a scale; the table grows from its bearing.
    let ex = STEEL * over(Node::Screw) * x + STEEL * 50.0 * over(Node::Table);
    // Y: the bent column and the head, which extends 330 mm forward, minus the bed below.
    let ey = 0.5 * bend * 700.0 * 700.0 + STEEL * 330.0 * head - STEEL * 280.0 * over(Node::BedTop) + tilt * tool_mm;
    // Z: the spindle grows down, the column up, the table up; a glass scale on the column.
    let nose = 0.7 * over(Node::NoseCore) + 0.3 * over(Node::NoseSkin);
    let ez = -STEEL * 190.0 * nose - STEEL * 90.0 * over(Node::HeadCore) + STEEL * 650.0 * 0.5 * (front + back)
        - STEEL * 260.0 * over(Node::Table)
        - STEEL * 180.0 * over(Node::BedTop)
        + GLASS * front * z;
    [ex, ey, ez]
}
