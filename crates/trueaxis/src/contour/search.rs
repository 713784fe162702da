//! The search in every cycle, warm and cold.

use super::kernel::{Foot, foot};
use super::legs::{Apart, Doubt};
use super::refine::{Found, descend};
use super::span::{OnPath, Path, Reference, Span, dot};
use super::way::{advance, sight, way, way_far, window};
use super::{ContourError, Flags};
use crate::error::{ConfigError, Field};
use crate::position::Position;
use crate::range::LAG;
use crate::real::Real;

/// Method for narrowing a bracket.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Method {
    /// Third-order kernel, then Newton steps guarded by bisection.
    #[default]
    Guarded = 0,
    /// Plain bisection, as published, for comparison. Up to 60 evaluations a cycle.
    Bisection = 1,
}

/// Settings of the search; immutable.
#[derive(Clone, Copy, Debug)]
pub struct ContourSearch<R> {
    pub(super) max_lag: R,
    pub(super) method: Method,
}

/// State of the search from cycle to cycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContourState<R> {
    pub(super) foot: Reference<R>,
    pub(super) reference: Reference<R>,
    /// Whether a foot is known.
    pub(super) warm: bool,
    /// State for a leg that lies beside the foot's.
    pub(super) doubt: Doubt<R>,
    /// Number of samples taken in the cold search and of cycles that descended since, and the best sample.
    pub(super) looked: u16,
    pub(super) best: Sample<R>,
    best_distance: R,
    /// The next sample.
    sample: Sample<R>,
}

/// A sample of a cold search.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sample<R> {
    pub(super) at: Reference<R>,
    /// Arc length from the sample to the reference.
    pub(super) lag: R,
}

impl<R: Real> Sample<R> {
    /// Moves the sample with the reference; where that is beyond the limit of spans, returns the reference itself.
    fn follow<P: Position>(&self, path: &Path<'_, R, P>, reference: Reference<R>, progress: R) -> Self {
        match advance(path, self.at, progress) {
            Some(moved) => Sample { at: moved.to, lag: self.lag + progress - moved.by },
            None => Sample { at: reference, lag: R::ZERO },
        }
    }
}

/// Most evaluations of the path in a cycle.
pub(super) const EVALUATIONS: u8 = 6;
/// Most evaluations in a cycle of the published bisection.
pub(super) const BISECTIONS: u8 = 60;
/// Samples of a cold search over ±max_lag.
pub(super) const COLD_SAMPLES: u16 = 130;
/// Samples from the reference backwards; after a step from there, the others run ahead of it.
const COLD_BEHIND: u16 = 66;
/// This fraction of a sample's lag is added to its distance at right angles: of two legs side by side, the one near the
/// reference wins.
const DOUBT_PER_LAG: f64 = 0.1;
/// Samples of a cold search in one cycle: they cost what the search from a known foot costs at worst.
const COLD_PER_CYCLE: u16 = 10;
/// Most spans between two samples.
const HOPS: u8 = 3;
/// Cycles after the last sample in which a cold search descends, before it starts over.
pub(super) const COLD_DESCENTS: u16 = 6;

impl<R: Real> ContourSearch<R> {
    /// `max_lag_mm`: half-window of a cold search, arc length.
    ///
    /// # Errors
    /// `max_lag_mm` outside [`LAG`].
    pub fn new(max_lag_mm: f64, method: Method) -> Result<Self, ConfigError> {
        LAG.check(max_lag_mm, Field::MaxLag, None)?;
        Ok(ContourSearch { max_lag: R::of(max_lag_mm), method })
    }

    /// Contour error of `point` (mm) in this cycle; `reference` is the interpolator's position on the path.
    ///
    /// Uses at most six evaluations of the path. With no foot known it samples the path over thirteen cycles and measures no
    /// error meanwhile ([`Flags::SEARCHING`]). Cost: usually the kernel's; at worst some three times that.
    ///
    /// A reference outside its span is clamped to the nearer end and flagged ([`Flags::REFERENCE`]); if it is infinite or not
    /// a number, no error is measured.
    #[inline(always)]
    pub fn update<P: Position>(
        &self,
        state: &mut ContourState<R>,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
        point: [P; 3],
    ) -> ContourError<R> {
        if !reference.is_on_its_span() {
            return self.update_off(state, path, reference, &point);
        }
        self.update_on(state, path, reference, &point)
    }

