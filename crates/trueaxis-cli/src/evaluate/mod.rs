//! `trueaxis evaluate`: records of tests with instruments.

mod points;
mod probing;
mod r_test;
mod step_diagonal;
mod thermal;

use anyhow::Result;

#[derive(clap::Subcommand)]
pub(crate) enum Command {
    /// The 21 errors of X, Y, Z from coordinates that a tracker or tracer measured: a machine that compensates them.
    #[command(after_help = points::HELP)]
    Points(points::Arguments),
    /// Probing tests of the machine's own probe after ISO 230-10: form error, repeatability, tip offset and diameter.
    #[command(after_help = probing::HELP)]
    Probing(probing::Arguments),
    /// R-test after ISO 10791-6: location errors of the rotary axes from a ball on the table.
    #[command(after_help = r_test::HELP)]
    RTest(r_test::Arguments),
    /// Diagonal and step-diagonal displacement tests after ISO 230-6: figures, squareness, scale, and what steps tell.
    #[command(after_help = step_diagonal::HELP)]
    StepDiagonal(step_diagonal::Arguments),
    /// Thermal tests after ISO 230-3: drift over stated periods, by probe and tilt.
    #[command(after_help = thermal::HELP)]
    Thermal(thermal::Arguments),
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
