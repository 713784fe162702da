//! Out-of-line search: descends, brackets, refines; across borders and corners, within a window.

use super::Flags;
use super::kernel::{Evaluation, Foot, evaluate, evaluated};
pub(super) use super::span::dot;
use super::span::{Path, Reference, Span};
use crate::position::Position;
use crate::real::Real;

/// A foot and how the search found it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found<R> {
    pub(super) place: Reference<R>,
    /// From the point to the foot, mm.
    pub(super) vector: [R; 3],
    /// Derivative of the path, mm.
    pub(super) tangent: [R; 3],
    /// Remaining width of the bracket, mm of arc length.
    pub(super) width: R,
    pub(super) flags: Flags,
    /// The evaluations ran out while descending to a minimum: the next cycle can continue from this point.
    pub(super) downhill: bool,
}

impl<R: Real> Found<R> {
    /// The kernel's foot on a span, as a minimum.
    #[inline(always)]
    pub(super) fn of(span: u32, foot: &Foot<R>) -> Self {
        Found {
            place: Reference { span, t: foot.t },
            vector: foot.vector,
            tangent: foot.tangent,
            width: R::ZERO,
            flags: Flags::BRACKETED,
            downhill: false,
        }
    }
}

/// A point of the path relative to the start of the search: number of spans ahead, parameter in the span.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Spot<R> {
    span: i32,
    number: u32,
    t: R,
}

impl<R: Real> Spot<R> {
    fn before(&self, other: &Self) -> bool {
        self.span < other.span || (self.span == other.span && self.t < other.t)
    }
}

/// Most spans that a search covers on either side of its start.
const SPANS: i32 = 4;

/// A Newton step shorter than this converges quadratically to within rounding, mm.
#[inline(always)]
fn short_step<R: Real>() -> R {
    if R::EPSILON.to_f64() < 1e-10 { R::of(1e-7) } else { R::of(2e-5) }
}

/// Descends from `start` to the minimum downhill, within `window` mm of arc length on either side.
///
/// Takes Newton steps inside the bracket, guarded by bisection, or plain bisection if `bisect`. Each step takes one
/// evaluation, at most `budget` in all; `spent` counts them. Without a change from − to +, the result is the last
/// sample, without the flag *bracketed*.
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
    let at = Spot { span: 0, number: start.span, t: start.t.limit(R::ZERO, R::ONE) };
    let mut descent =
        Descent { path, window, bisect, at, low: None, high: None, flags: Flags::default(), walked: R::ZERO };
    // At most 2 rounds without bisection, else 60.
    for round in 0..budget {
        let span = path.span(descent.at.number)?;
        let e = evaluated(span, &span.relative(point), descent.at.t);
        *spent = spent.saturating_add(1);
        let speed = e.straight.sqrt();
        if e.g == R::ZERO && e.slope >= R::ZERO {
            return Some(found(descent.at, &e, R::ZERO, descent.flags.and(Flags::BRACKETED)));
        }
        let ahead = descent.bracket(&e, round == 0);
        if let Some(foot) = descent.at_border(&e, &ahead) {
            return Some(foot);
        }
        let newton = descent.newton(&e);
        if !bisect && newton.convex && newton.inside && newton.bounded && newton.step.abs() * speed < short_step() {
            return Some(descent.series(&e, &newton));
        }
        if round + 1 == budget {
            return Some(descent.last(&e, newton.convex));
        }
        let next = match (descent.low, descent.high) {
            (Some(low), Some(high)) => descent.between(&low, &high, &e, &newton)?,
            _ => descent.downhill(&e, speed, &newton, &ahead, round > 0),
        };
        match next {
            Next::Sample(spot) => descent.at = spot,
            Next::Foot(foot) => return Some(foot),
        }
    }
    None
}

