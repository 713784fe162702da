//! Grids of errors of the simulated machine: the values as given, by repeated linear interpolation.

use super::rotation::rotation;
use crate::grid::{Grid, GridSource, LINEAR};
use glam::{DAffine3, DMat3, DVec3};
use trueaxis::machine::{AXES, Axis, MachineSettings, Twist};

/// A grid and the centre of its rotations.
#[derive(Clone, Debug)]
pub(super) struct ErrorGrid {
    source: GridSource,
    /// Slots of X, Y, Z among the machine's axes.
    slots: [Option<usize>; 3],
    /// The centre, without the travels of the slides that move it.
    fixed: DVec3,
    /// 1 for the slides that move the centre.
    moves: DVec3,
}

impl ErrorGrid {
    /// `on_tool`: the axes that carry the tool.
    pub(super) fn new(machine: &MachineSettings, grid: &Grid, on_tool: &[Axis]) -> ErrorGrid {
        let source = grid.source().clone();
        let (mut fixed, mut moves) = (DVec3::ZERO, DVec3::ZERO);
        for own in machine.axes.iter().filter(|own| on_tool.contains(&own.axis)) {
            fixed += DVec3::from_array(own.offset_mm);
            if let Some(axis) = LINEAR.iter().position(|axis| *axis == own.axis) {
                if source.nodes[axis].is_empty() {
                    fixed[axis] += source.measured_at_mm[axis];
                } else {
                    moves[axis] = 1.0;
                }
            }
        }
        let slots = LINEAR.map(|axis| machine.axes.iter().position(|own| own.axis == axis));
        ErrorGrid { source, slots, fixed, moves }
    }

    /// Transform by which it displaces the tool side, in bed coordinates.
    pub(super) fn displacement(&self, position: &[f64; AXES]) -> DAffine3 {
        let at = self.slots.map(|slot| slot.map_or(0.0, |slot| position[slot]));
        let [ex, ey, ez, a, b, c] = self.at(at);
        let about = self.fixed + self.moves * DVec3::from_array(at);
        let turn: DMat3 = rotation(DVec3::new(a, b, c));
        DAffine3 { matrix3: turn, translation: about + DVec3::new(ex, ey, ez) - turn * about }
    }

    /// The six errors at X, Y, Z: mm and rad.
    fn at(&self, [x, y, z]: [f64; 3]) -> Twist {
        let weight = self.source.fade_mm.map_or(1.0, |[whole, none]| {
            if z <= whole {
                1.0
            } else if z >= none {
                0.0
            } else {
                (none - z) / (none - whole)
            }
        });
        self.along(0, 0, &[x, y, z]).map(|error| weight * error)
    }

    /// Interpolates along an axis and those after it; `before`: number of the node reached along the axes before.
    fn along(&self, axis: usize, before: usize, at: &[f64; 3]) -> Twist {
        let Some(nodes) = self.source.nodes.get(axis) else { return self.source.values[before] };
        if nodes.is_empty() {
            return self.along(axis + 1, before, at);
        }
        let value = |index: usize| self.along(axis + 1, before * nodes.len() + index, at);
        let above = nodes.partition_point(|node| *node <= at[axis]);
        if above == 0 || above == nodes.len() {
            return value(above.min(nodes.len() - 1));
        }
        let share = (at[axis] - nodes[above - 1]) / (nodes[above] - nodes[above - 1]);
        let (low, high) = (value(above - 1), value(above));
        std::array::from_fn(|k| low[k] + share * (high[k] - low[k]))
    }
}
