//! Machines drawn from the uncertainties, evaluated through the exact geometry.

use super::options::Options;
use super::terms::{Effect, Terms};
use crate::compensate::{Place, Settings, with_model};
use crate::contributions::Source;
use anyhow::{Result, anyhow};
use trueaxis::compensation::Direction;
use trueaxis::machine::{AXES, Axis, wraps};
use trueaxis_metrology::cores::*;
use trueaxis_metrology::uncertainty::Draws;
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;

/// Corrections of the machine's own tables at the places, by [`Axis::index`].
fn corrections(machine: &Machine, places: &[[f64; AXES]]) -> Result<Vec<[f64; AXES]>> {
    with_model(machine, &Settings::default(), |model| {
        let at = |command: &[f64; AXES]| {
            Ok(model.correction(&Place { command: *command, directions: [Direction::NEGATIVE; AXES] })?)
        };
        places.iter().map(at).collect()
    })
}

/// Deviations of the tip at every place, mm: `[place][trial]`.
pub(super) fn draw(
    machine: &Machine,
    terms: &Terms,
    places: &[[f64; AXES]],
    options: &Options,
) -> Result<Vec<Vec<[f64; 3]>>> {
    let own: Vec<Axis> = machine.settings.axes.iter().map(|own| own.axis).collect();
    let slots = |letters: &[f64; AXES]| {
        let mut slots = [0.0; AXES];
        for (slot, axis) in slots.iter_mut().zip(&own) {
            *slot = letters[axis.index()];
        }
        slots
    };
    let geometry = Geometry::new(machine, 0.0).map_err(|error| anyhow!("{error}"))?;
    let reverse = [1.0; AXES];
    let stated: Vec<_> = places
        .iter()
        .zip(corrections(machine, places)?)
        .map(|(place, correction)| {
            let sent: [f64; AXES] = std::array::from_fn(|index| place[index] + correction[index]);
            let command = geometry.commanded(&slots(place));
            let left = geometry.pose_error_of(&command, &slots(&sent), &reverse).tip_mm;
            (sent, command, left)
        })
        .collect();
    let trial = |number: u64| {
        let mut draws = Draws::new(options.seed, number);
        let (drawn, along) = machine_of(machine, terms, &mut draws);
        let geometry = Geometry::new(&drawn, 0.0).map_err(|error| anyhow!("{error}"))?;
        let deviations = places.iter().zip(&stated).map(|(place, (sent, command, left))| {
            let mut sent = *sent;
            for (axis, constant, per_length, datum) in &along {
                let index = axis.index();
                let moved = constant + per_length * (place[index] - datum);
                sent[index] += if axis.is_rotary() { moved.to_degrees() } else { moved };
            }
            let tip = geometry.pose_error_of(command, &slots(&sent), &reverse).tip_mm;
            std::array::from_fn(|i| tip[i] - left[i])
        });
        Ok(deviations.collect::<Vec<[f64; 3]>>())
    };
    let trials = (0..options.trials as u64).into_par_iter().map(trial).collect::<Result<Vec<_>>>()?;
    Ok((0..places.len()).map(|place| trials.iter().map(|trial| trial[place]).collect()).collect())
}

/// Constant and slope of an axis' error along itself, and the datum of the slope.
type Moved = (Axis, f64, f64, f64);

/// A machine consistent with the stated one and its uncertainties; errors of the axes along themselves are returned
/// separately.
fn machine_of(machine: &Machine, terms: &Terms, draws: &mut Draws) -> (Machine, Vec<Moved>) {
    let (mut drawn, mut along) = (machine.clone(), Vec::new());
    for term in &terms.all {
        let nu = term.degrees_of_freedom;
        match &term.effect {
            Effect::Along(axes) => {
                let z = draws.student(nu);
                along.extend(axes.iter().map(|one| (one.axis, z * one.constant, z * one.per_length, one.datum)));
            }
            Effect::Cosine(one, inclined) => {
                let inclined = inclined * draws.student(nu);
                along.push((one.axis, 0.0, 0.5 * inclined * inclined, one.datum));
            }
            Effect::Points { axis, component, of } => {
                let spread = draws.spread(nu);
                let slot = machine.settings.axes.iter().position(|own| own.axis == *axis);
                let Some(Some(table)) = slot.and_then(|slot| drawn.tables.get_mut(slot)) else { continue };
                for (row, u) in table.rows.iter_mut().zip(of) {
                    let by = u * spread * draws.normal();
                    row.forward[*component] += by;
                    row.reverse[*component] += by;
                }
                let around = wraps(*axis, table.rows.as_slice());
                if let (true, [first, .., last]) = (around, table.rows.as_mut_slice()) {
                    (last.forward, last.reverse) = (first.forward, first.reverse);
                }
            }
            Effect::Location(source, u) => {
                let by = u * draws.student(nu);
                let location = &mut drawn.settings.location;
                match source {
                    Source::Squareness(which) => {
                        *[&mut location.a0z, &mut location.b0z, &mut location.c0y][*which] += by;
                    }
                    Source::Location(axis, component) => {
                        location.rotary[axis.index() - Axis::A.index()][*component] += by;
                    }
                    _ => {}
                }
            }
        }
    }
    (drawn, along)
}
