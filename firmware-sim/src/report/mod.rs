//! HTML reports of the simulator, one self-contained file each.
//!
//! [`Report`] is plain data: the caller fills it in after the simulation, [`render`] makes the page and [`write()`] its
//! `index.html`. Missing or undefined data omit a figure and are never an error.
//!
//! Each section of the page is a function `fn(&Report) -> Option<Section>` in a separate file, listed in `SECTIONS`; a new
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
mod summary;
pub mod thermal;

pub use data::{
    AngleSize, AxisReport, CircleReport, ContourErrors, ContourSeries, ErrorSize, FaultEntry, OrientationSeries,
    PathPoint, Report, ReversalReport,
};
pub use trueaxis_report::decimate;

use maud::Markup;
use std::{
    io,
    path::{Path, PathBuf},
};
use trueaxis_report::Page;
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
    let title = if report.title.is_empty() { "Simulation report" } else { &report.title };
    let page = Page::new(title).top(summary::top(report));
    let sections = SECTIONS.iter().filter_map(|section| section(report));
    sections.fold(page, |page, section| page.section(section.heading, section.content)).document()
}

/// Writes the page to `index.html` in `directory`, which is created if needed; returns the file's path.
///
/// # Errors
/// The file system's error if the page cannot be written. A failure leaves no file behind.
pub fn write(report: &Report, directory: &Path) -> io::Result<PathBuf> {
    write_page(directory, "index.html", &render(report), Vec::new())
}

/// Writes a page and its accompanying files, all or nothing; creates the folder if needed.
fn write_page(directory: &Path, name: &str, page: &str, accompanying: Vec<(String, String)>) -> io::Result<PathBuf> {
    let mut outputs = Outputs::default();
    let file = directory.join(name);
    let write = |outputs: &mut Outputs| {
        outputs.folder(directory)?;
        for (name, text) in &accompanying {
            outputs.put(&directory.join(name), text.as_bytes())?;
        }
        outputs.put(&file, page.as_bytes())
    };
    write(&mut outputs).and_then(|()| outputs.commit()).map_err(io::Error::other)?;
    Ok(file)
}
