//! Reports: one self-contained HTML page each, no network. Figures are SVG inside the page; only the helicoid's page, whose
//! inputs can be changed, has a script.

pub(crate) mod circle;
mod figure;
pub(crate) mod helicoid;
pub(crate) mod identify;
mod polar;
pub(crate) mod roundness;
mod text;

use anyhow::Result;
use std::path::Path;
use trueaxis_tables::output::Outputs;

const STYLE: &str = include_str!("style.css");

/// A page in a folder, which is created if need be.
pub(crate) fn write(outputs: &mut Outputs, page: &str, directory: &Path, name: &str) -> Result<()> {
    outputs.folder(directory)?;
    Ok(outputs.put(&directory.join(name), page.as_bytes())?)
}

/// A page in a file, if the path's name ends in `.html`, or else under `name` in that folder.
pub(crate) fn write_to(outputs: &mut Outputs, page: &str, path: &Path, name: &str) -> Result<()> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("html")) && !path.is_dir() {
        return Ok(outputs.put(path, page.as_bytes())?);
    }
    write(outputs, page, path, name)
}

/// A whole page; `body` must be well formed.
fn document(title: &str, body: &str) -> String {
    document_with(title, "", body)
}

/// A whole page with styles of its own.
fn document_with(title: &str, style: &str, body: &str) -> String {
    let title = text::escape(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en-GB\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>{title}</title>\n<style>\n{STYLE}{style}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n{body}</main>\n\
         </body>\n</html>\n"
    )
}

fn section(heading: &str, html: &str) -> String {
    format!("<section>\n<h2>{}</h2>\n{html}</section>\n", text::escape(heading))
}
