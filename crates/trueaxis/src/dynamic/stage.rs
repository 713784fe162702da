//! The dynamic correction of a cycle.

#![deny(clippy::indexing_slicing)]

use super::adaptation::Adaptation;
use super::common::{self, Common, Room, Shared, Wanted};
use super::crosstalk::Crosstalk;
use super::evidence::{Evidence, Reach, Worth};
use super::feed_forward::FeedForward;
use super::feedback::{Feedback, NotchFilter, NotchState, REVERSAL};
use super::harm::{Harm, Trial, Wave};
use super::spike::Probe;
use super::watch::{Swing, Watch};
use super::{DynamicParts, DynamicState, Dynamics};
use crate::check::{notches, of_dynamic};
use crate::error::ConfigError;
use crate::limiter::{Limiter, LimiterState};
use crate::machine::{AxisOrder, AxisSettings, DynamicSettings, Limits, MachineSettings};
use crate::part::{self, Presence};
use crate::position::Position;
use crate::real::Real;
use crate::sample::{Sample, Verdict};

/// One axis: feed-forward, limiter.
#[derive(Clone, Copy, Debug)]
struct Act<R> {
    law: FeedForward<R>,
    reach: Reach<R>,
    limiter: Limiter<R>,
    /// Limiters that ramp the geometric correction: within the limits of the axis; no faster than friction brakes,
    /// while the acceleration is fed forward.
    ramps: [Limiter<R>; 2],
    /// Whether the axis takes up its lost motion from the reversal of the command.
    takes_up: bool,
    /// Whether the axis is linear: the feedback moves the tip along it.
    is_linear: bool,
    /// Whether the axis takes part in the common lag.
    shares: bool,
    room: Room<R>,
}

impl<R: Real> Act<R> {
    /// An axis that wants nothing.
    fn idle(limiter: Limiter<R>) -> Self {
        let room = Room { magnitude: limiter.magnitude(), whole: limiter.magnitude(), slope: limiter.slope() };
        let (law, reach) = (FeedForward::none(), Reach::new(None, 1.0));
        Act { law, reach, limiter, ramps: [limiter; 2], takes_up: false, is_linear: false, shares: false, room }
    }

    /// The limiter that ramps the geometric correction.
    #[inline(always)]
    fn ramp(&self, slowly: usize) -> &Limiter<R> {
        let [own, slow] = &self.ramps;
        if slowly == 0 { own } else { slow }
    }
}

/// Immutable half of the stage.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DynamicStage<R, P, const N: usize> {
    axes: [Act<R>; N],
    /// Whether any axis takes up its lost motion.
    takes_up: bool,
    common: Option<Common<R>>,
    /// `None` if the friction of no axis adapts.
    adaptation: Option<Adaptation<R, N>>,
    /// `None` if no axis has drive figures.
    evidence: Option<Evidence<R>>,
    feedback: Option<(Feedback<R>, Watch<R>, Harm<R>)>,
    /// Notches of the feedback by linear axis, if any axis has one.
    notches: Option<[NotchFilter<R>; 3]>,
    crosstalk: Option<Crosstalk<R, P>>,
    part: part::Dynamic,
}

/// Inputs of a cycle.
pub(crate) struct Moment<'m, R, const N: usize> {
    /// Geometric correction, rate-limited.
    pub(crate) geometric: &'m [R; N],
    /// Hysteresis of the reversals.
    pub(crate) bands: &'m [R; N],
    /// Contour error of the tip in machine directions; `None` if it cannot be acted on.
    pub(crate) error: Option<[R; 3]>,
    /// Axes that were limited in the last cycle.
    pub(crate) limited: u8,
    /// Whether the cycle took longer than a period.
    pub(crate) late: bool,
}

