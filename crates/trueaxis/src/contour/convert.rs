//! From lines, arcs, helices and splines to spans: once, outside the step, in double precision.

use super::span::{Form, Span};
use crate::position::Position;
use crate::real::Real;
use core::fmt;

/// A segment of a programmed path, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Segment<'a> {
    /// Straight; u = 0..1 proportional to length.
    Line {
        /// Start.
        start: [f64; 3],
        /// End.
        end: [f64; 3],
    },
    /// Circular about `normal` (right hand), a helix where start and end differ along it; u = 0..1 proportional to the
    /// angle. Start and end at the same angle make a full circle.
    Arc {
        /// Start.
        start: [f64; 3],
        /// End.
        end: [f64; 3],
        /// A point of the axis.
        center: [f64; 3],
        /// Direction of the axis, any length.
        normal: [f64; 3],
        /// Full turns beyond the first arc.
        turns: u32,
    },
    /// The tip stands while the tool's direction turns; u = 0..1.
    Turning {
        /// Where.
        point: [f64; 3],
    },
    /// Spline with u over `knots[degree] ..= knots[points.len()]`.
    Nurbs {
        /// Degree, 1 to 5.
        degree: usize,
        /// `points.len() + degree + 1` knots, ascending.
        knots: &'a [f64],
        /// Control points.
        points: &'a [[f64; 3]],
        /// As many weights, positive; none at all for weights of one.
        weights: &'a [f64],
    },
}

/// What is wrong with a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathError {
    /// Which part of the segment.
    pub field: &'static str,
    /// Which element, where the part is a list.
    pub index: Option<usize>,
    /// What was found.
    pub found: f64,
    /// What is needed.
    pub needed: &'static str,
}

impl fmt::Display for PathError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.field)?;
        if let Some(index) = self.index {
            write!(f, "[{index}]")?;
        }
        write!(f, ": found {}, needed {}", self.found, self.needed)
    }
}

impl core::error::Error for PathError {}

fn refuse<T>(field: &'static str, index: Option<usize>, found: f64, needed: &'static str) -> Result<T, PathError> {
    Err(PathError { field, index, found, needed })
}

/// Largest distance of a span from its origin, mm.
pub(super) const REACH: f64 = 8.0;
/// Largest angle by which a span's tangent turns, rad (30°, less a hair for rounding).
const TURN: f64 = 0.523;
/// Largest error of a helix' axial coordinate, mm.
const HELIX_ERROR: f64 = 1e-10;
/// Radii at start and end of an arc may differ by this much, mm (what rounded programs leave); the radius then changes
/// linearly with the angle.
const RADIUS_TOLERANCE: f64 = 0.02;
/// Points closer than this are the same, mm.
const SAME_POINT: f64 = 1e-9;
/// A spline is halved at most this often for its turn; a cusp is never turned by less.
const HALVINGS: u32 = 24;
/// A spline is halved at most this often for its reach: its parameter has no finer steps.
const FINEST: u32 = 48;
/// Most spans of a segment.
const MOST: u32 = 1_000_000;
const TOO_MANY: &str = "a segment of at most 1000000 spans, each within 8 mm of its middle";

/// Speeds at a spline piece's ends may differ from its mean by this factor, …
const UNEVEN: f64 = 1.5;
/// … for as many halvings: at a point without speed they always do.
const EVENING: u32 = 8;

type Vector = [f64; 3];

fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
fn along(a: Vector, t: f64, b: Vector) -> Vector {
    [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]]
}
fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
fn norm(a: Vector) -> f64 {
    libm::sqrt(dot(a, a))
}

fn finite(field: &'static str, point: Vector) -> Result<(), PathError> {
    match point.iter().find(|x| !x.is_usable()) {
        Some(x) => refuse(field, None, *x, "finite coordinates below 1e9 mm"),
        None => Ok(()),
    }
}

