//! `trueaxis evaluate thermal`.

use crate::output::{json, print};
use crate::{csv_in, report};
use anyhow::Result;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use trueaxis_evaluation::thermal_test::{COLUMNS, ThermalTestDocument, check, read};
use trueaxis_tables::output::Outputs;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis evaluate thermal records/spindle.csv --distance-mm 100";

pub(crate) const HELP: &str = "\
RECORD.csv has one row a reading, with the columns:
  t_s: time
  position: of the axis that moves (--test axis), 1 for P1, 2 for P2
  x1_um,y1_um,z_um: displacements of the tool at the mandrel's tip
  x2_um,y2_um: the same at a distance L above it, towards the spindle
  ambient_c,spindle_c,machine_c: temperatures
Displacements are of the tool from the workpiece; any of the five may be missing. Position and temperatures may be \
left out.

Tests:
  --test etve: environmental temperature variation, at rest for 4 h or more
  --test spindle: distortion by the rotating spindle, warm-up and cooling
  --test axis: distortion by a moving linear axis, at every position

For X1, Y1, Z, X2, Y2 and the tilts A = −(y2 − y1)/L, B = (x2 − x1)/L (--distance-mm L) the table shows:
  range: max − min over the whole test
  first: the same in the first period (60 min in ISO 230-3)
  worst, from min: the largest within any period, and when it begins
  end: last less first reading
`trueaxis thermal fit` fits a model to such a record; this command gives the test's figures.";

#[derive(Args)]
pub(crate) struct ThermalTestArgs {
    /// Displacements and temperatures over time.
    #[arg(value_name = "RECORD.csv")]
    record: PathBuf,
    /// The test of ISO 230-3.
    #[arg(long, value_enum, default_value = "spindle")]
    test: Kind,
    /// Length of a period.
    #[arg(long, value_name = "T", default_value_t = 60.0)]
    period_min: f64,
    /// Distance of the probes at both heights.
    #[arg(long, value_name = "L")]
    distance_mm: Option<f64>,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write thermal.html with plots into a folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum Kind {
    /// Environmental temperature variation error.
    Etve,
    /// Rotating spindle.
    Spindle,
    /// Moving linear axis.
    Axis,
}

pub(crate) fn run(arguments: &ThermalTestArgs) -> Result<()> {
    check(arguments.period_min, arguments.distance_mm).map_err(|wrong| wrong.option())?;
    let name = match arguments.test {
        Kind::Etve => "etve",
        Kind::Spindle => "spindle",
        Kind::Axis => "axis",
    };
    let test = read(&mut csv_in::open(&arguments.record, &COLUMNS, "readings")?)?;
    let document = ThermalTestDocument::new(&test, name, arguments.period_min, arguments.distance_mm);
    let shown = document.shown(&test);
    if let Some(directory) = &arguments.report {
        let mut outputs = Outputs::of([&arguments.record]);
        report::stage(&mut outputs, (directory, "thermal.html"), &arguments.record, &shown, report::NO_FIGURES)?;
        outputs.commit()?;
    }
    if arguments.json { json(&document) } else { print(&shown.text()) }
}
