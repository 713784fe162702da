//! `firmware-sim`: servo cycles on the host, with the machine simulated.

// print! and its like panic when the other end of a pipe is closed: `put` and `tell` do not.
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod compare_command;
mod grind;
mod program_args;
mod record;
mod rtcp;

use anyhow::{Context, Result, anyhow, bail};
use clap::{Args, Parser, Subcommand, ValueEnum};
use firmware_sim::motion::{Motion, MotionSettings};
use firmware_sim::outcome::{self, Outcome};
use firmware_sim::placement::Placement;
use firmware_sim::plant::fault::FaultScript;
use firmware_sim::scenario::{Scenario, axis_count, middle_of_travel, sample_machine};
use firmware_sim::series::Series;
use firmware_sim::simulate::{Kind, Sink};
use firmware_sim::trace::Trace;
use firmware_sim::{bench, report};
use indicatif::{ProgressBar, ProgressStyle};
use program_args::{Document, ProgramArgs, noted};
use serde_json::json;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use trueaxis::machine::ErrorModel;
use trueaxis_tables::Machine;
use trueaxis_tables::output::{Outputs, Staged};
use trueaxis_tables::text::{counted, printable};

/// Runs a part program through the compensated servo step against a simulated machine, and shows what was gained on
/// the part and what each cycle cost.
///
/// Without a command: `run` with the default scenario, and the report in ./report.
///
/// Exit code 0: done; 2: bad input. A reader that closes the standard output or error early (`| head`) ends the program
/// without a word: exit code 0.
#[derive(Parser)]
#[command(version, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Simulate a program three times: without and with compensation, and on a geometrically perfect machine.
    Run(RunArgs),
    /// Time the step alone, without the simulated machine.
    Bench(BenchArgs),
    /// Grind a crankpin twice: without and with the infeed correction of the three-probe gauge.
    ///
    /// Both runs have the same seed; the true surface is measured after every revolution.
    ///
    /// The pin circles with the crankshaft; three probes on an arm that follows it see the surface and the motion of the
    /// pin's centre. That motion is imprinted on the pin: where the centre comes toward the wheel, too much is ground off.
    /// The gauge separates surface and motion while the servo loop runs, and corrects the infeed of the next revolutions.
    /// Only what repeats with every turn (the synchronous imprint) can be corrected; it should fall below a tenth.
    ///
    /// The gauge works on one revolution while the next is sampled. When a revolution is shorter than the work, it skips
    /// whole revolutions: --skip chooses a speed at which that happens.
    Grind(grind::GrindArgs),
    /// Measure a head's rotary axes with a ball under RTCP, identify their errors, correct them, and show what is left.
    ///
    /// C turns a full circle, A a quarter, with three set-ups of the ball each. Linear axes are taken for perfect.
    Rtcp(rtcp::RtcpArgs),
    /// Record what the step is given in every cycle of a run, for the bare-metal image.
    ///
    /// Positions are rounded to 1e-6 mm. A machine file with [roundness] adds a workpiece that turns at three probes.
    Record(record::RecordArgs),
    /// Run the same recording on this host and in the bare-metal image under QEMU, and hold one against the other.
    ///
    /// Needs qemu-system-arm and, unless built images are given, the Rust target thumbv7em-none-eabihf. In the same scalar
    /// both must agree in every bit; single and double precision within 2 nm.
    Compare(compare_command::CompareArgs),
}

