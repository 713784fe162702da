//! Two legs side by side: after a turn by almost 180°, order along the path determines which leg a tip close to both is on.
//!
//! The distance alone cannot decide. A tip that lags turns when the reference has come back to it, so its foot
//!
//! - is not ahead of the reference by more than the window;
//! - does not go back along the path by more than the window;
//! - lags, on the leg before the turn, at most twice as much as when the reference turned;
//! - is the nearer one if both are possible.
//!
//! The doubt begins when the reference has turned against the foot, or the foot goes back; it ends when the leg that the foot
//! left is out of sight. Until then no cycle is plain, and a second minimum is flagged while it is near or could not be
//! tested.

use super::Flags;
use super::kernel::{evaluate, foot};
use super::refine::Found;
use super::span::{Form, OnPath, Path, Reference, Span, dot};
use super::way::{advance, sight, way};
use crate::position::Position;
use crate::real::Real;

/// Square of the cosine of the largest angle between legs that count as side by side, 45°. Beyond 28° the border is in sight
/// for as long as the legs are close.
const SIDE_BY_SIDE: f64 = 0.5;
/// Feet closer than this are equivalent for any use of the error, mm.
const SAME: f64 = 2e-4;

/// Consecutive cycles after which the search gives up an implausible foot.
const MISSED: u8 = 8;

/// State that decides which leg the foot is on, from cycle to cycle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Doubt<R> {
    pub(super) open: bool,
    /// The foot on the leg before the turn, if the tip's foot is on the leg after it.
    left: Option<Reference<R>>,
    /// Arc length from the foot's furthest position to the reference, mm.
    furthest: R,
    /// Lag in the last cycle, mm.
    lag: R,
    /// Largest plausible lag on this leg, mm.
    plausible_lag: R,
    /// Span on which the reference was when it turned.
    turned: u32,
    /// Whether the other leg has not been searched in this cycle.
    unresolved: bool,
    /// Consecutive cycles with an implausible foot and no other one.
    missed: u8,
    /// A point near the minimum on the reference's leg.
    after: Option<Reference<R>>,
    /// Spans of the foot and of the reference that were compared last, and whether they run in opposite directions.
    compared: [u32; 2],
    against: bool,
}

/// Start of a cycle in which foot and reference are on two spans.
pub(super) struct Apart<R> {
    pub(super) foot: u32,
    pub(super) reference: u32,
    /// Whether both were on one span in the last cycle.
    pub(super) were_together: bool,
    /// Lag in the last cycle, and progress of the reference since.
    pub(super) lag: R,
    pub(super) progress: R,
}

/// Whether the start of one span runs against the end of another. Uses homogeneous coefficients, without computing the points:
/// half the cost of two evaluations.
#[inline(never)]
fn against<R: Real, P: Position>(one: &Span<R, P>, other: &Span<R, P>) -> bool {
    let [c0, c1, ..] = &one.coefficients;
    let start: [R; 3] = core::array::from_fn(|k| c1[k] * c0[3] - c0[k] * c1[3]);
    let (mut at, mut rate, mut power) = ([R::ZERO; 4], [R::ZERO; 4], R::ZERO);
    let terms = match other.form() {
        Form::Cubic | Form::RationalCubic => 4,
        Form::Quintic | Form::RationalQuintic => 6,
    };
    for c in other.coefficients.iter().take(terms) {
        for k in 0..4 {
            at[k] += c[k];
            rate[k] += power * c[k];
        }
        power += R::ONE;
    }
    let end: [R; 3] = core::array::from_fn(|k| rate[k] * at[3] - at[k] * rate[3]);
    are_against(&start, &end)
}

#[inline(always)]
pub(super) fn are_against<R: Real>(a: &[R; 3], b: &[R; 3]) -> bool {
    let along = dot(a, b);
    along < R::ZERO && along * along > R::of(SIDE_BY_SIDE) * (dot(a, a) * dot(b, b))
}

impl<R: Real> Doubt<R> {
    /// Updates the state for this cycle; returns whether the leg is in doubt.
    #[inline(always)]
    pub(super) fn follow<P: Position>(&mut self, path: &Path<'_, R, P>, apart: &Apart<R>, window: R) -> bool {
        let Apart { foot, reference, were_together, lag, progress } = *apart;
        self.unresolved = true;
        if were_together || progress < R::ZERO || lag < self.furthest {
            self.furthest = lag;
        }
        let back = lag - self.furthest > window;
        self.furthest += progress;
        self.lag = lag;
        if foot != reference && (back || self.has_turned(path, foot, reference)) {
            if !self.open || self.left.is_some() {
                (self.open, self.left, self.turned, self.after) = (true, None, reference, None);
                self.plausible_lag = R::TWO * lag.max(R::ZERO) + window;
            }
            self.missed = if back || lag > self.plausible_lag { self.missed.saturating_add(1) } else { 0 };
        } else {
            self.open &= self.left.is_some_and(|left| left.span != foot);
            self.missed = 0;
        }
        self.open
    }

    /// Whether the reference runs against the foot's direction, or has turned against it and the foot has not yet followed.
    #[inline(always)]
    fn has_turned<P: Position>(&mut self, path: &Path<'_, R, P>, foot: u32, reference: u32) -> bool {
        if self.compared != [foot, reference] {
            self.compared = [foot, reference];
            self.against =
                matches!((path.span(foot), path.span(reference)), (Some(one), Some(other)) if against(one, other));
        }
        let waits = self.open && self.left.is_none() && (foot.wrapping_sub(self.turned) as i32) < 0;
        waits || self.against
    }

