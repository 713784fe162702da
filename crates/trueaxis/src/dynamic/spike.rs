//! What a reversal leaves of friction: the error of the stated Coulomb friction and pre-sliding, from the spike.
//!
//! From the cycle of a reversal on, for at least 6/K_v, a model of the drive follows what was sent to it. With p the distance by which
//! the axis is behind, v its velocity, F the friction, Δr the distance sent, all per period:
//!
//! ```text
//! w = K_v T p + k_ff Δr                      velocity wanted, in n parts of the period:
//! I <- I + (w − v) T/(n τ)
//! a <- a + (w − v + I − a) (1 − e^(−T/(n t_c)))
//! v <- v + (a − F − d v) K_vp T/n            p <- p − v/n,  at the end of the period  p <- p + Δr
//! ```
//!
//! The model is linear: one copy of it starts at the reading and takes the motion sent, a second one takes the stated
//! friction at the velocity of both (φ, how far it pushes the axis back), a third one the change of that friction with the
//! pre-sliding. A Coulomb friction that differs from the stated by the share l_c and a pre-sliding that differs by l_z leave of the readings
//!
//! ```text
//! e = l_c φ + l_z ∂φ/∂ln z + line in time + noise
//! ```
//!
//! whose shares are fitted. A share counts only if its shape explains more of the energy than an eighth of what the fit leaves, and
//! than 16/n of it, n the number of cycles: of white noise it explains 1/n. So noise, an oscillation or a cutting force that has not
//! the shape of a spike moves nothing. The spike has to be seen whole: from friction saturated on one side to friction
//! saturated on the other, without another reversal, a refused reading, a stop or a late cycle.
//!
//! One window serves all axes; the others wait. Between windows an axis costs a comparison a cycle.

#![deny(clippy::indexing_slicing)]

use super::feed_forward::{Drift, FeedForward};
use crate::machine::AxisServo;
use crate::position::Position;
use crate::real::Real;

/// Length of a window, in 1/K_v; of the watch on stick-slip, in windows.
const LENGTH: f64 = 6.0;
const WATCHED: u32 = 4;
/// Shortest and longest window, cycles.
const SHORTEST: f64 = 16.0;
const LONGEST: f64 = 20_000.0;
/// Longest part of a period, in 1/K_vp, and the largest number of parts.
const PART: f64 = 0.025;
const PARTS: u32 = 16;
/// Friction state that counts as saturated.
pub(super) const SATURATED: f64 = 0.98;
/// Relative change of the pre-sliding over which its effect is computed.
const WIDER: f64 = 0.125;
/// Energy that a shape has to explain, of what the fit leaves; in white noise, this many times its expected energy.
const EXPLAINED: f64 = 0.125;
const BEYOND_NOISE: f64 = 16.0;
/// Share of the effect of pre-sliding that has to differ from that of the level.
const DISTINCT: f64 = 0.1;
/// A stick is as high as this share of Coulomb friction over the position gain.
const STICK: f64 = 0.5;

/// Constants of an axis, lengths per period.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probe<R> {
    /// Shortest window.
    cycles: u32,
    /// Parts of a period, and their share of it.
    parts: u32,
    part: R,
    /// K_v T, k_ff.
    position: R,
    fed: R,
    /// T/(n τ), 1 − e^(−T/(n t_c)), K_vp T/n.
    reset: R,
    current: R,
    velocity: R,
    /// 1/(K_vp T): multiplies a change of the velocity.
    acceleration: R,
    /// Lag, periods.
    lag: R,
    /// Share of a filter for the dead time.
    late: R,
    stick: R,
}

