//! Margin of the contour feedback at the resonances of an axis, and whether a notch pays.
//!
//! Some hundred thousand values of a transfer function for an axis: evaluated where a machine is compiled or checked, never on
//! a controller, whose image does not contain this module.

use super::drive::stiffness;
use super::margins::{Closed, Margins, rigid};
use super::notch::{LOWEST_RATE, Notch, Sampled};
use super::open_loop::{Margin, decibels, hertz};
use super::two_masses::{Masses, is_stable, transfer};
use crate::machine::DriveFigures;
use crate::range::GAIN_WITHOUT_NOTCH;
use core::f64::consts::TAU;

/// Smallest permitted margin of the contour feedback at a resonance, dB: the loop's gain stays below one half there,
/// whatever its phase.
pub const RESONANCE_MARGIN_DB: f64 = 6.0;
/// Damping of a resonance that is not known, share of critical.
pub const ASSUMED_DAMPING: f64 = 0.02;
/// Frequency above which resonances are assumed if nothing is stated, Hz.
pub const ASSUMED_LOWEST_HZ: f64 = 100.0;

/// How far a stated resonance may be off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Its frequency, as a share of it.
    pub frequency: f64,
    /// Its damping, share of critical.
    pub damping: f64,
    /// Whether resonances that nobody stated are assumed, from [`assumed_lowest_hz`] up.
    pub assumed: bool,
}

impl Spread {
    /// ±10 % of the frequency, the damping as stated, no other resonance.
    pub const LEAST: Spread = Spread { frequency: 0.1, damping: 0.0, assumed: false };
}

/// Gains K_v and K_vp over the stated ones.
const GAINS: [[f64; 2]; 5] = [[1.0, 1.0], [1.1, 1.1], [0.9, 0.9], [1.1, 0.9], [0.9, 1.1]];
/// The gains with which a drive that is closed on its motor has the largest peak.
const HIGHEST: [[f64; 2]; 1] = [[1.1, 1.1]];
/// Shares of the load in the mass: a light table on a large motor, a heavy one on a small motor.
const SHARES: [f64; 3] = [0.2, 0.5, 0.8];
/// Quotient of two assumed resonances: half the width of a peak would need 1.02, but the members of a family overlap by far
/// more.
const NEXT: f64 = 1.25;
/// Largest number of assumed resonances, up to eleven times the lowest one. Higher ones lie beyond the velocity loop.
const RESONANCES: u8 = 12;
/// Quotient of two evaluated frequencies: a peak of 2 % damping is 4 % wide.
const STEP: f64 = 1.04;
/// Largest number of evaluated frequencies, from half the antiresonance of the largest share to four times the resonance.
const POINTS: u8 = 74;
/// Largest gain of a sound drive without velocity feed-forward: a step overshoots by some 40 %.
const SOUND: f64 = 2.0;

/// A notch costs lag and instructions, and is worth them if the gains may be larger by this factor.
const WORTH: f64 = 1.1;
/// Servo period at which that is decided, s, unless the notch needs a shorter one.
const USUAL_PERIOD_S: f64 = 1e-3;

/// The worst of a family of plants.
#[derive(Clone, Copy, Debug)]
pub(super) struct Peak {
    /// Largest gain of the loop.
    gain: f64,
    /// Its frequency, 1/s.
    omega: f64,
}

impl Peak {
    /// No plant yet.
    const NONE: Peak = Peak { gain: 0.0, omega: 0.0 };

    /// The larger one.
    fn or(self, other: Peak) -> Peak {
        if other.gain > self.gain { other } else { self }
    }

    /// A drive that is unstable without any feedback.
    fn unstable(omega: f64) -> Peak {
        Peak { gain: f64::INFINITY, omega }
    }

    /// Factor by which the gains may grow; 0 if the drive alone is unstable.
    fn factor(&self) -> f64 {
        libm::exp10(-RESONANCE_MARGIN_DB / 20.0) / self.gain
    }
}

/// The margins of a drive in the contour feedback, with the notch that a machine compiled from these figures has at this
/// servo period.
pub(super) fn margins(closed: &Closed<'_>, spread: &Spread) -> Margins {
    let drive = DriveFigures { gain_without_notch: gain_without_notch(closed), ..*closed.drive };
    with(closed, spread, Notch::of(&drive, closed.period_s).as_ref())
}

