//! Errors in files.

use crate::printable::one_line;
use std::fmt;
use std::path::PathBuf;

/// Most characters of a column or key name in a message.
const LONGEST_NAME: usize = 100;
/// Most characters of the found text, which may be a list, and of any other part.
const LONGEST: usize = 1000;

/// Why a file is refused: line and column, the text found there, and the text needed instead.
///
/// Displayed on one line of bounded length, as `x.csv:14: column EXX_um: found "nan", needed a finite number`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    /// The file.
    pub file: PathBuf,
    /// Line, counted from 1; `None` for the file as a whole.
    pub line: Option<u32>,
    /// Name of the column or key.
    pub column: Option<String>,
    /// Found text.
    pub found: String,
    /// Needed text.
    pub needed: String,
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", one_line(&self.file.display().to_string(), LONGEST))?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if let Some(column) = &self.column {
            let kind =
                if self.file.extension().is_some_and(|extension| extension == "toml") { "key" } else { "column" };
            write!(f, ": {kind} {}", one_line(column, LONGEST_NAME))?;
        }
        write!(f, ": found {}, needed {}", one_line(&self.found, LONGEST), one_line(&self.needed, LONGEST))
    }
}

impl std::error::Error for FileError {}

/// Needed instead of a file that cannot be read.
pub(crate) const READABLE: &str = "a readable file";

impl FileError {
    /// Whether the file could not be read because it does not exist.
    pub fn is_missing(&self) -> bool {
        self.needed == READABLE && !self.file.exists()
    }
}

#[test]
fn a_refusal_is_one_line_of_bounded_length_whatever_the_file_holds() {
    let file = "machine.toml".into();
    let error = FileError {
        file,
        line: Some(2),
        column: Some("x".repeat(4000)),
        found: "a\nb".repeat(4000),
        needed: "c".into(),
    };
    let text = error.to_string();
    assert!(text.starts_with("machine.toml:2: key xxx") && text.ends_with("…, needed c"), "{text}");
    assert!(!text.contains('\n') && text.chars().count() < 1700, "{} characters", text.chars().count());
}
