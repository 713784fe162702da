//! Parameter of a curve at arc length, as a table for the servo cycle.

use crate::program::{Curve, Move};

/// Largest distance in mm along the curve between the table's point and the exact one, tested at three points of each
/// interval.
const TOLERANCE: f64 = 1.0e-9;

/// Intervals are halved at most this often.
const DEEPEST_HALVING: u32 = 40;

/// A point of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    /// Arc length from the start of the curve, mm.
    s: f64,
    u: f64,
    /// du/ds = 1 / |C'(u)| after and before the node; they differ at knots.
    after: f64,
    before: f64,
}

/// u(s) by cubic Hermite interpolation between nodes with exact values and slopes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ArcLength {
    nodes: Vec<Node>,
}

impl ArcLength {
    pub(super) fn new(curve: &Curve) -> ArcLength {
        let breaks = curve.breaks();
        let mut table = ArcLength { nodes: vec![Node { s: 0.0, u: breaks[0], after: 0.0, before: 0.0 }] };
        for piece in breaks.windows(2) {
            table.add(curve, piece[0], piece[1], DEEPEST_HALVING);
        }
        table
    }

    /// Table along a move; proportional to the parameter if the move is measured in degrees.
    pub(super) fn of(element: &Move) -> ArcLength {
        if !element.in_degrees() {
            return ArcLength::new(&element.curve);
        }
        let ((first, last), length) = (element.curve.domain(), element.length());
        let slope = (last - first) / length;
        ArcLength {
            nodes: vec![
                Node { s: 0.0, u: first, after: slope, before: 0.0 },
                Node { s: length, u: last, after: 0.0, before: slope },
            ],
        }
    }

    pub(super) fn length(&self) -> f64 {
        self.nodes.last().map_or(0.0, |node| node.s)
    }

    /// Appends nodes for u in a..b, halving until the quarters agree.
    fn add(&mut self, curve: &Curve, a: f64, b: f64, depth: u32) {
        let quarters = [0.0, 0.25, 0.5, 0.75].map(|part| a + part * (b - a));
        let [_, first_quarter, middle, last_quarter] = quarters;
        let parts = [
            curve.length_between(a, first_quarter),
            curve.length_between(first_quarter, middle),
            curve.length_between(middle, last_quarter),
            curve.length_between(last_quarter, b),
        ];
        let length: f64 = parts.iter().sum();
        if length <= 0.0 {
            return;
        }
        let start = self.length();
        // Slopes beyond three times the secant would make the cubic non-monotone (Fritsch and Carlson 1980).
        let steepest = 3.0 * (b - a) / length;
        let slope = |u: f64| (1.0 / curve.speed(u)).min(steepest);
        // The derivative at b belongs to the interval before it: approach from inside.
        let inside = b - (b - a) * 1.0e-9;
        let first = Node { s: start, u: a, after: slope(a), before: 0.0 };
        let last = Node { s: start + length, u: b, after: 0.0, before: slope(inside) };
        let mut s = start;
        let off = quarters.iter().skip(1).zip(parts).any(|(u, part)| {
            s += part;
            (hermite(&first, &last, s) - u).abs() * curve.speed(*u) > TOLERANCE
        });
        if depth > 0 && off && length > TOLERANCE {
            self.add(curve, a, middle, depth - 1);
            self.add(curve, middle, b, depth - 1);
            return;
        }
        if let Some(node) = self.nodes.last_mut() {
            node.after = first.after;
        }
        self.nodes.push(last);
    }

    /// u at arc length s, searched from the interval `cursor` on; s must not decrease from call to call.
    pub(super) fn parameter(&self, s: f64, cursor: &mut usize) -> f64 {
        while self.nodes.get(*cursor + 1).is_some_and(|node| node.s < s) {
            *cursor += 1;
        }
        match (self.nodes.get(*cursor), self.nodes.get(*cursor + 1)) {
            (Some(a), Some(b)) => hermite(a, b, s.min(b.s)),
            (Some(a), None) => a.u,
            _ => 0.0,
        }
    }
}

fn hermite(a: &Node, b: &Node, s: f64) -> f64 {
    let width = b.s - a.s;
    let t = (s - a.s) / width;
    let rise = b.u - a.u;
    let (p, q) = (a.after * width - rise, b.before * width - rise);
    a.u + t * (rise + (1.0 - t) * ((1.0 - t) * p - t * q))
}
