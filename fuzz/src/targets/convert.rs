//! Segments of arbitrary numbers, cut into spans: refused, or exact.

use crate::execution::SLOWEST;
use crate::outcome::{accepted, refused, saw};
use crate::{Target, no_repair};
use trueaxis::contour::{ContourSearch, Method, Path, PathError, Reference, Segment, Span, convert, span_count};
use trueaxis::glam::DVec3;

/// Lines, arcs, turnings and NURBS from bytes: a byte for the kind, then doubles.
pub const TARGET: Target = Target {
    name: "convert",
    about: "lines, arcs and NURBS of any numbers, cut into spans",
    run,
    seeds,
    repair: no_repair,
    dictionary: include_str!("../../dictionaries/convert.dict"),
    slowest: SLOWEST,
};

/// Most spans of a segment made and checked.
const MOST_CHECKED: usize = 64;

/// A segment that owns its lists.
enum Shape {
    Line([DVec3; 2]),
    Arc([DVec3; 4], u32),
    Turning(DVec3),
    Nurbs { degree: usize, knots: Vec<f64>, points: Vec<DVec3>, weights: Vec<f64> },
}

/// Consecutive doubles; zero beyond the end.
struct Doubles<'i>(std::slice::Iter<'i, [u8; 8]>);

impl Doubles<'_> {
    fn next(&mut self) -> f64 {
        self.0.next().map_or(0.0, |bytes| f64::from_le_bytes(*bytes))
    }
    fn point(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }
}

impl Shape {
    /// Kind, number (turns of an arc, degree of a spline), number of points, whether it has weights.
    fn of(input: &[u8]) -> Option<Shape> {
        let ([kind, number, count, weighted], rest) = input.split_first_chunk()?;
        let mut doubles = Doubles(rest.as_chunks().0.iter());
        Some(match kind % 4 {
            0 => Shape::Line([(); 2].map(|()| doubles.point())),
            1 => Shape::Arc([(); 4].map(|()| doubles.point()), u32::from(*number)),
            2 => Shape::Turning(doubles.point()),
            _ => {
                let (degree, count) = (usize::from(*number), usize::from(*count));
                let points = (0..count).map(|_| doubles.point()).collect();
                let weights = (0..if weighted % 2 == 1 { count } else { 0 }).map(|_| doubles.next()).collect();
                let knots = (0..count + degree + 1).map(|_| doubles.next()).collect();
                Shape::Nurbs { degree, knots, points, weights }
            }
        })
    }

    fn segment(&self) -> Segment<'_> {
        match self {
            Shape::Line([start, end]) => Segment::Line { start: *start, end: *end },
            Shape::Arc([start, end, center, normal], turns) => {
                Segment::Arc { start: *start, end: *end, center: *center, normal: *normal, turns: *turns }
            }
            Shape::Turning(point) => Segment::Turning { point: *point },
            Shape::Nurbs { degree, knots, points, weights } => {
                Segment::Nurbs { degree: *degree, knots, points, weights }
            }
        }
    }

    /// The point of the curve at u, by the plainest formula, without the code under attack.
    fn at(&self, u: f64) -> DVec3 {
        match self {
            Shape::Line([start, end]) => *start + (*end - *start) * u,
            Shape::Turning(point) => *point,
            Shape::Arc([start, end, center, normal], turns) => {
                arc(*start, *end, *center, normal.normalize(), *turns, u)
            }
            Shape::Nurbs { degree, knots, points, weights } => de_boor(*degree, knots, points, weights, u),
        }
    }

    /// Whether start and end of an arc are apart by the nanometre below which it is a whole turn, to within rounding: either
    /// reading is then correct.
    fn is_undecided(&self) -> bool {
        let Shape::Arc([start, end, center, normal], _) = self else { return false };
        let (radius, angle) = swept(*start, *end, *center, normal.normalize());
        let scale = [start, end, center].map(|point| point.abs().max_element()).into_iter().fold(1.0, f64::max);
        (angle * radius.max(1e-3) - 1e-9).abs() < 1e-14 * scale
    }

    /// Permitted rounding error, mm: from coordinates that far from zero, and from the quotients of a spline.
    fn tolerance(&self) -> f64 {
        let (points, weights): (&[DVec3], &[f64]) = match self {
            Shape::Line(points) => (points, &[]),
            Shape::Arc(points, _) => (&points[..3], &[]),
            Shape::Turning(point) => (std::slice::from_ref(point), &[]),
            Shape::Nurbs { points, weights, .. } => (points, weights),
        };
        let scale = points.iter().map(|point| point.abs().max_element()).fold(1.0, f64::max);
        let least = weights.iter().copied().fold(f64::INFINITY, f64::min);
        let spread = weights.iter().copied().fold(least, f64::max) / least;
        self.spiral() + 1e-9 + 1e-12 * scale * if weights.is_empty() { 1.0 } else { spread }
    }

    /// Error that the documentation permits if the radius of an arc changes, mm.
    fn spiral(&self) -> f64 {
        let Shape::Arc([start, end, center, normal], _) = self else { return 0.0 };
        let radius = |point: &DVec3| (*point - *center).reject_from(*normal).length();
        8e-6 * (radius(start) - radius(end)).abs()
    }
}

