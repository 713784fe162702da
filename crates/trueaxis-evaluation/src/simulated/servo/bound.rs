//! The bound: plants in which one figure varies show which of many drawn plants are the worst; those are simulated.

use super::family::{Family, Place};
use super::side_by_side::{Cycle, simulate};
use super::superposed::Effects;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use trueaxis::Axis;
use trueaxis::machine::AXES;
use trueaxis_sim::Scenario;
use trueaxis_sim::error::Result;
use trueaxis_sim::plant::drive::DriveSettings;

/// Bound over the worst of [`SCREENED`] plants. The worst of 1,000 other plants is larger than that of 4,000 by 4 % in one of
/// twenty trials where four figures share the effect evenly, by 9 % where very many do; it is smaller by at most 17 to 25 %.
const MARGIN: f64 = 1.15;
/// Plants drawn from the family of which the superposed effects choose those that are simulated.
const SCREENED: usize = 4000;
/// Most plants that are simulated by this choice.
const MOST_CHOSEN: usize = 96;
/// Plants chosen for a line.
const CHOSEN_PER_LINE: usize = 4;
/// Stream of the screened plants: no seed of a drawn plant gives the same ones.
const SCREENING_SEED: u64 = 0x9e37_79b9_7f4a_7c15;
/// Number of moments recorded of a line.
const MOMENTS: usize = 48;
/// Interval between recorded moments, s.
const MOMENT_S: f64 = 2e-3;

/// A scenario and a family of plants about the figures that its machine states.
pub(super) struct Plants<'p> {
    pub(super) scenario: Arc<Scenario>,
    pub(super) family: &'p Family,
    about: [DriveSettings; AXES],
    /// Axis and figure of everything that varies.
    varied: Vec<(usize, usize)>,
}

/// Errors on a line of the program, µm.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bounded {
    /// Largest error with the figures as stated.
    pub(super) stated: f64,
    /// Bound over the family.
    pub(super) bound: f64,
}

/// Errors and bound of a line.
#[derive(Default)]
struct Line {
    stated: f64,
    /// The moments of the largest sums, each with its sum.
    moments: Vec<(f64, Effects)>,
    /// The moment under way: its number and sum.
    last: Option<(u64, f64)>,
}

impl<'p> Plants<'p> {
    pub(super) fn new(scenario: Arc<Scenario>, family: &'p Family) -> Plants<'p> {
        let turns = |axis: &Axis| scenario.five_axis || !axis.is_rotary();
        let axes: Vec<Axis> = scenario.machine.axes().map(|(own, _)| own.axis).filter(turns).collect();
        let about = family.about(&scenario.machine.settings);
        Plants { family, about, varied: family.varied(&axes), scenario }
    }

    /// Bounds of every line that cuts, and the number of plants simulated.
    pub(super) fn bounds(&self) -> Result<(BTreeMap<u32, Bounded>, usize)> {
        let lines = self.effects()?;
        let places = Family::draw(SCREENING_SEED, SCREENED);
        let foreseen = |(line, of): (&u32, &Line)| {
            let at = |place| of.moments.iter().map(|(_, own)| own.at(place, &self.varied)).fold(0.0, f64::max);
            (*line, places.iter().map(at).collect::<Vec<f64>>())
        };
        let foreseen: BTreeMap<u32, Vec<f64>> = lines.par_iter().map(foreseen).collect();
        let chosen: Vec<usize> = chosen(&foreseen).into_iter().collect();
        let found = self.worst(&chosen.iter().map(|i| places[*i]).collect::<Vec<_>>())?;
        let bounds = lines.iter().map(|(line, of)| {
            let most = |of: &mut dyn Iterator<Item = f64>| of.fold(0.0, f64::max);
            let foreseen = &foreseen[line];
            // The forecast of the sums for all plants, corrected by their errors on the plants simulated.
            let (all, simulated) =
                (most(&mut foreseen.iter().copied()), most(&mut chosen.iter().map(|i| foreseen[*i])));
            let worst = found.get(line).copied().unwrap_or(0.0).max(of.stated);
            let worst = if simulated > 0.0 { worst * (all / simulated).max(1.0) } else { worst };
            (*line, Bounded { stated: of.stated, bound: MARGIN * worst })
        });
        Ok((bounds.collect(), 1 + 2 * self.varied.len() + chosen.len()))
    }

    /// Simulates the figures as stated and one figure at a time at either end.
    fn effects(&self) -> Result<BTreeMap<u32, Line>> {
        let mut places = vec![Place::default()];
        for &(axis, figure) in &self.varied {
            for end in [-1.0, 1.0] {
                let mut place = Place::default();
                place[axis][figure] = end;
                places.push(place);
            }
        }
        let mut lines: BTreeMap<u32, Line> = BTreeMap::new();
        let mut effects = Effects { about: DVec3::ZERO, changes: vec![Default::default(); self.varied.len()] };
        let cycles = (MOMENT_S * self.scenario.rate_hz()).max(1.0) as u64;
        simulate(&self.scenario, &self.drives(&places), |cycle: Cycle<'_>| {
            effects.about = next(&mut *cycle.errors);
            for change in &mut effects.changes {
                *change = [(); 2].map(|()| next(&mut *cycle.errors) - effects.about);
            }
            lines.entry(cycle.line).or_default().add(cycle.cycle / cycles, &effects);
        })?;
        Ok(lines)
    }

