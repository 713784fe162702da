//! Single changes to the files of a machine: a point of a table, an added or removed line, a key of `machine.toml`. Comments,
//! order and the rest of the files stay as they are.

use crate::correlated::forget;
use crate::document::{Edited, as_before, editable, set};
use crate::error::FileError;
use crate::files::{Edit, Memory, Source};
use crate::origin::Origin;
use crate::read::table_text::{TableText, table_texts};
use crate::{Machine, read};
use serde::Deserialize;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml_edit::{Item, TableLike, Value};
use trueaxis::machine::{Axis, Curve, wraps};

/// A change to the files of a machine, in the units of the files.
///
/// As JSON: `{"change": "point", "axis": "X", "column": "EXX_um", "row": 3, "value": 1.5}`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "change", rename_all = "lowercase")]
pub enum Change {
    /// Change a value of a table.
    Point {
        /// Axis of the table.
        axis: Axis,
        /// Column by its name in the header.
        column: String,
        /// Row, from 0.
        row: usize,
        /// In mm or degrees for the position column, in µm or µrad for the others.
        value: f64,
        /// Other columns of the row that change with it, by name, with their values: the other direction of travel.
        #[serde(default)]
        also: Vec<(String, f64)>,
    },
    /// Add a row, with the errors that the table has at its position, to 0.001 µm (µrad).
    Insert {
        /// Axis of the table.
        axis: Axis,
        /// Position in mm or degrees.
        position: f64,
    },
    /// Remove a row.
    Remove {
        /// Axis of the table.
        axis: Axis,
        /// Row, from 0.
        row: usize,
    },
    /// Set a key of `machine.toml` by its full name, like `axis.X.backlash_um`; without a value the key is removed, so that
    /// its default applies.
    Key {
        /// Full name.
        key: String,
        /// New value.
        value: Option<Setting>,
    },
}

/// A value of `machine.toml`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Setting {
    /// A number.
    Number(f64),
    /// A list of numbers.
    Numbers(Vec<f64>),
    /// A word.
    Word(String),
    /// True or false.
    Truth(bool),
}

impl From<&Setting> for Value {
    fn from(setting: &Setting) -> Value {
        match setting {
            Setting::Number(number) => Value::from(*number),
            Setting::Numbers(numbers) => numbers.iter().copied().collect(),
            Setting::Word(word) => Value::from(word.as_str()),
            Setting::Truth(truth) => Value::from(*truth),
        }
    }
}

/// The files after a change; `name` is that of the `machine.toml`. The result is checked as [`Machine::read`] does. Nothing is
/// written.
///
/// # Errors
/// No such table, column or row; a machine that the controller would refuse.
pub fn change(files: &dyn Source, name: &Path, change: &Change) -> Result<Edited, FileError> {
    changes(files, name, std::slice::from_ref(change))
}

/// The files after several changes, one after the other, of which only the result is checked: on the way to it, a table may
/// be one that the controller would refuse.
///
/// # Errors
/// As [`change`]; a row to insert into a table that the changes before it have made unreadable.
pub fn changes(files: &dyn Source, name: &Path, changes: &[Change]) -> Result<Edited, FileError> {
    let mut edited: Vec<(PathBuf, String)> = Vec::new();
    for change in changes {
        let changed = Memory::new(edited.iter().map(|(file, text)| (file, text.as_str())));
        let (file, text) = changed_file(&Edit { changed, beneath: files }, name, change)?;
        edited.retain(|(own, _)| *own != file);
        edited.push((file, text));
    }
    let changed = Memory::new(edited.iter().map(|(file, text)| (file, text.as_str())));
    Machine::read_from(&Edit { changed, beneath: files }, name, &mut |_| {})?;
    Ok(Edited { files: edited, notes: Vec::new() })
}

