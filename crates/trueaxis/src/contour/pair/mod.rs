//! Contour errors of the estimated tip and of the plain encoder position together.
//!
//! The two points are only the tip's modelled error apart, some micrometres, so one guess and one shifted frame serve both
//! ([`frame`]). The search follows one foot from cycle to cycle, the tip's; the encoder's foot is the minimum of its distance
//! downhill from there. In a hairpin, where each point may have a different nearest leg, both feet therefore stay on the same
//! leg.
//!
//! The plain case of a cycle is straight-line code that runs every test before it writes anything. Any other case goes out of
//! line at once ([`general`]).

mod frame;
mod general;

use super::legs::Apart;
use super::search::{ContourSearch, ContourState, Method};
use super::span::{OnPath, Path, Reference, dot};
use super::way::{Moved, advance, way, window};
use super::{ContourError, Flags};
use crate::position::Position;
use crate::real::Real;
use frame::{Start, Tangent, feet};

/// State of the search for both feet from cycle to cycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairState<R> {
    tip: ContourState<R>,
    /// Arc length from the start of the foot's span to the reference.
    place: R,
    /// The path's derivative at the foot.
    along: Tangent<R>,
    /// Whether the foot can be followed.
    swift: bool,
    /// Whether it is a corner.
    at_corner: bool,
    /// Consecutive cycles without a foot.
    unsettled: u8,
}

impl<R: Real> ContourSearch<R> {
    /// Contour errors of an encoder position (mm) and of the tip, which is `d` (mm) from it, in this cycle; writes both.
    ///
    /// The tip's error equals the result of [`ContourSearch::update`], without rounding the tip to a position. The
    /// encoder's foot is the minimum of its distance downhill from the tip's foot, and its distance is as exact: 1e-6
    /// nm in doubles, 2 nm in single precision. In the plain case both vectors are split in the frame of the tip's
    /// foot, in which the encoder's components are exact on plane paths and on helices about the plane's normal. On
    /// other paths its binormal component has a relative error of up to cot α · κ|d|, with κ the curvature and α the
    /// angle between path and normal, and its normal component is the remainder of the distance.
    ///
    /// Uses at most five evaluations of the path for both, of which the frame of the plain case takes three; evaluations
    /// that serve both count for the tip. If they run out before the search finds a foot, it continues in the next cycle:
    /// the error has [`Flags::SEARCHING`], not [`Flags::BRACKETED`]. The encoder's is then measured from the tip's foot,
    /// and its `width` is |d|. For a reference off its span see [`ContourSearch::update`]. Cost: usually two and a half
    /// times the kernel's.
    #[inline(always)]
    pub fn update_pair<P: Position>(
        &self,
        state: &mut PairState<R>,
        on: &OnPath<'_, R, P>,
        position: &[P; 3],
        d: &[R; 3],
        tip: &mut ContourError<R>,
        encoder: &mut ContourError<R>,
    ) {
        if on.reference.is_on_its_span() {
            self.pair_on(state, on, position, d, tip, encoder);
        } else {
            self.pair_off(state, on, position, d, tip, encoder);
        }
    }

    /// Handles a reference off its span.
    #[cold]
    #[inline(never)]
    fn pair_off<P: Position>(
        &self,
        state: &mut PairState<R>,
        on: &OnPath<'_, R, P>,
        position: &[P; 3],
        d: &[R; 3],
        tip: &mut ContourError<R>,
        encoder: &mut ContourError<R>,
    ) {
        let Reference { span, t } = on.reference;
        if t.is_finite() {
            let held = OnPath { path: on.path, reference: Reference { span, t: t.limit(R::ZERO, R::ONE) } };
            self.pair_on(state, &held, position, d, tip, encoder);
        } else {
            state.lose(tip, encoder);
        }
        if t != R::ZERO {
            tip.flags = tip.flags.and(Flags::REFERENCE);
            encoder.flags = encoder.flags.and(Flags::REFERENCE);
        }
    }