/// Converts a segment into spans, handed to `sink` in path order.
///
/// `number` is the segment's number, `plane` the normal of the machining plane (G17 to G19) for the signed components.
/// Lines, circles and splines are exact; a helix' axial coordinate is within 1e-10 mm.
///
/// # Errors
/// The segment is no path, or the sink's own refusal.
pub fn convert<R: Real, P: Position>(
    segment: &Segment<'_>,
    number: u32,
    plane: [f64; 3],
    mut sink: impl FnMut(Span<R, P>) -> Result<(), PathError>,
) -> Result<(), PathError> {
    finite("plane", plane)?;
    let length = norm(plane);
    if length < 1e-6 {
        return refuse("plane", None, length, "a direction");
    }
    let plane = plane.map(|x| R::of(x / length));
    let position = core::marker::PhantomData;
    Maker { number, count: 0, counting: false, plane, sink: &mut sink, position }.segment(segment)
}

/// How many spans [`convert`] makes of a segment, at most: known before any is made, so that memory can be refused or lent.
///
/// In time for lines and arcs that does not grow with the number; splines are cut without their spans being formed.
///
/// # Errors
/// The segment is no path, or needs more than 1,000,000 spans.
pub fn span_count(segment: &Segment<'_>) -> Result<u32, PathError> {
    let mut none = |_: Span<f64, f64>| Ok(());
    let position = core::marker::PhantomData;
    let mut maker = Maker { number: 0, count: 0, counting: true, plane: [0.0; 3], sink: &mut none, position };
    maker.segment(segment)?;
    Ok(maker.count)
}

struct Maker<'s, R, P, S> {
    number: u32,
    /// Spans made, or counted, so far.
    count: u32,
    /// Whether they are only counted.
    counting: bool,
    plane: [R; 3],
    sink: &'s mut S,
    position: core::marker::PhantomData<P>,
}

/// A homogeneous polynomial about an exact origin, coefficients of t^0 to t^5.
struct Piece {
    origin: Vector,
    coefficients: [[f64; 4]; 6],
    form: Form,
    u: [f64; 2],
    quarter_tangent: f64,
}

