//! `trueaxis thermal compile`.

use crate::model;
use crate::output::report_line;
use anyhow::{Result, anyhow};
use clap::Args;
use std::path::PathBuf;
use trueaxis::tcomp::machine_id;
use trueaxis_tables::output::Outputs;
use trueaxis_tables::text::{axes, counted, read_text};

pub(super) const EXAMPLE: &str = "\
Example:
  trueaxis thermal compile firmware-sim/cortex-m/machine/thermal.toml \\
      --machine firmware-sim/cortex-m/machine -o mill.ttherm";

pub(super) const HELP: &str = "\
The file is for one machine, by its name and structural code; reference temperature and datums must be those of its \
machine.toml. The task replaces [axis.X.thermal] of the machine: a host uses one of them.";

#[derive(Args)]
pub(crate) struct ThermalCompileArgs {
    /// Growth in the format that `trueaxis thermal fit` writes.
    #[arg(value_name = "thermal.toml")]
    thermal: PathBuf,
    /// The machine.
    #[arg(long, value_name = "M")]
    machine: PathBuf,
    /// The file for the controller.
    #[arg(short, long, value_name = "FILE.ttherm")]
    output: PathBuf,
}

pub(super) fn run(arguments: &ThermalCompileArgs) -> Result<()> {
    let machine = model::machine(&arguments.machine)?;
    let mut outputs = Outputs::of(model::files(&arguments.machine).into_iter().chain([arguments.thermal.clone()]));
    outputs.refuse_input(&arguments.output)?;
    let text = read_text(&arguments.thermal, &['#'])?;
    let model = trueaxis_evaluation::thermal::model(&text, &arguments.thermal, &machine.settings)?;
    let id = machine_id(&machine.settings.name, &machine.settings.chain);
    let bytes = model.encode(id).map_err(|error| anyhow!("{}: {error}", arguments.thermal.display()))?;
    outputs.put(&arguments.output, &bytes)?;
    outputs.commit()?;
    report_line(format_args!(
        "{}: {} bytes, machine {} (id {id:08x}), {}, {}",
        arguments.output.display(),
        bytes.len(),
        machine.settings.name,
        counted(model.sensors.len(), "sensor"),
        axes(model.axes.len())
    ));
    Ok(())
}
