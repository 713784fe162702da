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

use super::search::{ContourSearch, ContourState, Method, advance, sight, way, window};
use super::span::{OnPath, Path, Reference, Span, dot};
use super::{ContourError, Flags};
use crate::position::Position;
use crate::real::Real;
use frame::{Tangent, feet};

/// State of the search for both feet from cycle to cycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairState<R> {
    tip: ContourState<R>,
    /// Arc length from the start of the foot's span to the reference, where they share one.
    place: R,
    /// |dP/dt| at the foot, mm.
    speed: R,
    /// The foot can be followed.
    swift: bool,
}

/// Where a cycle's search starts.
#[derive(Clone, Copy, Debug)]
struct Start<R> {
    span: u32,
    guess: R,
    /// Of the reference, since the last cycle.
    progress: R,
    /// Arc length from the start of the span to the reference.
    place: R,
}

/// A path's normal b × T of less than this times |T|², squared, points nowhere: the path runs along the plane's normal.
const UPRIGHT: f64 = 0.01;

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
    #[inline(never)]
    pub fn update_pair<P: Position>(
        &self,
        state: &mut PairState<R>,
        on: &OnPath<'_, R, P>,
        position: &[P; 3],
        d: &[R; 3],
        tip: &mut ContourError<R>,
        encoder: &mut ContourError<R>,
    ) {
        let reference = on.reference;
        let mut start = match (state.swift && reference.is_on_its_span(), on.path.span(reference.span)) {
            (true, Some(span)) => {
                let place = span.arc_length(reference.t);
                let progress = place - state.place;
                Start { span: reference.span, guess: state.tip.foot.t + progress / state.speed, progress, place }
            }
            _ => return self.pair_anew(state, on, position, d, tip, encoder),
        };
        let same = state.tip.foot.span == reference.span && state.tip.reference.span == reference.span;
        if !(same && start.guess.is_in_unit()) {
            start = self.cross(&on.path, &state.tip, reference);
        }
        let Start { span: number, guess, progress, place } = start;
        let Some(span) = on.path.span(number) else {
            return self.pair_anew(state, on, position, d, tip, encoder);
        };
        let mut along = Tangent::NONE;
        let converged = feet(span, position, d, guess, tip, encoder, &mut along);
        let window = window(progress);
        let (foot, other) = (span.arc_length(tip.t), span.arc_length(encoder.t));
        let lag = place - foot;
        let half = R::HALF * span.length();
        let room = half - sight(window, tip.error.max(encoder.error));
        let frame = Frame::at(&span.plane, &along);
        let plain = converged.encoder
            && (foot - half).abs() < room
            && (other - half).abs() < room
            && tip.t.is_in_unit()
            && encoder.t.is_in_unit()
            && (tip.t - guess).abs() * along.speed <= window
            && lag.abs() <= self.max_lag
            && frame.nn > R::of(UPRIGHT) * along.squared;
        if !plain {
            return self.beside_pair(state, on, position, d, &start, converged, &along, tip, encoder);
        }
        (state.place, state.speed) = (place, along.speed);
        (state.tip.foot, state.tip.reference) = (Reference { span: number, t: tip.t }, reference);
        frame.split(span, &along, number, lag, place - other, tip, encoder);
    }

    /// Foot and reference are on two spans, or the guess is beyond the foot's.
    #[inline(never)]
    fn cross<P: Position>(&self, path: &Path<'_, R, P>, tip: &ContourState<R>, reference: Reference<R>) -> Start<R> {
        let progress = way(path, tip.reference, reference, self.max_lag);
        let guess = advance(path, tip.foot, progress);
        let from = Reference { span: guess.span, t: R::ZERO };
        let place = way(path, from, reference, self.max_lag + self.max_lag);
        Start { span: guess.span, guess: guess.t, progress, place }
    }
}

/// The frame at the tip's foot in which both vectors are split.
struct Frame<R> {
    /// b × T, not of unit length, and its length squared.
    n: [R; 3],
    nn: R,
}

impl<R: Real> Frame<R> {
    #[inline(always)]
    fn at(b: &[R; 3], along: &Tangent<R>) -> Self {
        let t = &along.tangent;
        let n = [b[1] * t[2] - b[2] * t[1], b[2] * t[0] - b[0] * t[2], b[0] * t[1] - b[1] * t[0]];
        Frame { n, nn: dot(&n, &n) }
    }

    /// Writes what [`feet`] has not: with e at right angles to T, e·(T × n)/|T||n| = (e·b)|T|/|n|.
    #[inline(always)]
    fn split<P: Position>(
        &self,
        span: &Span<R, P>,
        along: &Tangent<R>,
        number: u32,
        lag: R,
        behind: R,
        tip: &mut ContourError<R>,
        encoder: &mut ContourError<R>,
    ) {
        let inverse = R::ONE / self.nn.sqrt();
        let stretch = along.speed * inverse;
        let e: [R; 3] = tip.vector.into();
        tip.normal = dot(&e, &self.n) * inverse;
        tip.binormal = dot(&e, &span.plane) * stretch;
        let e: [R; 3] = encoder.vector.into();
        // The path has turned a little on the way to the encoder's foot: what is not out of the plane is in it.
        let binormal = dot(&e, &span.plane) * stretch;
        let normal = (encoder.error * encoder.error - binormal * binormal).sqrt();
        encoder.binormal = binormal;
        encoder.normal = if dot(&e, &self.n) < R::ZERO { -normal } else { normal };
        (tip.lag, encoder.lag) = (lag, behind);
        for (foot, evaluations) in [(tip, 2), (encoder, 1)] {
            foot.span = number;
            (foot.tangential, foot.width) = (R::ZERO, R::ZERO);
            (foot.evaluations, foot.flags) = (evaluations, Flags::BRACKETED);
        }
    }
}

impl<R: Real> PairState<R> {
    /// The next search starts cold.
    #[inline(always)]
    pub(crate) fn forget(&mut self) {
        (self.tip, self.swift) = (ContourState::default(), false);
    }

    /// What the next cycle starts from, after a search out of line.
    fn keep<P: Position>(&mut self, method: Method, path: &Path<'_, R, P>, tangent: &[R; 3]) {
        self.speed = dot(tangent, tangent).sqrt();
        self.swift = self.tip.warm && method == Method::Guarded && self.speed > R::ZERO;
        let Reference { span, t } = self.tip.reference;
        self.place = path.span(span).map_or(R::ZERO, |span| span.arc_length(t));
    }
}