/// A descent in progress: the latest sample, the bracket around the minimum, and the distance covered.
struct Descent<'p, 's, R, P> {
    path: &'p Path<'s, R, P>,
    window: R,
    bisect: bool,
    at: Spot<R>,
    low: Option<Spot<R>>,
    high: Option<Spot<R>>,
    flags: Flags,
    /// Arc length covered outside the bracket, mm.
    walked: R,
}

/// The downhill side of a sample.
struct Ahead<R> {
    forward: bool,
    /// The span beyond the border.
    beyond: Option<u32>,
    /// Parameter of the border.
    border: R,
}

/// Newton's step from a sample or, if the distance is not convex there, the step of a straight tangent.
struct Newton<R> {
    step: R,
    to: R,
    convex: bool,
    /// Whether it stays on the span.
    inside: bool,
    /// Whether it stays in the bracket.
    bounded: bool,
}

/// Result of a round: another sample or the answer.
enum Next<R> {
    Sample(Spot<R>),
    Foot(Found<R>),
}

impl<R: Real, P: Position> Descent<'_, '_, R, P> {
    /// Makes the latest sample an end of the bracket.
    #[inline(always)]
    fn bracket(&mut self, e: &Evaluation<R>, first: bool) -> Ahead<R> {
        if first && e.slope <= R::ZERO {
            self.flags = self.flags.and(Flags::SECOND_MINIMUM);
        }
        let forward = e.g < R::ZERO;
        if forward {
            self.low = Some(self.at)
        } else {
            self.high = Some(self.at)
        }
        let number = self.at.number;
        let beyond = if forward { self.path.next(number) } else { self.path.previous(number) };
        Ahead { forward, beyond, border: if forward { R::ONE } else { R::ZERO } }
    }

    /// A corner between two samples on either side of one border, or an end with the minimum beyond it.
    #[inline(always)]
    fn at_border(&self, e: &Evaluation<R>, ahead: &Ahead<R>) -> Option<Found<R>> {
        if let (Some(l), Some(h)) = (self.low, self.high)
            && h.span == l.span + 1
            && l.t == R::ONE
            && h.t == R::ZERO
        {
            return Some(found(self.at, e, R::ZERO, self.flags.and(Flags::BRACKETED).and(Flags::AT_CORNER)));
        }
        let open = if ahead.forward { self.high.is_none() } else { self.low.is_none() };
        if open && self.at.t == ahead.border && ahead.beyond.is_none() {
            return Some(found(self.at, e, R::ZERO, self.flags.and(Flags::BRACKETED).and(Flags::AT_END)));
        }
        None
    }

    #[inline(always)]
    fn newton(&self, e: &Evaluation<R>) -> Newton<R> {
        let at = self.at;
        let convex = e.slope > R::of(0.25) * e.straight;
        let step = -(e.g / if convex { e.slope } else { e.straight }.max(R::of(1e-30)));
        let to = at.t + step;
        let inside = to >= R::ZERO && to <= R::ONE;
        let bounded = self.low.is_none_or(|l| l.span < at.span || l.t <= to)
            && self.high.is_none_or(|h| h.span > at.span || to <= h.t);
        Newton { step, to, convex, inside, bounded }
    }

    /// The foot by the series about the latest sample, without another evaluation.
    #[inline(always)]
    fn series(&self, e: &Evaluation<R>, newton: &Newton<R>) -> Found<R> {
        let step = newton.step;
        let mut done = found(self.at, e, R::ZERO, self.flags.and(Flags::BRACKETED));
        done.place.t = newton.to;
        for k in 0..3 {
            done.vector[k] = e.vector[k] + step * (e.tangent[k] + step * e.bend[k]);
            done.tangent[k] = e.tangent[k] + R::TWO * (step * e.bend[k]);
        }
        done
    }

    /// The latest sample, after the last evaluation.
    #[inline(always)]
    fn last(&self, e: &Evaluation<R>, convex: bool) -> Found<R> {
        let (width, flags) = match (self.low, self.high) {
            (Some(l), Some(h)) => (bracket_width(self.path, &l, &h), self.flags.and(Flags::BRACKETED)),
            _ => (self.window, self.flags),
        };
        Found { downhill: convex, ..found(self.at, e, width, flags) }
    }

