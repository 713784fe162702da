//! Check of a machine as a controller loads it at a servo rate: compiled form, doubtful settings, ramp of lost motion,
//! margins.

use anyhow::{Result, bail};
use serde::Serialize;
use std::path::Path;
use trueaxis::tcomp::Tcomp;
use trueaxis_tables::error::FileError;
use trueaxis_tables::files::Source;
use trueaxis_tables::uncertainty::Uncertainties;
use trueaxis_tables::{DynamicNeed, FeedbackMargins, LostMotion, Machine, Summary, Warning};
use trueaxis_tables::{
    build, check, compile, dynamic_needs, feedback_margins_within, feedback_within, lost_motion, summary,
};

/// Refuses a servo rate that no controller has, Hz.
///
/// # Errors
/// A rate outside 10 Hz to 1 MHz.
pub fn rate(rate_hz: f64) -> Result<()> {
    if (10.0..=1e6).contains(&rate_hz) { Ok(()) } else { bail!("--rate-hz: found {rate_hz}, needed 10 to 1000000") }
}

/// The compiled form of a machine, once a controller's build at this rate, Hz, has accepted it. `files` and `name` are where
/// its `machine.toml` was read, so that a refusal names the key.
///
/// # Errors
/// A rate outside 10 Hz to 1 MHz; anything that [`compile`] or [`build`] refuses.
pub fn compiled(machine: &Machine, files: &dyn Source, name: &Path, rate_hz: f64) -> Result<Vec<u8>> {
    rate(rate_hz)?;
    let bytes = compile(machine).map_err(|error| Machine::refusal(files, name, &error))?;
    let known = Uncertainties::read_from(files, name)?;
    build(machine, rate_hz).and_then(|()| feedback_within(machine, &known, rate_hz)).map_err(|error| {
        let refusal = Machine::refusal(files, name, &error);
        FileError { needed: format!("{} (at {rate_hz} Hz)", refusal.needed), ..refusal }
    })?;
    Ok(bytes)
}

/// Remarks on a machine that was accepted.
#[derive(Clone, Debug)]
pub struct Findings {
    /// Doubtful settings.
    pub warnings: Vec<Warning>,
    /// Axes with lost motion.
    pub lost_motion: Vec<LostMotion>,
    /// Margins of the contour feedback.
    pub margins: Vec<FeedbackMargins>,
    /// Magnitudes that the parts of the dynamic correction need.
    pub dynamic_needs: Vec<DynamicNeed>,
    /// The compiled file in figures.
    pub summary: Summary,
}

/// Checks a machine, its stated uncertainties and its compiled form at a servo rate, Hz.
pub fn findings(machine: &Machine, known: &Uncertainties, tables: &Tcomp<'_>, rate_hz: f64) -> Findings {
    Findings {
        warnings: check(machine, rate_hz),
        lost_motion: lost_motion(machine),
        margins: feedback_margins_within(machine, known, rate_hz),
        dynamic_needs: dynamic_needs(machine),
        summary: summary(tables),
    }
}

/// [`Findings`] in serialised form.
#[derive(Clone, Debug, Serialize)]
pub struct CheckDocument {
    /// Always true: a machine with an error is refused.
    pub ok: bool,
    /// Doubtful settings, a sentence each.
    pub warnings: Vec<String>,
    /// Axes with lost motion.
    pub lost_motion: Vec<Lost>,
    /// Margins of the contour feedback.
    pub feedback_margins: Vec<FeedbackMargins>,
    /// Magnitudes that the parts of the dynamic correction need, beside its limit.
    pub dynamic_needs: Vec<DynamicNeed>,
    /// The compiled file in figures.
    pub summary: Summary,
}

impl From<Findings> for CheckDocument {
    fn from(found: Findings) -> CheckDocument {
        CheckDocument {
            ok: true,
            warnings: found.warnings.iter().map(ToString::to_string).collect(),
            lost_motion: found.lost_motion.iter().map(Lost::from).collect(),
            feedback_margins: found.margins,
            dynamic_needs: found.dynamic_needs,
            summary: found.summary,
        }
    }
}

/// Lost motion in the units of the files.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Lost {
    /// A linear axis.
    Linear {
        /// The axis.
        axis: char,
        /// Largest lost motion, µm.
        play_um: f64,
        /// Time in which it is corrected, ms.
        #[serde(rename = "lead_in_ms")]
        ramp_in_ms: f64,
        /// Highest feed, mm/s.
        feed_mm_per_s: f64,
        /// Distance travelled at that feed in that time, mm.
        way_mm: f64,
    },
    /// A rotary axis.
    Rotary {
        /// The axis.
        axis: char,
        /// Largest lost motion, µrad.
        play_urad: f64,
        /// Time in which it is corrected, ms.
        #[serde(rename = "lead_in_ms")]
        ramp_in_ms: f64,
        /// Highest feed, degrees/s.
        feed_deg_per_s: f64,
        /// Angle turned at that feed in that time, degrees.
        way_deg: f64,
    },
}

impl From<&LostMotion> for Lost {
    fn from(lost: &LostMotion) -> Lost {
        let (axis, ramp_in_ms) = (lost.axis.letter(), lost.ramp_in_s * 1e3);
        if lost.axis.is_rotary() {
            let play_urad = lost.play.to_radians() * 1e6;
            Lost::Rotary { axis, play_urad, ramp_in_ms, feed_deg_per_s: lost.feed_per_s, way_deg: lost.way }
        } else {
            let play_um = lost.play * 1e3;
            Lost::Linear { axis, play_um, ramp_in_ms, feed_mm_per_s: lost.feed_per_s, way_mm: lost.way }
        }
    }
}
