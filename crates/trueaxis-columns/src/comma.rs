//! Comma-separated values.

use crate::{Column, Value};
use std::io::{self, Write};

pub(crate) struct File<W: Write> {
    out: csv::Writer<W>,
}

impl<W: Write> File<W> {
    pub(crate) fn new(out: W, columns: &[Column]) -> io::Result<File<W>> {
        let mut out = csv::Writer::from_writer(out);
        out.write_record(columns.iter().map(|column| &column.name))?;
        Ok(File { out })
    }

    pub(crate) fn put(&mut self, value: Value<'_>) -> io::Result<()> {
        let written = match value {
            Value::Number(value) => self.out.write_field(value.to_string()),
            Value::Whole(value) => self.out.write_field(value.to_string()),
            Value::Text(value) => self.out.write_field(value),
        };
        Ok(written?)
    }

    pub(crate) fn end_row(&mut self) -> io::Result<()> {
        Ok(self.out.write_record(None::<&[u8]>)?)
    }

    pub(crate) fn finish(self) -> io::Result<W> {
        self.out.into_inner().map_err(|error| error.into_error())
    }
}
