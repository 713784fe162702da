//! CSV with a header of known columns, read row by row; every error names line and column.

use anyhow::Result;
use std::borrow::Cow;
use std::io::Read;
use std::path::{Path, PathBuf};
use trueaxis_tables::error::FileError;
use trueaxis_tables::sheet::Sheet;
use trueaxis_tables::text::one_of;

/// A column that a file may contain.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// Name in the header.
    pub name: &'static str,
    /// Whether a file without it is refused.
    pub needed: bool,
}

/// A row: its line, and the values in the order of the requested columns (0 for absent ones).
#[derive(Clone, Copy, Debug)]
pub struct Row<const C: usize> {
    /// Line of the file, from 1.
    pub line: u32,
    /// One value per column.
    pub values: [f64; C],
}

/// Reads the rows of a file one by one: memory does not grow with their number.
pub struct Rows<'r, const C: usize> {
    /// The file as errors name it.
    pub file: PathBuf,
    /// Which of the columns the file has.
    pub present: [bool; C],
    /// Header cells as written in the file.
    pub header: Vec<String>,
    /// Rows read so far.
    pub count: usize,
    sheet: Sheet<'r>,
    /// Index in the requested columns, by column of the file.
    order: Vec<usize>,
    gaps: bool,
    words: Option<Words>,
    reported: Option<&'static str>,
    note: Box<dyn FnMut(String) + 'r>,
}

/// A column that may contain words, and the function that gives their values.
type Words = (&'static str, fn(&str) -> Option<f64>);

/// Largest magnitude of a value: a metre of deviation, 1e9 of anything else (degrees are counted over many turns).
fn most(column: &str) -> f64 {
    match column.rsplit_once('_') {
        Some((_, "um" | "urad")) => 1e6,
        _ => 1e9,
    }
}

/// Opens the sheet and maps its columns to the requested ones. Separate from [`Rows`], whose code is compiled for each number
/// of columns.
fn opened<'r>(input: Box<dyn Read + 'r>, file: &Path, columns: &[Column]) -> Result<(Sheet<'r>, Vec<usize>)> {
    let sheet = Sheet::new(input, file)?;
    let header = sheet.header();
    let known = |cell: &str| one_of(cell, columns.iter().map(|column| column.name), ", ");
    let mut order = Vec::with_capacity(header.len());
    for (i, cell) in header.iter().enumerate() {
        let Some(slot) = columns.iter().position(|c| c.name == cell) else {
            return Err(sheet.error(cell, cell, known(cell)).into());
        };
        if header[..i].contains(cell) {
            return Err(sheet.error(cell, "a second column of that name", "one").into());
        }
        order.push(slot);
    }
    if let Some((_, missing)) = columns.iter().enumerate().find(|(slot, column)| column.needed && !order.contains(slot))
    {
        let needed = format!("the column {}", missing.name);
        return Err(sheet.error("", format!("columns {}", header.join(", ")), needed).into());
    }
    Ok((sheet, order))
}

/// Writes the values of the last row read into their slots.
fn read(
    sheet: &mut Sheet<'_>,
    header: &[String],
    order: &[usize],
    (gaps, words): (bool, Option<Words>),
    values: &mut [f64],
) -> Result<()> {
    for (i, (&slot, name)) in order.iter().zip(header).enumerate() {
        if gaps && sheet.field(i).is_empty() {
            values[slot] = f64::NAN;
            continue;
        }
        if let Some((column, meaning)) = words
            && column == name
            && let Some(value) = meaning(sheet.field(i))
        {
            values[slot] = value;
            continue;
        }
        let value = sheet.number(i)?;
        if value.abs() > most(name) {
            return Err(sheet.error(name, sheet.field(i), format!("at most {:e}", most(name))).into());
        }
        values[slot] = value;
    }
    Ok(())
}

fn no_rows(file: &Path) -> anyhow::Error {
    let (found, needed) = ("no rows".into(), "at least one".into());
    FileError { file: file.into(), line: None, column: None, found, needed }.into()
}

/// An error at a line of a file.
fn wrong(file: &Path, line: u32, column: &str, found: String, needed: String) -> anyhow::Error {
    FileError { file: file.into(), line: Some(line), column: Some(column.into()), found, needed }.into()
}

impl<'r, const C: usize> Rows<'r, C> {
    /// Checks the header; `file` is only named in errors. Separators other than commas and decimal commas are reported once to
    /// the callback.
    ///
    /// # Errors
    /// A header with unknown or duplicate columns, or without a required one.
    pub fn new(
        input: impl Read + 'r,
        file: &Path,
        columns: &[Column; C],
        note: impl FnMut(String) + 'r,
    ) -> Result<Rows<'r, C>> {
        let (sheet, order) = opened(Box::new(input), file, columns)?;
        let present: [bool; C] = std::array::from_fn(|slot| order.contains(&slot));
        let (header, note) = (sheet.header().to_vec(), Box::new(note));
        let mut rows = Rows {
            file: file.into(),
            present,
            header,
            count: 0,
            sheet,
            order,
            gaps: false,
            words: None,
            reported: None,
            note,
        };
        rows.note_dialect();
        Ok(rows)
    }

    /// From here on an empty cell gives NaN instead of an error.
    pub fn with_gaps(mut self) -> Self {
        self.gaps = true;
        self
    }

    /// Cells of `column` may be words to which `meaning` gives a value; all others are numbers.
    pub fn with_words(mut self, column: &'static str, meaning: fn(&str) -> Option<f64>) -> Self {
        self.words = Some((column, meaning));
        self
    }

    /// The next row; `None` at the end of the file.
    ///
    /// # Errors
    /// A row that cannot be read, or a file without rows.
    #[expect(clippy::should_implement_trait, reason = "a row may be an error, and an error does not end an iterator")]
    pub fn next(&mut self) -> Result<Option<Row<C>>> {
        let mut values = [0.0; C];
        if !self.sheet.next_row()? {
            self.note_dialect();
            return if self.count == 0 { Err(no_rows(&self.file)) } else { Ok(None) };
        }
        self.count += 1;
        read(&mut self.sheet, &self.header, &self.order, (self.gaps, self.words), &mut values)?;
        Ok(Some(Row { line: self.sheet.line(), values }))
    }

    /// All remaining rows, for evaluations that need them at once.
    ///
    /// # Errors
    /// As [`Rows::next`].
    pub fn all(&mut self) -> Result<Vec<Row<C>>> {
        let mut rows = Vec::new();
        while let Some(row) = self.next()? {
            rows.push(row);
        }
        Ok(rows)
    }

    /// The cells of the last row as written in the file, but with decimal points, in the file's order.
    pub fn cells(&self) -> impl Iterator<Item = Cow<'_, str>> + Clone {
        (0..self.header.len()).map(|i| self.sheet.plain(i))
    }

    /// An error at a line of the file.
    pub fn error(&self, line: u32, column: &str, found: impl ToString, needed: impl ToString) -> anyhow::Error {
        wrong(&self.file, line, column, found.to_string(), needed.to_string())
    }

    /// Reports once how a file with other separators or decimals is read.
    fn note_dialect(&mut self) {
        let dialect = self.sheet.dialect();
        if dialect != self.reported
            && let Some(how) = dialect
        {
            (self.note)(format!("{}: {how}", self.file.display()));
        }
        self.reported = dialect;
    }
}

impl<const C: usize> std::fmt::Debug for Rows<'_, C> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Rows").field("file", &self.file).field("count", &self.count).finish_non_exhaustive()
    }
}
