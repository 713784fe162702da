//! All minima of the distance on a stretch of path, none missed: each part of a span is halved until it has one or none.

use super::part::Part;
use crate::contour::Flags;
use crate::contour::convert::REACH;
use crate::contour::kernel::{evaluate, foot};
use crate::contour::refine::{Found, at, dot};
use crate::contour::search::Method;
use crate::contour::span::{Form, Path, Reference, Span};
use crate::position::Position;
use crate::real::Real;

/// Width of the narrowest parts of a span: narrower parts cannot have two distinct minima.
const NARROWEST: f64 = 1.0 / 1024.0;
/// Most parts waiting while a span is halved down to the narrowest.
const WAITING: usize = 12;
/// Most parts of a span: where the slope is all rounding, near the centre of an arc, halving would not end.
const PARTS: u32 = 64;

/// Minima found so far, for one point.
pub(in crate::contour) struct Survey<'a, R, P> {
    pub(in crate::contour) path: Path<'a, R, P>,
    pub(in crate::contour) point: [P; 3],
    pub(in crate::contour) method: Method,
    /// Counts every minimum; otherwise only the nearest matters, and parts beyond it are skipped.
    pub(in crate::contour) counting: bool,
    /// A likely position of the foot.
    pub(in crate::contour) guess: Reference<R>,
    /// The nearest minimum.
    pub(in crate::contour) minimum: Option<Found<R>>,
    /// The nearest end of a stretch.
    pub(in crate::contour) end: Option<Found<R>>,
    pub(in crate::contour) minima: u32,
    /// Evaluations of the path.
    pub(in crate::contour) spent: u8,
}

/// An end of a part: parameter, and slope of the squared distance.
#[derive(Clone, Copy, Default)]
struct End<R> {
    t: R,
    g: R,
}

#[inline(always)]
fn squared<R: Real>(found: &Found<R>) -> R {
    dot(&found.vector, &found.vector)
}

