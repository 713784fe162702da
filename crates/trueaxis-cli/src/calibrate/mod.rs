//! `trueaxis calibrate`.

mod plan;
mod simulate;
mod solve;

use crate::machine_folder::Writing;
use crate::model;
use crate::simulate::{Disturbances, Truth};
use anyhow::Result;
use clap::{Args, Subcommand};
use std::path::{Path, PathBuf};
use trueaxis_evaluation::calibrate::Task;
use trueaxis_tables::Machine;
use trueaxis_tables::files::Folder;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis calibrate plan records/probing/task.toml -o probe.ngc
  trueaxis calibrate plan records/probing/dial.toml -o sheet.csv
  trueaxis calibrate plan records/probing/plate.toml -o plate.ngc
  cp -r records/probing trial
  trueaxis calibrate plan trial/hour.toml --minutes 60 \\
      --placed trial/placed.toml -o trial/hour.ngc";

const SIMULATE: &str = "\
Example:
  trueaxis calibrate simulate records/probing/task.toml \\
      --machine records/probing/true -o probe.log";

const SIMULATED: &str = "\
A rehearsal: plan, simulate and solve a task at the desk, and see how well it finds errors that you state, before the \
machine is touched:

  trueaxis calibrate plan task.toml -o probe.ngc
  trueaxis calibrate simulate task.toml --machine true -o probe.log
  trueaxis calibrate solve task.toml probe.log -o found

TRUE is a machine of the same chain, whose tables, location errors and backlash are the true errors; with `compensated \
= true` the tables of the task's machine correct it. Without --machine the true errors are drawn about those of the \
task's machine: location errors, scales, backlash and points of tables, each with the standard uncertainty that the \
machine's files state. --save-true writes that machine, to compare it with the machine found.

Ring, ball and the other artefacts get true sizes within their uncertainty, and are up to 0.6 mm and about 0.5 mrad \
off their places; the tip trips pre_travel_um after the touch, within tip_uncertainty_um if that is stated. Every \
pause lasts five minutes. What a task leaves unknown is drawn: lengths by 20 um, form by 5 um, angles by 50 urad, a \
bar's run-out by 5 um and 30 urad; places on a plate by 30 um, its diameters by 10 um, and the plate is put down within \
0.25 degrees.";

const SOLVE: &str = "\
Example:
  trueaxis calibrate solve records/probing/task.toml \\
      records/probing/probe.log -o calibrated";

pub(crate) const HELP: &str = "\
TASK.toml names the machine's folder, the control, the probe, and artefacts with the places they are set up at:

  machine = \"mill\"                  # its folder: chain and travels
  dialect = \"linuxcnc\"              # or grblhal, klipper
  [probe]
  tip_radius_mm = 3.0
  [[artefact]]
  name = \"ring\"
  kind = \"ring\"                     # ball, ball plate, step gauge, square,
                                    # gauge block, block
  diameter_mm = 150.002
  uncertainty_um = 0.5
  [[artefact.place]]
  at_mm = [120.0, 90.0, -200.0]     # of the machine, the tip in its middle, at the depth of the touches
  normal = \"Z\"                      # its orientation
  [reference]
  artefact = \"ball\"                 # touched again and again against drift

A ring determines scales and squareness of its plane, a ball the tip's radius. A square needs its angle or a second \
place turned over (reversed = true). A ball at several rotary_deg determines centre lines and tilts of rotary axes.

A gauge block (length_mm) gives the scale along its length; a thin one, touched from both sides, gives lost motion. \
Parallels that nobody has measured (unknown_length, same_as) carry its length to the other axes. A block (size_mm) has \
three lengths; a second place, turned over, shows squareness: mark the corner that the program names.

A plate whose balls or holes nobody has measured gives squareness, scales, positioning and straightness of two axes, \
if one distance on it is known:

  [[plate]]
  name = \"plate\"
  kind = \"holes\"                    # or balls
  diameter_mm = 20.0
  columns = 5
  rows = 5
  pitch_mm = 70.0
  at_mm = [215.0, 165.0, -200.0]    # of its middle, at the depth of touches
  [plate.length]                    # of the centres of two of them
  from = [1, 1]                     # column and row
  to = [5, 5]
  mm = 395.98
  uncertainty_um = 2.0
  [[plate.placement]]               # its first position
  turn_deg = 0
  [[plate.placement]]
  turn_deg = 90
  [[plate.placement]]
  moved = [1, 0]                    # pitches, along X and Y
  [[plate.placement]]
  moved = [0, 1]

