//! `trueaxis evaluate probing`.

use crate::output::{json, print};
use crate::{csv_in, report};
use anyhow::Result;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use trueaxis_evaluation::probing::{COLUMNS, Feature, ProbingDocument, Record, check};
use trueaxis_tables::output::Outputs;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis evaluate probing records/ring.csv --feature ring --diameter-mm 50";

pub(crate) const HELP: &str = "\
RECORD.csv has the columns x_mm,y_mm[,z_mm][,run][,spindle_deg], one row a point: the position of the centre of the \
stylus tip when the machine's probe triggered, the number of the run (a measurement of the whole feature), and the \
spindle's orientation (constant in a run). z_mm is needed for a sphere or a point.

Every run gives:
  --feature ring: P_FTU,2D, range of the distances from the fitted centre
  --feature sphere: P_FTU,3D, the same for a sphere
  --feature point: range and standard deviation of one point
The fitted centre is that of the least-squares circle or sphere. ISO 230-10 takes 36 points on a ring, 25 over half a \
sphere and 10 touches of a point; check its edition for their number and places.

Runs together give the repeatability of the location, the range of the centres. Spindle orientations give the offset \
e of the tip from the spindle's axis, centre(θ) = c + R(θ) e. The calibrated diameter D of the artefact gives the \
effective diameter of the tip: D − d in a ring, d − D on a sphere (d: diameter through the tip's centres).";

#[derive(Args)]
pub(crate) struct ProbingArgs {
    /// Points measured by the machine's probe.
    #[arg(value_name = "RECORD.csv")]
    record: PathBuf,
    /// The probed feature.
    #[arg(long, value_enum)]
    feature: Of,
    /// Calibrated diameter of the ring or sphere.
    #[arg(long, value_name = "D")]
    diameter_mm: Option<f64>,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write probing.html with a plot into a folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum Of {
    /// A ring.
    Ring,
    /// A sphere.
    Sphere,
    /// A point of a surface.
    Point,
}

impl Of {
    pub(super) fn feature(self) -> Feature {
        match self {
            Of::Ring => Feature::Ring,
            Of::Sphere => Feature::Sphere,
            Of::Point => Feature::Point,
        }
    }
}

pub(crate) fn run(arguments: &ProbingArgs) -> Result<()> {
    check(arguments.diameter_mm).map_err(|wrong| wrong.option())?;
    let feature = arguments.feature.feature();
    let record =
        Record::read(&mut csv_in::open(&arguments.record, &COLUMNS, "points")?, feature, arguments.diameter_mm)?;
    let document = ProbingDocument::new(&record);
    let shown = document.shown(&record);
    if let Some(directory) = &arguments.report {
        let mut outputs = Outputs::of([&arguments.record]);
        report::stage(&mut outputs, (directory, "probing.html"), &arguments.record, &shown, report::NO_FIGURES)?;
        outputs.commit()?;
    }
    if arguments.json { json(&document) } else { print(&shown.text()) }
}
