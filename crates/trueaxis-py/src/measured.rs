//! What was measured: a file as the command line reads it, or an array.

use crate::arrays;
use pyo3::prelude::*;
use std::borrow::Cow;
use std::fmt::Write;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use trueaxis_evaluation::rows::{Column, Rows};

/// A file, or an array as the text of one: what reads it says the line of what is wrong.
pub(crate) enum Measured {
    File(PathBuf),
    Text { name: &'static str, text: String },
}

impl Measured {
    /// A path, or an array with the columns of one of these forms, which differ in number.
    pub(crate) fn of(given: &Bound<'_, PyAny>, name: &'static str, forms: &[&[&str]]) -> PyResult<Measured> {
        if let Ok(path) = given.extract::<PathBuf>() {
            return Ok(Measured::File(path));
        }
        let widths: Vec<usize> = forms.iter().map(|columns| columns.len()).collect();
        let (width, values) = arrays::rows(given, name, &widths)?;
        let columns = forms.iter().find(|columns| columns.len() == width).copied().unwrap_or_default();
        let mut text = columns.join(",");
        for row in values.chunks_exact(width) {
            for (i, value) in row.iter().enumerate() {
                let _ = write!(text, "{}{value}", if i == 0 { '\n' } else { ',' });
            }
        }
        Ok(Measured::Text { name, text })
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
            Measured::File(path) => Box::new(File::open(path).map_err(|error| unreadable(path, &error))?),
            Measured::Text { text, .. } => Box::new(text.as_bytes()),
        };
        Rows::new(input, self.name(), columns, |note| notes.push(note))
    }

    /// All of it.
    pub(crate) fn bytes(&self) -> anyhow::Result<Cow<'_, [u8]>> {
        match self {
            Measured::File(path) => Ok(std::fs::read(path).map_err(|error| unreadable(path, &error))?.into()),
            Measured::Text { text, .. } => Ok(text.as_bytes().into()),
        }
    }
}

fn unreadable(path: &Path, error: &std::io::Error) -> anyhow::Error {
    anyhow::anyhow!("cannot read {}: {error}", path.display())
}