    /// The next sample inside the bracket.
    #[inline(always)]
    fn between(&self, l: &Spot<R>, h: &Spot<R>, e: &Evaluation<R>, newton: &Newton<R>) -> Option<Next<R>> {
        let at = self.at;
        let width = bracket_width(self.path, l, h);
        let done = || Next::Foot(found(at, e, width, self.flags.and(Flags::BRACKETED)));
        if width <= resolution::<R>() {
            return Some(done());
        }
        let to = newton.to;
        Some(Next::Sample(if l.span == h.span {
            let middle = R::HALF * (l.t + h.t);
            if !(l.t < middle && middle < h.t) {
                return Some(done());
            }
            let strictly = l.t < to && to < h.t;
            Spot { t: if !self.bisect && strictly && at.span == l.span { to } else { middle }, ..*l }
        } else if !self.bisect && newton.inside && newton.bounded && to != at.t && to > R::ZERO && to < R::ONE {
            Spot { t: to, ..at }
        } else if l.t < R::ONE {
            // The border itself, first from the lower side, then from the upper.
            Spot { t: R::ONE, ..*l }
        } else {
            Spot { span: l.span + 1, number: self.path.next(l.number)?, t: R::ZERO }
        }))
    }

    /// Continues downhill by Newton's step, but not over a border and not out of the window.
    #[inline(always)]
    fn downhill(&mut self, e: &Evaluation<R>, speed: R, newton: &Newton<R>, ahead: &Ahead<R>, later: bool) -> Next<R> {
        let (at, border) = (self.at, ahead.border);
        let room = self.window - self.walked;
        let reach = room / speed.max(R::of(1e-12));
        let far = if self.bisect {
            (R::of(0.25) * self.window / speed.max(R::of(1e-12))).min(reach)
        } else {
            newton.step.abs().min(reach)
        };
        let target = if ahead.forward { at.t + far } else { at.t - far };
        let over = |number| {
            let span = if ahead.forward { at.span + 1 } else { at.span - 1 };
            Next::Sample(Spot { span, number, t: R::ONE - border })
        };
        let near = at.span.abs() < SPANS;
        let crosses = !(target > R::ZERO && target < R::ONE);
        if crosses && at.t == border {
            // At the border already: continue in the span beyond it.
            return match ahead.beyond {
                Some(number) if near => over(number),
                _ => Next::Foot(found(at, e, self.window, self.flags)),
            };
        }
        if crosses {
            self.walked += (border - at.t).abs() * speed;
            return match ahead.beyond {
                // A smooth tangent makes samples on both sides of the border unnecessary.
                Some(number) if near && !self.bisect => over(number),
                _ => Next::Sample(Spot { t: border, ..at }),
            };
        }
        self.walked += far * speed;
        let left = self.walked >= self.window * R::of(0.999) && far < newton.step.abs() && later && room <= R::ZERO;
        if left || far == R::ZERO || target == at.t {
            return Next::Foot(found(at, e, self.window, self.flags));
        }
        Next::Sample(Spot { t: target, ..at })
    }
}

/// A bracket narrower than this counts as a point, mm.
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
    if low.span == high.span { to - from } else { whole - from + to }
}

fn found<R: Real>(spot: Spot<R>, e: &Evaluation<R>, width: R, flags: Flags) -> Found<R> {
    let place = Reference { span: spot.number, t: spot.t };
    Found { place, vector: e.vector, tangent: e.tangent, width, flags, downhill: false }
}

/// Evaluates a span at `t` and returns the result as a foot.
pub(super) fn at<R: Real, P: Position>(span: &Span<R, P>, number: u32, point: &[P; 3], t: R) -> Found<R> {
    let e = evaluate(span, &span.relative(point), t);
    found(Spot { span: 0, number, t }, &e, R::ZERO, Flags::default())
}