    /// Handles a reference off its span.
    #[cold]
    #[inline(never)]
    pub(crate) fn update_off<P: Position>(
        &self,
        state: &mut ContourState<R>,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
        point: &[P; 3],
    ) -> ContourError<R> {
        let mut error = if reference.t.is_finite() {
            let held = Reference { t: reference.t.limit(R::ZERO, R::ONE), ..reference };
            self.slow(state, path, held, point)
        } else {
            *state = ContourState::default();
            ContourError::none()
        };
        if reference.t != R::ZERO {
            error.flags = error.flags.and(Flags::REFERENCE);
        }
        error
    }

    /// Handles a reference on its span.
    #[inline(always)]
    pub(crate) fn update_on<P: Position>(
        &self,
        state: &mut ContourState<R>,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
        point: &[P; 3],
    ) -> ContourError<R> {
        // Tests "not warm, or bisection" in one comparison.
        if u8::from(state.warm) <= self.method as u8 {
            return self.slow(state, path, reference, point);
        }
        let Some(progress) = way(path, state.reference, reference) else {
            return self.slow(state, path, reference, point);
        };
        let Some(guess) = advance(path, state.foot, progress).map(|moved| moved.to) else {
            return self.slow(state, path, reference, point);
        };
        let Some(span) = path.span(guess.span) else { return self.slow(state, path, reference, point) };
        let window = window(progress);
        let mut alone = !state.doubt.open;
        if !alone || state.foot.span != reference.span {
            let apart = Apart {
                foot: state.foot.span,
                reference: reference.span,
                were_together: state.foot.span == state.reference.span,
                lag: way(path, guess, reference).unwrap_or(R::ZERO),
                progress,
            };
            alone = !state.doubt.follow(path, &apart, window);
        }
        let found = foot(span, &span.relative(point), guess.t);
        let (place, length) = (span.arc_length(found.t), span.length());
        let squared = dot(&found.vector, &found.vector);
        let error = squared.sqrt();
        let sight = sight(window, error);
        let clear = place > sight && length - place > sight;
        let near = (place - span.arc_length(guess.t)).abs() <= window;
        if found.trusted && clear && near && alone {
            return self.report(state, path, reference, &Found::of(guess.span, &found), error, 2);
        }
        self.general(state, path, reference, point, guess, window, found)
    }

    /// Continues where the kernel's foot is not clear: near a border, beyond it, not trusted, or beside another leg.
    #[inline(never)]
    fn general<P: Position>(
        &self,
        state: &mut ContourState<R>,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
        point: &[P; 3],
        guess: Reference<R>,
        window: R,
        first: Foot<R>,
    ) -> ContourError<R> {
        let mut spent = 2;
        let Some(span) = path.span(guess.span) else { return ContourError::none() };
        let near = (span.arc_length(first.t) - span.arc_length(guess.t)).abs() <= window;
        let mut found = if first.trusted && near {
            Found::of(guess.span, &first)
        } else {
            match descend(path, guess, point, window, false, EVALUATIONS - spent, &mut spent) {
                Some(found) => found,
                None => return ContourError::none(),
            }
        };
        let on = OnPath { path: *path, reference };
        let doubt = &mut state.doubt;
        let resolved = if doubt.open && first.trusted && near {
            doubt.resolve(&on, window, self.max_lag, &found, |span| span.relative(point), &mut spent)
        } else {
            None
        };
        // One more call of the kernel, at the nearer border; if the span is so short that both are in sight, the foot soon
        // leaves it.
        if let Some(other) = resolved {
            found = other;
        } else if spent + 2 <= EVALUATIONS
            && let Some(other) = across(&on, doubt, self.max_lag, &found, point, window, &mut spent)
        {
            found = other;
        }
        // On short spans at high feed the evaluations may run out just past a border: the next cycle continues from there.
        if !(found.flags.has(Flags::BRACKETED) || found.downhill) || state.doubt.is_lost() {
            state.warm = false;
            state.looked = 0;
        }
        let mut error = self.report_found(state, path, reference, &found, spent);
        error.flags = error.flags.and(state.doubt.flags());
        error
    }

