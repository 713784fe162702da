//! Margin of the contour feedback at the resonances of an axis.

use super::drive::stiffness;
use super::margins::Closed;
use super::notch::{Notch, Sampled};
use super::open_loop::{Margin, OpenLoop, decibels, hertz};
use super::two_masses::{Masses, is_stable, product, transfer};
use crate::machine::DriveFigures;
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
}

impl Spread {
    /// ±10 % of the frequency, the damping as stated.
    pub const LEAST: Spread = Spread { frequency: 0.1, damping: 0.0 };
}

/// Gains K_v and K_vp over the stated ones.
const GAINS: [[f64; 2]; 5] = [[1.0, 1.0], [1.1, 1.1], [0.9, 0.9], [1.1, 0.9], [0.9, 1.1]];
/// The gains with which a drive that is closed on its motor has the largest peak.
const HIGHEST: [[f64; 2]; 1] = [[1.1, 1.1]];
/// Shares of the load in the mass: a light table on a large motor, a heavy one on a small motor.
const SHARES: [f64; 3] = [0.2, 0.5, 0.8];
/// Quotient of two resonances above the lowest one: half the width of a peak would need 1.02, but the members of a family
/// overlap by far more.
const NEXT: f64 = 1.25;
/// Number of resonances above the lowest one, up to eleven times as high. Higher ones lie beyond the velocity loop.
const RESONANCES: u8 = 12;
/// Quotient of two evaluated frequencies: a peak of 2 % damping is 4 % wide.
const STEP: f64 = 1.04;

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
    pub(super) fn factor(&self) -> f64 {
        libm::exp10(-RESONANCE_MARGIN_DB / 20.0) / self.gain
    }

    pub(super) fn margin(&self) -> Margin {
        Margin { value: -decibels(self.gain), frequency_hz: hertz(self.omega) }
    }
}

/// The largest gain at the resonances that the drive's figures state; `None` if they state none.
pub(super) fn worst(closed: &Closed<'_>, spread: &Spread, notch: Option<&Notch>) -> Option<Peak> {
    let DriveFigures { resonance_hz, resonance_damping, lowest_resonance_hz, .. } = *closed.drive;
    let stated = (resonance_hz > 0.0).then(|| {
        let damping = resonance_damping - spread.damping;
        let share = spread.frequency.max(Spread::LEAST.frequency);
        around(closed, [resonance_hz, damping], &[1.0, 1.0 - share, 1.0 + share], notch)
    });
    let assumed = (lowest_resonance_hz > 0.0).then(|| above(closed, lowest_resonance_hz, notch));
    stated.into_iter().chain(assumed).reduce(Peak::or)
}

/// The largest gain at any resonance above a frequency, with [`ASSUMED_DAMPING`].
pub(super) fn above(closed: &Closed<'_>, lowest_hz: f64, notch: Option<&Notch>) -> Peak {
    let mut hz = lowest_hz;
    let mut worst = Peak::NONE;
    for _ in 0..RESONANCES {
        worst = worst.or(around(closed, [hz, ASSUMED_DAMPING], &[1.0], notch));
        hz *= NEXT;
    }
    worst
}

/// The largest gain over the family about a resonance: gains ±10 %, frequencies times `factors`, loads of every share,
/// sliding and held, with a scale on the load, which is nearly always the worse case, or an encoder on the motor.
fn around(closed: &Closed<'_>, [hz, damping]: [f64; 2], factors: &[f64], notch: Option<&Notch>) -> Peak {
    let held = closed.friction.map(|friction| stiffness(closed.drive, friction));
    let forms =
        [Some((0.0, true, &GAINS[..])), held.map(|held| (held, true, &GAINS[..])), Some((0.0, false, &HIGHEST[..]))];
    let mut worst = Peak::NONE;
    for share in SHARES {
        for (stiffness, scale, all) in forms.into_iter().flatten() {
            let masses = Masses { omega: TAU * hz, damping, share, stiffness, scale };
            for &gains in all {
                for factor in factors {
                    let masses = Masses { omega: masses.omega * factor, ..masses };
                    worst = worst.or(member(closed, gains, &masses, notch));
                }
            }
        }
    }
    worst
}

/// The largest gain of one plant, from half the antiresonance up: below it the plant is as good as rigid.
fn member(closed: &Closed<'_>, [kv, kvp]: [f64; 2], masses: &Masses, notch: Option<&Notch>) -> Peak {
    let drive = DriveFigures {
        position_gain_per_s: closed.drive.position_gain_per_s * kv,
        velocity_gain_per_s: closed.drive.velocity_gain_per_s * kvp,
        ..*closed.drive
    };
    let (numerator, denominator) = transfer(&drive, masses);
    if !is_stable(&denominator) {
        return Peak::unstable(masses.omega);
    }
    let feedback = closed.feedback;
    let open = OpenLoop::<6, 8> {
        numerator: product(&[feedback.integral_per_s, feedback.proportional], &numerator),
        denominator: product(&[0.0, 1.0], &denominator),
        dead_time_s: drive.dead_time_s + closed.delay_s(),
        notch: notch.map(|notch| Sampled { notch: *notch, period_s: closed.period_s }),
    };
    let low = 0.5 * masses.omega * libm::sqrt(1.0 - masses.share);
    let [omega, gain] = open.largest([low, 4.0 * masses.omega], STEP);
    Peak { gain, omega }
}
