//! The three runs side by side: console summary, JSON, report.

use crate::latency::{Latency, timed};
use crate::pace::{self, Pace, PaceReport};
use crate::report::{ContourErrors, FaultEntry, Report};
use crate::series::Series;
use crate::stopwatch::Stopwatch;
use anyhow::{Result, anyhow};
use serde::Serialize;
use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;
use trueaxis_sim::run::{AngleSize, ErrorSize, Kind, MOST_FAULT_SPANS, Run, Sink, Tallies};
use trueaxis_sim::scenario::Scenario;
use trueaxis_tables::text::counted;

/// Cycles between two looks at the progress.
const STRETCH: u64 = 4096;

/// Said where steps took long or cycles came late.
const BUSY_KERNEL: &str = "steps over the budget and late cycles are the doing of a busy kernel, which took the processor \
away: the work of a step is bounded, its median and 99 % are what it costs";

/// What the three runs gave.
#[derive(Debug)]
pub struct Outcome {
    uncompensated: Tallies,
    compensated: Tallies,
    servo_only: Tallies,
    /// Cost of the compensated run's steps.
    latency: Latency,
    /// How pacing went, if it was asked for.
    pace: Option<PaceReport>,
    cycles: u64,
    wall_s: f64,
}

/// Runs a scenario to its end on the machines of [`Kind::ALL`], which `run` was made for. `sinks` get every cycle; `progress` gets the fraction done, 0
/// to 1. `paced`: the steps are timed in a further run of the compensated machine, at the real rate.
///
/// # Errors
/// As [`Run::of`].
pub fn simulate(
    mut run: Run,
    scenario: &Arc<Scenario>,
    paced: bool,
    mut sinks: Vec<&mut dyn Sink>,
    progress: &mut dyn FnMut(f64),
) -> Result<Outcome> {
    let compensated = Kind::ALL.iter().position(|kind| *kind == Kind::Compensated).unwrap_or(0);
    let mut stopwatch = Stopwatch::new(compensated, scenario);
    let ((), nanoseconds) = timed(|| {
        sinks.push(&mut stopwatch);
        while run.advance(STRETCH, &mut sinks) {
            progress(run.cycle() as f64 / run.cycles() as f64);
        }
        drop(sinks);
    });
    let tallies = run.tallies();
    let [uncompensated, compensated, servo_only] =
        <[Tallies; 3]>::try_from(tallies).map_err(|found| anyhow!("{} runs in place of three", found.len()))?;
    let (latency, pace) = match paced.then(|| pace(scenario)).transpose()? {
        Some((latency, report)) => (latency, Some(report)),
        None => (stopwatch.latency, None),
    };
    let wall_s = 1e-9 * nanoseconds as f64;
    Ok(Outcome { uncompensated, compensated, servo_only, latency, pace, cycles: run.cycles(), wall_s })
}

/// Runs the compensated machine alone at the real rate, for what its steps cost there.
fn pace(scenario: &Arc<Scenario>) -> Result<(Latency, PaceReport)> {
    let mut run = Run::of(Arc::clone(scenario), &[Kind::Compensated])?;
    let mut stopwatch = Stopwatch::new(0, scenario);
    // Only settles.
    run.advance(0, &mut ());
    let report = pace::run(&Pace::new(scenario.period_ns().into()), |_| match run.advance(1, &mut stopwatch) {
        true => ControlFlow::Continue(()),
        false => ControlFlow::Break(()),
    });
    Ok((stopwatch.latency, report))
}

#[derive(Serialize)]
struct Size {
    max: f64,
    rms: f64,
}

#[derive(Serialize)]
struct ErrorJson {
    uncompensated: Size,
    compensated: Size,
    servo_only: Size,
}

/// Of the perfect machine the step would report the errors that its tables have and the machine has not.
#[derive(Serialize)]
struct EstimateJson {
    uncompensated: Size,
    compensated: Size,
}

#[derive(Serialize)]
struct LatencyJson {
    min: u64,
    p50: u64,
    p99: u64,
    p99_99: u64,
    max: u64,
}

#[derive(Serialize)]
struct FaultJson {
    time_s: f64,
    fault: String,
    code: u8,
    axis: char,
    line: u32,
    cycles: u64,
}

