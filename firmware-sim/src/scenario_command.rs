//! `firmware-sim scenario`: prints the settings of a simulation.

use crate::console::put;
use crate::settings_args::{ActArgs, SettingsArgs};
use anyhow::Result;
use clap::Args;

const EXAMPLE: &str = "\
Example:
  firmware-sim scenario --noise-um 0.02 > noisy.toml
  firmware-sim run --scenario noisy.toml";

const HELP: &str = "\
Prints every setting, with its default unless an option changes it.

More examples:
  firmware-sim scenario > mine.toml
  firmware-sim scenario --set drive.reset_time_s=0.01 > mine.toml";

/// Arguments of `scenario`.
#[derive(Args)]
#[command(before_help = EXAMPLE, after_help = HELP)]
pub(crate) struct PrintArgs {
    #[command(flatten)]
    settings: SettingsArgs,
    #[command(flatten)]
    acts: ActArgs,
}

pub(crate) fn print(args: &PrintArgs) -> Result<()> {
    let settings = args.settings.settings(&args.acts)?;
    put(&format!(
        "# Settings of a simulation: firmware-sim run --scenario FILE. Keys left out keep their defaults.\n\
         # For rotary axes read degrees for every mm.\n{}",
        settings.to_toml()
    ))
}
