//! Out-of-line search near borders and corners, without convergence, or with no foot known.
//!
//! After its frame a cycle takes at most two evaluations of the path for both points together. Where they do not reach a foot,
//! the search continues in the next cycle from the best point so far; the error is flagged meanwhile ([`Flags::SEARCHING`]).

use super::frame::{Seen, Start, Tangent, change_of_u, feet, leaves_nothing, local};
use super::{PairState, place};
use crate::contour::kernel::{Evaluation, evaluate, evaluate_end, foot};
use crate::contour::legs::Doubt;
use crate::contour::refine::{Found, descend};
use crate::contour::search::{BISECTIONS, COLD_DESCENTS, COLD_SAMPLES, ContourState, Sample, components};
use crate::contour::span::{Form, OnPath, Reference, Span, dot};
use crate::contour::way::{sight, way, way_far, window};
use crate::contour::{ContourError, ContourSearch, Flags, Method};
use crate::position::Position;
use crate::real::Real;

/// Evaluations of the path that a cycle may take after its frame, for both points together.
const FURTHER: u8 = 2;
/// Consecutive cycles without a foot after which the search starts cold.
const UNSETTLED: u8 = 6;

/// The two points in a cycle, and the evaluations spent on them.
struct Points<'a, 's, R: Real, P> {
    on: &'a OnPath<'s, R, P>,
    position: &'a [P; 3],
    d: &'a [R; 3],
    /// Borders within this arc length are searched, whatever the errors.
    window: R,
    /// How far a search may go, mm of arc length.
    reach: R,
    /// A span near the feet, and the arc length from its start to the reference.
    base: u32,
    place: R,
    doubt: Doubt<R>,
    max_lag: R,
    /// Evaluations for the tip or for both points, and for the encoder alone.
    spent: [u8; 2],
    /// Evaluations left in this cycle.
    left: u8,
    /// Whether the tip's foot was a corner in the last cycle.
    at_corner: bool,
}

/// Both feet, if known.
struct Feet<R> {
    tip: Option<Found<R>>,
    encoder: Option<Found<R>>,
}

/// The far side of a border.
struct Side<'s, R, P> {
    /// The span beyond.
    beyond: u32,
    there: &'s Span<R, P>,
    /// Whether it is entered at its start.
    forward: bool,
}

impl<R: Real, P: Position> Side<'_, R, P> {
    /// Parameter of the border.
    fn entry(&self) -> R {
        if self.forward { R::ZERO } else { R::ONE }
    }

    /// Parameter at an arc length from the border, by two of Newton's steps.
    fn enter(&self, past: R) -> R {
        let (entry, span) = (self.entry(), self.there);
        let t = (entry + past / span.arc_speed(entry)).limit(R::ZERO, R::ONE);
        let left = span.arc_length(entry) + past - span.arc_length(t);
        (t + left / span.arc_speed(t)).limit(R::ZERO, R::ONE)
    }
}

/// An evaluation relative to the tip, and its place.
struct Sampled<'s, R, P> {
    e: Evaluation<R>,
    span: &'s Span<R, P>,
    place: Reference<R>,
}

/// One of Newton's steps from a sample.
struct Step<R> {
    by: R,
    /// Parameter it leads to.
    to: R,
    /// u: half the relative change of the slope.
    u: R,
}

impl<R: Real> Step<R> {
    /// Parameter that a step of second order leads to.
    fn guess(&self) -> R {
        (self.to - self.u * (self.by * self.by)).limit(R::ZERO, R::ONE)
    }
}