    /// Decides between the foot `one` and the minimum on the leg beside it. `None` if that leg has no minimum or none is known
    /// yet, or a border ahead must be tested first. At most two evaluations.
    pub(super) fn resolve<P: Position>(
        &mut self,
        on: &OnPath<'_, R, P>,
        window: R,
        max_lag: R,
        one: &Found<R>,
        point: impl Fn(&Span<R, P>) -> [R; 3],
        spent: &mut u8,
    ) -> Option<Found<R>> {
        let path = &on.path;
        let Some(left) = self.left else {
            let Some(near) = self.after.take() else {
                self.after = near_minimum_on_reference_leg(on, max_lag, point, spent);
                return None;
            };
            let after = minimum(path, near, point, spent)?.0?;
            if after.place.span == one.place.span {
                // Both are on one span: the foot is the only one.
                *self = Self::none();
                return None;
            }
            return self.choose(on, window, max_lag, one, &after, self.lag);
        };
        let span = path.span(one.place.span)?;
        let error = dot(&one.vector, &one.vector).root();
        if span.length() - span.arc_length(one.place.t) <= sight(window, error) {
            return None;
        }
        let Some((before, t)) = minimum(path, left, point, spent) else {
            *self = Self::none();
            return None;
        };
        if let Some(before) = before {
            // Over too many spans it is out of sight.
            let lag = way(path, before.place, on.reference).unwrap_or(R::MAX);
            return self.choose(on, window, max_lag, &before, one, lag);
        }
        // The minimum has moved to the neighbouring span, or the leg ends there.
        let neighbour = if t < R::ZERO { (path.previous(left.span), R::ONE) } else { (path.next(left.span), R::ZERO) };
        self.left = neighbour.0.filter(|span| *span != one.place.span).map(|span| Reference { span, t: neighbour.1 });
        self.open = self.left.is_some();
        None
    }

    /// Decides between two minima in path order, and flags the result if the other is near. `None` if the path is cut off.
    fn choose<P: Position>(
        &mut self,
        on: &OnPath<'_, R, P>,
        window: R,
        max_lag: R,
        before: &Found<R>,
        after: &Found<R>,
        lag_before: R,
    ) -> Option<Found<R>> {
        let lag_after = way(&on.path, after.place, on.reference)?;
        let [far, near] = [before, after].map(|found| dot(&found.vector, &found.vector).root());
        (self.unresolved, self.missed) = (false, 0);
        let behind = lag_before - self.furthest > window || lag_before > self.plausible_lag;
        let is_after = lag_after >= -window && (behind || near < far);
        let (one, distance, other) = if is_after { (after, near, far) } else { (before, far, near) };
        let apart: [R; 3] = core::array::from_fn(|k| after.vector[k] - before.vector[k]);
        let in_sight = other <= sight(window, distance);
        let passed = !in_sight || lag_before - lag_after > R::TWO * max_lag;
        self.left = (is_after && !passed).then_some(before.place);
        self.open = !(is_after && passed);
        let said = in_sight && dot(&apart, &apart) > R::of(SAME * SAME);
        Some(Found { flags: if said { one.flags.and(Flags::SECOND_MINIMUM) } else { one.flags }, ..*one })
    }

    /// Like [`Doubt::choose`], for the minima on both sides of a border, `other` behind it. `None` if their spans are not side
    /// by side.
    pub(super) fn at_border<P: Position>(
        &mut self,
        on: &OnPath<'_, R, P>,
        window: R,
        max_lag: R,
        (one, other): (&Found<R>, &Found<R>),
        forward: bool,
    ) -> Option<Found<R>> {
        if !are_against(&one.tangent, &other.tangent) {
            return None;
        }
        let (before, after) = if forward { (one, other) } else { (other, one) };
        let lag = way(&on.path, before.place, on.reference)?;
        if !self.open {
            (self.furthest, self.plausible_lag) = (lag, R::MAX);
        }
        let found = self.choose(on, window, max_lag, before, after, lag)?;
        Some(Found { flags: found.flags.and(Flags::SECOND_MINIMUM), ..found })
    }

    /// Whether the foot has stayed behind on a leg and the search has no other. The search then starts cold.
    pub(super) fn is_lost(&self) -> bool {
        self.missed > MISSED
    }

    /// Flags for a foot while the leg beside it could not be searched.
    pub(super) fn flags(&self) -> Flags {
        if self.open && self.unresolved { Flags::SECOND_MINIMUM } else { Flags::default() }
    }

    /// The state if no foot is known, or the foot is known to be the only one.
    pub(super) fn none() -> Self {
        Doubt { furthest: R::MAX, ..Doubt::default() }
    }
}

/// Minimum near a point, if it lies on that point's span, and its parameter; `None` if the distance has no minimum.
fn minimum<R: Real, P: Position>(
    path: &Path<'_, R, P>,
    near: Reference<R>,
    point: impl Fn(&Span<R, P>) -> [R; 3],
    spent: &mut u8,
) -> Option<(Option<Found<R>>, R)> {
    let span = path.span(near.span)?;
    let found = foot(span, &point(span), near.t);
    *spent = spent.saturating_add(2);
    found.converged.then(|| (found.t.is_in_unit().then(|| Found::of(near.span, &found)), found.t))
}

/// A point near the minimum on the leg that the reference is on, by a step along the tangent.
fn near_minimum_on_reference_leg<R: Real, P: Position>(
    on: &OnPath<'_, R, P>,
    max_lag: R,
    point: impl Fn(&Span<R, P>) -> [R; 3],
    spent: &mut u8,
) -> Option<Reference<R>> {
    let OnPath { path, reference } = on;
    let span = path.span(reference.span)?;
    let e = evaluate(span, &point(span), reference.t);
    *spent = spent.saturating_add(1);
    let lag = e.g / e.straight.root();
    // False for NaN too.
    let in_reach = lag.abs() <= max_lag;
    Some(in_reach.then(|| advance(path, *reference, -lag))??.to)
}
