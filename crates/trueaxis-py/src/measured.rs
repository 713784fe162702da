//! Measurements: a file that the command line reads, by its path or open, or an array.

use crate::{Error, arrays, units};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::borrow::Cow;
use std::fmt::Write;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use trueaxis_evaluation::rows::{Column, Rows};
use trueaxis_tables::text::{decode, read_text};

/// First characters of comments, which may be in any encoding.
const COMMENTS: [char; 2] = ['#', ';'];

/// A file, or an array converted to the text of a file, so that errors name the line.
pub(crate) enum Measured {
    File(PathBuf),
    Text { name: &'static str, text: String },
}

impl Measured {
    /// Accepts a path or an object with a method `read`, which gives text or bytes; `None` for anything else.
    fn of_file(given: &Bound<'_, PyAny>, name: &'static str) -> PyResult<Option<Measured>> {
        if let Ok(path) = given.extract::<PathBuf>() {
            return Ok(Some(Measured::File(path)));
        }
        if !given.hasattr("read")? {
            return Ok(None);
        }
        let content = given.call_method0("read")?;
        let bytes = match content.extract::<String>() {
            Ok(text) => text.into_bytes(),
            Err(_) => content.extract::<Vec<u8>>().map_err(|_| {
                let found = content.get_type();
                PyTypeError::new_err(format!("{name}: read() gave {found}, needed text or bytes"))
            })?,
        };
        let text = decode(bytes, Path::new(name), &COMMENTS).map_err(|error| Error::new_err(error.to_string()))?;
        Ok(Some(Measured::Text { name, text }))
    }

    /// Accepts a path or file object, or an array or data frame with the columns of one of `forms`; their number distinguishes the forms.
    pub(crate) fn of(given: &Bound<'_, PyAny>, name: &'static str, forms: &[&[&str]]) -> PyResult<Measured> {
        if let Some(file) = Measured::of_file(given, name)? {
            return Ok(file);
        }
        let (width, values) = arrays::named(&units::framed(given, name, forms)?, name, forms)?;
        let columns = forms.iter().find(|columns| columns.len() == width).copied().unwrap_or_default();
        let mut text = columns.join(",");
        for row in values.chunks_exact(width) {
            for (i, value) in row.iter().enumerate() {
                let _ = write!(text, "{}{value}", if i == 0 { '\n' } else { ',' });
            }
        }
        Ok(Measured::Text { name, text })
    }

    /// Accepts a path or file object, or a dict or data frame with columns of equal length; its rows count from line 2.
    pub(crate) fn of_columns(given: &Bound<'_, PyAny>, name: &'static str, known: &[Column]) -> PyResult<Measured> {
        if let Some(file) = Measured::of_file(given, name)? {
            return Ok(file);
        }
        let columns: Vec<&str> = known.iter().map(|column| column.name).collect();
        let given = &units::framed(given, name, &[&columns])?;
        let keys = match given.cast::<PyDict>() {
            Ok(dict) => dict.keys().extract()?,
            Err(_) if arrays::is_frame(given)? => arrays::columns_of(given)?,
            Err(_) => {
                let found = given.get_type().name()?;
                let needed = "a path, a file object, or a dict or data frame of columns";
                return Err(PyTypeError::new_err(format!("{name}: found {found}, needed {needed}")));
            }
        };
        let (mut names, mut columns): (Vec<String>, Vec<Vec<f64>>) = Default::default();
        for key in keys {
            let values = given.get_item(&key)?;
            if !known.iter().any(|column| column.name == key) {
                let names: Vec<&str> = known.iter().map(|column| column.name).collect();
                return Err(Error::new_err(format!(
                    "{name}: found column {key:?}, needed some of {}",
                    names.join(", ")
                )));
            }
            let rows = columns.first().map_or(values.len().unwrap_or(1), Vec::len);
            columns.push(arrays::column(&values, &key, rows, names.first().map_or(key.as_str(), String::as_str))?);
            names.push(key);
        }
        let mut text = names.join(",");
        for row in 0..columns.first().map_or(0, Vec::len) {
            for (i, value) in columns.iter().filter_map(|column| column.get(row)).enumerate() {
                let _ = write!(text, "{}{value}", if i == 0 { '\n' } else { ',' });
            }
        }
        Ok(Measured::Text { name, text })
    }

