//! Both runs as one document.

use super::{Grinding, Outcome, Revolution, Run};
use crate::error::Result;
use serde::Serialize;
use trueaxis::roundness::ErrorMotion;

/// Surface after one turn.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RevolutionFigures {
    /// Root mean square of the true surface in the corrected band.
    pub imprint_um: f64,
    /// Peak to valley of the true surface.
    pub roundness_um: f64,
    /// Root mean square of the corrected band as the gauge last evaluated it, once available.
    pub gauge_imprint_um: Option<f64>,
    /// Peak to valley as the gauge evaluates it, once available.
    pub gauge_roundness_um: Option<f64>,
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunFigures {
    /// Root mean square of the average surface in the corrected band.
    pub imprint_um: f64,
    /// Mean peak to valley over the averaged revolutions.
    pub roundness_um: f64,
    /// Revolutions evaluated.
    pub evaluated: u32,
    /// Revolutions skipped.
    pub skipped: u32,
    /// Revolutions discarded.
    pub discarded: u32,
    /// Cycles in which the limiter bounded the infeed axis.
    pub limited_cycles: u64,
    /// One entry per turn.
    pub per_revolution: Vec<RevolutionFigures>,
}

/// Error motion in both directions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Motion {
    /// Across probe 1.
    pub x: ErrorMotion<f64>,
    /// Along probe 1.
    pub y: ErrorMotion<f64>,
}

/// True error motion of the pin's centre, and the gauge's measurement of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpindleFigures {
    /// True error motion.
    #[serde(rename = "true")]
    pub truth: Motion,
    /// Error motion measured by the gauge, once it has a full window.
    pub gauge: Option<Motion>,
}

/// Figures of grinding without and with correction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GrindingDocument {
    /// Name of the machine.
    pub machine: String,
    /// Turns of the spindle.
    pub revolutions: u32,
    /// Points per revolution.
    pub points: u16,
    /// First and last corrected harmonic.
    pub harmonics: [u16; 2],
    /// Servo rate.
    pub servo_rate_hz: f64,
    /// Speed of the spindle.
    pub speed_rpm: f64,
    /// Gain of the correction.
    pub gain: f64,
    /// Servo cycles of a run.
    pub cycles: u64,
    /// Most cycles that the work on a revolution takes.
    pub cycles_of_work: usize,
    /// Number of last revolutions over which the surface is averaged.
    pub averaged_revolutions: usize,
    /// Correction off.
    pub uncorrected: RunFigures,
    /// Correction on.
    pub corrected: RunFigures,
    /// Imprint with correction divided by that without.
    pub imprint_ratio: f64,
    /// Error motion.
    pub spindle: SpindleFigures,
    /// Cycles in which a correction exceeded a limit.
    pub limits_exceeded: u64,
}

impl From<&Revolution> for RevolutionFigures {
    fn from(of: &Revolution) -> Self {
        RevolutionFigures {
            imprint_um: of.imprint_um,
            roundness_um: of.roundness_um,
            gauge_imprint_um: of.gauge_imprint_um,
            gauge_roundness_um: of.gauge_roundness_um,
        }
    }
}

impl From<&Run> for RunFigures {
    fn from(run: &Run) -> Self {
        RunFigures {
            imprint_um: run.imprint_um,
            roundness_um: run.roundness_um,
            evaluated: run.counts.evaluated,
            skipped: run.counts.skipped,
            discarded: run.counts.discarded,
            limited_cycles: run.limited_cycles,
            per_revolution: run.revolutions.iter().map(RevolutionFigures::from).collect(),
        }
    }
}

impl GrindingDocument {
    /// Builds the document of an outcome.
    ///
    /// # Errors
    /// The machine has no gauge.
    pub fn new(outcome: &Outcome, grinding: &Grinding) -> Result<GrindingDocument> {
        let gauge = grinding.gauge()?;
        let infeed = gauge.infeed.as_ref();
        let [x, y] = outcome.motion;
        let measured = outcome.corrected.evaluation.filter(|e| e.revolutions > 0);
        Ok(GrindingDocument {
            machine: grinding.machine.settings.name.as_str().into(),
            revolutions: grinding.revolutions,
            points: gauge.points,
            harmonics: infeed.map_or([0; 2], |infeed| [infeed.band.first, infeed.band.last]),
            servo_rate_hz: grinding.rate_hz,
            speed_rpm: grinding.speed_rpm,
            gain: infeed.map_or(0.0, |infeed| infeed.gain),
            cycles: outcome.corrected.cycles,
            cycles_of_work: outcome.corrected.cycles_of_work,
            averaged_revolutions: outcome.corrected.averaged,
            uncorrected: RunFigures::from(&outcome.uncorrected),
            corrected: RunFigures::from(&outcome.corrected),
            imprint_ratio: outcome.imprint_ratio(),
            spindle: SpindleFigures { truth: Motion { x, y }, gauge: measured.map(|e| Motion { x: e.x, y: e.y }) },
            limits_exceeded: outcome.limits_exceeded(),
        })
    }
}
