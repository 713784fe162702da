//! Limits magnitude, slope and acceleration of a correction, so that it can never make a machine jump.
//!
//! In units of one cycle (T = period): C = magnitude, V = slope·T, a = acceleration·T². With r the wanted correction
//! (clamped to ±C), c the sent one, Δ backward differences, in every cycle
//!
//! ```text
//! |c| <= C      |Δc| <= V      |Δ²c| <= a
//! ```
//!
//! and c = r bit for bit from the cycle in which it locks on, for every r that stays inside the three limits itself. The
//! scalar contains the limits rounded towards zero, and c to some units in the last place of C. Positions in nanometres
//! round the sent correction to a step: C is a whole number of steps there, and no drive exceeds it (C up to 1 mm); its
//! Δc may be one step more than V, over any time too, its Δ²c two. While c differs from r it approaches with the braking
//! law
//!
//! ```text
//! g    = r − c − Δr                               distance to the target, in its moving frame
//! U(d, b) = d/n + b(n − 1)/2,  n = max(1, ⌈(√(1 + 8d/b) − 1)/2⌉),  U(d <= 0) = 0
//! want = Δr + sgn(g) U(|g|, 0.8 a)
//! Δc   = want clamped to [max(−V, v − a, −U(C + c, a)), min(V, v + a, U(C − c, a))],   v = Δc of the last cycle
//! ```
//!
//! U(d, b) is the largest speed from which whole cycles of deceleration b stop within d. Note: the limiter catches up
//! slowly with a ramp just below V that started from rest, and never with one above V; it chatters while following a
//! target that jitters by more than a per cycle; it reaches limits lowered in motion with a. It flags all of these as
//! *limited*.
//!
//! While the output holds a drive, c stays the difference between drive and held command: its speed is cut to zero, and
//! it continues from there ([`Limiter::hold`]).
//!
//! A cycle of this law takes a period of time: a cycle that comes too early is not counted, and the state does not change
//! ([`crate::Input::elapsed_ns`]). So the limits in seconds apply however cycles arrive.

#![deny(clippy::indexing_slicing)]

use crate::error::{ConfigError, Field};
use crate::machine::Limits;
use crate::real::Real;

/// Limits of one axis in units of one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limiter<R> {
    magnitude: R,
    velocity: R,
    acceleration: R,
    /// Below this |r| a stop at full speed always fits: C − V − V²/2a.
    open: R,
    /// 8 / (0.8 a) and 8 / a.
    approach: R,
    brake: R,
    /// From this |g| on the approach speed exceeds 2 V: (2V)²/(2 · 0.8 a) + 2 V.
    far: R,
    /// |g| up to this counts as rounding: some units in the last place of C.
    rounding: R,
}

/// State of the limiter of one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LimiterState<R> {
    sent: R,
    velocity: R,
    target: R,
}

impl<R: Real> LimiterState<R> {
    /// The correction sent, mm (deg).
    #[inline(always)]
    pub fn sent(&self) -> R {
        self.sent
    }

    /// The state at rest on a correction.
    #[inline(always)]
    pub(crate) fn at_rest(sent: R) -> Self {
        LimiterState { sent, velocity: R::ZERO, target: sent }
    }

    /// Whether the limiter sent the target unchanged.
    #[inline(always)]
    pub(crate) fn is_locked(&self) -> bool {
        self.sent == self.target
    }

    /// The state after sending `wanted` unchanged.
    #[inline(always)]
    pub(crate) fn passed(&self, wanted: R) -> Self {
        LimiterState { sent: wanted, velocity: wanted - self.target, target: wanted }
    }

    /// Change of the correction in the last cycle.
    #[inline(always)]
    pub fn velocity(&self) -> R {
        self.velocity
    }
}

/// The approach uses 0.8 of the permitted acceleration; the rest is for a target that accelerates itself.
const APPROACH: f64 = 0.8;

