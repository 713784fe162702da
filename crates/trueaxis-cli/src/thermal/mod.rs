//! `trueaxis thermal`.

mod compile;
mod fit;
mod simulate;

use anyhow::Result;
use clap::Subcommand;

pub(crate) use fit::EXAMPLE;

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Find lags of sensors and curves of growth from a recorded warm-up after ISO 230-3.
    #[command(before_help = fit::EXAMPLE, after_help = fit::HELP)]
    Fit(fit::ThermalFitArgs),
    /// Write the record that a machine of simulated bodies would give while it warms up.
    #[command(before_help = simulate::EXAMPLE, after_help = simulate::HELP)]
    Simulate(simulate::ThermalSimulateArgs),
    /// Compile a thermal.toml into the file that the controller's task reads.
    #[command(before_help = compile::EXAMPLE, after_help = compile::HELP)]
    Compile(compile::ThermalCompileArgs),
}

pub(crate) fn run(command: Command) -> Result<()> {
    match command {
        Command::Fit(arguments) => fit::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Compile(arguments) => compile::run(&arguments),
    }
}
