//! JSON and summary of grinding with and without correction.

use anyhow::Result;
use serde::Serialize;
use std::fmt;
use trueaxis::roundness::{ErrorMotion, GaugeFlags};
use trueaxis_sim::grinding::{Grinding, GrindingDocument, Outcome};

/// The document that `--json` prints.
#[derive(Serialize)]
pub(crate) struct Json {
    #[serde(flatten)]
    figures: GrindingDocument,
    wall_s: f64,
}

/// The outcome as one JSON document; `wall_s` is the time taken by both runs.
///
/// # Errors
/// The machine has no gauge.
pub(crate) fn json(outcome: &Outcome, grinding: &Grinding, wall_s: f64) -> Result<Json> {
    Ok(Json { figures: GrindingDocument::new(outcome, grinding)?, wall_s })
}

/// Prints the outcome as plain text.
pub(crate) struct Summary<'o> {
    /// Figures of both runs.
    pub(crate) outcome: &'o Outcome,
    /// The pin and its process.
    pub(crate) grinding: &'o Grinding,
    /// Time taken by both runs, s.
    pub(crate) wall_s: f64,
}

impl fmt::Display for Summary<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (g, o) = (self.grinding, self.outcome);
        let Outcome { uncorrected: before, corrected: after, .. } = o;
        let settings = &g.machine.settings;
        let Some((gauge, infeed)) = settings.roundness.as_ref().and_then(|r| Some((r, r.infeed.as_ref()?))) else {
            return Ok(());
        };
        writeln!(f, "machine  {} ({})", settings.name, settings.chain)?;
        writeln!(
            f,
            "grinding {} revolutions at {:.4} rpm, {} Hz: {} servo cycles",
            g.revolutions, g.speed_rpm, g.rate_hz, after.cycles
        )?;
        writeln!(
            f,
            "gauge    {} points, harmonics {} to {} corrected, gain {}; {} cycles of work on a revolution of {:.0}",
            gauge.points,
            infeed.band.first,
            infeed.band.last,
            infeed.gain,
            after.cycles_of_work,
            60.0 * g.rate_hz / g.speed_rpm
        )?;
        writeln!(f)?;
        writeln!(f, "true surface, last {} revolutions     synchronous imprint    out of roundness", after.averaged)?;
        for (name, run) in [("without correction", before), ("with correction", after)] {
            writeln!(f, "  {name:<36} {:>9.4} µm rms {:>13.3} µm", run.imprint_um, run.roundness_um)?;
        }
        writeln!(f, "  {:<36} {:>9.1} %", "remaining", 100.0 * o.imprint_ratio())?;
        writeln!(f)?;
        writeln!(f, "error motion of the pin's centre        synchronous  asynchronous  once per revolution")?;
        let mut row = |name: &str, motion: &ErrorMotion<f64>| {
            let [a, b] = motion.once_per_revolution_um;
            let (synchronous, asynchronous) = (motion.synchronous_um, motion.asynchronous_um);
            writeln!(f, "  {name:<36} {synchronous:>8.3} µm   {asynchronous:>8.3} µm  {:>16.3} µm", a.hypot(b))
        };
        let [x, y] = &o.motion;
        row("X, across probe 1, true", x)?;
        if let Some(measured) = after.evaluation.filter(|e| e.revolutions > 0) {
            row("X, as the gauge sees it", &measured.x)?;
            row("Y, along probe 1, true", y)?;
            row("Y, as the gauge sees it", &measured.y)?;
        } else {
            row("Y, along probe 1, true", y)?;
        }
        writeln!(f)?;
        writeln!(
            f,
            "revolutions evaluated {}, skipped {}, discarded {}; cycles beyond the correction's limits {}",
            after.counts.evaluated,
            after.counts.skipped,
            after.counts.discarded,
            o.limits_exceeded()
        )?;
        if after.flags.has(GaugeFlags::INFEED_FROZEN) {
            writeln!(f, "note     the infeed correction was frozen at least once: it was limited, or near its bound")?;
        }
        writeln!(f, "two runs in {:.1} s", self.wall_s)
    }
}
