//! The part at another place, or a feature cut in the other direction.

use super::document::{Directed, Elsewhere, Placed};
use crate::predict::locate::ends;
use crate::predict::{Feature, FeatureKind, Options, Part, PredictDocument, Predicted, Side, predict};
use anyhow::Result;
use trueaxis_sim::program::{Curve, Move, Program, Turn};
use trueaxis_tables::Machine;
use trueaxis_tables::uncertainty::Uncertainties;

/// Draws of a comparison: places differ by the machine, not by chance, since the seed is the same.
const TRIALS: u64 = 200;
/// Places along X and Y.
const PLACES: usize = 3;
/// Share of the way to the end of the travel: the correction needs the rest.
const ROOM: f64 = 0.95;
/// Least improvement that is worth saying.
const BETTER: f64 = 0.05;
/// Share of the variance by lost motion above which a feature is tried in the other direction.
const LOST_MOTION: f64 = 0.02;

/// Machine and part as asked for.
pub(super) struct Asked<'a> {
    pub(super) machine: &'a Machine,
    pub(super) stated: &'a Uncertainties,
    pub(super) program: &'a Program,
    pub(super) part: &'a Part,
    pub(super) seed: u64,
}

impl Asked<'_> {
    fn predict(&self, program: &Program, part: &Part) -> Result<PredictDocument> {
        predict(self.machine, self.stated, program, part, Options { trials: TRIALS, seed: self.seed })
    }

    /// The best of some places in X and Y, by the characteristics that conform, then by the largest share of a tolerance;
    /// `room`: how far the part can move down and up along each. No place if it is where it is best.
    pub(super) fn place(&self, room: [[f64; 2]; 2]) -> Result<Elsewhere> {
        let here = Rated::of(&self.predict(self.program, self.part)?);
        let mut best = (here, self.part.at_mm);
        let [mut places_compared, mut places_refused] = [1, 0];
        let shift = |[low, high]: [f64; 2], k: usize| ROOM * (low + (high - low) * k as f64 / (PLACES - 1) as f64);
        let mut tried = vec![self.part.at_mm];
        for (i, j) in (0..PLACES).flat_map(|i| (0..PLACES).map(move |j| (i, j))) {
            let mut at = self.part.at_mm;
            for (q, by) in at.iter_mut().zip([shift(room[0], i), shift(room[1], j)]) {
                // To the millimetre, towards where the part is.
                *q += by.trunc();
            }
            if tried.contains(&at) {
                continue;
            }
            tried.push(at);
            let part = Part { at_mm: at, ..self.part.clone() };
            // The correction may lead out of the travel at its ends.
            let Ok(document) = self.predict(self.program, &part) else {
                places_refused += 1;
                continue;
            };
            places_compared += 1;
            let there = Rated::of(&document);
            if there.is_better(&best.0, 0.0) {
                best = (there, at);
            }
        }
        let (there, at_mm) = best;
        let conform = [here.conform, there.conform];
        let place = Placed { at_mm, conform, here: here.worst, there: there.worst };
        let place = there.is_better(&here, BETTER).then_some(place);
        Ok(Elsewhere { place, places_compared, places_refused, directions: Vec::new(), without_servo: false })
    }

    /// The features that lost motion decides, cut in the other direction, where that is better.
    pub(super) fn directions(&self, predicted: &PredictDocument) -> Result<Vec<Directed>> {
        let depends = |of: &Predicted| {
            let budget = of.known.iter().flat_map(|known| &known.budget);
            budget.filter(|one| one.term.starts_with("backlash")).map(|one| one.share.abs()).sum::<f64>() > LOST_MOTION
        };
        let mut found = Vec::new();
        let mut here = None;
        for (index, feature) in self.part.features.iter().enumerate() {
            let own: Vec<usize> = (0..self.part.tolerances.len())
                .filter(|k| self.part.tolerances[*k].feature == index && depends(&predicted.features[*k]))
                .collect();
            if matches!(feature.kind, FeatureKind::Hole | FeatureKind::Flank)
                || feature.setup.is_some()
                || own.is_empty()
            {
                continue;
            }
            let Some(program) = reversed(self.program, feature.lines) else { continue };
            let Ok(there) = self.predict(&program, &with_sides_swapped(self.part, feature.lines)) else { continue };
            if here.is_none() {
                here = Some(self.predict(self.program, self.part)?);
            }
            let Some(here) = &here else { continue };
            // Others refer to it as a datum: none of them may be worse.
            let all = here.features.iter().zip(&there.features);
            let is_worse = |(now, then): (&Predicted, &Predicted)| then.used() > (1.0 + BETTER) * now.used().max(1e-3);
            if all.clone().any(is_worse) {
                continue;
            }
            let gain = |k: &usize| here.features[*k].used() - there.features[*k].used();
            let Some(k) = own.into_iter().max_by(|a, b| gain(a).total_cmp(&gain(b))) else { continue };
            let [here, there] = [here, &there].map(|document| document.features[k].used());
            if there < (1.0 - BETTER) * here {
                found.push(Directed { feature: feature.name.clone(), kind: predicted.features[k].kind, here, there });
            }
        }
        Ok(found)
    }
}

