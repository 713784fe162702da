//! `trueaxis evaluate`: records of tests with instruments.

mod points;
mod probing;
mod r_test;
mod simulate;
mod step_diagonal;
mod thermal;

use crate::simulate::OrSimulate;
use anyhow::Result;

pub(crate) use probing::EXAMPLE;

#[derive(clap::Subcommand)]
pub(crate) enum Command {
    /// Find the 21 errors of X, Y, Z from coordinates measured by a tracker or tracer, and write a machine with them.
    #[command(before_help = points::EXAMPLE, after_help = points::HELP)]
    Points(OrSimulate<points::PointsArgs, simulate::PointsArgs>),
    /// Evaluate probing tests of the machine's own probe after ISO 230-10: form error, repeatability, tip offset and diameter.
    #[command(before_help = probing::EXAMPLE, after_help = probing::HELP)]
    Probing(OrSimulate<probing::ProbingArgs, simulate::ProbingArgs>),
    /// Evaluate an R-test after ISO 10791-6: location errors of the rotary axes from a ball on the table.
    #[command(before_help = r_test::EXAMPLE, after_help = r_test::HELP)]
    RTest(OrSimulate<r_test::RTestArgs, simulate::RTestArgs>),
    /// Evaluate diagonal and step-diagonal displacement tests after ISO 230-6: figures, squareness, scale, error shapes.
    #[command(before_help = step_diagonal::EXAMPLE, after_help = step_diagonal::HELP)]
    StepDiagonal(OrSimulate<step_diagonal::StepDiagonalArgs, simulate::StepDiagonalArgs>),
    /// Evaluate thermal tests after ISO 230-3: drift over stated periods, by probe and tilt.
    #[command(before_help = thermal::EXAMPLE, after_help = thermal::HELP)]
    Thermal(OrSimulate<thermal::ThermalTestArgs, simulate::ThermalArgs>),
}

pub(crate) fn run(command: Command) -> Result<()> {
    use OrSimulate::{Evaluate, Simulate};
    match command {
        Command::Points(Evaluate(arguments)) => points::run(&arguments),
        Command::Points(Simulate(arguments)) => arguments.run(),
        Command::Probing(Evaluate(arguments)) => probing::run(&arguments),
        Command::Probing(Simulate(arguments)) => arguments.run(),
        Command::RTest(Evaluate(arguments)) => r_test::run(&arguments),
        Command::RTest(Simulate(arguments)) => arguments.run(),
        Command::StepDiagonal(Evaluate(arguments)) => step_diagonal::run(&arguments),
        Command::StepDiagonal(Simulate(arguments)) => arguments.run(),
        Command::Thermal(Evaluate(arguments)) => thermal::run(&arguments),
        Command::Thermal(Simulate(arguments)) => arguments.run(),
    }
}
