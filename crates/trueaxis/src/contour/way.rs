//! Distances along a path, over a bounded number of spans.

use super::span::{Path, Reference, Span};
use crate::position::Position;
use crate::real::Real;

/// Spans that a motion goes over in a cycle, at most: what goes farther is lost sight of.
const SPANS: u32 = 8;
/// Spans between two samples of a cold search, at most.
const STEP: u32 = 3;
/// The same for the distance between a foot and the reference, off the servo cycle.
const FAR: u32 = 64;

/// Half-window at standstill, mm.
const STANDSTILL_WINDOW: f64 = 5e-3;
/// Half-window per progress of the reference.
const WINDOW_PER_PROGRESS: f64 = 4.0;

/// Arc length from one point of the path to another, negative backwards; none over more than eight spans.
#[inline(always)]
pub(super) fn way<R: Real, P: Position>(path: &Path<'_, R, P>, from: Reference<R>, to: Reference<R>) -> Option<R> {
    match path.span(from.span) {
        Some(span) if from.span == to.span => Some(span.arc_length(to.t) - span.arc_length(from.t)),
        _ => across(path, from, to, SPANS),
    }
}

/// The same over up to 64 spans; beyond them it is more than `beyond`.
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

/// Whichever way is over fewer spans.
#[inline(never)]
fn across<R: Real, P: Position>(path: &Path<'_, R, P>, from: Reference<R>, to: Reference<R>, most: u32) -> Option<R> {
    let part = |place: Reference<R>| Some(path.span(place.span)?.arc_length(place.t));
    let count = path.spans.len() as u32;
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

/// Length of `number` and the spans after it, `count` in all.
fn between<R: Real, P: Position>(path: &Path<'_, R, P>, mut number: u32, count: u32, most: u32) -> Option<R> {
    if count > most {
        return None;
    }
    let mut sum = R::ZERO;
    for _ in 0..count {
        sum += path.span(number)?.length();
        number = path.following(number)?;
    }
    Some(sum)
}

/// Borders within this may hide a nearer foot behind them: where a tool cuts a corner of 28° or more by the error, the
/// foot on the old leg lies within four times that of the corner.
#[inline(always)]
pub(super) fn sight<R: Real>(window: R, error: R) -> R {
    window + R::of(4.0) * error
}

/// S = 5 µm + 4 × progress.
#[inline(always)]
pub(super) fn window<R: Real>(progress: R) -> R {
    R::of(STANDSTILL_WINDOW) + R::of(WINDOW_PER_PROGRESS) * progress.abs()
}

/// A point of the path, and how far from another it really is, arc length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moved<R> {
    pub(super) to: Reference<R>,
    pub(super) by: R,
}

/// The point at a distance further along the path, within the speed's change on the way; held at the ends of an open one.
/// None over more than eight spans.
#[inline(always)]
pub(super) fn advance<R: Real, P: Position>(path: &Path<'_, R, P>, from: Reference<R>, by: R) -> Option<Moved<R>> {
    let (moved, there) = walk(path, from, by, SPANS)?;
    there.then_some(moved)
}

/// The same for a step between two samples: over three spans at most, where it stays.
#[inline(always)]
pub(super) fn step<R: Real, P: Position>(path: &Path<'_, R, P>, from: Reference<R>, by: R) -> Option<Moved<R>> {
    Some(walk(path, from, by, STEP)?.0)
}

/// Over `most` spans at most, and whether that was enough.
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
    // Lengths passed, negative backwards.
    let mut passed = R::ZERO;
    let (mut left, mut there) = (most, true);
    while place > length || place < R::ZERO {
        let ahead = place > length;
        let next = if ahead { path.following(number) } else { path.preceding(number) };
        there = left > 0 || next.is_none();
        let (true, Some(next)) = (left > 0, next) else {
            // An end of the path, or of what is looked at.
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

/// The same over up to 64 spans, where it stays: off the servo cycle.
pub(super) fn advance_far<R: Real, P: Position>(path: &Path<'_, R, P>, from: Reference<R>, by: R) -> Reference<R> {
    walk(path, from, by, FAR).map_or(from, |(moved, _)| moved.to)
}
