//! The path of a piece of a program.

use crate::predict::kinds::FeatureKind;
use crate::predict::locate::ends;
use glam::DVec3;
use std::ops::Range;
use trueaxis_sim::program::{Curve, Move};

/// Positions on an arc or spline.
const ON_CURVE: usize = 32;

/// Moves that cut one feature.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub(super) kind: FeatureKind,
    pub(super) moves: Range<usize>,
    /// First and last line of the program.
    pub(super) lines: [u32; 2],
}

impl Piece {
    /// A piece of a pass; `from`: index of the pass's first move in the program.
    pub(super) fn of(kind: FeatureKind, moves: &[Move], from: usize) -> Piece {
        Piece { kind, moves: from..from + moves.len(), lines: [moves[0].line, moves[moves.len() - 1].line] }
    }
}

/// Direction of a line.
pub(super) fn direction(step: &Move) -> Option<DVec3> {
    match &step.curve {
        Curve::Line { start, end } => (DVec3::from(*end) - DVec3::from(*start)).try_normalize(),
        _ => None,
    }
}

pub(super) fn normal(step: &Move) -> DVec3 {
    DVec3::from(step.plane_normal)
}

/// Whether a line goes along the plane's normal: into the material or out of it.
pub(super) fn plunges(step: &Move) -> bool {
    direction(step).is_some_and(|along| along.cross(normal(step)).length() < 1e-9)
}

/// Points along moves that cut: the corners of a polyline.
pub(super) fn corners<'m>(moves: impl Iterator<Item = &'m Move>) -> Vec<DVec3> {
    let mut corners: Vec<DVec3> = Vec::new();
    for step in moves.filter(|step| !step.rapid) {
        let (first, last) = step.curve.domain();
        let count = if matches!(step.curve, Curve::Line { .. }) { 1 } else { ON_CURVE };
        let from = usize::from(corners.last().is_some_and(|corner| corner.distance(ends(step)[0]) < 1e-9));
        let at = |k: usize| DVec3::from(step.curve.position(first + (last - first) * k as f64 / count as f64));
        corners.extend((from..=count).map(at));
    }
    corners
}

/// Distance of a point from a polyline.
pub(super) fn distance(point: DVec3, corners: &[DVec3]) -> f64 {
    let to = |pair: &[DVec3]| {
        let [from, way] = [pair[0], pair[1] - pair[0]];
        let share = (point - from).dot(way) / way.length_squared().max(f64::MIN_POSITIVE);
        point.distance_squared(from + share.clamp(0.0, 1.0) * way)
    };
    let first = corners.first().map_or(f64::INFINITY, |corner| point.distance_squared(*corner));
    corners.windows(2).map(to).fold(first, f64::min).sqrt()
}
