//! Stability margins of the contour feedback, axis by axis.

use crate::Machine;
use serde::Serialize;
use std::fmt;
use trueaxis::check::{self, Margin};

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
}

/// The margins of every linear axis at a servo rate, Hz; empty without contour feedback.
pub fn feedback_margins(machine: &Machine, servo_rate_hz: f64) -> Vec<FeedbackMargins> {
    let Some(feedback) = machine.settings.contour.feedback else { return Vec::new() };
    let of = |(axis, margins): (trueaxis::machine::Axis, check::Margins)| {
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
        }
    };
    check::feedback_margins(&machine.settings, 1.0 / servo_rate_hz).map(of).collect()
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
        match (self.largest_proportional, self.largest_integral_per_s) {
            (Some(p), Some(i)) => write!(f, "; permitted up to K_p {p:.2}, K_i {i:.1}/s"),
            _ => Ok(()),
        }
    }
}