Readings of a dial indicator, in place of touches:

  machine = \"mill\"
  [indicator]
  repeatability_um = 1.0
  [[dial]]
  name = \"cylinder\"
  kind = \"squareness\"               # straightness, tram, test bar
  along = \"X\"                       # axis along the table under it
  across = \"Z\"
  at_mm = [150.0, 200.0, -280.0]    # of the machine at the first reading
  arms_mm = [200.0, 200.0]

`plan` then writes a sheet with a row for every reading, and `solve` takes it filled in. Faces, squares and bars are \
read a second time turned by 180 degrees, in which their own errors cancel; a face is turned over about its length: \
each end stays where it is.
With --minutes, artefacts without [[artefact.place]] get the places that reduce the error of the tip over the volume \
most in that time; stated places are kept, and the reference needs one. Roll, pitch and yaw are among the terms with \
angular_degree:

  [solve]
  angular_degree = 3
  [plan]
  styli_mm = [100.0, 200.0]         # lengths of the styli that there are
  free_mm = [[0.0, 500.0], [0.0, 400.0], [-300.0, 0.0]]
  set_up_minutes = 3.0
  tools_mm = [120.0]                # of the tools that it works with

All keys: docs/calibration.md";

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Write the probing program of a task; refuse a task whose places cannot separate the terms.
    #[command(before_help = EXAMPLE)]
    Plan(PlanArgs),
    /// Write the log that the program would give on a machine of stated errors, noise and drift.
    #[command(before_help = SIMULATE, after_help = SIMULATED)]
    Simulate(SimulateArgs),
    /// Turn the log of the program into errors of the machine, and write the machine with them.
    #[command(before_help = SOLVE)]
    Solve(SolveArgs),
}

#[derive(Args)]
pub(crate) struct PlanArgs {
    /// Machine, probe, artefacts and places.
    #[arg(value_name = "TASK.toml")]
    task: PathBuf,
    /// The program, or the sheet for a dial's readings [default: standard output].
    #[arg(short, long, value_name = "probe.ngc")]
    output: Option<PathBuf>,
    /// Choose places for the artefacts that have none: those that reduce the error over the volume most in this time, minutes
    /// with setting up.
    #[arg(long, value_name = "N", requires = "placed", help_heading = "Choosing places")]
    minutes: Option<f64>,
    /// The task with the chosen places, for `simulate` and `solve`; in the folder of TASK.toml.
    #[arg(long, value_name = "PLACED.toml", requires = "minutes", help_heading = "Choosing places")]
    placed: Option<PathBuf>,
    /// Print one JSON document with the expected standard error of every term, or with the chosen places.
    #[arg(long, requires = "output")]
    json: bool,
}

#[derive(Args)]
pub(crate) struct SimulateArgs {
    /// Machine, probe, artefacts and places.
    #[arg(value_name = "TASK.toml")]
    task: PathBuf,
    #[command(flatten)]
    truth: Truth,
    #[command(flatten)]
    disturbances: Disturbances,
    /// Number of the set-up, from which the artefacts' true sizes and places and the tip are drawn [default: the seed].
    #[arg(long, value_name = "N")]
    set_up: Option<u64>,
    /// The log, in the format of the task's control [default: standard output].
    #[arg(short, long, value_name = "LOG")]
    output: Option<PathBuf>,
}

#[derive(Args)]
pub(crate) struct SolveArgs {
    /// The task that the program was planned from.
    #[arg(value_name = "TASK.toml")]
    task: PathBuf,
    /// Log of the control, a dial's filled sheet, or a CSV: id, x_mm, y_mm, z_mm, tripped, and a_deg, b_deg, c_deg.
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
        Command::Simulate(arguments) => simulate::run(arguments),
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
    of_task(Task::read(&model::text(path)?, path)?, path)
}

fn of_task(task: Task, path: &Path) -> Result<Read> {
    let at = path.parent().unwrap_or(Path::new("")).join(&task.machine);
    let (folder, name) = Folder::of_machine(&at);
    let machine =
        Machine::read_from(&folder, &name, &mut |how| crate::output::report_line(format_args!("note: {how}")))?;
    Ok(Read { task, path: at, machine })
}
