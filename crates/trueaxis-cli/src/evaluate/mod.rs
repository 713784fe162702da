//! `trueaxis evaluate`: records of tests with instruments.

mod points;
mod probing;
mod r_test;
mod step_diagonal;
mod thermal;

use anyhow::Result;

pub(crate) use probing::EXAMPLE;

#[derive(clap::Subcommand)]
pub(crate) enum Command {
    /// Find the 21 errors of X, Y, Z from coordinates measured by a tracker or tracer, and write a machine with them.
    #[command(before_help = points::EXAMPLE, after_help = points::HELP)]
    Points(points::PointsArgs),
    /// Evaluate probing tests of the machine's own probe after ISO 230-10: form error, repeatability, tip offset and diameter.
    #[command(before_help = probing::EXAMPLE, after_help = probing::HELP)]
    Probing(probing::ProbingArgs),
    /// Evaluate an R-test after ISO 10791-6: location errors of the rotary axes from a ball on the table.
    #[command(before_help = r_test::EXAMPLE, after_help = r_test::HELP)]
    RTest(r_test::RTestArgs),
    /// Evaluate diagonal and step-diagonal displacement tests after ISO 230-6: figures, squareness, scale, error shapes.
    #[command(before_help = step_diagonal::EXAMPLE, after_help = step_diagonal::HELP)]
    StepDiagonal(step_diagonal::StepDiagonalArgs),
    /// Evaluate thermal tests after ISO 230-3: drift over stated periods, by probe and tilt.
    #[command(before_help = thermal::EXAMPLE, after_help = thermal::HELP)]
    Thermal(thermal::ThermalTestArgs),
}

pub(crate) fn run(command: Command) -> Result<()> {
    match command {
        Command::Points(arguments) => points::run(&arguments),
        Command::Probing(arguments) => probing::run(&arguments),
        Command::RTest(arguments) => r_test::run(&arguments),
        Command::StepDiagonal(arguments) => step_diagonal::run(&arguments),
        Command::Thermal(arguments) => thermal::run(&arguments),
    }
}
