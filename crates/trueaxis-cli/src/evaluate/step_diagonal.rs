//! `trueaxis evaluate step-diagonal`.

use crate::machine_folder::{self, Writing};
use crate::output::print;
use crate::{csv_in, report};
use anyhow::Result;
use clap::Args;
use std::path::PathBuf;
use trueaxis_evaluation::diagonal::{COLUMNS, DiagonalDocument, additions, check, read};
use trueaxis_tables::output::Outputs;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis evaluate step-diagonal records/step-diagonal.csv";

pub(crate) const HELP: &str = "\
RECORD.csv has the columns diagonal,run,direction,x_mm,y_mm,z_mm,deviation_um, one row a reading:
  diagonal: 1 to 4, the body diagonal
  run: number of the run (may be left out)
  direction: 1 away from the diagonal's first target, -1 back
  x_mm,y_mm,z_mm: commanded position
  deviation_um: actual less commanded displacement along the beam
Targets on the diagonals alone are a diagonal test. With targets between, reached by one axis after the other, it is \
a step-diagonal (vector) test.

ISO 230-6, for every diagonal D with the means x↑, x↓ of the runs at its targets:
  E(D) = max(x↑, x↓) − min(x↑, x↓)
  B(D) = max |x↑ − x↓|
  M(D): range of (x↑ + x↓)/2
  R(D): repeatability
  E_d, B_d, M_d, R_d: the largest of the four diagonals
The slopes of the four diagonals (u: unit vector) give three squarenesses and one scale:
  slope = u_x² s_x + u_y² s_y + u_z² s_z
          − u_x u_y C0Y + u_x u_z B0Z − u_y u_z A0Z
Steps add the shapes of the nine errors EXX … EZZ with their slopes removed. The scales of X, Y, Z depend on how \
square the flat mirror is to each diagonal, by as many ppm as it is µrad off. They are given with --alignment-urad, \
its standard uncertainty, and with the standard error that follows from it.

-o writes the squarenesses into the machine of --machine, or into another folder with a copy of it, if they differ \
from those that it states by more than two combined standard uncertainties; values that agree become their weighted \
mean.";

#[derive(Args)]
#[command(group(clap::ArgGroup::new("decided").args(["dry_run", "force"]).multiple(true).requires("machine")))]
#[command(group(clap::ArgGroup::new("into").args(["output", "dry_run"]).multiple(true)))]
pub(crate) struct StepDiagonalArgs {
    /// Readings along the four body diagonals.
    #[arg(value_name = "RECORD.csv")]
    record: PathBuf,
    /// Standard uncertainty of the mirror's (and the beam's) alignment to a diagonal.
    #[arg(long, value_name = "U")]
    alignment_urad: Option<f64>,
    /// Machine to write the squarenesses into.
    #[arg(long, value_name = "M", requires = "into", help_heading = "Writing into a machine")]
    machine: Option<PathBuf>,
    /// Folder to write the machine into: its own, or a new one.
    #[arg(short, long, value_name = "MACHINE_DIR", requires = "machine", help_heading = "Writing into a machine")]
    output: Option<PathBuf>,
    #[command(flatten)]
    writing: Writing,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write step-diagonal.html with plots into a folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

pub(crate) fn run(arguments: &StepDiagonalArgs) -> Result<()> {
    let into = arguments.writing.output(arguments.output.as_deref());
    let _alone = into.map(machine_folder::alone).transpose()?;
    check(arguments.alignment_urad).map_err(|wrong| wrong.option())?;
    let test = read(&mut csv_in::open(&arguments.record, &COLUMNS, "readings")?)?;
    let document = DiagonalDocument::new(&test, arguments.alignment_urad);
    let shown = document.shown(&test);
    let inputs = arguments
        .machine
        .iter()
        .flat_map(|machine| machine_folder::inputs(machine, into))
        .chain([arguments.record.clone()]);
    let mut outputs = Outputs::of(inputs);
    let mut done = machine_folder::Done::default();
    if let Some(machine) = &arguments.machine {
        let additions = (arguments.writing, additions(&test));
        done = machine_folder::decide(&mut outputs, machine, into, &arguments.record, additions)?;
    }
    if arguments.writing.dry_run {
        return done.dry_run(&document, arguments.json);
    }
    if let Some(directory) = &arguments.report {
        report::stage(&mut outputs, (directory, "step-diagonal.html"), &arguments.record, &shown, report::NO_FIGURES)?;
    }
    outputs.commit()?;
    done.print_notes();
    if arguments.json { done.json(&document) } else { print(&shown.text()) }
}
