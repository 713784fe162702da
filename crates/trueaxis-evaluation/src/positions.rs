//! Successive commanded positions, and the directions in which the drives reach them.

use crate::rows::{Column, Row, Rows};
use anyhow::Result;
use trueaxis::compensation::{Direction, Reversal};
use trueaxis::machine::{AXES, Axis};
use trueaxis_tables::Machine;

/// Columns of the positions.
pub const COLUMNS: [Column; 6] = [
    Column { name: "x_mm", needed: true },
    Column { name: "y_mm", needed: true },
    Column { name: "z_mm", needed: true },
    Column { name: "a_deg", needed: false },
    Column { name: "b_deg", needed: false },
    Column { name: "c_deg", needed: false },
];

/// The next row of [`COLUMNS`]; `None` at the end.
///
/// # Errors
/// A row that cannot be read, a position outside the declared travel of its axis.
pub fn next(machine: &Machine, positions: &mut Rows<'_, 6>) -> Result<Option<Row<6>>> {
    let Some(row) = positions.next()? else { return Ok(None) };
    for settings in &machine.settings.axes {
        let index = settings.axis.index();
        let (q, [low, high]) = (row.values[index], settings.travel);
        if q < low || q > high {
            let needed = format!("the declared travel, {low} to {high}");
            return Err(positions.error(row.line, COLUMNS[index].name, q, needed));
        }
    }
    Ok(Some(row))
}

/// Values by [`Axis::index`] in the order of `axes`; those of a machine are in the order that its exact geometry has.
pub(crate) fn in_order<T: Copy + Default>(axes: impl Iterator<Item = Axis>, by_axis: &[T; AXES]) -> [T; AXES] {
    let mut ordered = [T::default(); AXES];
    for (slot, axis) in ordered.iter_mut().zip(axes) {
        *slot = by_axis[axis.index()];
    }
    ordered
}

/// Maximum number of rounds until a row's directions settle: an axis' own lost motion confirms a reversal, and may cause a
/// reversal of another axis.
const MOST_REVERSALS: usize = AXES + 1;

/// Directions of travel of the drives from row to row, as in the servo step.
#[derive(Clone, Debug)]
pub struct Travel {
    reversal: [Reversal<f64>; AXES],
    band: [f64; AXES],
    begun: bool,
}

impl Travel {
    /// The axes are in the order of `axes`.
    pub fn new(machine: &Machine, axes: impl Iterator<Item = Axis>) -> Self {
        let mut band = [0.0; AXES];
        for (band, axis) in band.iter_mut().zip(axes) {
            let own = machine.settings.axis(axis);
            *band = own.map_or(0.0, |own| own.hysteresis);
        }
        Travel { reversal: [Reversal::default(); AXES], band, begun: false }
    }

    /// Iterates the directions in which `correction` brings the drives to this command, starting from their state after the
    /// previous row.
    ///
    /// # Errors
    /// As `correction`.
    pub fn arrive<const N: usize, E>(
        &mut self,
        command: &[f64; N],
        mut correction: impl FnMut(&[Direction; N]) -> Result<[f64; N], E>,
    ) -> Result<[Direction; N], E> {
        let mut directions = self.directions();
        for _ in 0..MOST_REVERSALS {
            let sent = correction(&directions)?;
            for (slot, (command, sent)) in command.iter().zip(sent).enumerate() {
                if !self.begun {
                    self.reversal[slot] = Reversal::at(command + sent);
                }
                self.reversal[slot].update(command + sent, self.band[slot]);
            }
            self.begun = true;
            let before = directions;
            directions = self.directions();
            if directions == before {
                break;
            }
        }
        Ok(directions)
    }

    fn directions<const N: usize>(&self) -> [Direction; N] {
        std::array::from_fn(|slot| self.reversal[slot].direction())
    }
}
