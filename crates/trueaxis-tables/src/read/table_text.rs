//! The tables of a machine as in their files, for display and editing.

use super::{axis_table, described, path_from};
use crate::error::FileError;
use crate::files::{Source, bytes};
use crate::origin::Origin;
use crate::sheet::Sheet;
use std::path::{Path, PathBuf};
use trueaxis::machine::Axis;

/// A column of an axis table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColumnText {
    /// Name in the header.
    pub name: String,
    /// 0 to 5 for EX to EC; `None`: the position.
    pub component: Option<usize>,
    /// Whether it applies to positive travel. A column that applies to neither direction is the standard uncertainty of its
    /// component.
    pub forward: bool,
    /// Whether it applies to negative travel.
    pub reverse: bool,
}

/// A table in the units of its file: positions in mm (degrees), errors in µm and µrad.
#[derive(Clone, Debug, PartialEq)]
pub struct TableText {
    /// The axis.
    pub axis: Axis,
    /// The file as `machine.toml` names it.
    pub file: String,
    /// Columns in the order of the file.
    pub columns: Vec<ColumnText>,
    /// Values of every line.
    pub rows: Vec<Vec<f64>>,
    /// Line number of every row in the file, from 1.
    pub lines: Vec<u32>,
    /// Name of the file in the source.
    pub(crate) path: PathBuf,
    /// Text of the file.
    pub(crate) text: String,
    /// Separator of the fields.
    pub(crate) separator: char,
    /// Whether decimals follow a comma.
    pub(crate) decimal_commas: bool,
}

/// The tables that a `machine.toml` names, in the order of the axes.
///
/// # Errors
/// A file that cannot be read, or that is invalid.
pub fn table_texts(files: &dyn Source, name: &Path) -> Result<Vec<TableText>, FileError> {
    let (_, description) = described(files, name)?;
    let read = |reference: super::TableReference| {
        let path = path_from(name, &reference.file);
        let origin = Origin::new(&files.path(&path));
        let bytes = bytes(files, &path)?;
        let read = axis_table::read(&bytes, &origin, reference.axis)?;
        let column = |column: &axis_table::Column| ColumnText {
            name: column.name.clone(),
            component: (0..6)
                .find(|of| column.holds(Some(*of), false) || column.holds(Some(*of), true))
                .or_else(|| column.uncertainty()),
            forward: (0..6).any(|of| column.holds(Some(of), false)),
            reverse: (0..6).any(|of| column.holds(Some(of), true)),
        };
        let columns: Vec<ColumnText> = read.columns.iter().map(column).collect();
        let mut sheet = Sheet::new(bytes.as_slice(), origin.file())?;
        let mut rows = Vec::with_capacity(read.lines.len());
        while sheet.next_row()? {
            rows.push((0..columns.len()).map(|index| sheet.number(index)).collect::<Result<Vec<f64>, FileError>>()?);
        }
        let (separator, decimal_commas) = (sheet.separator(), sheet.has_decimal_commas());
        drop(sheet);
        Ok(TableText {
            axis: reference.axis,
            file: reference.file,
            columns,
            rows,
            lines: read.lines,
            path,
            text: String::from_utf8_lossy(&bytes).into_owned(),
            separator,
            decimal_commas,
        })
    };
    let mut tables = description.tables.into_iter().map(read).collect::<Result<Vec<TableText>, FileError>>()?;
    tables.sort_by_key(|table| table.axis.index());
    Ok(tables)
}
