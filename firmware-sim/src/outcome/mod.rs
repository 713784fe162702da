//! Comparison of the runs of a scenario: tables, JSON, report.

mod json;
mod shown;

pub use json::Cost;

use crate::latency::{Latency, timed};
use crate::pace::{self, Pace, PaceReport};
use crate::report::Report;
use crate::series::Series;
use crate::stopwatch::Stopwatch;
use anyhow::{Result, anyhow, bail};
use std::ops::ControlFlow;
use std::sync::Arc;
use trueaxis_sim::Scenario;
use trueaxis_sim::run::{self, Kind, ReportedFault, Run, Sink, Tallies};

/// Cycles between two updates of the progress bar.
const STRETCH: u64 = 4096;

/// Note for long steps or late cycles.
const BUSY_KERNEL: &str = "a busy kernel that took the processor away causes steps over the budget and late cycles: the work \
of a step is bounded, and its median and 99 % show its cost";

/// Figures of the runs.
#[derive(Debug)]
pub struct Outcome {
    uncompensated: Tallies,
    compensated: Tallies,
    servo_only: Tallies,
    /// The run with the servo corrected, on a machine with dynamic parts.
    full: Option<Tallies>,
    /// Latency of the corrected run's steps.
    latency: Latency,
    /// Report of the pacing, if it was requested.
    pace: Option<PaceReport>,
    cycles: u64,
    wall_s: f64,
}

/// Timing settings of the steps.
#[derive(Clone, Copy, Debug)]
pub struct Timing {
    /// Time a step may take, ns.
    pub budget_ns: u64,
    /// Whether to time the steps in a further run of the corrected machine, at the real rate.
    pub paced: bool,
}

/// Runs a scenario to its end on the machines of [`Kind::of`], which must be those of `run`. `sinks` receive every
/// cycle; `progress` receives the fraction done, 0 to 1.
///
/// # Errors
/// As [`Run::of`].
pub fn simulate(
    mut run: Run,
    scenario: &Arc<Scenario>,
    timing: Timing,
    mut sinks: Vec<&mut dyn Sink>,
    progress: &mut dyn FnMut(f64),
) -> Result<Outcome> {
    let compensated = Kind::ALL.iter().position(|kind| *kind == Kind::Compensated).unwrap_or(0);
    let mut stopwatch = Stopwatch::new(compensated, scenario, timing.budget_ns);
    let ((), nanoseconds) = timed(|| {
        sinks.push(&mut stopwatch);
        while run.advance(STRETCH, &mut sinks) {
            progress(run.cycle() as f64 / run.cycles() as f64);
        }
        drop(sinks);
    });
    let mut tallies = run.tallies();
    let full = (tallies.len() == Kind::ALL.len()).then(|| tallies.pop()).flatten();
    let [uncompensated, compensated, servo_only] =
        <[Tallies; 3]>::try_from(tallies).map_err(|found| anyhow!("found {} runs, needed three", found.len()))?;
    let (latency, pace) = match timing.paced.then(|| pace(scenario, timing.budget_ns)).transpose()? {
        // The step has no clock, so late cycles of the host must not change its outputs.
        Some((_, _, tallies)) if tallies != compensated => {
            bail!("--paced: found outputs that differ from those of the run, needed the same in every bit")
        }
        Some((latency, report, _)) => (latency, Some(report)),
        None => (stopwatch.latency, None),
    };
    let wall_s = 1e-9 * nanoseconds as f64;
    Ok(Outcome { uncompensated, compensated, servo_only, full, latency, pace, cycles: run.cycles(), wall_s })
}

/// Runs the corrected machine alone at the real rate and times its steps; the figures must equal those of the original run.
fn pace(scenario: &Arc<Scenario>, budget_ns: u64) -> Result<(Latency, PaceReport, Tallies)> {
    let mut run = Run::of(Arc::clone(scenario), &[Kind::Compensated])?;
    let mut stopwatch = Stopwatch::new(0, scenario, budget_ns);
    // Settling only.
    run.advance(0, &mut ());
    let report = pace::run(&Pace::new(scenario.period_ns().into()), |_| match run.advance(1, &mut stopwatch) {
        true => ControlFlow::Continue(()),
        false => ControlFlow::Break(()),
    });
    let tallies = run.tallies().pop().ok_or_else(|| anyhow!("no machine in the paced run"))?;
    Ok((stopwatch.latency, report, tallies))
}

impl Outcome {
    /// The contents of the HTML page; `series` has recorded the runs.
    pub fn report(&self, scenario: &Scenario, series: &Series) -> Report {
        let mut contour = series.contour();
        let mut length = 0.0;
        for step in &scenario.program.moves {
            contour.program_lines.push((length, step.line));
            length += step.length();
        }
        let axes = series.axes();
        Report {
            shown: self.shown(scenario, &axes),
            orientation: series.orientation(),
            contour,
            path: series.path(),
            circle: series.circle(),
            reversals: series.reversals(),
            axes,
            latency: self.latency.summary(),
            latency_buckets: self.latency.buckets().collect(),
        }
    }

    /// Remarks on how the runs went.
    pub fn notes(&self, scenario: &Scenario) -> Vec<String> {
        [self.notes_on_time(), run::notes(scenario, self.cycles, &self.machines())].concat()
    }

    /// Remarks on the measured times.
    fn notes_on_time(&self) -> Vec<String> {
        let mut notes = self.pace.as_ref().map(PaceReport::notes).unwrap_or_default();
        let steps = self.latency.summary();
        let late = self.pace.as_ref().is_some_and(|pace| pace.late > 0 || pace.skipped_periods > 0);
        if late || steps.over_budget > 0 || steps.missed_deadlines > 0 {
            notes.push(BUSY_KERNEL.into());
        }
        notes
    }

    /// The machines with their tallies.
    fn machines(&self) -> Vec<(Kind, Tallies)> {
        let Outcome { uncompensated, compensated, servo_only, full, .. } = self;
        let runs = [uncompensated, compensated, servo_only].into_iter().chain(full);
        Kind::ALL.into_iter().zip(runs.cloned()).collect()
    }

    /// Faults of the corrected run.
    fn faults<'o>(&'o self, scenario: &'o Scenario) -> impl Iterator<Item = ReportedFault> + 'o {
        self.compensated.reported_faults(scenario)
    }
}
