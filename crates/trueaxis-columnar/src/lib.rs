#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod comma;
#[cfg(feature = "parquet")]
mod parquet_file;

use std::io::{self, Write};
use std::path::Path;

/// Type of a column. A column has no nulls: a missing number is a NaN.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Real numbers, Parquet's `DOUBLE`.
    Number,
    /// Whole numbers, `INT64`.
    Whole,
    /// Text, `STRING`.
    Text,
}

/// A column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Name, with the unit if it has one (`error_um`); no two columns of a table have the same.
    pub name: String,
    /// Type of the column's values.
    pub kind: Kind,
}

impl Column {
    /// Creates a column with that name.
    pub fn new(name: impl Into<String>, kind: Kind) -> Column {
        Column { name: name.into(), kind }
    }
}

/// A value in a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// A value of a number column.
    Number(f64),
    /// A value of a column of whole numbers.
    Whole(i64),
    /// A value of a text column.
    Text(&'a str),
}

impl Value<'_> {
    fn kind(&self) -> Kind {
        match self {
            Value::Number(_) => Kind::Number,
            Value::Whole(_) => Kind::Whole,
            Value::Text(_) => Kind::Text,
        }
    }
}

/// File format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Apache Parquet, compressed with Snappy, 65,536 rows per group; needs the feature `parquet`.
    Parquet,
    /// Comma-separated values under a header; numbers with the digits that represent them exactly.
    Csv,
}

impl Form {
    /// The form for a file's extension, `.parquet` or `.csv`.
    pub fn of(path: &Path) -> Option<Form> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "parquet" => Some(Form::Parquet),
            "csv" => Some(Form::Csv),
            _ => None,
        }
    }
}

/// Whether this build can write Parquet (feature `parquet`).
pub const PARQUET: bool = cfg!(feature = "parquet");

enum Out<W: Write + Send> {
    #[cfg(feature = "parquet")]
    Parquet(Box<parquet_file::File<W>>),
    Csv(Box<comma::File<W>>),
}

/// Writes a table row by row. Equal rows give equal bytes.
pub struct Writer<W: Write + Send> {
    out: Out<W>,
    columns: Vec<Column>,
}

impl<W: Write + Send> Writer<W> {
    /// Creates a table with these columns.
    ///
    /// # Errors
    /// Errors of the writer; [`io::ErrorKind::InvalidInput`] without a column, or if two have one name;
    /// [`io::ErrorKind::Unsupported`] for Parquet without its feature.
    pub fn new(out: W, form: Form, columns: &[Column]) -> io::Result<Writer<W>> {
        let twice =
            columns.iter().enumerate().find(|(k, column)| columns[..*k].iter().any(|of| of.name == column.name));
        if let Some((_, column)) = twice {
            return Err(refused(format!("found two columns {}, needed one", column.name)));
        }
        if columns.is_empty() {
            return Err(refused("found no column, needed one".into()));
        }
        let out = match form {
            #[cfg(feature = "parquet")]
            Form::Parquet => Out::Parquet(Box::new(parquet_file::File::new(out, columns)?)),
            #[cfg(not(feature = "parquet"))]
            Form::Parquet => return Err(io::Error::new(io::ErrorKind::Unsupported, "built without Parquet")),
            Form::Csv => Out::Csv(Box::new(comma::File::new(out, columns)?)),
        };
        Ok(Writer { out, columns: columns.to_vec() })
    }

    /// Writes a row: one value per column, in order.
    ///
    /// # Errors
    /// Errors of the writer; [`io::ErrorKind::InvalidInput`] for too many or too few values, or a value of another kind
    /// than its column. The table must not be used after that.
    pub fn row<'v>(&mut self, values: impl IntoIterator<Item = Value<'v>>) -> io::Result<()> {
        let mut values = values.into_iter();
        for (at, column) in self.columns.iter().enumerate() {
            let Some(value) = values.next() else {
                return Err(refused(format!("found {at} values, needed {}", self.columns.len())));
            };
            if value.kind() != column.kind {
                return Err(refused(format!("column {}: found {value:?}, needed {:?}", column.name, column.kind)));
            }
            match &mut self.out {
                #[cfg(feature = "parquet")]
                Out::Parquet(file) => file.put(at, value),
                Out::Csv(file) => file.put(value)?,
            }
        }
        if values.next().is_some() {
            return Err(refused(format!("found more values than {}", self.columns.len())));
        }
        match &mut self.out {
            #[cfg(feature = "parquet")]
            Out::Parquet(file) => file.end_row(),
            Out::Csv(file) => file.end_row(),
        }
    }

    /// Writes the remaining rows and returns the writer.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn finish(self) -> io::Result<W> {
        match self.out {
            #[cfg(feature = "parquet")]
            Out::Parquet(file) => file.finish(),
            Out::Csv(file) => file.finish(),
        }
    }
}

fn refused(why: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, why)
}
