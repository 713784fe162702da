//! Machines drawn from the uncertainties, evaluated through the exact geometry.

use super::options::Options;
use super::terms::{Along, Effect, Term, Terms};
use crate::compensate::{Place, Settings, with_model};
use crate::contributions::Source;
use crate::positions::in_order;
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
    let slots = |by_axis: &[f64; AXES]| in_order(own.iter().copied(), by_axis);
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
        let (drawn, along) = machine_of(machine, terms, &values(terms, &mut draws));
        let geometry = Geometry::new(&drawn, 0.0).map_err(|error| anyhow!("{error}"))?;
        let deviations = places.iter().zip(&stated).map(|(place, (sent, command, left))| {
            let mut sent = *sent;
            for one in &along {
                let index = one.axis.index();
                sent[index] += one.moves(place[index], reverse[index]);
            }
            let tip = geometry.pose_error_of(command, &slots(&sent), &reverse).tip_mm;
            std::array::from_fn(|i| tip[i] - left[i])
        });
        Ok(deviations.collect::<Vec<[f64; 3]>>())
    };
    let trials = (0..options.trials as u64).into_par_iter().map(trial).collect::<Result<Vec<_>>>()?;
    Ok((0..places.len()).map(|place| trials.iter().map(|trial| trial[place]).collect()).collect())
}

/// Values of the quantities in units of their standard uncertainties, in the order of the terms: one for each, and one for
/// every point of a column. Correlated ones are as [`Correlations`] draws them.
///
/// [`Correlations`]: trueaxis_metrology::uncertainty::Correlations
pub(crate) fn values(terms: &Terms, draws: &mut Draws) -> Vec<Vec<f64>> {
    let mut spreads = vec![1.0; terms.all.len()];
    let of = |(term, own): (&Term, &mut f64)| {
        let nu = term.degrees_of_freedom;
        match &term.effect {
            Effect::Points { of, .. } => {
                let spread = draws.spread(nu);
                of.iter().map(|_| spread * draws.normal()).collect()
            }
            Effect::Along(_) | Effect::Cosine(..) | Effect::Location(..) | Effect::Part => {
                let normal = draws.normal();
                *own = draws.spread(nu);
                vec![normal]
            }
        }
    };
    let mut values: Vec<Vec<f64>> = terms.all.iter().zip(&mut spreads).map(of).collect();
    let correlations = &terms.correlated.terms;
    if !correlations.is_empty() {
        let independent: Vec<f64> = values.iter().map(|values| values.first().copied().unwrap_or(0.0)).collect();
        let mixed = correlations.mixed(&independent);
        correlations.groups().flatten().for_each(|term| values[*term] = vec![mixed[*term]]);
        spreads = (0..spreads.len()).map(|term| spreads[correlations.first(term)]).collect();
    }
    values.iter_mut().zip(spreads).for_each(|(values, spread)| values.iter_mut().for_each(|value| *value *= spread));
    values
}

/// The machine with its quantities shifted by these [`values`]; errors of the axes along themselves are returned separately.
pub(crate) fn machine_of(machine: &Machine, terms: &Terms, values: &[Vec<f64>]) -> (Machine, Vec<Along>) {
    let (mut drawn, mut along) = (machine.clone(), Vec::new());
    for (term, values) in terms.all.iter().zip(values) {
        let z = values.first().copied().unwrap_or(0.0);
        match &term.effect {
            Effect::Along(axes) => along.extend(axes.iter().map(|one| one.times(z))),
            Effect::Cosine(one, inclined) => {
                along.push(Along { constant: 0.0, per_length: 0.5 * (inclined * z).powi(2), ..*one });
            }
            Effect::Points { axis, component, of } => {
                let slot = machine.settings.axes.iter().position(|own| own.axis == *axis);
                let Some(Some(table)) = slot.and_then(|slot| drawn.tables.get_mut(slot)) else { continue };
                for (row, (u, z)) in table.rows.iter_mut().zip(of.iter().zip(values)) {
                    row.forward[*component] += u * z;
                    row.reverse[*component] += u * z;
                }
                let around = wraps(*axis, table.rows.as_slice());
                if let (true, [first, .., last]) = (around, table.rows.as_mut_slice()) {
                    (last.forward, last.reverse) = (first.forward, first.reverse);
                }
            }
            Effect::Location(source, u) => {
                let location = &mut drawn.settings.location;
                match source {
                    Source::Squareness(which) => {
                        *[&mut location.a0z, &mut location.b0z, &mut location.c0y][*which] += u * z;
                    }
                    Source::Location(axis, component) => {
                        location.rotary[axis.index() - Axis::A.index()][*component] += u * z;
                    }
                    _ => {}
                }
            }
            Effect::Part => {}
        }
    }
    (drawn, along)
}