// Only with dynamic.
impl<R: Real, P: Position, const N: usize> DynamicStage<R, P, N> {
    /// Creates the stage of a machine; `None` if no part of it is configured.
    ///
    /// # Errors
    /// A limit that the scalar cannot represent, an axis that the machine does not have.
    pub(crate) fn new(
        order: &AxisOrder<N>,
        machine: &MachineSettings,
        period_s: f64,
    ) -> Result<Option<Self>, ConfigError> {
        let Some(part) = part::DYNAMIC else { return Ok(None) };
        let feedback = machine.contour.feedback.as_ref();
        let crosstalk = Crosstalk::new(order, machine, period_s)?;
        let mut any = feedback.is_some() || !machine.crosstalk.is_empty();
        let idle = Limiter::new(&DynamicSettings::with_defaults(crate::axis::Axis::X).limits, period_s)?;
        let (mut axes, mut probes) = ([Act::idle(idle); N], [None; N]);
        for ((act, probe), settings) in axes.iter_mut().zip(&mut probes).zip(order.settings(machine)) {
            let Some(settings) = settings else { continue };
            let servo = &settings.servo;
            *probe = Probe::new(servo, period_s);
            any |= servo.friction.is_some() || servo.dynamic.is_some();
            let dynamic = servo.dynamic.unwrap_or(DynamicSettings::with_defaults(settings.axis));
            let limiter: Limiter<R> =
                Limiter::new(&dynamic.limits, period_s).map_err(|error| of_dynamic(error).on(settings.axis))?;
            let law = FeedForward::new(servo, &dynamic, period_s);
            let own = Limiter::new(&settings.limits, period_s).map_err(|error| error.on(settings.axis))?;
            // If it is too slow for the scalar to represent: as fast as the axis may.
            let slow = Limiter::new(&ramp_limits(settings, &dynamic), period_s).unwrap_or(own);
            // So that rounding carries no wanted correction beyond its limit.
            let inside = R::of(1.0 - 16.0 * R::EPSILON.to_f64());
            let room = Room {
                magnitude: limiter.magnitude() * inside,
                whole: own.magnitude() * inside,
                slope: limiter.slope().min(own.slope()),
            };
            let (takes_up, is_linear, shares) = (dynamic.take_up, !settings.axis.is_rotary(), common::shares(settings));
            let reach = Reach::new(servo.drive.as_ref(), period_s);
            *act = Act { law, reach, limiter, ramps: [own, slow], takes_up, is_linear, shares, room };
        }
        let feedback = feedback.map(|settings| {
            (Feedback::new(settings, period_s), Watch::new(settings, period_s), Harm::new(settings, period_s))
        });
        let crosstalk = (!machine.crosstalk.is_empty()).then_some(crosstalk);
        let common = Common::new(order.settings(machine).into_iter().flatten(), period_s);
        let evidence = Evidence::new(order.settings(machine).into_iter().flatten(), period_s);
        let takes_up = axes.iter().any(|act| act.takes_up);
        let mut filters = None;
        for (axis, notch) in notches(machine, period_s) {
            let all = filters.get_or_insert([NotchFilter::none(); 3]);
            if let Some(filter) = all.get_mut(axis.index()) {
                *filter = NotchFilter::new(&notch, period_s);
            }
        }
        let adaptation = probes.iter().any(Option::is_some).then_some(Adaptation { probes });
        Ok(any.then_some(DynamicStage {
            axes,
            takes_up,
            common,
            adaptation,
            evidence,
            feedback,
            notches: filters,
            crosstalk,
            part,
        }))
    }

    /// Makes the calling code unreachable in a build without the part.
    #[inline(always)]
    pub(crate) fn exists(&self) {
        self.part.exists();
    }

    /// Whether the friction of an axis adapts.
    #[inline(always)]
    pub(crate) fn adapts(&self) -> bool {
        self.adaptation.is_some()
    }

    /// Factors on the identified Coulomb friction and pre-sliding of an axis that adapts.
    pub(crate) fn factors(&self, state: &DynamicState<R, P, N>, slot: usize) -> Option<[R; 2]> {
        let (act, drift) = (self.axes.get(slot)?, state.drift.get(slot)?);
        act.law.intervals().map(|intervals| intervals.used(&drift.factors))
    }