    /// Searches with no foot known, or by plain bisection.
    #[inline(never)]
    fn slow<P: Position>(
        &self,
        state: &mut ContourState<R>,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
        point: &[P; 3],
    ) -> ContourError<R> {
        if self.is_sampling(state, path, reference, |span| span.relative(point)) {
            return ContourError::searching();
        }
        let mut spent = 0;
        match self.seek(state, path, reference, point, &mut spent) {
            Some(found) => self.report_found(state, path, reference, &found, spent),
            None => ContourError::none(),
        }
    }

    /// [`slow`](Self::slow) without samples and without the report. `None` if the path has no span there; this resets the
    /// state.
    #[inline(never)]
    pub(super) fn seek<P: Position>(
        &self,
        state: &mut ContourState<R>,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
        point: &[P; 3],
        spent: &mut u8,
    ) -> Option<Found<R>> {
        if path.span(reference.span).is_none() {
            *state = ContourState::default();
            return None;
        }
        let progress = self.progress(state, path, reference);
        let start = match state.warm {
            true => advance(path, state.foot, progress).map(|moved| moved.to),
            false => Some(state.best.at),
        };
        let window = if state.warm { window(progress) } else { self.max_lag };
        let bisect = self.method == Method::Bisection;
        let budget = if bisect { BISECTIONS } else { EVALUATIONS };
        let Some(mut found) = start.and_then(|start| descend(path, start, point, window, bisect, budget, spent)) else {
            *state = ContourState::default();
            return None;
        };
        let bracketed = found.flags.has(Flags::BRACKETED);
        if !state.warm {
            found.flags = found.flags.and(Flags::COLD);
        }
        // After the last sample, the search either has the foot or starts over.
        state.warm = bracketed;
        state.looked = 0;
        Some(found)
    }

    /// Whether the search samples the path in this cycle: it knows no foot and has not taken all samples. Takes this cycle's.
    #[inline(always)]
    pub(super) fn is_sampling<P: Position>(
        &self,
        state: &mut ContourState<R>,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
        point: impl Fn(&Span<R, P>) -> [R; 3],
    ) -> bool {
        let progress = self.progress(state, path, reference);
        // After a jump of the reference beyond the limit of spans, no foot is known.
        if state.warm && advance(path, state.foot, progress).is_none_or(|moved| path.span(moved.to.span).is_none()) {
            state.warm = false;
            state.looked = 0;
        }
        if state.warm || path.span(reference.span).is_none() {
            return false;
        }
        let sampling = state.looked < COLD_SAMPLES;
        if state.looked == 0 {
            state.best_distance = R::MAX;
            state.doubt = Doubt::none();
            state.best = Sample { at: reference, lag: R::ZERO };
            state.sample = state.best;
        } else {
            state.best = state.best.follow(path, reference, progress);
        }
        if sampling {
            if state.looked > 0 {
                state.sample = state.sample.follow(path, reference, progress);
            }
            self.look_around(state, path, reference, point);
        }
        state.reference = reference;
        sampling
    }

    /// Motion of the reference since the last cycle; resets the state if it has jumped beyond the limit of spans.
    #[inline(always)]
    pub(super) fn progress<P: Position>(
        &self,
        state: &mut ContourState<R>,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
    ) -> R {
        if !(state.warm || state.looked > 0) {
            return R::ZERO;
        }
        way(path, state.reference, reference).unwrap_or_else(|| {
            *state = ContourState::default();
            R::ZERO
        })
    }