/// What `--json` prints.
#[derive(Serialize)]
pub struct Json {
    machine: String,
    program: String,
    cycles: u64,
    servo_rate_hz: f64,
    contour_error_um: ErrorJson,
    /// Programs with rotary axes only.
    #[serde(skip_serializing_if = "Option::is_none")]
    orientation_error_urad: Option<ErrorJson>,
    /// The same two as the step itself reports them.
    #[serde(skip_serializing_if = "Option::is_none")]
    estimated_contour_error_um: Option<EstimateJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    estimated_orientation_error_urad: Option<EstimateJson>,
    latency_ns: LatencyJson,
    budget_ns: u64,
    over_budget: u64,
    missed_deadlines: u64,
    faults: Vec<FaultJson>,
    stopped: bool,
    limited_cycles: u64,
    simulated_s: f64,
    wall_s: f64,
    notes: Vec<String>,
}

impl Outcome {
    /// Remarks on how the runs went.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = self.pace.as_ref().map(PaceReport::notes).unwrap_or_default();
        let steps = self.latency.summary();
        let late = self.pace.as_ref().is_some_and(|pace| pace.late > 0 || pace.skipped_periods > 0);
        if late || steps.over_budget > 0 || steps.missed_deadlines > 0 {
            notes.push(BUSY_KERNEL.into());
        }
        if self.compensated.stopped {
            notes.push("the compensated run was ended by a stop request".into());
        }
        if self.compensated.more_faults > 0 {
            notes.push(format!(
                "faults: the first {} are listed; there are faults in {} after them",
                MOST_FAULT_SPANS,
                counted(self.compensated.more_faults as usize, "cycle")
            ));
        }
        notes
    }

    fn faults<'o>(&'o self, scenario: &'o Scenario) -> impl Iterator<Item = FaultJson> + 'o {
        self.compensated.faults.iter().map(|span| FaultJson {
            time_s: span.cycle as f64 * scenario.period_s(),
            fault: format!("{:?}", span.fault),
            code: span.fault as u8,
            axis: span.axis.letter(),
            line: span.line,
            cycles: span.cycles,
        })
    }

    fn each(&self, size: impl Fn(&Tallies) -> Size) -> ErrorJson {
        ErrorJson {
            uncompensated: size(&self.uncompensated),
            compensated: size(&self.compensated),
            servo_only: size(&self.servo_only),
        }
    }

    /// The outcome as one JSON document.
    pub fn json(&self, scenario: &Scenario) -> Json {
        let length = |size: &ErrorSize| Size { max: size.max_um, rms: size.rms_um };
        let angle = |size: &AngleSize| Size { max: size.max_urad, rms: size.rms_urad };
        let estimate = |size: &dyn Fn(&Tallies) -> Size| {
            let of_both =
                || EstimateJson { uncompensated: size(&self.uncompensated), compensated: size(&self.compensated) };
            scenario.five_axis.then(of_both)
        };
        let latency = self.latency.summary();
        Json {
            machine: scenario.machine.settings.name.as_str().into(),
            program: scenario.program.name.clone(),
            cycles: self.cycles,
            servo_rate_hz: scenario.rate_hz,
            contour_error_um: self.each(|run| length(&run.error)),
            orientation_error_urad: scenario.five_axis.then(|| self.each(|run| angle(&run.orientation))),
            estimated_contour_error_um: estimate(&|run| length(&run.estimated)),
            estimated_orientation_error_urad: estimate(&|run| angle(&run.estimated_orientation)),
            latency_ns: LatencyJson {
                min: latency.min_ns,
                p50: latency.p50_ns,
                p99: latency.p99_ns,
                p99_99: latency.p99_99_ns,
                max: latency.max_ns,
            },
            budget_ns: latency.budget_ns,
            over_budget: latency.over_budget,
            missed_deadlines: latency.missed_deadlines,
            faults: self.faults(scenario).collect(),
            stopped: self.compensated.stopped,
            limited_cycles: self.compensated.limited_cycles,
            simulated_s: self.cycles as f64 * scenario.period_s(),
            wall_s: self.wall_s,
            notes: self.notes(),
        }
    }

    /// Everything the HTML page shows; `series` has seen the runs.
    pub fn report(&self, scenario: &Scenario, series: &Series) -> Report {
        let mut contour = series.contour();
        let mut length = 0.0;
        for step in &scenario.program.moves {
            contour.program_lines.push((length, step.line));
            length += step.length();
        }
        Report {
            orientation: series.orientation(),
            title: "Compensated servo step".into(),
            machine: scenario.machine.settings.name.as_str().into(),
            program: scenario.program.name.clone(),
            chain: scenario.machine.settings.chain.as_str().into(),
            servo_rate_hz: scenario.rate_hz,
            cycles: self.cycles,
            contour_error: ContourErrors {
                uncompensated: self.uncompensated.error,
                compensated: self.compensated.error,
                servo_only: self.servo_only.error,
            },
            contour,
            path: series.path(),
            axes: series.axes(),
            latency: self.latency.summary(),
            latency_buckets: self.latency.buckets().collect(),
            faults: self
                .faults(scenario)
                .map(|f| FaultEntry {
                    time_s: f.time_s,
                    code: f.code.to_string(),
                    description: format!("{} on axis {}, program line {}", f.fault, f.axis, f.line),
                    cycles: f.cycles,
                })
                .collect(),
            notes: self.notes(),
        }
    }

    /// The summary for the console.
    pub fn summary<'o>(&'o self, scenario: &'o Scenario) -> Summary<'o> {
        Summary { outcome: self, scenario }
    }
}

