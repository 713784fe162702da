//! Passes that a later one repeats: other depths of one contour, and roughing with stock.

use super::path::{Piece, corners, direction, distance, normal};
use crate::predict::chords::circle_of_chords;
use crate::predict::circle::{Circle, NEAR};
use crate::predict::kinds::FeatureKind;
use crate::predict::locate::circle_of;
use glam::DVec3;
use trueaxis_report::number::shortest;
use trueaxis_sim::program::Move;

/// Largest stock, mm.
const STOCK: f64 = 2.0;
/// Largest difference of the sides of two faces, as a share.
const SIDES: f64 = 0.2;
/// Points of a path that are compared.
const COMPARED: usize = 60;

/// A piece as compared with others.
struct Shape {
    kind: FeatureKind,
    normal: DVec3,
    corners: Vec<DVec3>,
    low: DVec3,
    high: DVec3,
    circle: Option<Circle>,
    /// Rotary axes at its start and end, degrees.
    turn: [[f64; 3]; 2],
    /// Direction of an edge: the two sides of a slot are cut in opposite ones.
    along: Option<DVec3>,
}

/// For each piece that a later one repeats: the last of these, and where the piece is, seen from it.
pub(super) fn finishing(moves: &[Move], pieces: &[Piece]) -> Vec<Option<(usize, String)>> {
    let shapes: Vec<Shape> = pieces.iter().map(|piece| Shape::of(moves, piece)).collect();
    let next = |k: usize| (k + 1..shapes.len()).find(|later| shapes[k].is_repeated_by(&shapes[*later]));
    let nexts: Vec<Option<usize>> = (0..shapes.len()).map(next).collect();
    let last = |k: usize| {
        let mut last = nexts[k]?;
        while let Some(later) = nexts[last] {
            last = later;
        }
        Some((last, shapes[k].seen_from(&shapes[last])))
    };
    (0..shapes.len()).map(last).collect()
}

impl Shape {
    fn of(moves: &[Move], piece: &Piece) -> Shape {
        let own = &moves[piece.moves.clone()];
        let axis = normal(&own[0]);
        let corners = corners(own.iter());
        let chords = || circle_of_chords(&corners, axis, NEAR).map(|of| of.circle);
        let circle = (piece.kind == FeatureKind::Circle).then(|| circle_of(&own[0]).or_else(chords)).flatten();
        let along = (piece.kind == FeatureKind::Line).then(|| direction(&own[0])).flatten();
        let end = |of: fn(DVec3, DVec3) -> DVec3| corners.iter().copied().reduce(of).unwrap_or_default();
        let (low, high) = (end(DVec3::min), end(DVec3::max));
        let turn = [own[0].turn.start, own[own.len() - 1].turn.end()];
        Shape { kind: piece.kind, normal: axis, corners, low, high, circle, turn, along }
    }

    fn height(&self) -> f64 {
        self.corners.first().map_or(0.0, |corner| corner.dot(self.normal))
    }

    /// Whether a later piece cuts the same: the same path at another depth, or beside it within the stock.
    fn is_repeated_by(&self, later: &Shape) -> bool {
        if self.kind != later.kind || self.turn != later.turn || self.normal.distance(later.normal) > 1e-9 {
            return false;
        }
        let flat = |of: DVec3| of - of.dot(self.normal) * self.normal;
        let far = |one: DVec3, other: DVec3| flat(one - other).abs().max_element() > STOCK;
        if self.kind == FeatureKind::Plane {
            let sides = flat(later.high - later.low).abs();
            let apart = flat(self.low - later.low).abs().max(flat(self.high - later.high).abs());
            return self.height() >= later.height() - NEAR && apart.cmple(SIDES * sides + NEAR).all();
        }
        if far(self.low, later.low) || far(self.high, later.high) {
            return false;
        }
        let depth = (self.height() - later.height()).abs();
        match (self.circle, later.circle, self.along, later.along) {
            (Some(one), Some(other), ..) => {
                let same = (one.radius - other.radius).abs();
                flat(one.centre - other.centre).length() <= NEAR && (same <= NEAR || depth <= NEAR && same <= STOCK)
            }
            (.., Some(one), Some(other)) if one.dot(other) <= 0.0 => false,
            _ if self.kind == FeatureKind::Hole => self.apart(later, flat) <= NEAR,
            _ => self.apart(later, flat) <= NEAR || depth <= NEAR && self.apart(later, |point| point) <= STOCK,
        }
    }

    /// Largest distance of a point of one from the other.
    fn apart(&self, other: &Shape, seen: impl Fn(DVec3) -> DVec3) -> f64 {
        let path = |of: &Shape| of.corners.iter().map(|corner| seen(*corner)).collect::<Vec<DVec3>>();
        let [one, other] = [path(self), path(other)];
        let most = |points: &[DVec3], path: &[DVec3]| {
            let every = points.len().div_ceil(COMPARED).max(1);
            points.iter().step_by(every).map(|point| distance(*point, path)).fold(0.0, f64::max)
        };
        most(&one, &other).max(most(&other, &one))
    }

    /// Where it is, seen from the piece that repeats it last.
    fn seen_from(&self, last: &Shape) -> String {
        let flat = |of: DVec3| of - of.dot(self.normal) * self.normal;
        let higher = self.height() - last.height();
        let beside = match (self.circle, last.circle) {
            (Some(one), Some(other)) => (one.radius - other.radius).abs(),
            _ if matches!(self.kind, FeatureKind::Plane | FeatureKind::Hole) => 0.0,
            _ => self.apart(last, flat),
        };
        let mm = |value: f64| format!("{} mm", shortest((1e3 * value).round() * 1e-3));
        let mut parts = Vec::new();
        if higher.abs() > NEAR {
            parts.push(format!("{} {}", mm(higher.abs()), if higher > 0.0 { "higher" } else { "lower" }));
        }
        if beside > NEAR {
            parts.push(format!("{} beside", mm(beside)));
        }
        let what = match self.kind {
            FeatureKind::Plane => "the same face",
            FeatureKind::Hole => "the same hole",
            _ => "the same path",
        };
        if parts.is_empty() { what.to_owned() } else { format!("{what} {}", parts.join(" and ")) }
    }
}
