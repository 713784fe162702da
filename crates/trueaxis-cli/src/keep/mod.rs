//! `trueaxis keep`.

mod apply;
mod history;
mod plan;
mod reprobing;
mod simulate;
mod table;
mod undo;

use crate::simulate::{Disturbances, Truth};
use anyhow::Result;
use clap::{Args, Subcommand};
use std::path::PathBuf;
use trueaxis_evaluation::keep::time;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis keep plan records/probing/keep.toml -o look.ngc";

const SIMULATE: &str = "\
Example:
  trueaxis keep simulate records/probing/keep.toml \\
      --machine records/probing/warm -o look.log";

const SIMULATED: &str = "\
A rehearsal of a shift, on a copy of the machine's folder:

  trueaxis keep simulate keep.toml --machine mill -o begin.log
  trueaxis keep begin keep.toml begin.log
  # The machine as it has moved since:
  trueaxis keep simulate keep.toml --machine warm --seed 2 -o look.log
  trueaxis keep check keep.toml look.log

TRUE is a machine of the same chain, whose tables, location errors and backlash are the true errors; the tables of the \
task's machine correct it, as they do when the control runs the program. Without --machine the true errors are drawn \
about those of the task's machine, within the standard uncertainties that its files state.

The balls stay where they are as long as --set-up stays the same, up to 0.6 mm beside their stated places; their \
diameters are drawn from it within their uncertainty. The tip trips within tip_uncertainty_um of pre_travel_um.";

const BEGIN: &str = "\
Example:
  cp -r records/probing trial
  trueaxis keep begin trial/keep.toml trial/begin.log";

const CHECK: &str = "\
Example:
  cp -r records/probing trial
  trueaxis keep begin trial/keep.toml trial/begin.log
  trueaxis keep check trial/keep.toml trial/look.log";

const APPLY: &str = "\
Example:
  cp -r records/probing trial
  trueaxis keep begin trial/keep.toml trial/begin.log
  trueaxis keep apply trial/keep.toml trial/look.log";

const UNDO: &str = "\
Example:
  cp -r records/probing trial
  trueaxis keep begin trial/keep.toml trial/begin.log
  trueaxis keep apply trial/keep.toml trial/look.log
  trueaxis keep undo trial/keep.toml";

const HISTORY: &str = "\
Example:
  cp -r records/probing trial
  trueaxis keep begin trial/keep.toml trial/begin.log
  trueaxis keep apply trial/keep.toml trial/look.log
  trueaxis keep history trial/keep.toml";

pub(crate) const HELP: &str = "\
KEEP.toml names the machine, the probe, balls that stay in place, and the terms that may change, with their bounds:

  machine = \"mill\"                  # its folder; its tables are in force
  dialect = \"linuxcnc\"              # or grblhal, klipper
  every_parts = 10                  # parts between two re-probings
  # Optional; in the machine's folder, recompiled after each change:
  tcomp = \"mill.tcomp\"
  [probe]
  tip_radius_mm = 3.0
  tip_uncertainty_um = 2.0
  [[artefact]]                      # a ball; more balls determine more
  name = \"ball\"
  kind = \"ball\"
  diameter_mm = 25.0
  uncertainty_um = 0.3
  [[artefact.place]]
  at_mm = [440.0, 340.0, -250.0]
  # With rotary axes:
  rotary_deg = [[0, 0, 0], [0, 0, 90], [0, 0, 180], [0, 0, 270]]
  [[term]]
  # Or C0Y, offset X, scale X, backlash X; with thermal = \"thermal.toml\" at the
  # top growth X, expansion X:
  names = [\"EX0C\", \"EY0C\"]
  largest_update_um = 10.0          # more at once needs a person
  largest_total_um = 40.0           # and so does more since the beginning
  significance = 3.0                # standard errors by which a term has moved

One round, by a script of the control after every so many parts:

  # Once; run it between parts, compensation on:
  trueaxis keep plan keep.toml -o look.ngc
  # The first log, with which all later ones are compared:
  trueaxis keep begin keep.toml trueaxis-1a2b3c4d.log
  # Show the changes and why, then apply them; undo reverts them:
  trueaxis keep check keep.toml trueaxis-1a2b3c4d.log
  trueaxis keep apply keep.toml trueaxis-1a2b3c4d.log

Exit code 0: done, or nothing to do; 3: a term is out of its bounds, nothing is written and a person has to decide; \
2: bad input.
The history is in keep/history.jsonl in the machine's folder, replaced files are in keep/NUMBER. The guide is \
docs/calibration.md.";

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Write the probing program, which runs without a pause, and print the expected uncertainty of every term.
    #[command(before_help = EXAMPLE)]
    Plan(PlanArgs),
    /// Write the log that the program would give on a machine of stated errors, noise and drift.
    #[command(before_help = SIMULATE, after_help = SIMULATED)]
    Simulate(SimulateArgs),
    /// Evaluate the first probing, with which all later ones are compared; the machine is not changed.
    #[command(before_help = BEGIN)]
    Begin(ReprobingArgs),
    /// Show what this log would change, without writing anything except the report.
    #[command(before_help = CHECK)]
    Check(CheckArgs),
    /// Apply the changes if every one is within its bounds, and record them in the history.
    #[command(before_help = APPLY)]
    Apply(CheckArgs),
    /// Restore the machine's files as they were before an entry of the history.
    #[command(before_help = UNDO)]
    Undo(UndoArgs),
    /// Print the history.
    #[command(before_help = HISTORY)]
    History(HistoryArgs),
}

