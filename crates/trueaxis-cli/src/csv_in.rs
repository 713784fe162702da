//! CSV with a header of known columns, row by row; every fault with its line and column.

use crate::output::{progress, tell};
use anyhow::{Context, Result};
use indicatif::ProgressBar;
use std::fs::File;
use std::path::{Path, PathBuf};
use trueaxis_tables::error::FileError;
use trueaxis_tables::sheet::Sheet;

/// A column that a file may have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Column {
    pub(crate) name: &'static str,
    pub(crate) needed: bool,
}

/// A row: its line, and the values in the order of the columns asked for (0 for absent ones).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row<const C: usize> {
    pub(crate) line: u32,
    pub(crate) values: [f64; C],
}

/// The rows of a file, one after the other: memory does not grow with their number.
#[derive(Debug)]
pub(crate) struct Rows<const C: usize> {
    pub(crate) file: PathBuf,
    /// Which of the columns the file has.
    pub(crate) present: [bool; C],
    /// Header cells as they stand in the file.
    pub(crate) header: Vec<String>,
    /// Rows read so far.
    pub(crate) count: usize,
    sheet: Sheet<'static>,
    /// Index among the columns asked for, by column of the file.
    order: Vec<usize>,
    reported: Option<&'static str>,
    bar: ProgressBar,
}

/// Largest size of a value: a metre of deviation, 1e9 of anything else (degrees are counted over many turns).
fn most(column: &str) -> f64 {
    match column.rsplit_once('_') {
        Some((_, "um" | "urad")) => 1e6,
        _ => 1e9,
    }
}

impl<const C: usize> Rows<C> {
    /// Opens a file and checks its header; `what` names the rows on the progress bar.
    pub(crate) fn open(file: &Path, columns: &[Column; C], what: &'static str) -> Result<Rows<C>> {
        let input = File::open(file).with_context(|| format!("cannot read {}", file.display()))?;
        let bar = progress(input.metadata().map_or(0, |data| data.len()), what);
        let sheet = Sheet::new(bar.wrap_read(input), file)?;
        let header = sheet.header().to_vec();
        let names = || columns.iter().map(|c| c.name).collect::<Vec<_>>().join(", ");
        let mut order = Vec::with_capacity(header.len());
        for (i, cell) in header.iter().enumerate() {
            let Some(slot) = columns.iter().position(|c| c.name == cell) else {
                return Err(sheet.error(cell, cell, format!("one of {}", names())).into());
            };
            if header[..i].contains(cell) {
                return Err(sheet.error(cell, "a second column of that name", "one").into());
            }
            order.push(slot);
        }
        let present: [bool; C] = std::array::from_fn(|slot| order.contains(&slot));
        if let Some(missing) = columns.iter().zip(present).find(|(column, present)| column.needed && !present) {
            let needed = format!("the column {}", missing.0.name);
            return Err(sheet.error("", format!("columns {}", header.join(", ")), needed).into());
        }
        let mut rows = Rows { file: file.into(), present, header, count: 0, sheet, order, reported: None, bar };
        rows.tell();
        Ok(rows)
    }

    /// The next row; none at the end of the file.
    ///
    /// # Errors
    /// A row that cannot be read, or a file without any.
    pub(crate) fn next(&mut self) -> Result<Option<Row<C>>> {
        if !self.sheet.next_row()? {
            self.bar.finish_and_clear();
            self.tell();
            if self.count == 0 {
                let file = self.file.clone();
                let (found, needed) = ("no rows".into(), "at least one".into());
                return Err(FileError { file, line: None, column: None, found, needed }.into());
            }
            return Ok(None);
        }
        self.count += 1;
        let mut values = [0.0; C];
        for (i, &slot) in self.order.iter().enumerate() {
            let (value, name) = (self.sheet.number(i)?, &self.header[i]);
            if value.abs() > most(name) {
                return Err(self.sheet.error(name, self.sheet.field(i), format!("at most {:e}", most(name))).into());
            }
            values[slot] = value;
        }
        Ok(Some(Row { line: self.sheet.line(), values }))
    }

    /// All rows that are left: for commands that need them at once.
    pub(crate) fn all(&mut self) -> Result<Vec<Row<C>>> {
        let mut rows = Vec::new();
        while let Some(row) = self.next()? {
            rows.push(row);
        }
        Ok(rows)
    }

    /// The cells of the last row as they stand in the file, but with decimal points, in the file's order.
    pub(crate) fn cells(&self) -> impl Iterator<Item = std::borrow::Cow<'_, str>> + Clone {
        (0..self.header.len()).map(|i| self.sheet.plain(i))
    }

    /// An error at a line of the file.
    pub(crate) fn error(&self, line: u32, column: &str, found: impl ToString, needed: impl ToString) -> anyhow::Error {
        FileError {
            file: self.file.clone(),
            line: Some(line),
            column: Some(column.into()),
            found: found.to_string(),
            needed: needed.to_string(),
        }
        .into()
    }

    /// Says once how a file is read that has other separators or decimals.
    fn tell(&mut self) {
        let dialect = self.sheet.dialect();
        if dialect != self.reported
            && let Some(how) = dialect
        {
            self.bar.suspend(|| tell(format_args!("note: {}: {how}", self.file.display())));
        }
        self.reported = dialect;
    }
}

impl<const C: usize> Drop for Rows<C> {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
