//! Tip errors of the volumetric model at places, and the effect of a unit of one error on them.

use crate::compensate::{Place, Settings, with_model};
use anyhow::{Result, anyhow};
use trueaxis::Axis;
use trueaxis::compensation::Direction;
use trueaxis::machine::{AXES, ErrorModel, Row};
use trueaxis_tables::{Machine, Table};

/// An error that a machine may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// One of the six errors (X Y Z A B C) of a linear axis, constant along it.
    Linear(Axis, usize),
    /// One of the six location errors of a rotary axis.
    Rotary(Axis, usize),
    /// A0Z.
    A0z,
    /// B0Z.
    B0z,
    /// C0Y.
    C0y,
}

/// Size of the error whose effect is computed, mm or rad. The model is linear in it.
const SIZE: f64 = 1e-3;

/// Tip errors, mm, of the machine's volumetric model at positions of X Y Z A B C (mm, degrees), in positive travel at the
/// reference temperature; and whether an edge value was clamped. Periods of rotary axes, which that model lacks, are left out.
///
/// # Errors
/// Anything that the model refuses.
pub fn tip_errors(machine: &Machine, places: &[[f64; AXES]]) -> Result<(Vec<[f64; 3]>, bool)> {
    let mut volumetric = machine.clone();
    volumetric.settings.compensation.model = ErrorModel::Volumetric;
    volumetric.settings.periodic.retain(|period| !period.axis.is_rotary());
    own_tip_errors(&volumetric, places)
}

/// Like [`tip_errors`], by the model that the machine states.
///
/// # Errors
/// Anything that the model refuses.
pub fn own_tip_errors(machine: &Machine, places: &[[f64; AXES]]) -> Result<(Vec<[f64; 3]>, bool)> {
    with_model(machine, &Settings { passes: Some(1), ..Settings::default() }, |model| {
        let mut clamped = false;
        let errors = places.iter().map(|command| {
            let error = model.error(&Place { command: *command, directions: [Direction::POSITIVE; AXES] });
            clamped |= error.clamped;
            error.tip
        });
        let errors = errors.collect();
        Ok((errors, clamped))
    })
}

/// The machine without any error: no tables, no periods, no grids, no location errors, no backlash.
pub fn without_errors(machine: &Machine) -> Machine {
    let mut bare = machine.clone();
    bare.settings.location = Default::default();
    bare.settings.periodic.clear();
    bare.grids.clear();
    for (own, table) in bare.settings.axes.iter_mut().zip(&mut bare.tables) {
        own.backlash = 0.0;
        *table = None;
    }
    bare
}

/// Tip error, mm, for one mm or rad of `unit` at every place.
///
/// # Errors
/// An axis that the machine does not have; anything that the model refuses.
pub fn response(bare: &Machine, unit: Unit, places: &[[f64; AXES]]) -> Result<Vec<[f64; 3]>> {
    let mut machine = bare.clone();
    match unit {
        Unit::A0z => machine.settings.location.a0z = SIZE,
        Unit::B0z => machine.settings.location.b0z = SIZE,
        Unit::C0y => machine.settings.location.c0y = SIZE,
        Unit::Rotary(axis, component) => {
            let own =
                axis.index().checked_sub(Axis::A.index()).and_then(|k| machine.settings.location.rotary.get_mut(k));
            let own = own
                .and_then(|own| own.get_mut(component))
                .ok_or_else(|| anyhow!("{} is not a rotary axis", axis.letter()))?;
            *own = SIZE;
        }
        Unit::Linear(axis, component) => {
            let slot = machine.settings.axes.iter().position(|own| own.axis == axis);
            let slot = slot.ok_or_else(|| anyhow!("found no axis {}, needed one", axis.letter()))?;
            let mut twist = [0.0; 6];
            twist[component] = SIZE;
            let along = places.iter().map(|place| place[axis.index()]);
            let [low, high] = along.fold([-1.0, 1.0], |[low, high], q| [f64::min(low, q), f64::max(high, q)]);
            let rows = [low - 1.0, high + 1.0].map(|position| Row { position, forward: twist, reverse: twist });
            machine.tables[slot] = Some(Table { given: [true; 6], bidirectional: false, rows: rows.into() });
        }
    }
    let (errors, _) = tip_errors(&machine, places)?;
    Ok(errors.into_iter().map(|error| error.map(|mm| mm / SIZE)).collect())
}
