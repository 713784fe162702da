//! Minimum circumscribed circle.

use super::local::{Local, Point, equidistant, extremes};
use super::{NoCircle, ReferenceCircle, check};
use std::vec::Vec;

/// Smallest circle that encloses all points, MCC; it always exists and is unique.
///
/// Exchange: the circle of those two or three points and the one farthest outside replaces theirs, until none is outside. The
/// radius grows with every exchange, so no set occurs twice and the search is finite (Welzl 1991 for the bases; largest
/// violation first). Radius: the circle's own, = outer.
///
/// Cost: linear in the points, some ten passes.
///
/// # Errors
///
/// [`NoCircle::TooFew`], [`NoCircle::NonFinite`], [`NoCircle::Straight`].
pub fn minimum_circumscribed(points: &[[f64; 2]]) -> Result<ReferenceCircle, NoCircle> {
    check(points)?;
    let local = about(points);
    let (c, contacts) = enclose(&local);
    let circle = local.circle(c, contacts);
    Ok(ReferenceCircle { radius: circle.outer, ..circle })
}

/// Points about the centre of their circumscribed circle, to rounding: a second search from there preserves all digits.
pub(super) fn about(points: &[[f64; 2]]) -> Local {
    let any = Local::new(points, points[0], 0.0);
    let (c, _) = enclose(&any);
    let radius = any.distance(any.extremes(c).high, c);
    Local::new(points, [any.origin[0] + c[0], any.origin[1] + c[1]], radius)
}

/// Local centre of the smallest enclosing circle and the points that determine it.
fn enclose(local: &Local) -> ([f64; 2], Vec<usize>) {
    let first = local.extremes([local.points[0].x, local.points[0].y]).far;
    let second = local.extremes([first.x, first.y]).far;
    let mut basis = Basis::smallest(&[first, second]);
    // Every exchange enlarges the circle; the bound only guards against cycling due to rounding.
    for _ in 0..local.points.len() {
        let at = local.extremes(basis.centre);
        let mut with: Vec<Point> = basis.points.clone();
        if with.iter().any(|p| p.index == at.far.index) {
            break;
        }
        with.push(at.far);
        let next = Basis::smallest(&with);
        if next.square <= basis.square {
            break;
        }
        basis = next;
    }
    (basis.centre, basis.points.iter().map(|p| p.index).collect())
}

struct Basis {
    centre: [f64; 2],
    /// R² − R₀².
    square: f64,
    points: Vec<Point>,
}

impl Basis {
    /// Among all circles on two or three of at most four points, the one whose farthest point is nearest: it encloses all.
    fn smallest(points: &[Point]) -> Self {
        let mut best = Self { centre: [0.0; 2], square: f64::INFINITY, points: points.to_vec() };
        let mut offer = |c: [f64; 2], of: &[&Point]| {
            let square = extremes(points, points, c).high + c[0] * c[0] + c[1] * c[1];
            if square < best.square {
                best = Self { centre: c, square, points: of.iter().map(|p| **p).collect() };
            }
        };
        for (i, a) in points.iter().enumerate() {
            for (j, b) in points.iter().enumerate().skip(i + 1) {
                offer([0.5 * (a.x + b.x), 0.5 * (a.y + b.y)], &[a, b]);
                for k in points.iter().skip(j + 1) {
                    if let Some(c) = equidistant(a, b, a, k) {
                        offer(c, &[a, b, k]);
                    }
                }
            }
        }
        best
    }
}