fn with(closed: &Closed<'_>, spread: &Spread, notch: Option<&Notch>) -> Margins {
    let (rigid, peak) = (rigid(closed, notch), worst(closed, spread, notch));
    let resonance = Margin { value: -decibels(peak.gain), frequency_hz: hertz(peak.omega) };
    Margins { resonance: Some(resonance), factor: rigid.factor.min(peak.factor()), ..rigid }
}

/// Factor by which the stated resonance lets the gains grow without a notch there, which holds at any servo period; 0 if
/// there is to be no notch: none is stated, or the gains would not be larger by [`WORTH`] with it.
///
/// The choice depends on the ratio of the gains, not on their size, nor on the servo period that a controller will have, nor
/// on the uncertainty of the resonance.
pub(super) fn gain_without_notch(closed: &Closed<'_>) -> f64 {
    let frequency_hz = closed.drive.resonance_hz;
    if frequency_hz <= 0.0 {
        return 0.0;
    }
    let usual = Closed { period_s: USUAL_PERIOD_S.min(slowest_s(frequency_hz)), ..*closed };
    let (bare, peak) = (rigid(&usual, None).factor, worst(&usual, &Spread::LEAST, None).factor());
    let notched = with(&usual, &Spread::LEAST, Some(&Notch::at(frequency_hz))).factor;
    // Without feedback to speak of, the permitted factor is beyond any gain.
    if peak > 0.0 && notched > WORTH * bare.min(peak) { peak.min(GAIN_WITHOUT_NOTCH.most) } else { 0.0 }
}

/// The longest servo period with a notch, s.
fn slowest_s(frequency_hz: f64) -> f64 {
    1.0 / (LOWEST_RATE * frequency_hz)
}

/// The largest gain at the resonances that the drive's figures state, or else at the assumed ones. A notch counts as it is at
/// the slowest servo that has it, where it is narrowest: so the gain is at most this one at any servo period.
fn worst(closed: &Closed<'_>, spread: &Spread, notch: Option<&Notch>) -> Peak {
    let sampled = |notch: &Notch| Sampled { notch: *notch, period_s: slowest_s(notch.frequency_hz) };
    let plants = Plants { closed, notch: notch.map(sampled) };
    let DriveFigures { resonance_hz, resonance_damping, .. } = *closed.drive;
    let stated = (resonance_hz > 0.0).then(|| {
        let share = spread.frequency.max(Spread::LEAST.frequency);
        let damping = resonance_damping - spread.damping;
        plants.around([resonance_hz, damping], &[1.0, 1.0 - share, 1.0 + share], false)
    });
    let lowest = assumed_lowest_hz(closed.drive).filter(|_| spread.assumed);
    let assumed = lowest.map(|lowest| plants.above(lowest));
    stated.into_iter().chain(assumed).fold(Peak::NONE, Peak::or)
}

/// Frequency above which resonances with [`ASSUMED_DAMPING`] are assumed, Hz; `None` if the resonance is known and nothing
/// is said about others.
pub fn assumed_lowest_hz(drive: &DriveFigures) -> Option<f64> {
    match (drive.lowest_resonance_hz > 0.0, drive.resonance_hz > 0.0) {
        (true, _) => Some(drive.lowest_resonance_hz),
        (false, true) => None,
        (false, false) => Some(ASSUMED_LOWEST_HZ),
    }
}

/// The drive in its loop, with the notch, and whatever it moves.
struct Plants<'c> {
    closed: &'c Closed<'c>,
    notch: Option<Sampled>,
}

