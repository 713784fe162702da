//! Orientation contour error: the angle between the tool's direction and the path's direction at the foot.
//!
//! Besides the path of the tip, a five-axis path has a direction for every span: a [`Turn`]. The error is
//!
//! ```text
//! ε = atan2(|a × b|, a · b)        a: direction of the path at the foot of the tip, b: the tool's
//! ```
//!
//! An arc cosine would lose everything below a milliradian in single precision. Where the tip stays in place and only
//! the direction turns (P' = 0), the tip's foot is that point and does not show the progress of the turn; the foot is
//! then the nearest orientation of the turn.

#![deny(clippy::indexing_slicing)]

use super::span::{Path, Reference, Span, atan};
use super::way::way;
use super::{ContourError, Flags};
use crate::compensation::trig::{atan2, cos_sin_deg};
use crate::position::Position;
use crate::real::Real;
use crate::vector::V3;
use glam::DVec3;

/// Direction of the tool along a span of the path.
#[derive(Clone, Copy, Debug)]
pub struct Turn<R> {
    way: Way<R>,
    /// tan² of a quarter of the span's angle, and the weight by which its series is divided: on arcs the segment's parameter
    /// is not linear in the span's.
    bend: R,
    scale: R,
}

#[derive(Clone, Copy, Debug)]
enum Way<R> {
    /// Positions of A, B, C, degrees: `start + change · s`.
    Axes { start: [R; 3], change: [R; 3] },
    /// Unit vectors: `cos(φ s) from + sin(φ s) across`, φ in degrees.
    Circle { from: V3<R>, across: V3<R>, degrees: R },
}

impl<R: Real> Turn<R> {
    /// Rotary axes that move linearly in the segment's parameter u, as a block with rotary words specifies.
    ///
    /// `span`: the span; `domain`: u at start and end of its segment (0 and 1, or the spline's outer knots); `start` and
    /// `end`: positions of A, B, C there, degrees, any number of turns.
    pub fn axes<P: Position>(span: &Span<R, P>, domain: [f64; 2], start: [f64; 3], end: [f64; 3]) -> Self {
        let [from, to] = part(span, domain);
        let (mut first, mut change) = ([R::ZERO; 3], [R::ZERO; 3]);
        for ((first, change), (start, end)) in first.iter_mut().zip(&mut change).zip(start.into_iter().zip(end)) {
            let at = start + (end - start) * from;
            // Removes whole turns so that single precision keeps the angle.
            *first = R::of(at - 360.0 * libm::rint(at / 360.0));
            *change = R::of((end - start) * (to - from));
        }
        Turn::along(span, Way::Axes { start: first, change })
    }

    /// The great circle between two tool directions in workpiece coordinates, at a constant rate in the segment's parameter;
    /// the vectors may have any length. `None` if a vector has no direction, or the two are opposite.
    pub fn directions<P: Position>(
        span: &Span<R, P>,
        domain: [f64; 2],
        start: impl Into<DVec3>,
        end: impl Into<DVec3>,
    ) -> Option<Self> {
        let unit = |v: V3<f64>| (v.norm() > 1e-9 && v.norm().is_finite()).then(|| v * (1.0 / v.norm()));
        let (a, b) = (unit(V3::from_glam(start.into()))?, unit(V3::from_glam(end.into()))?);
        let angle = libm::atan2(a.cross(b).norm(), a.dot(b));
        if angle > core::f64::consts::PI - 1e-6 {
            return None;
        }
        let across = unit(b - a * a.dot(b)).unwrap_or(V3::ZERO);
        let [from, to] = part(span, domain);
        let (c, s) = (libm::cos(angle * from), libm::sin(angle * from));
        Some(Turn::along(
            span,
            Way::Circle {
                from: V3::of((a * c + across * s).array()),
                across: V3::of((across * c - a * s).array()),
                degrees: R::of((angle * (to - from)).to_degrees()),
            },
        ))
    }

