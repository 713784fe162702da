//! Why nothing is learned from a record.

use core::fmt;

/// Why nothing is learned.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum NotLearned {
    /// A figure of the law is out of range.
    Setting {
        /// Its name, as an option of the command line.
        key: &'static str,
        /// The figure.
        found: f64,
        /// Its range.
        needed: &'static str,
    },
    /// No row, or none in which the error was measured.
    Empty,
    /// A row lies off the path.
    OffThePath {
        /// The row, from 0.
        index: usize,
        /// Its path length, mm.
        found_mm: f64,
        /// Of the path, mm.
        length_mm: f64,
    },
    /// The path length goes back.
    Backwards {
        /// The row, from 0.
        index: usize,
        /// Its path length, mm.
        found_mm: f64,
        /// That of the row before, mm.
        before_mm: f64,
    },
    /// The rows leave a stretch of the path out.
    Gap {
        /// The row at its end, from 0.
        index: usize,
        /// Where it begins, mm.
        from_mm: f64,
        /// Where it ends, mm.
        to_mm: f64,
        /// Widest that is accepted, mm.
        widest_mm: f64,
    },
    /// An error that is no contour error, or no number.
    TooLarge {
        /// The row, from 0.
        index: usize,
        /// Largest component, mm.
        found_mm: f64,
        /// The most, mm.
        most_mm: f64,
    },
    /// The correction before has another number of nodes.
    Nodes {
        /// Its number.
        found: usize,
        /// Of the errors.
        needed: usize,
    },
    /// The path takes more nodes than a file holds.
    TooLong {
        /// Nodes.
        found: f64,
        /// The most.
        most: usize,
    },
    /// The correction is larger than the file's coarsest resolution holds.
    TooStrong {
        /// Largest component, mm.
        found_mm: f64,
        /// The most, mm.
        most_mm: f64,
    },
}

impl NotLearned {
    /// The row that is refused, from 0; none where it is not a single one.
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
