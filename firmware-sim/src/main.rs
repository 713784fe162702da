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
mod grinding_text;
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

use clap::{Parser, Subcommand};
use console::{Closed, report_line};
use std::process::ExitCode;
use trueaxis_tables::text::printable;

/// Runs a part program through the compensated servo step against a simulated machine, and shows the gain on the
/// part and the cost of each cycle.
///
/// Without a command: `run` with the default scenario, and the report in ./report.
///
/// Exit code 0: done; 2: bad input. A reader that closes the standard output or error early (`| head`) ends the program
/// silently with exit code 0.
#[derive(Parser)]
#[command(version, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Simulate a program three or four times: without compensation, with compensation, with perfect geometry, and full.
    ///
    /// A machine with friction, a dynamic correction, contour feedback or cross-talk gets the fourth run, full, with every
    /// correction of the plugin. The run with compensation corrects only the geometry.
    ///
    /// The drives of the simulated machine are settings of the scenario, [drive] and [axis.X] in `firmware-sim scenario`;
    /// those that the plugin uses are in machine.toml. They need not agree: --set drive.coulomb_mm_per_s2=500 or
    /// --set axis.Y.friction_factor=1.3 simulates a machine that differs from its machine.toml.
    Run(run::RunArgs),
    /// Print the settings of a simulation as a scenario file, which --scenario reads back.
    Scenario(scenario_command::PrintArgs),
    /// Time the step alone, without the simulated machine.
    Bench(bench_command::BenchArgs),
    /// Repeat a program for a simulated day in several runs side by side, and compare the runs: however busy the host is, all
    /// have the same bits.
    Soak(soak_command::SoakArgs),
    /// Grind a crankpin twice: without and with the infeed correction of the three-probe gauge.
    ///
    /// Both runs have the same seed; the true surface is measured after every revolution.
    ///
    /// The pin circles with the crankshaft; three probes on an arm that follows it see the surface and the motion of the
    /// pin's centre. That motion is imprinted on the pin: where the centre comes toward the wheel, too much is ground off.
    /// The gauge separates surface and motion while the servo loop runs, and corrects the infeed of the next revolutions.
    /// Only the part that repeats with every turn (the synchronous imprint) can be corrected; it should fall below a tenth.
    ///
    /// The gauge works on one revolution while the next is sampled. When a revolution is shorter than the work, it skips
    /// whole revolutions: --skip chooses a speed at which that happens.
    Grind(grind::GrindArgs),
    /// Make a program several times, each part with the correction learned from those before.
    ///
    /// Between two parts, the correction over path length is learned from the contour error that the step itself estimates,
    /// or that a grid encoder measures, as `trueaxis learn` does from a record; every part has different encoder noise.
    Learn(learn::LearnArgs),
    /// Measure a head's rotary axes with a ball under RTCP, identify their errors, correct them, and show the residual.
    ///
    /// C turns a full circle, A a quarter, with three set-ups of the ball each. Linear axes are perfect.
    Rtcp(rtcp::RtcpArgs),
    /// Record circles, find the friction of X and Y in them, configure its feed-forward, record again, and show the spikes
    /// at reversals before and after.
    ///
    /// Two feeds, each in both directions, with the encoders' subdivisional error, noise and counts. Geometry is corrected
    /// in both records; of the dynamic parts only friction is on in the second.
    Friction(friction::FrictionArgs),
    /// Warm a machine over shifts, find its thermal growth in the record, and run a shift of another kind with the task and
    /// the step in the loop.
    ///
    /// Spindle, feed, coolant and the air of the hall warm bodies of two nodes each. Drift is probed at four points every five
    /// minutes. The judged shift has other speeds, longer periods and other positions.
    Thermal(thermal::ThermalArgs),
    /// Calibrate random machines with a touch probe, a ring and a ball, and show their remaining errors.
    ///
    /// Every machine gets the probing program of `trueaxis calibrate plan`; the probe with its scatter and pre-travel touches
    /// slightly misplaced artefacts, the machine drifts, and the log becomes tables. The remaining error is evaluated over
    /// the volume by exact transforms, in both directions of travel.
    Calibrate(calibrate::CalibrateArgs),
    /// Let a machine drift over a shift, re-probe balls every so many parts as `trueaxis keep` does, update its tables and
    /// exchange them in motion, and show the tip's error with and without the updates.
    ///
    /// Bodies warm as in `thermal`, location errors wander; no thermal model compensates the growth. The probing program runs
    /// on the corrected machine with scatter; errors are evaluated over the volume by exact transforms.
    Keep(keep::KeepArgs),
    /// Record the step's inputs in every cycle of a run, for the bare-metal image.
    ///
    /// Positions are rounded to 1e-6 mm. A machine file with [roundness] adds a workpiece that turns at three probes.
    Record(record::RecordArgs),
    /// Run a recording through the step on this host, and write its inputs and outputs, cycle by cycle.
    ///
    /// Compare your own controller with this file; every other host of trueaxis is compared with it (docs/hosts.md).
    Replay(replay::ReplayArgs),
    /// Run the same recording on this host and in the bare-metal image under QEMU, and compare the two.
    ///
    /// Needs qemu-system-arm and, unless you pass built images, the Rust target thumbv7em-none-eabihf. In the same
    /// scalar both must agree in every bit; single and double precision within 2 nm.
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
    let result = match Cli::parse().command {
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
