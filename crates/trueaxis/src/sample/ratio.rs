//! Ratio of the motion that a reading reports to the motion sent to the drive: its sign, half of it, twice of it.
//!
//! Counted from where the axis last rested: s the motion sent, x the motion reported. A drive whose lag decays with a time
//! constant of at most T is between L and H,
//!
//! ```text
//! L <- min(s, L + w (s − L))      H <- max(s, H + w (s − H))      w = h / (T + h)
//! ```
//!
//! with h the time between two turns of the axis. If the drive moves forward, else mirrored, the reading is wrong where
//!
//! ```text
//! x < 5/4 min(L, 0) − t           against the command
//! x > 5/4 H + t                   about twice
//! L/4 < x < 3/4 L − t             about half
//! ```
//!
//! and has proved right, until the next rest, where H/2 < 3/4 L − t and 2 L > 5/4 H + t: no reading of half or twice the
//! motion would have come so far. A reading that shows less than a quarter is left to the check for stuck readings.
//!
//! That finds half the motion late, after 3 T v: first a slow drive looks like it. But a lag is made up, and half the motion
//! stays half. So x is also compared at marks, 1.5 t apart or by 0.4 farther than the last, as long as the axis moves on and
//! has never shown more than 0.6 s + t/3: from the second on,
//!
//! ```text
//! 0.42 s < x < 0.56 s             0.4 Δs < Δx < 1.07 x/s Δs       about half, steadily; wrong at two marks in a row
//! ```
//!
//! A drive with lag passes 0.42 to 0.56 while its share rises by 13 % at least from one mark to the next, unless it feeds
//! 0.4 to 0.56 of the velocity forward.
//!
//! T = 1.25/K_v, 0.125 s for gains of 10/s and more or unknown ones; t = 0.15 mm (deg) + backlash + two steps of the
//! encoder. Since the correction may reach the reading or not (a stepper without encoder repeats its command), L and H
//! enclose the motion with and without it. An axis rests once its command has not changed for 8 T.
//!
//! One axis a cycle, in turn, while a reading is outside L − t/3 to H + t/3, or may still be half of a motion of more than t/3;
//! while none is, one axis every third cycle, if every axis then has a turn in 9 ms.

#![deny(clippy::indexing_slicing)]

use crate::machine::{AxisOrder, AxisSettings, MachineSettings};
use crate::position::Position;
use crate::real::Real;

/// Play and transients that no reading need show, mm (deg).
const TOLERANCE: f64 = 0.15;
/// Encoder steps by which a motion may be misread.
const STEPS: f64 = 2.0;
/// Gain of the slowest drive, 1/s, unless its figures say less, and by how much a time constant may exceed 1/K_v.
const SLOWEST_GAIN_PER_S: f64 = 10.0;
const SLOWER: f64 = 1.25;
/// Shares of the motion that are about half, of all of it and since the last mark, and growth that is none.
const ABOUT_HALF: [f64; 2] = [0.42, 0.56];
const STILL_HALF: f64 = 0.4;
const MORE_THAN_HALF: f64 = 0.6;
/// How much farther the next mark lies.
const FARTHER: f64 = 0.4;
const STEADY: f64 = 1.07;
/// Rest, in time constants.
const REST: f64 = 8.0;
/// Cycles from one turn to the next while all readings follow, and the longest time between two turns of an axis then, s.
const UNHURRIED: f64 = 3.0;
const UNHURRIED_S: f64 = 0.009;

/// Limits of an axis.
#[derive(Clone, Copy, Debug)]
struct RatioLimits<R> {
    /// t.
    tolerance: R,
    /// w, for a turn in every cycle and for an unhurried one.
    decay: [R; 2],
    /// Turns without a change of the command after which the axis rests.
    rest: u16,
}

/// What is known of a reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Known {
    /// It proved right, or where it started is unknown: until the next rest.
    #[default]
    Enough,
    /// Compared since the last rest.
    Compared,
    /// The same, and about half at the last mark.
    Half,
    /// Found wrong.
    Wrong,
}

/// What a turn of an axis shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Judged {
    /// The reading follows the motion sent with some lag, or is not compared.
    Follows,
    /// It may not.
    Apart,
    /// It is wrong.
    Wrong,
}

