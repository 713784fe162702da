//! `firmware-sim run`: its arguments and output.

use crate::console::{progress_bar, put};
use crate::machine_arg::outputs_of;
use crate::program_args::{Document, noted};
use crate::scenario_args::{ScenarioArgs, prepare};
use anyhow::{Context, Result};
use clap::Args;
use firmware_sim::outcome::{self, Outcome, Timing};
use firmware_sim::report;
use firmware_sim::series::Series;
use firmware_sim::trace::Trace;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trueaxis_sim::Scenario;
use trueaxis_sim::run::{Kind, Run, Sink};
use trueaxis_tables::output::Staged;

#[derive(Args)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// Inject a fault, e.g. dropout:X@1.25s+3, glitch:Y@0.5s+1=5mm, stuck:X@2s+500, late@3s+1=2.5, nan-command:X@2s+1,
    /// jump-command:X@2s+1=3mm (may be given several times; time counts from the start of the program).
    #[arg(long, value_name = "FAULT")]
    fault: Vec<String>,
    /// Time the steps in a further compensated run at the real rate, with real-time scheduling where it is permitted.
    #[arg(long)]
    paced: bool,
    /// Print one JSON document and nothing else.
    #[arg(long)]
    json: bool,
    /// Write index.html and trace.csv into this folder, and trace-full.csv of a full run.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// The traces keep every Nth cycle.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..))]
    trace_every: u64,
}

pub(crate) fn run(args: &RunArgs) -> Result<()> {
    let mut outputs = outputs_of([args.scenario.machine.as_path()], args.scenario.files());
    if let Some(dir) = &args.report {
        outputs.refuse_input(&dir.join("index.html"))?;
        outputs.refuse_input(&dir.join("trace.csv"))?;
        outputs.refuse_input(&dir.join("trace-full.csv"))?;
    }
    let scenario = Arc::new(prepare(&args.scenario, &args.fault)?);
    let simulation = Run::new(Arc::clone(&scenario))?;
    let mut files = match &args.report {
        Some(dir) => {
            outputs.folder(dir)?;
            Some(ReportFiles::create(dir, &scenario, args.trace_every)?)
        }
        None => None,
    };
    let timing = Timing { budget_ns: args.scenario.budget_ns(&scenario), paced: args.paced };
    let bar = progress_bar("simulating");
    let mut tell = |fraction: f64| bar.set_position((1000.0 * fraction) as u64);
    let mut sinks: Vec<&mut dyn Sink> = Vec::new();
    if let Some(files) = &mut files {
        sinks.extend(files.traces.iter_mut().map(|(_, trace)| trace as &mut dyn Sink));
        sinks.push(&mut files.series);
    }
    let outcome = outcome::simulate(simulation, &scenario, timing, sinks, &mut tell)?;
    bar.finish_and_clear();
    let written = files.map(|files| files.finish(&outcome, &scenario)).transpose()?;
    if args.json {
        let document = Document { run: outcome.json(&scenario), noted: &scenario.program.notes };
        put(&format!("{}\n", serde_json::to_string_pretty(&document)?))
    } else {
        let files = written.iter().flatten().map(|file| format!("written  {}\n", file.display()));
        put(&(outcome.summary(&scenario).to_string() + &noted(&scenario.program) + &files.collect::<String>()))
    }
}

/// Files that `run --report` writes.
struct ReportFiles {
    directory: PathBuf,
    traces: Vec<(PathBuf, Trace<BufWriter<Staged>>)>,
    series: Series,
}

impl ReportFiles {
    fn create(directory: &Path, scenario: &Scenario, trace_every: u64) -> Result<ReportFiles> {
        let kinds = Kind::of(&scenario.machine.settings);
        let traced = [(Kind::Compensated, "trace.csv"), (Kind::Full, "trace-full.csv")];
        let open = |(kind, name)| {
            let path = directory.join(name);
            let trace = Staged::create(&path)
                .and_then(|file| Trace::new(BufWriter::new(file), trace_every, kind, &scenario.machine.settings))
                .with_context(|| format!("cannot write {}", path.display()))?;
            Ok((path, trace))
        };
        let traces = traced.into_iter().filter(|(kind, _)| kinds.contains(kind)).map(open).collect::<Result<_>>()?;
        Ok(ReportFiles { directory: directory.into(), traces, series: Series::new(scenario) })
    }

    /// Writes what is left to write; the files.
    fn finish(self, outcome: &Outcome, scenario: &Scenario) -> Result<Vec<PathBuf>> {
        let cannot_write = |path: &Path| format!("cannot write {}", path.display());
        let mut staged = Vec::new();
        for (path, trace) in self.traces {
            let file = trace.finish().with_context(|| cannot_write(&path))?;
            let file = file.into_inner().map_err(|error| error.into_error()).with_context(|| cannot_write(&path))?;
            staged.push((path, file));
        }
        let page = report::write(&outcome.report(scenario, &self.series), &self.directory)
            .with_context(|| format!("cannot write into {}", self.directory.display()))?;
        let mut written = vec![page];
        // After the page: dropped where that is refused.
        for (path, file) in staged {
            file.commit().with_context(|| cannot_write(&path))?;
            written.push(path);
        }
        Ok(written)
    }
}
