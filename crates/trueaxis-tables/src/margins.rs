//! Stability margins of the contour feedback, axis by axis.

use crate::Machine;
use crate::text::short;
use crate::uncertainty::Uncertainties;
use serde::Serialize;
use std::fmt;
use trueaxis::check::{self, Margin, Spread};
use trueaxis::error::ConfigError;
use trueaxis::machine::Axis;

/// Margins of the contour feedback on a linear axis, the worst of the loops in [`trueaxis::check::Margins`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FeedbackMargins {
    /// The axis.
    pub axis: char,
    /// Phase margin, degrees; `None`: the gain of the loop is below 1 everywhere.
    pub phase_margin_deg: Option<f64>,
    /// Frequency at which the gain of the loop is 1, Hz.
    pub phase_margin_hz: Option<f64>,
    /// Gain margin, dB; `None`: the loop never lags by 180°.
    pub gain_margin_db: Option<f64>,
    /// Frequency at which the lag reaches 180°, Hz.
    pub gain_margin_hz: Option<f64>,
    /// Largest permitted K_p, with K_i in the same ratio; `None`: any.
    pub largest_proportional: Option<f64>,
    /// K_i at that ratio, 1/s.
    pub largest_integral_per_s: Option<f64>,
    /// Frequency above which any resonance with 2 % damping is assumed, Hz; `None`: the resonance is stated, and no lowest
    /// one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub assumed_above_hz: Option<f64>,
    /// Margin at the resonances of the axis, stated or assumed, dB; `None`: the drive alone is unstable with a stated one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resonance_margin_db: Option<f64>,
    /// Frequency of that margin, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resonance_margin_hz: Option<f64>,
    /// Notch of the feedback.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub notch: Option<Notched>,
}

/// Notch of the contour feedback at a resonance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Notched {
    /// Its frequency, Hz.
    pub frequency_hz: f64,
    /// Its damping, share of critical.
    pub damping: f64,
    /// Gain that remains at its frequency.
    pub bottom: f64,
    /// Resonances with which the margins hold, Hz.
    pub robust_hz: [f64; 2],
}

/// Expanded uncertainty (k = 2) of the resonance that an axis states.
fn spread(machine: &Machine, known: &Uncertainties, axis: Axis) -> Spread {
    let drive = machine.settings.axis(axis).and_then(|own| own.servo.drive);
    let own = known.axes.iter().find(|own| own.axis == axis);
    let assumed = Spread { assumed: true, ..Spread::LEAST };
    let (Some(drive), Some(own)) = (drive, own) else { return assumed };
    let expanded = |stated: Option<f64>| 2.0 * stated.unwrap_or(0.0);
    Spread {
        frequency: (expanded(own.resonance_hz) / drive.resonance_hz).max(Spread::LEAST.frequency),
        damping: expanded(own.resonance_damping),
        ..assumed
    }
}

/// Refuses gains of the contour feedback that leave too little margin at a servo rate, Hz, with the stated uncertainty of the
/// resonances, which a controller does not know.
///
/// # Errors
/// As [`check::feedback`].
pub fn feedback_within(machine: &Machine, known: &Uncertainties, servo_rate_hz: f64) -> Result<(), ConfigError> {
    check::feedback_within(&machine.settings, 1.0 / servo_rate_hz, |axis| spread(machine, known, axis))
}

/// The margins of every linear axis at a servo rate, Hz; empty without contour feedback.
pub fn feedback_margins(machine: &Machine, servo_rate_hz: f64) -> Vec<FeedbackMargins> {
    feedback_margins_within(machine, &Uncertainties::default(), servo_rate_hz)
}

/// Like [`feedback_margins`], with the stated uncertainty of the resonances.
pub fn feedback_margins_within(machine: &Machine, known: &Uncertainties, servo_rate_hz: f64) -> Vec<FeedbackMargins> {
    let Some(feedback) = machine.settings.contour.feedback else { return Vec::new() };
    let of = |(axis, margins): (Axis, check::Margins)| {
        let resonance = margins.resonance.filter(|margin| margin.value.is_finite());
        let drive = machine.settings.axis(axis).and_then(|own| own.servo.drive);
        let stated = drive.map_or(0.0, |drive| drive.resonance_hz);
        let share = spread(machine, known, axis).frequency;
        let notch = margins.notch.map(|notch| Notched {
            frequency_hz: notch.frequency_hz,
            damping: notch.damping,
            bottom: notch.bottom,
            robust_hz: [stated * (1.0 - share), stated * (1.0 + share)],
        });
        let value = |margin: Option<Margin>| margin.map(|margin| margin.value);
        let frequency = |margin: Option<Margin>| margin.map(|margin| margin.frequency_hz);
        let largest = |gain: f64| Some(gain * margins.factor).filter(|gain| gain.is_finite());
        FeedbackMargins {
            axis: axis.letter(),
            phase_margin_deg: value(margins.phase),
            phase_margin_hz: frequency(margins.phase),
            gain_margin_db: value(margins.gain),
            gain_margin_hz: frequency(margins.gain),
            largest_proportional: largest(feedback.proportional),
            largest_integral_per_s: largest(feedback.integral_per_s),
            assumed_above_hz: drive.as_ref().and_then(check::assumed_lowest_hz),
            resonance_margin_db: value(resonance),
            resonance_margin_hz: frequency(resonance),
            notch,
        }
    };
    let within = |axis| spread(machine, known, axis);
    check::feedback_margins_within(&machine.settings, 1.0 / servo_rate_hz, within).map(of).collect()
}

impl fmt::Display for FeedbackMargins {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "axis {}: contour feedback has ", self.axis)?;
        match (self.phase_margin_deg, self.phase_margin_hz) {
            (Some(deg), Some(hz)) => write!(f, "{deg:.0}° of phase margin at {hz:.1} Hz, ")?,
            _ => write!(f, "a gain below 1, ")?,
        }
        match (self.gain_margin_db, self.gain_margin_hz) {
            (Some(db), Some(hz)) => write!(f, "{db:.1} dB of gain margin at {hz:.0} Hz")?,
            _ => write!(f, "no lag of 180°")?,
        }
        if let (Some(db), Some(hz)) = (self.resonance_margin_db, self.resonance_margin_hz) {
            match self.assumed_above_hz {
                None => write!(f, ", {db:.1} dB at the resonance, {hz:.0} Hz")?,
                Some(lowest) => write!(f, ", {db:.1} dB at {hz:.0} Hz with any resonance above {} Hz", short(lowest))?,
            }
        }
        if let (Some(p), Some(i)) = (self.largest_proportional, self.largest_integral_per_s) {
            // A small gain keeps two digits.
            let digits = if p < 0.1 { 3 } else { 2 };
            write!(f, "; permitted up to K_p {p:.digits$}, K_i {i:.1}/s")?;
        }
        let Some(notch) = &self.notch else { return Ok(()) };
        let [low, high] = notch.robust_hz;
        write!(f, "; notch at {:.0} Hz, robust for {low:.0} to {high:.0} Hz", notch.frequency_hz)
    }
}