/// Motion of an axis since it rested.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ratio<R, P> {
    /// Position sent, command and reading at rest.
    sent: P,
    commanded: P,
    read: P,
    /// Command at the last turn.
    last: P,
    /// L and H.
    low: R,
    high: R,
    /// Motion sent and reported at the last mark.
    mark: [R; 2],
    /// Turns since the command last changed.
    rest: u16,
    known: Known,
}

/// Positions of an axis in a cycle.
#[derive(Clone, Copy, Debug)]
struct Places<P> {
    /// Position sent in the last cycle.
    sent: P,
    command: P,
    reading: P,
}

impl<R: Real, P: Position> Ratio<R, P> {
    /// An axis at rest.
    fn at_rest(at: Places<P>, rest: u16) -> Self {
        let Places { sent, command, reading } = at;
        Ratio {
            sent,
            commanded: command,
            read: reading,
            last: command,
            low: R::ZERO,
            high: R::ZERO,
            mark: [R::ZERO; 2],
            rest,
            known: Known::Compared,
        }
    }

    fn is_wrong(&self) -> bool {
        self.known == Known::Wrong
    }

    /// The reading was found to be wrong.
    fn condemn(&mut self) {
        self.known = Known::Wrong;
    }

    /// Nothing is known of the reading until the next rest, and nothing is held against it.
    pub(super) fn forget(&mut self) {
        (self.known, self.rest) = (Known::Enough, 0);
    }

    /// [`forget`](Self::forget) unless the reading was found to be wrong.
    pub(super) fn interrupt(&mut self) {
        if !self.is_wrong() {
            self.forget();
        }
    }
}

impl<R: Real> RatioLimits<R> {
    /// Of an axis that the machine does not have: it always rests.
    const ABSENT: Self = RatioLimits { tolerance: R::MAX, decay: [R::ONE; 2], rest: 0 };

    /// `turn_s`: time between two turns of the axis, with one in every cycle; `unhurried`: cycles to the next turn otherwise.
    fn new(settings: &AxisSettings, turn_s: f64, unhurried: u8) -> Self {
        let gain = settings.servo.drive.map_or(SLOWEST_GAIN_PER_S, |drive| drive.position_gain_per_s);
        let lag_s = SLOWER / gain.min(SLOWEST_GAIN_PER_S);
        let tolerance = TOLERANCE + settings.backlash.abs() + STEPS * settings.encoder_resolution.unwrap_or(0.0);
        RatioLimits {
            tolerance: R::of(tolerance),
            decay: [turn_s, f64::from(unhurried) * turn_s].map(|turn_s| R::of(turn_s / (lag_s + turn_s))),
            rest: libm::ceil(REST * lag_s / turn_s).clamp(1.0, f64::from(u16::MAX)) as u16,
        }
    }

    /// Whether nothing is compared: the reading proved right, or the axis rests on, which a turn then records.
    #[inline(always)]
    fn passes<P: Position>(&self, ratio: &mut Ratio<R, P>, at: Places<P>, pace: u8) -> bool {
        let still = at.command == ratio.last;
        let rest = if still { ratio.rest.saturating_add(u16::from(pace)) } else { 0 };
        match ratio.known {
            Known::Enough if rest < self.rest => (ratio.last, ratio.rest) = (at.command, rest),
            Known::Compared if still && ratio.rest >= self.rest => (ratio.sent, ratio.read) = (at.sent, at.reading),
            _ => return false,
        }
        true
    }

    /// A turn, `pace` cycles after that of the axis before. Where it shows that the reading is wrong, nothing has changed.
    #[inline(always)]
    fn judge<P: Position>(&self, ratio: &mut Ratio<R, P>, at: Places<P>, pace: u8) -> Judged {
        let rest = if at.command == ratio.last { ratio.rest.saturating_add(u16::from(pace)) } else { 0 };
        if matches!(ratio.known, Known::Compared | Known::Half) && rest < self.rest {
            return self.compare(ratio, at, rest, pace);
        }
        if ratio.known == Known::Wrong || rest < self.rest {
            (ratio.last, ratio.rest) = (at.command, rest);
        } else {
            *ratio = Ratio::at_rest(at, rest);
        }
        Judged::Follows
    }

