//! A path in the form that the step searches.

use crate::part::Part;
use crate::position::Position;
use crate::real::Real;
use crate::vector::V3;
use serde::{Deserialize, Serialize};

/// Terms that a span's polynomial has, so that the kernel computes no others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Form {
    /// Degree up to 3, weight 1.
    Cubic,
    /// Degree up to 3 with weights (circular arcs, rational cubics).
    #[cfg_attr(not(feature = "curves"), serde(skip_deserializing))]
    RationalCubic,
    /// Degree up to 5, weight 1.
    #[cfg_attr(not(feature = "curves"), serde(skip_deserializing))]
    Quintic,
    /// Degree up to 5 with weights (helices, rational splines).
    #[cfg_attr(not(feature = "curves"), serde(skip_deserializing))]
    RationalQuintic,
}

/// A short polynomial part of a line, arc, helix or spline.
///
/// Each span has its own parameter t = 0..1 and its own origin; homogeneous, in power basis:
///
/// ```text
/// P(t) = origin + (Σ c_k t^k)_xyz / (Σ c_k t^k)_w
/// ```
///
/// In mm. Every span lies within 8 mm of its origin and its tangent turns by less than 30°: single precision then keeps about
/// a nanometre, and the foot-point kernel's series converges.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Span<R, P> {
    pub(super) origin: [P; 3],
    pub(super) coefficients: [[R; 4]; 6],
    /// Arc length from the start: `a t + b t² + c t³`, exact in the speeds at both ends and in the length.
    pub(super) arc: [R; 3],
    /// Normal of the machining plane.
    pub(super) plane: [R; 3],
    pub(super) form: Form,
    pub(super) segment: u32,
    pub(super) u: [f64; 2],
    /// tan of a quarter of the span's angle if u is proportional to an angle, 0 if t is linear in u.
    pub(super) quarter_tangent: f64,
}

impl Span<f64, f64> {
    /// Converts the span to the scalar and positions of a step: a host plans in doubles and hands the result to the servo's
    /// core.
    ///
    /// Equal bit for bit to the span that the conversion of the segment makes for them: the origin is rounded to a
    /// representable position, and the polynomial absorbs the rounding error.
    pub fn rounded<R: Real, P: Position>(&self) -> Span<R, P> {
        let origin = self.origin.map(P::of);
        let mut coefficients = self.coefficients;
        for c in &mut coefficients {
            for k in 0..3 {
                c[k] += (self.origin[k] - origin[k].to_f64()) * c[3];
            }
        }
        Span {
            origin,
            coefficients: coefficients.map(|c| c.map(R::of)),
            arc: self.arc.map(R::of),
            plane: self.plane.map(R::of),
            form: self.form,
            segment: self.segment,
            u: self.u,
            quarter_tangent: self.quarter_tangent,
        }
    }
}

