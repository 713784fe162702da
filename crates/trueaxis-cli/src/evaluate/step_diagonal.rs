//! `trueaxis evaluate step-diagonal`.

use crate::machine_folder::{self, Writing};
use crate::output::print;
use crate::{csv_in, report};
use anyhow::Result;
use clap::Args;
use std::fmt::Write;
use std::path::PathBuf;
use trueaxis_evaluation::diagonal::{COLUMNS, DiagonalDocument, Value, additions, check, read};
use trueaxis_report::number::significant;
use trueaxis_tables::output::Outputs;
use trueaxis_tables::text::degrees_of_freedom;

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
        let source = arguments.record.file_name().unwrap_or_default().to_string_lossy();
        let page = report::evaluate::page(&source, &document.shown(&test));
        report::write(&mut outputs, &page, directory, "step-diagonal.html")?;
    }
    outputs.commit()?;
    done.print_notes();
    if arguments.json { done.json(&document) } else { print(&table(&document)?) }
}

fn value(of: Value, unit: &str) -> String {
    format!("{} ± {} {unit}", significant(of.value, 4), significant(of.standard_error, 2))
}

fn table(d: &DiagonalDocument) -> Result<String> {
    let um = |value: Option<f64>| value.map_or_else(|| "–".into(), |um| significant(um, 4));
    let mut text = format!("{} test, {} readings; ISO 230-6\n\n", d.test, d.readings);
    writeln!(
        text,
        "{:<10}{:>10}{:>9}{:>10}{:>10}{:>10}{:>10}",
        "diagonal", "mm", "targets", "E um", "B um", "M um", "R um"
    )?;
    for of in &d.diagonals {
        let [e, b, m, r] = [Some(of.e_um), of.b_um, Some(of.m_um), of.r_um].map(um);
        let length = significant(of.length_mm, 5);
        writeln!(text, "{:<10}{length:>10}{:>9}{e:>10}{b:>10}{m:>10}{r:>10}", of.diagonal, of.targets)?;
    }
    let [e, b, m, r] = [Some(d.e_d_um), d.b_d_um, Some(d.m_d_um), d.r_d_um].map(um);
    writeln!(text, "{:<10}{:>19}{e:>10}{b:>10}{m:>10}{r:>10}\n", "largest", "")?;
    for (name, of) in [("A0Z", d.a0z), ("B0Z", d.b0z), ("C0Y", d.c0y)] {
        writeln!(text, "squareness {name}      {}", value(of, "µrad"))?;
    }
    writeln!(text, "diagonal scale      {}", value(d.scale, "ppm"))?;
    writeln!(text, "rank {} of 4, condition number {}", d.rank, significant(d.condition, 3))?;
    if let Some(steps) = &d.steps {
        text.push('\n');
        for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
            let if_aligned = significant(steps.scales_if_aligned_ppm[axis], 4);
            let known = steps.scales_ppm.map_or_else(|| "not known".into(), |scales| value(scales[axis], "ppm"));
            writeln!(text, "scale {name}: {known}; {if_aligned} ppm if the mirror is exactly square")?;
        }
        let (sigma, freedom) = (significant(steps.sigma_um, 3), degrees_of_freedom(steps.degrees_of_freedom));
        writeln!(text, "sigma of a step {sigma} µm, {freedom}")?;
        for shape in &steps.shapes {
            let axis = shape.axis;
            writeln!(
                text,
                "\n{:>10}{:>12}{:>12}{:>12}",
                format!("{axis}_mm"),
                format!("EX{axis}_um"),
                format!("EY{axis}_um"),
                format!("EZ{axis}_um")
            )?;
            for point in &shape.points {
                let [x, y, z] = point.error_um;
                writeln!(text, "{:>10.3}{x:>12.3}{y:>12.3}{z:>12.3}", point.position_mm)?;
            }
        }
    }
    for limit in &d.limits {
        writeln!(text, "note: {limit}")?;
    }
    Ok(text)
}
