//! CSV with a header of known columns; every fault with its line and column.

use anyhow::{Context, Result};
use std::path::{Path, PathBuf};
use trueaxis::check::range::POSITION;
use trueaxis_tables::error::FileError;

/// A column that a file may have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Column {
    pub(crate) name: &'static str,
    pub(crate) needed: bool,
}

/// The rows of a file, values in the order of the columns asked for.
#[derive(Debug)]
pub(crate) struct Rows<const C: usize> {
    pub(crate) file: PathBuf,
    /// Which of the columns the file has.
    pub(crate) present: [bool; C],
    /// Header cells as they stand in the file.
    pub(crate) header: Vec<String>,
    /// Line number, values (0 for absent columns) and the cells as they stand in the file.
    pub(crate) rows: Vec<(u32, [f64; C], Vec<String>)>,
}

/// Largest size of a value: a kilometre, a metre of deviation, 1e9 of anything else (degrees are counted over many turns).
fn most(column: &str) -> f64 {
    match column.rsplit_once('_') {
        Some((_, "mm")) => POSITION.linear.most,
        Some((_, "um" | "urad")) => 1e6,
        _ => 1e9,
    }
}

impl<const C: usize> Rows<C> {
    /// Reads a file; `#` starts a comment line.
    pub(crate) fn read(file: &Path, columns: &[Column; C]) -> Result<Rows<C>> {
        let bytes = std::fs::read(file).with_context(|| format!("cannot read {}", file.display()))?;
        let wrong = |line: Option<u32>, column: Option<&str>, found: String, needed: String| FileError {
            file: file.into(),
            line,
            column: column.map(str::to_owned),
            found,
            needed,
        };
        let text = String::from_utf8(bytes)
            .map_err(|_| wrong(None, None, "bytes that are no UTF-8".into(), "a CSV text".into()))?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        let mut lines = (1u32..)
            .zip(text.lines())
            .map(|(number, line)| (number, line.trim()))
            .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let names = || columns.iter().map(|c| c.name).collect::<Vec<_>>().join(", ");
        let Some((header_line, header_text)) = lines.next() else {
            return Err(wrong(None, None, "no header".into(), format!("columns {}", names())).into());
        };
        let header: Vec<String> = header_text.split(',').map(|cell| cell.trim().to_owned()).collect();
        let mut order = Vec::with_capacity(header.len());
        for (i, cell) in header.iter().enumerate() {
            let Some(place) = columns.iter().position(|c| c.name == cell) else {
                return Err(wrong(Some(header_line), Some(cell), cell.clone(), format!("one of {}", names())).into());
            };
            if header[..i].contains(cell) {
                return Err(
                    wrong(Some(header_line), Some(cell), "a second column of that name".into(), "one".into()).into()
                );
            }
            order.push(place);
        }
        let present: [bool; C] = std::array::from_fn(|place| order.contains(&place));
        if let Some(missing) = columns.iter().zip(present).find(|(column, present)| column.needed && !present) {
            let needed = format!("the column {}", missing.0.name);
            return Err(wrong(Some(header_line), None, format!("columns {}", header.join(", ")), needed).into());
        }
        let mut rows = Vec::new();
        for (line, text) in lines {
            let cells: Vec<String> = text.split(',').map(|cell| cell.trim().to_owned()).collect();
            if cells.len() != order.len() {
                let (found, needed) = (format!("{} values", cells.len()), format!("{} as in the header", order.len()));
                return Err(wrong(Some(line), None, found, needed).into());
            }
            let mut values = [0.0; C];
            for ((cell, place), name) in cells.iter().zip(&order).zip(&header) {
                values[*place] = match cell.parse::<f64>() {
                    Ok(value) if value.abs() <= most(name) => value,
                    _ => {
                        let found = if cell.is_empty() { "an empty cell".into() } else { cell.clone() };
                        let needed = format!("a finite number, at most {:e}", most(name));
                        return Err(wrong(Some(line), Some(name), found, needed).into());
                    }
                };
            }
            rows.push((line, values, cells));
        }
        if rows.is_empty() {
            return Err(wrong(None, None, "no rows".into(), "at least one".into()).into());
        }
        Ok(Rows { file: file.into(), present, header, rows })
    }

    /// An error at a place in the file.
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
}
