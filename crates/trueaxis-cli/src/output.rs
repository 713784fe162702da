//! Where results go: a file, written whole or not at all, or the standard output; notes go to the standard error. The only
//! place that prints.

use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressStyle};
use std::fmt::Display;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use trueaxis_tables::text::printable;
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
pub(crate) fn progress(steps: u64, what: &'static str) -> ProgressBar {
    let style =
        ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}").unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(steps).with_style(style).with_message(what)
}

/// Rows of a result on their way to a file or to the standard output, in memory that does not grow with their number.
///
/// A file is written whole or not at all. The standard output gets nothing either where an error ends the command before
/// [`HELD`] bytes; past that the rows before the error have gone out.
pub(crate) struct Writer<'p> {
    file: Option<&'p Path>,
    text: String,
    /// Where the rows before those in `text` are.
    begun: Option<Begun>,
}

/// As much is held before anything is written.
const HELD: usize = 8 << 20;
/// As much is written at once after that.
const CHUNK: usize = 1 << 16;

enum Begun {
    StandardOutput,
    /// A device or a pipe that was named.
    Device(File),
    /// A file beside the one that is asked for, renamed in the end.
    Temporary {
        file: File,
        path: PathBuf,
        to: PathBuf,
    },
}

impl<'p> Writer<'p> {
    /// Without a file: the standard output.
    pub(crate) fn new(file: Option<&'p Path>) -> Writer<'p> {
        Writer { file, text: String::new(), begun: None }
    }

    /// Writes a row, or a part of one.
    pub(crate) fn put(&mut self, part: std::fmt::Arguments<'_>) -> Result<()> {
        use std::fmt::Write;
        self.text.write_fmt(part)?;
        if self.text.len() >= if self.begun.is_some() { CHUNK } else { HELD } { self.spill() } else { Ok(()) }
    }

    /// Writes what is held; a file is complete after this.
    pub(crate) fn finish(mut self) -> Result<()> {
        if self.begun.is_none() {
            return put(&self.text, self.file);
        }
        self.spill()?;
        if let Some(Begun::Temporary { file, path, to }) = &self.begun {
            let done = file.sync_all().and_then(|()| std::fs::rename(path, to));
            done.with_context(|| format!("cannot write {}", to.display()))?;
        }
        // Nothing is left to be removed.
        self.begun = Some(Begun::StandardOutput);
        Ok(())
    }

    fn spill(&mut self) -> Result<()> {
        if self.begun.is_none() {
            self.begun = Some(match self.file {
                None => Begun::StandardOutput,
                Some(file) => begin(file).with_context(|| format!("cannot write {}", file.display()))?,
            });
        }
        match &mut self.begun {
            Some(Begun::Temporary { file, to, .. }) => {
                file.write_all(self.text.as_bytes()).with_context(|| format!("cannot write {}", to.display()))?;
            }
            Some(Begun::Device(file)) => file.write_all(self.text.as_bytes()).map_err(standard_output)?,
            _ => put(&self.text, None)?,
        }
        self.text.clear();
        Ok(())
    }
}

/// Opens what the rows go into until the file is complete.
fn begin(file: &Path) -> std::io::Result<Begun> {
    // Behind a link, so that the link stays.
    let to = std::fs::canonicalize(file).unwrap_or_else(|_| file.to_path_buf());
    if to.exists() && !to.is_file() && !to.is_dir() {
        return Ok(Begun::Device(File::options().write(true).open(to)?));
    }
    let mut name = to.file_name().ok_or(std::io::ErrorKind::InvalidInput)?.to_owned();
    name.push(format!(".{}.tmp", std::process::id()));
    let path = to.with_file_name(name);
    Ok(Begun::Temporary { file: File::create(&path)?, path, to })
}

impl Drop for Writer<'_> {
    fn drop(&mut self) {
        if let Some(Begun::Temporary { path, .. }) = &self.begun {
            let _ = std::fs::remove_file(path);
        }
    }
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
            tell(format_args!("error: {}", printable(&format!("{error:#}"))));
            ExitCode::from(2)
        }
    }
}
