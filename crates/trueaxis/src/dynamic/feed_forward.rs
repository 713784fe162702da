//! Feed-forward of an axis: the position offset that makes the drive supply friction, lag and acceleration.
//!
//! With v the velocity of command plus geometric correction, a their acceleration, T the period and the drive figures of
//! the axis, in velocities (a force divided by the moved mass and K_vp):
//!
//! ```text
//! f  <- (f + v T/z) / (1 + |v| T/z)                      friction state, −1 … 1; Dahl, implicit: cannot overshoot
//! F   = F_c (1 + s/(1 + (v/v_s)²)) f + d v + a/K_vp      required error of the velocity loop
//! h  <- (h + ΔF) e^(−T/τ)                                the share that its integrator does not supply yet
//! u  <- k u + (h + (1 − k_ff) v) g                       k = e^(−K_v T/k_ff),  g = (1 − k)/K_v
//! ```
//!
//! The geometric correction enters rate-limited, ahead of the axis limiter: the part withheld by that limiter would
//! return through a, with a gain of 1/(K_vp T). The last line is k_ff u' = h + (1 − k_ff) v − K_v u, exact for inputs
//! that are constant over a period; for k_ff = 0 it is u = (h + v)/K_v. Where the machine states a lag L, it takes the
//! place of the drive's own: L K_v instead of 1 − k_ff. Where friction adapts ([`super::adapt`]), its factors multiply F_c
//! and 1/z. On trial, shares of ΔF and of the velocity lead a part that harms out ([`super::evidence`]). Cost: two divisions
//! and some 20 multiplications and additions per axis.

#![deny(clippy::indexing_slicing)]

use super::Dynamics;
use super::adapt::{Factors, Intervals};
use crate::machine::{AxisServo, DynamicSettings};
use crate::real::Real;

/// Constants of an axis, lengths per period.
#[derive(Clone, Copy, Debug)]
pub(super) struct FeedForward<R> {
    /// 1/z.
    per_presliding: R,
    /// 1/(v_s T).
    per_stribeck: R,
    coulomb: R,
    stribeck: R,
    viscous: R,
    /// In periods.
    lead: R,
    /// 1/(K_vp T): multiplies a change of the velocity.
    acceleration: R,
    /// 1 − k_ff.
    lag: R,
    /// e^(−T/τ).
    decay: R,
    keep: R,
    gain: R,
    /// Where the friction may adapt.
    intervals: Option<Intervals<R>>,
}

/// State of an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drift<R> {
    /// Friction state f, −1 … 1.
    friction: R,
    force: R,
    /// Force that the integrator does not supply yet.
    missing: R,
    /// The position offset, mm (deg).
    offset: R,
    /// mm (deg) per period.
    velocity: R,
    /// Factors on the identified friction.
    pub(super) factors: Factors<R>,
    /// F of friction and of acceleration, and (1 − k_ff) v, at their full figures; followed while the parts are on trial.
    sliding: R,
    accelerating: R,
    lag: R,
}

impl<R: Real> Default for Drift<R> {
    fn default() -> Self {
        let zero = R::ZERO;
        Drift {
            friction: zero,
            force: zero,
            missing: zero,
            offset: zero,
            velocity: zero,
            factors: Factors::default(),
            sliding: zero,
            accelerating: zero,
            lag: zero,
        }
    }
}

/// Shares of the parts that act, 0 … 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shares<R> {
    pub(super) friction: R,
    pub(super) lag: R,
    pub(super) acceleration: R,
}

impl<R: Real> Drift<R> {
    /// Sets the axis to rest.
    #[inline(always)]
    pub(super) fn rest(&mut self) {
        (self.velocity, self.missing) = (R::ZERO, R::ZERO);
    }

    /// Change of position in the last period.
    #[inline(always)]
    pub(super) fn velocity(&self) -> R {
        self.velocity
    }

    /// Friction state f.
    #[inline(always)]
    pub(super) fn friction(&self) -> R {
        self.friction
    }

    /// Changes the force, of which the drive already supplies the same share.
    pub(super) fn shift(&mut self, force: R, factor: R) {
        self.force += force;
        self.sliding += force;
        self.missing = self.missing * factor;
    }

    /// The rise of the force that the shares leave out, nothing at full shares; takes over F of friction, F of acceleration
    /// and (1 − k_ff) v of the cycle.
    #[inline(never)]
    fn withheld(&mut self, shares: &Shares<R>, sliding: R, accelerating: R, lag: R) -> R {
        let withheld = (R::ONE - shares.friction) * (sliding - self.sliding)
            + (R::ONE - shares.acceleration) * (accelerating - self.accelerating);
        (self.sliding, self.accelerating, self.lag) = (sliding, accelerating, lag);
        withheld
    }

    /// F of friction at its full share.
    #[inline(always)]
    pub(super) fn sliding(&self) -> R {
        self.sliding
    }

    /// F of acceleration at its full share.
    #[inline(always)]
    pub(super) fn accelerating(&self) -> R {
        self.accelerating
    }

    /// (1 − k_ff) v at its full share.
    #[inline(always)]
    pub(super) fn lag(&self) -> R {
        self.lag
    }
}

