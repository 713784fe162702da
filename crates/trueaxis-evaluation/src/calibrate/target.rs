//! A point to touch, and where to approach it from.

use super::task::Task;

/// Clearance above an artefact for moves over it, mm.
const CLEAR: f64 = 10.0;
/// Height above that at which the probe waits, mm.
pub(super) const CLEAR_ABOVE: f64 = 20.0;

pub(super) fn clear_mm(task: &Task) -> f64 {
    task.probe.approach_mm.max(task.probe.take_up_mm) + CLEAR
}

/// A point to touch, in positions and directions of X, Y, Z.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Target {
    /// See [`super::plan::Planned::feature`].
    pub(super) feature: usize,
    /// Centre of the tip at the nominal surface.
    pub(super) point: [f64; 3],
    /// Direction of the probing move, of length 1.
    pub(super) approach: [f64; 3],
    /// For each axis that does not probe: whether it moves to the start in the negative direction.
    pub(super) from_above: [bool; 3],
    /// Where the probe waits between touches.
    pub(super) home: [f64; 3],
    /// Where the probe enters and leaves.
    pub(super) entry: [f64; 3],
    /// Between home and the start the probe moves at home's height along this direction.
    pub(super) lift: Option<[f64; 3]>,
    /// A, B, C.
    pub(super) pose: [f64; 3],
}
