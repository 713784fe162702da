//! Errors and numbers of a text file.

use crate::error::{FileError, READABLE};
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// The file that is being read, for error messages.
pub(crate) struct Origin {
    file: PathBuf,
}

impl Origin {
    pub(crate) fn new(file: &Path) -> Origin {
        Origin { file: file.to_path_buf() }
    }

    /// The file.
    pub(crate) fn file(&self) -> &Path {
        &self.file
    }

    /// An error at one line (0: no single line); an empty `column` means the line as a whole.
    pub(crate) fn at(&self, line: u32, column: &str, found: impl Display, needed: impl Into<String>) -> FileError {
        FileError {
            file: self.file.clone(),
            line: (line > 0).then_some(line),
            column: (!column.is_empty()).then(|| column.to_owned()),
            found: shortened(&found.to_string()),
            needed: needed.into(),
        }
    }

    /// An error of the file as a whole.
    pub(crate) fn whole(&self, found: impl Into<String>, needed: impl Into<String>) -> FileError {
        FileError { file: self.file.clone(), line: None, column: None, found: found.into(), needed: needed.into() }
    }

    /// The error for a file that cannot be read.
    pub(crate) fn unreadable(&self, error: &std::io::Error) -> FileError {
        self.whole(error.to_string(), READABLE)
    }

    /// A finite decimal number.
    pub(crate) fn number(&self, line: u32, column: &str, text: &str) -> Result<f64, FileError> {
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => Err(self.at(line, column, format!("{text:?}"), "a finite number")),
            Err(_) if text.is_empty() => Err(self.at(line, column, "nothing", "a number")),
            Err(_) => Err(self.at(line, column, format!("{text:?}"), "a number")),
        }
    }
}

/// Keeps messages short: a binary file may have no line ends.
fn shortened(found: &str) -> String {
    if found.chars().count() <= 120 {
        return found.to_owned();
    }
    found.chars().take(117).chain("...".chars()).collect()
}

/// Lines with their numbers, from 1.
pub(crate) fn numbered(text: &str) -> impl Iterator<Item = (u32, &str)> {
    (1..).zip(text.lines())
}