    fn along<P: Position>(span: &Span<R, P>, way: Way<R>) -> Self {
        let k = span.quarter_tangent;
        let scale = if k == 0.0 { 1.0 } else { k / atan(k) };
        Turn { way, bend: R::of(k * k), scale: R::of(scale) }
    }

    /// Fraction of the span's angle at its parameter: ½ + ½ atan(k(2t − 1))/atan k, to 1e-9.
    #[inline(always)]
    fn fraction(&self, t: R) -> R {
        if self.bend == R::ZERO {
            return t;
        }
        let x = t + t - R::ONE;
        let z = -(self.bend * x * x);
        let series = [1.0, 1.0 / 3.0, 1.0 / 5.0, 1.0 / 7.0, 1.0 / 9.0];
        let sum = series.into_iter().rev().fold(R::ZERO, |sum, c| sum * z + R::of(c));
        R::HALF + R::HALF * x * sum * self.scale
    }

    /// Direction at the span's parameter; `of_axes` gives the direction at rotary positions, degrees.
    #[inline(always)]
    pub fn direction(&self, t: R, of_axes: impl Fn([R; 3]) -> R::Vec3) -> R::Vec3 {
        self.heading(t, of_axes).glam()
    }

    #[inline(always)]
    fn heading(&self, t: R, of_axes: impl Fn([R; 3]) -> R::Vec3) -> V3<R> {
        let s = self.fraction(t);
        match &self.way {
            Way::Axes { start: [a, b, c], change: [da, db, dc] } => {
                V3::from_glam(of_axes([*a + *da * s, *b + *db * s, *c + *dc * s]))
            }
            Way::Circle { from, across, degrees } => {
                let (cos, sin) = cos_sin_deg(*degrees * s);
                *from * cos + *across * sin
            }
        }
    }

    /// Largest change of an angle over the span, degrees.
    #[inline(always)]
    fn extent(&self) -> R {
        match &self.way {
            Way::Axes { change: [a, b, c], .. } => a.abs().max(b.abs()).max(c.abs()),
            Way::Circle { degrees, .. } => *degrees,
        }
    }
}

/// Part of the segment that the span covers, 0 to 1.
fn part<R: Real, P: Position>(span: &Span<R, P>, [low, high]: [f64; 2]) -> [f64; 2] {
    span.u_range().map(|u| if high > low { (u - low) / (high - low) } else { u })
}

/// A path of the tip and its tool directions: one [`Turn`] for every span, in the same order. In workpiece coordinates.
#[derive(Clone, Copy, Debug)]
pub struct ToolPath<'a, R, P> {
    pub(crate) path: Path<'a, R, P>,
    turns: &'a [Turn<R>],
}

impl<'a, R: Real, P: Position> ToolPath<'a, R, P> {
    /// Combines a window of spans with as many turns; a span without a turn has no orientation error.
    pub fn new(path: Path<'a, R, P>, turns: &'a [Turn<R>]) -> Self {
        ToolPath { path: Path { turning: true, ..path }, turns }
    }