    /// Largest error of the plants at these places on every line.
    pub(super) fn worst(&self, places: &[Place]) -> Result<BTreeMap<u32, f64>> {
        let mut worst: BTreeMap<u32, f64> = BTreeMap::new();
        for places in places.chunks(64) {
            simulate(&self.scenario, &self.drives(places), |cycle| {
                let line = worst.entry(cycle.line).or_default();
                *line = cycle.errors.map(size).fold(*line, f64::max);
            })?;
        }
        Ok(worst)
    }

    fn drives(&self, places: &[Place]) -> Vec<[DriveSettings; AXES]> {
        places.iter().map(|place| self.family.drives(&self.about, place)).collect()
    }
}

impl Line {
    fn add(&mut self, number: u64, effects: &Effects) {
        self.stated = self.stated.max(effects.about.length());
        let sum = effects.largest();
        match &mut self.last {
            Some((last, largest)) if *last == number => {
                if sum <= *largest {
                    return;
                }
                *largest = sum;
                self.moments.pop();
            }
            last => *last = Some((number, sum)),
        }
        if self.moments.len() == 2 * MOMENTS {
            self.moments.sort_by(|a, b| b.0.total_cmp(&a.0));
            self.moments.truncate(MOMENTS);
        }
        self.moments.push((sum, effects.clone()));
    }
}

/// Plants to simulate: the worst foreseen of every line, the lines with the largest errors first.
fn chosen(foreseen: &BTreeMap<u32, Vec<f64>>) -> BTreeSet<usize> {
    let mut lines: Vec<Vec<(f64, usize)>> = foreseen.values().map(|errors| worst_of(errors)).collect();
    lines.sort_by(|a, b| b[0].0.total_cmp(&a[0].0));
    let mut chosen = BTreeSet::new();
    for rank in 0..CHOSEN_PER_LINE {
        for line in &lines {
            if chosen.len() < MOST_CHOSEN {
                chosen.extend(line.get(rank).map(|(_, plant)| *plant));
            }
        }
    }
    chosen
}

/// The plants with the largest errors.
fn worst_of(errors: &[f64]) -> Vec<(f64, usize)> {
    let mut all: Vec<(f64, usize)> = errors.iter().copied().zip(0..).collect();
    all.select_nth_unstable_by(CHOSEN_PER_LINE, |a, b| b.0.total_cmp(&a.0));
    all.truncate(CHOSEN_PER_LINE);
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all
}

fn size(error: Option<[f32; 3]>) -> f64 {
    error.map_or(0.0, |error| DVec3::from(error.map(f64::from)).length())
}

fn next(errors: &mut dyn Iterator<Item = Option<[f32; 3]>>) -> DVec3 {
    errors.next().flatten().map_or(DVec3::ZERO, |error| DVec3::from(error.map(f64::from)))
}
