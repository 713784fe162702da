//! Lines of an error table, wherever they are stored.

use super::Row;

/// A table's lines by number: implemented for slices and for the lines of a compiled file.
pub trait Rows {
    /// Number of lines.
    fn len(&self) -> usize;
    /// Line `index`, in ascending order of position.
    fn row(&self, index: usize) -> Option<Row>;
    /// No lines at all.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Rows for [Row] {
    fn len(&self) -> usize {
        <[Row]>::len(self)
    }
    fn row(&self, index: usize) -> Option<Row> {
        self.get(index).copied()
    }
}