#[derive(Args)]
struct ScenarioArgs {
    /// Machine: a machine.toml, its folder, or the name of a sample (mill-3axis, mill-5axis, mill-turn).
    #[arg(long, value_name = "M", default_value = "mill-3axis")]
    machine: PathBuf,
    #[command(flatten)]
    program: ProgramArgs,
    /// Error model that the step corrects by [default: the machine file's].
    #[arg(long, value_name = "MODEL", value_enum)]
    model: Option<Model>,
    /// Whether the tool's direction is corrected too, through the rotary axes; only with the volumetric model [default: the
    /// machine file's].
    #[arg(long, value_name = "on|off", value_enum, num_args = 0..=1, require_equals = true, default_missing_value = "on")]
    orientation: Option<Switch>,
    /// Servo rate.
    #[arg(long, value_name = "HZ", default_value_t = 10_000.0)]
    rate_hz: f64,
    /// Machine coordinates of the place that the program's controller calls zero: program zero where nothing shifts it
    /// [default: 0,0,0 with --offsets, else the middle of the declared travels].
    #[arg(long, value_name = "X,Y,Z", value_delimiter = ',', allow_hyphen_values = true)]
    origin_mm: Option<Vec<f64>>,
    /// Seed of the encoders' noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Time a step may take [default: a tenth of the period].
    #[arg(long, value_name = "NS")]
    budget_ns: Option<u64>,
    /// Temperature of the machine, °C [default: the tables' reference temperature].
    #[arg(long, value_name = "C", allow_hyphen_values = true)]
    temperature_c: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Model {
    /// Nine one-dimensional tables; angular errors have no lever.
    Nine,
    /// All errors of every axis, carried to the tool tip.
    Volumetric,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Switch {
    On,
    Off,
}

#[derive(Args)]
struct RunArgs {
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
    /// Write index.html and trace.csv into this folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// The trace keeps every Nth cycle.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..))]
    trace_every: u64,
}

#[derive(Args)]
struct BenchArgs {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// Steps to time.
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    cycles: u64,
    /// Print one JSON document and nothing else.
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        None => {
            let Cli { command: Some(Command::Run(args)) } =
                Cli::parse_from(["firmware-sim", "run", "--report", "report"])
            else {
                return ExitCode::FAILURE;
            };
            run(&args)
        }
        Some(Command::Run(args)) => run(&args),
        Some(Command::Bench(args)) => time(&args),
        Some(Command::Grind(args)) => grind::grind(&args),
        Some(Command::Rtcp(args)) => rtcp::rtcp(&args),
        Some(Command::Record(args)) => record::record(&args),
        Some(Command::Compare(args)) => match compare_command::compare(&args) {
            Ok(false) => return ExitCode::FAILURE,
            other => other.map(|_| ()),
        },
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if error.is::<Closed>() => ExitCode::SUCCESS,
        Err(error) => {
            tell(format_args!("error: {}", printable(&format!("{error:#}"))));
            ExitCode::from(2)
        }
    }
}

fn prepare(args: &ScenarioArgs, faults: &[String]) -> Result<Scenario> {
    if !(100.0..=100_000.0).contains(&args.rate_hz) {
        bail!("--rate-hz: found {}, needed 100 to 100000", args.rate_hz);
    }
    let mut machine = read_machine("--machine", &args.machine)?;
    choose_model(&mut machine, args)?;
    let program = args.program.read()?;
    program.check_axes(&machine.settings, &args.program.file)?;
    program.check_duration(args.rate_hz, MotionSettings::default().rapid_mm_per_min, &args.program.file)?;
    let origin_mm = match args.origin_mm.as_deref() {
        None if args.program.offsets.is_some() => [0.0; 3],
        None => middle_of_travel(&machine),
        Some(&[x, y, z]) if [x, y, z].iter().all(|c| c.is_finite()) => [x, y, z],
        Some(other) => bail!("--origin-mm: found {other:?}, needed three finite numbers X,Y,Z"),
    };
    let kelvin = args.temperature_c.map_or(0.0, |t| t - machine.settings.reference_temperature_c);
    let faults = FaultScript::parse(faults).map_err(|e| anyhow!("--fault: {e}"))?;
    let placement = Placement::new(&machine, origin_mm)?;
    let scenario = Scenario {
        five_axis: program.is_five_axis(),
        placement,
        machine,
        program,
        origin_mm,
        rate_hz: args.rate_hz,
        seed: args.seed,
        faults,
        kelvin,
        budget_ns: args.budget_ns.unwrap_or((1e8 / args.rate_hz) as u64),
    };
    stays_in_travel(&scenario)?;
    Ok(scenario)
}

/// What the options say in place of the machine file's `[compensation]`.
fn choose_model(machine: &mut Machine, args: &ScenarioArgs) -> Result<()> {
    let settings = &mut machine.settings.compensation;
    match args.model {
        Some(Model::Nine) => (settings.model, settings.orientation) = (ErrorModel::Nine, false),
        Some(Model::Volumetric) => settings.model = ErrorModel::Volumetric,
        None => {}
    }
    if let Some(switch) = args.orientation {
        settings.orientation = switch == Switch::On;
    }
    if settings.orientation && settings.model == ErrorModel::Nine {
        bail!("--orientation: found on with the nine-term model, needed --model volumetric");
    }
    Ok(())
}

/// A machine.toml, its folder, or a sample's name.
fn read_machine(option: &str, given: &Path) -> Result<Machine> {
    let path = if given.exists() { given.to_path_buf() } else { sample_machine(&given.to_string_lossy()) };
    if !path.exists() {
        bail!(
            "{option}: found no file or sample \"{}\", needed a machine.toml, its folder, or mill-3axis, mill-5axis, mill-turn, head-5axis or grinder",
            given.display()
        );
    }
    Ok(Machine::read(&path)?)
}

/// What a command may not write over: the files of machines, named as for [`read_machine`], and others.
fn outputs_of<'p>(machines: impl IntoIterator<Item = &'p Path>, others: impl IntoIterator<Item = &'p Path>) -> Outputs {
    let files = machines.into_iter().flat_map(|given| {
        let path = if given.exists() { given.to_path_buf() } else { sample_machine(&given.to_string_lossy()) };
        Machine::files(&path).unwrap_or_else(|_| vec![path])
    });
    Outputs::of(files.chain(others.into_iter().map(Path::to_path_buf)))
}

