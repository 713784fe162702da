//! `firmware-sim run`: arguments and output.

use crate::console::{progress_bar, put};
use crate::machine_arg::outputs_of;
use crate::program_args::noted;
use crate::scenario_args::{ScenarioArgs, prepare_with};
use crate::settings_args::ActArgs;
use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use firmware_sim::figures;
use firmware_sim::learning_record::LearningRecord;
use firmware_sim::outcome::{self, Timing};
use firmware_sim::report;
use firmware_sim::series::Series;
use firmware_sim::trace::Trace;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trueaxis_columnar::{Form, PARQUET};
use trueaxis_sim::Scenario;
use trueaxis_sim::learning::{self, Instrument, LearnedTable, Recorder};
use trueaxis_sim::run::{Kind, Run, Sink};
use trueaxis_tables::output::{Outputs, Staged};

const HELP: &str = "\
A machine with friction, a dynamic correction, contour feedback or cross-talk gets the fourth run, everything on, \
with every correction of the plugin. The corrected run corrects only the geometry.

The drives of the simulated machine are settings of the scenario, [drive] and [axis.X] in `firmware-sim scenario`; \
those that the plugin uses are in machine.toml. They need not agree.

--drive VARIANT[@AXIS] simulates motor and load as two masses. Each variant is stable and damped without the plugin:

         resonance  antires.  damping  load   scale   play  Kv    Kvp   k_ff  friction
         Hz         Hz        %        share  at      µm    1/s   1/s         mm/s²
  stiff  250        209       3        0.3    load    0     110   800   0.93  420
  usual  120        93        3        0.4    load    0     60    350   0.9   420
  soft   45         32        4        0.5    motor   0     25    150   0     420
  worn   80         62        2        0.4    motor   6     35    250   0.9   650

worn has a torque ripple of 60 mm/s² every 10 mm, too. Without --drive the axes are rigid. The figures are settings of \
[drive]; a variant of one axis replaces [drive] there.

More examples:
  # A machine that differs from its machine.toml:
  firmware-sim run --set drive.coulomb_mm_per_s2=500
  firmware-sim run --set axis.Y.friction_factor=1.3
  # An old Y axis on a usual machine:
  firmware-sim run --drive usual --drive worn@Y";

#[derive(Args)]
#[command(before_help = "Example:\n  firmware-sim run --program short-tour --report out", after_help = HELP)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    scenario: ScenarioArgs,
    #[command(flatten)]
    acts: ActArgs,
    /// Time the steps in a further corrected run at the real rate, with real-time scheduling if it is permitted.
    #[arg(long)]
    paced: bool,
    /// Print one JSON document and nothing else.
    #[arg(long)]
    json: bool,
    /// Write index.html and trace.csv into this folder, and trace-full.csv of the run with everything on.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Write the traces (trace.parquet, trace-full.parquet) and the figures (result.parquet) into this folder, as columns
    /// for DuckDB, Polars or pandas; needs the feature `parquet`.
    #[arg(long, value_name = "DIR")]
    parquet: Option<PathBuf>,
    /// Correction learned on this program, for the run with everything on.
    #[arg(long, value_name = "FILE.tlearn")]
    learned: Option<PathBuf>,
    /// Write the contour error of the run with everything on over path length, for `trueaxis learn`.
    #[arg(long, value_name = "FILE.csv")]
    record: Option<PathBuf>,
    /// Source of the contour error of that record.
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = MeasuredBy::Estimate)]
    measured_by: MeasuredBy,
    /// The traces keep every Nth cycle.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..))]
    trace_every: u64,
}

