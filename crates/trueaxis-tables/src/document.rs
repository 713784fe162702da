//! Edits `machine.toml` while keeping the text around a changed value, together with the files that change with it.

use crate::error::FileError;
use crate::origin::Origin;
use std::path::PathBuf;
use toml_edit::{DocumentMut, Item, TableLike, Value};
use trueaxis::machine::Axis;

/// Changes that an import makes to an existing machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edited {
    /// The files that change, by their name in the source, with their new text; `machine.toml` last, and only if it changes.
    pub files: Vec<(PathBuf, String)>,
    /// Everything added, replaced, set, or kept although the file differs; one sentence each.
    pub notes: Vec<String>,
}

/// Parses a text as a document, without its byte order mark.
pub(crate) fn editable(text: &str, origin: &Origin) -> Result<DocumentMut, FileError> {
    text.strip_prefix('\u{feff}')
        .unwrap_or(text)
        .parse::<DocumentMut>()
        .map_err(|error| origin.whole(error.message().to_owned(), "a TOML file that can be edited"))
}

/// A text with the line ends and the byte order mark of the previous one.
pub(crate) fn as_before(mut text: String, before: &str) -> String {
    if before.contains("\r\n") && !text.contains("\r\n") {
        text = text.replace('\n', "\r\n");
    }
    if before.starts_with('\u{feff}') {
        text.insert(0, '\u{feff}');
    }
    text
}

/// The section of an axis, created if absent.
pub(crate) fn section<'d>(
    document: &'d mut DocumentMut,
    axis: Axis,
    origin: &Origin,
) -> Result<&'d mut dyn TableLike, FileError> {
    let no_section = || origin.whole("an axis that is not a section", "[axis.…] sections");
    let axes = document.entry("axis").or_insert_with(|| {
        let mut axes = toml_edit::Table::new();
        axes.set_implicit(true);
        Item::Table(axes)
    });
    let axes = axes.as_table_like_mut().ok_or_else(no_section)?;
    let letter = axis.letter().to_string();
    axes.entry(&letter).or_insert_with(toml_edit::table).as_table_like_mut().ok_or_else(no_section)
}

/// Sets a key and keeps the text around its value.
pub(crate) fn set(section: &mut dyn TableLike, key: &str, mut value: Value) {
    match section.get_mut(key).and_then(Item::as_value_mut) {
        Some(old) => {
            if same(old, &value) {
                return;
            }
            *value.decor_mut() = old.decor().clone();
            *old = value;
        }
        None => {
            section.insert(key, Item::Value(value));
        }
    }
}

/// Whether two values are equal, however they are written.
pub(crate) fn same(a: &Value, b: &Value) -> bool {
    let number = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64));
    match (a, b) {
        (Value::String(a), Value::String(b)) => a.value() == b.value(),
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b)),
        _ => match (number(a), number(b)) {
            (Some(a), Some(b)) => a == b,
            _ => a.to_string().trim() == b.to_string().trim(),
        },
    }
}