impl<R: Real, P: Position> Span<R, P> {
    /// Form of the polynomial; a build without curves has only lines.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(super) fn form(&self) -> Form {
        if Part::Curves.is_built() { self.form } else { Form::Cubic }
    }

    /// A span without length: the tip stays at `point` (mm) while the tool's direction turns.
    ///
    /// In a [`super::ToolPath`] the search of the tip skips it and continues on the spans on either side; the [`super::Turn`]
    /// with the same number describes the turn. In a plain [`Path`] it is an ordinary point and can be the foot. `number` is
    /// the segment's number, `plane` the unit normal of the machining plane; u = 0..1.
    #[doc(hidden)]
    pub fn turning(point: [P; 3], number: u32, plane: [R; 3]) -> Self {
        let mut coefficients = [[R::ZERO; 4]; 6];
        coefficients[0][3] = R::ONE;
        Span {
            origin: point,
            coefficients,
            arc: [R::ZERO; 3],
            plane,
            form: Form::Cubic,
            segment: number,
            u: [0.0, 1.0],
            quarter_tangent: 0.0,
        }
    }

    /// A cubic from a point over a distance vector, with the derivatives at both ends (all mm); other parameters as in
    /// [`Span::turning`].
    ///
    /// Real-time: some sixty multiplications and three roots. The arc length is by Simpson's rule, to 1e-6 of its value at 20°
    /// of turn.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(super) fn hermite(from: &[P; 3], way: V3<R>, start: V3<R>, end: V3<R>, number: u32, plane: [R; 3]) -> Self {
        let [x, y, z] = from;
        let half = way * R::HALF;
        let origin = [x.plus(half.x), y.plus(half.y), z.plus(half.z)];
        let [ox, oy, oz] = origin;
        // The polynomial absorbs the rounding error of the origin.
        let first = V3::new(x.since_near(ox), y.since_near(oy), z.since_near(oz));
        let square = way * R::THREE - start * R::TWO - end;
        let cube = start + end - way * R::TWO;
        let term = |v: V3<R>, w: R| [v.x, v.y, v.z, w];
        let none = [R::ZERO; 4];
        let coefficients =
            [term(first, R::ONE), term(start, R::ZERO), term(square, R::ZERO), term(cube, R::ZERO), none, none];
        let middle = way * R::of(1.5) - (start + end) * R::of(0.25);
        let (from, to) = (start.norm(), end.norm());
        let length = (from + R::of(4.0) * middle.norm() + to) * R::of(1.0 / 6.0);
        let arc = [from, R::THREE * length - R::TWO * from - to, from + to - R::TWO * length];
        Span {
            origin,
            coefficients,
            arc,
            plane,
            form: Form::Cubic,
            segment: number,
            u: [0.0, 1.0],
            quarter_tangent: 0.0,
        }
    }

    /// Whether the tip stays in place on this span ([`Span::turning`]).
    #[cfg_attr(feature = "fast", inline(always))]
    pub fn is_stationary(&self) -> bool {
        // Every other span has a speed at its start; a cusp's cubic at least contains the whole length.
        let [a, b, c] = self.arc;
        a == R::ZERO && b == R::ZERO && c == R::ZERO
    }

    /// Number of the segment to which the span belongs.
    pub fn segment(&self) -> u32 {
        self.segment
    }

    /// The segment's parameter at both ends of the span.
    pub fn u_range(&self) -> [f64; 2] {
        self.u
    }

    /// Arc length, mm.
    pub fn length(&self) -> R {
        let [a, b, c] = self.arc;
        a + b + c
    }

    /// Arc length from the start of the span to `t`, mm.
    ///
    /// Cubic in t: exact at both ends, elsewhere to 1e-4 of the span's length on lines and circles, to some 1e-3 on splines.
    #[cfg_attr(feature = "fast", inline(always))]
    pub fn arc_length(&self, t: R) -> R {
        let [a, b, c] = self.arc;
        t * (a + t * (b + t * c))
    }

    /// d(arc length)/dt at `t`, mm, at least a tenth of the mean.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(super) fn arc_speed(&self, t: R) -> R {
        let [a, b, c] = self.arc;
        (a + t * (R::TWO * b + R::THREE * t * c)).max(R::of(0.1) * self.length())
    }

    /// Parameter at an arc length from the start: the inverse of [`Span::arc_length`], clamped at both ends. Takes forty
    /// halvings: not for a servo cycle.
    pub fn t_at(&self, arc_length: R) -> R {
        let (mut low, mut high) = (R::ZERO, R::ONE);
        for _ in 0..40 {
            let middle = R::HALF * (low + high);
            if self.arc_length(middle) < arc_length { low = middle } else { high = middle }
        }
        if arc_length >= self.length() { R::ONE } else { low }
    }

    /// Span parameter at the segment's parameter `u`, to 1e-13 of the range, without libm.
    ///
    /// On arcs u is proportional to the angle θ = 2 atan(k(2t − 1)), |θ| < 15°, so t = (1 + tan(θ/2)/k)/2, with the tangent's
    /// series to the 13th power.
    pub fn t_of(&self, u: f64) -> R {
        let [u0, u1] = self.u;
        let linear = Real::limit((u - u0) / (u1 - u0), 0.0, 1.0);
        let k = self.quarter_tangent;
        if k == 0.0 {
            return R::of(linear);
        }
        let tangent = tan((2.0 * linear - 1.0) * atan(k));
        R::of(Real::limit(0.5 + 0.5 * tangent / k, 0.0, 1.0))
    }

    /// The segment's parameter at span parameter `t`: the inverse of [`Span::t_of`].
    pub fn u_of(&self, t: R) -> f64 {
        let [u0, u1] = self.u;
        let t = t.to_f64();
        let k = self.quarter_tangent;
        let linear = if k == 0.0 { t } else { 0.5 + 0.5 * atan(k * (2.0 * t - 1.0)) / atan(k) };
        u0 + (u1 - u0) * linear
    }

    /// Point at `t`, relative to the origin, mm.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(super) fn local(&self, t: R) -> [R; 3] {
        let [x, y, z, w] = self.coefficients.iter().rev().fold([R::ZERO; 4], |sum, c| mad(c, t, &sum));
        let i = R::ONE / w;
        [x * i, y * i, z * i]
    }

    /// Start of a cubic, relative to the origin, and the vector from there to its end, mm.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(super) fn chord(&self) -> ([R; 4], V3<R>) {
        let [start, [x1, y1, z1, _], [x2, y2, z2, _], [x3, y3, z3, _], ..] = self.coefficients;
        (start, V3::new(x1 + x2 + x3, y1 + y2 + y3, z1 + z2 + z3))
    }

    /// Point at `t`, mm.
    pub fn position(&self, t: R) -> [P; 3] {
        let [x, y, z] = self.local(t);
        let [ox, oy, oz] = self.origin;
        [ox.plus(x), oy.plus(y), oz.plus(z)]
    }

    /// Point relative to the origin, for points within a few millimetres of the span.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(super) fn relative(&self, point: &[P; 3]) -> [R; 3] {
        let ([x, y, z], [ox, oy, oz]) = (point, &self.origin);
        [x.since_near(*ox), y.since_near(*oy), z.since_near(*oz)]
    }
}

