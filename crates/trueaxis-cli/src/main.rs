//! `trueaxis`, the bench commands: error tables, corrections, contour error, roundness.

// print! and similar macros panic when the reader closes a pipe: see `output`.
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod ballbar;
mod calibrate;
mod circle;
mod compensate;
mod contour;
mod correct;
mod csv_in;
mod desk;
mod evaluate;
mod explain;
mod friction;
mod helicoid;
mod identify;
mod keep;
mod kinematics;
mod learn;
mod machine_folder;
mod model;
mod numbers;
mod output;
mod periodic;
mod predict;
mod predict_servo;
mod probe_angles;
mod probes;
mod report;
mod roundness;
mod simulate;
mod tables;
mod telemetry;
mod thermal;
mod uncertainty;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::process::ExitCode;

/// Computes geometric error compensation and contour errors of CNC machines, from files.
#[derive(Parser)]
#[command(
    version,
    name = "trueaxis",
    args_conflicts_with_subcommands = true,
    arg_required_else_help = true,
    before_help = TO_TRY,
    after_help = HELP
)]
struct Cli {
    /// Print the licences of this program and of everything built into it.
    #[arg(long)]
    licences: bool,
    #[command(subcommand)]
    command: Option<Command>,
}

const TO_TRY: &str = "\
Five things to try in a checkout of the repository:
  trueaxis tables check compensation-tables/mill-3axis
  trueaxis correct compensation-tables/mill-3axis --at 120,-40,-200
  trueaxis tables accuracy compensation-tables/mill-3axis/x-iso230-2.csv
  trueaxis uncertainty compensation-tables/mill-3axis
  trueaxis probe-angles --n 512";

const HELP: &str = "\
An error is actual − ideal (ISO 230-1), of the tool relative to the workpiece. Lengths are in mm, positions of rotary \
axes in degrees, errors in µm and µrad.
Exit code 0: done; 2: bad input, with file, line, column, value found and value needed; 3: only `trueaxis keep`, a \
term is out of its bounds.
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

const LICENCES: &str = include_str!("../THIRD-PARTY.txt");