impl<R: Real, P: Position, S: FnMut(Span<R, P>) -> Result<(), PathError>> Maker<'_, R, P, S> {
    fn segment(&mut self, segment: &Segment<'_>) -> Result<(), PathError> {
        match *segment {
            Segment::Line { start, end } => self.line(start, end),
            Segment::Arc { start, end, center, normal, turns } => self.arc(start, end, center, normal, turns),
            Segment::Turning { point } => {
                finite("point", point)?;
                if self.counting {
                    return self.counted(1);
                }
                let span = Span::turning(point.map(P::of), self.number, self.plane);
                (self.sink)(span)
            }
            Segment::Nurbs { degree, knots, points, weights } => self.nurbs(degree, knots, points, weights),
        }
    }

    /// Counts spans instead of making them.
    fn counted(&mut self, count: u32) -> Result<(), PathError> {
        self.count = self.count.saturating_add(count);
        Ok(())
    }

    fn emit(&mut self, mut piece: Piece) -> Result<(), PathError> {
        // The origin is rounded to what positions can say; the polynomial moves by what that leaves.
        let origin = piece.origin.map(P::of);
        let left: Vector = core::array::from_fn(|k| piece.origin[k] - origin[k].to_f64());
        for c in &mut piece.coefficients {
            for (k, left) in left.iter().enumerate() {
                c[k] += left * c[3];
            }
        }
        let (start, end, length) =
            (speed(&piece.coefficients, 0.0), speed(&piece.coefficients, 1.0), length(&piece.coefficients));
        if length <= 0.0 {
            return Ok(());
        }
        // a t + b t² + c t³ with the speeds at both ends and the whole length.
        let arc = [start, 3.0 * length - 2.0 * start - end, start + end - 2.0 * length];
        (self.sink)(Span {
            origin,
            coefficients: piece.coefficients.map(|c| c.map(R::of)),
            arc: arc.map(R::of),
            plane: self.plane,
            form: piece.form,
            segment: self.number,
            u: piece.u,
            quarter_tangent: piece.quarter_tangent,
        })
    }

    fn line(&mut self, start: Vector, end: Vector) -> Result<(), PathError> {
        finite("start", start)?;
        finite("end", end)?;
        let way = sub(end, start);
        let length = norm(way);
        if length < SAME_POINT {
            return refuse("end", None, length, "a line longer than 1e-9 mm, or a turning of the tool");
        }
        let count = libm::ceil(length / (2.0 * REACH)).max(1.0);
        if count > f64::from(MOST) {
            return refuse("end", None, length, "a line of at most 1.6e7 mm");
        }
        if self.counting {
            return self.counted(count as u32);
        }
        for i in 0..count as u32 {
            let u = [f64::from(i) / count, f64::from(i + 1) / count];
            let half = along([0.0; 3], 0.5 / count, way);
            let mut coefficients = [[0.0; 4]; 6];
            coefficients[0] = [-half[0], -half[1], -half[2], 1.0];
            coefficients[1] = [2.0 * half[0], 2.0 * half[1], 2.0 * half[2], 0.0];
            let origin = along(start, 0.5 * (u[0] + u[1]), way);
            self.emit(Piece { origin, coefficients, form: Form::Cubic, u, quarter_tangent: 0.0 })?;
        }
        Ok(())
    }

    fn arc(&mut self, start: Vector, end: Vector, center: Vector, normal: Vector, turns: u32) -> Result<(), PathError> {
        for (field, point) in [("start", start), ("end", end), ("center", center), ("normal", normal)] {
            finite(field, point)?;
        }
        let size = norm(normal);
        if size < 1e-6 {
            return refuse("normal", None, size, "a direction");
        }
        if turns > 10_000 {
            return refuse("turns", None, f64::from(turns), "at most 10000");
        }
        let n = normal.map(|x| x / size);
        let across = |p: Vector| along(p, -dot(p, n), n);
        let (from, to) = (across(sub(start, center)), across(sub(end, center)));
        let (radius, end_radius) = (norm(from), norm(to));
        if radius < SAME_POINT {
            return refuse("center", None, radius, "a radius above 1e-9 mm");
        }
        if (radius - end_radius).abs() > RADIUS_TOLERANCE + 1e-3 * radius.min(1.0) {
            return refuse("end", None, end_radius - radius, "the same radius at start and end, within 0.02 mm");
        }
        let e1 = from.map(|x| x / radius);
        let e2 = cross(n, e1);
        let mut angle = libm::atan2(dot(to, e2), dot(to, e1));
        if angle < 1e-9 / radius.max(1e-3) {
            angle += core::f64::consts::TAU;
        }
        let angle = angle + core::f64::consts::TAU * f64::from(turns);
        let rise = dot(sub(end, start), n);
        let pitch = rise / angle;
        let growth = if (end_radius - radius).abs() < SAME_POINT { 0.0 } else { (end_radius - radius) / angle };

        // Enough pieces for the turn, the reach, and the helix' axial polynomial.
        let mut count = libm::ceil((angle / TURN).max(norm([radius * angle, rise, 0.0]) / (2.0 * REACH))).max(1.0);
        while axial_error(angle / count, pitch) > HELIX_ERROR && count <= f64::from(MOST) {
            count *= 1.25;
        }
        let count = libm::ceil(count);
        if count > f64::from(MOST) {
            let length = norm([radius * angle, rise, 0.0]);
            return refuse("length", None, length, TOO_MANY);
        }
        if self.counting {
            return self.counted(count as u32);
        }
        let k = libm::tan(0.25 * angle / count);
        for i in 0..count as u32 {
            let u = [f64::from(i) / count, f64::from(i + 1) / count];
            let middle = angle * 0.5 * (u[0] + u[1]);
            let (s, c) = (libm::sin(middle), libm::cos(middle));
            let out: Vector = core::array::from_fn(|j| c * e1[j] + s * e2[j]);
            let on: Vector = core::array::from_fn(|j| c * e2[j] - s * e1[j]);
            let origin: Vector = core::array::from_fn(|j| {
                let height = dot(sub(start, center), n) + pitch * middle;
                center[j] + (radius + growth * middle) * out[j] + height * n[j]
            });
            let radius = radius + growth * middle;
            // In τ = −1..1: w = 1 + k²τ², (xyz) w = r(−2k²τ² out + 2kτ on) + pitch θ w n.
            let axial = axial_polynomial(k).map(|c| c * pitch);
            let mut tau = [[0.0; 4]; 6];
            for j in 0..3 {
                tau[1][j] = 2.0 * k * radius * on[j];
                tau[2][j] = -2.0 * k * k * radius * out[j];
                for (power, axial) in [1, 3, 5].into_iter().zip(axial) {
                    tau[power][j] += axial * n[j];
                }
            }
            // A changing radius adds growth θ ((1 − k²τ²) out + 2kτ on); what its series leaves out is growth k⁷.
            let (k2, k3, k4, k5) = (k * k, k * k * k, k * k * k * k, k * k * k * k * k);
            let spiral = [
                (1, 2.0 * k, 0.0),
                (2, 0.0, 4.0 * k2),
                (3, -8.0 / 3.0 * k3, 0.0),
                (4, 0.0, -4.0 / 3.0 * k4),
                (5, 16.0 / 15.0 * k5, 0.0),
            ];
            for (power, outward, onward) in spiral {
                for j in 0..3 {
                    tau[power][j] += growth * (outward * out[j] + onward * on[j]);
                }
            }
            tau[0][3] = 1.0;
            tau[2][3] = k2;
            let form = if rise == 0.0 && growth == 0.0 { Form::RationalCubic } else { Form::RationalQuintic };
            self.emit(Piece { origin, coefficients: from_tau(tau), form, u, quarter_tangent: k })?;
        }
        Ok(())
    }

    fn nurbs(&mut self, degree: usize, knots: &[f64], points: &[Vector], weights: &[f64]) -> Result<(), PathError> {
        if !(1..=5).contains(&degree) {
            return refuse("degree", None, degree as f64, "1 to 5");
        }
        if points.len() <= degree {
            return refuse("points", None, points.len() as f64, "more control points than the degree");
        }
        if knots.len() != points.len() + degree + 1 {
            return refuse("knots", None, knots.len() as f64, "as many knots as control points, degree and one");
        }
        if !weights.is_empty() && weights.len() != points.len() {
            return refuse("weights", None, weights.len() as f64, "as many weights as control points, or none");
        }
        for (i, point) in points.iter().enumerate() {
            finite("points", *point).map_err(|error| PathError { index: Some(i), ..error })?;
        }
        for (i, weight) in weights.iter().enumerate() {
            if !(*weight > 0.0 && *weight < 1e9) {
                return refuse("weights", Some(i), *weight, "positive finite weights");
            }
        }
        for (i, knot) in knots.iter().enumerate() {
            let before = if i == 0 { *knot } else { knots[i - 1] };
            if !knot.is_usable() || *knot < before {
                return refuse("knots", Some(i), *knot, "finite ascending knots");
            }
        }
        if knots[points.len()] <= knots[degree] {
            return refuse("knots", Some(points.len()), knots[points.len()], "a domain of positive length");
        }
        for i in degree..points.len() {
            // A knot within an inner run of more than `degree` breaks the curve.
            if i > degree && knots[i + degree] - knots[i] <= 0.0 && i + degree < knots.len() - 1 {
                return refuse("knots", Some(i), knots[i], "inner knots of at most the degree's multiplicity");
            }
        }
        let rational = weights.iter().any(|w| *w != weights[0]);
        for i in degree..points.len() {
            let u = [knots[i], knots[i + 1]];
            if u[1] <= u[0] {
                continue;
            }
            let origin = points[i - degree / 2];
            let control = |j: usize| {
                let w = if rational { weights[j] } else { 1.0 };
                let p = sub(points[j], origin);
                [p[0] * w, p[1] * w, p[2] * w, w]
            };
            let mut bezier = [[0.0; 4]; 6];
            for (j, to) in bezier.iter_mut().enumerate().take(degree + 1) {
                *to = blossom(degree, knots, i, control, u, j);
            }
            // The pieces of a chord are no fewer than its length over theirs: no need to cut a spline to refuse it.
            let ends = [bezier[0], bezier[degree]].map(|b| -> Vector { core::array::from_fn(|k| b[k] / b[3]) });
            let chord = norm(sub(ends[1], ends[0]));
            if chord > 2.0 * REACH * f64::from(MOST) {
                return refuse("points", Some(i), chord, TOO_MANY);
            }
            self.split(degree, bezier, origin, u, rational, 0)?;
        }
        Ok(())
    }

    /// Halves a Bézier piece until it is short and straight enough; recursion is bounded by `FINEST`.
    fn split(
        &mut self,
        degree: usize,
        b: [[f64; 4]; 6],
        origin: Vector,
        u: [f64; 2],
        rational: bool,
        depth: u32,
    ) -> Result<(), PathError> {
        let hull = |j: usize| -> Vector { core::array::from_fn(|k| b[j][k] / b[j][3]) };
        let middle: Vector = {
            let (first, last) = (hull(0), hull(degree));
            core::array::from_fn(|k| 0.5 * (first[k] + last[k]))
        };
        let far = (0..=degree).map(|j| norm(sub(hull(j), middle))).fold(0.0, f64::max);
        let mut turn = 0.0;
        let mut last = None::<Vector>;
        for j in 0..degree {
            let leg = sub(hull(j + 1), hull(j));
            if norm(leg) < SAME_POINT {
                continue;
            }
            if let Some(last) = last {
                turn += libm::atan2(norm(cross(last, leg)), dot(last, leg));
            }
            last = Some(leg);
        }
        // Speeds at both ends against the mean: the arc length's cubic wants them alike.
        let ends =
            [(b[1][3] / b[0][3], hull(0), hull(1)), (b[degree - 1][3] / b[degree][3], hull(degree - 1), hull(degree))];
        let mean = norm(sub(hull(degree), hull(0)));
        let uneven = ends.into_iter().any(|(w, from, to)| {
            let speed = degree as f64 * w * norm(sub(to, from));
            speed > UNEVEN * mean || mean > UNEVEN * speed
        });
        if far > REACH && depth == FINEST {
            return refuse("points", None, far, "a spline whose speed is not concentrated in a single point");
        }
        if far > REACH || (turn > TURN && depth < HALVINGS) || (uneven && depth < EVENING) {
            let (mut left, mut right, mut row) = ([[0.0; 4]; 6], [[0.0; 4]; 6], b);
            for level in 0..=degree {
                left[level] = row[0];
                right[degree - level] = row[degree - level];
                for j in 0..degree - level {
                    row[j] = core::array::from_fn(|k| 0.5 * (row[j][k] + row[j + 1][k]));
                }
            }
            let half = 0.5 * (u[0] + u[1]);
            self.split(degree, left, origin, [u[0], half], rational, depth + 1)?;
            return self.split(degree, right, origin, [half, u[1]], rational, depth + 1);
        }
        self.count += 1;
        if self.count > MOST {
            return refuse("points", None, f64::from(self.count), TOO_MANY);
        }
        if self.counting {
            return Ok(());
        }
        // Origin to the middle of the piece, Bernstein to power basis: c_k = C(n,k) Δ^k b_0; weights scaled to about 1.
        let scale = 1.0 / b[0][3];
        let mut difference = [[0.0; 4]; 6];
        for (to, from) in difference.iter_mut().zip(&b).take(degree + 1) {
            *to = core::array::from_fn(|k| scale * if k < 3 { from[k] - middle[k] * from[3] } else { from[3] });
        }
        let mut coefficients = [[0.0; 4]; 6];
        let mut binomial = 1.0;
        for power in 0..=degree {
            coefficients[power] = difference[0].map(|c| c * binomial);
            binomial *= (degree - power) as f64 / (power + 1) as f64;
            for j in 0..degree - power {
                difference[j] = core::array::from_fn(|k| difference[j + 1][k] - difference[j][k]);
            }
        }
        if !rational {
            for (power, c) in coefficients.iter_mut().enumerate() {
                c[3] = if power == 0 { 1.0 } else { 0.0 };
            }
        }
        let form = match (degree <= 3, rational) {
            (true, false) => Form::Cubic,
            (true, true) => Form::RationalCubic,
            (false, false) => Form::Quintic,
            (false, true) => Form::RationalQuintic,
        };
        let origin = along(origin, 1.0, middle);
        self.emit(Piece { origin, coefficients, form, u, quarter_tangent: 0.0 })
    }
}