/// Radius at the start, and the angle from there to the end, −π to π.
fn swept(start: DVec3, end: DVec3, center: DVec3, axis: DVec3) -> (f64, f64) {
    let flat = |point: DVec3| point - center - axis * (point - center).dot(axis);
    let (from, to) = (flat(start), flat(end));
    let out = from.normalize();
    (from.length(), to.dot(axis.cross(out)).atan2(to.dot(out)))
}

fn arc(start: DVec3, end: DVec3, center: DVec3, axis: DVec3, turns: u32, u: f64) -> DVec3 {
    let flat = |point: DVec3| point - center - axis * (point - center).dot(axis);
    let (from, to) = (flat(start), flat(end));
    let out = from.normalize();
    let on = axis.cross(out);
    let (radius, mut angle) = swept(start, end, center, axis);
    if angle < 1e-9 / radius.max(1e-3) {
        angle += std::f64::consts::TAU;
    }
    let angle = angle + std::f64::consts::TAU * f64::from(turns);
    let radius = radius + u * (to.length() - radius);
    let height = (start - center).dot(axis) + u * (end - start).dot(axis);
    let (sine, cosine) = (u * angle).sin_cos();
    center + (out * cosine + on * sine) * radius + axis * height
}

/// Cox–de Boor recursion on points and weights.
fn de_boor(degree: usize, knots: &[f64], points: &[DVec3], weights: &[f64], u: f64) -> DVec3 {
    let span = (degree..points.len()).rev().find(|i| knots[*i] <= u && knots[*i] < knots[i + 1]).unwrap_or(degree);
    let homogeneous = |i: usize| {
        let weight = weights.get(i).copied().unwrap_or(1.0);
        (points[i] * weight, weight)
    };
    let mut row: Vec<(DVec3, f64)> = (span - degree..=span).map(homogeneous).collect();
    for level in 1..=degree {
        for j in (level..=degree).rev() {
            let (low, high) = (knots[span - degree + j], knots[span + 1 + j - level]);
            let a = (u - low) / (high - low);
            row[j] = (row[j - 1].0 * (1.0 - a) + row[j].0 * a, row[j - 1].1 * (1.0 - a) + row[j].1 * a);
        }
    }
    row[degree].0 / row[degree].1
}

fn run(input: &[u8]) {
    let Some(shape) = Shape::of(input) else { return refused("no kind of segment") };
    let segment = shape.segment();
    let mut spans: Vec<Span<f64, f64>> = Vec::new();
    let enough = PathError { field: "segment", index: None, found: 0.0, needed: "no more" };
    let made = convert(&segment, 7, [0.0, 0.0, 1.0], |span| {
        spans.push(span);
        if spans.len() < MOST_CHECKED { Ok(()) } else { Err(enough) }
    });
    let whole = match made {
        Ok(()) => true,
        Err(error) if error == enough => false,
        Err(error) => {
            assert!(span_count(&segment).is_err() || !spans.is_empty(), "counted, but refused: {error}");
            return refused(error);
        }
    };
    if whole {
        let counted = span_count(&segment).unwrap_or_else(|error| panic!("made, but not counted: {error}"));
        assert!(spans.len() as u32 <= counted, "{} spans, {counted} counted", spans.len());
    }
    accepted();
    saw((whole, spans.len().checked_ilog2()));
    exact(&shape, &spans);
    if let Some(span) = spans.first().filter(|span| !span.is_stationary()) {
        foot(&spans, span.position(0.5));
    }
}

