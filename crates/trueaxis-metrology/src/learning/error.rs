//! Why a record cannot be learned from.

use core::fmt;

/// Why a record cannot be learned from.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum NotLearned {
    /// A value of the law is out of range.
    Setting {
        /// Name of the command-line option.
        key: &'static str,
        /// The value.
        found: f64,
        /// Permitted range.
        needed: &'static str,
    },
    /// No row with a measured error.
    Empty,
    /// A row is off the path.
    OffThePath {
        /// Index of the row, from 0.
        index: usize,
        /// Path length of the row, mm.
        found_mm: f64,
        /// Length of the path, mm.
        length_mm: f64,
    },
    /// The path length decreases.
    Backwards {
        /// Index of the row, from 0.
        index: usize,
        /// Path length of the row, mm.
        found_mm: f64,
        /// Path length of the previous row, mm.
        before_mm: f64,
    },
    /// The rows omit a stretch of the path.
    Gap {
        /// Index of the row after the gap, from 0.
        index: usize,
        /// Start of the gap, mm.
        from_mm: f64,
        /// End of the gap, mm.
        to_mm: f64,
        /// Widest permitted gap, mm.
        widest_mm: f64,
    },
    /// An error is too large for a contour error, or not a number.
    TooLarge {
        /// Index of the row, from 0.
        index: usize,
        /// Largest component, mm.
        found_mm: f64,
        /// Largest permitted component, mm.
        most_mm: f64,
    },
    /// The previous correction has another number of nodes.
    Nodes {
        /// Number of nodes of the correction.
        found: usize,
        /// Number of nodes of the errors.
        needed: usize,
    },
    /// The path needs more nodes than a file can contain.
    TooLong {
        /// Number of nodes.
        found: f64,
        /// Largest permitted number.
        most: usize,
    },
    /// The correction exceeds the range at the file's coarsest resolution.
    TooStrong {
        /// Largest component, mm.
        found_mm: f64,
        /// Largest permitted component, mm.
        most_mm: f64,
    },
}

impl NotLearned {
    /// Returns the index of the refused row, from 0; `None` if the refusal concerns no single row.
    pub fn row(&self) -> Option<usize> {
        match *self {
            NotLearned::OffThePath { index, .. }
            | NotLearned::Backwards { index, .. }
            | NotLearned::Gap { index, .. }
            | NotLearned::TooLarge { index, .. } => Some(index),
            _ => None,
        }
    }
}

impl fmt::Display for NotLearned {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotLearned::Setting { key, found, needed } => write!(f, "{key}: found {found}, needed {needed}"),
            NotLearned::Empty => f.write_str("found no row with a measured error, needed one at least"),
            NotLearned::OffThePath { found_mm, length_mm, .. } => {
                write!(f, "found path length {found_mm} mm, needed 0 to {length_mm} mm, the length of the program")
            }
            NotLearned::Backwards { found_mm, before_mm, .. } => {
                write!(f, "found path length {found_mm} mm, needed at least {before_mm} mm of the row before")
            }
            NotLearned::Gap { from_mm, to_mm, widest_mm, .. } => write!(
                f,
                "found no row from {from_mm} to {to_mm} mm, needed a row at least every {widest_mm} mm (half the cut-off)"
            ),
            NotLearned::TooLarge { found_mm, most_mm, .. } => write!(
                f,
                "found an error of {} µm, needed at most {} µm (is the column in µm?)",
                1e3 * found_mm,
                1e3 * most_mm
            ),
            NotLearned::Nodes { found, needed } => {
                write!(f, "found a correction of {found} nodes, needed {needed} as the record has")
            }
            NotLearned::TooLong { found, most } => {
                write!(f, "found a path of {found} nodes, needed at most {most}: a longer cut-off takes fewer")
            }
            NotLearned::TooStrong { found_mm, most_mm } => {
                write!(f, "found a correction of {found_mm} mm, needed at most {most_mm} mm")
            }
        }
    }
}

impl core::error::Error for NotLearned {}
