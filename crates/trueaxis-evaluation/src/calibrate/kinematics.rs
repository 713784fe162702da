//! Axis positions for a point on the workpiece, from the geometry of a machine without errors.

use super::terms::perfect;
use trueaxis::machine::AXES;
use trueaxis_tables::Machine;
use trueaxis_tables::exact::{Geometry, GeometryError};

/// A machine without errors. Positions are X, Y, Z, A, B, C, mm and degrees.
#[derive(Clone, Debug)]
pub struct Ideal {
    geometry: Geometry,
    /// Index of X, Y, Z, A, B, C among the machine's axes.
    slots: [Option<usize>; AXES],
}

impl Ideal {
    /// The machine's ideal geometry.
    ///
    /// # Errors
    /// A chain that cannot be read.
    pub fn new(machine: &Machine) -> Result<Ideal, GeometryError> {
        let mut slots = [None; AXES];
        for (slot, own) in machine.settings.axes.iter().enumerate() {
            slots[own.axis.index()] = Some(slot);
        }
        Ok(Ideal { geometry: Geometry::new(&perfect(machine), 0.0)?, slots })
    }

    /// Reorders values by letter into the order of the machine's axes.
    pub fn ordered(&self, by_letter: &[f64; AXES]) -> [f64; AXES] {
        let mut ordered = [0.0; AXES];
        for (slot, value) in self.slots.iter().zip(by_letter) {
            if let Some(to) = slot.and_then(|slot| ordered.get_mut(slot)) {
                *to = *value;
            }
        }
        ordered
    }

    /// Tip position in workpiece coordinates, mm.
    pub fn tip(&self, position: &[f64; AXES]) -> [f64; 3] {
        self.geometry.ideal_pose(&self.ordered(position)).tip_mm
    }

    /// Tip displacement in workpiece coordinates for 1 mm of X, of Y, of Z.
    fn columns(&self, position: &[f64; AXES]) -> [[f64; 3]; 3] {
        let base = self.tip(position);
        std::array::from_fn(|axis| {
            let mut moved = *position;
            moved[axis] += 1.0;
            let tip = self.tip(&moved);
            std::array::from_fn(|k| tip[k] - base[k])
        })
    }

    /// X, Y, Z that bring the tip to a point of the workpiece, with A, B, C as in `position`.
    pub fn reach(&self, position: &[f64; AXES], point: [f64; 3]) -> [f64; AXES] {
        let (tip, columns) = (self.tip(position), self.columns(position));
        let mut reached = *position;
        // The columns are those of a rotation: orthogonal, of length 1.
        for (axis, column) in columns.iter().enumerate() {
            reached[axis] += (0..3).map(|k| column[k] * (point[k] - tip[k])).sum::<f64>();
        }
        reached
    }

    /// Converts a workpiece direction to machine directions.
    pub fn turned(&self, position: &[f64; AXES], direction: [f64; 3]) -> [f64; 3] {
        self.columns(position).map(|column| (0..3).map(|k| column[k] * direction[k]).sum())
    }

    /// Direction from the tip to the spindle, in machine directions.
    pub fn tool(&self, position: &[f64; AXES]) -> [f64; 3] {
        self.turned(position, self.geometry.ideal_pose(&self.ordered(position)).direction)
    }
}