impl<R: Real> Limiter<R> {
    /// Converts limits in seconds into limits per cycle.
    ///
    /// # Errors
    /// A limit that is not positive and finite, or that the scalar cannot represent: one that it rounds to zero, above a
    /// sixteenth of its largest number (2e37 in f32; sums of limits must not overflow), or a below 1e-7 of C (f32; 1e-15
    /// in f64), which is lost in rounding.
    pub fn new(limits: &Limits, period_s: f64) -> Result<Self, ConfigError> {
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let refuse = |field, found, needed| Err(ConfigError::new(field, found, needed));
        if !positive(limits.magnitude) {
            return refuse(Field::Magnitude, limits.magnitude, "a positive number");
        }
        if !positive(limits.slope_per_s) {
            return refuse(Field::Slope, limits.slope_per_s, "a positive number");
        }
        if !positive(limits.acceleration_per_s2) {
            return refuse(Field::Acceleration, limits.acceleration_per_s2, "a positive number");
        }
        if !positive(period_s) {
            return refuse(Field::Period, period_s, "a positive number");
        }
        let (c, v, a) =
            (limits.magnitude, limits.slope_per_s * period_s, limits.acceleration_per_s2 * period_s * period_s);
        let resolution = R::EPSILON.to_f64() * c;
        if a <= resolution {
            return refuse(Field::Acceleration, a, "a change per cycle above the resolution of the correction");
        }
        let largest = R::MAX.to_f64() / 16.0;
        for (field, limit) in [(Field::Magnitude, c), (Field::Slope, v), (Field::Acceleration, a)] {
            if R::of(limit) <= R::ZERO || limit > largest {
                return refuse(field, limit, "a limit that the scalar holds, up to a sixteenth of its largest number");
            }
        }
        let limiter = Limiter {
            magnitude: towards_zero(c),
            velocity: towards_zero(v),
            acceleration: towards_zero(a),
            open: towards_zero(c - v - v * v / (2.0 * a)),
            approach: R::of(8.0 / (APPROACH * a)),
            brake: R::of(8.0 / a),
            far: R::of(2.0 * v * (v / (APPROACH * a) + 1.0)),
            rounding: R::of(8.0 * resolution),
        };
        Ok(limiter)
    }

    /// Magnitude limit C.
    pub fn magnitude(&self) -> R {
        self.magnitude
    }

    /// Slope limit V.
    pub(crate) fn slope(&self) -> R {
        self.velocity
    }

    /// Below this |r| a stop at full speed always fits: C − V − V²/2a. Beyond it a correction never passes unchanged.
    pub(crate) fn open(&self) -> R {
        self.open
    }

    /// Takes the wanted correction of this cycle and sets the one to send; returns whether they differ (*limited*).
    ///
    /// Cost: some 40 host instructions per axis while no limit binds; otherwise a square root or two out of line.
    #[inline(always)]
    pub fn follow(&self, state: &mut LimiterState<R>, wanted: R) -> bool {
        if self.passes(state, wanted) {
            *state = state.passed(wanted);
            return false;
        }
        self.approach(state, wanted)
    }

    /// [`Limiter::follow`] if a cycle is due; otherwise no time has passed, and the state does not change.
    #[inline(always)]
    pub(crate) fn follow_when(&self, due: bool, state: &mut LimiterState<R>, wanted: R) -> bool {
        if due { self.follow(state, wanted) } else { state.sent != wanted }
    }

    /// Whether the state is locked on and the target keeps the limits: [`Limiter::follow`] then sends `wanted` unchanged,
    /// without root or rounding.
    #[inline(always)]
    pub(crate) fn passes(&self, state: &LimiterState<R>, wanted: R) -> bool {
        state.is_locked() && self.follows(state, wanted)
    }

    /// Like [`Limiter::passes`], for a state known to be locked on.
    #[inline(always)]
    pub(crate) fn follows(&self, state: &LimiterState<R>, wanted: R) -> bool {
        let change = wanted - state.target;
        change.abs() <= self.velocity
            && (change - state.velocity).abs() <= self.acceleration
            && wanted.abs() <= self.open
    }

    /// Takes no new target: decelerates to rest with the permitted acceleration and stays there.
    #[inline(always)]
    pub fn freeze(&self, state: &mut LimiterState<R>) {
        let velocity = state.velocity - state.velocity.limit(-self.acceleration, self.acceleration);
        let sent = state.sent + velocity;
        *state = LimiterState { sent, velocity, target: sent };
    }