impl<R: Real> Probe<R> {
    /// `None` if the axis does not adapt.
    pub(super) fn new(servo: &AxisServo, period_s: f64) -> Option<Self> {
        let (drive, friction) = (servo.drive?, servo.friction.filter(|friction| friction.adapt > 0.0)?);
        let filter = |time_s: f64, of: f64| R::of(if of > 0.0 { 1.0 - libm::exp(-time_s / of) } else { 1.0 });
        let (position, velocity) = (drive.position_gain_per_s * period_s, drive.velocity_gain_per_s * period_s);
        let parts = libm::ceil(velocity / PART).limit(1.0, f64::from(PARTS));
        let part_s = period_s / parts;
        let length_s = LENGTH / drive.position_gain_per_s + drive.dead_time_s;
        let cycles = libm::ceil((length_s / period_s).limit(SHORTEST, LONGEST));
        Some(Probe {
            cycles: cycles as u32,
            parts: parts as u32,
            part: R::of(1.0 / parts),
            position: R::of(position),
            fed: R::of(drive.velocity_feed_forward),
            reset: R::of(part_s / drive.reset_time_s),
            current: filter(part_s, drive.current_loop_s),
            velocity: R::of(velocity / parts),
            acceleration: R::of(1.0 / velocity),
            lag: R::of((1.0 - drive.velocity_feed_forward) / position),
            late: filter(period_s, drive.dead_time_s),
            stick: R::of(STICK * friction.coulomb_per_s / drive.position_gain_per_s),
        })
    }
}

/// What an axis does in a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion<R, P> {
    /// Command plus geometric correction sent last, the dynamic correction sent last, and the reading.
    pub(super) drive: P,
    pub(super) dynamic: R,
    pub(super) reading: P,
    /// Distance of this cycle, and its change.
    pub(super) way: R,
    pub(super) change: R,
}

/// What a window found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Left<R> {
    /// Relative error of the Coulomb friction in use.
    pub(super) level: R,
    /// Whether it is beyond noise.
    pub(super) is_clear: bool,
    /// Relative error of the pre-sliding in use, 0 if it cannot be told.
    pub(super) presliding: R,
}

/// What a cycle of a window shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Seen<R> {
    Nothing,
    /// The window cannot go on.
    Lost,
    /// The spike has been seen whole.
    Spike(Left<R>),
    /// The watch on stick-slip has ended; whether the axis stuck repeatedly.
    Ended(bool),
}

/// Model of the drive.
#[derive(Clone, Copy, Debug, Default)]
struct Model<R> {
    behind: R,
    velocity: R,
    integral: R,
    /// Acceleration given by the current loop, as a velocity.
    given: R,
    /// `behind`, later by the dead time.
    seen: R,
}

impl<R: Real> Model<R> {
    /// Velocity wanted in a period in which `sent` is sent.
    #[inline(always)]
    fn wanted(&self, probe: &Probe<R>, sent: R) -> R {
        self.behind * probe.position + sent * probe.fed
    }

    /// A part of a period in which `force` acts.
    #[inline(always)]
    fn advance(&mut self, probe: &Probe<R>, wanted: R, force: R, viscous: R) {
        let error = wanted - self.velocity;
        self.integral += error * probe.reset;
        self.given += (error + self.integral - self.given) * probe.current;
        self.velocity += (self.given - force - viscous * self.velocity) * probe.velocity;
        self.behind -= self.velocity * probe.part;
    }

    /// Ends a period.
    #[inline(always)]
    fn end(&mut self, probe: &Probe<R>, sent: R) {
        self.behind += sent;
        self.seen += (self.behind - self.seen) * probe.late;
    }
}

/// Sum of a signal over a window, and of its product with the time.
#[derive(Clone, Copy, Debug, Default)]
struct Line<R> {
    sum: R,
    moment: R,
}

impl<R: Real> Line<R> {
    #[inline(always)]
    fn add(&mut self, value: R, time: R) {
        self.sum += value;
        self.moment += value * time;
    }
}

/// Sums over a window: c the shape of the level, z that of pre-sliding, e the rest.
#[derive(Clone, Copy, Debug, Default)]
struct Sums<R> {
    c: Line<R>,
    z: Line<R>,
    e: Line<R>,
    cc: R,
    cz: R,
    zz: R,
    ce: R,
    ze: R,
    ee: R,
}

impl<R: Real> Sums<R> {
    #[inline(always)]
    fn add(&mut self, c: R, z: R, e: R, time: R) {
        self.c.add(c, time);
        self.z.add(z, time);
        self.e.add(e, time);
        self.cc += c * c;
        self.cz += c * z;
        self.zz += z * z;
        self.ce += c * e;
        self.ze += z * e;
        self.ee += e * e;
    }

