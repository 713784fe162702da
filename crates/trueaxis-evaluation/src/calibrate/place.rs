//! Where artefacts are set up.

use trueaxis::machine::Axis;

/// Where an artefact is set up.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// X, Y, Z of the machine with the tip's centre at the artefact's origin: centre of a ring or ball, first ball of a ball
    /// plate, middle of a plate of unknown places, first face of a gauge, corner of a square; mm.
    pub at_mm: [f64; 3],
    /// All but balls: direction normal to it (gauge: to its row), along which the probe retracts.
    pub normal: Axis,
    /// Gauge and square: direction of the row or the first arm; along Z it points down, as does an upright second arm. Block:
    /// axis of its first length.
    pub along: Axis,
    /// Block: axis of its second length.
    pub across: Axis,
    /// Square: whether it is turned over about its second arm. Block: about its second length.
    pub reversed: bool,
    /// Block: whether the surface under it is touched, beside it.
    pub base: bool,
    /// Plate of unknown places: quarter turns about the normal.
    pub turn: u8,
    /// A, B, C at which a ball is measured, degrees.
    pub rotary_deg: Vec<[f64; 3]>,
    /// Length of the stylus that touches it, from the spindle's nose to the centre of the tip, mm; `None`: the machine's tool.
    pub stylus_mm: Option<f64>,
    /// Line in the task file.
    pub line: u32,
}

/// Direction of a linear axis, 0 to 2.
pub(super) fn unit(axis: usize) -> [f64; 3] {
    std::array::from_fn(|k| f64::from(u8::from(k == axis)))
}

/// Two directions that make a right-handed system with a third.
pub(super) fn across(normal: Axis) -> [[f64; 3]; 2] {
    match normal {
        Axis::X => [1, 2],
        Axis::Y => [2, 0],
        _ => [0, 1],
    }
    .map(unit)
}

/// Rounds to a tenth of a micrometre, as a program prints a position.
pub(super) fn printed(mm: f64) -> f64 {
    (mm * 1e4).round() / 1e4
}
