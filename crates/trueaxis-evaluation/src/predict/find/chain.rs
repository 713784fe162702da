//! Chains of moves without a corner.

use super::path::{Piece, corners, direction, normal};
use crate::predict::chords::circle_of_chords;
use crate::predict::circle::{NEAR, circle_through};
use crate::predict::kinds::FeatureKind;
use crate::predict::locate::ends;
use glam::DVec3;
use std::f64::consts::TAU;
use trueaxis_sim::program::{Curve, Move};

/// Shortest line that is an edge, mm.
const SHORTEST: f64 = 1.0;
/// Longest line or arc that may be a part of a curve, mm.
const SHORT: f64 = 10.0;
/// Fewest of them: a slot or a rectangle with rounded corners has fewer between its sides.
const FEWEST: usize = 5;
/// Cosine of the largest turn that is not a corner: about 30°, that of the coarsest chords of a circle.
const SMOOTH: f64 = 0.86;

/// Free forms, circles made of chords, and straight edges.
pub(super) fn pieces(level: &[Move], from: usize) -> Vec<Piece> {
    let mut found = Vec::new();
    let mut at = from;
    for chain in level.chunk_by(goes_on) {
        match kind(chain) {
            Some(kind) => found.push(Piece::of(kind, chain, at)),
            None => {
                let edges = chain.iter().enumerate().filter(|(_, step)| is_edge(step));
                found.extend(edges.map(|(k, step)| Piece::of(FeatureKind::Line, std::slice::from_ref(step), at + k)));
            }
        }
        at += chain.len();
    }
    found
}

/// What several moves, or a spline, are together.
fn kind(chain: &[Move]) -> Option<FeatureKind> {
    let corners = corners(chain.iter());
    let [first, last] = [*corners.first()?, *corners.last()?];
    let is_lines = chain.iter().all(|step| direction(step).is_some());
    if is_lines && chain.len() > 1 {
        let axis = normal(&chain[0]);
        let along = (last - first).normalize_or_zero();
        let is_straight = corners.iter().all(|corner| (*corner - first).reject_from(last - first).length() <= NEAR);
        if last != first && is_straight {
            let is_level = along.dot(axis).abs() < 1e-9 && first.distance(last) >= SHORTEST;
            return is_level.then_some(FeatureKind::Line);
        }
        let is_full = |turn: f64| turn > TAU - 1e-3;
        // The rim of a tilted cone is in no plane of G17 to G19.
        let axis = circle_through(&corners).map_or(axis, |(_, normal)| normal);
        if circle_of_chords(&corners, axis, NEAR).is_some_and(|chords| is_full(chords.angle)) {
            return Some(FeatureKind::Circle);
        }
    }
    let is_spline = |step: &Move| matches!(step.curve, Curve::Nurbs { .. });
    (chain.iter().any(is_spline) || chain.len() >= FEWEST).then_some(FeatureKind::Profile)
}

/// Whether two moves belong to one curve.
fn goes_on(one: &Move, next: &Move) -> bool {
    let is_part = |step: &Move| matches!(step.curve, Curve::Nurbs { .. }) || step.curve.length() <= SHORT;
    let tangent = |step: &Move, u: f64| DVec3::from(step.curve.derivatives(u).first).normalize_or_zero();
    let (before, after) = (tangent(one, one.curve.domain().1), tangent(next, next.curve.domain().0));
    let meet = ends(one)[1].distance(ends(next)[0]) < 1e-9;
    is_part(one) && is_part(next) && meet && before.dot(after) > SMOOTH
}

/// Whether a move is an edge: a line in the active plane.
fn is_edge(step: &Move) -> bool {
    let is_level = direction(step).is_some_and(|along| along.dot(normal(step)).abs() < 1e-9);
    is_level && step.curve.length() >= SHORTEST
}