impl Plants<'_> {
    /// The largest gain at any resonance above a frequency with which the drive alone is sound.
    fn above(&self, lowest_hz: f64) -> Peak {
        let mut hz = lowest_hz;
        let mut worst = Peak::NONE;
        for _ in 0..RESONANCES {
            let peak = self.around([hz, ASSUMED_DAMPING], &[1.0], true);
            // Far above the loops of the drive the peaks only fall.
            if peak.gain < 0.5 * worst.gain {
                break;
            }
            worst = worst.or(peak);
            hz *= NEXT;
        }
        worst
    }

    /// The largest gain over the family about a resonance: gains ±10 %, frequencies times `factors`, loads of every share,
    /// sliding and held, with a scale on the load, which is nearly always the worse case, or an encoder on the motor. If
    /// `only_sound`, drives that are not sound without the correction are left out.
    fn around(&self, [hz, damping]: [f64; 2], factors: &[f64], only_sound: bool) -> Peak {
        let held = self.closed.friction.map(|friction| stiffness(self.closed.drive, friction));
        let forms = [
            Some((0.0, true, &GAINS[..])),
            held.map(|held| (held, true, &GAINS[..])),
            Some((0.0, false, &HIGHEST[..])),
        ];
        let mut worst = Peak::NONE;
        for share in SHARES {
            for (stiffness, scale, all) in forms.into_iter().flatten() {
                let masses = Masses { omega: TAU * hz, damping, share, stiffness, scale };
                for &gains in all {
                    for factor in factors {
                        let masses = Masses { omega: masses.omega * factor, ..masses };
                        worst = worst.or(self.member(gains, &masses, only_sound, &worst).unwrap_or(Peak::NONE));
                    }
                }
            }
        }
        worst
    }

    /// The largest gain of one plant, from half the antiresonance up: below it the plant is as good as rigid. `None` if it is
    /// not sound by itself, though `only_sound` ones count and its gain is beyond that of the `worst` one so far.
    fn member(&self, [kv, kvp]: [f64; 2], masses: &Masses, only_sound: bool, worst: &Peak) -> Option<Peak> {
        let drive = DriveFigures {
            position_gain_per_s: self.closed.drive.position_gain_per_s * kv,
            velocity_gain_per_s: self.closed.drive.velocity_gain_per_s * kvp,
            ..*self.closed.drive
        };
        let (numerator, denominator) = transfer(&drive, masses);
        if !is_stable(&denominator) {
            return (!only_sound).then(|| Peak::unstable(masses.omega));
        }
        let (alone, _) = transfer(&DriveFigures { velocity_feed_forward: 0.0, ..drive }, masses);
        let [p, i] = [self.closed.feedback.proportional, self.closed.feedback.integral_per_s];
        // Squares of the loop's gain, whose dead time turns only its phase, and of the drive's own.
        let loop_gain = |omega: f64| {
            (p * p + i * i / (omega * omega)) * square(&numerator, omega) / square(&denominator, omega)
                * self.notched(omega)
        };
        let own_gain = |omega: f64| square(&alone, omega) / square(&denominator, omega);
        let range = [0.5 * masses.omega * libm::sqrt(1.0 - masses.share), 4.0 * masses.omega];
        let [omega, gain] = largest(range, loop_gain);
        // Whether a drive is sound costs as much again, and matters only if it is the worst so far.
        let counts = gain > worst.gain * worst.gain;
        if counts && only_sound && largest(range, own_gain)[1] > SOUND * SOUND {
            return None;
        }
        Some(Peak { gain: libm::sqrt(gain), omega })
    }

    /// |F(jω)|² of the notch.
    fn notched(&self, omega: f64) -> f64 {
        self.notch.as_ref().map_or(1.0, |notch| notch.at(omega).iter().map(|part| part * part).sum())
    }
}

/// The largest gain between two frequencies, with its frequency; a peak to one part in 10⁴ of its frequency, by golden-section
/// search between the neighbours of an evaluated frequency.
fn largest([lowest, highest]: [f64; 2], gain: impl Fn(f64) -> f64) -> [f64; 2] {
    const SECTION: f64 = 0.381_966_011_250_105_15;
    let mut found = [lowest, gain(lowest)];
    let mut omega = lowest;
    for _ in 0..POINTS {
        omega *= STEP;
        if omega > highest {
            break;
        }
        let gain = gain(omega);
        if gain > found[1] {
            found = [omega, gain];
        }
    }
    let [mut low, mut high] = [lowest.max(found[0] / STEP), found[0] * STEP];
    for _ in 0..12 {
        let (left, right) = (low + SECTION * (high - low), high - SECTION * (high - low));
        if gain(left) < gain(right) {
            low = left;
        } else {
            high = right;
        }
    }
    let omega = 0.5 * (low + high);
    let top = [omega, gain(omega)];
    if top[1] > found[1] { top } else { found }
}

/// |P(jω)|² of a polynomial.
fn square(polynomial: &[f64], omega: f64) -> f64 {
    let [mut even, mut odd] = [0.0; 2];
    // Backwards, every second coefficient belongs to jω.
    for (power, coefficient) in polynomial.iter().enumerate().rev() {
        let part = if power % 2 == 0 { &mut even } else { &mut odd };
        *part = coefficient - omega * omega * *part;
    }
    even * even + omega * omega * odd * odd
}
