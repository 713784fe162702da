//! Converts lines, arcs, helices and splines to spans: once, outside the step, in double precision.

mod arc;
mod spline;

use super::span::{Form, Span};
use crate::part::{Part, text};
use crate::position::Position;
use crate::real::Real;
use core::fmt;
use glam::DVec3;

/// A segment of a programmed path, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Segment<'a> {
    /// Straight line; u = 0..1 proportional to length.
    Line {
        /// Start.
        start: DVec3,
        /// End.
        end: DVec3,
    },
    /// Circular arc about `normal` (right hand), a helix if start and end differ along it; u = 0..1 proportional to the angle.
    /// Start and end at the same angle make a full circle.
    Arc {
        /// Start.
        start: DVec3,
        /// End.
        end: DVec3,
        /// A point on the axis.
        center: DVec3,
        /// Direction of the axis, any length.
        normal: DVec3,
        /// Full turns beyond the first arc.
        turns: u32,
    },
    /// Turn of the tool's direction while the tip stays in place; u = 0..1.
    Turning {
        /// Position of the tip.
        point: DVec3,
    },
    /// Spline with u over `knots[degree] ..= knots[points.len()]`.
    Nurbs {
        /// Degree, 1 to 5.
        degree: usize,
        /// `points.len() + degree + 1` knots, ascending.
        knots: &'a [f64],
        /// Control points.
        points: &'a [DVec3],
        /// As many weights, 1e-9 to 1e9, within a factor of 1e6 of one another; empty for weights of one.
        weights: &'a [f64],
    },
}

/// Error of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(feature = "bench"), non_exhaustive)]
pub struct PathError {
    /// Part of the segment with the error.
    pub field: &'static str,
    /// Element of the part, if that is a list.
    pub index: Option<usize>,
    /// Value found.
    pub found: f64,
    /// Value or form needed.
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
    Err(PathError { field, index, found, needed: text(needed) })
}

/// Largest distance of a span from its origin, mm.
pub(super) const REACH: f64 = 8.0;
/// Largest angle by which a span's tangent turns, rad (30°, minus a margin for rounding).
const TURN: f64 = 0.523;
/// Points closer than this coincide, mm.
const SAME_POINT: f64 = 1e-9;
/// Most spans per segment.
const MOST: u32 = 1_000_000;
const TOO_MANY: &str = "a segment of at most 1000000 spans, each within 8 mm of its middle";

fn finite(field: &'static str, point: DVec3) -> Result<(), PathError> {
    match point.to_array().into_iter().find(|x| !x.is_usable()) {
        Some(x) => refuse(field, None, x, "finite coordinates below 1e9 mm"),
        None => Ok(()),
    }
}

/// Converts a segment into spans and hands them to `sink` in path order.
///
/// `number` is the segment's number, `plane` the normal of the machining plane (G17 to G19) for the signed components. Lines,
/// circles and splines are exact; the axial coordinate of a helix is within 1e-10 mm, a spiral within 8e-6 of the change of
/// its radius, 1.7e-7 mm.
///
/// # Errors
/// The segment is not a valid path, or `sink` refuses a span.
pub fn convert<R: Real, P: Position>(
    segment: &Segment<'_>,
    number: u32,
    plane: impl Into<DVec3>,
    mut sink: impl FnMut(Span<R, P>) -> Result<(), PathError>,
) -> Result<(), PathError> {
    let plane = plane.into();
    finite("plane", plane)?;
    let length = plane.length();
    if length < 1e-6 {
        return refuse("plane", None, length, "a direction");
    }
    let plane = plane.to_array().map(|x| R::of(x / length));
    let position = core::marker::PhantomData;
    Maker { number, count: 0, counting: false, plane, sink: &mut sink, position }.segment(segment)
}

/// Upper bound on the spans that [`convert`] makes of a segment, known before the conversion so that memory can be provided or
/// refused.
///
/// For lines and arcs the cost does not grow with the number; splines are split without forming the spans.
///
/// # Errors
/// The segment is not a valid path, or needs more than 1,000,000 spans.
pub fn span_count(segment: &Segment<'_>) -> Result<u32, PathError> {
    let mut none = |_: Span<f64, f64>| Ok(());
    let position = core::marker::PhantomData;
    let mut maker = Maker { number: 0, count: 0, counting: true, plane: [0.0; 3], sink: &mut none, position };
    maker.segment(segment)?;
    Ok(maker.count)
}

struct Maker<'s, R, P, S> {
    number: u32,
    /// Number of spans made, or counted, so far.
    count: u32,
    /// Whether spans are counted instead of made.
    counting: bool,
    plane: [R; 3],
    sink: &'s mut S,
    position: core::marker::PhantomData<P>,
}

/// A homogeneous polynomial about an exact origin, coefficients of t^0 to t^5.
struct Piece {
    origin: DVec3,
    coefficients: [[f64; 4]; 6],
    form: Form,
    u: [f64; 2],
    quarter_tangent: f64,
}

impl<R: Real, P: Position, S: FnMut(Span<R, P>) -> Result<(), PathError>> Maker<'_, R, P, S> {
    fn segment(&mut self, segment: &Segment<'_>) -> Result<(), PathError> {
        match *segment {
            Segment::Line { start, end } => self.line(start, end),
            Segment::Arc { .. } | Segment::Nurbs { .. } if !Part::Curves.is_built() => {
                refuse("segment", None, 0.0, "a line: this build leaves the part curves out")
            }
            Segment::Arc { start, end, center, normal, turns } => self.arc(start, end, center, normal, turns),
            Segment::Turning { point } => {
                finite("point", point)?;
                if self.counting {
                    return self.counted(1);
                }
                let span = Span::turning(point.to_array().map(P::of), self.number, self.plane);
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
        // The origin is rounded to a representable position; the polynomial absorbs the rounding error.
        let origin = piece.origin.to_array().map(P::of);
        let left: [f64; 3] = core::array::from_fn(|k| piece.origin[k] - origin[k].to_f64());
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
        // a t + b t² + c t³ from the speeds at both ends and the total length.
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

    fn line(&mut self, start: DVec3, end: DVec3) -> Result<(), PathError> {
        finite("start", start)?;
        finite("end", end)?;
        let way = end - start;
        let length = way.length();
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
            let half = way * (0.5 / count);
            let mut coefficients = [[0.0; 4]; 6];
            coefficients[0] = [-half[0], -half[1], -half[2], 1.0];
            coefficients[1] = [2.0 * half[0], 2.0 * half[1], 2.0 * half[2], 0.0];
            let origin = start + way * (0.5 * (u[0] + u[1]));
            self.emit(Piece { origin, coefficients, form: Form::Cubic, u, quarter_tangent: 0.0 })?;
        }
        Ok(())
    }
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
    DVec3::from_array(core::array::from_fn(|k| (v[k] - x[k] / x[3] * v[3]) / x[3])).length()
}

/// Arc length by eight-point Gauss-Legendre quadrature on two halves; the integrand of a short span is smooth.
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