impl<R: Real> FeedForward<R> {
    /// Creates the law of an axis without feed-forward.
    pub(super) fn none() -> Self {
        let zero = R::ZERO;
        FeedForward {
            per_presliding: zero,
            per_stribeck: zero,
            coulomb: zero,
            stribeck: zero,
            viscous: zero,
            lead: zero,
            acceleration: zero,
            lag: zero,
            decay: zero,
            keep: zero,
            gain: zero,
            intervals: None,
        }
    }

    /// Creates the law of an axis; zero without its drive figures.
    pub(super) fn new(servo: &AxisServo, dynamic: &DynamicSettings, period_s: f64) -> Self {
        let mut law = FeedForward::none();
        let Some(drive) = servo.drive else { return law };
        let shared = drive.velocity_feed_forward;
        // Without feed-forward the offset follows immediately.
        let keep = if shared > 0.0 { libm::exp(-drive.position_gain_per_s * period_s / shared) } else { 0.0 };
        law.keep = R::of(keep);
        law.gain = R::of((1.0 - keep) / (drive.position_gain_per_s * period_s));
        law.decay = R::of(libm::exp(-period_s / drive.reset_time_s));
        if dynamic.lag {
            let own = 1.0 - shared;
            law.lag = R::of(if dynamic.lag_s > 0.0 { dynamic.lag_s * drive.position_gain_per_s } else { own });
        }
        if dynamic.acceleration {
            law.acceleration = R::of(1.0 / (drive.velocity_gain_per_s * period_s));
        }
        if let Some(friction) = servo.friction {
            law.per_presliding = R::of(1.0 / friction.presliding);
            law.per_stribeck = R::of(1.0 / (friction.stribeck_velocity_per_s * period_s));
            law.coulomb = R::of(friction.coulomb_per_s * period_s);
            law.stribeck = R::of(friction.coulomb_per_s * friction.stribeck_share * period_s);
            law.viscous = R::of(friction.viscous);
            law.lead = R::of(friction.lead_s / period_s);
            law.intervals = (friction.adapt > 0.0).then(|| Intervals::new(friction.adapt));
        }
        law
    }

    /// Where the friction may adapt.
    #[inline(always)]
    pub(super) fn intervals(&self) -> Option<&Intervals<R>> {
        self.intervals.as_ref()
    }

    /// Factors of Coulomb friction and of 1/z.
    #[inline(always)]
    fn factors(&self, state: &Drift<R>) -> [R; 2] {
        match &self.intervals {
            None => [R::ONE; 2],
            Some(intervals) => [intervals.level.used(&state.factors.level), intervals.rate.used(&state.factors.rate)],
        }
    }

    /// The distance of the lead's velocity.
    #[inline(always)]
    pub(super) fn ahead(&self, way: R, change: R) -> R {
        way + change * self.lead
    }

    /// That distance over the pre-sliding.
    #[inline(always)]
    pub(super) fn travel(&self, state: &Drift<R>, ahead: R) -> R {
        let [_, rate] = self.factors(state);
        ahead * self.per_presliding * rate
    }

    /// Force of sliding friction without its viscous part.
    #[inline(always)]
    pub(super) fn sliding(&self, state: &Drift<R>, ahead: R) -> R {
        let [level, _] = self.factors(state);
        let ratio = ahead * self.per_stribeck;
        (self.coulomb + self.stribeck / (R::ONE + ratio * ratio)) * level
    }

    #[inline(always)]
    pub(super) fn viscous(&self) -> R {
        self.viscous
    }

    /// The offset of a cycle that takes no time: the previous one.
    #[inline(always)]
    pub(super) fn held_offset(&self, state: &Drift<R>) -> R {
        // Zero without a law, even if a loop before an exchange has left an offset.
        if self.gain == R::ZERO { R::ZERO } else { state.offset }
    }

    /// The offset of a cycle in which the axis moves by `way`. `supplied`: the drive already supplies the present force;
    /// `shares`: while the parts are on trial.
    #[inline(always)]
    pub(super) fn offset(
        &self,
        state: &mut Drift<R>,
        way: R,
        parts: Dynamics,
        supplied: bool,
        shares: Option<&Shares<R>>,
    ) -> R {
        let change = way - state.velocity;
        let ahead = self.ahead(way, change);
        let travel = self.travel(state, ahead);
        state.friction = (state.friction + travel) / (R::ONE + travel.abs());
        let (mut sliding, mut accelerating) = (R::ZERO, R::ZERO);
        if parts.has(Dynamics::FRICTION) {
            sliding = self.sliding(state, ahead) * state.friction + self.viscous * way;
        }
        let mut force = sliding;
        if parts.has(Dynamics::ACCELERATION) {
            accelerating = self.acceleration * change;
            force += accelerating;
        }
        let mut rise = if supplied { R::ZERO } else { force - state.force };
        let mut lag = if parts.has(Dynamics::LAG) { self.lag * way } else { R::ZERO };
        if let Some(shares) = shares {
            let withheld = state.withheld(shares, sliding, accelerating, lag);
            if !supplied {
                rise -= withheld;
            }
            lag = shares.lag * lag;
        }
        state.missing = (state.missing + rise) * self.decay;
        state.offset = state.offset * self.keep + (state.missing + lag) * self.gain;
        (state.force, state.velocity) = (force, way);
        state.offset
    }
}
