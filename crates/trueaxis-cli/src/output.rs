//! Where results go: a file, written whole or not at all, or the standard output; notes go to the standard error. The only
//! place that prints.

use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressStyle};
use std::fmt::Display;
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;
use trueaxis_tables::write_atomically;

/// Writes a text to a file, or to the standard output without one.
pub(crate) fn put(text: &str, file: Option<&Path>) -> Result<()> {
    match file {
        Some(file) => put_bytes(text.as_bytes(), file),
        None => {
            let mut out = std::io::stdout().lock();
            out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(standard_output)
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

/// Says something on the standard error. Nobody listening there is no error, and nothing could be said about it.
pub(crate) fn tell(line: impl Display) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// The reader of the standard output has seen enough (`trueaxis … | head`).
#[derive(Debug)]
struct Closed;

impl Display for Closed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the standard output is closed")
    }
}

impl std::error::Error for Closed {}

/// What went wrong with the standard output; a closed pipe apart from everything else.
fn standard_output(error: std::io::Error) -> anyhow::Error {
    if error.kind() == std::io::ErrorKind::BrokenPipe {
        return Closed.into();
    }
    anyhow::Error::new(error).context("cannot write to the standard output")
}

/// The exit code: 0 done, or nobody reads on; 2 and the reason on the standard error.
pub(crate) fn exit_code(result: Result<()>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if error.is::<Closed>() => ExitCode::SUCCESS,
        Err(error) => {
            tell(format_args!("error: {error:#}"));
            ExitCode::from(2)
        }
    }
}