/// Most consecutive spans without length that the search of the tip skips; one alone may turn by any angle.
const TURNS_IN_A_ROW: u32 = 8;

/// a·b.
#[cfg_attr(feature = "fast", inline(always))]
pub(super) fn dot<R: Real>(a: &[R; 3], b: &[R; 3]) -> R {
    (a[0] * b[0]).add_product(a[1], b[1]).add_product(a[2], b[2])
}

/// `a + t b`.
#[cfg_attr(feature = "fast", inline(always))]
pub(super) fn mad<R: Real>(a: &[R; 4], t: R, b: &[R; 4]) -> [R; 4] {
    [a[0].add_product(t, b[0]), a[1].add_product(t, b[1]), a[2].add_product(t, b[2]), a[3].add_product(t, b[3])]
}

/// |x| < 0.14: the next term is below 1e-14 of x.
pub(super) fn atan(x: f64) -> f64 {
    let z = -x * x;
    x * (1.0 + z * (1.0 / 3.0 + z * (1.0 / 5.0 + z * (1.0 / 7.0 + z * (1.0 / 9.0 + z * (1.0 / 11.0 + z / 13.0))))))
}

/// |x| < 0.14: series to the 13th power.
fn tan(x: f64) -> f64 {
    const C: [f64; 7] =
        [1.0, 1.0 / 3.0, 2.0 / 15.0, 17.0 / 315.0, 62.0 / 2835.0, 1382.0 / 155_925.0, 21844.0 / 6_081_075.0];
    let z = x * x;
    x * C.iter().rev().fold(0.0, |sum, c| sum * z + c)
}

/// The interpolator's path: spans in path order, each beginning where the previous one ends.
///
/// A host with a long program slides a window over it: `first` is the sequence number of the window's first span.
#[derive(Clone, Copy, Debug)]
pub struct Path<'a, R, P> {
    pub(super) spans: &'a [Span<R, P>],
    pub(super) first: u32,
    pub(super) closed: bool,
    /// Whether spans without length may have to be skipped; false for a path of the tip alone, to save the test.
    pub(super) turning: bool,
}

impl<'a, R: Real, P: Position> Path<'a, R, P> {
    /// A window of spans; `closed` if the last span ends at the first one's start.
    pub fn new(spans: &'a [Span<R, P>], first: u32, closed: bool) -> Self {
        Path { spans, first, closed, turning: false }
    }