    /// The shares that fit best, beside a line in time.
    #[inline(never)]
    fn fit(&self, cycles: u32) -> Left<R> {
        let count = R::of_i32(cycles as i32);
        // (n − 1)/2, 1/n, 1/Σ(k − (n − 1)/2)².
        let (middle, per_cycle) = (R::HALF * (count - R::ONE), R::ONE / count);
        let per_square = R::of(12.0) / (count * (count * count - R::ONE));
        let rest = |product: R, a: &Line<R>, b: &Line<R>| {
            let about = |line: &Line<R>| line.moment - middle * line.sum;
            product - a.sum * b.sum * per_cycle - about(a) * about(b) * per_square
        };
        let Sums { c, z, e, .. } = self;
        let (cc, cz, zz) = (rest(self.cc, c, c), rest(self.cz, c, z), rest(self.zz, z, z));
        let (ce, ze, ee) = (rest(self.ce, c, e), rest(self.ze, z, e), rest(self.ee, e, e));
        let determinant = cc * zz - cz * cz;
        let least = R::of(EXPLAINED).max(R::of(BEYOND_NOISE) * per_cycle);
        let of = |share: R, energy: R, left: R| share * share * energy > least * left.max(R::ZERO);
        if determinant > R::of(DISTINCT) * cc * zz {
            let (level, presliding) = ((ce * zz - ze * cz) / determinant, (ze * cc - ce * cz) / determinant);
            let left = ee - level * ce - presliding * ze;
            let is_clear = of(level, determinant / zz, left);
            let tells = of(presliding, determinant / cc, left);
            return Left { level, is_clear, presliding: if tells { presliding } else { R::ZERO } };
        }
        let level = ce / cc;
        Left { level, is_clear: of(level, cc, ee - level * ce), presliding: R::ZERO }
    }
}

/// A lag that rises while the reading stands still and falls again, repeatedly.
#[derive(Clone, Copy, Debug, Default)]
struct Sticks<R> {
    /// Distance that the reading has moved.
    at: R,
    /// Lag and distance at the last turn, and where the lag was largest or smallest since.
    turn: [R; 2],
    top: [R; 2],
    falls: bool,
    count: u8,
}

impl<R: Real> Sticks<R> {
    #[inline(always)]
    fn see(&mut self, lag: R, way: R, level: R) {
        self.at += way;
        let [top, _] = self.top;
        let beyond = if self.falls { top - lag } else { lag - top };
        if beyond >= R::ZERO {
            self.top = [lag, self.at];
        } else if beyond < -level {
            self.turn_over(lag, level);
        }
    }

    fn turn_over(&mut self, lag: R, level: R) {
        let ([low, from], [high, to]) = (self.turn, self.top);
        let (rise, moved) = (high - low, to - from);
        if !self.falls && rise > level && moved.abs() * R::of(4.0) <= rise {
            self.count = self.count.saturating_add(1);
        }
        self.falls = !self.falls;
        (self.turn, self.top) = (self.top, [lag, self.at]);
    }
}

/// Sticks in a window from which on it counts; the one at the reversal is friction itself.
const STICKS: u8 = 3;

/// A window after a reversal; free while `cycle` is 0.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spike<R, P> {
    cycle: u32,
    pub(super) slot: u8,
    drive: P,
    dynamic: R,
    /// p in the last cycle.
    behind: R,
    /// Without friction, of friction alone, of the change of friction with the pre-sliding.
    motion: Model<R>,
    level: Model<R>,
    presliding: Model<R>,
    /// Friction state, and that with a wider pre-sliding.
    state: R,
    wider: R,
    measured: bool,
    /// 1 or −1.
    side: R,
    sums: Sums<R>,
    sticks: Sticks<R>,
}

impl<R: Real, P: Position> Spike<R, P> {
    /// Whether no axis has it.
    #[inline(always)]
    pub(super) fn is_free(&self) -> bool {
        self.cycle == 0
    }

    /// Whether a spike is being measured, so that no other axis may begin.
    #[inline(always)]
    pub(super) fn is_taken(&self) -> bool {
        self.cycle != 0 && !self.measured
    }

    pub(super) fn end(&mut self) {
        self.cycle = 0;
    }