    /// The drive stops, and so does the correction: the next motion starts from rest. The velocity is cut, not braked.
    #[inline(always)]
    pub fn hold(&self, state: &mut LimiterState<R>) {
        *state = LimiterState::at_rest(state.sent);
    }

    #[inline(never)]
    fn approach(&self, state: &mut LimiterState<R>, wanted: R) -> bool {
        let LimiterState { sent: c, velocity: v, target: last } = *state;
        let (slowest, fastest) = (v - self.acceleration, v + self.acceleration);
        // Usually both corrections are far from the magnitude, and no limit was lowered in motion.
        let is_usual = wanted.abs() <= self.open && c.abs() <= self.open && v.abs() <= self.velocity;
        let (r, lowest, highest) = if is_usual {
            (wanted, slowest.max(-self.velocity), fastest.min(self.velocity))
        } else {
            let r = wanted.limit(-self.magnitude, self.magnitude);
            let (down, up) = self.room(c);
            // The acceleration has priority, in case limits were lowered in motion.
            let (lowest, highest) = (down.max(slowest).min(fastest), up.min(fastest).max(slowest));
            (r, lowest, highest)
        };
        let moves = (r - last).limit(-self.velocity, self.velocity);
        let gap = r - c - moves;

        let direct = r - c;
        let lock = gap.abs() <= self.rounding && direct >= lowest && direct <= highest;
        let (sent, velocity) = if lock {
            (r, direct)
        } else {
            let closing = self.closing_speed(gap.abs());
            let want = if gap < R::ZERO { moves - closing } else { moves + closing };
            let velocity = want.limit(lowest, highest);
            (c + velocity, velocity)
        };
        *state = LimiterState { sent, velocity, target: r };
        sent != wanted
    }

    /// Fastest changes of a correction c from which it stops within the magnitude, and within the slope.
    #[inline(always)]
    fn room(&self, c: R) -> (R, R) {
        if c.abs() <= self.open {
            return (-self.velocity, self.velocity);
        }
        let speed = |room| stopping_speed(room, self.acceleration, self.brake).min(self.velocity);
        (-speed(self.magnitude + c), speed(self.magnitude - c))
    }

    /// U(|g|, 0.8 a), or a speed that the slope limits in any case, whichever way the target moves.
    #[inline(always)]
    fn closing_speed(&self, gap: R) -> R {
        if gap >= self.far {
            return R::TWO * self.velocity;
        }
        stopping_speed(gap, R::of(APPROACH) * self.acceleration, self.approach)
    }
}

/// Time to move a correction at rest by the distance `way`, mm (deg), to a target at rest, s.
///
/// With V and A the limits in seconds, by the law above without its rounding to whole cycles: acceleration A up to the
/// speed v, deceleration 0.8 A from it,
///
/// ```text
/// B = v²/2 · (1/A + 1/0.8A)     t = v (1/A + 1/0.8A)  + (|way| − B)/V where v = V, B < |way|
/// ```
pub fn ramp_in_s(limits: &Limits, way: f64) -> f64 {
    let (way, top) = (way.abs(), limits.slope_per_s);
    let both = (1.0 + 1.0 / APPROACH) / limits.acceleration_per_s2;
    let ramps = 0.5 * top * top * both;
    if way <= ramps { libm::sqrt(2.0 * way * both) } else { top * both + (way - ramps) / top }
}

/// Rounds a limit to the scalar, towards zero.
fn towards_zero<R: Real>(limit: f64) -> R {
    let nearest = R::of(limit);
    if nearest.to_f64().abs() > limit.abs() { R::of(limit * (1.0 - R::EPSILON.to_f64())) } else { nearest }
}

/// U(d, b): the largest speed from which whole cycles of deceleration `b` stop within `d`; `eight_over_b` = 8/b.
#[inline(always)]
fn stopping_speed<R: Real>(d: R, b: R, eight_over_b: R) -> R {
    if d <= R::ZERO {
        return R::ZERO;
    }
    let cycles = ((R::ONE + d * eight_over_b).root() - R::ONE) * R::HALF;
    let whole = R::of_i32(cycles.to_i32());
    let n = if whole < cycles { whole + R::ONE } else { whole }.max(R::ONE);
    d / n + b * (n - R::ONE) * R::HALF
}

#[cfg(test)]
mod tests;
