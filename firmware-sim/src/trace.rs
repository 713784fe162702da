//! Trace of a run, as CSV or as columns.

use std::io::{self, Write};
use trueaxis::machine::MachineSettings;
use trueaxis_columns::{Form, Value, Writer};
use trueaxis_sim::run::{Column, Kind, Moment, Sample, Sink, columns};

/// Writes a line every so many cycles, as they come.
#[derive(Debug)]
pub struct Trace<W> {
    out: W,
    every: u64,
    /// Index of the run in [`Kind::ALL`].
    run: usize,
    columns: Vec<Column>,
    failure: Option<io::Error>,
}

impl<W: Write> Trace<W> {
    /// Writes the header. A line is written in every `every`th cycle of the run of that kind, with the columns of
    /// [`columns`].
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn new(mut out: W, every: u64, kind: Kind, machine: &MachineSettings) -> io::Result<Trace<W>> {
        let columns = columns(kind, machine);
        let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        writeln!(out, "{}", names.join(","))?;
        Ok(Trace { out, every: every.max(1), run: place(kind), columns, failure: None })
    }

    fn row(&mut self, moment: &Moment, sample: &Sample) -> io::Result<()> {
        let mut between = "";
        for column in &self.columns {
            write!(self.out, "{between}{:.*}", column.decimals, column.value(moment, sample))?;
            between = ",";
        }
        writeln!(self.out)
    }

    /// Hands back what was written to.
    ///
    /// # Errors
    /// Something could not be written.
    pub fn finish(mut self) -> io::Result<W> {
        match self.failure.take() {
            Some(error) => Err(error),
            None => self.out.flush().map(|()| self.out),
        }
    }
}

/// The same columns as Apache Parquet, not rounded; those of whole numbers as integers.
pub struct ColumnTrace<W: Write + Send> {
    out: Writer<W>,
    every: u64,
    run: usize,
    columns: Vec<Column>,
    failure: Option<io::Error>,
}

impl<W: Write + Send> ColumnTrace<W> {
    /// Begins the file; else as [`Trace::new`].
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn new(out: W, every: u64, kind: Kind, machine: &MachineSettings) -> io::Result<ColumnTrace<W>> {
        let columns = columns(kind, machine);
        let kinds = columns.iter().map(|column| {
            let whole = column.decimals == 0;
            let of = if whole { trueaxis_columns::Kind::Whole } else { trueaxis_columns::Kind::Number };
            trueaxis_columns::Column::new(&column.name, of)
        });
        let out = Writer::new(out, Form::Parquet, &kinds.collect::<Vec<_>>())?;
        Ok(ColumnTrace { out, every: every.max(1), run: place(kind), columns, failure: None })
    }

    /// Writes what is left, and hands back what was written to.
    ///
    /// # Errors
    /// Something could not be written.
    pub fn finish(self) -> io::Result<W> {
        match self.failure {
            Some(error) => Err(error),
            None => self.out.finish(),
        }
    }
}

impl<W: Write + Send> Sink for ColumnTrace<W> {
    /// A failure to write is kept for [`ColumnTrace::finish`].
    fn cycle(&mut self, moment: &Moment, runs: &[Option<&Sample>]) {
        if moment.cycle.is_multiple_of(self.every)
            && self.failure.is_none()
            && let Some(Some(sample)) = runs.get(self.run)
        {
            let values = self.columns.iter().map(|column| match column.value(moment, sample) {
                value if column.decimals == 0 => Value::Whole(value as i64),
                value => Value::Number(value),
            });
            self.failure = self.out.row(values).err();
        }
    }
}

/// Index of a run in [`Kind::ALL`].
fn place(kind: Kind) -> usize {
    Kind::ALL.iter().position(|of| *of == kind).unwrap_or(Kind::ALL.len())
}

impl<W: Write> Sink for Trace<W> {
    /// A failure to write is kept for [`Trace::finish`].
    fn cycle(&mut self, moment: &Moment, runs: &[Option<&Sample>]) {
        if moment.cycle.is_multiple_of(self.every)
            && self.failure.is_none()
            && let Some(Some(sample)) = runs.get(self.run)
        {
            self.failure = self.row(moment, sample).err();
        }
    }
}
