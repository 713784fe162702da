//! Reports: one self-contained HTML page each, no network. Figures are SVG inside the page; only the helicoid's page, whose
//! inputs can be changed, has a script.

pub(crate) mod circle;
mod figure;
pub(crate) mod helicoid;
mod polar;
pub(crate) mod roundness;
mod text;

use crate::output::put_bytes;
use anyhow::{Context, Result};
use std::path::Path;

const STYLE: &str = include_str!("style.css");

/// Writes a page into a folder, which is created if need be.
pub(crate) fn write(page: &str, directory: &Path, name: &str) -> Result<()> {
    std::fs::create_dir_all(directory).with_context(|| format!("cannot create {}", directory.display()))?;
    put_bytes(page.as_bytes(), &directory.join(name))
}

/// Writes a page into a file, if the path's name ends in `.html`, or else under `name` into that folder.
pub(crate) fn write_to(page: &str, path: &Path, name: &str) -> Result<()> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("html")) && !path.is_dir() {
        return put_bytes(page.as_bytes(), path);
    }
    write(page, path, name)
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