    /// Ramps the geometric corrections; returns one bit for every axis that has not reached its correction yet.
    #[inline(always)]
    pub(crate) fn ramp(&self, ramped: &mut [LimiterState<R>; N], wanted: &[R; N], sample: &Sample<P, N>) -> u8 {
        let which = usize::from(sample.input.dynamics.has(Dynamics::ACCELERATION));
        let mut flags = 0;
        if sample.verdict == Verdict::Active && sample.due {
            for (slot, ((act, ramped), wanted)) in self.axes.iter().zip(ramped).zip(wanted).enumerate() {
                flags |= u8::from(act.ramp(which).follow(ramped, *wanted)) << (slot & 7);
            }
            return flags;
        }
        for (slot, (act, ramped)) in self.axes.iter().zip(ramped).enumerate() {
            match sample.verdict {
                Verdict::Hold | Verdict::NoOutput => act.ramp(which).hold(ramped),
                _ if !sample.due => {}
                Verdict::Freeze => act.ramp(which).freeze(ramped),
                _ => flags |= u8::from(act.ramp(which).follow(ramped, R::ZERO)) << (slot & 7),
            }
        }
        flags
    }

    /// Which axes take up their lost motion from the reversal of the command; `None` if no axis does.
    #[inline(always)]
    pub(crate) fn takes_up(&self) -> Option<[bool; N]> {
        self.takes_up.then(|| self.axes.map(|act| act.takes_up))
    }

    /// Writes the correction of a cycle into the record; returns one bit for every axis whose limiter differs from its
    /// target.
    #[inline(always)]
    pub(crate) fn act(
        &self,
        state: &mut DynamicState<R, P, N>,
        sample: &Sample<P, N>,
        moment: &Moment<'_, R, N>,
        parts: &mut DynamicParts<R, N>,
    ) -> u8 {
        let none = [R::ZERO; N];
        (parts.feedback, parts.crosstalk, parts.learned) = (none, none, none);
        match sample.verdict {
            Verdict::Active | Verdict::Freeze if !sample.first => {
                self.want(state, sample, moment, sample.input.dynamics, parts);
            }
            _ => {
                parts.feed_forward = none;
                if self.idle(state, sample, moment, parts) {
                    return 0;
                }
            }
        }
        self.follow(state, moment.geometric, parts, sample.due)
    }

    /// Handles cycles in which nothing is wanted; returns whether nothing moves either.
    #[inline(never)]
    fn idle(
        &self,
        state: &mut DynamicState<R, P, N>,
        sample: &Sample<P, N>,
        moment: &Moment<'_, R, N>,
        parts: &mut DynamicParts<R, N>,
    ) -> bool {
        match sample.verdict {
            _ if sample.first => state.rest(),
            Verdict::Hold | Verdict::NoOutput => {
                let limiters = self.axes.iter().zip(&mut state.limited);
                limiters.for_each(|(act, limited)| act.limiter.hold(limited));
                state.rest();
                parts.sent = state.limited.map(|limited| limited.sent());
                return true;
            }
            // While switched off, friction is still tracked, for a part that is switched on in motion.
            _ => self.want(state, sample, moment, Dynamics::NONE, parts),
        }
        false
    }

    /// Moves the limiters towards the sum of the parts if they are `due`; returns one bit for every axis that still
    /// differs.
    #[inline(always)]
    fn follow(
        &self,
        state: &mut DynamicState<R, P, N>,
        geometric: &[R; N],
        parts: &mut DynamicParts<R, N>,
        due: bool,
    ) -> u8 {
        let mut wanted = [Wanted { sum: R::ZERO, geometric: R::ZERO }; N];
        let laws = parts.feed_forward.iter().zip(&parts.feedback).zip(parts.crosstalk.iter().zip(&parts.learned));
        let axes = self.axes.iter().zip(&state.limited).zip(&mut wanted).zip(geometric);
        let mut free = due && state.share == R::ONE;
        for ((((act, limited), wanted), geometric), ((law, feedback), (crosstalk, learned))) in axes.zip(laws) {
            let sum = *law + *feedback + *crosstalk + *learned;
            *wanted = Wanted { sum, geometric: *geometric };
            free &= act.limiter.passes(limited, sum) && (sum + *geometric).abs() <= act.room.whole;
        }
        let axes = state.limited.iter_mut().zip(&mut parts.sent).zip(&wanted);
        if free {
            for ((limited, sent), wanted) in axes {
                *limited = limited.passed(wanted.sum);
                *sent = wanted.sum;
            }
            return 0;
        }
        self.follow_limited(state, &mut wanted, parts, due)
    }