pub(crate) fn run(args: &RunArgs) -> Result<()> {
    if args.parquet.is_some() && !PARQUET {
        bail!(
            "--parquet: found a program built without Parquet, needed: cargo run --release --features parquet -- run --parquet DIR"
        );
    }
    let scenario = with_learned(prepare_with(&args.scenario, &args.acts)?, args.learned.as_deref())?;
    let machines = scenario.exchanges.keys().map(Path::new).chain([args.scenario.machine.as_path()]);
    let mut outputs = outputs_of(machines, args.scenario.files().chain(args.learned.as_deref()));
    for name in ["index.html", "trace.csv", "trace-full.csv"] {
        args.report.iter().try_for_each(|dir| outputs.refuse_input(&dir.join(name)))?;
    }
    for name in ["result.parquet", "trace.parquet", "trace-full.parquet"] {
        args.parquet.iter().try_for_each(|dir| outputs.refuse_input(&dir.join(name)))?;
    }
    let scenario = Arc::new(scenario);
    let simulation = Run::new(Arc::clone(&scenario))?;
    let mut traces = Vec::new();
    for (dir, form) in [(&args.report, Form::Csv), (&args.parquet, Form::Parquet)] {
        if let Some(dir) = dir {
            traces.extend(begin_traces(dir, form, &scenario, args.trace_every, &mut outputs)?);
        }
    }
    let mut series = args.report.is_some().then(|| Series::new(&scenario));
    let record = args.record.as_ref().map(|path| record_to(path, &scenario, args.measured_by, &mut outputs));
    let mut record = record.transpose()?;
    let timing = Timing { budget_ns: args.scenario.budget_ns(&scenario), paced: args.paced };
    let bar = progress_bar("simulating");
    let mut progress = |fraction: f64| bar.set_position((1000.0 * fraction) as u64);
    let mut sinks: Vec<&mut dyn Sink> = Vec::new();
    sinks.extend(traces.iter_mut().map(|(_, trace)| trace as &mut dyn Sink));
    sinks.extend(series.as_mut().map(|series| series as &mut dyn Sink));
    sinks.extend(record.as_mut().map(|record| record as &mut dyn Sink));
    let outcome = outcome::simulate(simulation, &scenario, timing, sinks, &mut progress)?;
    bar.finish_and_clear();
    // The summary names the traces last, but their files take their places first.
    let traces = finish_traces(traces, &mut outputs)?;
    let mut written = Vec::new();
    if let (Some(series), Some(dir)) = (&series, &args.report) {
        let page = dir.join("index.html");
        outputs.put(&page, report::render(&outcome.report(&scenario, series)).as_bytes())?;
        written.push(page);
    }
    if let Some(dir) = &args.parquet {
        let result = dir.join("result.parquet");
        let document = serde_json::to_value(outcome.json(&scenario))?;
        outputs.put(&result, &figures::table(&document).with_context(|| cannot_write(&result))?)?;
        written.push(result);
    }
    written.extend(traces);
    if let (Some(record), Some(path)) = (record, &args.record) {
        outputs.add(path, complete(record.finish(), path)?);
        written.push(path.clone());
    }
    outputs.commit()?;
    if args.json {
        put(&trueaxis_evaluation::json::pretty(&outcome.json(&scenario))?)
    } else {
        let files = written.iter().map(|file| format!("written  {}\n", file.display()));
        put(&(outcome.shown(&scenario, &[]).text() + &noted(&scenario.program) + &files.collect::<String>()))
    }
}

/// Source of the contour error to learn from.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MeasuredBy {
    /// The step, from the encoders.
    Estimate,
    /// A grid encoder between table and spindle.
    Grid,
}

impl From<MeasuredBy> for Instrument {
    fn from(by: MeasuredBy) -> Instrument {
        match by {
            MeasuredBy::Estimate => Instrument::Estimate,
            MeasuredBy::Grid => Instrument::Grid,
        }
    }
}

/// The scenario with a learned correction read from its file.
pub(crate) fn with_learned(scenario: Scenario, file: Option<&Path>) -> Result<Scenario> {
    let Some(file) = file else { return Ok(scenario) };
    let bytes = std::fs::read(file).with_context(|| format!("--learned: cannot read {}", file.display()))?;
    let of_file = || format!("--learned {}", file.display());
    let table = LearnedTable::read(bytes).with_context(of_file)?;
    scenario.with_learned(Arc::new(table)).with_context(of_file)
}

/// Begins the record of the run with everything on.
fn record_to(
    path: &Path,
    scenario: &Scenario,
    measured_by: MeasuredBy,
    outputs: &mut Outputs,
) -> Result<LearningRecord<BufWriter<Staged>>> {
    let kinds = Kind::of(&scenario.machine.settings);
    let Some(run) = kinds.iter().position(|kind| *kind == Kind::Full) else {
        bail!("--record: found a machine without dynamic correction, needed [axis.X.dynamic] in its machine.toml");
    };
    let identity = learning::identity(scenario, &scenario.motion()?);
    let recorder = Recorder::new(scenario, measured_by.into())?;
    let file = BufWriter::new(outputs.begin(path)?);
    LearningRecord::new(file, run, &identity, recorder).with_context(|| cannot_write(path))
}

fn cannot_write(path: &Path) -> String {
    format!("cannot write {}", path.display())
}

/// The file behind a writer, after flushing it.
fn complete(written: std::io::Result<BufWriter<Staged>>, path: &Path) -> Result<Staged> {
    written.and_then(|out| out.into_inner().map_err(|error| error.into_error())).with_context(|| cannot_write(path))
}

/// A trace being written, and its path.
type FileTrace = (PathBuf, Trace<BufWriter<Staged>>);

/// Opens the trace files of a run in a folder.
fn begin_traces(
    directory: &Path,
    form: Form,
    scenario: &Scenario,
    every: u64,
    outputs: &mut Outputs,
) -> Result<Vec<FileTrace>> {
    outputs.folder(directory)?;
    let extension = if form == Form::Csv { "csv" } else { "parquet" };
    let settings = &scenario.machine.settings;
    let kinds = Kind::of(settings);
    let traced = [(Kind::Compensated, "trace"), (Kind::Full, "trace-full")];
    let open = |(kind, name): (Kind, &str)| {
        let path = directory.join(name).with_extension(extension);
        let file = BufWriter::new(outputs.begin(&path)?);
        let trace = Trace::new(file, form, every, kind, settings).with_context(|| cannot_write(&path))?;
        Ok((path, trace))
    };
    traced.into_iter().filter(|(kind, _)| kinds.contains(kind)).map(open).collect()
}

/// Completes the traces; returns the paths at which the commit places their files.
fn finish_traces(traces: Vec<FileTrace>, outputs: &mut Outputs) -> Result<Vec<PathBuf>> {
    let finish = |(path, trace): FileTrace| {
        outputs.add(&path, complete(trace.finish(), &path)?);
        Ok(path)
    };
    traces.into_iter().map(finish).collect()
}