impl<R: Real, P: Position> Sampled<'_, R, P> {
    /// The sample itself as the foot of the point that lies `d` behind the tip.
    fn at(&self, d: &[R; 3], flags: Flags) -> Found<R> {
        let mut vector = self.e.vector;
        for (vector, d) in vector.iter_mut().zip(d) {
            *vector += *d;
        }
        Found { place: self.place, vector, tangent: self.e.tangent, width: R::ZERO, flags, downhill: false }
    }

    /// Newton's step to the minimum of that point's distance; `None` if it leads off the span or there is no minimum near.
    fn step(&self, d: &[R; 3]) -> Option<Step<R>> {
        let e = &self.e;
        let curved = dot(d, &e.bend);
        let slope = e.slope + (curved + curved);
        let inverse = R::ONE / slope;
        let by = -((e.g + dot(d, &e.tangent)) * inverse);
        let to = self.place.t + by;
        let u = R::THREE * dot(&e.tangent, &e.bend) * inverse;
        (slope > R::of(0.25) * e.straight && to.is_in_unit()).then_some(Step { by, to, u })
    }

    /// The foot of that point, if one step leads exactly to it.
    #[inline(never)]
    fn exact(&self, d: &[R; 3]) -> Option<Found<R>> {
        let e = &self.e;
        let Step { by, to, u } = self.step(d)?;
        let mut vector = [R::ZERO; 3];
        for (k, vector) in vector.iter_mut().enumerate() {
            *vector = (e.vector[k] + d[k]) + by * (e.tangent[k] + by * e.bend[k]);
        }
        // On a straight span at constant speed nothing is left of the first step.
        let steady = self.span.form() == Form::Cubic && self.span.coefficients[2..4] == [[R::ZERO; 4]; 2];
        let change = if steady { R::ZERO } else { u.abs() + change_of_u() };
        let error = dot(&vector, &vector).root();
        if !(dot(&e.bend, &e.bend) < R::of(4.0) * e.straight && leaves_nothing(by, error, change, e.straight)) {
            return None;
        }
        let tangent = core::array::from_fn(|k| e.tangent[k] + R::TWO * (by * e.bend[k]));
        let place = Reference { t: to, ..self.place };
        Some(Found { place, vector, tangent, width: R::ZERO, flags: Flags::BRACKETED, downhill: false })
    }
}

/// Whether the distance of the point that lies `d` behind the tip grows in the given direction.
fn rises<R: Real>(e: &Evaluation<R>, d: &[R; 3], forward: bool) -> bool {
    let g = e.g + dot(d, &e.tangent);
    if forward { g >= R::ZERO } else { g <= R::ZERO }
}

impl<R: Real> ContourSearch<R> {
    /// Continues where a test of the plain case has failed: near or beyond a border, at a second minimum, on an upright path,
    /// or with the foot left behind.
    #[inline(never)]
    pub(super) fn general_pair<P: Position>(
        &self,
        state: &mut PairState<R>,
        on: &OnPath<'_, R, P>,
        position: &[P; 3],
        d: &[R; 3],
        guess: Reference<R>,
        start: &Start<R>,
        seen: Seen,
        along: &Tangent<R>,
        tip: &mut ContourError<R>,
        encoder: &mut ContourError<R>,
    ) {
        let spent = [2, u8::from(seen.tip())];
        let Start { window, place, .. } = *start;
        let mut points = Points {
            on,
            position,
            d,
            window,
            reach: window,
            base: guess.span,
            place,
            doubt: state.tip.doubt,
            max_lag: self.max_lag,
            spent,
            left: FURTHER,
            at_corner: state.at_corner,
        };
        let mut feet = Feet { tip: None, encoder: None };
        points.resolve(&mut feet, guess, seen, along, tip, encoder);
        let Feet { tip: Some(at_tip), encoder: Some(at_encoder) } = &feet else {
            return state.lose(tip, encoder);
        };
        // Where the evaluations ran out on the way downhill, the next cycle continues from there.
        let bracketed = at_tip.flags.has(Flags::BRACKETED);
        state.unsettled = if bracketed { 0 } else { state.unsettled.saturating_add(1) };
        if state.unsettled > UNSETTLED || points.doubt.is_lost() {
            state.unsettled = 0;
            state.tip.warm = false;
            state.tip.looked = 0;
        }
        self.report_pair(state, on.reference, &points, at_tip, at_encoder, tip, encoder);
    }

