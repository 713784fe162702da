//! `trueaxis evaluate points`.

use crate::output::{json, print};
use crate::{csv_in, machine_folder, model, report};
use anyhow::{Result, anyhow, bail};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};
use trueaxis_evaluation::points::{
    COLUMNS, Options, PlaneDocument, Points, PointsDocument, identify, identify_plane, nodes,
};
use trueaxis_evaluation::shown::Shown;
use trueaxis_tables::output::Outputs;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis evaluate points records/tracer.csv \\
      --machine compensation-tables/mill-3axis";

pub(crate) const HELP: &str = "\
POINTS.csv has one row a point, with the columns:
  x_mm,y_mm,z_mm: the commanded position
  actual_x_mm,actual_y_mm,actual_z_mm: the measured coordinates
  u_um: their standard uncertainty
  tool_x_mm,tool_y_mm,tool_z_mm: reflector from the last tool-side frame
u_um and tool_x_mm,tool_y_mm,tool_z_mm may be left out. The coordinates are those of a tracker, a tracer or several of them: the instrument \
is on the workpiece's side, its coordinates are in the machine's directions and within 2 mm of the command. The \
offset of the reflector is needed if it differs from the machine's tool_mm. Rotary axes are at zero, and points are \
approached in positive travel.

One least-squares fit finds the 21 errors of X, Y, Z over nodes (the levels of the points, up to 41; else 11) \
together with the place of the instrument. A constant of an error and the slope of a straightness cannot be \
separated from that place: every error is zero at machine zero (or the nearest end), straightnesses have no slope, \
squareness is separate.
A rotation that these points see only as a translation of its own axis is left at zero and named: a second reflector \
offset shows it. Points that leave more than that open are refused, and the errors that they cannot separate are \
named; --without omits an angular error.
Second differences of the tables are held at zero with a thousandth of a reading's weight, which binds nodes without \
points and moves no other. One point in ten is excluded from a first fit; the error that it leaves at those points \
is the figure to trust.

Points in a plane, or along lines of it (a plate on a coordinate measuring machine, a scale under a camera, a printed \
grid), show the errors of the two axes in that plane. The models compared are the placement of the plate alone; affine \
(two scales and squareness); affine with four tables, one for each axis and direction; maps: polynomials of degree 2 to \
8. Each predicts every tenth of the points from the others (parts drawn at random by a fixed seed). Chosen is the model \
with the fewest unknowns whose mean squared error at held-out points exceeds the smallest by no more than one standard \
error of the difference. Everything else that the machine states is subtracted first and stays. A map is written as a \
grid and holds the value of the nearest edge beyond the points. If no model predicts better than the placement alone, \
nothing is written.
One line along an axis gives its scale or table of positioning, and the straightness across it without a slope. A plane \
inclined to the axes gives the scales and squarenesses that it determines; the sums of the others are named.
--against OTHER.csv applies the errors to a second record (another plate, another day), aligned rigidly with and without \
them. They transfer if they reduce its squared residuals, summed over 16 areas, more than 95 % of all changes of the \
areas' signs would (permutation test, level 0.05). If they do not, nothing is written.

-o writes the machine of --machine with these tables and squarenesses, model volumetric, into a separate folder. The \
following command then gives back the measured errors without the instrument's placement:
  trueaxis compensate MACHINE_DIR positions.csv --model volumetric";

