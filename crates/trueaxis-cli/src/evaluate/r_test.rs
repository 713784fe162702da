//! `trueaxis evaluate r-test`.

use crate::machine_folder::{self, Writing};
use crate::numbers::triple;
use crate::output::print;
use crate::{csv_in, model, report};
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;
use trueaxis_evaluation::r_test::{COLUMNS, Options, RTestDocument, Record, check, identify};
use trueaxis_tables::output::Outputs;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis evaluate r-test records/r-test.csv --machine records/trunnion";

pub(crate) const HELP: &str = "\
RECORD.csv has the columns x_mm,y_mm,z_mm[,a_deg,b_deg,c_deg],dx_um,dy_um,dz_um[,ball], one row a pose (ISO 10791-6, \
tests BK): the commanded position under RTCP, and how far the tool has moved from the ball on the table, actual − \
commanded, in machine directions. `ball` numbers the balls, if there are several.

One least-squares fit finds the two offsets and two tilts across every rotary axis that turns, together with the \
offset of each ball from its commanded place:
  A: EY0A EZ0A EB0A EC0A
  B: EX0B EZ0B EA0B EC0B
  C: EX0C EY0C EA0C EB0C
The effect of the machine's tables and its other errors on the ball is removed first. Poses that cannot separate \
some of the errors are refused, and these are named: turn the axis that carries them, or keep some as they are with \
--without (in a head the first axis' offsets are the ball's own place).

With --free-sensor the zero of the nest in the tool's frame is an unknown too, for a nest that was not calibrated to \
the spindle.

-o writes the errors found into the machine: its own folder, or another one with a copy of it. Values that agree \
with stated ones become their weighted mean. A record that does not fit the machine writes nothing.";

#[derive(Args)]
pub(crate) struct RTestArgs {
    /// Displacements at angles of the rotary axes.
    #[arg(value_name = "RECORD.csv")]
    record: PathBuf,
    /// The machine that was measured.
    #[arg(long, value_name = "M")]
    machine: PathBuf,
    /// Centre of the nest (or ball in the spindle) from the last tool-side frame [default: the machine's tool_mm].
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    tool_mm: Option<[f64; 3]>,
    /// Location errors that keep the machine's values.
    #[arg(long, value_name = "EX0C,…", value_delimiter = ',')]
    without: Vec<String>,
    /// Also fit the zero of the nest.
    #[arg(long)]
    free_sensor: bool,
    /// Folder to write the machine into: its own, or a new one.
    #[arg(short, long, value_name = "MACHINE_DIR", help_heading = "Writing into a machine")]
    output: Option<PathBuf>,
    #[command(flatten)]
    writing: Writing,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write r-test.html with plots into a folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

pub(crate) fn run(arguments: &RTestArgs) -> Result<()> {
    let into = arguments.writing.output(arguments.output.as_deref());
    let _alone = into.map(machine_folder::alone).transpose()?;
    check(arguments.tool_mm).map_err(|wrong| wrong.option())?;
    let record = Record::read(&mut csv_in::open(&arguments.record, &COLUMNS, "readings")?)?;
    let mut machine = model::machine(&arguments.machine)?;
    machine.settings.tool_mm = arguments.tool_mm.unwrap_or(machine.settings.tool_mm);
    let options = Options { without: arguments.without.clone(), free_sensor: arguments.free_sensor };
    let found = identify(&record, &arguments.record.display().to_string(), &machine, &options)?;
    let document = RTestDocument::new(&record, &found, &machine);
    let shown = document.shown(&record, &found);
    let mut outputs =
        Outputs::of(machine_folder::inputs(&arguments.machine, into).into_iter().chain([arguments.record.clone()]));
    let mut done = machine_folder::Done::default();
    if arguments.writing.decides(into)? {
        let additions = (arguments.writing, found.additions());
        done = machine_folder::decide(&mut outputs, &arguments.machine, into, &arguments.record, additions)?;
    }
    if arguments.writing.dry_run {
        return done.dry_run(&document, arguments.json);
    }
    if let Some(directory) = &arguments.report {
        report::stage(&mut outputs, (directory, "r-test.html"), &arguments.record, &shown, report::NO_FIGURES)?;
    }
    outputs.commit()?;
    done.print_notes();
    if arguments.json { done.json(&document) } else { print(&shown.text()) }
}
