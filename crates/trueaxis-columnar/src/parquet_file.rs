//! Apache Parquet, by arrow's crate.

use super::{Column, Kind, Value};
use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::io::{self, Write};
use std::mem::take;
use std::sync::Arc;

/// Rows collected and compressed together.
const GROUP: usize = 1 << 16;

enum Kept {
    Number(Vec<f64>),
    Whole(Vec<i64>),
    Text(Vec<ByteArray>),
}

pub(super) struct File<W: Write + Send> {
    out: SerializedFileWriter<W>,
    kept: Vec<Kept>,
    rows: usize,
}

impl<W: Write + Send> File<W> {
    pub(super) fn new(out: W, columns: &[Column]) -> io::Result<File<W>> {
        let fields = columns.iter().map(|column| {
            let (physical, logical) = match column.kind {
                Kind::Number => (Physical::DOUBLE, None),
                Kind::Whole => (Physical::INT64, None),
                Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            };
            let field = Type::primitive_type_builder(&column.name, physical).with_logical_type(logical);
            Ok(Arc::new(field.with_repetition(Repetition::REQUIRED).build().map_err(failed)?))
        });
        let fields = fields.collect::<io::Result<_>>()?;
        let schema = Type::group_type_builder("trueaxis").with_fields(fields).build().map_err(failed)?;
        let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
        let out = SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties)).map_err(failed)?;
        let kept = columns.iter().map(|column| match column.kind {
            Kind::Number => Kept::Number(Vec::new()),
            Kind::Whole => Kept::Whole(Vec::new()),
            Kind::Text => Kept::Text(Vec::new()),
        });
        Ok(File { out, kept: kept.collect(), rows: 0 })
    }

    /// The caller has compared the kinds.
    pub(super) fn put(&mut self, column: usize, value: Value<'_>) {
        match (&mut self.kept[column], value) {
            (Kept::Number(kept), Value::Number(value)) => kept.push(value),
            (Kept::Whole(kept), Value::Whole(value)) => kept.push(value),
            (Kept::Text(kept), Value::Text(value)) => kept.push(value.into()),
            _ => {}
        }
    }

    pub(super) fn end_row(&mut self) -> io::Result<()> {
        self.rows += 1;
        if self.rows == GROUP { self.write_group() } else { Ok(()) }
    }

    fn write_group(&mut self) -> io::Result<()> {
        let mut group = self.out.next_row_group().map_err(failed)?;
        for kept in &mut self.kept {
            let Some(mut column) = group.next_column().map_err(failed)? else { break };
            let written = match kept {
                Kept::Number(kept) => column.typed::<DoubleType>().write_batch(&take(kept), None, None),
                Kept::Whole(kept) => column.typed::<Int64Type>().write_batch(&take(kept), None, None),
                Kept::Text(kept) => column.typed::<ByteArrayType>().write_batch(&take(kept), None, None),
            };
            written.and_then(|_| column.close()).map_err(failed)?;
        }
        group.close().map_err(failed)?;
        self.rows = 0;
        Ok(())
    }

    pub(super) fn finish(mut self) -> io::Result<W> {
        if self.rows > 0 {
            self.write_group()?;
        }
        self.out.into_inner().map_err(failed)
    }
}

/// Keeps the kind of an I/O error, such as a full disk.
fn failed(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(error) => match error.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(error) => io::Error::other(error),
        },
        error => io::Error::other(error),
    }
}
