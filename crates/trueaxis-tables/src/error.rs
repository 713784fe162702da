//! Errors in files.

use crate::printable::printable;
use std::fmt;
use std::path::PathBuf;

/// Why a file is refused: line and column, what was found there, what is needed instead.
///
/// Displayed as `x.csv:14: column EXX_um: found "nan", needed a finite number`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    /// The file.
    pub file: PathBuf,
    /// Line, counted from 1; `None` where the whole file is meant.
    pub line: Option<u32>,
    /// Column or key by name.
    pub column: Option<String>,
    /// Found text.
    pub found: String,
    /// Needed text.
    pub needed: String,
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", printable(&self.file.display().to_string()))?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if let Some(column) = &self.column {
            let kind =
                if self.file.extension().is_some_and(|extension| extension == "toml") { "key" } else { "column" };
            write!(f, ": {kind} {}", printable(column))?;
        }
        write!(f, ": found {}, needed {}", printable(&self.found), printable(&self.needed))
    }
}

impl std::error::Error for FileError {}
