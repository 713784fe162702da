//! Out-of-line search near borders and corners, without convergence, or with no foot known. Both points share one budget of
//! evaluations.

use super::frame::{Seen, Start, Tangent, feet, local};
use super::{PairState, place};
use crate::contour::kernel::{Evaluation, evaluate_end, foot};
use crate::contour::legs::Doubt;
use crate::contour::refine::{Found, at, descend};
use crate::contour::search::{BISECTIONS, ContourState, across, components};
use crate::contour::span::{OnPath, Reference, Span, dot};
use crate::contour::way::{sight, way, way_far, window};
use crate::contour::{ContourError, ContourSearch, Flags, Method};
use crate::position::Position;
use crate::real::Real;

/// Most evaluations of the path for both points together.
const BOTH: u8 = 8;
/// Evaluations needed to search behind a border.
const BEYOND: u8 = 5;
/// Evaluations for the tip's own descent if the first frame did not converge: the rest are for the encoder's kernel.
const DESCENT: u8 = 3;

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
}

/// Both feet, if known.
struct Feet<R> {
    tip: Option<Found<R>>,
    encoder: Option<Found<R>>,
}

/// Where the search for each missing foot continues.
struct From<R> {
    tip: Reference<R>,
    /// `None`: from the tip's foot.
    encoder: Option<Reference<R>>,
}

/// Parameters of a border on its span and on the span beyond it.
fn sides<R: Real>(forward: bool) -> [R; 2] {
    if forward { [R::ONE, R::ZERO] } else { [R::ZERO, R::ONE] }
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
        };
        let mut feet = Feet { tip: None, encoder: None };
        points.resolve(&mut feet, guess, seen, along, tip, encoder);
        let Feet { tip: Some(at_tip), encoder: Some(at_encoder) } = &feet else {
            return state.lose(tip, encoder);
        };
        // On short spans at high feed the evaluations may run out just past a border: the next cycle continues from there.
        if !(at_tip.flags.has(Flags::BRACKETED) || at_tip.downhill) || points.doubt.is_lost() {
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
        let [x, y, z] = position;
        let point = [x.plus(d[0]), y.plus(d[1]), z.plus(d[2])];
        let reach = self.max_lag;
        let mut points = Points {
            on,
            position,
            d,
            window: window(R::ZERO),
            reach,
            base: reference.span,
            place: R::ZERO,
            doubt: Doubt::none(),
            max_lag: self.max_lag,
            spent: [0; 2],
        };
        let found = match self.method {
            Method::Guarded => self.cold_pair(&mut state.tip, &mut points, reference, &point, tip, encoder),
            // Only with bisection.
            Method::Bisection => self
                .seek(&mut state.tip, &on.path, reference, &point, &mut points.spent[0])
                .map(|at_tip| (at_tip, points.by_halves(&at_tip, reference))),
        };
        let Some((at_tip, mut at_encoder)) = found else { return state.lose(tip, encoder) };
        if at_tip.flags.has(Flags::COLD) {
            at_encoder.flags = at_encoder.flags.and(Flags::COLD);
        }
        self.report_pair(state, reference, &points, &at_tip, &at_encoder, tip, encoder);
    }

    /// Takes a few samples around the reference and finds both feet from the nearest sample so far.
    fn cold_pair<P: Position>(
        &self,
        state: &mut ContourState<R>,
        points: &mut Points<'_, '_, R, P>,
        reference: Reference<R>,
        point: &[P; 3],
        tip: &mut ContourError<R>,
        encoder: &mut ContourError<R>,
    ) -> Option<(Found<R>, Found<R>)> {
        let path = &points.on.path;
        let progress = self.progress(state, path, reference);
        self.look_around(state, path, reference, point, progress, &mut points.spent[0]);
        let sampled = points.spent[0] > 0;
        let guess = path.moving(state.best.at);
        (points.base, points.place) = (guess.span, place(path, guess, state.best.lag, reference)?);
        let mut along = Tangent::NONE;
        let start = Start { guess: guess.t, window: self.max_lag, place: R::ZERO, max_lag: Start::never_plain() };
        let seen = feet(path.span(guess.span)?, points.position, points.d, &start, tip, encoder, &mut along);
        points.spent[0] += 2;
        points.spent[1] += u8::from(seen.tip());
        let (mut at_tip, at_encoder) = if sampled {
            // Until the last sample, the sample itself is the answer if the frame has none.
            let feet = Feet::of(guess.span, seen, &along, tip, encoder);
            let at_tip = match feet.tip {
                Some(at_tip) => at_tip,
                None => {
                    points.spent[0] += 1;
                    at(path.span(guess.span)?, guess.span, point, guess.t)
                }
            };
            (at_tip, feet.encoder.unwrap_or_else(|| points.encoder_at_tip_foot(&at_tip)))
        } else {
            let mut feet = Feet { tip: None, encoder: None };
            points.resolve(&mut feet, guess, seen, &along, tip, encoder);
            (feet.tip?, feet.encoder?)
        };
        if !sampled {
            // After the last sample, the search either has the foot or starts over.
            state.warm = at_tip.flags.has(Flags::BRACKETED);
            state.looked = 0;
        }
        at_tip.flags = at_tip.flags.and(Flags::COLD);
        Some((at_tip, at_encoder))
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
        let behind = points.lag(at_encoder.place);
        for (foot, found, lag, spent) in [(tip, at_tip, lag, for_tip), (encoder, at_encoder, behind, for_encoder)] {
            let error = dot(&found.vector, &found.vector).root();
            *foot = components(&points.on.path, found, error, lag, spent);
            foot.flags = foot.flags.and(points.doubt.flags());
        }
    }
}

