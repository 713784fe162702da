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
//! L/4 < x < 3/4 L − t             about half
//! x > 5/4 H + t                   about twice
//! ```
//!
//! and has proved right, until the next rest, where H/2 < 3/4 L − t and 2 L > 5/4 H + t: no reading of half or twice the
//! motion would have come so far. A reading that shows less than a quarter is left to the check for stuck readings.
//!
//! T = (1.25 − k_ff)/K_v + 1/K_vp + the times of current loop and bus, 0.125 s without a drive's figures (K_v 10/s);
//! t = 0.15 mm (deg) + backlash + two steps of the encoder. Since the correction may reach the reading or not (a stepper
//! without encoder repeats its command), L and H enclose the motion with and without it. An axis rests once its command
//! has not changed for 8 T.
//!
//! Found after 0.15 mm against the command, after 0.6 mm at half and 0.2 mm at twice the scale, plus 3 T v at most. One
//! axis a cycle, in turn.

#![deny(clippy::indexing_slicing)]

use crate::machine::AxisSettings;
use crate::position::Position;
use crate::real::Real;

/// Play and transients that no reading need show, mm (deg).
const TOLERANCE: f64 = 0.15;
/// Encoder steps by which a motion may be misread.
const STEPS: f64 = 2.0;
/// Gain of the slowest drive, 1/s, if no figures are stated, and by how much a drive's lag may exceed its figures, 1/K_v.
const SLOWEST_GAIN_PER_S: f64 = 10.0;
const SLOWER: f64 = 1.25;
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
        let lag_s = settings.servo.drive.map_or(SLOWER / SLOWEST_GAIN_PER_S, |drive| {
            (SLOWER - drive.velocity_feed_forward) / drive.position_gain_per_s
                + 1.0 / drive.velocity_gain_per_s
                + drive.current_loop_s
                + drive.dead_time_s
        });
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
        if ratio.known == Known::Compared && rest < self.rest {
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
        let (near, far, shown) = if forward { (low, high, shown) } else { (-high, -low, -shown) };
        let three_quarters = near - quarter * near - self.tolerance;
        let twice = far + quarter * far + self.tolerance;
        let behind = near.min(R::ZERO);
        let against = shown < behind + quarter * behind - self.tolerance;
        let is_less = shown < three_quarters;
        if against || shown > twice || (is_less && shown > quarter * near) {
            return true;
        }
        if !is_less && R::HALF * far < three_quarters && near + near > twice {
            ratio.known = Known::Enough;
        }
        (ratio.low, ratio.high, ratio.last, ratio.rest) = (low, high, at.command, rest);
        false
    }
}