    /// Searches with no foot known, with a foot without a speed, or by plain bisection.
    #[cold]
    #[inline(never)]
    pub(super) fn slow_pair<P: Position>(
        &self,
        state: &mut PairState<R>,
        on: &OnPath<'_, R, P>,
        position: &[P; 3],
        d: &[R; 3],
        tip: &mut ContourError<R>,
        encoder: &mut ContourError<R>,
    ) {
        let reference = on.reference;
        if on.path.span(reference.span).is_none() {
            return state.lose(tip, encoder);
        }
        if self.method == Method::Guarded && state.tip.warm {
            if let Some(at) = state.cross(&on.path, reference) {
                let (guess, none) = (at.guess, Tangent::NONE);
                let start =
                    Start { guess: guess.t, window: window(at.progress), place: at.place, max_lag: self.max_lag };
                return self.general_pair(state, on, position, d, guess, &start, Seen::NOTHING, &none, tip, encoder);
            }
            state.forget();
        }
        if self.is_sampling(&mut state.tip, &on.path, reference, |span| local(span, position, d)) {
            (*tip, *encoder) = (ContourError::searching(), ContourError::searching());
            state.swift = false;
            return;
        }
        let mut points = Points {
            on,
            position,
            d,
            window: window(R::ZERO),
            reach: self.max_lag,
            base: reference.span,
            place: R::ZERO,
            doubt: Doubt::none(),
            max_lag: self.max_lag,
            spent: [0; 2],
            left: FURTHER,
            at_corner: false,
        };
        let found = match self.method {
            Method::Guarded => self.cold_pair(&mut state.tip, &mut points, reference, tip, encoder),
            // Only with bisection.
            Method::Bisection => {
                let [x, y, z] = position;
                let point = [x.plus(d[0]), y.plus(d[1]), z.plus(d[2])];
                let at_tip = self.seek(&mut state.tip, &on.path, reference, &point, &mut points.spent[0]);
                at_tip.map(|at_tip| (at_tip, points.by_halves(&at_tip, reference)))
            }
        };
        let Some((at_tip, mut at_encoder)) = found else { return state.lose(tip, encoder) };
        if at_tip.flags.has(Flags::COLD) {
            at_encoder.flags = at_encoder.flags.and(Flags::COLD);
        }
        self.report_pair(state, reference, &points, &at_tip, &at_encoder, tip, encoder);
    }

    /// Finds both feet from the nearest sample.
    fn cold_pair<P: Position>(
        &self,
        state: &mut ContourState<R>,
        points: &mut Points<'_, '_, R, P>,
        reference: Reference<R>,
        tip: &mut ContourError<R>,
        encoder: &mut ContourError<R>,
    ) -> Option<(Found<R>, Found<R>)> {
        let path = &points.on.path;
        let guess = path.moving(state.best.at);
        (points.base, points.place) = (guess.span, place(path, guess, state.best.lag, reference)?);
        let mut along = Tangent::NONE;
        let start = Start { guess: guess.t, window: self.max_lag, place: R::ZERO, max_lag: Start::never_plain() };
        let seen = feet(path.span(guess.span)?, points.position, points.d, &start, tip, encoder, &mut along);
        points.spent = [2, u8::from(seen.tip())];
        let mut feet = Feet { tip: None, encoder: None };
        points.resolve(&mut feet, guess, seen, &along, tip, encoder);
        let mut at_tip = feet.tip?;
        state.looked = state.looked.saturating_add(1);
        if at_tip.flags.has(Flags::BRACKETED) || state.looked >= COLD_SAMPLES + COLD_DESCENTS {
            // The search either has the foot or starts over.
            state.warm = at_tip.flags.has(Flags::BRACKETED);
            state.looked = 0;
        } else {
            state.best = Sample { at: at_tip.place, lag: points.lag(at_tip.place) };
        }
        at_tip.flags = at_tip.flags.and(Flags::COLD);
        Some((at_tip, feet.encoder?))
    }

    fn report_pair<P: Position>(
        &self,
        state: &mut PairState<R>,
        reference: Reference<R>,
        points: &Points<'_, '_, R, P>,
        at_tip: &Found<R>,
        at_encoder: &Found<R>,
        tip: &mut ContourError<R>,
        encoder: &mut ContourError<R>,
    ) {
        let [for_tip, for_encoder] = points.spent;
        let lag = points.lag(at_tip.place);
        (state.tip.foot, state.tip.reference, state.tip.doubt) = (at_tip.place, reference, points.doubt);
        if state.tip.warm && lag.abs() > self.max_lag {
            // The foot has stayed behind: start a cold search.
            state.tip.warm = false;
            state.tip.looked = 0;
        }
        state.keep(self.method, &points.on.path, reference, &at_tip.tangent, lag);
        state.at_corner = at_tip.flags.has(Flags::AT_CORNER);
        // Both feet usually lie on one span.
        let behind = match points.on.path.span(at_tip.place.span) {
            Some(span) if at_encoder.place.span == at_tip.place.span => {
                lag + (span.arc_length(at_tip.place.t) - span.arc_length(at_encoder.place.t))
            }
            _ => points.lag(at_encoder.place),
        };
        // At most 2 rounds.
        for (foot, found, lag, spent) in [(tip, at_tip, lag, for_tip), (encoder, at_encoder, behind, for_encoder)] {
            let error = dot(&found.vector, &found.vector).root();
            *foot = components(&points.on.path, found, error, lag, spent);
            foot.flags = foot.flags.and(points.doubt.flags());
            if !found.flags.has(Flags::BRACKETED) {
                foot.flags = foot.flags.and(Flags::SEARCHING);
            }
        }
    }
}