    /// Handles a reference on its span.
    #[inline(always)]
    fn pair_on<P: Position>(
        &self,
        state: &mut PairState<R>,
        on: &OnPath<'_, R, P>,
        position: &[P; 3],
        d: &[R; 3],
        tip: &mut ContourError<R>,
        encoder: &mut ContourError<R>,
    ) {
        let reference = on.reference;
        let mut number = reference.span;
        let (true, Some(mut span)) = (state.swift, on.path.span(number)) else {
            return self.slow_pair(state, on, position, d, tip, encoder);
        };
        let mut place = span.arc_length(reference.t);
        let mut progress = place - state.place;
        let mut guess = state.tip.foot.t + progress / state.along.speed;
        let same = state.tip.foot.span == number && state.tip.reference.span == number;
        let mut max_lag = self.max_lag;
        if !(same && guess.is_in_unit()) || state.tip.doubt.open {
            let Some(at) = state.cross(&on.path, reference) else {
                // The motion exceeds the limit of spans.
                state.forget();
                return self.slow_pair(state, on, position, d, tip, encoder);
            };
            (number, guess, progress, place) = (at.guess.span, at.guess.t, at.progress, at.place);
            let Some(other) = on.path.span(number) else {
                return self.slow_pair(state, on, position, d, tip, encoder);
            };
            span = other;
            let apart = Apart {
                foot: state.tip.foot.span,
                reference: reference.span,
                were_together: state.tip.foot.span == state.tip.reference.span,
                lag: place - span.arc_length(guess),
                progress,
            };
            if state.tip.doubt.follow(&on.path, &apart, window(progress)) {
                max_lag = Start::never_plain();
            }
            state.tip.foot.span = number;
        }
        (state.place, state.tip.reference) = (place, reference);
        let start = Start { guess, window: window(progress), place, max_lag };
        let seen = feet(span, position, d, &start, tip, encoder, &mut state.along);
        if !seen.plain() {
            let (from, along) = (Reference { span: number, t: guess }, state.along);
            return self.general_pair(state, on, position, d, from, &start, seen, &along, tip, encoder);
        }
        state.tip.foot.t = tip.t;
        (tip.span, encoder.span) = (number, number);
    }
}

/// Start of a cycle in which foot and reference are on two spans, or the guess is beyond the foot's span.
struct Crossed<R> {
    guess: Reference<R>,
    progress: R,
    /// Arc length from the start of the guess's span to the reference.
    place: R,
}

impl<R: Real> PairState<R> {
    /// `None` if the reference has jumped beyond the limit of spans.
    #[inline(never)]
    fn cross<P: Position>(&self, path: &Path<'_, R, P>, reference: Reference<R>) -> Option<Crossed<R>> {
        let foot = self.tip.foot;
        let progress = way(path, self.tip.reference, reference)?;
        let Moved { to: guess, by } = advance(path, foot, progress)?;
        // The lag carries over from cycle to cycle; `place` recomputes it where both are on one span.
        let lag = self.place - path.span(foot.span)?.arc_length(foot.t) + progress - by;
        Some(Crossed { guess, progress, place: place(path, guess, lag, reference)? })
    }

    /// Makes the next search start cold.
    #[inline(always)]
    pub(crate) fn forget(&mut self) {
        (self.tip, self.swift) = (ContourState::default(), false);
    }

    /// Forgets the foot and reports no error measured.
    #[cold]
    fn lose(&mut self, tip: &mut ContourError<R>, encoder: &mut ContourError<R>) {
        self.forget();
        (*tip, *encoder) = (ContourError::none(), ContourError::none());
    }

    /// Stores the start of the next cycle after a search out of line.
    fn keep<P: Position>(
        &mut self,
        method: Method,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
        tangent: &[R; 3],
        lag: R,
    ) {
        self.along.speed = dot(tangent, tangent).root();
        self.swift = self.tip.warm && method == Method::Guarded && self.along.speed > R::ZERO;
        self.place = place(path, self.tip.foot, lag, reference).unwrap_or(R::ZERO);
    }
}

/// Arc length from the start of a foot's span to the reference, which is `lag` ahead of the foot.
#[inline(always)]
fn place<R: Real, P: Position>(
    path: &Path<'_, R, P>,
    foot: Reference<R>,
    lag: R,
    reference: Reference<R>,
) -> Option<R> {
    let span = path.span(foot.span)?;
    Some(if foot.span == reference.span { span.arc_length(reference.t) } else { lag + span.arc_length(foot.t) })
}

#[cfg(test)]
mod tests;
