//! Reports: one self-contained HTML page each, no network, no script. Figures are SVG inside the page.

pub(crate) mod helicoid;
pub(crate) mod identify;
pub(crate) mod predict;
pub(crate) mod uncertainty;

use anyhow::Result;
use maud::Markup;
use std::path::Path;
use trueaxis_evaluation::shown::Shown;
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

/// Stages the page of a result from the file `record`, with the additional sections `figures`.
pub(crate) fn stage<H: AsRef<str>>(
    outputs: &mut Outputs,
    to: (&Path, &str),
    record: &Path,
    shown: &Shown,
    figures: impl IntoIterator<Item = (H, Markup)>,
) -> Result<()> {
    let source = record.file_name().unwrap_or_default().to_string_lossy();
    write(outputs, &shown.page(&source, figures), to.0, to.1)
}

/// No sections of the result's own.
pub(crate) const NO_FIGURES: [(&str, Markup); 0] = [];
