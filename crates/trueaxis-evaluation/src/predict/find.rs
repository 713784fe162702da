//! Features found in a program, for confirmation.

use super::locate::{circle_of, turn};
use super::part::{Feature, FeatureKind};
use glam::DVec3;
use std::fmt::Write as _;
use trueaxis_sim::program::{Curve, Move, Program};

/// Shortest line that is an edge and least distance of rows, mm.
const SHORTEST: f64 = 1.0;
/// Fewest rows of a plane: a rectangle's outline has two parallel sides.
const ROWS: usize = 3;
/// Sine of the largest angle between rows.
const PARALLEL: f64 = 1e-6;

/// Features that the program cuts between two rapid motions: holes, full circles, planes milled line by line, and otherwise
/// the straight lines as edges. Roughing is not told from finishing.
pub fn find(program: &Program) -> Vec<Feature> {
    let mut found: Vec<(FeatureKind, [u32; 2])> = Vec::new();
    for pass in program.moves.chunk_by(|one, next| one.rapid == next.rapid).filter(|pass| !pass[0].rapid) {
        found.extend(of_pass(pass));
    }
    let mut features: Vec<Feature> = Vec::new();
    for (kind, lines) in found {
        // Lines of a loop or subprogram cut more than once.
        let again = |own: &Feature| own.lines[0] <= lines[1] && lines[0] <= own.lines[1];
        if !features.iter().any(again) {
            let number = 1 + features.iter().filter(|own| own.kind == kind).count();
            let name = format!("{} {number}", kind.name());
            features.push(Feature { name, kind, lines, setup: None, tool: None, side: None, gear: None, line: 0 });
        }
    }
    features
}

/// The features as sections of a part's file.
pub fn sections(features: &[Feature]) -> String {
    let mut text = String::new();
    for Feature { name, kind, lines: [from, to], .. } in features {
        let kind = kind.name();
        let _ = write!(text, "\n[[feature]]\nname = \"{name}\"\nkind = \"{kind}\"\nlines = [{from}, {to}]\n");
    }
    text
}

fn of_pass(pass: &[Move]) -> Vec<(FeatureKind, [u32; 2])> {
    let lines = |moves: &[Move]| [moves[0].line, moves[moves.len() - 1].line];
    let circles: Vec<_> = pass
        .chunk_by(|one, next| circle_of(one).zip(circle_of(next)).is_some_and(|(one, next)| one.is_near(&next)))
        .filter(|arcs| circle_of(&arcs[0]).is_some())
        .filter(|arcs| arcs.iter().map(|arc| turn(&arc.curve)).sum::<f64>() > std::f64::consts::TAU - 1e-6)
        .map(|arcs| (FeatureKind::Circle, lines(arcs)))
        .collect();
    if !circles.is_empty() {
        return circles;
    }
    let plunges = |step: &Move| direction(step).is_some_and(|along| along.cross(normal(step)).length() < 1e-9);
    if pass.iter().all(plunges) {
        return vec![(FeatureKind::Hole, lines(pass))];
    }
    let from = pass.iter().position(|step| !plunges(step)).unwrap_or(0);
    let to = pass.iter().rposition(|step| !plunges(step)).unwrap_or(0);
    let level = &pass[from..=to];
    if is_plane(level) {
        return vec![(FeatureKind::Plane, lines(level))];
    }
    let is_edge = |step: &&Move| is_level(step) && step.curve.length() >= SHORTEST;
    level.iter().filter(is_edge).map(|step| (FeatureKind::Line, [step.line; 2])).collect()
}

/// Whether lines at one height mill a plane: at least three of them side by side, parallel to the longest.
fn is_plane(level: &[Move]) -> bool {
    let longest = level.iter().max_by(|one, other| one.curve.length().total_cmp(&other.curve.length()));
    let Some(along) = longest.and_then(direction).filter(|_| level.iter().all(is_level)) else { return false };
    let rows = level.iter().filter(|step| direction(step).is_some_and(|own| own.cross(along).length() < PARALLEL));
    let mut apart: Vec<DVec3> = Vec::new();
    for row in rows {
        let at = DVec3::from(row.curve.position(row.curve.domain().0)).reject_from_normalized(along);
        if apart.iter().all(|other| (*other - at).length() > SHORTEST) {
            apart.push(at);
        }
    }
    apart.len() >= ROWS
}

/// Whether a move is a line in the active plane.
fn is_level(step: &Move) -> bool {
    direction(step).is_some_and(|along| along.dot(normal(step)).abs() < 1e-9)
}

fn normal(step: &Move) -> DVec3 {
    DVec3::from(step.plane_normal)
}

/// Direction of a line.
fn direction(step: &Move) -> Option<DVec3> {
    match &step.curve {
        Curve::Line { start, end } => (DVec3::from(*end) - DVec3::from(*start)).try_normalize(),
        _ => None,
    }
}