    /// Takes a few samples of the path around the reference, first behind it, then ahead, and keeps the nearest.
    #[inline(never)]
    fn look_around<P: Position>(
        &self,
        state: &mut ContourState<R>,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
        point: impl Fn(&Span<R, P>) -> [R; 3],
    ) {
        let spacing = self.max_lag * R::of(2.0 / f64::from(COLD_SAMPLES - 4));
        let first = state.looked;
        state.looked += COLD_PER_CYCLE;
        let mut sample = state.sample;
        let Some(mut span) = path.span(sample.at.span) else { return };
        let mut local = point(span);
        // At most COLD_PER_CYCLE rounds.
        for number in first..first + COLD_PER_CYCLE {
            let mut by = if number < COLD_BEHIND { -spacing } else { spacing };
            if number == COLD_BEHIND {
                sample = Sample { at: reference, lag: R::ZERO };
                let Some(home) = path.span(reference.span) else { return };
                (span, local) = (home, point(home));
            } else {
                let [x, y, z] = span.local(sample.at.t);
                let off = [x - local[0], y - local[1], z - local[2]];
                let doubtful = R::of(DOUBT_PER_LAG) * sample.lag;
                let distance = dot(&off, &off) + doubtful * doubtful;
                if distance < state.best_distance {
                    (state.best_distance, state.best) = (distance, sample);
                }
            }
            let (t, begin) = (sample.at.t, span.arc_length(sample.at.t));
            let to = t + by / span.arc_speed(t);
            if to.is_in_unit() {
                sample = Sample { at: Reference { t: to, ..sample.at }, lag: sample.lag + begin - span.arc_length(to) };
                continue;
            }
            let end = if by > R::ZERO { span.length() } else { R::ZERO };
            let left = end - begin;
            sample.lag -= left;
            by -= left;
            (sample, span) = hop(path, sample, span, by);
            local = point(span);
        }
        state.sample = sample;
    }

    /// Like [`report`](Self::report), out of line, for a foot whose distance is not known yet.
    #[inline(never)]
    pub(super) fn report_found<P: Position>(
        &self,
        state: &mut ContourState<R>,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
        found: &Found<R>,
        evaluations: u8,
    ) -> ContourError<R> {
        let error = dot(&found.vector, &found.vector).sqrt();
        self.report(state, path, reference, found, error, evaluations)
    }

    /// Components, lag and flags of a foot.
    #[inline(always)]
    fn report<P: Position>(
        &self,
        state: &mut ContourState<R>,
        path: &Path<'_, R, P>,
        reference: Reference<R>,
        found: &Found<R>,
        error: R,
        evaluations: u8,
    ) -> ContourError<R> {
        state.foot = found.place;
        state.reference = reference;
        let lag = way_far(path, found.place, reference, self.max_lag);
        if state.warm && lag.abs() > self.max_lag {
            // The foot has stayed behind: start a cold search.
            state.warm = false;
            state.looked = 0;
        }
        components(path, found, error, lag, evaluations)
    }
}

/// The sample `by` beyond the border that a sample has reached, over at most three spans; at an end of the path, the end.
#[inline(always)]
fn hop<'s, R: Real, P: Position>(
    path: &Path<'s, R, P>,
    mut sample: Sample<R>,
    mut span: &'s Span<R, P>,
    mut by: R,
) -> (Sample<R>, &'s Span<R, P>) {
    let ahead = by > R::ZERO;
    // At most HOPS rounds.
    for _ in 0..HOPS {
        let next = if ahead { path.following(sample.at.span) } else { path.preceding(sample.at.span) };
        let Some((number, there)) = next.and_then(|number| Some((number, path.span(number)?))) else {
            sample.at.t = if ahead { R::ONE } else { R::ZERO };
            break;
        };
        span = there;
        sample.at = Reference { span: number, t: if ahead { R::ZERO } else { R::ONE } };
        let length = there.length();
        if by.abs() < length {
            let to = sample.at.t + by / there.arc_speed(sample.at.t);
            let to = to.limit(R::ZERO, R::ONE);
            let passed = if ahead { there.arc_length(to) } else { there.arc_length(to) - length };
            sample = Sample { at: Reference { t: to, ..sample.at }, lag: sample.lag - passed };
            break;
        }
        let passed = if ahead { length } else { -length };
        sample.at.t = R::ONE - sample.at.t;
        sample.lag -= passed;
        by -= passed;
    }
    (sample, span)
}