/// The file that a change concerns, and its text after it; the machine is not checked.
fn changed_file(files: &dyn Source, name: &Path, change: &Change) -> Result<(PathBuf, String), FileError> {
    let edited = match change {
        Change::Key { key, value } => key_set(files, name, key, value.as_ref())?,
        Change::Point { axis, .. } | Change::Insert { axis, .. } | Change::Remove { axis, .. } => {
            let origin = Origin::new(&files.path(name));
            let tables = table_texts(files, name)?;
            let table = tables.into_iter().find(|table| table.axis == *axis).ok_or_else(|| {
                origin.whole(format!("no table of axis {}", axis.letter()), "one, to change a point of it")
            })?;
            let file = Origin::new(&files.path(&table.path));
            let text = match change {
                Change::Point { column, row, value, also, .. } => {
                    let all = std::iter::once((column.as_str(), *value));
                    let others = also.iter().map(|(column, value)| (column.as_str(), *value));
                    all.chain(others).try_fold(table.text.clone(), |text, (column, value)| {
                        point(&table, &text, &file, column, *row, value)
                    })?
                }
                Change::Insert { position, .. } => {
                    let machine = Machine::read_from(files, name, &mut |_| {})?;
                    inserted(&table, &machine, *position)
                }
                Change::Remove { row, .. } => removed(&table, &file, *row)?,
                Change::Key { .. } => table.text.clone(),
            };
            (table.path, text)
        }
    };
    Ok(edited)
}

fn point(
    table: &TableText,
    text: &str,
    origin: &Origin,
    column: &str,
    row: usize,
    value: f64,
) -> Result<String, FileError> {
    let names = || table.columns.iter().map(|column| column.name.as_str()).collect::<Vec<_>>().join(" ");
    let index = table.columns.iter().position(|known| known.name == column);
    let index = index.ok_or_else(|| origin.whole(format!("no column {column:?}"), format!("one of {}", names())))?;
    let first = row_line(table, origin, row)?;
    let mut text = with_field(table, text, first, index, value);
    // Both ends of a full circle are one point.
    let last = table.rows.len() - 1;
    if let Some(position) = table.columns.iter().position(|column| column.component.is_none())
        && position != index
        && (row == 0 || row == last)
        && full_circle(table, position)
        && let Some(other) = table.lines.get(last - row)
    {
        text = with_field(table, &text, *other, index, value);
    }
    Ok(text)
}

/// Whether the table wraps around.
fn full_circle(table: &TableText, position: usize) -> bool {
    let row = |cells: &Vec<f64>| trueaxis::machine::Row {
        position: cells.get(position).copied().unwrap_or_default(),
        forward: [0.0; 6],
        reverse: [0.0; 6],
    };
    wraps(table.axis, table.rows.iter().map(row).collect::<Vec<_>>().as_slice())
}

/// Line number of a row.
fn row_line(table: &TableText, origin: &Origin, row: usize) -> Result<u32, FileError> {
    let needed = || format!("one of its {} rows", table.lines.len());
    table.lines.get(row).copied().ok_or_else(|| origin.whole(format!("row {}", row.saturating_add(1)), needed()))
}

/// The text with a new number in a field of a line.
fn with_field(table: &TableText, text: &str, line: u32, index: usize, value: f64) -> String {
    let lines = (1..).zip(text.split_inclusive('\n'));
    lines
        .map(|(number, old)| if number == line { replaced(table, old, index, value) } else { old.to_owned() })
        .collect()
}

fn replaced(table: &TableText, line: &str, index: usize, value: f64) -> String {
    let Some(Range { start, end }) = fields(line, table.separator).into_iter().nth(index) else {
        return line.to_owned();
    };
    let (before, field, after) = (&line[..start], &line[start..end], &line[end..]);
    format!("{before}{}{after}", written(table, value, field.starts_with('"')))
}

/// A number in the notation of the file.
fn written(table: &TableText, value: f64, quoted: bool) -> String {
    // −0 is written as 0.
    let mut text = (value + 0.0).to_string();
    if table.decimal_commas {
        text = text.replace('.', ",");
    }
    if quoted || text.contains(table.separator) { format!("\"{text}\"") } else { text }
}

