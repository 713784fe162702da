//! `trueaxis circle`.

use crate::csv_in;
use crate::output::{json, print};
use crate::report;
use anyhow::Result;
use clap::Args;
use maud::Render;
use std::path::PathBuf;
use trueaxis_evaluation::circle::{COLUMNS, Evaluation, polar};
use trueaxis_tables::output::Outputs;

pub(crate) const EXAMPLE: &str = "\
Example:
  trueaxis circle records/points.csv";

pub(crate) const HELP: &str = "\
POINTS.csv has the columns x_mm,y_mm, one row a point: at least three that are not on one line. Two other \
coordinates (x_mm,z_mm) are a section in their plane. With all three a plane is fitted to the points first, and the \
circles lie in it.

Reference circles after ISO 12181-1, in the plane:
  LSC: least squares of the distances; radius: their mean
  MZC: narrowest ring that holds all points; radius: mean of inner and outer
  MIC: largest circle with no point inside; radius: inner
  MCC: smallest circle that holds all points; radius: outer
A zone is the largest less the smallest distance of all points from that centre. MZC, MIC and MCC are exact. The \
points that determine them are given: in the table by their line in the file, in JSON (contacts) counted from 0.

An inscribed circle needs points all round. On a part arc it is null, with the reason in \"refused\".";

#[derive(Args)]
pub(crate) struct CircleArgs {
    /// Points on a nominally round section.
    #[arg(value_name = "POINTS.csv")]
    points: PathBuf,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write circle.html with a polar plot into a folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

pub(crate) fn run(arguments: &CircleArgs) -> Result<()> {
    let mut rows = csv_in::open(&arguments.points, &COLUMNS, "points")?;
    let found = Evaluation::read(&mut rows)?;
    let shown = found.shown();
    if let Some(directory) = &arguments.report {
        let mut outputs = Outputs::of([&arguments.points]);
        let departures = polar(&found, [true; 4]).map(|figure| ("Departures", figure.render()));
        report::stage(&mut outputs, (directory, "circle.html"), &arguments.points, &shown, departures)?;
        outputs.commit()?;
    }
    if arguments.json { json(&found.document()) } else { print(&shown.text()) }
}