#[derive(Args)]
pub(crate) struct PointsArgs {
    /// Measured points.
    #[arg(value_name = "POINTS.csv")]
    points: PathBuf,
    /// Machine that states chain, offsets, tool and `measured_at_mm`.
    /// Points in a plane may do without one.
    #[arg(long, value_name = "M")]
    machine: Option<PathBuf>,
    /// Points in a plane or on a line: another record, of a second plate or another day. The errors are written only if they help it.
    #[arg(long, value_name = "OTHER.csv")]
    against: Option<PathBuf>,
    /// Folder to write the machine with the errors into.
    #[arg(short, long, value_name = "MACHINE_DIR", help_heading = "Writing into a machine")]
    output: Option<PathBuf>,
    /// Nodes of the tables of X, Y, Z, evenly spaced [default: the levels of the points, else 11].
    #[arg(long, value_name = "NX,NY,NZ", value_delimiter = ',')]
    nodes: Option<Vec<usize>>,
    /// Angular errors to leave at zero.
    #[arg(long, value_name = "EBX,…", value_delimiter = ',')]
    without: Vec<String>,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write points.html with plots into a folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

pub(crate) fn run(arguments: &PointsArgs) -> Result<()> {
    let _alone = arguments.output.as_deref().map(machine_folder::alone).transpose()?;
    let nodes = arguments.nodes.as_deref().map(nodes).transpose().map_err(|wrong| anyhow!("--nodes: {wrong}"))?;
    let options = Options { nodes, without: arguments.without.clone() };
    let points = read(&arguments.points)?;
    if points.are_flat() {
        return plane(arguments, &points, &options);
    }
    if arguments.against.is_some() {
        bail!("--against: found points along X, Y and Z, needed points in a plane or on a line");
    }
    let Some(machine) = &arguments.machine else {
        bail!("--machine: found none, needed one for points along X, Y and Z");
    };
    let found = identify(&points, &model::machine(machine)?, &options)
        .map_err(|error| error.context(arguments.points.display().to_string()))?;
    let document = PointsDocument::new(&points, &found);
    let (shown, files) = (document.shown(&points, &found), document.files(&found, &source(arguments)));
    put_out(arguments, &document, &shown, Some(files))
}

fn read(file: &Path) -> Result<Points> {
    Points::read(&mut csv_in::open(file, &COLUMNS, "points")?)
}

/// Name of the record in the files of the machine.
fn source(arguments: &PointsArgs) -> String {
    arguments.points.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Points in a plane or along lines of it.
fn plane(arguments: &PointsArgs, points: &Points, options: &Options) -> Result<()> {
    if arguments.output.is_some() && arguments.machine.is_none() {
        bail!("--output: found no --machine, needed the machine to add the errors to");
    }
    let machine = arguments.machine.as_deref().map(model::machine).transpose()?;
    let other = arguments.against.as_deref().map(|file| Ok::<_, anyhow::Error>((read(file)?, file))).transpose()?;
    let name = other.as_ref().map(|(_, file)| file.display().to_string()).unwrap_or_default();
    let against = other.as_ref().map(|(points, _)| (points, name.as_str()));
    let found = identify_plane(points, machine.as_ref(), options, against)
        .map_err(|error| error.context(arguments.points.display().to_string()))?;
    let document = PlaneDocument::new(&found, points.stated);
    let files = document.files(&found, &source(arguments));
    put_out(arguments, &document, &document.shown(&found), files)
}

/// Writes the machine, if there is one to write, and the report, and prints the document.
fn put_out(
    arguments: &PointsArgs,
    document: &impl Serialize,
    shown: &Shown,
    files: Option<Vec<(String, String)>>,
) -> Result<()> {
    let machine = arguments.machine.iter().flat_map(|machine| model::files(machine));
    let inputs = machine.chain([arguments.points.clone()]).chain(arguments.against.clone());
    let mut outputs = Outputs::of(inputs);
    let mut written = Vec::new();
    if let (Some(output), Some(files)) = (&arguments.output, files) {
        written = machine_folder::whole(&mut outputs, output, &files)?;
    }
    if let Some(directory) = &arguments.report {
        report::stage(&mut outputs, (directory, "points.html"), &arguments.points, shown, report::NO_FIGURES)?;
    }
    outputs.commit()?;
    machine_folder::print_notes(&written);
    if arguments.json { json(document) } else { print(&shown.text()) }
}