impl<R: Real> Feet<R> {
    /// The feet of one frame, if they lie on its span.
    fn of(span: u32, seen: Seen, along: &Tangent<R>, tip: &ContourError<R>, encoder: &ContourError<R>) -> Self {
        let found = |converged: bool, foot: &ContourError<R>| {
            let vector: [R; 3] = foot.vector.into();
            (converged && foot.t >= R::ZERO && foot.t <= R::ONE).then(|| Found {
                place: Reference { span, t: foot.t },
                vector: vector.map(|x| -x),
                tangent: along.tangent,
                width: R::ZERO,
                flags: Flags::BRACKETED,
                downhill: false,
            })
        };
        Feet { tip: found(seen.tip(), tip), encoder: found(seen.encoder(), encoder) }
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

    fn left(&self) -> u8 {
        let [tip, encoder] = self.spent;
        BOTH.saturating_sub(tip.saturating_add(encoder))
    }

    /// Finds both feet, starting from those of the first frame; they stay `None` without a path.
    fn resolve(
        &mut self,
        feet: &mut Feet<R>,
        guess: Reference<R>,
        seen: Seen,
        along: &Tangent<R>,
        tip: &ContourError<R>,
        encoder: &ContourError<R>,
    ) {
        let mut from = From { tip: guess, encoder: None };
        // A foot beyond the border counts as lying on it.
        let near = (tip.t.limit(R::ZERO, R::ONE) - guess.t).abs() * along.speed <= self.reach;
        if seen.tip() && near {
            *feet = Feet::of(guess.span, seen, along, tip, encoder);
            if !self.search_other_leg(feet) {
                from = self.look_beyond(feet, guess.span, seen, tip, encoder);
            }
        }
        if feet.tip.is_none() {
            feet.tip = self.descend_from(from.tip);
        }
        if let (Some(at_tip), None) = (&feet.tip, &feet.encoder) {
            feet.encoder = Some(self.encoder_from(at_tip, from.encoder));
        }
    }

    /// Searches the leg beside the tip's foot, if any: keeps the intended foot of the two, with the encoder's foot on
    /// the same leg.
    fn search_other_leg(&mut self, found: &mut Feet<R>) -> bool {
        let (true, Some(at_tip)) = (self.doubt.open, &found.tip) else { return false };
        let (position, d) = (self.position, self.d);
        let tip = |span: &Span<R, P>| local(span, position, d);
        let Some(meant) = self.doubt.resolve(self.on, self.window, self.max_lag, at_tip, tip, &mut self.spent[0])
        else {
            return false;
        };
        if meant.place.span != at_tip.place.span {
            found.encoder = None;
        }
        found.tip = Some(meant);
        true
    }

    /// Searches behind the border if it is in sight: one frame there for both points. For feet that are still missing, tests
    /// the border itself from either side.
    fn look_beyond(
        &mut self,
        found: &mut Feet<R>,
        number: u32,
        seen: Seen,
        tip: &ContourError<R>,
        encoder: &ContourError<R>,
    ) -> From<R> {
        let path = &self.on.path;
        let held = |t: R| Reference { span: number, t: t.limit(R::ZERO, R::ONE) };
        // An inexact foot of the encoder is still a good guess.
        let mut from = From { tip: held(tip.t), encoder: (!seen.encoder()).then(|| held(encoder.t)) };
        let Some(span) = path.span(number) else { return from };
        let (place, other, length) = (span.arc_length(tip.t), span.arc_length(encoder.t), span.length());
        let forward = place + place > length;
        let rest = if forward { length - place.max(other) } else { place.min(other) };
        if rest > sight(self.window, tip.error.max(encoder.error)) || self.left() < BEYOND {
            return from;
        }
        let border = if forward { path.next(number) } else { path.previous(number) };
        let [_, entry] = sides(forward);
        let mut missing = [found.tip.is_none(), found.encoder.is_none() && seen.encoder()];
        let mut outer = None;
        if let Some((beyond, there)) = border.and_then(|beyond| Some((beyond, path.span(beyond)?))) {
            let entered = evaluate_end(there, &local(there, self.position, self.d), forward);
            self.spent[0] += 1;
            let uphill = [&[R::ZERO; 3], self.d].map(|d| rises(&entered, d, forward));
            outer = Some((beyond, entered));
            if uphill != [true; 2] {
                let (mut to_tip, mut to_encoder) = (ContourError::none(), ContourError::none());
                let mut along = Tangent::NONE;
                let start = Start { guess: entry, window: self.window, place: R::ZERO, max_lag: Start::never_plain() };
                let inside = feet(there, self.position, self.d, &start, &mut to_tip, &mut to_encoder, &mut along);
                self.spent[0] += 2;
                self.spent[1] += u8::from(inside.tip());
                let second = Feet::of(beyond, inside, &along, &to_tip, &to_encoder);
                self.keep_meant(found, second, forward);
                // The border is the foot only if both spans' feet lie beyond it.
                let begin = Reference { span: beyond, t: entry };
                let [tip_outside, encoder_outside] = [uphill[0] || inside.tip(), uphill[1] || inside.encoder()];
                if !tip_outside {
                    from.tip = begin;
                }
                if seen.encoder() && !encoder_outside {
                    from.encoder = Some(begin);
                }
                missing =
                    [found.tip.is_none() && tip_outside, found.encoder.is_none() && seen.encoder() && encoder_outside];
            }
        }
        if missing.contains(&true) {
            self.look_at(found, number, outer, forward, missing);
        }
        from
    }

    /// Keeps the nearer feet from both sides of a border, or those of the intended leg.
    fn keep_meant(&mut self, found: &mut Feet<R>, second: Feet<R>, forward: bool) {
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

    /// Takes the border itself, a corner or the end of an open path, for the points whose foot is missing.
    fn look_at(
        &mut self,
        found: &mut Feet<R>,
        number: u32,
        outer: Option<(u32, Evaluation<R>)>,
        forward: bool,
        [tip, encoder]: [bool; 2],
    ) {
        let [out, entry] = sides(forward);
        let Some(inner) = self.sample_end(number, forward) else { return };
        self.spent[usize::from(!tip)] += 1;
        let still = [R::ZERO; 3];
        for (missing, d, slot) in [(tip, &still, &mut found.tip), (encoder, self.d, &mut found.encoder)] {
            if !missing {
                continue;
            }
            // The border is a foot if the distance falls towards it from within and rises beyond it.
            let downhill = rises(&inner, d, !forward);
            let (place, e, kind, bracketed) = match &outer {
                Some((span, outer)) => {
                    let bracketed = downhill && rises(outer, d, forward);
                    (Reference { span: *span, t: entry }, outer, Flags::AT_CORNER, bracketed)
                }
                None => (Reference { span: number, t: out }, &inner, Flags::AT_END, downhill),
            };
            let mut vector = e.vector;
            for k in 0..3 {
                vector[k] += d[k];
            }
            let flags = if bracketed { Flags::BRACKETED.and(kind) } else { Flags::default() };
            let width = if bracketed { R::ZERO } else { self.window };
            *slot = Some(Found { place, vector, tangent: e.tangent, width, flags, downhill: !bracketed });
        }
    }

    /// Evaluates a span at the end towards the border, relative to the tip.
    fn sample_end(&self, number: u32, forward: bool) -> Option<Evaluation<R>> {
        let span = self.on.path.span(number)?;
        Some(evaluate_end(span, &local(span, self.position, self.d), !forward))
    }

    /// Finds the tip's foot by a separate descent and, if evaluations remain, a second one behind the nearer border.
    fn descend_from(&mut self, from: Reference<R>) -> Option<Found<R>> {
        let ([x, y, z], [dx, dy, dz]) = (self.position, self.d);
        let point = [x.plus(*dx), y.plus(*dy), z.plus(*dz)];
        let budget = self.left().min(DESCENT);
        let found = descend(&self.on.path, from, &point, self.reach, false, budget, &mut self.spent[0])?;
        if self.left() < 4 {
            return Some(found);
        }
        let spent = &mut self.spent[0];
        across(self.on, &mut self.doubt, self.max_lag, &found, &point, self.window, spent).or(Some(found))
    }

    /// The encoder's foot by the kernel, from a guess or from the tip's foot; failing that, the tip's foot itself, not
    /// bracketed.
    fn encoder_from(&mut self, tip: &Found<R>, guess: Option<Reference<R>>) -> Found<R> {
        let from = guess.unwrap_or(tip.place);
        if let (true, Some(span)) = (self.left() >= 2, self.on.path.span(from.span)) {
            let near = foot(span, &span.relative(self.position), from.t);
            self.spent[1] += 2;
            if near.trusted {
                return Found::of(from.span, &near);
            }
        }
        self.encoder_at_tip_foot(tip)
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
        by_halves.unwrap_or_else(|| self.encoder_from(tip, None))
    }
}
