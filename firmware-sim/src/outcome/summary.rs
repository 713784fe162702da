//! The outcome for the console.

use super::Outcome;
use std::fmt;
use trueaxis_sim::Scenario;
use trueaxis_sim::run::{Kind, Tallies};
use trueaxis_tables::text::counted;

impl Outcome {
    /// The summary for the console.
    pub fn summary<'o>(&'o self, scenario: &'o Scenario) -> Summary<'o> {
        Summary { outcome: self, scenario }
    }
}

const RUNS: [&str; 4] = ["without compensation", "with compensation", "perfect geometry", "full"];

/// Prints the outcome as plain text.
pub struct Summary<'o> {
    outcome: &'o Outcome,
    scenario: &'o Scenario,
}

impl fmt::Display for Summary<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.scenario(f)?;
        self.contour_errors(f)?;
        if self.scenario.five_axis {
            self.orientation_errors(f)?;
        }
        self.cost(f)?;
        self.remarks(f)
    }
}

impl Summary<'_> {
    /// Every run with its name.
    fn runs(&self) -> impl Iterator<Item = (&'static str, &Tallies)> {
        let Outcome { uncompensated, compensated, servo_only, full, .. } = self.outcome;
        RUNS.into_iter().zip([uncompensated, compensated, servo_only].into_iter().chain(full))
    }

    fn scenario(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let s = self.scenario;
        let simulated = self.outcome.cycles as f64 * s.period_s();
        writeln!(f, "machine  {} ({})", s.machine.settings.name, s.machine.settings.chain)?;
        writeln!(
            f,
            "program  {}, {:.1} s at {} Hz, {} servo cycles",
            s.program.name,
            simulated,
            s.rate_hz(),
            self.outcome.cycles
        )?;
        for (key, value, default) in s.settings.changes() {
            writeln!(f, "setting  {key} = {value} (default {default})")?;
        }
        writeln!(f)
    }

    fn contour_errors(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "true contour error of the tool tip while cutting      largest        RMS")?;
        for (name, run) in self.runs() {
            writeln!(f, "  {name:<46} {:>9.3} µm {:>7.3} µm", run.error.max_um, run.error.rms_um)?;
        }
        let Outcome { uncompensated, compensated, full, .. } = self.outcome;
        let before = uncompensated.error;
        if before.max_um > 0.0 && before.rms_um > 0.0 {
            let shares = [("remaining with compensation", Some(compensated)), ("remaining in full", full.as_ref())];
            for (name, after) in shares.into_iter().filter_map(|(name, run)| Some((name, run?.error))) {
                let share = [after.max_um / before.max_um, after.rms_um / before.rms_um].map(|share| 100.0 * share);
                writeln!(f, "  {name:<46} {:>9.1} %  {:>7.1} %", share[0], share[1])?;
            }
        }
        Ok(())
    }

    fn orientation_errors(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "true angle of the tool from the programmed direction")?;
        for (name, run) in self.runs() {
            let size = run.orientation;
            writeln!(f, "  {name:<44} {:>9.2} µrad {:>6.2} µrad", size.max_urad, size.rms_urad)?;
        }
        writeln!(f, "both as the step itself reports them")?;
        // Leave out the perfect machine: the step would report its tables' errors, which that machine does not have.
        for (name, run) in self.runs().filter(|(_, run)| !std::ptr::eq(*run, &self.outcome.servo_only)) {
            let (tip, angle) = (run.estimated, run.estimated_orientation);
            writeln!(f, "  {name:<46} {:>9.3} µm {:>7.3} µm", tip.max_um, tip.rms_um)?;
            writeln!(f, "  {:<44} {:>9.2} µrad {:>6.2} µrad", "", angle.max_urad, angle.rms_urad)?;
        }
        Ok(())
    }

    fn cost(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let simulated = self.outcome.cycles as f64 * self.scenario.period_s();
        let latency = self.outcome.latency.summary();
        writeln!(f)?;
        writeln!(f, "cost of one step, wall time on this host (shown, never gated)")?;
        writeln!(
            f,
            "  min {} ns, median {} ns, 99 % {} ns, 99.99 % {} ns, max {} ns; budget {} ns, period {} ns",
            latency.min_ns,
            latency.p50_ns,
            latency.p99_ns,
            latency.p99_99_ns,
            latency.max_ns,
            latency.budget_ns,
            latency.period_ns
        )?;
        writeln!(f, "  over budget {}, missed deadlines {}", latency.over_budget, latency.missed_deadlines)?;
        writeln!(
            f,
            "  {} runs in {:.1} s: {:.0} times real time each",
            if self.outcome.full.is_some() { "four" } else { "three" },
            self.outcome.wall_s,
            self.runs().count() as f64 * simulated / self.outcome.wall_s.max(1e-9)
        )?;
        let digests = self.runs().zip(Kind::ALL).map(|((_, run), kind)| format!("{} {:08x}", kind.name(), run.digest));
        writeln!(f, "  digest of every output: {}", digests.collect::<Vec<_>>().join(", "))?;
        writeln!(f)
    }

    fn remarks(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.outcome.compensated.faults.is_empty() {
            writeln!(f, "faults   none")?;
        }
        for fault in self.outcome.faults(self.scenario) {
            writeln!(
                f,
                "fault    {:.4} s, line {}: {} on axis {}, {}",
                fault.time_s,
                fault.line,
                fault.fault,
                fault.axis,
                counted(fault.cycles as usize, "cycle")
            )?;
        }
        for note in self.outcome.notes(self.scenario) {
            writeln!(f, "note     {note}")?;
        }
        Ok(())
    }
}