    /// [`DynamicStage::follow`] where a limit binds: what all axes have in common gives way first.
    #[inline(never)]
    fn follow_limited(
        &self,
        state: &mut DynamicState<R, P, N>,
        wanted: &mut [Wanted<R>; N],
        parts: &mut DynamicParts<R, N>,
        due: bool,
    ) -> u8 {
        if self.common.is_some() {
            if due {
                state.share = common::share(state.share, &state.shared, wanted, &self.axes.map(|act| act.room));
            }
            if state.share < R::ONE {
                for ((shared, wanted), law) in state.shared.iter().zip(&mut *wanted).zip(&mut parts.feed_forward) {
                    let withheld = shared.withheld(state.share);
                    wanted.sum -= withheld;
                    *law -= withheld;
                }
            }
        } else {
            state.share = R::ONE;
        }
        let mut flags = 0;
        let axes = self.axes.iter().zip(&mut state.limited).zip(&mut parts.sent).zip(wanted);
        for (slot, (((act, limited), sent), wanted)) in axes.enumerate() {
            flags |= u8::from(act.limiter.follow_when(due, limited, wanted.sum)) << (slot & 7);
            *sent = limited.sent();
        }
        flags
    }

    /// Computes the offset that each part wants.
    #[inline(always)]
    fn want(
        &self,
        state: &mut DynamicState<R, P, N>,
        sample: &Sample<P, N>,
        moment: &Moment<'_, R, N>,
        on: Dynamics,
        parts: &mut DynamicParts<R, N>,
    ) {
        let fresh = state.fresh;
        // When a part is switched on in motion, the drive already supplies its force.
        let supplied = fresh || state.parts != on;
        if sample.due {
            (state.fresh, state.parts) = (false, on);
        }
        if supplied {
            self.restart(state, on);
        }
        if sample.input.reset {
            state.worth = Worth::new(on.has(Dynamics::ON_TRIAL));
        }
        let shares = state.worth.acting();
        let mut changes = [R::ZERO; N];
        let drift = state.drift.iter_mut().zip(&mut state.shared);
        let memory = drift.zip(&mut state.command).zip(&mut state.geometric_before);
        let moved = sample.command.iter().zip(moment.geometric).zip(&mut changes);
        let laws = self.axes.iter().zip(&mut parts.feed_forward);
        for (((((drift, shared), before), geometric_before), ((command, geometric), change)), (act, offset)) in
            memory.zip(moved).zip(laws)
        {
            let was = drift.velocity();
            let way = if fresh {
                R::ZERO
            } else if moment.late {
                // Several periods in one: the axis counts as having kept its velocity.
                was
            } else {
                command.since_near::<R>(*before) + (*geometric - *geometric_before)
            };
            (*before, *geometric_before) = (*command, *geometric);
            if self.common.is_some() && !act.shares {
                // Another configuration may have left a share.
                *shared = Shared::default();
            }
            if !sample.due {
                // The drives have had no time to move: their laws keep their offsets, and distances count from here.
                *offset = act.law.held_offset(drift);
                continue;
            }
            *change = way - was;
            *offset = act.law.offset(drift, way, on, supplied, shares.as_ref());
            if let (Some(common), true) = (&self.common, act.shares) {
                common.advance(shared, (way, *change), on, supplied, shares.as_ref());
            }
        }
        if let Some(adaptation) = &self.adaptation {
            let follows = sample.verdict == Verdict::Active
                && on.has(Dynamics::FRICTION)
                && sample.due
                && !(supplied || moment.late);
            adaptation.cycle(self.axes.each_ref().map(|act| &act.law), state, sample, &changes, follows);
        }
        if let (Some(evidence), true) = (&self.evidence, sample.due && state.worth.is_on_trial()) {
            let error = moment.error.filter(|_| sample.verdict == Verdict::Active);
            let axes = self.axes.iter().map(|act| &act.reach).zip(&state.drift);
            evidence.judge(&mut state.worth, axes, error);
        }
        self.feed_back(state, sample, moment, on, &mut parts.feedback);
        if let (Some(crosstalk), true) = (&self.crosstalk, on.has(Dynamics::CROSSTALK)) {
            crosstalk.subtract(&mut parts.crosstalk, &changes, sample.command);
        }
        if on.has(Dynamics::LEARNED) && sample.input.learned != [P::default(); 3] {
            for (wanted, learned) in parts.learned.iter_mut().zip(&sample.input.learned) {
                if learned.is_usable() {
                    *wanted = learned.since_near(P::default());
                }
            }
        }
    }