    /// The window that begins at a reversal.
    #[inline(never)]
    pub(super) fn at_reversal(
        slot: u8,
        probe: &Probe<R>,
        law: &FeedForward<R>,
        drift: &Drift<R>,
        motion: &Motion<R, P>,
    ) -> Self {
        let Motion { drive, dynamic, reading, way, change } = *motion;
        let behind = drive.since_near::<R>(reading) + dynamic;
        let side = if way < R::ZERO { -R::ONE } else { R::ONE };
        let mut spike = Spike { cycle: 1, slot, drive, dynamic, behind, side, ..Spike::default() };
        // What the axis does now; whatever force that takes beyond the proportional gain, the integrator supplies.
        let mean = way - change * probe.lag;
        let given = change * probe.acceleration + law.viscous() * mean;
        let integral = given - (behind * probe.position + way * probe.fed - mean);
        let velocity = mean - R::HALF * change;
        spike.motion = Model { behind, velocity, integral, given, ..Model::default() };
        // Before the reversal, friction was saturated against the last motion.
        (spike.state, spike.wider) = (-side, -side);
        let friction = law.sliding(drift, velocity) * -side;
        spike.level = Model { integral: friction, given: friction, ..Model::default() };
        let start = [behind * side, R::ZERO];
        (spike.sticks.turn, spike.sticks.top) = (start, start);
        spike
    }

    /// Moves the window by a cycle.
    #[inline(never)]
    pub(super) fn advance(
        &mut self,
        probe: &Probe<R>,
        law: &FeedForward<R>,
        drift: &Drift<R>,
        motion: &Motion<R, P>,
    ) -> Seen<R> {
        let Motion { drive, dynamic, reading, way, .. } = *motion;
        if way * self.side < R::ZERO {
            return Seen::Lost;
        }
        let behind = drive.since_near::<R>(reading) + dynamic;
        let sent = drive.since_near::<R>(self.drive) + (dynamic - self.dynamic);
        let moved = sent - (behind - self.behind);
        (self.drive, self.dynamic, self.behind) = (drive, dynamic, behind);
        self.sticks.see(behind * self.side, moved * self.side, probe.stick);
        if self.measured {
            self.cycle += 1;
            let ends = self.cycle > WATCHED * probe.cycles;
            return if ends { Seen::Ended(self.sticks.count >= STICKS) } else { Seen::Nothing };
        }
        self.measure(probe, law, drift, sent)
    }

    fn measure(&mut self, probe: &Probe<R>, law: &FeedForward<R>, drift: &Drift<R>, sent: R) -> Seen<R> {
        self.follow(probe, law, drift, sent);
        let rest = self.behind - self.motion.behind - self.level.seen;
        let time = R::of_i32(self.cycle as i32 - 1);
        self.sums.add(self.level.seen, self.presliding.seen, rest, time);
        let cycles = self.cycle;
        self.cycle += 1;
        if cycles < probe.cycles {
            return Seen::Nothing;
        }
        if self.state * self.side >= R::of(SATURATED) {
            self.measured = true;
            return Seen::Spike(self.sums.fit(cycles));
        }
        if cycles >= WATCHED * probe.cycles { Seen::Lost } else { Seen::Nothing }
    }

    /// Moves the models by a period.
    #[inline(always)]
    fn follow(&mut self, probe: &Probe<R>, law: &FeedForward<R>, drift: &Drift<R>, sent: R) {
        let (fixed, viscous) = (R::ZERO, law.viscous());
        let motion = self.motion.wanted(probe, sent);
        let (level, presliding) = (self.level.wanted(probe, fixed), self.presliding.wanted(probe, fixed));
        for _ in 0..probe.parts.min(PARTS) {
            let way = self.motion.velocity + self.level.velocity;
            let travel = law.travel(drift, way) * probe.part;
            self.state = (self.state + travel) / (R::ONE + travel.abs());
            let travel = travel * R::of(1.0 / (1.0 + WIDER));
            self.wider = (self.wider + travel) / (R::ONE + travel.abs());
            let sliding = law.sliding(drift, way);
            let difference = sliding * (self.wider - self.state) * R::of(1.0 / WIDER);
            self.motion.advance(probe, motion, fixed, viscous);
            self.level.advance(probe, level, sliding * self.state, viscous);
            self.presliding.advance(probe, presliding, difference, viscous);
        }
        self.motion.end(probe, sent);
        self.level.end(probe, fixed);
        self.presliding.end(probe, fixed);
    }
}
