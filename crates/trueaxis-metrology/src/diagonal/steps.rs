//! Single steps of one axis along the diagonals.

use super::Test;
use std::vec::Vec;

/// A step of one axis over one interval, as measured on one diagonal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Step {
    pub(super) diagonal: usize,
    pub(super) axis: usize,
    /// Ends of the interval, low and high, mm.
    pub(super) ends_mm: [f64; 2],
    /// Change of the deviation when the axis moves from the low to the high end, mm.
    pub(super) change_mm: f64,
}

/// All steps between successive targets that moved a single axis.
pub(super) fn steps(test: &Test) -> Vec<Step> {
    let mut found = Vec::new();
    for (diagonal, own) in test.diagonals.iter().enumerate() {
        for pair in own.targets.windows(2) {
            let way = super::less(pair[1].position_mm, pair[0].position_mm);
            let size = super::dot(way, way).sqrt();
            let moved: Vec<usize> = (0..3).filter(|&axis| way[axis].abs() > 1e-6 * size).collect();
            let [axis] = moved[..] else { continue };
            let (from, to) = (pair[0].position_mm[axis], pair[1].position_mm[axis]);
            let sense = (to - from).signum();
            let change_mm = sense * (pair[1].mean() - pair[0].mean());
            found.push(Step { diagonal, axis, ends_mm: [from.min(to), from.max(to)], change_mm });
        }
    }
    found
}