    /// Continues the estimate of what the feed-forward is worth after a part was switched or the drives were at rest.
    #[inline(never)]
    fn restart(&self, state: &mut DynamicState<R, P, N>, on: Dynamics) {
        let forward = Dynamics(Dynamics::FRICTION.0 | Dynamics::LAG.0 | Dynamics::ACCELERATION.0);
        let on_trial = on.has(Dynamics::ON_TRIAL);
        if on.0 & forward.0 == 0 || on_trial != state.worth.is_on_trial() {
            state.worth = Worth::new(on_trial);
        }
        state.worth.supplied();
    }

    /// Computes the offsets of the contour feedback.
    #[inline(always)]
    fn feed_back(
        &self,
        state: &mut DynamicState<R, P, N>,
        sample: &Sample<P, N>,
        moment: &Moment<'_, R, N>,
        on: Dynamics,
        wanted: &mut [R; N],
    ) {
        let Some((feedback, watch, harm)) = &self.feedback else {
            // The new loop has no feedback, so nothing remains to ramp out.
            state.out = false;
            return;
        };
        if !on.has(Dynamics::FEEDBACK) || sample.input.reset {
            (state.swing, state.out) = ([Swing::default(); N], false);
            (state.waves, state.trial) = ([Wave::default(); 3], Trial::new());
        }
        if !on.has(Dynamics::FEEDBACK) || state.out {
            state.integral = [R::ZERO; N];
            state.notched = [NotchState::default(); 3];
            return;
        }
        let linear = state.drift.iter().zip(&self.axes).filter(|(_, act)| act.is_linear);
        // At rest on an end of the path an error that oscillates can be acted on only while it points one way: the integral
        // would follow those half waves alone.
        let rests = on.has(Dynamics::ON_TRIAL) && state.drift.iter().all(|drift| drift.velocity() == R::ZERO);
        let acts = !rests && feedback.reaches(linear.map(|(drift, _)| drift.velocity()));
        let error = moment.error.filter(|_| acts && sample.verdict == Verdict::Active && sample.due);
        let errors = error.unwrap_or_default();
        if error.is_some() {
            state.out |= harm.is_found(&mut state.trial, &mut state.waves, errors, &state.integral);
        }
        // One axis that cannot follow displaces the tool in all directions, so every integral stays constant.
        let limited = moment.limited != 0;
        let motion = state.drift.iter().zip(&mut state.heading).zip(moment.bands);
        let axes = self.axes.iter().zip(&mut state.integral).zip(&mut state.swing).zip(&mut *wanted);
        for (((((act, integral), swing), wanted), ((drift, heading), band)), e) in axes.zip(motion).zip(errors) {
            if sample.due && heading.reverses(drift.velocity(), band.max(R::of(REVERSAL))) {
                *integral = R::ZERO;
            }
            *wanted =
                feedback.offset(integral, error.map(|_| e), state.trial.share(), limited, act.limiter.magnitude());
            if error.is_some() {
                state.out |= watch.swings(swing, e);
            }
        }
        if let Some(notches) = &self.notches {
            for ((notch, state), wanted) in notches.iter().zip(&mut state.notched).zip(wanted) {
                *wanted = notch.filtered(state, *wanted, sample.due);
            }
        }
        if state.out {
            // The limiters ramp the feedback out from this cycle on.
            state.integral = [R::ZERO; N];
        }
    }
}

/// Limits of an axis' geometric correction while the acceleration is fed forward: it accelerates no more than friction
/// brakes. A faster ramp makes the step that takes up lost motion overshoot, and the returning carriage takes up some
/// of the play in the opposite direction, which no reading shows.
fn ramp_limits(settings: &AxisSettings, dynamic: &DynamicSettings) -> Limits {
    match (&settings.servo.drive, &settings.servo.friction) {
        (Some(drive), Some(friction)) if dynamic.acceleration => {
            let braking = friction.coulomb_per_s * drive.velocity_gain_per_s;
            Limits { acceleration_per_s2: settings.limits.acceleration_per_s2.min(braking), ..settings.limits }
        }
        _ => settings.limits,
    }
}
