//! Reports: one self-contained HTML page each, no network, no script. Figures are SVG inside the page.

pub(crate) mod friction;
pub(crate) mod helicoid;
pub(crate) mod identify;
pub(crate) mod roundness;
mod shown;
pub(crate) mod uncertainty;

pub(crate) use shown::{NO_FIGURES, page, stage};

use anyhow::Result;
use maud::{Markup, html};
use std::path::Path;
use trueaxis_tables::output::Outputs;

/// Stages a page in a folder, which is created if needed.
pub(crate) fn write(outputs: &mut Outputs, page: &str, directory: &Path, name: &str) -> Result<()> {
    outputs.folder(directory)?;
    Ok(outputs.put(&directory.join(name), page.as_bytes())?)
}

/// Stages a page as a file if the path's name ends in `.html`, otherwise under `name` in that folder.
pub(crate) fn write_to(outputs: &mut Outputs, page: &str, path: &Path, name: &str) -> Result<()> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("html")) && !path.is_dir() {
        return Ok(outputs.put(path, page.as_bytes())?);
    }
    write(outputs, page, path, name)
}

/// Warnings of a run, one per line.
fn warnings(warnings: &[String]) -> Markup {
    html! { @if !warnings.is_empty() { ul { @for warning in warnings { li { (warning) } } } } }
}

/// Smallest and largest of the values.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}
