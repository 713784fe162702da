//! The contour error of one part, recorded over path length, from which the correction for the next part is learned.
//!
//! The mathematics is in [`trueaxis_metrology::learning`].

mod document;
mod record;

pub use document::{LearnDocument, Size};
pub use record::{COLUMNS, Record};

use anyhow::{Context, Result};
use std::path::Path;
use trueaxis::learned::Learned;
use trueaxis_metrology::learning::{Law, Lesson};

/// Learns from a record and from the correction that acted on the part, the content of a `.tlearn` with its path; returns the
/// document, the lesson, and the bytes of the correction for the next part. The caller must check the law.
///
/// # Errors
/// A correction of another machine or program; a record that does not reach over the path, or from which nothing can be
/// learned.
pub fn learned(law: Law, record: &Record, table: Option<(&Path, &[u8])>) -> Result<(LearnDocument, Lesson, Vec<u8>)> {
    let old =
        table.map(|(path, bytes)| belonging(bytes, record).with_context(|| format!("--table {}", path.display())));
    let old = old.transpose()?;
    let lesson = Lesson::learn(&law, &record.identity, old.as_ref(), &record.rows)
        .map_err(|refused| record.refused(&refused))?;
    let file = lesson.to_bytes().map_err(|refused| record.refused(&refused))?;
    Ok((LearnDocument::new(record, law, &lesson), lesson, file))
}

/// Parses a correction that must belong to the record's program and machine.
fn belonging<'b>(bytes: &'b [u8], record: &Record) -> Result<Learned<'b, f64>> {
    let learned = Learned::parse(bytes)?;
    learned.expect_machine(record.identity.machine_id)?;
    learned.expect_program(record.identity.program_id, record.identity.length_mm)?;
    Ok(learned)
}
