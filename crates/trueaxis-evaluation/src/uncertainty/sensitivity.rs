//! Derivatives of the tip's error: the response of the first-order model to one unit of each of its errors.

use super::terms::{Effect, Terms};
use crate::compensate::{Place, Settings, with_model};
use crate::contributions::Source;
use crate::model::range;
use anyhow::Result;
use trueaxis::compensation::Direction;
use trueaxis::machine::{AXES, Axis, AxisSettings, Curve, ErrorModel, Interpolation, Row, wraps};
use trueaxis_metrology::uncertainty::Contribution;
use trueaxis_tables::{Machine, Table};

/// One unit: small enough to pass every check; the model is linear.
const UNIT: f64 = 1e-6;

/// Derivatives with respect to every error that a term needs, at every place.
pub(super) struct Responses {
    found: Vec<(Source, Vec<[f64; 3]>)>,
}

impl Responses {
    pub(super) fn of(machine: &Machine, terms: &Terms, places: &[[f64; AXES]]) -> Result<Responses> {
        let mut needed: Vec<Source> = Vec::new();
        for term in &terms.all {
            let own = |axis: Axis| Source::Term(axis, axis.index());
            let sources = match &term.effect {
                Effect::Along(axes) => axes.iter().map(|along| own(along.axis)).collect(),
                Effect::Cosine(along, _) => vec![own(along.axis)],
                Effect::Points { axis, component, .. } => vec![Source::Term(*axis, *component)],
                Effect::Location(source, _) => vec![*source],
                Effect::Part => Vec::new(),
            };
            sources.into_iter().for_each(|source| {
                if !needed.contains(&source) {
                    needed.push(source);
                }
            });
        }
        let found = needed.into_iter().map(|source| Ok((source, response(machine, source, places)?)));
        Ok(Responses { found: found.collect::<Result<_>>()? })
    }

    fn at(&self, source: Source, place: usize) -> [f64; 3] {
        let own = self.found.iter().find(|(own, _)| *own == source);
        own.and_then(|(_, places)| places.get(place)).copied().unwrap_or_default()
    }

    /// The contribution of every term at a place, in the order of the terms.
    pub(super) fn contributions(
        &self,
        machine: &Machine,
        terms: &Terms,
        place: usize,
        at: &[f64; AXES],
    ) -> Vec<Contribution> {
        let along = |axis: Axis, size: f64| self.at(Source::Term(axis, axis.index()), place).map(|part| part * size);
        let contribution = |term: &super::terms::Term| {
            let vector = match &term.effect {
                Effect::Along(axes) => axes.iter().fold([0.0; 3], |sum, one| {
                    let own = along(one.axis, one.at(at[one.axis.index()]));
                    std::array::from_fn(|i| sum[i] + own[i])
                }),
                Effect::Cosine(one, _) => along(one.axis, one.at(at[one.axis.index()])),
                Effect::Points { axis, component, of } => {
                    let size = interpolated(machine, *axis, *component, of, at[axis.index()]);
                    self.at(Source::Term(*axis, *component), place).map(|part| part * size)
                }
                Effect::Location(source, u) => self.at(*source, place).map(|part| part * u),
                Effect::Part => [0.0; 3],
            };
            Contribution { vector, degrees_of_freedom: term.degrees_of_freedom }
        };
        terms.all.iter().map(contribution).collect()
    }
}

/// The machine with one unit of this error and no other, under the model that includes all levers.
fn with_one(machine: &Machine, source: Source) -> Machine {
    let mut one = machine.clone();
    one.settings.compensation.model = ErrorModel::Volumetric;
    one.settings.location = Default::default();
    one.settings.periodic.clear();
    one.tables.iter_mut().for_each(|table| *table = None);
    one.grids.clear();
    for own in &mut one.settings.axes {
        (own.backlash, own.thermal, own.interpolation) = (0.0, Default::default(), Interpolation::Linear);
    }
    match source {
        Source::Term(axis, component) => {
            let mut unit = [0.0; 6];
            unit[component] = UNIT;
            for ((own, table), before) in one.settings.axes.iter().zip(&mut one.tables).zip(&machine.tables) {
                if own.axis == axis {
                    let row = |position| Row { position, forward: unit, reverse: unit };
                    let [low, high] = range(own, before.as_ref());
                    let given = std::array::from_fn(|other| other == component);
                    *table = Some(Table { given, bidirectional: false, rows: vec![row(low), row(high)] });
                }
            }
        }
        Source::Squareness(which) => {
            let location = &mut one.settings.location;
            *[&mut location.a0z, &mut location.b0z, &mut location.c0y][which] = UNIT;
        }
        Source::Location(axis, component) => {
            one.settings.location.rotary[axis.index() - Axis::A.index()][component] = UNIT;
        }
        Source::Axis(_) | Source::Periods(_) | Source::Backlash(_) | Source::Thermal(_) => {}
    }
    one
}

fn response(machine: &Machine, source: Source, places: &[[f64; AXES]]) -> Result<Vec<[f64; 3]>> {
    let one = with_one(machine, source);
    with_model(&one, &Settings { passes: Some(1), ..Settings::default() }, |model| {
        let at = |command: &[f64; AXES]| {
            let place = Place { command: *command, directions: [Direction::NEGATIVE; AXES] };
            model.error(&place).tip.map(|part| part / UNIT)
        };
        Ok(places.iter().map(at).collect())
    })
}

/// Standard uncertainty of a column between its points, mm or rad.
fn interpolated(machine: &Machine, axis: Axis, component: usize, of: &[f64], position: f64) -> f64 {
    let Some((own, Some(table))) = machine.axes().find(|(own, _)| own.axis == axis) else { return 0.0 };
    let mut rows = table.rows.clone();
    let around = wraps(axis, rows.as_slice());
    let first = rows.first().map_or(0.0, |row| row.position);
    let position = if around { first + (position - first).rem_euclid(360.0) } else { position };
    let count = rows.len();
    // A cubic between two points also depends on the next ones.
    let above = rows.partition_point(|row| row.position <= position);
    let near = (above + count - 2..above + count + 2).filter_map(|shifted| {
        let index = shifted as isize - count as isize;
        match around {
            // The last row repeats the first.
            true => Some(index.rem_euclid(count as isize - 1) as usize),
            false => usize::try_from(index).ok().filter(|index| *index < count),
        }
    });
    let mut points: Vec<usize> = near.collect();
    points.sort_unstable();
    points.dedup();
    let mut variance = 0.0;
    for point in points {
        let u = of.get(point).copied().unwrap_or(0.0);
        if u > 0.0 {
            let [more, less] = [u, -u].map(|by| shifted_value(own, &mut rows, point, around, component, by, position));
            variance += (0.5 * (more - less)).powi(2);
        }
    }
    variance.sqrt()
}

/// The column at a position with one of its points shifted; restores the point (JCGM 100:2008, 5.1.3, note 2).
fn shifted_value(
    own: &AxisSettings,
    rows: &mut [Row],
    point: usize,
    around: bool,
    component: usize,
    by: f64,
    position: f64,
) -> f64 {
    let both = if around && point == 0 { [0, rows.len() - 1] } else { [point; 2] };
    let kept = rows[both[0]];
    let end = rows[both[1]];
    for index in both {
        rows[index].reverse[component] = kept.reverse[component] + by;
    }
    let value = Curve::new(own, &*rows, component, true).at(position).unwrap_or(0.0);
    rows[both[1]] = end;
    rows[both[0]] = kept;
    value
}
