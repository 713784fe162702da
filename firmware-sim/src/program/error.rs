//! What is wrong with a program, and where.

use std::path::{Path, PathBuf};

/// The way out for what only a whole interpreter can read.
pub(super) const THROUGH_LINUXCNC: &str = "with --interpreter rs274, where LinuxCNC is installed";

/// So many characters of a program stand in a message at most.
const LONGEST_FOUND: usize = 160;

/// A program that cannot be executed: file, line, what was found there and what is needed instead.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}:{line}: found {found}; needed: {needed}", file.display())]
pub struct ProgramError {
    /// File the text came from.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: u32,
    /// The offending word or state.
    pub found: String,
    /// What is accepted in its place.
    pub needed: String,
}

/// The same without the file, as raised below [`super::Program::parse`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Refusal {
    pub(super) line: u32,
    pub(super) found: String,
    pub(super) needed: String,
}

impl Refusal {
    pub(super) fn new(line: u32, found: impl Into<String>, needed: impl Into<String>) -> Self {
        let mut found = found.into();
        if let Some((end, _)) = found.char_indices().nth(LONGEST_FOUND) {
            found.truncate(end);
            found.push('…');
        }
        Refusal { line, found, needed: needed.into() }
    }

    pub(super) fn in_file(self, file: &Path) -> ProgramError {
        ProgramError { file: file.to_path_buf(), line: self.line, found: self.found, needed: self.needed }
    }
}