/// A bar of thousandths on the standard error.
fn progress_bar(message: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}");
    let bar = ProgressBar::new(1000).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_message(message);
    bar
}

/// Motion of a scenario's program, which is found to be a path.
fn plan(scenario: &Scenario) -> Result<Motion<'_>> {
    let settings = MotionSettings { period_s: scenario.period_s(), ..MotionSettings::default() };
    let motion = Motion::plan_on(&scenario.program, settings, &scenario.placement)
        .map_err(|e| anyhow!("{}: {e}", scenario.program.name))?;
    firmware_sim::path::check(scenario)?;
    Ok(motion)
}

/// A program that leaves the declared travel would only run into the plugin's stop request.
fn stays_in_travel(scenario: &Scenario) -> Result<()> {
    for step in &scenario.program.moves {
        let (first, last) = step.curve.domain();
        for i in 0..=64 {
            let point = scenario.placement.axes(step, first + (last - first) * f64::from(i) / 64.0);
            let counted = scenario.machine.settings.axes.iter().filter(|a| scenario.five_axis || !a.axis.is_rotary());
            for settings in counted {
                let (q, [low, high]) = (point[settings.axis.index()], settings.travel);
                if q < low || q > high {
                    let (unit, hint) =
                        if settings.axis.is_rotary() { ("°", "") } else { (" mm", " (see --origin-mm)") };
                    bail!(
                        "{}, line {}: axis {} goes to {q:.3}{unit}, needed within its travel {low} to {high}{unit}{hint}",
                        scenario.program.name,
                        step.line,
                        settings.axis.letter()
                    );
                }
            }
        }
    }
    Ok(())
}

/// Calls a function that is generic over the number of axes.
macro_rules! with_axes {
    ($machine:expr, $module:ident, $function:ident, ($($argument:expr),*)) => {
        match axis_count($machine) {
            3 => $module::$function::<3>($($argument),*),
            4 => $module::$function::<4>($($argument),*),
            5 => $module::$function::<5>($($argument),*),
            _ => $module::$function::<6>($($argument),*),
        }
    };
}

