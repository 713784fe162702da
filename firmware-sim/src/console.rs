//! Standard output, standard error and the progress bar.

use anyhow::Result;
use firmware_sim::report;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::io::Write;
use std::path::Path;
use trueaxis_evaluation::shown::Shown;
use trueaxis_tables::output::Outputs;

/// A progress bar in thousandths on standard error.
pub(crate) fn progress_bar(message: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}");
    let bar = ProgressBar::new(1000).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_message(message);
    bar
}

/// A counting progress bar on standard error.
pub(crate) fn counting_bar(length: u64, of: &str) -> ProgressBar {
    let style = ProgressStyle::with_template(&format!("{{bar:40}} {{pos}}/{{len}} {of}"));
    ProgressBar::new(length).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// The reader of standard output has closed it (`firmware-sim … | head`), which is not an error.
#[derive(Debug)]
pub(crate) struct Closed;

impl std::fmt::Display for Closed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the standard output is closed")
    }
}

impl std::error::Error for Closed {}

/// Writes to standard output; a full disk or a closed pipe is an error, not a panic.
pub(crate) fn put(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|error| match error.kind() {
        std::io::ErrorKind::BrokenPipe => Closed.into(),
        _ => anyhow::Error::new(error).context("cannot write to the standard output"),
    })
}

/// Ends a command: writes the files of a page into a folder, if there is one, and prints the document or the text.
pub(crate) fn conclude<D: Serialize>(
    as_json: bool,
    document: &D,
    shown: &Shown,
    (folder, outputs): (Option<&Path>, Outputs),
    files: impl FnOnce() -> Vec<(String, String)>,
) -> Result<()> {
    let page = folder.map(|folder| report::write(outputs, folder, &files())).transpose()?;
    if as_json {
        return put(&trueaxis_evaluation::json::pretty(document)?);
    }
    let page = page.map_or(String::new(), |page| format!("\nwritten  {}\n", page.display()));
    put(&(shown.text() + &page))
}

/// Writes a line to standard error, and ignores a closed one: nobody could read the report.
pub(crate) fn report_line(line: impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}