#[derive(Args)]
pub(crate) struct PlanArgs {
    /// Machine, probe, balls and bounds.
    #[arg(value_name = "KEEP.toml")]
    task: PathBuf,
    /// The program [default: standard output].
    #[arg(short, long, value_name = "look.ngc")]
    output: Option<PathBuf>,
    /// Print one JSON document with the expected standard error of every term.
    #[arg(long, requires = "output")]
    json: bool,
}

#[derive(Args)]
pub(crate) struct SimulateArgs {
    /// Machine, probe, balls and bounds.
    #[arg(value_name = "KEEP.toml")]
    task: PathBuf,
    #[command(flatten)]
    truth: Truth,
    #[command(flatten)]
    disturbances: Disturbances,
    /// Number of the set-up, from which the balls' true diameters and places are drawn, and how the tip trips.
    #[arg(long, value_name = "N", default_value_t = 1)]
    set_up: u64,
    /// The log, in the format of the task's control [default: standard output].
    #[arg(short, long, value_name = "LOG")]
    output: Option<PathBuf>,
}

#[derive(Args)]
pub(crate) struct ReprobingArgs {
    /// Machine, probe, balls and bounds.
    #[arg(value_name = "KEEP.toml")]
    task: PathBuf,
    /// Log of the control, or a CSV: id, x_mm, y_mm, z_mm, tripped, and a_deg, b_deg, c_deg of rotary axes.
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// Time of the probing, UTC: 2026-05-04T06:00:00Z.
    #[arg(long, value_parser = time)]
    time: Option<String>,
    /// Parts made until then, as the control counts them.
    #[arg(long, value_name = "COUNT")]
    parts: Option<u64>,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write keep.html with the history's curves into a folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

#[derive(Args)]
pub(crate) struct CheckArgs {
    #[command(flatten)]
    reprobing: ReprobingArgs,
    /// Accept a term that is out of its bounds, by its name.
    #[arg(long, value_name = "TERM")]
    accept: Vec<String>,
    /// Accept tables that are not as the history left them.
    #[arg(long)]
    by_hand: bool,
}

#[derive(Args)]
pub(crate) struct UndoArgs {
    /// Machine, probe, balls and bounds.
    #[arg(value_name = "KEEP.toml")]
    task: PathBuf,
    /// First entry to undo, with all entries after it [default: the last update in effect].
    #[arg(value_name = "ENTRY")]
    entry: Option<u32>,
    /// Time of the undo, UTC: 2026-05-04T06:00:00Z.
    #[arg(long, value_parser = time)]
    time: Option<String>,
    /// Replace the tables even if they are not as the history left them.
    #[arg(long)]
    by_hand: bool,
}

#[derive(Args)]
pub(crate) struct HistoryArgs {
    /// Machine, probe, balls and bounds.
    #[arg(value_name = "KEEP.toml")]
    task: PathBuf,
    /// Print all entries as one JSON document.
    #[arg(long)]
    json: bool,
    /// Write keep.html with its curves into a folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

pub(crate) fn run(command: &Command) -> Result<()> {
    match command {
        Command::Plan(arguments) => plan::run(arguments),
        Command::Simulate(arguments) => simulate::run(arguments),
        Command::Begin(arguments) => reprobing::begin(arguments),
        Command::Check(arguments) => reprobing::check(arguments),
        Command::Apply(arguments) => apply::run(arguments),
        Command::Undo(arguments) => undo::run(arguments),
        Command::History(arguments) => history::run(arguments),
    }
}