impl<R: Real> Feet<R> {
    /// Takes the feet of one frame, if they lie on its span.
    #[inline(always)]
    fn take(&mut self, span: u32, seen: Seen, along: &Tangent<R>, tip: &ContourError<R>, encoder: &ContourError<R>) {
        let found = |foot: &ContourError<R>| {
            let vector: [R; 3] = foot.vector.into();
            Found {
                place: Reference { span, t: foot.t },
                vector: vector.map(|x| -x),
                tangent: along.tangent,
                width: R::ZERO,
                flags: Flags::BRACKETED,
                downhill: false,
            }
        };
        if seen.tip() && tip.t.is_in_unit() {
            self.tip = Some(found(tip));
        }
        if seen.encoder() && encoder.t.is_in_unit() {
            self.encoder = Some(found(encoder));
        }
    }
}

/// Keeps the nearer of two minima, and flags it if both exist.
fn keep_nearer<R: Real>(kept: &mut Option<Found<R>>, other: &Option<Found<R>>) {
    let Some(other) = other else { return };
    let Some(one) = kept else {
        *kept = Some(*other);
        return;
    };
    if dot(&one.vector, &one.vector) > dot(&other.vector, &other.vector) {
        *one = *other;
    }
    one.flags = one.flags.and(Flags::SECOND_MINIMUM);
}

impl<R: Real, P: Position> Points<'_, '_, R, P> {
    /// Arc length from a foot to the reference.
    fn lag(&self, foot: Reference<R>) -> R {
        let base = Reference { span: self.base, t: R::ZERO };
        way(&self.on.path, base, foot).map_or(self.max_lag + self.max_lag, |way| self.place - way)
    }

    /// Finds both feet, starting from those of the frame; they stay `None` without a path.
    fn resolve(
        &mut self,
        feet: &mut Feet<R>,
        guess: Reference<R>,
        seen: Seen,
        along: &Tangent<R>,
        tip: &ContourError<R>,
        encoder: &ContourError<R>,
    ) {
        // A foot beyond the border counts as lying on it.
        let near = (tip.t.limit(R::ZERO, R::ONE) - guess.t).abs() * along.speed <= self.reach;
        if seen.tip() && near {
            feet.take(guess.span, seen, along, tip, encoder);
            if feet.tip.is_none() || !self.search_other_leg(feet) {
                self.look_beyond(feet, guess.span, seen, tip, encoder);
            }
        }
        if feet.tip.is_none() {
            feet.tip = self.descend_from(guess);
        }
        if let (Some(at_tip), None) = (&feet.tip, &feet.encoder) {
            let guess = Reference { span: guess.span, t: encoder.t };
            let known = seen.tip() && near && !seen.encoder() && at_tip.place.span == guess.span;
            feet.encoder = Some(self.encoder_from(at_tip, if known { guess } else { at_tip.place }));
        }
    }

    /// Searches the leg beside the tip's foot, if any: keeps the intended foot of the two, with the encoder's foot on
    /// the same leg.
    fn search_other_leg(&mut self, found: &mut Feet<R>) -> bool {
        let (true, Some(at_tip)) = (self.doubt.open, &found.tip) else { return false };
        let (position, d) = (self.position, self.d);
        let tip = |span: &Span<R, P>| local(span, position, d);
        let mut spent = 0;
        let meant = self.doubt.resolve(self.on, self.window, self.max_lag, at_tip, tip, &mut spent);
        self.spent[0] += spent;
        self.left = self.left.saturating_sub(spent);
        let Some(meant) = meant else { return false };
        if meant.place.span != at_tip.place.span {
            found.encoder = None;
        }
        found.tip = Some(meant);
        true
    }