    /// [`judge`](Self::judge) while the motion is compared.
    #[inline(never)]
    fn compare<P: Position>(&self, ratio: &mut Ratio<R, P>, at: Places<P>, rest: u16, pace: u8) -> Judged {
        let (quarter, third) = (R::HALF * R::HALF, R::of(1.0 / 3.0) * self.tolerance);
        let [hurried, unhurried] = self.decay;
        let decay = if pace == 1 { hurried } else { unhurried };
        let with: R = at.sent.since_near(ratio.sent);
        let without = at.command.since_near(ratio.commanded);
        let shown: R = at.reading.since_near(ratio.read);
        let (least, most) = (with.min(without), with.max(without));
        let low = least.min(ratio.low.add_product(decay, least - ratio.low));
        let high = most.max(ratio.high.add_product(decay, most - ratio.high));
        let forward = low + high >= R::ZERO;
        let (near, far, now, shown) = if forward { (low, high, most, shown) } else { (-high, -low, -least, -shown) };
        let three_quarters = near - quarter * near - self.tolerance;
        let twice = far + quarter * far + self.tolerance;
        let behind = near.min(R::ZERO);
        let against = shown < behind + quarter * behind - self.tolerance;
        let is_less = shown < three_quarters;
        if against || shown > twice || (is_less && shown > quarter * near) || self.stays_half(ratio, [far, now, shown])
        {
            return Judged::Wrong;
        }
        if !is_less && R::HALF * far < three_quarters && near + near > twice {
            ratio.known = Known::Enough;
        }
        (ratio.low, ratio.high, ratio.last, ratio.rest) = (low, high, at.command, rest);
        let may_be_half = now > third && ratio.mark[0] < R::MAX;
        if may_be_half || shown < near - third || shown > far + third { Judged::Apart } else { Judged::Follows }
    }

    /// Whether the reading shows about half of the motion at a mark, as at the last one; then nothing has changed.
    #[inline(always)]
    fn stays_half<P: Position>(&self, ratio: &mut Ratio<R, P>, [far, now, shown]: [R; 3]) -> bool {
        let [marked, showed] = ratio.mark;
        let third = R::of(1.0 / 3.0) * self.tolerance;
        if far - now > third || shown > R::of(MORE_THAN_HALF) * now + third {
            // Nothing of this motion is about half of it.
            ratio.mark = [R::MAX; 2];
        } else if now >= (marked + R::of(FARTHER) * marked).max(marked + R::of(1.5) * self.tolerance) {
            let [least, most] = ABOUT_HALF.map(R::of);
            let (way, gone) = (now - marked, shown - showed);
            let stays = gone > R::of(STILL_HALF) * way && gone * now < R::of(STEADY) * shown * way;
            let is_half = marked > R::ZERO && stays && shown > least * now && shown < most * now;
            if is_half && ratio.known == Known::Half {
                return true;
            }
            (ratio.mark, ratio.known) = ([now, shown], if is_half { Known::Half } else { Known::Compared });
        }
        false
    }
}

/// The comparison of every axis' motion: limits, and the pace while all readings follow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ratios<R, const N: usize> {
    axes: [RatioLimits<R>; N],
    /// Cycles from one turn to the next while all readings follow.
    unhurried: u8,
}

/// Motion of every axis, and whose turn it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct RatioState<R, P, const N: usize> {
    axes: [Ratio<R, P>; N],
    /// Slot of the axis that is compared next.
    turn: u8,
    /// Cycles until then.
    pause: u8,
    /// Cycles from the last turn to this one.
    pace: u8,
    /// Turns in a row in which the reading followed, up to the number of axes.
    followed: u8,
}