/// Bézier point `j` of knot span `i`: the blossom at `degree − j` times the span's start and `j` times its end.
fn blossom(
    degree: usize,
    knots: &[f64],
    i: usize,
    control: impl Fn(usize) -> [f64; 4],
    u: [f64; 2],
    j: usize,
) -> [f64; 4] {
    let mut d = [[0.0; 4]; 6];
    for (k, d) in d.iter_mut().enumerate().take(degree + 1) {
        *d = control(i - degree + k);
    }
    for r in 1..=degree {
        let at = if r <= j { u[1] } else { u[0] };
        for k in (r..=degree).rev() {
            let (low, high) = (knots[i - degree + k], knots[i + 1 + k - r]);
            let a = (at - low) / (high - low);
            d[k] = core::array::from_fn(|c| (1.0 - a) * d[k - 1][c] + a * d[k][c]);
        }
    }
    d[degree]
}

/// θ w = 2 atan(kτ)(1 + k²τ²) = 2(kτ + ⅔k³τ³ − 2/15 k⁵τ⁵ + 2/35 k⁷τ⁷ − …), its τ⁷ spread over the lower odd powers
/// by the Chebyshev polynomial T₇ = 64τ⁷ − 112τ⁵ + 56τ³ − 7τ: coefficients of τ, τ³, τ⁵.
fn axial_polynomial(k: f64) -> [f64; 3] {
    let k2 = k * k;
    let (c1, c3, c5, c7) = (2.0 * k, 4.0 / 3.0 * k * k2, -4.0 / 15.0 * k * k2 * k2, 4.0 / 35.0 * k * k2 * k2 * k2);
    [c1 + c7 * 7.0 / 64.0, c3 - c7 * 56.0 / 64.0, c5 + c7 * 112.0 / 64.0]
}

