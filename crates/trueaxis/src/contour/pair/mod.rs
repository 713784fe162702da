//! Contour errors of the estimated tip and of the plain encoder position together.
//!
//! The two lie apart by the tip's modelled error, some micrometres, so that one guess and one shifted frame serve both
//! ([`frame`]). One foot is followed from cycle to cycle, the tip's; the encoder's is the minimum of its distance that
//! lies downhill from there. In a hairpin, where the nearest leg may be another for each, both are therefore on
//! the same one.
//!
//! A cycle's plain case is computed straight: everything is tested, then written. What is not plain goes out of line at
//! once ([`beside`]).

mod beside;
mod frame;

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
    /// The foot can be followed.
    swift: bool,
}

impl<R: Real> ContourSearch<R> {
    /// Contour errors of an encoder position (mm) and of the tip, which is `d` (mm) from it, in this cycle; both are written.
    ///
    /// The tip's is what [`ContourSearch::update`] gives, without rounding it to a position. The encoder's is
    /// the minimum of its distance that lies downhill from the tip's foot, and its distance is as exact: 1e-6 nm in
    /// doubles, 2 nm in single precision. In the plain case both vectors are split in the frame of the tip's foot, in
    /// which the encoder's components are exact on plane paths and on helices about the plane's normal. Elsewhere its
    /// binormal one is off by up to cot α · κ|d| of itself, κ the curvature and α the angle between path and normal,
    /// and the normal one is what then remains of the distance.
    ///
    /// At most eight evaluations of the path for both; what serves both counts for the tip. If they are used up before
    /// the encoder's foot is found, its error is counted from the tip's, `width` is |d| and [`Flags::BRACKETED`] is
    /// missing. A reference off its span: as in [`ContourSearch::update`]. Cost: the kernel's twice and a half, as a rule.
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

    /// The reference is off its span.
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

    /// The reference is on its span.
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
            return self.pair_anew(state, on, position, d, tip, encoder);
        };
        let mut place = span.arc_length(reference.t);
        let mut progress = place - state.place;
        let mut guess = state.tip.foot.t + progress / state.along.speed;
        let same = state.tip.foot.span == number && state.tip.reference.span == number;
        let mut max_lag = self.max_lag;
        if !(same && guess.is_in_unit()) || state.tip.doubt.open {
            let Some(at) = state.cross(&on.path, reference) else {
                // Out of sight.
                state.forget();
                return self.pair_anew(state, on, position, d, tip, encoder);
            };
            (number, guess, progress, place) = (at.guess.span, at.guess.t, at.progress, at.place);
            let Some(other) = on.path.span(number) else {
                return self.pair_anew(state, on, position, d, tip, encoder);
            };
            span = other;
            let apart = Apart {
                foot: state.tip.foot.span,
                reference: reference.span,
                anew: state.tip.foot.span == state.tip.reference.span,
                lag: place - span.arc_length(guess),
                progress,
            };
            if state.tip.doubt.follow(&on.path, &apart, window(progress)) {
                // No lag is so small: never plain.
                max_lag = -R::ONE;
            }
            state.tip.foot.span = number;
        }
        (state.place, state.tip.reference) = (place, reference);
        let start = Start { guess, window: window(progress), place, max_lag };
        let seen = feet(span, position, d, start, tip, encoder, &mut state.along);
        if !seen.plain() {
            let (from, along) = (Reference { span: number, t: guess }, state.along);
            return self.beside_pair(state, on, position, d, from, start, seen, &along, tip, encoder);
        }
        state.tip.foot.t = tip.t;
        (tip.span, encoder.span) = (number, number);
    }
}

/// Where a cycle starts whose foot and reference are on two spans, or whose guess is beyond the foot's.
struct Crossed<R> {
    guess: Reference<R>,
    progress: R,
    /// Arc length from the start of the guess's span to the reference.
    place: R,
}

impl<R: Real> PairState<R> {
    /// None where the reference has leaped out of sight.
    #[inline(never)]
    fn cross<P: Position>(&self, path: &Path<'_, R, P>, reference: Reference<R>) -> Option<Crossed<R>> {
        let foot = self.tip.foot;
        let progress = way(path, self.tip.reference, reference)?;
        let Moved { to: guess, by } = advance(path, foot, progress)?;
        // The distance goes on from cycle to cycle, and is taken anew where there is only one span to look at.
        let lag = self.place - path.span(foot.span)?.arc_length(foot.t) + progress - by;
        Some(Crossed { guess, progress, place: place(path, guess, lag, reference)? })
    }

    /// The next search starts cold.
    #[inline(always)]
    pub(crate) fn forget(&mut self) {
        (self.tip, self.swift) = (ContourState::default(), false);
    }

    /// Nothing is measured.
    #[cold]
    fn lose(&mut self, tip: &mut ContourError<R>, encoder: &mut ContourError<R>) {
        self.forget();
        (*tip, *encoder) = (ContourError::none(), ContourError::none());
    }

    /// What the next cycle starts from, after a search out of line.
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

/// Arc length from the start of a foot's span to the reference, which is `lag` ahead of it.
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