/// Splits the vector at a foot into its signed components.
#[inline(always)]
pub(super) fn components<R: Real, P: Position>(
    path: &Path<'_, R, P>,
    found: &Found<R>,
    error: R,
    lag: R,
    evaluations: u8,
) -> ContourError<R> {
    let [bx, by, bz] = path.span(found.place.span).map_or([R::ZERO, R::ZERO, R::ONE], |s| s.plane);
    let [tx, ty, tz] = found.tangent;
    let e = [-found.vector[0], -found.vector[1], -found.vector[2]];
    // n = b × t; the components use the unnormalised frame, with one root for both lengths.
    let n = [by * tz - bz * ty, bz * tx - bx * tz, bx * ty - by * tx];
    let (tt, nn) = (dot(&found.tangent, &found.tangent), dot(&n, &n));
    let (n, nn) = if nn > R::of(1e-12) * tt { (n, nn) } else { ([R::ONE, R::ZERO, R::ZERO], R::ONE) };
    let product = tt * nn;
    let i = if product > R::of(1e-30) { R::ONE / product.sqrt() } else { R::ZERO };
    // 1/|n| = |t| i and 1/|t| = |n| i would need two more roots: |t × n| = |t||n| for n at right angles to t.
    let out = [ty * n[2] - tz * n[1], tz * n[0] - tx * n[2], tx * n[1] - ty * n[0]];
    let binormal = dot(&e, &out) * i;
    let along = dot(&e, &found.tangent);
    // At a plain foot the tangential part is rounding: the in-plane component is the remainder of the distance.
    let special =
        found.flags.has(Flags::AT_END) || found.flags.has(Flags::AT_CORNER) || !found.flags.has(Flags::BRACKETED);
    let tangential = if special && tt > R::of(1e-30) { along / tt.sqrt() } else { R::ZERO };
    let in_plane = (error * error - binormal * binormal - tangential * tangential).sqrt();
    let normal = if dot(&e, &n) < R::ZERO { -in_plane } else { in_plane };
    ContourError {
        span: found.place.span,
        t: found.place.t,
        error,
        vector: e.into(),
        normal,
        binormal,
        tangential,
        lag,
        width: found.width,
        evaluations,
        flags: found.flags,
    }
}

/// Finds a minimum behind the nearer border, if the path bends so that each side has one: returns the nearer of the two
/// or, of two legs side by side, the one intended.
#[inline(never)]
pub(super) fn across<R: Real, P: Position>(
    on: &OnPath<'_, R, P>,
    doubt: &mut Doubt<R>,
    max_lag: R,
    found: &Found<R>,
    point: &[P; 3],
    window: R,
    spent: &mut u8,
) -> Option<Found<R>> {
    let path = &on.path;
    let span = path.span(found.place.span)?;
    let (place, length) = (span.arc_length(found.place.t), span.length());
    let distance = dot(&found.vector, &found.vector);
    let error = distance.sqrt();
    let forward = place + place > length;
    let rest = if forward { length - place } else { place };
    if rest > sight(window, error) {
        return None;
    }
    let (number, entry) =
        if forward { (path.next(found.place.span)?, R::ZERO) } else { (path.previous(found.place.span)?, R::ONE) };
    let beyond = path.span(number)?;
    let local = beyond.relative(point);
    *spent = spent.saturating_add(2);
    let other = foot(beyond, &local, entry);
    // Unless the distance falls into the neighbour, it has no minimum there.
    if !(other.converged && other.t > R::ZERO && other.t < R::ONE) {
        return None;
    }
    let nearer = dot(&other.vector, &other.vector);
    let other = Found { flags: Flags::BRACKETED.and(Flags::SECOND_MINIMUM), ..Found::of(number, &other) };
    if let Some(meant) = doubt.at_border(on, window, max_lag, (found, &other), forward) {
        return Some(meant);
    }
    if nearer < distance {
        Some(other)
    } else {
        Some(Found { flags: found.flags.and(Flags::SECOND_MINIMUM), ..*found })
    }
}
