//! The whole cold search in one call: for files, not for servo cycles.

use super::kernel::{Foot, evaluate, foot};
use super::nearest::survey::Survey;
use super::refine::dot;
use super::search::{ContourSearch, Method, components};
use super::span::{Path, Reference, Span};
use super::way::{advance_far, way_far};
use super::{ContourError, Flags};
use crate::position::Position;
use crate::real::Real;

/// Most spans searched on either side of the reference.
const PIECES: usize = 4096;
/// Steps along the tangent before the whole window is searched.
const WALKS: usize = 3;

/// A foot alone, without the components of a [`ContourError`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub struct NearFoot<R: Real> {
    /// Position on the path.
    pub at: Reference<R>,
    /// Actual − foot, mm.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub vector: R::Vec3,
    /// Flags of the foot; without *bracketed* it is the nearest end of the window.
    pub flags: Flags,
}

impl<R: Real> NearFoot<R> {
    /// Distance from the path, mm.
    #[inline(always)]
    pub fn distance(&self) -> R {
        let vector: [R; 3] = self.vector.into();
        dot(&vector, &vector).sqrt()
    }
}

impl<R: Real> ContourSearch<R> {
    /// Finds the foot of `point` (mm) near `guess` without a known foot: a local projection.
    ///
    /// Returns the kernel's foot from the guess, or from a few steps along the tangent, if its own test trusts it and
    /// it lies within a sixteenth of `max_lag_mm` of the point; otherwise the nearest of all feet within `max_lag_mm`
    /// of arc length of the guess, missing none. `None` if the path has no such span, or the guess or the point is not
    /// a number.
    ///
    /// Cost: one call of the kernel; across a border or from farther away two calls and an evaluation. The whole window is
    /// usually searched only at corners and ends.
    #[inline(always)]
    pub fn foot_near<P: Position>(
        &self,
        path: &Path<'_, R, P>,
        guess: Reference<R>,
        point: &[P; 3],
    ) -> Option<NearFoot<R>> {
        let span = path.span(guess.span)?;
        if self.method == Method::Guarded {
            let found = foot(span, &span.relative(point), guess.t);
            if found.trusted && dot(&found.vector, &found.vector) <= self.certain() {
                return Some(near(guess.span, &found));
            }
        }
        self.foot_farther(path, guess, point)
    }

    /// Continues where the kernel does not trust its foot at the guess.
    #[inline(never)]
    fn foot_farther<P: Position>(
        &self,
        path: &Path<'_, R, P>,
        guess: Reference<R>,
        point: &[P; 3],
    ) -> Option<NearFoot<R>> {
        if !(guess.t.is_finite() && point.iter().all(|x| x.is_usable())) {
            return None;
        }
        let guess = path.moving(Reference { t: guess.t.limit(R::ZERO, R::ONE), ..guess });
        if self.method == Method::Guarded
            && let Some(found) = self.walk(path, guess, point)
        {
            return Some(found);
        }
        let mut survey = self.survey(*path, guess, *point, false);
        self.window(&mut survey);
        let found = survey.answer()?;
        Some(NearFoot { at: found.place, vector: found.vector.map(|x| -x).into(), flags: found.flags })
    }

    /// Squared distance up to which a foot is accepted without a search of the window, mm².
    #[inline(always)]
    fn certain(&self) -> R {
        R::of(1.0 / 256.0) * self.max_lag * self.max_lag
    }

    /// Steps along the tangent and calls the kernel there, a few times.
    #[inline(always)]
    fn walk<P: Position>(&self, path: &Path<'_, R, P>, guess: Reference<R>, point: &[P; 3]) -> Option<NearFoot<R>> {
        let (mut at, mut left) = (guess, self.max_lag);
        for _ in 0..WALKS {
            let span = path.span(at.span)?;
            let e = evaluate(span, &span.relative(point), at.t);
            let along = (-(e.g / e.straight.max(R::of(1e-30)).sqrt())).limit(-left, left);
            left -= along.abs();
            at = advance_far(path, at, along);
            let span = path.span(at.span)?;
            let found = foot(span, &span.relative(point), at.t);
            if found.trusted && dot(&found.vector, &found.vector) <= self.certain() {
                return Some(near(at.span, &found));
            }
        }
        None
    }

    /// Contour error of `point` when only the reference's position is known: distance to the nearest of all feet within
    /// `max_lag_mm` of arc length on either side of the reference.
    ///
    /// Finds every minimum in that window and flags the result if it finds a second one; without any minimum the nearer
    /// end of the window is the answer, without the flag *bracketed*. Not for a servo cycle: two evaluations of every
    /// span in the window, and a call of the kernel for each minimum; `evaluations` saturates at 255.
    pub fn nearest<P: Position>(
        &self,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
        point: [P; 3],
    ) -> ContourError<R> {
        let reference = path.moving(reference);
        let mut survey = self.survey(*path, reference, point, true);
        self.window(&mut survey);
        let Some(mut found) = survey.answer() else { return ContourError::none() };
        if survey.minima > 1 {
            found.flags = found.flags.and(Flags::SECOND_MINIMUM);
        }
        let error = dot(&found.vector, &found.vector).sqrt();
        let lag = way_far(path, found.place, reference, self.max_lag);
        components(path, &found, error, lag, survey.spent)
    }

    fn survey<'p, P: Position>(
        &self,
        path: Path<'p, R, P>,
        guess: Reference<R>,
        point: [P; 3],
        counting: bool,
    ) -> Survey<'p, R, P> {
        let method = self.method;
        Survey { path, point, method, counting, guess, minimum: None, end: None, minima: 0, spent: 0 }
    }

    /// Surveys all spans within `max_lag` of the guess, from there outwards on both sides.
    fn window<P: Position>(&self, survey: &mut Survey<'_, R, P>) {
        let (path, reference) = (survey.path, survey.guess);
        let Some(home) = path.span(reference.span) else { return };
        let (mut ahead, mut behind) = (R::ZERO, R::ZERO);
        let here = home.arc_length(reference.t);
        let mut pieces = [Some((reference.span, here)), None];
        let (mut next, mut previous) = (Some(reference.span), Some(reference.span));
        for round in 0..PIECES {
            for (number, from) in pieces.into_iter().flatten() {
                self.piece(survey, number, from);
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
    }

    /// Surveys the part of one span that lies in the window; `reference` is the reference's arc length from the start of the
    /// span.
    fn piece<P: Position>(&self, survey: &mut Survey<'_, R, P>, number: u32, reference: R) {
        let Some(span) = survey.path.span(number) else { return };
        let (first, last) = (place(span, reference - self.max_lag), place(span, reference + self.max_lag));
        if first < last {
            survey.look(number, first, last);
        }
    }
}

#[inline(always)]
fn near<R: Real>(span: u32, foot: &Foot<R>) -> NearFoot<R> {
    let at = Reference { span, t: foot.t };
    NearFoot { at, vector: foot.vector.map(|x| -x).into(), flags: Flags::BRACKETED }
}

/// [`Span::t_at`] by Newton's method if it converges quickly.
fn place<R: Real, P: Position>(span: &Span<R, P>, arc: R) -> R {
    let length = span.length();
    if arc <= R::ZERO {
        return R::ZERO;
    }
    if arc >= length {
        return R::ONE;
    }
    let mut t = arc / length;
    for _ in 0..4 {
        let left = arc - span.arc_length(t);
        if left.abs() <= R::of(4.0) * R::EPSILON * length {
            return t;
        }
        t = (t + left / span.arc_speed(t)).limit(R::ZERO, R::ONE);
    }
    span.t_at(arc)
}
