//! `trueaxis calibrate`.

mod plan;
mod solve;

use crate::machine_folder::Writing;
use crate::model;
use anyhow::Result;
use clap::{Args, Subcommand};
use std::path::{Path, PathBuf};
use trueaxis_evaluation::calibrate::Task;
use trueaxis_tables::Machine;
use trueaxis_tables::files::Folder;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis calibrate plan records/probing/task.toml -o probe.ngc";

const SOLVE: &str = "\
Example:
  trueaxis calibrate solve records/probing/task.toml \\
      records/probing/probe.log -o calibrated";

pub(crate) const HELP: &str = "\
TASK.toml names the machine's folder, the control, the probe, and artefacts of known size with the places they are \
set up at:

  machine = \"mill\"                  # its folder: chain and travels
  dialect = \"linuxcnc\"              # or grblhal, klipper
  [probe]
  tip_radius_mm = 3.0
  [[artefact]]
  name = \"ring\"
  kind = \"ring\"                     # ring, ball, ball plate, step gauge, square
  diameter_mm = 150.002
  uncertainty_um = 0.5
  [[artefact.place]]
  at_mm = [120.0, 90.0, -200.0]     # of the machine, the tip in its middle
  normal = \"Z\"                      # its orientation
  [reference]
  artefact = \"ball\"                 # touched again and again against drift

A ring determines scales and squareness of its plane, a ball the tip's radius. A square needs its angle or a second \
place turned over (reversed = true). A ball at several rotary_deg determines centre lines and tilts of rotary axes.
All keys: docs/calibration.md";

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Write the probing program of a task; refuse a task whose places cannot separate the terms.
    #[command(before_help = EXAMPLE)]
    Plan(PlanArgs),
    /// Turn the log of the program into errors of the machine, and write the machine with them.
    #[command(before_help = SOLVE)]
    Solve(SolveArgs),
}

#[derive(Args)]
pub(crate) struct PlanArgs {
    /// Machine, probe, artefacts and places.
    #[arg(value_name = "TASK.toml")]
    task: PathBuf,
    /// The program [default: standard output].
    #[arg(short, long, value_name = "probe.ngc")]
    output: Option<PathBuf>,
    /// Print one JSON document with the expected standard error of every term.
    #[arg(long, requires = "output")]
    json: bool,
}

#[derive(Args)]
pub(crate) struct SolveArgs {
    /// The task that the program was planned from.
    #[arg(value_name = "TASK.toml")]
    task: PathBuf,
    /// Log of the control, or a CSV: id, x_mm, y_mm, z_mm, tripped, and a_deg, b_deg, c_deg of rotary axes.
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// Folder to write the machine with the errors found into: the task's own, or one without a machine.toml.
    #[arg(
        short,
        long,
        value_name = "MACHINE_DIR",
        required_unless_present = "dry_run",
        help_heading = "Writing into a machine"
    )]
    output: Option<PathBuf>,
    #[command(flatten)]
    writing: Writing,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write calibrate.html with residuals and curves into a folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

pub(crate) fn run(command: &Command) -> Result<()> {
    match command {
        Command::Plan(arguments) => plan::run(arguments),
        Command::Solve(arguments) => solve::run(arguments),
    }
}

/// A task with its machine.
struct Read {
    task: Task,
    /// Path of the machine, relative to the current folder.
    path: PathBuf,
    machine: Machine,
}

fn read(path: &Path) -> Result<Read> {
    let task = Task::read(&model::text(path)?, path)?;
    let at = path.parent().unwrap_or(Path::new("")).join(&task.machine);
    let (folder, name) = Folder::of_machine(&at);
    let machine =
        Machine::read_from(&folder, &name, &mut |how| crate::output::report_line(format_args!("note: {how}")))?;
    Ok(Read { task, path: at, machine })
}
