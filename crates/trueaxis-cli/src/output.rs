//! Where results go: a file, written whole or not at all, or the standard output.

use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::Write;
use std::path::Path;
use trueaxis_tables::write_atomically;

/// Writes a text to a file, or to the standard output without one.
pub(crate) fn put(text: &str, file: Option<&Path>) -> Result<()> {
    match file {
        Some(file) => put_bytes(text.as_bytes(), file),
        None => {
            let mut out = std::io::stdout().lock();
            out.write_all(text.as_bytes())?;
            out.flush()?;
            Ok(())
        }
    }
}

/// Writes a file whole or not at all.
pub(crate) fn put_bytes(bytes: &[u8], file: &Path) -> Result<()> {
    write_atomically(file, bytes).with_context(|| format!("cannot write {}", file.display()))
}

/// Prints one JSON document.
pub(crate) fn json(document: &impl serde::Serialize) -> Result<()> {
    put(&format!("{}\n", serde_json::to_string_pretty(document)?), None)
}

/// A bar on the standard error; hidden by indicatif where that is no terminal.
pub(crate) fn progress(rows: usize, what: &'static str) -> ProgressBar {
    let style =
        ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}").unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(rows as u64).with_style(style).with_message(what)
}

pub(crate) fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}
