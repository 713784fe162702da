//! Out of line: descend, bracket, refine; across borders and corners, within a window.

use super::Flags;
use super::kernel::{Evaluation, evaluate};
use super::span::{Path, Reference, Span};
use crate::position::Position;
use crate::real::Real;

/// A foot as the search found it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found<R> {
    pub(super) place: Reference<R>,
    /// From the point to the foot, mm.
    pub(super) vector: [R; 3],
    /// Derivative of the path, mm.
    pub(super) tangent: [R; 3],
    /// What is left of the bracket, mm of arc length.
    pub(super) width: R,
    pub(super) flags: Flags,
    /// The evaluations ran out on the way down to a minimum: the place is good to go on from.
    pub(super) downhill: bool,
}

#[inline(always)]
pub(super) fn dot<R: Real>(a: &[R; 3], b: &[R; 3]) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A place counted from the start of the search: pieces forward, parameter in the piece.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Spot<R> {
    piece: i32,
    number: u32,
    t: R,
}

impl<R: Real> Spot<R> {
    fn before(&self, other: &Self) -> bool {
        self.piece < other.piece || (self.piece == other.piece && self.t < other.t)
    }
}

/// Pieces that a search looks at on either side of its start.
const PIECES: i32 = 4;

/// A Newton step shorter than this leaves, after its quadratic convergence, nothing but rounding: mm.
#[inline(always)]
fn short_step<R: Real>() -> R {
    if R::EPSILON.to_f64() < 1e-10 { R::of(1e-7) } else { R::of(2e-5) }
}

