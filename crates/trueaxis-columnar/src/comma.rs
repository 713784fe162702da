//! Comma-separated values.

use super::{Column, Value};
use std::io::{self, Write};

pub(super) struct File<W: Write> {
    out: csv::Writer<W>,
}

impl<W: Write> File<W> {
    pub(super) fn new(out: W, columns: &[Column]) -> io::Result<File<W>> {
        let mut out = csv::Writer::from_writer(out);
        out.write_record(columns.iter().map(|column| &column.name))?;
        Ok(File { out })
    }

    pub(super) fn put(&mut self, value: Value<'_>) -> io::Result<()> {
        let written = match value {
            Value::Number(value) => self.out.write_field(value.to_string()),
            Value::Whole(value) => self.out.write_field(value.to_string()),
            Value::Text(value) => self.out.write_field(value),
        };
        Ok(written?)
    }

    pub(super) fn end_row(&mut self) -> io::Result<()> {
        Ok(self.out.write_record(None::<&[u8]>)?)
    }

    pub(super) fn finish(self) -> io::Result<W> {
        self.out.into_inner().map_err(|error| error.into_error())
    }
}
