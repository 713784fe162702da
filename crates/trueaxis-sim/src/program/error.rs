//! Errors of a program, with their lines.

use crate::message::LONGEST_FOUND;
use trueaxis_tables::text::one_line;

/// Hint for words that only a full interpreter can read.
pub(super) const THROUGH_LINUXCNC: &str = "with --interpreter rs274, where LinuxCNC is installed";

/// A program that cannot be executed: file, line, the text found there and the text needed instead.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}: found {found}; needed: {needed}")]
pub struct ProgramError {
    /// File the text came from.
    pub file: String,
    /// Line, from 1.
    pub line: u32,
    /// The offending word or state.
    pub found: String,
    /// Accepted instead.
    pub needed: String,
}

impl ProgramError {
    /// Creates an error in a line of a file; `found` is shortened to the length of a line.
    pub fn new(file: &str, line: u32, found: impl Into<String>, needed: impl Into<String>) -> ProgramError {
        Refusal::new(line, found, needed).in_file(file)
    }
}

/// A [`ProgramError`] without the file, as raised below [`super::Program::parse`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Refusal {
    pub(super) line: u32,
    pub(super) found: String,
    pub(super) needed: String,
}

impl Refusal {
    pub(super) fn new(line: u32, found: impl Into<String>, needed: impl Into<String>) -> Self {
        Refusal { line, found: one_line(&found.into(), LONGEST_FOUND), needed: needed.into() }
    }

    pub(super) fn in_file(self, file: &str) -> ProgramError {
        ProgramError { file: file.to_owned(), line: self.line, found: self.found, needed: self.needed }
    }
}

#[test]
fn quoted_text_stays_on_its_line() {
    let error = ProgramError::new("offsets.toml", 3, "unknown field `a\nb`", "x_mm");
    assert_eq!(error.to_string(), "offsets.toml:3: found unknown field `a\\nb`; needed: x_mm");
}
