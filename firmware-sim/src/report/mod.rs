//! HTML reports of the simulator, one self-contained file each: the tables of the console, and figures.
//!
//! [`Report`] is the plain data of a run: the caller fills it in after the simulation, and [`render`] makes the page. Missing or
//! undefined data omit a figure and are never an error.
//!
//! Each section of that page is a function `fn(&Report) -> Option<Section>` in a separate file, listed in `SECTIONS`; a new
//! section needs its data in [`Report`] and an entry there.

pub mod ball_test;
pub mod calibration;
mod circle;
pub mod compare;
mod contour;
mod correction;
mod data;
pub mod grinding;
pub mod keeping;
mod latency;
mod orientation;
mod path;
mod reversal;
pub mod thermal;

pub use data::{
    AngleSize, AxisReport, CircleReport, ContourSeries, ErrorSize, OrientationSeries, PathPoint, Report, ReversalReport,
};
pub use trueaxis_report::decimate;

use anyhow::{Context, Result};
use maud::Markup;
use std::path::{Path, PathBuf};
use trueaxis_tables::output::Outputs;

/// The sections below the summary, in the order of the page.
const SECTIONS: [fn(&Report) -> Option<Section>; 7] = [
    path::section,
    contour::section,
    circle::section,
    reversal::section,
    orientation::section,
    correction::section,
    latency::section,
];

/// A section of the page.
struct Section {
    heading: &'static str,
    content: Markup,
}

/// The page as one HTML document that is also well-formed XML.
#[must_use]
pub fn render(report: &Report) -> String {
    let sections = SECTIONS.iter().filter_map(|section| section(report));
    report.shown.page("", sections.map(|section| (section.heading, section.content)))
}

/// Writes files and the page, the last of them, into a folder, all or nothing; creates the folder if needed. Returns the path of
/// the page.
///
/// # Errors
/// A file cannot be written. A failure leaves no file behind.
pub fn write(mut outputs: Outputs, directory: &Path, files: &[(String, String)]) -> Result<PathBuf> {
    let write = || {
        outputs.folder(directory)?;
        for (name, text) in files {
            outputs.put(&directory.join(name), text.as_bytes())?;
        }
        outputs.commit()
    };
    write().with_context(|| format!("cannot write into {}", directory.display()))?;
    Ok(directory.join(files.last().map_or("", |(name, _)| name)))
}
