//! `trueaxis correct`: error and correction at one position.

mod arguments;
mod table;

use crate::model::{self, by_axes};
use crate::output::{json, print, report_line};
use anyhow::Result;
use arguments::Asked;
pub(crate) use arguments::{CorrectArgs, position};
use trueaxis::machine::Axis;
use trueaxis_evaluation::correct::{self, CorrectionAt};
use trueaxis_tables::Warning;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis correct compensation-tables/mill-3axis --at 120,-40,-200";

pub(crate) const HELP: &str = "\
Evaluates the machine's own error model at one position, as the servo step does. Without --at the position is the \
middle of the declared travel of every axis, else the middle of its table, else zero.

The table shows:
  error of the tip: actual − ideal at the uncorrected command
  of X, of Y …: the share of each axis
  correction: added to the command so that the tip reaches the position
  command: position + correction
All are in machine coordinates; corrections of rotary axes are in degrees.

Two-sided tables and backlash depend on the direction of travel. Beyond the end of a table its edge value is used, \
and a note says so. Another note says if the step's magnitude limit would reduce the correction.

--json prints machine, model, at_mm, error_um, correction_mm, command_mm (each [x, y, z]), contributions [{source, \
error_um}], clamped, out_of_travel and clipped (letters of axes). With rotary axes it adds at_deg, correction_deg \
and command_deg (by letter), and with the volumetric model error_urad, the rotation of the tool about [x, y, z], \
actual − ideal.";

pub(crate) fn run(arguments: &CorrectArgs) -> Result<()> {
    let machine = model::machine(&arguments.machine)?;
    if !machine.states_errors() {
        report_line(format_args!("note: {}", Warning::NoErrorsStated));
    }
    let asked = Asked::new(arguments, &machine)?;
    let found: CorrectionAt = by_axes!(machine.settings.step_axes().count(), correct::at(&machine, &asked.query))?;
    for (letters, what) in [
        (&found.clamped, "beyond the end of the table: its edge value is used"),
        (&found.out_of_travel, "outside the declared travel"),
    ] {
        if !letters.is_empty() {
            report_line(format_args!("note: {} {what}", axes(letters)));
        }
    }
    for note in found.clipped.notes(&machine.settings, "position") {
        report_line(format_args!("note: {note}"));
    }
    if arguments.json {
        json(&table::document(&machine, &found))
    } else {
        print(&table::text(&machine, &asked, &found))
    }
}

/// `axis X`, `axes X, Y`.
fn axes(axes: &[Axis]) -> String {
    let letters: Vec<String> = axes.iter().map(|axis| axis.letter().to_string()).collect();
    format!("{} {}", if letters.len() == 1 { "axis" } else { "axes" }, letters.join(", "))
}