fn run(args: &RunArgs) -> Result<()> {
    let mut outputs = outputs_of([args.scenario.machine.as_path()], args.scenario.program.files());
    if let Some(dir) = &args.report {
        outputs.refuse_input(&dir.join("index.html"))?;
        outputs.refuse_input(&dir.join("trace.csv"))?;
    }
    let scenario = prepare(&args.scenario, &args.fault)?;
    let motion = plan(&scenario)?;
    let mut files = match &args.report {
        Some(dir) => {
            outputs.folder(dir)?;
            Some(ReportFiles::create(dir, &scenario, args.trace_every)?)
        }
        None => None,
    };
    let bar = progress_bar("simulating");
    let mut tell = |fraction: f64| bar.set_position((1000.0 * fraction) as u64);
    let mut sinks: Vec<&mut dyn Sink> = Vec::new();
    if let Some(files) = &mut files {
        sinks.extend([&mut files.trace as &mut dyn Sink, &mut files.series]);
    }
    let outcome =
        with_axes!(&scenario.machine, outcome, simulate, (&scenario, &motion, args.paced, &mut sinks, &mut tell))?;
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

/// What `run --report` writes.
struct ReportFiles {
    directory: PathBuf,
    trace: Trace<BufWriter<Staged>>,
    series: Series,
}

impl ReportFiles {
    fn create(directory: &Path, scenario: &Scenario, trace_every: u64) -> Result<ReportFiles> {
        let compensated = outcome::KINDS.iter().position(|kind| *kind == Kind::Compensated).unwrap_or(0);
        let path = Self::trace_path(directory);
        let trace = Staged::create(&path)
            .and_then(|file| Trace::new(BufWriter::new(file), trace_every, compensated, &scenario.machine.settings))
            .with_context(|| format!("cannot write {}", path.display()))?;
        Ok(ReportFiles { directory: directory.into(), trace, series: Series::new(scenario) })
    }

    fn trace_path(directory: &Path) -> PathBuf {
        directory.join("trace.csv")
    }

    /// Writes what is left to write; the files.
    fn finish(self, outcome: &Outcome, scenario: &Scenario) -> Result<[PathBuf; 2]> {
        let trace = Self::trace_path(&self.directory);
        let cannot_write = || format!("cannot write {}", trace.display());
        let staged = self.trace.finish().with_context(cannot_write)?;
        let page = report::write(&outcome.report(scenario, &self.series), &self.directory)
            .with_context(|| format!("cannot write into {}", self.directory.display()))?;
        // After the page: dropped where that is refused.
        let staged = staged.into_inner().map_err(|error| error.into_error());
        staged.and_then(Staged::commit).with_context(cannot_write)?;
        Ok([page, trace])
    }
}

fn time(args: &BenchArgs) -> Result<()> {
    if args.cycles == 0 {
        bail!("--cycles: found 0, needed at least 1");
    }
    let scenario = prepare(&args.scenario, &[])?;
    let motion = plan(&scenario)?;
    let outcome = with_axes!(&scenario.machine, bench, run, (&scenario, &motion, args.cycles))?;
    let l = outcome.latency;
    if args.json {
        let document = json!({
            "cycles": args.cycles,
            "latency_ns": { "min": l.min_ns, "p50": l.p50_ns, "p99": l.p99_ns, "p99_99": l.p99_99_ns, "max": l.max_ns },
            "budget_ns": l.budget_ns,
            "missed_deadlines": l.missed_deadlines,
            "steps_per_s": outcome.steps_per_s,
        });
        return put(&format!("{}\n", serde_json::to_string_pretty(&document)?));
    }
    put(&format!(
        "{} of {} on {}, wall time on this host\n  \
         min {} ns, median {} ns, 99 % {} ns, 99.99 % {} ns, max {} ns (the clock's reading included)\n  \
         {:.2} million steps a second on one core, without a clock between them\n",
        counted(args.cycles as usize, "step"),
        scenario.program.name,
        scenario.machine.settings.name,
        l.min_ns,
        l.p50_ns,
        l.p99_ns,
        l.p99_99_ns,
        l.max_ns,
        outcome.steps_per_s * 1e-6
    ))
}

/// The reader of the standard output has seen enough (`firmware-sim … | head`): no error.
#[derive(Debug)]
struct Closed;

impl std::fmt::Display for Closed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the standard output is closed")
    }
}

impl std::error::Error for Closed {}

/// Writes to the standard output; a full disk or a closed pipe is an error, not a panic.
fn put(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|error| match error.kind() {
        std::io::ErrorKind::BrokenPipe => Closed.into(),
        _ => anyhow::Error::new(error).context("cannot write to the standard output"),
    })
}

/// Says something on the standard error. Nobody listening there is no error, and nothing could be said about it.
fn tell(line: impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}