/// Bound of what that leaves, mm: a 64th of the τ⁷ term, and all of the τ⁹ term.
fn axial_error(angle: f64, pitch: f64) -> f64 {
    let k = libm::tan(0.25 * angle);
    let k7 = libm::pow(k, 7.0);
    pitch.abs() * k7 * (4.0 / 35.0 / 64.0 + 4.0 / 63.0 * k * k)
}

/// A polynomial in τ = 2t − 1 as one in t.
fn from_tau(tau: [[f64; 4]; 6]) -> [[f64; 4]; 6] {
    // Horner's scheme with the factor (2t − 1).
    let mut result = [[0.0; 4]; 6];
    for c in tau.iter().rev() {
        let mut next = [[0.0; 4]; 6];
        for power in 0..6 {
            for k in 0..4 {
                let lower = if power == 0 { 0.0 } else { result[power - 1][k] };
                next[power][k] = 2.0 * lower - result[power][k];
            }
        }
        for k in 0..4 {
            next[0][k] += c[k];
        }
        result = next;
    }
    result
}

/// |dP/dt| at t, mm.
fn speed(c: &[[f64; 4]; 6], t: f64) -> f64 {
    let (mut x, mut v) = ([0.0; 4], [0.0; 4]);
    for c in c.iter().rev() {
        for k in 0..4 {
            v[k] = x[k] + t * v[k];
            x[k] = c[k] + t * x[k];
        }
    }
    let rate: Vector = core::array::from_fn(|k| (v[k] - x[k] / x[3] * v[3]) / x[3]);
    norm(rate)
}

/// Arc length by Gauss and Legendre's eight points on two halves; the integrand of a short span is smooth.
fn length(c: &[[f64; 4]; 6]) -> f64 {
    const NODES: [(f64, f64); 4] = [
        (0.183_434_642_495_649_8, 0.362_683_783_378_362),
        (0.525_532_409_916_329, 0.313_706_645_877_887_3),
        (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
        (0.960_289_856_497_536_2, 0.101_228_536_290_376_3),
    ];
    let mut sum = 0.0;
    for middle in [0.25, 0.75] {
        for (x, w) in NODES {
            sum += 0.25 * w * (speed(c, middle - 0.25 * x) + speed(c, middle + 0.25 * x));
        }
    }
    sum
}