#[derive(Subcommand)]
enum Command {
    /// Check, compile, show and convert error tables; evaluate measurements after ISO 230-2.
    #[command(subcommand, before_help = tables::EXAMPLE)]
    Tables(tables::Command),
    /// Compute the error and the corrected command at each position.
    #[command(before_help = compensate::EXAMPLE, after_help = compensate::HELP)]
    Compensate(compensate::CompensateArgs),
    /// Show the error, its sources and the correction at one position.
    #[command(before_help = correct::EXAMPLE, after_help = correct::HELP)]
    Correct(correct::CorrectArgs),
    /// Compute the contour error of measured positions against a path.
    #[command(before_help = contour::EXAMPLE, after_help = contour::HELP)]
    Contour(contour::ContourArgs),
    /// Evaluate roundness and spindle error from the readings of three probes.
    #[command(before_help = roundness::EXAMPLE, after_help = roundness::HELP)]
    Roundness(roundness::RoundnessArgs),
    /// Find the best places of three to six probes, or the noise gain of given ones.
    #[command(before_help = probe_angles::EXAMPLE, after_help = probe_angles::HELP)]
    ProbeAngles(probe_angles::ProbeAnglesArgs),
    /// Fit the least-squares, minimum zone, maximum inscribed and minimum circumscribed circle to points.
    #[command(before_help = circle::EXAMPLE, after_help = circle::HELP)]
    Circle(circle::CircleArgs),
    /// Evaluate a circular test after ISO 230-4 and find the causes of its deviation.
    #[command(before_help = ballbar::EXAMPLE, after_help = ballbar::HELP)]
    Ballbar(ballbar::Ballbar),
    /// Evaluate records of tests with instruments, after ISO 230 and ISO 10791.
    #[command(subcommand, before_help = evaluate::EXAMPLE)]
    Evaluate(evaluate::Command),
    /// Calibrate a machine with its touch probe: write the probing program, turn its log into errors of the machine.
    #[command(subcommand, before_help = calibrate::EXAMPLE, after_help = calibrate::HELP)]
    Calibrate(calibrate::Command),
    /// Keep a machine true: re-probe balls every so many parts, update location errors and growth within bounds.
    #[command(subcommand, before_help = keep::EXAMPLE, after_help = keep::HELP)]
    Keep(keep::Command),
    /// Convert axis positions to the tool's pose and back (five-axis transformation).
    #[command(subcommand, before_help = kinematics::EXAMPLE)]
    Kinematics(kinematics::Command),
    /// Compute displacements of five axes that keep a tool normal to the flank of a helical gear, as CSV and as a program.
    #[command(before_help = helicoid::EXAMPLE, after_help = helicoid::HELP)]
    Helicoid(Box<helicoid::HelicoidArgs>),
    /// Identify the six errors of a rotary axis from a ball measured under RTCP.
    #[command(before_help = identify::EXAMPLE, after_help = identify::HELP)]
    Identify(identify::IdentifyArgs),
    /// Identify the friction of two axes, and their drives' figures, from recorded circles.
    #[command(before_help = friction::EXAMPLE, after_help = friction::HELP)]
    Friction(friction::Friction),
    /// Find errors that repeat within a pitch: of a screw, a motor, a gear or a rack.
    #[command(before_help = periodic::EXAMPLE, after_help = periodic::HELP)]
    Periodic(periodic::Periodic),
    /// Predict the features of a part before it is cut: deviations, uncertainties, verdicts on their tolerances.
    #[command(before_help = predict::EXAMPLE, after_help = predict::HELP)]
    Predict(predict::PredictArgs),
    /// Bound the contour error that the servo may leave along a program where the drives' figures are not known exactly.
    #[command(before_help = predict_servo::EXAMPLE, after_help = predict_servo::HELP)]
    PredictServo(predict_servo::PredictServoArgs),
    /// Learn a correction over path length for the next part of a program from the contour error of the last one.
    #[command(before_help = learn::EXAMPLE, after_help = learn::HELP)]
    Learn(learn::LearnArgs),
    /// Fit thermal growth to a recorded warm-up, and compile it for the controller.
    #[command(subcommand, before_help = thermal::EXAMPLE)]
    Thermal(thermal::Command),
    /// Compute the uncertainty of the corrected position from the uncertainties of the machine's figures.
    #[command(before_help = uncertainty::EXAMPLE, after_help = uncertainty::HELP)]
    Uncertainty(uncertainty::UncertaintyArgs),
    /// Convert a controller's telemetry to a table, Parquet or CSV.
    #[command(before_help = telemetry::EXAMPLE, after_help = telemetry::HELP)]
    Telemetry(telemetry::TelemetryArgs),
    /// Explain a code that a controller or the C library reports.
    #[command(before_help = explain::EXAMPLE, after_help = explain::HELP)]
    Explain(explain::ExplainArgs),
    /// Serve the desk, a page that runs the code of these commands in a browser.
    #[command(before_help = desk::EXAMPLE, after_help = desk::HELP)]
    Desk(desk::DeskArgs),
}

fn main() -> ExitCode {
    let Some(command) = parsed().command else {
        return output::exit_code(output::data(LICENCES));
    };
    let result = match command {
        Command::Tables(command) => tables::run(command),
        Command::Compensate(arguments) => compensate::run(&arguments),
        Command::Correct(arguments) => correct::run(&arguments),
        Command::Contour(arguments) => contour::run(&arguments),
        Command::Roundness(arguments) => roundness::run(&arguments),
        Command::ProbeAngles(arguments) => probe_angles::run(&arguments),
        Command::Circle(arguments) => circle::run(&arguments),
        Command::Ballbar(arguments) => ballbar::run(&arguments),
        Command::Evaluate(command) => evaluate::run(command),
        Command::Calibrate(command) => calibrate::run(&command),
        Command::Keep(command) => keep::run(&command),
        Command::Kinematics(command) => kinematics::run(command),
        Command::Helicoid(arguments) => helicoid::run(&arguments),
        Command::Identify(arguments) => identify::run(&arguments),
        Command::Friction(arguments) => friction::run(&arguments),
        Command::Periodic(arguments) => periodic::run(&arguments),
        Command::Predict(arguments) => predict::run(&arguments),
        Command::PredictServo(arguments) => predict_servo::run(&arguments),
        Command::Learn(arguments) => learn::run(&arguments),
        Command::Thermal(command) => thermal::run(command),
        Command::Uncertainty(arguments) => uncertainty::run(&arguments),
        Command::Telemetry(arguments) => telemetry::run(&arguments),
        Command::Explain(arguments) => explain::run(&arguments),
        Command::Desk(arguments) => desk::run(&arguments),
    };
    output::exit_code(result)
}
