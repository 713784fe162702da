//! What one pass, between two rapid motions, cuts.

use super::chain;
use super::path::{Piece, direction, normal, plunges};
use crate::predict::kinds::FeatureKind;
use crate::predict::locate::{circle_of, turn};
use glam::DVec3;
use std::f64::consts::TAU;
use trueaxis_sim::program::Move;

/// Least distance of rows, mm.
const APART: f64 = 1.0;
/// Fewest rows of a plane: a rectangle's outline has two parallel sides.
const ROWS: usize = 3;
/// Sine of the largest angle between rows.
const PARALLEL: f64 = 1e-6;

/// The pieces of a pass; `from`: index of its first move.
pub(super) fn pieces(pass: &[Move], from: usize) -> Vec<Piece> {
    let mut at = from;
    let mut circles = Vec::new();
    for arcs in
        pass.chunk_by(|one, next| circle_of(one).zip(circle_of(next)).is_some_and(|(one, next)| one.is_near(&next)))
    {
        let is_circle = circle_of(&arcs[0]).is_some();
        if is_circle && arcs.iter().map(|arc| turn(&arc.curve)).sum::<f64>() > TAU - 1e-6 {
            circles.push(Piece::of(FeatureKind::Circle, arcs, at));
        }
        at += arcs.len();
    }
    if !circles.is_empty() {
        return circles;
    }
    if pass.iter().all(plunges) {
        return vec![Piece::of(FeatureKind::Hole, pass, from)];
    }
    let first = pass.iter().position(|step| !plunges(step)).unwrap_or(0);
    let last = pass.iter().rposition(|step| !plunges(step)).unwrap_or(0);
    let level = &pass[first..=last];
    if is_plane(level) {
        return vec![Piece::of(FeatureKind::Plane, level, from + first)];
    }
    chain::pieces(level, from + first)
}

/// Whether lines at one height mill a plane: at least three of them side by side, parallel to the longest.
fn is_plane(level: &[Move]) -> bool {
    let longest = level.iter().max_by(|one, other| one.curve.length().total_cmp(&other.curve.length()));
    let Some(along) = longest.and_then(direction).filter(|_| level.iter().all(is_level)) else { return false };
    let rows = level.iter().filter(|step| direction(step).is_some_and(|own| own.cross(along).length() < PARALLEL));
    let mut apart: Vec<DVec3> = Vec::new();
    for row in rows {
        let at = DVec3::from(row.curve.position(row.curve.domain().0)).reject_from_normalized(along);
        if apart.iter().all(|other| (*other - at).length() > APART) {
            apart.push(at);
        }
    }
    apart.len() >= ROWS
}

/// Whether a move is a line in the active plane.
fn is_level(step: &Move) -> bool {
    direction(step).is_some_and(|along| along.dot(normal(step)).abs() < 1e-9)
}
