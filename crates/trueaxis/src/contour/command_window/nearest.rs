//! Nearest point of a path of many short spans.

#![deny(clippy::indexing_slicing)]

use crate::contour::kernel::foot;
use crate::contour::refine::{Found, descend};
use crate::contour::search::components;
use crate::contour::span::{Path, Reference, Span};
use crate::contour::{ContourError, Flags};
use crate::position::Position;
use crate::real::Real;
use crate::vector::V3;

/// Evaluations of the descent if the kernel's two feet are not on their spans.
const DESCENT: u8 = 4;

/// `whole`: the path's first point is where the motion began, not where the window was cut off.
#[inline(never)]
pub(super) fn contour_error<R: Real, P: Position>(
    path: &Path<'_, R, P>,
    reference: Reference<R>,
    whole: bool,
    point: &[P; 3],
) -> ContourError<R> {
    let Some((span, guess)) = nearest(path, point) else { return ContourError::none() };
    let mut evaluations = 2;
    let mut found = on(span, guess, point);
    let border = if guess.t < R::HALF { R::ZERO } else { R::ONE };
    let beyond = if guess.t < R::HALF { path.preceding(guess.span) } else { path.following(guess.span) };
    if found.is_none()
        && let Some(number) = beyond
        && let Some(next) = path.span(number)
    {
        // The chord's end was nearest, and the curve's foot lies across the border.
        evaluations += 2;
        found = on(next, Reference { span: number, t: R::ONE - border }, point);
    }
    let found = match found {
        Some(found) => found,
        None => {
            // A corner, an end, or a bend that the chords misjudge.
            let window = R::TWO * span.length();
            let Some(found) = descend(path, guess, point, window, false, DESCENT, &mut evaluations) else {
                return ContourError::none();
            };
            let cut = !whole && found.place == Reference { span: path.first, t: R::ZERO };
            if cut { Found { flags: Flags::AT_END, ..found } } else { found }
        }
    };
    let error = V3::from(found.vector).norm();
    let lag = lag(path, found.place, reference);
    components(path, &found, error, lag, evaluations)
}

/// The span with the nearest chord (the later of two equal ones), and the nearest point on the chord.
#[inline(always)]
fn nearest<'a, R: Real, P: Position>(path: &Path<'a, R, P>, point: &[P; 3]) -> Option<(&'a Span<R, P>, Reference<R>)> {
    let (mut least, mut best) = (R::MAX, None);
    let mut number = path.first;
    for span in path.spans {
        let ([x, y, z, _], chord) = span.chord();
        let to = V3::from(span.relative(point)) - V3::new(x, y, z);
        let (along, square) = (to.dot(chord), chord.dot(chord));
        // A point has no chord; 0/0 becomes 0.
        let t = (along / square).limit(R::ZERO, R::ONE);
        let aside = to - chord * t;
        let distance = aside.dot(aside);
        if distance <= least {
            (least, best) = (distance, Some((span, Reference { span: number, t })));
        }
        number = number.wrapping_add(1);
    }
    best
}

/// The kernel's foot, if the span has one.
#[inline(always)]
fn on<R: Real, P: Position>(span: &Span<R, P>, guess: Reference<R>, point: &[P; 3]) -> Option<Found<R>> {
    let found = foot(span, &span.relative(point), guess.t);
    found.trusted.then_some(Found {
        place: Reference { span: guess.span, t: found.t },
        vector: found.vector,
        tangent: found.tangent,
        width: R::ZERO,
        flags: Flags::BRACKETED,
        downhill: false,
    })
}

/// Arc length from a point of the path to its end.
#[inline(always)]
fn lag<R: Real, P: Position>(path: &Path<'_, R, P>, from: Reference<R>, end: Reference<R>) -> R {
    let mut lag = R::ZERO;
    for (span, number) in path.spans.iter().rev().zip(0u32..) {
        let number = end.span.wrapping_sub(number);
        if number == from.span {
            return lag + span.length() - span.arc_length(from.t);
        }
        lag += span.length();
    }
    lag
}