    /// Path of the tip, on which searches skip spans without length.
    pub fn path(&self) -> &Path<'a, R, P> {
        &self.path
    }

    #[inline(always)]
    fn turn(&self, number: u32) -> Option<&'a Turn<R>> {
        self.turns.get(number.wrapping_sub(self.path.first) as usize)
    }

    /// Orientation error of a tool direction (unit vector, workpiece coordinates), from the tip's foot in this cycle.
    ///
    /// `of_axes`: direction at rotary positions, degrees. Spans on which the tip stays in place compete with the tip's
    /// foot for the nearest point of the path; a tilt counts as the motion of a point 100 mm up the tool. Without such
    /// spans the cost is one evaluation of `of_axes`, with them at most twenty-seven.
    #[inline(always)]
    pub fn orientation(
        &self,
        reference: Reference<R>,
        tip: &ContourError<R>,
        actual: R::Vec3,
        of_axes: impl Fn([R; 3]) -> R::Vec3 + Copy,
    ) -> OrientationError<R> {
        let actual = V3::from_glam(actual);
        let place = Reference { span: tip.span, t: tip.t };
        let Some(turn) = self.turn(place.span).filter(|_| tip.is_measured()) else { return OrientationError::none() };
        let error = OrientationError::between(turn.heading(place.t, of_axes), actual, place, 1, tip.flags);
        let adjacent = if self.path.is_stationary(reference.span) { Some(reference) } else { self.adjacent(place) };
        match adjacent {
            Some(start) => self.turning(start, place, &error, actual, of_axes),
            None => error,
        }
    }

    /// The span without length at the nearer border of a point, starting from that border.
    #[inline(always)]
    fn adjacent(&self, place: Reference<R>) -> Option<Reference<R>> {
        let (number, t) = if place.t > R::HALF {
            (self.path.following(place.span)?, R::ZERO)
        } else {
            (self.path.preceding(place.span)?, R::ONE)
        };
        self.path.is_stationary(number).then_some(Reference { span: number, t })
    }

    /// The nearest orientation on the turns from `start` on, if it is nearer than the one at the tip's foot.
    #[inline(never)]
    fn turning(
        &self,
        start: Reference<R>,
        foot: Reference<R>,
        at_foot: &OrientationError<R>,
        actual: V3<R>,
        of_axes: impl Fn([R; 3]) -> R::Vec3 + Copy,
    ) -> OrientationError<R> {
        let mut evaluations = at_foot.evaluations;
        let mut best: Option<OrientationError<R>> = None;
        let mut from = start;
        for _ in 0..SPANS {
            let Some(turn) = self.turn(from.span) else { break };
            let (t, spent) = nearest(turn, from.t.limit(R::ZERO, R::ONE), actual, of_axes);
            evaluations = evaluations.saturating_add(spent).saturating_add(1);
            // At a border seen at right angles, rounding decides on which side of it the point lies.
            let margin = R::of(MARGIN_DEG) / turn.extent().max(R::of(MARGIN_DEG));
            let inside = t > margin && t < R::ONE - margin;
            let flags = if inside { Flags::BRACKETED } else { Flags::AT_CORNER };
            let here = Reference { span: from.span, t };
            let error = OrientationError::between(turn.heading(t, of_axes), actual, here, 0, flags);
            if best.is_none_or(|best| error.angle < best.angle) {
                best = Some(error);
            }
            let beyond = if inside {
                None
            } else if t > R::HALF {
                self.path.following(from.span).map(|span| Reference { span, t: R::ZERO })
            } else {
                self.path.preceding(from.span).map(|span| Reference { span, t: R::ONE })
            };
            match beyond.filter(|b| self.path.is_stationary(b.span)) {
                Some(beyond) => from = beyond,
                None => break,
            }
        }
        let Some(best) = best else { return *at_foot };
        // On a path of turns alone, the tip's foot is already on one of them.
        let lever = R::of(LEVER_MM);
        let cold = at_foot.flags.has(Flags::COLD);
        let flags = if cold { best.flags.and(Flags::COLD) } else { best.flags };
        let turned = OrientationError { evaluations, flags, ..best };
        if self.path.is_stationary(foot.span) {
            return turned;
        }
        let there = Reference { span: best.span, t: best.t };
        let apart = way(&self.path, foot, there).map_or(R::of(2.0 * BEYOND_MM), R::abs);
        let (tilt, remains) = (lever * at_foot.angle, lever * best.angle);
        if apart * apart + remains * remains < tilt * tilt {
            turned
        } else {
            OrientationError { evaluations, ..*at_foot }
        }
    }
}

