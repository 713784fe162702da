//! Distances along a path, over a bounded number of spans.

use super::span::{Path, Reference, Span};
use crate::position::Position;
use crate::real::Real;

/// Most spans that the foot or the reference may cross in one cycle; after a larger motion the foot is lost.
const SPANS: u32 = 8;
/// Most spans between a foot and the reference, outside the servo cycle.
const FAR: u32 = 64;

/// Half-window at standstill, mm.
const STANDSTILL_WINDOW: f64 = 5e-3;
/// Half-window per unit of the reference's progress.
const WINDOW_PER_PROGRESS: f64 = 4.0;

/// Arc length from one point of the path to another, negative backwards; `None` over more than eight spans.
#[inline(always)]
pub(super) fn way<R: Real, P: Position>(path: &Path<'_, R, P>, from: Reference<R>, to: Reference<R>) -> Option<R> {
    match path.span(from.span) {
        Some(span) if from.span == to.span => Some(span.arc_length(to.t) - span.arc_length(from.t)),
        _ => across(path, from, to, SPANS),
    }
}

/// Like [`way`], over up to 64 spans; beyond them the result exceeds `beyond`.
// Only with far: not in a cycle, but for the published bisection.
#[inline(never)]
pub(super) fn way_far<R: Real, P: Position>(
    path: &Path<'_, R, P>,
    from: Reference<R>,
    to: Reference<R>,
    beyond: R,
) -> R {
    match path.span(from.span) {
        Some(span) if from.span == to.span => span.arc_length(to.t) - span.arc_length(from.t),
        _ => across(path, from, to, FAR).unwrap_or(R::TWO * beyond),
    }
}

/// Arc length in the direction that crosses fewer spans; `None` over more than `most`.
#[inline(never)]
fn across<R: Real, P: Position>(path: &Path<'_, R, P>, from: Reference<R>, to: Reference<R>, most: u32) -> Option<R> {
    let part = |place: Reference<R>| Some(path.span(place.span)?.arc_length(place.t));
    let count = path.spans.len() as u32;
    if to.span == from.span.wrapping_add(1) {
        // The usual case, without the counts; likewise backwards.
        let span = path.span(from.span)?;
        return Some(span.length() + part(to)? - span.arc_length(from.t));
    }
    if from.span == to.span.wrapping_add(1) && !(path.closed && count == 2) {
        let span = path.span(to.span)?;
        return Some(span.arc_length(to.t) - span.length() - part(from)?);
    }
    let (i, j) = (from.span.wrapping_sub(path.first), to.span.wrapping_sub(path.first));
    let ahead = if j >= i {
        j - i
    } else if path.closed {
        (j + count).wrapping_sub(i)
    } else {
        u32::MAX
    };
    let behind = if i >= j {
        i - j
    } else if path.closed {
        (i + count).wrapping_sub(j)
    } else {
        u32::MAX
    };
    if ahead <= behind {
        Some(between(path, from.span, ahead, most)? + part(to)? - part(from)?)
    } else {
        Some(part(to)? - between(path, to.span, behind, most)? - part(from)?)
    }
}

/// Total length of `count` spans, starting with `number`; `None` for more than `most`.
fn between<R: Real, P: Position>(path: &Path<'_, R, P>, mut number: u32, count: u32, most: u32) -> Option<R> {
    if count > most {
        return None;
    }
    let mut sum = R::ZERO;
    // At most SPANS rounds without far, else FAR: `most` of the callers.
    for _ in 0..count {
        sum += path.span(number)?.length();
        number = path.following(number)?;
    }
    Some(sum)
}

/// Distance within which a border may hide a nearer foot behind it: where a tool cuts a corner of 28° or more by the error,
/// the foot on the old leg lies within four times the error from the corner.
#[inline(always)]
pub(super) fn sight<R: Real>(window: R, error: R) -> R {
    window + R::of(4.0) * error
}

/// S = 5 µm + 4 × progress.
#[inline(always)]
pub(super) fn window<R: Real>(progress: R) -> R {
    R::of(STANDSTILL_WINDOW) + R::of(WINDOW_PER_PROGRESS) * progress.abs()
}

/// A point of the path and its exact arc length from the starting point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moved<R> {
    pub(super) to: Reference<R>,
    pub(super) by: R,
}

/// The point at arc length `by` along the path, to within the change of speed on the way; clamped at the ends of an open path.
/// `None` over more than eight spans.
#[inline(always)]
pub(super) fn advance<R: Real, P: Position>(path: &Path<'_, R, P>, from: Reference<R>, by: R) -> Option<Moved<R>> {
    let (moved, there) = walk(path, from, by, SPANS)?;
    there.then_some(moved)
}

/// Advances by `by` over at most `most` spans; also returns whether they were enough.
#[inline(never)]
fn walk<R: Real, P: Position>(path: &Path<'_, R, P>, from: Reference<R>, by: R, most: u32) -> Option<(Moved<R>, bool)> {
    let mut span: &Span<R, P> = path.span(from.span)?;
    let (mut number, begin) = (from.span, span.arc_length(from.t));
    let t = from.t + by / span.arc_speed(from.t);
    if t >= R::ZERO && t <= R::ONE {
        return Some((Moved { to: Reference { span: number, t }, by: span.arc_length(t) - begin }, true));
    }
    let mut length = span.length();
    let mut place = begin + by;
    // Length of the spans passed, negative backwards.
    let mut passed = R::ZERO;
    let (mut left, mut there) = (most, true);
    // At most 9 rounds without far, else 65: the one after the last of `most` spans ends the search.
    while place > length || place < R::ZERO {
        let ahead = place > length;
        let next = if ahead { path.following(number) } else { path.preceding(number) };
        there = left > 0 || next.is_none();
        let (true, Some(next)) = (left > 0, next) else {
            // An end of the path, or the limit of spans.
            place = if ahead { length } else { R::ZERO };
            break;
        };
        left -= 1;
        span = path.span(next)?;
        number = next;
        if ahead {
            (place, passed) = (place - length, passed + length);
            length = span.length();
        } else {
            length = span.length();
            (place, passed) = (place + length, passed - length);
        }
    }
    // From the nearer end, with the speed there.
    let rest = length - place;
    let t = if place < rest { place / span.arc_speed(R::ZERO) } else { R::ONE - rest / span.arc_speed(R::ONE) };
    let t = t.limit(R::ZERO, R::ONE);
    Some((Moved { to: Reference { span: number, t }, by: passed + span.arc_length(t) - begin }, there))
}

/// Like [`advance`], but stops after 64 spans; for use outside the servo cycle.
// Only with far.
pub(super) fn advance_far<R: Real, P: Position>(path: &Path<'_, R, P>, from: Reference<R>, by: R) -> Reference<R> {
    walk(path, from, by, FAR).map_or(from, |(moved, _)| moved.to)
}