/// A part at a place.
#[derive(Clone, Copy)]
struct Rated {
    /// Characteristics that conform.
    conform: usize,
    /// Largest share of a tolerance.
    worst: f64,
}

impl Rated {
    fn of(document: &PredictDocument) -> Rated {
        let conforms = |of: &&Predicted| of.known.as_ref().is_some_and(|known| known.verdict == "conforms");
        let conform = document.features.iter().filter(conforms).count();
        Rated { conform, worst: document.features.iter().map(Predicted::used).fold(0.0, f64::max) }
    }

    /// More characteristics conform, or as many with a largest share that is less by this part of it.
    fn is_better(&self, other: &Rated, by: f64) -> bool {
        let is_less = self.worst < (1.0 - by) * other.worst;
        self.conform > other.conform || self.conform == other.conform && is_less
    }
}

/// The part with the material on the other side of paths that are cut backwards: it stays where it is.
fn with_sides_swapped(part: &Part, [from, to]: [u32; 2]) -> Part {
    let mut part = part.clone();
    let is_own = |own: &&mut Feature| own.setup.is_none() && own.lines[0] <= to && from <= own.lines[1];
    for own in part.features.iter_mut().filter(is_own) {
        own.side = match own.side {
            Some(Side::Left) => Some(Side::Right),
            Some(Side::Right) => Some(Side::Left),
            side => side,
        };
    }
    part
}

/// The program with the moves of these lines cut backwards; `None` if one of them is a spline.
fn reversed(program: &Program, [from, to]: [u32; 2]) -> Option<Program> {
    let mut program = program.clone();
    let own = |line: u32| (from..=to).contains(&line);
    let first = program.moves.iter().position(|step| own(step.line) && !step.rapid)?;
    let last = program.moves.iter().rposition(|step| own(step.line) && !step.rapid)?;
    let moves = &mut program.moves[first..=last];
    moves.reverse();
    for step in moves {
        step.turn = Turn { start: step.turn.end(), change: step.turn.change.map(|by| -by) };
        match &mut step.curve {
            Curve::Line { start, end } => std::mem::swap(start, end),
            Curve::Arc { start, end, normal, .. } => {
                std::mem::swap(start, end);
                *normal = normal.map(|part| -part);
            }
            Curve::Nurbs { .. } => return None,
        }
    }
    // To the new start, so that the first point is reached along the feature.
    let [to, _] = ends(&program.moves[first]);
    let [_, from] = first.checked_sub(1).map_or([to; 2], |before| ends(&program.moves[before]));
    let curve = Curve::Line { start: from.to_array(), end: to.to_array() };
    let [_, turned] = first.checked_sub(1).map_or([program.moves[first].turn.start; 2], |before| {
        let before = &program.moves[before].turn;
        [before.start, before.end()]
    });
    let to = program.moves[first].turn.start;
    let turn = Turn { start: turned, change: std::array::from_fn(|k| to[k] - turned[k]) };
    let way = Move { rapid: true, curve, turn, ..program.moves[first].clone() };
    program.moves.insert(first, way);
    Some(program)
}