/// Most spans without length that a cycle searches.
const SPANS: usize = 2;
/// Most steps towards the nearest orientation on each.
const STEPS: u8 = 4;
/// Distance from the tip at which a tilt is compared with a motion of the tip, mm.
const LEVER_MM: f64 = 100.0;
/// Arc length beyond which two points count as far apart, mm.
const BEYOND_MM: f64 = 1e3;
/// Half the chord that replaces the tangent, degrees: its relative error is 1e-5, which enters the angle at the foot squared.
const CHORD_DEG: f64 = 0.5;
/// A foot this close to the end of a turn may lie on the next one, degrees.
const MARGIN_DEG: f64 = 0.1;
/// A step shorter than this does not change the angle noticeably, degrees.
const DONE_DEG: f64 = 1e-5;
/// Longest step, degrees.
const STEP_DEG: f64 = 30.0;

/// Parameter of the orientation nearest to `actual`, and the evaluations used.
///
/// Takes Gauss-Newton steps on |a − b|², with the chord about the point as its tangent, limited to the span and to 30°. Every
/// step goes downhill, and the error shrinks by about ε + (30°)²/8 per step at worst.
#[inline(always)]
fn nearest<R: Real>(turn: &Turn<R>, start: R, actual: V3<R>, of_axes: impl Fn([R; 3]) -> R::Vec3 + Copy) -> (R, u8) {
    let extent = turn.extent();
    if extent <= R::of(1e-9) || !extent.is_finite() {
        return (start, 0);
    }
    let per_degree = R::ONE / extent;
    let (half, longest) = (R::of(CHORD_DEG) * per_degree, R::of(STEP_DEG) * per_degree);
    let small = R::of(DONE_DEG) * per_degree;
    let mut t = start;
    let mut spent = 0;
    for _ in 0..STEPS {
        let (ahead, behind) = (turn.heading(t + half, of_axes), turn.heading(t - half, of_axes));
        let left = actual - turn.heading(t, of_axes);
        spent += 3;
        let chord = ahead - behind;
        let square = chord.dot(chord);
        // The direction hardly changes: the tool turns about its own axis.
        if square <= R::of(1e-12) || !square.is_finite() {
            break;
        }
        let step = ((half + half) * left.dot(chord) / square).limit(-longest, longest);
        let next = (t + step).limit(R::ZERO, R::ONE);
        let moved = (next - t).abs();
        t = next;
        if moved <= small {
            break;
        }
    }
    (t, spent)
}

/// Orientation contour error of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct OrientationError<R: Real> {
    /// Angle between the tool and the path's direction at the foot, rad, 0 to π.
    pub angle: R,
    /// Path × tool, in workpiece coordinates: for small errors the rotation (rad) from the path's direction to the tool's,
    /// actual − ideal; its length is the sine of the angle.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub vector: R::Vec3,
    /// Span on which the foot lies.
    pub span: u32,
    /// Parameter of the foot on the span.
    pub t: R,
    /// Evaluations of the path's direction used.
    pub evaluations: u8,
    /// Flags of the tip's foot; on a turn *bracketed* within it, *at corner* at its ends.
    pub flags: Flags,
}

impl<R: Real> OrientationError<R> {
    /// No error measured.
    pub fn none() -> Self {
        OrientationError {
            angle: R::ZERO,
            vector: V3::<R>::ZERO.glam(),
            span: 0,
            t: R::ZERO,
            evaluations: 0,
            flags: Flags::NOT_FOUND,
        }
    }

    /// Whether an error was measured.
    pub fn is_measured(&self) -> bool {
        !self.flags.has(Flags::NOT_FOUND)
    }

    #[inline(always)]
    fn between(path: V3<R>, tool: V3<R>, at: Reference<R>, evaluations: u8, flags: Flags) -> Self {
        let vector = path.cross(tool);
        let angle = atan2(vector.norm(), path.dot(tool));
        OrientationError { angle, vector: vector.glam(), span: at.span, t: at.t, evaluations, flags }
    }
}

#[cfg(test)]
mod tests;