    /// Searches behind the border if it is in sight, and takes the border itself where neither side has a minimum.
    fn look_beyond(
        &mut self,
        found: &mut Feet<R>,
        number: u32,
        seen: Seen,
        tip: &ContourError<R>,
        encoder: &ContourError<R>,
    ) {
        let path = &self.on.path;
        let Some(span) = path.span(number) else { return };
        let (place, other, length) = (span.arc_length(tip.t), span.arc_length(encoder.t), span.length());
        let forward = place + place > length;
        let rest = if forward { length - place.max(other) } else { place.min(other) };
        if rest > sight(self.window, tip.error.max(encoder.error)) || self.left < FURTHER {
            return;
        }
        let outside = [found.tip.is_none(), found.encoder.is_none() && seen.encoder()];
        let border = if forward { path.next(number) } else { path.previous(number) };
        let Some((beyond, there)) = border.and_then(|beyond| Some((beyond, path.span(beyond)?))) else {
            return self.take_end(found, number, forward, outside);
        };
        let past = |place: R| if forward { place - length } else { place };
        let side = Side { beyond, there, forward };
        if outside[0] && !self.at_corner && self.cross_smoothly(found, &side, [past(place), past(other)], outside[1]) {
            return;
        }
        self.look_from_border(found, &side, past(other), outside);
    }

    /// Finds the feet beyond a border that the path crosses smoothly: there the frame of one side says exactly enough where
    /// they lie on the other. `past`: arc lengths of tip and encoder from the border.
    fn cross_smoothly(&mut self, found: &mut Feet<R>, side: &Side<'_, R, P>, past: [R; 2], encoder: bool) -> bool {
        let [to_tip, to_encoder] = past;
        let at_tip = self.evaluate(side, side.enter(to_tip));
        let still = [R::ZERO; 3];
        found.tip = at_tip.exact(&still);
        if found.tip.is_some() && encoder {
            found.encoder = self.evaluate(side, side.enter(to_encoder)).exact(self.d);
        }
        if found.tip.is_none() && at_tip.place.t == R::ONE - side.entry() && !rises(&at_tip.e, &still, side.forward) {
            // It lies beyond this span too.
            found.tip = Some(at_tip.at(&still, Flags::default()));
        }
        found.tip.is_some()
    }

    /// Searches beyond a border from the border itself: a corner, or a second minimum behind it.
    fn look_from_border(&mut self, found: &mut Feet<R>, side: &Side<'_, R, P>, past: R, outside: [bool; 2]) {
        let entered = self.enter(side);
        let still = [R::ZERO; 3];
        let uphill = [&still, self.d].map(|d| rises(&entered.e, d, side.forward));
        let corner = |d: &[R; 3]| entered.at(d, Flags::BRACKETED.and(Flags::AT_CORNER));
        if outside[0] && uphill[0] {
            found.tip = Some(corner(&still));
        }
        if outside[1] && uphill[1] {
            found.encoder = Some(corner(self.d));
        }
        if !uphill[0] {
            self.look_inside(found, side, &entered, outside[0]);
        } else if !uphill[1] && self.left > 0 {
            let guess = entered.step(self.d).map_or_else(|| side.enter(past), |step| step.guess());
            let other = self.evaluate(side, guess).exact(self.d);
            keep_nearer(&mut found.encoder, &other);
        }
    }

    /// The tip's foot on the span beyond a border, if the distance falls into it: the only one, or a second minimum.
    fn look_inside(&mut self, found: &mut Feet<R>, side: &Side<'_, R, P>, entered: &Sampled<'_, R, P>, outside: bool) {
        let still = [R::ZERO; 3];
        let (mut near, mut second) = (entered.at(&still, Flags::default()), None);
        if let (Some(step), true) = (entered.step(&still), self.left > 0) {
            let sampled = self.evaluate(side, step.guess());
            match sampled.exact(&still) {
                Some(tip) => second = Some(Feet { tip: Some(tip), encoder: sampled.exact(self.d) }),
                None => near = sampled.at(&still, Flags::default()),
            }
        }
        match second {
            Some(second) => self.keep_meant(found, &second, side.forward),
            None if outside => found.tip = Some(near),
            None => {
                let Some(one) = &mut found.tip else { return };
                one.flags = one.flags.and(Flags::SECOND_MINIMUM);
            }
        }
    }

