//! The correction of a controller with a machine's compiled tables.

use crate::error::Result;
use trueaxis::compensation::{Compensation, Direction, Query, ThermalLine, requirement};
use trueaxis::machine::{AXES, AxisOrder, MachineSettings};
use trueaxis::tcomp::Tcomp;
use trueaxis_tables::{Machine, compile};

/// Corrected command for a command: from positions and directions of travel (1: negative), in the order of the true machine.
pub(crate) type Sent<'s> = dyn Fn(&[f64; AXES], &[f64; AXES]) -> [f64; AXES] + 's;

/// Lends out the correction by the tables of `known` for a machine with axes in the order of `truth`.
pub(crate) fn with_correction<T>(
    truth: &MachineSettings,
    known: &Machine,
    user: impl FnOnce(&Sent<'_>) -> Result<T>,
) -> Result<T> {
    match truth.step_axes().count() {
        3 => of::<3, T>(truth, known, user),
        _ => of::<6, T>(truth, known, user),
    }
}

fn of<const N: usize, T>(
    truth: &MachineSettings,
    known: &Machine,
    user: impl FnOnce(&Sent<'_>) -> Result<T>,
) -> Result<T> {
    let bytes = compile(known)?;
    let tcomp = Tcomp::parse(&bytes)?;
    let rows = tcomp.rows();
    let mut memory = vec![0.0; requirement(tcomp.settings(), rows)];
    let compensation: Compensation<'_, f64, f64, N> =
        Compensation::build(tcomp.settings(), rows, tcomp.grids(), tcomp.inverse_passes(), &mut memory)?;
    let place = |axis| truth.axes.iter().position(|own| own.axis == axis);
    let slots = AxisOrder::<N>::with_spare_slots(tcomp.settings())?.axes().map(place);
    let thermal = [ThermalLine::default(); N];
    user(&|position, reverse| {
        let command: [f64; N] = slots.map(|slot| slot.map_or(0.0, |slot| position[slot]));
        let side = |slot: usize| if reverse[slot] > 0.5 { Direction::NEGATIVE } else { Direction::POSITIVE };
        let directions = slots.map(|slot| slot.map_or(Direction::POSITIVE, side));
        let at = compensation.coordinates(&command);
        let correction = compensation.correction(&Query::at(&at, &directions, &thermal), &mut 0);
        let mut sent = *position;
        for (slot, by) in slots.into_iter().zip(correction) {
            if let Some(slot) = slot {
                sent[slot] += by;
            }
        }
        sent
    })
}