/// Every span lies on the curve, has a length, and begins where the previous one ends.
fn exact(shape: &Shape, spans: &[Span<f64, f64>]) {
    let (tolerance, undecided) = (shape.tolerance(), shape.is_undecided());
    let mut end: Option<DVec3> = None;
    for span in spans {
        assert_eq!(span.segment(), 7);
        let [first, last] = span.u_range();
        // Equal if the parameter has no finer steps.
        assert!(first <= last, "a span from {first} to {last}");
        assert!(span.length().is_finite() && (span.length() > 0.0 || span.is_stationary()));
        // A parameter resolves only the floating-point steps near its value; with few such steps it does not identify a
        // point on the span.
        let step = (f64::EPSILON * first.abs().max(last.abs())).max(f64::from_bits(1)) / (last - first);
        let named = step < 1e-3;
        let tolerance = tolerance + if named { 8.0 * step * span.length() } else { 0.0 };
        for t in [0.0, 0.3, 1.0] {
            let (found, u) = (DVec3::from(span.position(t)), span.u_of(t));
            assert!(found.is_finite(), "{found} at {t}");
            let off = found.distance(shape.at(u));
            assert!(
                !named || undecided || off <= tolerance,
                "{off} mm off the curve at u = {u}, more than {tolerance}"
            );
        }
        let start = DVec3::from(span.position(0.0));
        if let Some(end) = end {
            assert!(start.distance(end) <= 2.0 * tolerance, "a gap of {} mm", start.distance(end));
        }
        end = Some(span.position(1.0).into());
    }
}

/// Searches for the point nearest to a place beside the path: it must not be farther than the point beside which the place
/// lies.
fn foot(spans: &[Span<f64, f64>], on: [f64; 3]) {
    let search = ContourSearch::new(0.5, Method::Guarded).expect("a window of half a millimetre");
    let path = Path::new(spans, 0, false);
    let nearby = [on[0] + 0.003, on[1] - 0.004, on[2] + 0.012];
    let found = search.nearest(&path, Reference { span: 0, t: 0.5 }, nearby);
    let scale = on.iter().fold(1.0_f64, |scale, x| scale.max(x.abs()));
    assert!(found.error.is_finite() && found.lag.is_finite() && (0.0..=1.0).contains(&found.t), "{found:?}");
    assert!(found.error <= 0.013 + 1e-9 * scale, "{} mm away, and 0.013 mm from a point of the path", found.error);
}

fn seeds() -> Vec<Vec<u8>> {
    let bytes = |head: [u8; 4], doubles: &[f64]| {
        head.into_iter().chain(doubles.iter().flat_map(|double| double.to_le_bytes())).collect::<Vec<u8>>()
    };
    let spline = [0.0, 0.0, 0.0, 3.0, 4.0, 0.0, 6.0, -2.0, 1.0, 9.0, 5.0, 0.0, 12.0, 0.0, 0.0];
    let weights = [1.0, 0.7, 2.0, 1.0, 1.0];
    let knots = [0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0];
    let quintic: Vec<f64> = (0..18).map(f64::from).map(|k| (1.7 * k).sin() * 5.0).collect();
    vec![
        bytes([0, 0, 0, 0], &[0.0, 0.0, 0.0, 10.0, 20.0, -3.0]),
        bytes([1, 0, 0, 0], &[10.0, 0.0, 0.0, 0.0, 10.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
        bytes([1, 2, 0, 0], &[10.0, 0.0, 0.0, 10.01, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0]),
        bytes([2, 0, 0, 0], &[1.0, 2.0, 3.0]),
        bytes([3, 3, 5, 0], &[&spline[..], &knots].concat()),
        bytes([3, 3, 5, 1], &[&spline[..], &weights, &knots].concat()),
        bytes([3, 5, 6, 0], &[&quintic[..], &[0.0; 6], &[2.0; 6]].concat()),
        bytes([3, 1, 3, 0], &[0.0, 0.0, 0.0, 3.0, 4.0, 0.0, 6.0, -2.0, 1.0, 0.0, 0.0, 1.0, 2.0, 2.0]),
    ]
}
