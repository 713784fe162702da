//! Points about a local origin, with their squared distance minus that of a reference circle.

use super::ReferenceCircle;
use std::vec::Vec;

/// A point of the plane as a linear function of the centre.
///
/// With the local centre c, |p − c|² − R₀² = e − 2 p·c + |c|². The last term is common to all points, so that f(c) = e − 2 p·c
/// decides which are far and near, and if two points are equally far, c satisfies a linear equation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) x: f64,
    pub(super) y: f64,
    /// |p|² − R₀².
    pub(super) e: f64,
    pub(super) index: usize,
}

impl Point {
    /// f(c) = e − 2 p·c.
    pub(super) fn f(&self, c: [f64; 2]) -> f64 {
        self.e - 2.0 * (self.x * c[0] + self.y * c[1])
    }
}

/// Points about an origin near their common centre.
pub(super) struct Local {
    pub(super) origin: [f64; 2],
    /// R₀.
    pub(super) radius: f64,
    pub(super) points: Vec<Point>,
    /// Largest |e| and largest coordinate.
    largest: [f64; 2],
}

/// Centres of the four quarters of a square with half sides of 2.
pub(super) const QUARTERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];

/// Farthest and nearest point from a centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extremes {
    pub(super) far: Point,
    pub(super) near: Point,
    /// f of the farthest and of the nearest point.
    pub(super) high: f64,
    pub(super) low: f64,
}

impl Local {
    pub(super) fn new(points: &[[f64; 2]], origin: [f64; 2], radius: f64) -> Self {
        let local = |(index, p): (usize, &[f64; 2])| {
            let (x, x_rest) = two_sum(p[0], -origin[0]);
            let (y, y_rest) = two_sum(p[1], -origin[1]);
            let [xx, yy, rr] = [two_product(x, x), two_product(y, y), two_product(radius, radius)];
            let (sum, rest_1) = two_sum(xx.0, -rr.0);
            let (sum, rest_2) = two_sum(sum, yy.0);
            let rest = rest_1 + rest_2 + (xx.1 + yy.1 - rr.1) + 2.0 * (x * x_rest + y * y_rest);
            Point { x, y, e: sum + rest, index }
        };
        let points: Vec<Point> = points.iter().enumerate().map(local).collect();
        let largest = |value: fn(&Point) -> f64| points.iter().map(value).fold(0.0, f64::max);
        let largest = [largest(|p| p.e.abs()), largest(|p| p.x.abs().max(p.y.abs()))];
        Self { origin, radius, points, largest }
    }

    /// Removes coincident points except the first. They are equally far and near, so a search that divides until few points
    /// can decide would only end at rounding.
    ///
    /// Cost: n log n.
    pub(super) fn without_twins(mut self) -> Self {
        // Makes −0 and 0 equal.
        let place = |p: &Point| [p.x, p.y, p.e].map(|value| (value + 0.0).to_bits());
        self.points.sort_unstable_by_key(|p| (place(p), p.index));
        self.points.dedup_by_key(|p| place(p));
        self.points.sort_unstable_by_key(|p| p.index);
        self
    }

    /// Distance of a point with this f(c) from the local centre c.
    pub(super) fn distance(&self, f: f64, c: [f64; 2]) -> f64 {
        (self.radius * self.radius + (f + c[0] * c[0] + c[1] * c[1])).max(0.0).sqrt()
    }

    /// Difference of two distances from c, without cancellation: d₁ − d₂ = (f₁ − f₂)/(d₁ + d₂).
    pub(super) fn width(&self, high: f64, low: f64, c: [f64; 2]) -> f64 {
        let sum = self.distance(high, c) + self.distance(low, c);
        if sum > 0.0 { (high - low) / sum } else { 0.0 }
    }

    /// The farthest and the nearest point of each of several equally large groups, in the order of their directions: a bound
    /// for these is a bound for all.
    pub(super) fn sample(&self, groups: usize) -> [Vec<Point>; 2] {
        let mut around: Vec<(f64, &Point)> = self.points.iter().map(|p| (p.y.atan2(p.x), p)).collect();
        around.sort_by(|a, b| a.0.total_cmp(&b.0));
        let order = |a: &&(f64, &Point), b: &&(f64, &Point)| a.1.e.total_cmp(&b.1.e);
        let groups = || around.chunks(self.points.len().div_ceil(groups));
        [
            groups().filter_map(|group| group.iter().max_by(order)).map(|(_, p)| **p).collect(),
            groups().filter_map(|group| group.iter().min_by(order)).map(|(_, p)| **p).collect(),
        ]
    }

    pub(super) fn extremes(&self, c: [f64; 2]) -> Extremes {
        extremes(&self.points, &self.points, c)
    }

    /// Rounding error of f at centres up to a distance from the origin: smaller differences are meaningless.
    pub(super) fn noise(&self, distance: f64) -> f64 {
        let [e, size] = self.largest;
        4.0 * f64::EPSILON * (e + 2.0 * distance * size + f64::EPSILON * size * size)
    }

    /// Bound on the change of the difference of f between two points, per unit of the centre's movement.
    pub(super) fn steepest(&self) -> f64 {
        8.0 * self.largest[1]
    }

    /// The circle about c with all points between inner and outer; its radius is their mean.
    pub(super) fn circle(&self, c: [f64; 2], mut contacts: Vec<usize>) -> ReferenceCircle {
        let at = self.extremes(c);
        let (outer, inner) = (self.distance(at.high, c), self.distance(at.low, c));
        contacts.sort_unstable();
        contacts.dedup();
        ReferenceCircle {
            centre: [self.origin[0] + c[0], self.origin[1] + c[1]],
            radius: 0.5 * (outer + inner),
            zone: self.width(at.high, at.low, c),
            outer,
            inner,
            contacts,
        }
    }
}

/// Farthest point of the first and nearest of the second list; neither is empty.
pub(super) fn extremes(far: &[Point], near: &[Point], c: [f64; 2]) -> Extremes {
    let (mut a, mut high) = (far[0], f64::NEG_INFINITY);
    for point in far {
        let f = point.f(c);
        if f > high {
            (a, high) = (*point, f);
        }
    }
    let (mut b, mut low) = (near[0], f64::INFINITY);
    for point in near {
        let f = point.f(c);
        if f < low {
            (b, low) = (*point, f);
        }
    }
    Extremes { far: a, near: b, high, low }
}

/// The centre that is equally far from a₁ and b₁, and equally far from a₂ and b₂.
pub(super) fn equidistant(a1: &Point, b1: &Point, a2: &Point, b2: &Point) -> Option<[f64; 2]> {
    let (x1, y1, h1) = (a1.x - b1.x, a1.y - b1.y, 0.5 * (a1.e - b1.e));
    let (x2, y2, h2) = (a2.x - b2.x, a2.y - b2.y, 0.5 * (a2.e - b2.e));
    let determinant = x1 * y2 - x2 * y1;
    let c = [(h1 * y2 - h2 * y1) / determinant, (x1 * h2 - x2 * h1) / determinant];
    (c[0].is_finite() && c[1].is_finite()).then_some(c)
}

/// Sum and rounding error (Knuth 1969).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

/// Product and rounding error (Dekker 1971).
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let split = |v: f64| {
        let scaled = 134_217_729.0 * v;
        let high = scaled - (scaled - v);
        (high, v - high)
    };
    let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
    let product = a * b;
    (product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low)
}
