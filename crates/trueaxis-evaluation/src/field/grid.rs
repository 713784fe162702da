//! Points over the travel of the linear axes.

use crate::model::{is_declared, range};
use anyhow::{Result, bail};
use serde::Deserialize;
use trueaxis_tables::Machine;

/// Maximum number of points along one axis.
pub const MOST_POINTS: usize = 51;
const FEWEST_POINTS: usize = 2;

/// Number of points along the linear axes: one for all, or one each for X, Y and Z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged)]
pub enum Points {
    /// Along every axis.
    Every(usize),
    /// Along X, Y, Z.
    Each([usize; 3]),
}

impl Default for Points {
    fn default() -> Self {
        Points::Every(11)
    }
}

/// A grid over the working volume.
pub(crate) struct Grid {
    pub(crate) points: [usize; 3],
    /// Low and high end along X, Y, Z, mm.
    pub(crate) range: [[f64; 2]; 3],
}

impl Grid {
    /// An axis that the machine does not have is at zero.
    pub(crate) fn new(machine: &Machine, points: Points) -> Result<Grid> {
        let asked = match points {
            Points::Every(count) => [count; 3],
            Points::Each(counts) => counts,
        };
        let mut grid = Grid { points: [1; 3], range: [[0.0; 2]; 3] };
        for (own, table) in machine.axes().filter(|(own, _)| !own.axis.is_rotary()) {
            let (index, letter) = (own.axis.index(), own.axis.letter());
            if !is_declared(own) && table.is_none() {
                bail!("axis {letter}: found neither a declared travel nor a table, needed one for the working volume");
            }
            let count = asked[index];
            if !(FEWEST_POINTS..=MOST_POINTS).contains(&count) {
                bail!("points along {letter}: found {count}, needed {FEWEST_POINTS} to {MOST_POINTS}");
            }
            grid.points[index] = count;
            grid.range[index] = range(own, table);
        }
        Ok(grid)
    }

    pub(crate) fn count(&self) -> usize {
        self.points.iter().product()
    }

    /// Indices along X, Y, Z of a point; X changes fastest.
    pub(crate) fn indices(&self, index: usize) -> [usize; 3] {
        let [nx, ny, _] = self.points;
        [index % nx, index / nx % ny, index / (nx * ny)]
    }

    /// Position of an index along an axis, mm; exact at both ends.
    pub(crate) fn along(&self, axis: usize, index: usize) -> f64 {
        let ([low, high], last) = (self.range[axis], self.points[axis] - 1);
        if index == last && last > 0 { high } else { low + (high - low) * index as f64 / last.max(1) as f64 }
    }

    pub(crate) fn at(&self, index: usize) -> [f64; 3] {
        let indices = self.indices(index);
        std::array::from_fn(|axis| self.along(axis, indices[axis]))
    }
}