    /// Accepts a path or file object, or a dict or data frame with columns of any names and of words too, such as the sign of a direction.
    pub(crate) fn of_words(given: &Bound<'_, PyAny>, name: &'static str) -> PyResult<Measured> {
        if let Some(file) = Measured::of_file(given, name)? {
            return Ok(file);
        }
        let is_dict = given.is_instance_of::<PyDict>();
        if !is_dict && !arrays::is_frame(given)? {
            let found = given.get_type().name()?;
            let needed = "a path, a file object, or a dict or data frame of columns";
            return Err(PyTypeError::new_err(format!("{name}: found {found}, needed {needed}")));
        }
        let keys = if is_dict { given.clone() } else { given.getattr("columns")? };
        let (mut names, mut columns): (Vec<String>, Vec<Vec<String>>) = Default::default();
        for key in keys.try_iter()? {
            let key = key?;
            let cells = given.get_item(&key)?;
            let cells =
                cells.try_iter()?.map(|cell| Ok(cell?.str()?.to_string())).collect::<PyResult<Vec<String>>>()?;
            if let Some(first) = columns.first().filter(|first: &&Vec<String>| first.len() != cells.len()) {
                let found = format!("{name}: found {} rows of {key} and {} of {}", cells.len(), first.len(), names[0]);
                return Err(Error::new_err(format!("{found}, needed columns of equal length")));
            }
            names.push(key.str()?.to_string());
            columns.push(cells);
        }
        if let Some(found) =
            names.iter().chain(columns.iter().flatten()).find(|cell| cell.contains([',', '"', '\n', '#']))
        {
            return Err(Error::new_err(format!("{name}: found {found:?}, needed names and values without , \" and #")));
        }
        let mut text = names.join(",");
        for row in 0..columns.first().map_or(0, Vec::len) {
            let cells: Vec<&str> = columns.iter().filter_map(|column| column.get(row).map(String::as_str)).collect();
            text += &format!("\n{}", cells.join(","));
        }
        Ok(Measured::Text { name, text })
    }

    /// The whole text of the measurements.
    pub(crate) fn text(&self) -> anyhow::Result<Cow<'_, str>> {
        match self {
            Measured::File(path) => Ok(read_text(path, &COMMENTS)?.into()),
            Measured::Text { text, .. } => Ok(text.into()),
        }
    }

    pub(crate) fn name(&self) -> &Path {
        match self {
            Measured::File(path) => path,
            Measured::Text { name, .. } => Path::new(name),
        }
    }

    pub(crate) fn rows<'r, const C: usize>(
        &'r self,
        columns: &[Column; C],
        notes: &'r mut Vec<String>,
    ) -> anyhow::Result<Rows<'r, C>> {
        let input: Box<dyn Read + 'r> = match self {
            Measured::File(path) => Box::new(File::open(path).map_err(|error| unreadable(path, error))?),
            Measured::Text { text, .. } => Box::new(text.as_bytes()),
        };
        Rows::new(input, self.name(), columns, |note| notes.push(note))
    }

    /// All bytes of the measurements.
    pub(crate) fn bytes(&self) -> anyhow::Result<Cow<'_, [u8]>> {
        match self {
            Measured::File(path) => Ok(std::fs::read(path).map_err(|error| unreadable(path, error))?.into()),
            Measured::Text { text, .. } => Ok(text.as_bytes().into()),
        }
    }
}

/// Rows of a dict or data frame that has exactly these columns, in the order of `names`.
pub(crate) fn columns_of_table(given: &Bound<'_, PyAny>, name: &str, names: &[&str]) -> PyResult<Vec<Vec<f64>>> {
    let given = &units::framed(given, name, &[names])?;
    let keys: Vec<String> = match given.cast::<PyDict>() {
        Ok(dict) => dict.keys().extract()?,
        Err(_) if arrays::is_frame(given)? => arrays::columns_of(given)?,
        Err(_) => {
            let found = given.get_type().name()?;
            return Err(PyTypeError::new_err(format!("{name}: found {found}, needed a dict or data frame of columns")));
        }
    };
    if keys.len() != names.len() || !names.iter().all(|name| keys.iter().any(|key| key == name)) {
        return Err(Error::new_err(format!("{name}: found columns {}, needed {}", keys.join(", "), names.join(", "))));
    }
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for key in names {
        let values = given.get_item(key)?;
        let rows = columns.first().map_or(values.len().unwrap_or(1), Vec::len);
        columns.push(arrays::column(&values, key, rows, names.first().copied().unwrap_or(key))?);
    }
    let rows = columns.first().map_or(0, Vec::len);
    Ok((0..rows).map(|row| columns.iter().filter_map(|column| column.get(row).copied()).collect()).collect())
}

fn unreadable(path: &Path, error: std::io::Error) -> anyhow::Error {
    anyhow::Error::new(error).context(format!("cannot read {}", path.display()))
}
