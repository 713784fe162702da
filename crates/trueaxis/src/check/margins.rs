//! Stability margins of the contour feedback.

use super::drive::{characteristic, stiffness};
use super::notch::{Notch, Sampled};
use super::open_loop::{Margin, OpenLoop};
use crate::machine::{DriveFigures, FeedbackSettings, FrictionSettings};

/// Smallest permitted phase margin of the contour feedback, degrees.
pub const PHASE_MARGIN_DEG: f64 = 60.0;
/// Smallest permitted gain margin of the contour feedback, dB.
pub const GAIN_MARGIN_DB: f64 = 12.0;

/// Margins of the contour feedback on one axis: the smallest over the possible loops of the axis.
///
/// The feedback C(s) = K_p + K_i/s closes a loop through the axis' drive and a dead time t_d, the sum of the drive's and
/// the step's. Three forms of the drive are evaluated, and the worst counts:
///
/// ```text
/// L(s) = C(s) e^(−s t_d) · K_v/((s + K_v)(1 + s t_v)),  t_v = 1/K_vp + t_c                     gains alone
/// L(s) = C(s) e^(−s t_d) · V(s) (K_v + k_ff s)/(s² + k + V(s) (s + K_v)),  V = K_vp (1 + 1/(τ s))/(1 + s t_c)
///        k = 0: sliding;  k = F_c (1 + s)/z: held by pre-sliding friction
/// ```
///
/// A correction changes the command, and so passes through the velocity feed-forward: with k_ff near 1 the drive follows
/// it up to the bandwidth of its *velocity* loop, where the dead time costs the most phase, while in the first form the
/// gain falls from K_v on. The first form alone is safe only if nothing is fed forward; with feed-forward it is off by up
/// to 20 dB. It is still one of the three because it is the worst for a purely integral gain.
///
/// At resonances the gain of the loop counts, whatever its phase: of a motor that moves a load through a spring, a scale on
/// the load closing the position loop, over gains ±10 %, the stated resonance ±10 % and loads of 20 to 80 % of the mass. If no
/// resonance is stated, every one above [`super::ASSUMED_LOWEST_HZ`] with [`super::ASSUMED_DAMPING`] counts with which the
/// drive alone is sound. A notch, if there is one, is part of every loop. Resonances are judged where a machine is compiled or
/// checked; a controller judges the rigid drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Phase margin, degrees; `None` if the gain is below 1 everywhere.
    pub phase: Option<Margin>,
    /// Gain margin, dB; `None` if the phase never lags by 180°.
    pub gain: Option<Margin>,
    /// Margin at the resonances, dB, whatever the phase there; −∞ if a stated one makes the drive alone unstable.
    pub resonance: Option<Margin>,
    /// Notch of the feedback at the stated resonance.
    pub notch: Option<Notch>,
    /// Factor by which both gains may grow until [`PHASE_MARGIN_DEG`], [`GAIN_MARGIN_DB`] or
    /// [`super::RESONANCE_MARGIN_DB`] is reached; below 1 the gains are too large.
    pub factor: f64,
}

/// Delay of the step itself, in servo periods: one from a reading to the command computed from it, half of one for the
/// hold between two commands.
const OWN_DELAY: f64 = 1.5;

/// A drive in the contour feedback at a servo period, s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closed<'m> {
    pub(super) drive: &'m DriveFigures,
    pub(super) friction: Option<&'m FrictionSettings>,
    pub(super) feedback: &'m FeedbackSettings,
    pub(super) period_s: f64,
}

impl Closed<'_> {
    /// Delay of the step, s.
    pub(super) fn delay_s(&self) -> f64 {
        OWN_DELAY * self.period_s
    }
}

/// The margins of the rigid drive with this feedback.
///
/// Cost: some 3,000 values of a transfer function, at build only.
pub(super) fn rigid(closed: &Closed<'_>, notch: Option<&Notch>) -> Margins {
    let Closed { drive, friction, feedback, period_s } = *closed;
    let none = Margins { phase: None, gain: None, resonance: None, notch: notch.copied(), factor: f64::INFINITY };
    let held = friction.map(|friction| full(drive, stiffness(drive, friction)));
    let forms = [Some(gains_alone(drive)), Some(full(drive, 0.0)), held];
    let range = frequencies(drive, feedback);
    forms.into_iter().flatten().fold(none, |worst, (numerator, denominator)| {
        let open = OpenLoop {
            numerator: controlled(feedback, numerator),
            denominator: integrated(denominator),
            dead_time_s: drive.dead_time_s + closed.delay_s(),
            notch: notch.map(|notch| Sampled { notch: *notch, period_s }),
        };
        let found = open.margins(range, PHASE_MARGIN_DEG, GAIN_MARGIN_DB);
        Margins {
            phase: least(worst.phase, found.phase),
            gain: least(worst.gain, found.gain),
            factor: worst.factor.min(found.factor),
            ..worst
        }
    })
}

fn least(a: Option<Margin>, b: Option<Margin>) -> Option<Margin> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if b.value < a.value { b } else { a }),
        (a, b) => a.or(b),
    }
}

/// Numerator and denominator of a drive, from the constant term on.
type Drive = ([f64; 3], [f64; 5]);

fn gains_alone(drive: &DriveFigures) -> Drive {
    let (kv, lag) = (drive.position_gain_per_s, 1.0 / drive.velocity_gain_per_s + drive.current_loop_s);
    ([kv, 0.0, 0.0], [kv, 1.0 + kv * lag, lag, 0.0, 0.0])
}

/// K_vp (τ s + 1)(K_v + k_ff s) over the characteristic polynomial.
fn full(drive: &DriveFigures, stiffness: f64) -> Drive {
    let DriveFigures { position_gain_per_s: kv, velocity_gain_per_s: kvp, reset_time_s: tau, .. } = *drive;
    let ahead = drive.velocity_feed_forward;
    ([kvp * kv, kvp * (ahead + tau * kv), kvp * tau * ahead], characteristic(drive, stiffness))
}

/// Multiplies by K_p s + K_i.
fn controlled(feedback: &FeedbackSettings, [a, b, c]: [f64; 3]) -> [f64; 4] {
    let (p, i) = (feedback.proportional, feedback.integral_per_s);
    [i * a, p * a + i * b, p * b + i * c, p * c]
}

/// Multiplies by s.
fn integrated([a, b, c, d, e]: [f64; 5]) -> [f64; 6] {
    [0.0, a, b, c, d, e]
}

/// Angular frequencies that contain all features of the loop: from a ten-thousandth of its slowest rate to a hundred
/// times its fastest, 1/s. They depend on the drive and the ratio of the gains only, so that loops with one ratio are
/// evaluated at the same frequencies, whatever their gains. A dead time only adds lag where the gain has already fallen.
fn frequencies(drive: &DriveFigures, feedback: &FeedbackSettings) -> [f64; 2] {
    let DriveFigures { position_gain_per_s, velocity_gain_per_s, reset_time_s, current_loop_s, .. } = *drive;
    let rates = [position_gain_per_s, velocity_gain_per_s, 1.0 / reset_time_s, 1.0 / current_loop_s];
    let ratio = feedback.integral_per_s / feedback.proportional;
    let ratio = Some(ratio).filter(|ratio| *ratio > 1e-3 && *ratio < 1e6);
    let of = |pick: fn(f64, f64) -> f64| rates.into_iter().chain(ratio).fold(position_gain_per_s, pick);
    [1e-4 * of(f64::min), 1e2 * of(f64::max)]
}
