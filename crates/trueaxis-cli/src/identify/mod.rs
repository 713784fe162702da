//! `trueaxis identify`.

use crate::machine_folder::{self, Writing};
use crate::numbers::triple;
use crate::output::print;
use crate::{csv_in, model, report};
use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use trueaxis::Axis;
use trueaxis_evaluation::identify::{self, Known, Readings};
use trueaxis_metrology::identification::Offsets;
use trueaxis_tables::formats::write_axis_csv;
use trueaxis_tables::output::Outputs;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis identify records/ball-c.csv --axis C";

pub(crate) const HELP: &str = "\
MEASURED.csv has the columns angle_deg,l_mm,h_mm,dx_um,dy_um,dz_um, one row for each set-up and angle. RTCP holds \
the centre of a ball while the axis turns; d is how far it has moved (actual − ideal, tool relative to workpiece, \
machine directions). L is how far the ball's centre lies below the intersection of the rotary axes. H is how far it \
lies beside it, along +Y for A and C, along +X for B, while the measured axis is at 0. C is at 0 while A or B is \
measured.

Axis C at angle C:
  dx = X − L β − H cos C · γ
  dy = Y + L α − H sin C · γ
  dz = Z + H cos C · α + H sin C · β
Axis A at angle A:
  dx = X + (−L cos A + H sin A) β − (H cos A + L sin A) γ
  dy = Y + (L cos A − H sin A) α
  dz = Z + (H cos A + L sin A) α
X Y Z α β γ become EXC EYC EZC EAC EBC ECC (EXA … ECA). At least three set-ups (L, H) are needed, not on one line.

--free-offsets is for gauges that were zeroed in every set-up. Then ΣX = ΣY = ΣZ = 0 over the angles, and for A the \
patterns β = −k1 cos A + k2 sin A, γ = −k1 sin A − k2 cos A, which no reading can show, are at their minimum norm.

-o c.csv writes the errors as the axis' table, to read. -o MACHINE_DIR writes the machine of --machine, in its own \
folder or another one with a copy of it; the excess over its table and its location errors is added to that table. \
The six belong together: all are written if one of them differs from its stated value by more than two combined \
standard uncertainties; if all agree, their weighted share is written; nothing is written if the readings do not \
fit.

More examples:
  trueaxis identify measured.csv --axis C --machine myhead -o myhead";

#[derive(Args)]
#[command(group(clap::ArgGroup::new("decided").args(["dry_run", "force"]).multiple(true).requires("machine")))]
pub(crate) struct IdentifyArgs {
    /// Readings of the ball.
    #[arg(value_name = "MEASURED.csv")]
    measured: PathBuf,
    /// The axis that turns.
    #[arg(long, value_enum, ignore_case = true)]
    axis: Rotary,
    /// Machine that states the sense of the axis (`direction`); the errors of its linear axes are removed.
    #[arg(long, value_name = "M")]
    machine: Option<PathBuf>,
    /// With --machine: position of X, Y, Z in the first set-up at the first angle; RTCP moves them from there.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true, requires = "machine")]
    start_mm: Option<[f64; 3]>,
    /// Also fit one offset per set-up, constant in machine directions.
    #[arg(long)]
    free_offsets: bool,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write a page with plots: a folder (identify.html) or a file that ends in .html.
    #[arg(long, value_name = "DIR|FILE")]
    report: Option<PathBuf>,
    /// A .csv file for the errors as the axis' table, or the folder to write the machine into: its own, or a new one.
    #[arg(short, long, value_name = "CSV|MACHINE_DIR", help_heading = "Writing into a machine")]
    output: Option<PathBuf>,
    #[command(flatten)]
    writing: Writing,
}

#[derive(Clone, Copy, ValueEnum)]
enum Rotary {
    #[value(name = "A")]
    A,
    #[value(name = "B")]
    B,
    #[value(name = "C")]
    C,
}

impl From<Rotary> for Axis {
    fn from(axis: Rotary) -> Axis {
        match axis {
            Rotary::A => Axis::A,
            Rotary::B => Axis::B,
            Rotary::C => Axis::C,
        }
    }
}

pub(crate) fn run(arguments: &IdentifyArgs) -> Result<()> {
    let output = arguments.writing.output(arguments.output.as_deref());
    let (file, into) = machine_folder::file_or_folder(output, "csv", arguments.machine.is_some());
    let _alone = into.map(machine_folder::alone).transpose()?;
    let axis = Axis::from(arguments.axis);
    let readings = Readings::read(&mut csv_in::open(&arguments.measured, &identify::COLUMNS, "readings")?)?;
    let machine =
        arguments.machine.as_deref().map(|file| anyhow::Ok((model::source(file)?, file.display().to_string())));
    let machine = machine.transpose()?;
    let known = machine.as_ref().map(|(machine, file)| Known {
        machine,
        file,
        start_mm: arguments.start_mm.unwrap_or_default(),
    });
    let offsets = if arguments.free_offsets { Offsets::Free } else { Offsets::Known };
    let measured = arguments.measured.display().to_string();
    let mut found = identify::identify(readings, &measured, axis, offsets, known)?;
    let inputs = arguments.machine.iter().flat_map(|machine| machine_folder::inputs(machine, into));
    let mut outputs = Outputs::of(inputs.chain([arguments.measured.clone()]));
    if let Some(file) = file {
        let table = found.table().with_context(|| measured.clone())?;
        outputs.put(file, write_axis_csv(&table, axis).as_bytes())?;
    }
    let mut done = machine_folder::Done::default();
    if arguments.writing.decides(into)?
        && let (Some(path), Some((machine, _))) = (&arguments.machine, &machine)
    {
        let additions = (arguments.writing, found.additions(machine).context(measured)?);
        done = machine_folder::decide(&mut outputs, path, into, &arguments.measured, additions)?;
    }
    if arguments.writing.dry_run {
        return done.dry_run(&found.document, arguments.json);
    }
    if let Some(to) = &arguments.report {
        let source = arguments.measured.file_name().unwrap_or_default().to_string_lossy();
        let shown = found.document.shown(axis);
        let page = shown.page(&source, [("Residuals", report::identify::residuals_of(axis, &found.document))]);
        report::write_to(&mut outputs, &page, to, "identify.html")?;
    }
    outputs.commit()?;
    done.print_notes();
    if arguments.json { done.json(&found.document) } else { print(&found.document.shown(axis).text()) }
}
