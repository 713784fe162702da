//! Trace of a run: rounded in CSV, or unrounded in Apache Parquet.

use std::io::{self, Write};
use trueaxis::machine::MachineSettings;
use trueaxis_columnar::{Form, Value, Writer};
use trueaxis_sim::run::{Column, Kind, Moment, Sample, Sink, columns};

/// Writes a row every `every` cycles, in order.
pub struct Trace<W: Write + Send> {
    rows: Rows<W>,
    every: u64,
    /// Index of the run in [`Kind::ALL`].
    run: usize,
    columns: Vec<Column>,
    failure: Option<io::Error>,
}

enum Rows<W: Write + Send> {
    /// Rounded to each column's decimals.
    Csv(W),
    /// Not rounded; columns of whole numbers as integers.
    Parquet(Box<Writer<W>>),
}

impl<W: Write + Send> Trace<W> {
    /// Begins the file. A row is written in every `every`th cycle of the run of that kind, with the columns of [`columns`].
    ///
    /// # Errors
    /// The writer fails.
    pub fn new(mut out: W, form: Form, every: u64, kind: Kind, machine: &MachineSettings) -> io::Result<Trace<W>> {
        let columns = columns(kind, machine);
        let rows = match form {
            Form::Csv => {
                let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
                writeln!(out, "{}", names.join(","))?;
                Rows::Csv(out)
            }
            Form::Parquet => Rows::Parquet(Box::new(Writer::new(out, form, &typed(&columns))?)),
        };
        let run = Kind::ALL.iter().position(|of| *of == kind).unwrap_or(Kind::ALL.len());
        Ok(Trace { rows, every: every.max(1), run, columns, failure: None })
    }

    fn row(&mut self, moment: &Moment, sample: &Sample) -> io::Result<()> {
        match &mut self.rows {
            Rows::Csv(out) => {
                let mut between = "";
                for column in &self.columns {
                    write!(out, "{between}{:.*}", column.decimals, column.value(moment, sample))?;
                    between = ",";
                }
                writeln!(out)
            }
            Rows::Parquet(table) => table.row(self.columns.iter().map(|column| {
                let value = column.value(moment, sample);
                if column.decimals == 0 { Value::Whole(value as i64) } else { Value::Number(value) }
            })),
        }
    }

    /// Returns the writer.
    ///
    /// # Errors
    /// A write failed.
    pub fn finish(self) -> io::Result<W> {
        match (self.failure, self.rows) {
            (Some(error), _) => Err(error),
            (None, Rows::Csv(mut out)) => out.flush().map(|()| out),
            (None, Rows::Parquet(table)) => table.finish(),
        }
    }
}

/// The columns with the types of a typed table.
fn typed(columns: &[Column]) -> Vec<trueaxis_columnar::Column> {
    use trueaxis_columnar::{Column, Kind};
    let kind = |decimals: usize| if decimals == 0 { Kind::Whole } else { Kind::Number };
    columns.iter().map(|column| Column::new(&column.name, kind(column.decimals))).collect()
}

impl<W: Write + Send> Sink for Trace<W> {
    /// Stores a write error for [`Trace::finish`].
    fn cycle(&mut self, moment: &Moment, runs: &[Option<&Sample>]) {
        if moment.cycle.is_multiple_of(self.every)
            && self.failure.is_none()
            && let Some(Some(sample)) = runs.get(self.run)
        {
            self.failure = self.row(moment, sample).err();
        }
    }
}
