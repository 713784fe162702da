//! `trueaxis circle`.

use crate::csv_in;
use crate::output::{json, print};
use crate::report;
use anyhow::Result;
use clap::Args;
use std::fmt::Write;
use std::path::PathBuf;
use trueaxis_evaluation::circle::{COLUMNS, CircleDocument, Evaluation};
use trueaxis_report::number::significant;
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
    if let Some(directory) = &arguments.report {
        let source = arguments.points.file_name().unwrap_or_default().to_string_lossy();
        let mut outputs = Outputs::of([&arguments.points]);
        report::write(&mut outputs, &report::circle::page(&source, &found), directory, "circle.html")?;
        outputs.commit()?;
    }
    let document = found.document();
    if arguments.json { json(&document) } else { print(&table(&document, &found)?) }
}

fn table(document: &CircleDocument, found: &Evaluation) -> Result<String> {
    let mut text = format!("{} points", document.points);
    if let Some(plane) = &document.plane {
        let [x, y, z] = plane.normal.map(|at| format!("{:.6}", at + 0.0));
        let flat = significant(plane.flatness_um, 4);
        write!(text, " in the plane fitted to them: normal {x} {y} {z}, flat within {flat} µm")?;
    }
    let centre: String =
        found.section.letters().iter().map(|letter| format!(" {:>20}", format!("centre {letter}, mm"))).collect();
    writeln!(text, "; ISO 12181-1\n\n{:<5}{centre} {:>20} {:>18}  lines", "", "radius, mm", "zone, µm")?;
    let circles = [("LSC", &document.lsc), ("MZC", &document.mzc), ("MIC", &document.mic), ("MCC", &document.mcc)];
    for (name, circle) in circles {
        match circle {
            Some(circle) => {
                let lines = circle.contacts.iter().filter_map(|&i| found.lines.get(i)).map(u32::to_string);
                let centre: String = circle.centre_mm.iter().map(|mm| format!(" {mm:>20.12}")).collect();
                writeln!(
                    text,
                    "{name:<5}{centre} {:>20.12} {:>18.9}  {}",
                    circle.radius_mm,
                    circle.zone_um,
                    lines.collect::<Vec<_>>().join(" ")
                )?;
            }
            None => {
                let reason = document.refused.get(name.to_lowercase().as_str()).map_or("", String::as_str);
                writeln!(text, "{name:<5}none: {reason}")?;
            }
        }
    }
    if let Some(ring) = &document.mzc {
        writeln!(text, "\nMZC: inner radius {:.12} mm, outer radius {:.12} mm", ring.inner_mm, ring.outer_mm)?;
    }
    Ok(text)
}
