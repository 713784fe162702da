//! Where results go: a file, written whole or not at all, or the standard output.

use anyhow::Result;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::Write;
use std::path::{Path, PathBuf};
use trueaxis_tables::output::Outputs;

/// Writes a text to the standard output.
pub(crate) fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()?;
    Ok(())
}

/// Writes a text to a file that is none of the command's inputs, or to the standard output without one.
pub(crate) fn put(text: &str, file: Option<&Path>, inputs: impl IntoIterator<Item = PathBuf>) -> Result<()> {
    let Some(file) = file else { return print(text) };
    let mut outputs = Outputs::of(inputs);
    outputs.put(file, text.as_bytes())?;
    Ok(outputs.commit()?)
}

/// Prints one JSON document.
pub(crate) fn json(document: &impl serde::Serialize) -> Result<()> {
    print(&format!("{}\n", serde_json::to_string_pretty(document)?))
}

/// A bar on the standard error; hidden by indicatif where that is no terminal.
pub(crate) fn progress(rows: usize, what: &'static str) -> ProgressBar {
    let style =
        ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}").unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(rows as u64).with_style(style).with_message(what)
}

pub(crate) fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let broken = |cause: &std::io::Error| cause.kind() == std::io::ErrorKind::BrokenPipe;
    error.chain().any(|cause| cause.downcast_ref::<std::io::Error>().is_some_and(broken))
}
