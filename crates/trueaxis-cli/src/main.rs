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
mod probe_angles;
mod probes;
mod report;
mod roundness;
mod tables;
mod telemetry;
mod thermal;
mod uncertainty;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Geometric error compensation and contour error of CNC machines, from files.
///
/// Lengths are mm, positions of rotary axes degrees, errors µm and µrad. Error = actual − ideal (ISO 230-1), of the tool
/// relative to the workpiece. Exit code 0: done; 2: bad input, with file, line, column, what was found and what is needed.
/// A reader that closes the standard output or error early (`| head`) ends the program silently: exit code 0.
#[derive(Parser)]
#[command(version, name = "trueaxis", args_conflicts_with_subcommands = true, arg_required_else_help = true)]
struct Cli {
    /// Print the licence of this program and those of all that is inside it.
    #[arg(long)]
    licences: bool,
    #[command(subcommand)]
    command: Option<Command>,
}

const LICENCES: &str = include_str!("../THIRD-PARTY.txt");

#[derive(Subcommand)]
enum Command {
    /// Check, compile, show and convert error tables; evaluate measurements after ISO 230-2.
    #[command(subcommand)]
    Tables(tables::Command),
    /// Errors and corrected commands at positions.
    #[command(after_help = compensate::HELP)]
    Compensate(compensate::Arguments),
    /// Error, its sources and the correction at one position.
    #[command(after_help = correct::HELP)]
    Correct(correct::Arguments),
    /// Contour error of measured positions against a path.
    #[command(after_help = contour::HELP)]
    Contour(contour::Arguments),
    /// Roundness and spindle error from three probes.
    #[command(after_help = roundness::HELP)]
    Roundness(roundness::Arguments),
    /// Angles of three probes: the best slots of a circle, and the noise gain of a given pair.
    #[command(after_help = probe_angles::HELP)]
    ProbeAngles(probe_angles::Arguments),
    /// Least-squares, minimum zone, maximum inscribed and minimum circumscribed circle of points.
    #[command(after_help = circle::HELP)]
    Circle(circle::Arguments),
    /// Circular test after ISO 230-4, and what causes its deviation.
    #[command(after_help = ballbar::HELP)]
    Ballbar(ballbar::Arguments),
    /// Records of tests with instruments, after ISO 230 and ISO 10791.
    #[command(subcommand)]
    Evaluate(evaluate::Command),
    /// From a touch probe to tables: write the probing program, turn its log into errors of the machine.
    #[command(subcommand, after_help = calibrate::HELP)]
    Calibrate(calibrate::Command),
    /// A machine that keeps itself true: re-probe a ball every so many parts, update location and growth within bounds.
    #[command(subcommand, after_help = keep::HELP)]
    Keep(keep::Command),
    /// Axis positions to tool and back: five-axis transformation.
    #[command(subcommand)]
    Kinematics(kinematics::Command),
    /// Displacements of five axes that stand a tool normal to the flank of a helical gear, as CSV and as a program.
    #[command(after_help = helicoid::HELP)]
    Helicoid(Box<helicoid::Arguments>),
    /// Six errors of a rotary axis from a ball measured under RTCP.
    #[command(after_help = identify::HELP)]
    Identify(identify::Arguments),
    /// Friction of two axes, and their drives' figures, from recorded circles.
    #[command(after_help = friction::HELP)]
    Friction(friction::Arguments),
    /// Correction over path length for the next part of a program, from the contour error of the last.
    #[command(after_help = learn::HELP)]
    Learn(learn::Arguments),
    /// Thermal growth: lags and curves from a recorded warm-up, and their file for the controller.
    #[command(subcommand)]
    Thermal(thermal::Command),
    /// Uncertainty of the corrected position, from how well the machine's figures are known.
    #[command(after_help = uncertainty::HELP)]
    Uncertainty(uncertainty::Arguments),
    /// Telemetry of a controller as a table, Parquet or CSV.
    #[command(after_help = telemetry::HELP)]
    Telemetry(telemetry::Arguments),
    /// The desk: machine, servo, helicoid, roundness and friction in a page that runs these same commands' code.
    #[command(after_help = desk::HELP)]
    Desk(desk::Arguments),
}

fn main() -> ExitCode {
    let Some(command) = Cli::parse().command else {
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
        Command::Learn(arguments) => learn::run(&arguments),
        Command::Thermal(command) => thermal::run(command),
        Command::Uncertainty(arguments) => uncertainty::run(&arguments),
        Command::Telemetry(arguments) => telemetry::run(&arguments),
        Command::Desk(arguments) => desk::run(&arguments),
    };
    output::exit_code(result)
}