/// Ranges of the fields of a line, without the blanks around them.
fn fields(line: &str, separator: char) -> Vec<Range<usize>> {
    let content = line.trim_end_matches(['\n', '\r']);
    let (mut ranges, mut start, mut quoted) = (Vec::new(), 0, false);
    for (at, letter) in content.char_indices().chain([(content.len(), separator)]) {
        if letter == '"' {
            quoted = !quoted;
        }
        if at == content.len() || (letter == separator && !quoted) {
            let field = &content[start..at];
            let from = start + (field.len() - field.trim_start().len());
            ranges.push(from..from + field.trim().len());
            start = at + letter.len_utf8();
        }
    }
    ranges
}

fn inserted(table: &TableText, machine: &Machine, position: f64) -> String {
    let column = table.columns.iter().position(|column| column.component.is_none()).unwrap_or(0);
    let at = |cells: &Vec<f64>| cells.get(column).copied().unwrap_or_default();
    let next = table.rows.iter().position(|cells| at(cells) >= position);
    let value = |component: usize, reverse: bool| {
        let (settings, rows) = (machine.settings.axis(table.axis)?, machine.rows(table.axis)?);
        let error = Curve::new(settings, rows, component, reverse).at(position)?;
        Some((error * if component < 3 { 1e6 } else { 1e9 }).round() / 1e3)
    };
    let cells = table.columns.iter().enumerate().map(|(index, column)| {
        let error = match column.component {
            // An uncertainty column takes the value of the adjacent row.
            Some(_) if !column.forward && !column.reverse => {
                let neighbour = next.unwrap_or(table.rows.len().saturating_sub(1));
                table.rows.get(neighbour).and_then(|cells| cells.get(index)).copied()
            }
            component => component.and_then(|component| value(component, !column.forward)),
        };
        written(table, error.unwrap_or(position), false)
    });
    let line = cells.collect::<Vec<_>>().join(&table.separator.to_string());
    let end = if table.text.contains("\r\n") { "\r\n" } else { "\n" };
    match next.and_then(|row| table.lines.get(row)) {
        Some(before) => {
            let lines = (1..).zip(table.text.split_inclusive('\n'));
            lines
                .map(|(number, old)| if number == *before { format!("{line}{end}{old}") } else { old.to_owned() })
                .collect()
        }
        None if table.text.ends_with('\n') => format!("{}{line}{end}", table.text),
        None => format!("{}{end}{line}", table.text),
    }
}

fn removed(table: &TableText, origin: &Origin, row: usize) -> Result<String, FileError> {
    let line = row_line(table, origin, row)?;
    let lines = (1..).zip(table.text.split_inclusive('\n'));
    Ok(lines.filter(|(number, _)| *number != line).map(|(_, line)| line).collect())
}

fn key_set(
    files: &dyn Source,
    name: &Path,
    key: &str,
    value: Option<&Setting>,
) -> Result<(PathBuf, String), FileError> {
    let origin = Origin::new(&files.path(name));
    let before = read::text(files, name)?;
    let mut document = editable(&before, &origin)?;
    let (sections, last) = key.rsplit_once('.').unwrap_or(("", key));
    let mut section: &mut dyn TableLike = document.as_table_mut();
    let mut made = sections.split('.').filter(|name| !name.is_empty()).peekable();
    while let Some(name) = made.next() {
        let is_last = made.peek().is_none();
        let new = || {
            let mut table = toml_edit::Table::new();
            table.set_implicit(!is_last);
            Item::Table(table)
        };
        let refused = || origin.at(0, key, format!("{name} that is not a section"), format!("a section [{sections}]"));
        section = section.entry(name).or_insert_with(new).as_table_like_mut().ok_or_else(refused)?;
    }
    match value {
        Some(value) => set(section, last, value.into()),
        None => drop(section.remove(last)),
    }
    if matches!(value, None | Some(Setting::Number(0.0))) {
        forget(&mut document, key);
    }
    Ok((name.into(), as_before(document.to_string(), &before)))
}