    /// Point at parameter `u` of a segment, for the step: 0 to 1 on lines and arcs, the knots' domain on splines; outside, the
    /// nearer end.
    ///
    /// If the window does not contain the segment, or `u` is not a number, the point does not exist: the step measures
    /// no contour error and flags that.
    ///
    /// Cost: a binary search, some ten instructions for each doubling of the spans.
    pub fn at(&self, segment: u32, u: f64) -> OnPath<'a, R, P> {
        let before = self.spans.partition_point(|span| (span.segment, span.u[0]) <= (segment, u));
        let held = |index: usize| {
            let span = self.spans.get(index).filter(|span| span.segment == segment && !u.is_nan())?;
            Some(Reference { span: self.first.wrapping_add(index as u32), t: span.t_of(u) })
        };
        // Below the segment's first parameter the search ends on the span before: use the next one.
        let reference = held(before.saturating_sub(1))
            .or_else(|| held(before))
            .unwrap_or(Reference { span: self.first, t: R::of(f64::NAN) });
        self.on(reference)
    }

    /// Point given by span and parameter, for the step.
    #[cfg_attr(feature = "fast", inline(always))]
    pub fn on(&self, reference: Reference<R>) -> OnPath<'a, R, P> {
        OnPath { path: *self, reference }
    }

    /// The span with a sequence number.
    #[cfg_attr(feature = "fast", inline(always))]
    pub fn span(&self, number: u32) -> Option<&'a Span<R, P>> {
        #[cfg(test)]
        super::tests::LOOKED_AT.with(|count| count.set(count.get() + 1));
        self.spans.get(number.wrapping_sub(self.first) as usize)
    }

    /// Number of the next span after `number` on which the tip moves, if any.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(super) fn next(&self, number: u32) -> Option<u32> {
        let next = self.following(number)?;
        if self.turning { self.pass(next, Self::following) } else { Some(next) }
    }

    /// Number of the last span before `number` on which the tip moves, if any.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(super) fn previous(&self, number: u32) -> Option<u32> {
        let previous = self.preceding(number)?;
        if self.turning { self.pass(previous, Self::preceding) } else { Some(previous) }
    }

    /// Whether the tip stays in place on a span.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(super) fn is_stationary(&self, number: u32) -> bool {
        self.span(number).is_some_and(Span::is_stationary)
    }

    /// Skips spans without length, at most [`TURNS_IN_A_ROW`] of them.
    // Only with turning_spans.
    #[inline(never)]
    fn pass(&self, mut number: u32, onwards: impl Fn(&Self, u32) -> Option<u32>) -> Option<u32> {
        for _ in 0..TURNS_IN_A_ROW {
            if !self.is_stationary(number) {
                return Some(number);
            }
            number = onwards(self, number)?;
        }
        (!self.is_stationary(number)).then_some(number)
    }

    /// Equivalent of a point on a nearby span on which the tip moves, if any; otherwise the point itself.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(super) fn moving(&self, at: Reference<R>) -> Reference<R> {
        if self.turning && self.is_stationary(at.span) { self.neighbour(at) } else { at }
    }

    // Only with turning_spans.
    #[cold]
    #[inline(never)]
    fn neighbour(&self, at: Reference<R>) -> Reference<R> {
        match (self.next(at.span), self.previous(at.span)) {
            (Some(span), _) => Reference { span, t: R::ZERO },
            (None, Some(span)) => Reference { span, t: R::ONE },
            (None, None) => at,
        }
    }

    /// Number of the span after `number`, if any.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(super) fn following(&self, number: u32) -> Option<u32> {
        let next = number.wrapping_add(1);
        if (next.wrapping_sub(self.first) as usize) < self.spans.len() {
            Some(next)
        } else {
            self.closed.then_some(self.first)
        }
    }

    /// Number of the span before `number`, if any.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(super) fn preceding(&self, number: u32) -> Option<u32> {
        if number == self.first {
            let last = self.first.wrapping_add(self.spans.len() as u32).wrapping_sub(1);
            (self.closed && !self.spans.is_empty()).then_some(last)
        } else {
            Some(number.wrapping_sub(1))
        }
    }
}

/// A path and the position of this cycle's command on it.
#[derive(Clone, Copy, Debug)]
pub struct OnPath<'a, R, P> {
    /// The path.
    pub path: Path<'a, R, P>,
    /// Position on it.
    pub reference: Reference<R>,
}

impl<R: Real, P: Position> OnPath<'_, R, P> {
    /// Point of the path at the reference, mm; `None` if the path has no such position.
    pub fn position(&self) -> Option<[P; 3]> {
        let Reference { span, t } = self.reference;
        self.path.span(span).filter(|_| t.is_finite()).map(|span| span.position(t))
    }
}

/// A point of a path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reference<R> {
    /// Sequence number of the span.
    pub span: u32,
    /// Parameter in the span, 0 to 1.
    pub t: R,
}

impl<R: Real> Reference<R> {
    /// Whether the parameter is within 0 to 1 and not −0; false if it is not a number.
    #[cfg_attr(feature = "fast", inline(always))]
    pub(crate) fn is_on_its_span(&self) -> bool {
        self.t.is_in_unit()
    }
}