/// Descends from `start` to the minimum that lies downhill, within `window` mm of arc length on either side.
///
/// Newton steps inside the bracket, guarded by bisection; plain bisection if `bisect`. Every step is one evaluation,
/// at most `budget`; `spent` counts them. Without a change from − to + the last sample is the answer, and the flag
/// *bracketed* is missing.
#[inline(never)]
pub(super) fn descend<R: Real, P: Position>(
    path: &Path<'_, R, P>,
    start: Reference<R>,
    point: &[P; 3],
    window: R,
    bisect: bool,
    budget: u8,
    spent: &mut u8,
) -> Option<Found<R>> {
    let start = path.moving(start);
    let mut at = Spot { piece: 0, number: start.span, t: start.t.within(R::ZERO, R::ONE) };
    let (mut low, mut high) = (None::<Spot<R>>, None::<Spot<R>>);
    let mut flags = Flags::default();
    let mut walked = R::ZERO;
    for round in 0..budget {
        let span = path.span(at.number)?;
        let e = evaluate(span, &span.relative(point), at.t);
        *spent = spent.saturating_add(1);
        let speed = e.straight.sqrt();
        if e.g == R::ZERO && e.slope >= R::ZERO {
            return Some(found(at, &e, R::ZERO, flags.and(Flags::BRACKETED)));
        }
        if round == 0 && e.slope <= R::ZERO {
            flags = flags.and(Flags::SECOND_MINIMUM);
        }
        let forward = e.g < R::ZERO;
        if forward {
            low = Some(at)
        } else {
            high = Some(at)
        }

        // Two samples on either side of the same border, or an end with the minimum beyond it.
        if let (Some(l), Some(h)) = (low, high)
            && h.piece == l.piece + 1
            && l.t == R::ONE
            && h.t == R::ZERO
        {
            return Some(found(at, &e, R::ZERO, flags.and(Flags::BRACKETED).and(Flags::AT_CORNER)));
        }
        let beyond = if forward { path.next(at.number) } else { path.previous(at.number) };
        let border = if forward { R::ONE } else { R::ZERO };
        let open = if forward { high.is_none() } else { low.is_none() };
        if open && at.t == border && beyond.is_none() {
            return Some(found(at, &e, R::ZERO, flags.and(Flags::BRACKETED).and(Flags::AT_END)));
        }

        let convex = e.slope > R::of(0.25) * e.straight;
        let step = -(e.g / if convex { e.slope } else { e.straight }.max(R::of(1e-30)));
        let newton = at.t + step;
        let inside = newton >= R::ZERO && newton <= R::ONE;
        let bounded = low.is_none_or(|l| l.piece < at.piece || l.t <= newton)
            && high.is_none_or(|h| h.piece > at.piece || newton <= h.t);
        if !bisect && convex && inside && bounded && step.abs() * speed < short_step() {
            // The series about this place finishes it.
            let mut done = found(at, &e, R::ZERO, flags.and(Flags::BRACKETED));
            done.place.t = newton;
            for k in 0..3 {
                done.vector[k] = e.vector[k] + step * (e.tangent[k] + step * e.bend[k]);
                done.tangent[k] = e.tangent[k] + R::TWO * (step * e.bend[k]);
            }
            return Some(done);
        }

        if round + 1 == budget {
            let (width, flags) = match (low, high) {
                (Some(l), Some(h)) => (bracket_width(path, &l, &h), flags.and(Flags::BRACKETED)),
                _ => (window, flags),
            };
            return Some(Found { downhill: convex, ..found(at, &e, width, flags) });
        }
        at = match (low, high) {
            (Some(l), Some(h)) => {
                let width = bracket_width(path, &l, &h);
                if width <= resolution::<R>() {
                    return Some(found(at, &e, width, flags.and(Flags::BRACKETED)));
                }
                if l.piece == h.piece {
                    let middle = R::HALF * (l.t + h.t);
                    if !(l.t < middle && middle < h.t) {
                        return Some(found(at, &e, width, flags.and(Flags::BRACKETED)));
                    }
                    let strictly = l.t < newton && newton < h.t;
                    Spot { t: if !bisect && strictly && at.piece == l.piece { newton } else { middle }, ..l }
                } else if !bisect && inside && bounded && newton != at.t && newton > R::ZERO && newton < R::ONE {
                    Spot { t: newton, ..at }
                } else if l.t < R::ONE {
                    // The border itself, seen from the lower side, then from the upper.
                    Spot { t: R::ONE, ..l }
                } else {
                    let number = path.next(l.number)?;
                    Spot { piece: l.piece + 1, number, t: R::ZERO }
                }
            }
            _ => {
                // Still downhill: Newton's step, but not over a border, and not out of the window.
                let room = window - walked;
                let reach = room / speed.max(R::of(1e-12));
                let far = if bisect {
                    (R::of(0.25) * window / speed.max(R::of(1e-12))).min(reach)
                } else {
                    step.abs().min(reach)
                };
                let target = if forward { at.t + far } else { at.t - far };
                let crosses = !(target > R::ZERO && target < R::ONE);
                if crosses && at.t == border {
                    // At the border already: on in the piece beyond it.
                    match beyond {
                        Some(number) if at.piece.abs() < PIECES => {
                            let piece = if forward { at.piece + 1 } else { at.piece - 1 };
                            Spot { piece, number, t: R::ONE - border }
                        }
                        _ => return Some(found(at, &e, window, flags)),
                    }
                } else if crosses {
                    walked += (border - at.t).abs() * speed;
                    match beyond {
                        // A tangent that goes on smoothly needs no look at both sides of the border.
                        Some(number) if at.piece.abs() < PIECES && !bisect => {
                            let piece = if forward { at.piece + 1 } else { at.piece - 1 };
                            Spot { piece, number, t: R::ONE - border }
                        }
                        _ => Spot { t: border, ..at },
                    }
                } else {
                    walked += far * speed;
                    if walked >= window * R::of(0.999) && far < step.abs() && round > 0 && room <= R::ZERO {
                        return Some(found(at, &e, window, flags));
                    }
                    if far == R::ZERO || target == at.t {
                        return Some(found(at, &e, window, flags));
                    }
                    Spot { t: target, ..at }
                }
            }
        };
    }
    None
}

/// A bracket narrower than this is a point, mm.
#[inline(always)]
fn resolution<R: Real>() -> R {
    if R::EPSILON.to_f64() < 1e-10 { R::of(1e-12) } else { R::of(1e-6) }
}

fn bracket_width<R: Real, P: Position>(path: &Path<'_, R, P>, low: &Spot<R>, high: &Spot<R>) -> R {
    if !low.before(high) {
        return R::ZERO;
    }
    let at = |spot: &Spot<R>| path.span(spot.number).map_or((R::ZERO, R::ZERO), |s| (s.arc_length(spot.t), s.length()));
    let ((from, whole), (to, _)) = (at(low), at(high));
    if low.piece == high.piece { to - from } else { whole - from + to }
}

fn found<R: Real>(spot: Spot<R>, e: &Evaluation<R>, width: R, flags: Flags) -> Found<R> {
    let place = Reference { span: spot.number, t: spot.t };
    Found { place, vector: e.vector, tangent: e.tangent, width, flags, downhill: false }
}

/// Evaluates a span at `t` as a foot.
pub(super) fn at<R: Real, P: Position>(span: &Span<R, P>, number: u32, point: &[P; 3], t: R) -> Found<R> {
    let e = evaluate(span, &span.relative(point), t);
    found(Spot { piece: 0, number, t }, &e, R::ZERO, Flags::default())
}