impl<R: Real, P: Position> Survey<'_, R, P> {
    /// Squared distance of the nearest foot so far, mm².
    pub(in crate::contour) fn nearest(&self) -> R {
        let of = |found: &Option<Found<R>>| found.as_ref().map_or(R::MAX, squared);
        of(&self.minimum).min(of(&self.end))
    }

    /// The nearest minimum, unless an end of the stretch is nearer by more than rounding.
    pub(in crate::contour) fn answer(&self) -> Option<Found<R>> {
        let distance = |found: &Found<R>| squared(found).sqrt();
        let rounding = |distance: R| R::of(8.0) * R::EPSILON * (R::of(REACH) + distance);
        match (self.minimum, self.end) {
            (Some(minimum), Some(end)) if distance(&minimum) > distance(&end) + rounding(distance(&end)) => Some(end),
            (Some(minimum), _) => Some(minimum),
            (None, end) => end,
        }
    }

    /// Finds the minima and ends of a span between two of its parameters.
    pub(in crate::contour) fn look(&mut self, number: u32, first: R, last: R) {
        let Some(span) = self.path.span(number) else { return };
        let local = span.relative(&self.point);
        let low = self.end_of(span, number, &local, first);
        let high = self.end_of(span, number, &local, last);
        if span.is_straight() {
            if low.g < R::ZERO && high.g >= R::ZERO {
                self.straight(span, number, &local, low.t, high.t);
            }
            return;
        }
        match span.form() {
            Form::Cubic => self.parts::<4, false>(span, number, &local, low, high),
            Form::RationalCubic => self.parts::<4, true>(span, number, &local, low, high),
            Form::Quintic => self.parts::<6, false>(span, number, &local, low, high),
            Form::RationalQuintic => self.parts::<6, true>(span, number, &local, low, high),
        }
    }

    /// Evaluates an end of a stretch: a minimum if it is a corner or an end of the path.
    fn end_of(&mut self, span: &Span<R, P>, number: u32, local: &[R; 3], t: R) -> End<R> {
        let e = evaluate(span, local, t);
        self.spent = self.spent.saturating_add(1);
        // At the very end the slope is zero and rises from there.
        let g = if e.g == R::ZERO && e.slope > R::ZERO && t == R::ZERO { R::EPSILON } else { e.g };
        let (place, flags) = (Reference { span: number, t }, self.border(number, t, g));
        let found = Found { place, vector: e.vector, tangent: e.tangent, width: R::ZERO, flags, downhill: false };
        if flags.has(Flags::BRACKETED) {
            // A corner is an end of two spans: count it once.
            let twice = flags.has(Flags::AT_CORNER) && t == R::ZERO;
            self.minima += u32::from(!twice);
            self.keep(found);
        }
        if self.end.as_ref().is_none_or(|end| squared(&found) < squared(end)) {
            self.end = Some(found);
        }
        End { t, g: e.g }
    }

    /// Keeps the nearer of two minima; of equal ones, the one on the earlier span.
    fn keep(&mut self, found: Found<R>) {
        let (new, first) = (squared(&found), found.place.span.wrapping_sub(self.path.first));
        let nearer = self.minimum.as_ref().is_none_or(|held| {
            new < squared(held) || (new == squared(held) && first < held.place.span.wrapping_sub(self.path.first))
        });
        if nearer {
            self.minimum = Some(found);
        }
    }

    /// Finds the foot on a straight span, in closed form.
    fn straight(&mut self, span: &Span<R, P>, number: u32, local: &[R; 3], low: R, high: R) {
        self.minima += 1;
        let [c0, c1, ..] = &span.coefficients;
        let way = [c1[0], c1[1], c1[2]];
        let to = [local[0] - c0[0], local[1] - c0[1], local[2] - c0[2]];
        let t = (dot(&to, &way) / dot(&way, &way)).limit(low, high);
        self.spent = self.spent.saturating_add(1);
        self.keep(Found { flags: Flags::BRACKETED, ..at(span, number, &self.point, t) });
    }

    /// Finds the minima between two ends of a curved span.
    #[inline(never)]
    fn parts<const C: usize, const RATIONAL: bool>(
        &mut self,
        span: &Span<R, P>,
        number: u32,
        local: &[R; 3],
        low: End<R>,
        high: End<R>,
    ) {
        let mut waiting = [(low, high); WAITING];
        let mut count = 1;
        for looked in 0..PARTS {
            let Some(next) = usize::checked_sub(count, 1) else { return };
            count = next;
            let Some(&(low, high)) = waiting.get(count) else { return };
            let part = Part::<R, C>::new::<RATIONAL>(&span.coefficients, local, low.t, high.t);
            if !self.counting && part.is_beyond(self.nearest()) {
                continue;
            }
            let rises = low.g < R::ZERO && high.g >= R::ZERO;
            let changes = part.changes::<RATIONAL>(low.g, high.g);
            let narrow = high.t - low.t <= R::of(NARROWEST) || looked + 1 + count as u32 >= PARTS;
            if changes < 2 || narrow {
                if rises {
                    self.minima += 1;
                    if !self.counting || !part.is_beyond(self.nearest()) {
                        self.narrow(span, number, local, low, high);
                    }
                }
                continue;
            }
            if self.counting && part.is_beyond(self.nearest()) && narrow {
                continue;
            }
            let t = R::HALF * (low.t + high.t);
            let middle = End { t, g: evaluate(span, local, t).g };
            self.spent = self.spent.saturating_add(1);
            for half in [(middle, high), (low, middle)] {
                if let Some(room) = waiting.get_mut(count) {
                    (*room, count) = (half, count + 1);
                }
            }
        }
    }

    /// Finds the minimum between two ends of a part.
    fn narrow(&mut self, span: &Span<R, P>, number: u32, local: &[R; 3], low: End<R>, high: End<R>) {
        let inside = |t: R| low.t <= t && t <= high.t;
        let chord = low.t + (high.t - low.t) * (low.g / (low.g - high.g));
        let known = self.guess.span == number && inside(self.guess.t);
        let guess = if known { self.guess.t } else { chord.limit(low.t, high.t) };
        if self.method == Method::Guarded {
            let first = foot(span, local, guess);
            self.spent = self.spent.saturating_add(2);
            if first.trusted && inside(first.t) {
                return self.polish(span, number, local, first.t);
            }
        }
        self.bracket(span, number, local, low.t, high.t);
    }

    /// Takes a last Newton step: from a guess farther off than in a servo cycle, the kernel may leave some 1e-8 mm.
    fn polish(&mut self, span: &Span<R, P>, number: u32, local: &[R; 3], t: R) {
        let e = evaluate(span, local, t);
        self.spent = self.spent.saturating_add(1);
        let step = -(e.g / e.slope);
        let place = Reference { span: number, t: (t + step).limit(R::ZERO, R::ONE) };
        let (mut vector, mut tangent) = (e.vector, e.tangent);
        for k in 0..3 {
            vector[k] += step * (e.tangent[k] + step * e.bend[k]);
            tangent[k] += R::TWO * (step * e.bend[k]);
        }
        self.keep(Found { place, vector, tangent, width: R::ZERO, flags: Flags::BRACKETED, downhill: false });
    }

    /// Takes Newton steps inside the bracket, guarded by bisection; or bisects only.
    fn bracket(&mut self, span: &Span<R, P>, number: u32, local: &[R; 3], mut low: R, mut high: R) {
        let mut t = R::HALF * (low + high);
        for _ in 0..80 {
            let e = evaluate(span, local, t);
            self.spent = self.spent.saturating_add(1);
            if e.g < R::ZERO {
                low = t
            } else {
                high = t
            }
            // Near the centre of curvature the slope nearly vanishes: bisection continues where Newton's step leaves the
            // bracket.
            let newton = t - e.g / e.slope;
            let guarded = self.method == Method::Guarded && e.slope > R::ZERO && low < newton && newton < high;
            let next = if guarded { newton } else { R::HALF * (low + high) };
            let done = next == t || !(low < next && next < high);
            t = next;
            if done {
                break;
            }
        }
        let width = span.arc_length(high) - span.arc_length(low);
        self.keep(Found { width, flags: Flags::BRACKETED, ..at(span, number, &self.point, t) });
    }

    /// Flags of an end of a stretch: a minimum at a corner, or the path's end, or none.
    #[inline(always)]
    fn border(&self, number: u32, t: R, g: R) -> Flags {
        if (t == R::ONE && g < R::ZERO) || (t == R::ZERO && g > R::ZERO) {
            self.border_minimum(number, t)
        } else {
            Flags::default()
        }
    }

    /// The distance grows inwards from a border: flags for whether it grows outwards too.
    #[inline(never)]
    fn border_minimum(&self, number: u32, t: R) -> Flags {
        let outward = t == R::ONE;
        let beyond = if outward { self.path.next(number) } else { self.path.previous(number) };
        let Some(neighbour) = beyond.and_then(|n| self.path.span(n)) else {
            return Flags::BRACKETED.and(Flags::AT_END);
        };
        let there = evaluate(neighbour, &neighbour.relative(&self.point), R::ONE - t).g;
        let back = if outward { there >= R::ZERO } else { there <= R::ZERO };
        if back { Flags::BRACKETED.and(Flags::AT_CORNER) } else { Flags::default() }
    }
}

impl<R: Real, P: Position> Span<R, P> {
    /// A line at constant speed.
    #[inline(always)]
    fn is_straight(&self) -> bool {
        let [_, _, c2, c3, ..] = &self.coefficients;
        self.form == Form::Cubic && c2.iter().chain(c3).all(|c| *c == R::ZERO)
    }
}
