//! `trueaxis circle`.

use crate::csv_in::{self, Column};
use crate::output::{json, print};
use crate::report;
use anyhow::{Result, anyhow};
use clap::Args;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;
use trueaxis_metrology::circles::{
    NoCircle, ReferenceCircle, least_squares, maximum_inscribed, minimum_circumscribed, minimum_zone,
};
use trueaxis_tables::output::Outputs;

pub(crate) const HELP: &str = "\
POINTS.csv: x_mm,y_mm, one row a point, at least three that are not on one line.
Reference circles after ISO 12181-1, in the plane:
  LSC  least squares of the distances        radius: mean distance
  MZC  narrowest ring that holds all points  radius: mean of inner and outer
  MIC  largest circle with none inside       radius: inner
  MCC  smallest circle that holds all        radius: outer
Zone: largest less smallest distance of all points from that centre.
MZC, MIC and MCC are exact; the points that determine them are given, in the table by their line
in the file, in JSON (contacts) counted from 0.
An inscribed circle needs points all round: on a part arc it is null, with the reason in \"refused\".

Example: trueaxis circle points.csv --json";

#[derive(Args)]
pub(crate) struct Arguments {
    /// Points on a nominally round section.
    #[arg(value_name = "POINTS.csv")]
    points: PathBuf,
    /// One JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write circle.html with a polar plot into a folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

const COLUMNS: [Column; 2] = [Column { name: "x_mm", needed: true }, Column { name: "y_mm", needed: true }];

#[derive(Serialize)]
struct Circle {
    centre_mm: [f64; 2],
    cx_mm: f64,
    cy_mm: f64,
    radius_mm: f64,
    diameter_mm: f64,
    inner_mm: f64,
    outer_mm: f64,
    zone_mm: f64,
    zone_um: f64,
    contacts: Vec<usize>,
}

impl From<ReferenceCircle> for Circle {
    fn from(circle: ReferenceCircle) -> Self {
        let [cx_mm, cy_mm] = circle.centre;
        Self {
            centre_mm: circle.centre,
            cx_mm,
            cy_mm,
            radius_mm: circle.radius,
            diameter_mm: 2.0 * circle.radius,
            inner_mm: circle.inner,
            outer_mm: circle.outer,
            zone_mm: circle.zone,
            zone_um: 1e3 * circle.zone,
            contacts: circle.contacts,
        }
    }
}

#[derive(Serialize)]
struct Document {
    points: usize,
    lsc: Option<Circle>,
    mzc: Option<Circle>,
    mic: Option<Circle>,
    mcc: Option<Circle>,
    /// Why a circle is null.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    refused: BTreeMap<&'static str, String>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let mut rows = csv_in::open(&arguments.points, &COLUMNS, "points")?;
    let (lines, points): (Vec<u32>, Vec<[f64; 2]>) = rows.all()?.iter().map(|row| (row.line, row.values)).unzip();
    // The circumscribed circle exists for all points that have any circle.
    let mcc = minimum_circumscribed(&points).map_err(|error| match error {
        NoCircle::Straight => {
            anyhow!(
                "{}: found {} points on one straight line, needed three that are not",
                rows.file.display(),
                points.len()
            )
        }
        error => anyhow!("{}: {error}", rows.file.display()),
    })?;
    let [lsc, mzc, mic] = [least_squares(&points), minimum_zone(&points), maximum_inscribed(&points)];
    if let Some(directory) = &arguments.report {
        let source = arguments.points.file_name().unwrap_or_default().to_string_lossy();
        let circles = [lsc.as_ref(), mzc.as_ref(), Ok(&mcc), mic.as_ref()];
        let mut outputs = Outputs::of([&arguments.points]);
        report::write(&mut outputs, &report::circle::page(&source, &points, circles), directory, "circle.html")?;
        outputs.commit()?;
    }
    let mut refused = BTreeMap::new();
    let mut or_reason = |name, circle: Result<ReferenceCircle, NoCircle>| match circle {
        Ok(circle) => Some(circle.into()),
        Err(reason) => {
            refused.insert(name, reason.to_string());
            None
        }
    };
    let lsc = or_reason("lsc", lsc);
    let mzc = or_reason("mzc", mzc);
    let mic = or_reason("mic", mic);
    let document = Document { points: points.len(), lsc, mzc, mic, mcc: Some(mcc.into()), refused };
    if arguments.json { json(&document) } else { print(&table(&document, &lines)?) }
}

fn table(document: &Document, of: &[u32]) -> Result<String> {
    let mut text = format!("{} points; ISO 12181-1\n\n", document.points);
    writeln!(
        text,
        "{:<5} {:>20} {:>20} {:>20} {:>18}  lines",
        "", "centre x, mm", "centre y, mm", "radius, mm", "zone, µm"
    )?;
    let circles = [("LSC", &document.lsc), ("MZC", &document.mzc), ("MIC", &document.mic), ("MCC", &document.mcc)];
    for (name, circle) in circles {
        match circle {
            Some(circle) => {
                let lines = circle.contacts.iter().filter_map(|&i| of.get(i)).map(u32::to_string);
                writeln!(
                    text,
                    "{name:<5} {:>20.12} {:>20.12} {:>20.12} {:>18.9}  {}",
                    circle.cx_mm,
                    circle.cy_mm,
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
