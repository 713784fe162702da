//! The simulator's report: one self-contained HTML page with the figures a machine builder asks for.
//!
//! The page needs no network and no script; every figure is SVG inside the page. [`Report`] is plain data: whoever
//! ran the simulation fills it in, [`render`] turns it into text and [`write()`] into `index.html`. Missing or
//! undefined data leave a figure out, they are never an error.
//!
//! Each section of the page is a function `fn(&Report) -> Option<Section>` in a file of its own, listed in
//! `SECTIONS`; a further one needs its data in [`Report`] and a line there.

use std::{
    io,
    path::{Path, PathBuf},
};

pub mod ball_test;
pub mod compare;
mod contour;
mod correction;
mod decimate;
mod figure;
pub mod grinding;
mod latency;
mod number;
mod orientation;
mod path;
mod summary;
mod thinner;

pub use decimate::decimate;
pub use thinner::Thinner;

use crate::latency::{LatencyBucket, LatencySummary};
pub use trueaxis_sim::run::{AngleSize, ErrorSize};
use trueaxis_tables::output::Outputs;

/// The sections below the summary, in the order of the page.
const SECTIONS: [fn(&Report) -> Option<Section>; 5] =
    [path::section, contour::section, orientation::section, correction::section, latency::section];

const STYLE: &str = include_str!("style.css");

/// Everything the page shows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Report {
    /// Heading of the page.
    pub title: String,
    /// Name of the machine.
    pub machine: String,
    /// Name of the part program.
    pub program: String,
    /// Structural code of the machine from workpiece to tool (in the manner of ISO 10791-6), e.g. `w X' b Y Z t`.
    pub chain: String,
    /// Servo rate in Hz.
    pub servo_rate_hz: f64,
    /// Servo cycles simulated.
    pub cycles: u64,
    /// Contour error of the true tool tip in the three runs.
    pub contour_error: ContourErrors,
    /// Contour error over the path.
    pub contour: ContourSeries,
    /// Tool direction over the path; empty for a program of X, Y, Z alone.
    pub orientation: OrientationSeries,
    /// The programmed path and the tip's deviations from it, in path order.
    pub path: Vec<PathPoint>,
    /// Correction and limits of each axis.
    pub axes: Vec<AxisReport>,
    /// Percentiles and deadlines of the step.
    pub latency: LatencySummary,
    /// The latency histogram.
    pub latency_buckets: Vec<LatencyBucket>,
    /// Faults that occurred, in order.
    pub faults: Vec<FaultEntry>,
    /// Remarks, e.g. which real-time means the host did not permit.
    pub notes: Vec<String>,
}

/// Contour error of the true tool tip against the programmed path, in three runs with the same servo and seed.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ContourErrors {
    /// Machine with its geometric errors, compensation off.
    pub uncompensated: ErrorSize,
    /// The same machine, compensation on.
    pub compensated: ErrorSize,
    /// A geometrically perfect machine: what the servo alone leaves behind.
    pub servo_only: ErrorSize,
}

/// Contour error over the path: `[path length in mm, error in µm]`; the sign is ignored.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ContourSeries {
    /// Machine with its geometric errors, compensation off.
    pub uncompensated: Vec<[f64; 2]>,
    /// The same machine, compensation on.
    pub compensated: Vec<[f64; 2]>,
    /// A geometrically perfect machine.
    pub servo_only: Vec<[f64; 2]>,
    /// Path lengths at which the curves are interrupted, ascending, mm: what lies between was not cutting.
    pub breaks: Vec<f64>,
    /// Where each program line begins: path length in mm and line number.
    pub program_lines: Vec<(f64, u32)>,
}

/// Tool direction over the path; first the path length in mm.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct OrientationSeries {
    /// Angle from the programmed direction, machine with its geometric errors, compensation off, µrad.
    pub uncompensated: Vec<[f64; 2]>,
    /// The same machine, compensation on.
    pub compensated: Vec<[f64; 2]>,
    /// A geometrically perfect machine.
    pub servo_only: Vec<[f64; 2]>,
    /// Rotary axes by name: commanded position in degrees.
    pub rotary: Vec<(String, Vec<[f64; 2]>)>,
}

/// A point of the programmed path and how far the true tip was from it, actual − foot point.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PathPoint {
    /// Number of the uninterrupted cut that the point belongs to.
    pub run: u32,
    /// Programmed position in mm.
    pub nominal_mm: [f64; 3],
    /// Deviation without compensation in µm.
    pub uncompensated_um: [f64; 3],
    /// Deviation with compensation in µm.
    pub compensated_um: [f64; 3],
}

/// Correction of one axis over the compensated run, with its limits.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AxisReport {
    /// Name of the axis, e.g. `X`.
    pub name: String,
    /// Whether the axis is rotary: then read µrad for µm, mrad/s for mm/s, rad/s² for m/s².
    pub rotary: bool,
    /// Correction over time: `[s, µm]`.
    pub correction: Vec<[f64; 2]>,
    /// Slope of the correction over time: `[s, mm/s]`.
    pub slope: Vec<[f64; 2]>,
    /// Limit of the correction's magnitude in µm.
    pub magnitude_limit: f64,
    /// Limit of the correction's slope in mm/s.
    pub slope_limit: f64,
    /// Limit of the correction's acceleration in m/s².
    pub acceleration_limit: f64,
}

/// A fault that the step reported.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FaultEntry {
    /// When it first occurred, in s.
    pub time_s: f64,
    /// Its code or name.
    pub code: String,
    /// What happened, in words.
    pub description: String,
    /// In how many cycles it was reported.
    pub cycles: u64,
}

/// A section of the page: heading and inner HTML, which must be well formed.
#[derive(Debug, Clone, PartialEq)]
struct Section {
    heading: &'static str,
    html: String,
}

/// The page as one HTML document, which is well-formed XML too.
#[must_use]
pub fn render(report: &Report) -> String {
    let title = if report.title.is_empty() { "Simulation report" } else { &report.title };
    let sections: Vec<Section> = SECTIONS.iter().filter_map(|section| section(report)).collect();
    page(title, &summary::html(report), &sections)
}

/// A page: heading, summary, sections.
fn page(title: &str, summary: &str, sections: &[Section]) -> String {
    let title = number::escape(title);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en-GB\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n"
    );
    page.push_str(summary);
    for section in sections {
        page.push_str(&format!("<section>\n<h2>{}</h2>\n{}</section>\n", section.heading, section.html));
    }
    page.push_str("</main>\n</body>\n</html>\n");
    page
}

/// Writes the page to `index.html` in `directory`, which is created if need be; returns the file's path.
///
/// # Errors
/// Whatever the file system answers.
pub fn write(report: &Report, directory: &Path) -> io::Result<PathBuf> {
    write_page(directory, "index.html", &render(report), Vec::new())
}

/// A page and what goes with it, all or nothing; the folder is created if need be.
fn write_page(directory: &Path, name: &str, page: &str, beside: Vec<(String, String)>) -> io::Result<PathBuf> {
    let mut outputs = Outputs::default();
    let file = directory.join(name);
    let write = |outputs: &mut Outputs| {
        outputs.folder(directory)?;
        for (name, text) in &beside {
            outputs.put(&directory.join(name), text.as_bytes())?;
        }
        outputs.put(&file, page.as_bytes())
    };
    write(&mut outputs).and_then(|()| outputs.commit()).map_err(io::Error::other)?;
    Ok(file)
}
