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

use super::search::{ContourSearch, ContourState, Method, advance, way, window};
use super::span::{OnPath, Path, Reference, dot};
use super::{ContourError, Flags};
use crate::position::Position;
use crate::real::Real;
use frame::{Start, Tangent, feet};

/// State of the search for both feet from cycle to cycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairState<R> {
    tip: ContourState<R>,
    /// Arc length from the start of the foot's span to the reference, where they share one.
    place: R,
    /// The path's derivative at the foot.
    along: Tangent<R>,
    /// The foot can be followed.
    swift: bool,
}

impl<R: Real> ContourSearch<R> {
    /// Contour errors of an encoder position (mm) and of the tip, which is `d` (mm) from it, in this cycle.
    ///
    /// The tip's is what [`ContourSearch::update`] gives, without rounding it to a position. The encoder's is
    /// the minimum of its distance that lies downhill from the tip's foot; its components are split at the tip's foot:
    /// exact on plane paths and on helices about the plane's normal, elsewhere off by up to cot α · κ|d| of the binormal
    /// one, κ the curvature and α the angle between path and normal.
    ///
    /// At most eight evaluations of the path for both (a shared one counts for the tip). If they run out before the
    /// encoder's foot is found, its error is counted from the tip's foot, and the flag [`Flags::BRACKETED`] is missing. Cost: the
    /// kernel 1.4 times, as a rule.
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
    #[inline(never)]
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
        if !(same && guess.is_in_unit()) {
            let at = self.cross(&on.path, &state.tip, reference);
            (number, guess, progress, place) = (at.0.span, at.0.t, at.1, at.2);
            let Some(other) = on.path.span(number) else {
                return self.pair_anew(state, on, position, d, tip, encoder);
            };
            span = other;
            state.tip.foot.span = number;
        }
        (state.place, state.tip.reference) = (place, reference);
        let start = Start { guess, window: window(progress), place, max_lag: self.max_lag };
        let seen = feet(span, position, d, start, tip, encoder, &mut state.along);
        if !seen.plain() {
            let (from, along) = (Reference { span: number, t: guess }, state.along);
            return self.beside_pair(state, on, position, d, from, start.window, seen, &along, tip, encoder);
        }
        state.tip.foot.t = tip.t;
        (tip.span, encoder.span) = (number, number);
    }

    /// Foot and reference are on two spans, or the guess is beyond the foot's: the guess, the progress of the reference, and
    /// its arc length from the start of the guess's span.
    #[inline(never)]
    fn cross<P: Position>(
        &self,
        path: &Path<'_, R, P>,
        tip: &ContourState<R>,
        reference: Reference<R>,
    ) -> (Reference<R>, R, R) {
        let progress = way(path, tip.reference, reference, self.max_lag);
        let guess = advance(path, tip.foot, progress);
        let from = Reference { span: guess.span, t: R::ZERO };
        let place = way(path, from, reference, self.max_lag + self.max_lag);
        (guess, progress, place)
    }
}

impl<R: Real> PairState<R> {
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
    fn keep<P: Position>(&mut self, method: Method, path: &Path<'_, R, P>, tangent: &[R; 3]) {
        self.along.speed = dot(tangent, tangent).root();
        self.swift = self.tip.warm && method == Method::Guarded && self.along.speed > R::ZERO;
        let Reference { span, t } = self.tip.reference;
        self.place = path.span(span).map_or(R::ZERO, |span| span.arc_length(t));
    }
}

#[cfg(test)]
mod tests;