const RUNS: [&str; 3] = ["without compensation", "with compensation", "servo alone (perfect geometry)"];

/// Prints the outcome in plain words.
pub struct Summary<'o> {
    outcome: &'o Outcome,
    scenario: &'o Scenario,
}

impl fmt::Display for Summary<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Outcome { uncompensated: before, compensated: after, servo_only: servo, .. } = self.outcome;
        let s = self.scenario;
        let simulated = self.outcome.cycles as f64 * s.period_s();
        writeln!(f, "machine  {} ({})", s.machine.settings.name, s.machine.settings.chain)?;
        writeln!(
            f,
            "program  {}, {:.1} s at {} Hz, {} servo cycles",
            s.program.name, simulated, s.rate_hz, self.outcome.cycles
        )?;
        writeln!(f)?;
        writeln!(f, "true contour error of the tool tip while cutting      largest        RMS")?;
        let runs = [before, after, servo];
        for (name, run) in RUNS.into_iter().zip(runs) {
            writeln!(f, "  {name:<46} {:>9.3} µm {:>7.3} µm", run.error.max_um, run.error.rms_um)?;
        }
        if before.error.max_um > 0.0 && before.error.rms_um > 0.0 {
            writeln!(
                f,
                "  what is left                                   {:>9.1} %  {:>7.1} %",
                100.0 * after.error.max_um / before.error.max_um,
                100.0 * after.error.rms_um / before.error.rms_um
            )?;
        }
        if s.five_axis {
            writeln!(f, "true angle of the tool from the programmed direction")?;
            for (name, run) in RUNS.into_iter().zip(runs) {
                let size = run.orientation;
                writeln!(f, "  {name:<44} {:>9.2} µrad {:>6.2} µrad", size.max_urad, size.rms_urad)?;
            }
            writeln!(f, "both as the step itself reports them")?;
            for (name, run) in RUNS.into_iter().zip(runs).take(2) {
                let (tip, angle) = (run.estimated, run.estimated_orientation);
                writeln!(f, "  {name:<46} {:>9.3} µm {:>7.3} µm", tip.max_um, tip.rms_um)?;
                writeln!(f, "  {:<44} {:>9.2} µrad {:>6.2} µrad", "", angle.max_urad, angle.rms_urad)?;
            }
        }
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
            "  three runs in {:.1} s: {:.0} times real time each",
            self.outcome.wall_s,
            3.0 * simulated / self.outcome.wall_s.max(1e-9)
        )?;
        writeln!(f)?;
        if after.faults.is_empty() {
            writeln!(f, "faults   none")?;
        }
        for fault in self.outcome.faults(s) {
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
        for note in self.outcome.notes() {
            writeln!(f, "note     {note}")?;
        }
        Ok(())
    }
}
