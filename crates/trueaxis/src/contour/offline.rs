//! The whole cold search in one call: for files, not for cycles.

use super::kernel::evaluate;
use super::refine::{Found, at, dot};
use super::search::{ContourSearch, Method, components};
use super::span::{Path, Reference, Span};
use super::way::way_far;
use super::{ContourError, Flags};
use crate::position::Position;
use crate::real::Real;

/// Samples of every span; its tangent turns by less than 30°, so no two minima hide between two of them.
const SAMPLES: i32 = 16;
/// Spans looked at on either side of the reference.
const PIECES: usize = 4096;

impl<R: Real> ContourSearch<R> {
    /// Contour error of `point` with nothing known but where the reference is: the nearest of all feet within
    /// `max_lag_mm` of arc length on either side of it.
    ///
    /// Without a minimum in that window its nearest sampled point is the answer, without the flag *bracketed*. Not for a
    /// servo cycle: hundreds of evaluations; `evaluations` saturates at 255.
    pub fn nearest<P: Position>(
        &self,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
        point: [P; 3],
    ) -> ContourError<R> {
        let reference = path.moving(reference);
        let Some(home) = path.span(reference.span) else { return ContourError::none() };
        let mut spent = 0;
        let start = at(home, reference.span, &point, reference.t.limit(R::ZERO, R::ONE));
        let mut best = Best { minimum: None, sample: start };
        let mut minima = 0;
        let (mut ahead, mut behind) = (R::ZERO, R::ZERO);
        let here = home.arc_length(reference.t);
        let mut pieces = [Some((reference.span, here)), None];
        let (mut next, mut previous) = (Some(reference.span), Some(reference.span));
        for round in 0..PIECES {
            for (number, from) in pieces.into_iter().flatten() {
                self.piece(path, number, from, &point, &mut best, &mut minima, &mut spent);
            }
            let ahead_length = next.and_then(|n| path.span(n)).map_or(R::ZERO, Span::length);
            ahead += if round == 0 { ahead_length - here } else { ahead_length };
            behind += if round == 0 { here } else { previous.and_then(|n| path.span(n)).map_or(R::ZERO, Span::length) };
            next = next.and_then(|n| path.next(n)).filter(|n| ahead < self.max_lag && *n != reference.span);
            previous =
                previous.and_then(|n| path.previous(n)).filter(|n| behind < self.max_lag && *n != reference.span);
            // Position of the reference, from the start of the span.
            let before = previous.and_then(|n| path.span(n)).map_or(R::ZERO, Span::length);
            pieces = [next.map(|n| (n, -ahead)), previous.filter(|p| Some(*p) != next).map(|n| (n, behind + before))];
            if next.is_none() && previous.is_none() {
                break;
            }
        }
        let mut best = best.answer();
        if minima > 1 {
            best.flags = best.flags.and(Flags::SECOND_MINIMUM);
        }
        let error = dot(&best.vector, &best.vector).sqrt();
        let lag = way_far(path, best.place, reference, self.max_lag);
        components(path, &best, error, lag, spent)
    }

    /// Minima and borders of one span, as far as it lies in the window; `reference` is its arc length in the span.
    pub(super) fn piece<P: Position>(
        &self,
        path: &Path<'_, R, P>,
        number: u32,
        reference: R,
        point: &[P; 3],
        best: &mut Best<R>,
        minima: &mut u32,
        spent: &mut u8,
    ) {
        let Some(span) = path.span(number) else { return };
        let (first, last) = (span.t_at(reference - self.max_lag), span.t_at(reference + self.max_lag));
        if last <= first {
            return;
        }
        let local = span.relative(point);
        let mut before: Option<(R, R)> = None;
        for i in 0..=SAMPLES {
            let t = if i == SAMPLES {
                last
            } else {
                first + (last - first) * R::of_i32(i) * R::of(1.0 / f64::from(SAMPLES))
            };
            let e = evaluate(span, &local, t);
            *spent = spent.saturating_add(1);
            let mut candidate = at(span, number, point, t);
            candidate.flags = self.border(path, number, t, e.g, point);
            if candidate.flags.has(Flags::BRACKETED) {
                *minima += 1;
            }
            best.consider(candidate);
            if let Some((t0, g0)) = before
                && g0 < R::ZERO
                && e.g >= R::ZERO
                && let Some(found) = self.narrow(path, number, (t0, t), point, spent)
            {
                *minima += 1;
                best.consider(found);
            }
            before = Some((t, e.g));
        }
    }

    /// The minimum between two samples of one span.
    fn narrow<P: Position>(
        &self,
        path: &Path<'_, R, P>,
        number: u32,
        (low, high): (R, R),
        point: &[P; 3],
        spent: &mut u8,
    ) -> Option<Found<R>> {
        let span = path.span(number)?;
        let local = span.relative(point);
        let (mut low, mut high) = (low, high);
        let mut t = R::HALF * (low + high);
        for _ in 0..80 {
            let e = evaluate(span, &local, t);
            *spent = spent.saturating_add(1);
            if e.g < R::ZERO {
                low = t
            } else {
                high = t
            }
            // Near the centre of curvature the slope nearly vanishes: bisection goes on where Newton's step leads out.
            let newton = t - e.g / e.slope;
            let guarded = self.method == Method::Guarded && e.slope > R::ZERO && low < newton && newton < high;
            let next = if guarded { newton } else { R::HALF * (low + high) };
            let done = next == t || !(low < next && next < high);
            t = next;
            if done {
                break;
            }
        }
        let mut found = at(span, number, point, t);
        found.width = span.arc_length(high) - span.arc_length(low);
        found.flags = Flags::BRACKETED;
        Some(found)
    }

    /// Whether a sample at a border of its span is a corner's or an end's minimum.
    fn border<P: Position>(&self, path: &Path<'_, R, P>, number: u32, t: R, g: R, point: &[P; 3]) -> Flags {
        let (beyond, entry, outward) = if t == R::ONE && g < R::ZERO {
            (path.next(number), R::ZERO, true)
        } else if t == R::ZERO && g > R::ZERO {
            (path.previous(number), R::ONE, false)
        } else {
            return Flags::default();
        };
        let Some(neighbour) = beyond.and_then(|n| path.span(n)) else { return Flags::BRACKETED.and(Flags::AT_END) };
        let there = evaluate(neighbour, &neighbour.relative(point), entry).g;
        let back = if outward { there >= R::ZERO } else { there <= R::ZERO };
        if back { Flags::BRACKETED.and(Flags::AT_CORNER) } else { Flags::default() }
    }
}

/// The nearest minimum and the nearest sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Best<R> {
    pub(super) minimum: Option<Found<R>>,
    pub(super) sample: Found<R>,
}

impl<R: Real> Best<R> {
    fn consider(&mut self, candidate: Found<R>) {
        let squared = |found: &Found<R>| dot(&found.vector, &found.vector);
        if candidate.flags.has(Flags::BRACKETED) && self.minimum.is_none_or(|m| squared(&candidate) < squared(&m)) {
            self.minimum = Some(candidate);
        }
        if squared(&candidate) < squared(&self.sample) {
            self.sample = candidate;
        }
    }

    /// The minimum, unless the window's edge is nearer by more than rounding.
    pub(super) fn answer(self) -> Found<R> {
        let distance = |found: &Found<R>| dot(&found.vector, &found.vector).sqrt();
        match self.minimum {
            Some(minimum) if distance(&minimum) <= distance(&self.sample) + R::of(1e-6) => minimum,
            _ => self.sample,
        }
    }
}