impl<R: Real, const N: usize> Ratios<R, N> {
    pub(super) fn new(order: &AxisOrder<N>, machine: &MachineSettings, period_s: f64) -> Self {
        let turn_s = N as f64 * period_s;
        let unhurried = (UNHURRIED_S * (1.0 + 1e-9) / turn_s).clamp(1.0, UNHURRIED) as u8;
        let limits = |own: &AxisSettings| RatioLimits::new(own, turn_s, unhurried);
        let axes = order.slots(|axis| machine.axis(axis).map_or(RatioLimits::ABSENT, limits));
        Ratios { axes, unhurried }
    }

    /// Compares the motion that the reading of the axis whose turn it is shows with the motion sent; `sent`: in the last cycle.
    /// Where the reading is found to be wrong, returns `true` and changes nothing. The usual cases in a few instructions.
    #[inline(never)]
    pub(super) fn find<P: Position>(
        &self,
        state: &mut RatioState<R, P, N>,
        sent: &[P; N],
        command: &[P; N],
        reading: &[P; N],
    ) -> bool {
        let turn = state.turn();
        let (Some(limits), Some(ratio)) = (self.axes.get(turn), state.axes.get_mut(turn)) else { return false };
        let (Some(sent), Some(command), Some(reading)) = (sent.get(turn), command.get(turn), reading.get(turn)) else {
            return false;
        };
        let at = Places { sent: *sent, command: *command, reading: *reading };
        if usize::from(state.followed) < N || !limits.passes(ratio, at, state.pace) {
            return self.judge(state, at);
        }
        state.next(turn);
        false
    }

    /// [`Ratios::find`] in full.
    #[inline(never)]
    fn judge<P: Position>(&self, state: &mut RatioState<R, P, N>, at: Places<P>) -> bool {
        let turn = state.turn();
        let (Some(limits), Some(ratio)) = (self.axes.get(turn), state.axes.get_mut(turn)) else { return false };
        state.followed = match limits.judge(ratio, at, state.pace) {
            Judged::Wrong => return true,
            Judged::Apart => 0,
            Judged::Follows => state.followed.saturating_add(1).min(N as u8),
        };
        state.pace = if usize::from(state.followed) == N { self.unhurried } else { 1 };
        state.next(turn);
        false
    }
}

impl<R: Real, P: Position, const N: usize> RatioState<R, P, N> {
    pub(super) fn new() -> Self {
        RatioState { axes: [Ratio::default(); N], turn: 0, pause: 0, pace: 1, followed: 0 }
    }

    /// Whether it is no axis' turn in this cycle.
    #[inline(always)]
    pub(super) fn waits(&mut self) -> bool {
        let Some(pause) = self.pause.checked_sub(1) else { return false };
        self.pause = pause;
        true
    }

    fn turn(&self) -> usize {
        if usize::from(self.turn) < N { usize::from(self.turn) } else { 0 }
    }

    /// The axis after this one is next.
    #[inline(always)]
    fn next(&mut self, turn: usize) {
        (self.turn, self.pause) = ((turn + 1) as u8, self.pace.saturating_sub(1));
    }

    /// Begins at rest at a command, as the readings are.
    pub(super) fn rest(&mut self, command: &[P; N], reading: &[P; N]) {
        for ((ratio, command), reading) in self.axes.iter_mut().zip(command).zip(reading) {
            let at = Places { sent: *command, command: *command, reading: *reading };
            *ratio = Ratio::at_rest(at, u16::MAX);
        }
    }

    pub(super) fn axes(&mut self) -> impl Iterator<Item = &mut Ratio<R, P>> {
        self.axes.iter_mut()
    }

    /// The reading whose turn it is was found to be wrong; if not `active`, it is only forgotten.
    pub(super) fn found(&mut self, active: bool) {
        let turn = self.turn();
        if let Some(ratio) = self.axes.get_mut(turn) {
            if active { ratio.condemn() } else { ratio.forget() }
        }
        self.turn = (turn + 1) as u8;
    }

    /// Forgets the readings that were found to be wrong.
    pub(super) fn release(&mut self) {
        self.axes.iter_mut().filter(|ratio| ratio.is_wrong()).for_each(Ratio::forget);
    }

    /// Slot of the first axis whose reading was found to be wrong.
    pub(super) fn wrong(&self) -> Option<u8> {
        self.axes.iter().position(Ratio::is_wrong).map(|slot| slot as u8)
    }
}