    /// Keeps the nearer feet from both sides of a border, or those of the intended leg.
    fn keep_meant(&mut self, found: &mut Feet<R>, second: &Feet<R>, forward: bool) {
        let meant = match (&found.tip, &second.tip) {
            (Some(one), Some(other)) => self.doubt.at_border(self.on, self.window, self.max_lag, (one, other), forward),
            _ => None,
        };
        match meant {
            Some(meant) => {
                if found.tip.is_some_and(|one| one.place != meant.place) {
                    found.encoder = second.encoder;
                }
                found.tip = Some(meant);
            }
            None => {
                keep_nearer(&mut found.tip, &second.tip);
                keep_nearer(&mut found.encoder, &second.encoder);
            }
        }
    }

    /// Takes the end of an open path for the points whose foot lies beyond it.
    fn take_end(&mut self, found: &mut Feet<R>, number: u32, forward: bool, [tip, encoder]: [bool; 2]) {
        let (true, Some(there)) = (tip || encoder, self.on.path.span(number)) else { return };
        // Entered backwards, a span begins at its end.
        let end = self.enter(&Side { beyond: number, there, forward: !forward });
        let at_end = Flags::BRACKETED.and(Flags::AT_END);
        if tip {
            found.tip = Some(end.at(&[R::ZERO; 3], at_end));
        }
        if encoder {
            found.encoder = Some(end.at(self.d, at_end));
        }
    }

    /// Evaluates the span beyond a border at `t`, relative to the tip.
    fn evaluate<'s>(&mut self, side: &Side<'s, R, P>, t: R) -> Sampled<'s, R, P> {
        (self.spent[0], self.left) = (self.spent[0] + 1, self.left.saturating_sub(1));
        let e = evaluate(side.there, &local(side.there, self.position, self.d), t);
        Sampled { e, span: side.there, place: Reference { span: side.beyond, t } }
    }

    /// Evaluates it at the border.
    fn enter<'s>(&mut self, side: &Side<'s, R, P>) -> Sampled<'s, R, P> {
        (self.spent[0], self.left) = (self.spent[0] + 1, self.left.saturating_sub(1));
        let e = evaluate_end(side.there, &local(side.there, self.position, self.d), side.forward);
        Sampled { e, span: side.there, place: Reference { span: side.beyond, t: side.entry() } }
    }

    /// Descends to the tip's foot with the evaluations that are left.
    fn descend_from(&mut self, from: Reference<R>) -> Option<Found<R>> {
        let ([x, y, z], [dx, dy, dz]) = (self.position, self.d);
        let point = [x.plus(*dx), y.plus(*dy), z.plus(*dz)];
        let mut spent = 0;
        let found = descend(&self.on.path, from, &point, self.reach, false, self.left.max(1), &mut spent);
        self.spent[0] += spent;
        self.left = self.left.saturating_sub(spent);
        found
    }

    /// The encoder's foot from a guess, by the kernel or Newton's step; failing that, the tip's foot itself, not bracketed.
    fn encoder_from(&mut self, tip: &Found<R>, guess: Reference<R>) -> Found<R> {
        let found = self.on.path.span(guess.span).and_then(|there| {
            if self.left < FURTHER {
                let side = Side { beyond: guess.span, there, forward: true };
                return (self.left > 0).then(|| self.evaluate(&side, guess.t.limit(R::ZERO, R::ONE)))?.exact(self.d);
            }
            (self.spent[1], self.left) = (self.spent[1] + 2, 0);
            let near = foot(there, &there.relative(self.position), guess.t);
            near.trusted.then(|| Found::of(guess.span, &near))
        });
        found.unwrap_or_else(|| self.encoder_at_tip_foot(tip))
    }

    /// The encoder's error, measured at the tip's foot.
    fn encoder_at_tip_foot(&self, tip: &Found<R>) -> Found<R> {
        let mut vector = tip.vector;
        for k in 0..3 {
            vector[k] += self.d[k];
        }
        let width = dot(self.d, self.d).root();
        Found { vector, width, flags: Flags::default(), downhill: true, ..*tip }
    }

    /// The encoder's foot by plain bisection, starting at the tip's foot.
    fn by_halves(&mut self, tip: &Found<R>, reference: Reference<R>) -> Found<R> {
        let base = Reference { span: tip.place.span, t: R::ZERO };
        (self.base, self.place) = (base.span, way_far(&self.on.path, base, reference, self.reach));
        let by_halves =
            descend(&self.on.path, tip.place, self.position, self.reach, true, BISECTIONS, &mut self.spent[1]);
        by_halves.unwrap_or_else(|| self.encoder_at_tip_foot(tip))
    }
}
