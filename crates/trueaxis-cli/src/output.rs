//! Results go to a file, written completely or not at all and never over an input, or to standard output; notes go to standard
//! error. The only module that prints.

use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressStyle};
use std::fmt::Display;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use trueaxis_tables::output::{Outputs, Staged};
use trueaxis_tables::text::printable;

/// Writes text for people to standard output; names in it must not act on a terminal.
pub(crate) fn print(text: &str) -> Result<()> {
    data(&printable(text))
}

/// Writes text for programs to standard output, unchanged.
pub(crate) fn data(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(standard_output)
}

/// Prints one JSON document.
pub(crate) fn json(document: &impl serde::Serialize) -> Result<()> {
    data(&trueaxis_evaluation::json::pretty(document)?)
}

/// A progress bar on standard error; indicatif hides it if that is not a terminal.
pub(crate) fn progress(steps: u64, what: &'static str) -> ProgressBar {
    let style =
        ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}").unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(steps).with_style(style).with_message(what)
}

/// Rows of a result being written to a file or to standard output, in memory that does not grow with their number.
///
/// A file is written completely or not at all. Standard output also gets nothing if an error ends the command before [`KEPT`]
/// bytes; after that, the rows before the error have been written.
pub(crate) struct Writer<'p> {
    file: Option<&'p Path>,
    text: String,
    /// Destination of the rows before those in `text`.
    begun: Option<Begun>,
}

/// Bytes kept in memory before anything is written.
const KEPT: usize = 8 << 20;
/// Bytes written at a time after that.
const CHUNK: usize = 1 << 16;

enum Begun {
    StandardOutput,
    File(Staged),
}

impl<'p> Writer<'p> {
    /// Without a file, writes to standard output. Refuses a file that the command reads.
    pub(crate) fn new(file: Option<&'p Path>, inputs: impl IntoIterator<Item = PathBuf>) -> Result<Writer<'p>> {
        if let Some(file) = file {
            Outputs::of(inputs).refuse_input(file)?;
        }
        Ok(Writer { file, text: String::new(), begun: None })
    }

    /// Writes a row, or a part of one.
    pub(crate) fn put(&mut self, part: std::fmt::Arguments<'_>) -> Result<()> {
        use std::fmt::Write;
        self.text.write_fmt(part)?;
        if self.text.len() >= if self.begun.is_some() { CHUNK } else { KEPT } { self.spill() } else { Ok(()) }
    }

    /// Writes the rest; a file is complete after this.
    pub(crate) fn finish(mut self) -> Result<()> {
        self.spill()?;
        match (self.begun, self.file) {
            (Some(Begun::File(staged)), Some(file)) => staged.commit().with_context(|| cannot_write(file)),
            _ => Ok(()),
        }
    }

    fn spill(&mut self) -> Result<()> {
        let begun = match (&mut self.begun, self.file) {
            (Some(begun), _) => begun,
            (none, None) => none.insert(Begun::StandardOutput),
            (none, Some(file)) => none.insert(Begun::File(Staged::create(file).with_context(|| cannot_write(file))?)),
        };
        match begun {
            Begun::StandardOutput => data(&self.text)?,
            Begun::File(staged) => {
                let file = self.file.unwrap_or(Path::new(""));
                staged.write_all(self.text.as_bytes()).with_context(|| cannot_write(file))?;
            }
        }
        self.text.clear();
        Ok(())
    }
}

fn cannot_write(file: &Path) -> String {
    format!("cannot write {}", file.display())
}

/// Prints a line on standard error. Ignores errors, because a failing standard error leaves nowhere to report them.
pub(crate) fn report_line(line: impl Display) {
    let _ = writeln!(std::io::stderr().lock(), "{}", printable(&line.to_string()));
}

/// The reader of standard output closed it early (`trueaxis … | head`).
#[derive(Debug)]
struct Closed;

impl Display for Closed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the standard output is closed")
    }
}

impl std::error::Error for Closed {}

/// Error of a failed write to standard output; a pipe closed by its reader gets a separate error.
fn standard_output(error: std::io::Error) -> anyhow::Error {
    if error.kind() == std::io::ErrorKind::BrokenPipe {
        return Closed.into();
    }
    anyhow::Error::new(error).context("cannot write to the standard output")
}

/// A command that succeeded but needs a person to decide: exit code 3.
#[derive(Debug)]
pub(crate) struct NeedsPerson(pub(crate) String);

impl Display for NeedsPerson {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for NeedsPerson {}

/// The exit code: 0 for success or a closed pipe; 2 with the reason on standard error; 3 if `keep` needs a person.
pub(crate) fn exit_code(result: Result<()>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if error.is::<Closed>() => ExitCode::SUCCESS,
        Err(error) => {
            report_line(format_args!("error: {error:#}"));
            ExitCode::from(if error.is::<NeedsPerson>() { 3 } else { 2 })
        }
    }
}
