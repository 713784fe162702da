//! `firmware-sim`: servo cycles on the host, with the machine simulated.

// print! and similar macros panic if the other end of a pipe is closed; the functions of `console` do not.
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod ball_test_text;
mod bench_command;
mod calibrate;
mod compare_command;
mod console;
mod friction;
mod given;
mod grind;
mod keep;
mod learn;
mod machine_arg;
mod program_args;
mod record;
mod replay;
mod rtcp;
mod run;
mod scenario_args;
mod scenario_command;
mod settings_args;
mod soak_command;
mod thermal;
mod thermal_text;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use console::{Closed, report_line};
use std::process::ExitCode;
use trueaxis_tables::text::printable;

/// Runs a part program through the compensated servo step against a simulated machine, and shows the gain on the
/// part and the cost of each cycle.
#[derive(Parser)]
#[command(version, args_conflicts_with_subcommands = true, before_help = EXAMPLE, after_help = HELP)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

const EXAMPLE: &str = "\
Example:
  firmware-sim run --program short-tour --report out";

const HELP: &str = "\
Without a command the default scenario is run, with the report in ./report.
Exit code 0: done; 2: bad input; 1: only `soak` and `compare`, the runs differ.
A reader that closes the standard output or error early (`| head`) ends the program silently with exit code 0.";

/// Layout of a help text: description, example, options. In clap's own, no example can precede the options.
const LAYOUT: &str = "{about-with-newline}\n{before-help}{usage-heading} {usage}\n\n{all-args}{after-help}";

/// Sets [`LAYOUT`] for a command and everything below it; clap does not pass it on.
fn laid_out(command: clap::Command) -> clap::Command {
    command.mut_subcommands(laid_out).help_template(LAYOUT)
}

/// [`Parser::parse`] with [`LAYOUT`].
fn parsed() -> Cli {
    let mut command = laid_out(Cli::command());
    let matches = command.get_matches_mut();
    Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.format(&mut command).exit())
}

#[derive(Subcommand)]
enum Command {
    /// Simulate a program three or four times: uncorrected, corrected, the servo alone, and everything on.
    Run(run::RunArgs),
    /// Print the settings of a simulation as a scenario file, which --scenario reads back.
    Scenario(scenario_command::PrintArgs),
    /// Time the step alone, without the simulated machine.
    Bench(bench_command::BenchArgs),
    /// Repeat a program for a simulated day in several runs side by side, and compare the runs: however busy the host is, all
    /// have the same bits.
    Soak(soak_command::SoakArgs),
    /// Grind a crankpin twice: without and with the infeed correction of the three-probe gauge.
    Grind(grind::GrindArgs),
    /// Make a program several times, each part with the correction learned from those before.
    Learn(learn::LearnArgs),
    /// Measure a head's rotary axes with a ball under RTCP, identify their errors, correct them, and show the residual.
    Rtcp(rtcp::RtcpArgs),
    /// Record circles, find the friction of X and Y in them, configure its feed-forward, record again, and show the spikes
    /// at reversals before and after.
    Friction(friction::FrictionArgs),
    /// Warm a machine over shifts, find its thermal growth in the record, and run a shift of another kind with the task and
    /// the step in the loop.
    Thermal(thermal::ThermalArgs),
    /// Calibrate random machines with a touch probe, a ring and a ball, and show their remaining errors.
    Calibrate(calibrate::CalibrateArgs),
    /// Let a machine drift over a shift, re-probe balls every so many parts as `trueaxis keep` does, update its tables and
    /// exchange them in motion, and show the tip's error with and without the updates.
    Keep(keep::KeepArgs),
    /// Record the step's inputs in every cycle of a run, for the bare-metal image.
    Record(record::RecordArgs),
    /// Run a recording through the step on this host, and write its inputs and outputs, cycle by cycle.
    Replay(replay::ReplayArgs),
    /// Run the same recording on this host and in the bare-metal image under QEMU, and compare the two.
    Compare(compare_command::CompareArgs),
}

/// The compared runs differ; the differences have already been reported.
#[derive(Debug)]
struct Disagreement;

impl std::fmt::Display for Disagreement {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the runs differ")
    }
}

impl std::error::Error for Disagreement {}

fn agreed(agreed: bool) -> anyhow::Result<()> {
    if agreed { Ok(()) } else { Err(Disagreement.into()) }
}

fn main() -> ExitCode {
    let result = match parsed().command {
        None => {
            let Cli { command: Some(Command::Run(args)) } =
                Cli::parse_from(["firmware-sim", "run", "--report", "report"])
            else {
                return ExitCode::FAILURE;
            };
            run::run(&args)
        }
        Some(Command::Run(args)) => run::run(&args),
        Some(Command::Scenario(args)) => scenario_command::print(&args),
        Some(Command::Bench(args)) => bench_command::time(&args),
        Some(Command::Soak(args)) => soak_command::run(&args).and_then(agreed),
        Some(Command::Grind(args)) => grind::grind(&args),
        Some(Command::Learn(args)) => learn::learn(&args),
        Some(Command::Rtcp(args)) => rtcp::rtcp(&args),
        Some(Command::Friction(args)) => friction::friction(&args),
        Some(Command::Thermal(args)) => thermal::thermal(&args),
        Some(Command::Calibrate(args)) => calibrate::calibrate(&args),
        Some(Command::Keep(args)) => keep::keep(&args),
        Some(Command::Record(args)) => record::record(&args),
        Some(Command::Replay(args)) => replay::replay(&args),
        Some(Command::Compare(args)) => compare_command::compare(&args).and_then(agreed),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if error.is::<Closed>() => ExitCode::SUCCESS,
        Err(error) if error.is::<Disagreement>() => ExitCode::FAILURE,
        Err(error) => {
            report_line(format_args!("error: {}", printable(&format!("{error:#}"))));
            ExitCode::from(2)
        }
    }
}
