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
//! enclose the motion with and without it. An axis rests once its command has not changed for 8 T. One axis a cycle, in
//! turn.

#![deny(clippy::indexing_slicing)]

use crate::machine::AxisSettings;
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

/// Limits of an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct RatioLimits<R> {
    /// t.
    tolerance: R,
    /// w.
    decay: R,
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
pub(super) struct Places<P> {
    /// Position sent in the last cycle.
    pub(super) sent: P,
    pub(super) command: P,
    pub(super) reading: P,
}

impl<R: Real, P: Position> Ratio<R, P> {
    /// An axis at rest.
    pub(super) fn at_rest(at: Places<P>, rest: u16) -> Self {
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

    pub(super) fn is_wrong(&self) -> bool {
        self.known == Known::Wrong
    }

    /// The reading was found to be wrong.
    pub(super) fn condemn(&mut self) {
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
    pub(super) const ABSENT: Self = RatioLimits { tolerance: R::MAX, decay: R::ONE, rest: 0 };

    /// `turn_s`: time between two turns of the axis.
    pub(super) fn new(settings: &AxisSettings, turn_s: f64) -> Self {
        let gain = settings.servo.drive.map_or(SLOWEST_GAIN_PER_S, |drive| drive.position_gain_per_s);
        let lag_s = SLOWER / gain.min(SLOWEST_GAIN_PER_S);
        let tolerance = TOLERANCE + settings.backlash.abs() + STEPS * settings.encoder_resolution.unwrap_or(0.0);
        RatioLimits {
            tolerance: R::of(tolerance),
            decay: R::of(turn_s / (lag_s + turn_s)),
            rest: libm::ceil(REST * lag_s / turn_s).clamp(1.0, f64::from(u16::MAX)) as u16,
        }
    }

    /// Whether this turn shows that the reading is wrong; then nothing has changed.
    #[inline(always)]
    pub(super) fn finds<P: Position>(&self, ratio: &mut Ratio<R, P>, at: Places<P>) -> bool {
        let rest = if at.command == ratio.last { ratio.rest.saturating_add(1) } else { 0 };
        if matches!(ratio.known, Known::Compared | Known::Half) && rest < self.rest {
            return self.compares(ratio, at, rest);
        }
        if ratio.known == Known::Wrong || rest < self.rest {
            (ratio.last, ratio.rest) = (at.command, rest);
        } else {
            *ratio = Ratio::at_rest(at, rest);
        }
        false
    }

    /// [`finds`](Self::finds) while the motion is compared.
    #[inline(never)]
    fn compares<P: Position>(&self, ratio: &mut Ratio<R, P>, at: Places<P>, rest: u16) -> bool {
        let quarter = R::HALF * R::HALF;
        let with: R = at.sent.since_near(ratio.sent);
        let without = at.command.since_near(ratio.commanded);
        let shown: R = at.reading.since_near(ratio.read);
        let (least, most) = (with.min(without), with.max(without));
        let low = least.min(ratio.low.add_product(self.decay, least - ratio.low));
        let high = most.max(ratio.high.add_product(self.decay, most - ratio.high));
        let forward = low + high >= R::ZERO;
        let (near, far, now, shown) = if forward { (low, high, most, shown) } else { (-high, -low, -least, -shown) };
        let three_quarters = near - quarter * near - self.tolerance;
        let twice = far + quarter * far + self.tolerance;
        let behind = near.min(R::ZERO);
        let against = shown < behind + quarter * behind - self.tolerance;
        let is_less = shown < three_quarters;
        if against || shown > twice || (is_less && shown > quarter * near) || self.stays_half(ratio, [far, now, shown])
        {
            return true;
        }
        if !is_less && R::HALF * far < three_quarters && near + near > twice {
            ratio.known = Known::Enough;
        }
        (ratio.low, ratio.high, ratio.last, ratio.rest) = (low, high, at.command, rest);
        false
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
