//! Diagonal and step-diagonal displacement tests: a record as a test, and what it tells as a document and as figures.
//!
//! The mathematics is [`trueaxis_metrology::diagonal`].

mod document;
mod shown;

pub use document::{DiagonalFigures, Document, Point, Shape, Steps, Value, additions};

use crate::range::OutOfRange;
use crate::rows::{Column, Rows};
use crate::stuck;
use anyhow::{Result, anyhow};
use trueaxis_metrology::accuracy::Direction;
use trueaxis_metrology::diagonal::{Reading, Refused, Test};

/// Columns of a record.
pub const COLUMNS: [Column; 7] = [
    Column { name: "diagonal", needed: true },
    Column { name: "run", needed: false },
    Column { name: "direction", needed: true },
    Column { name: "x_mm", needed: true },
    Column { name: "y_mm", needed: true },
    Column { name: "z_mm", needed: true },
    Column { name: "deviation_um", needed: true },
];

/// Whether the mirror's alignment is one.
///
/// # Errors
/// Outside 0.001 to 100000 µrad.
pub fn check(alignment_urad: Option<f64>) -> Result<(), OutOfRange> {
    OutOfRange::check("alignment_urad", alignment_urad, 1e-3..=1e5, "µrad")
}

/// Reads all rows of [`COLUMNS`].
///
/// # Errors
/// A row that cannot be read, a diagonal that is not 1 to 4 or is missing, a target a second time, a laser that stands still,
/// lines that are not the four diagonals of a box.
pub fn read(rows: &mut Rows<'_, 7>) -> Result<Test> {
    let (mut lines, mut readings) = (Vec::new(), Vec::new());
    while let Some(row) = rows.next()? {
        let [diagonal, run, direction, x, y, z, deviation_um] = row.values;
        if ![1.0, 2.0, 3.0, 4.0].contains(&diagonal) {
            return Err(rows.error(row.line, "diagonal", diagonal, "1, 2, 3 or 4"));
        }
        if direction == 0.0 {
            return Err(rows.error(row.line, "direction", 0, "1 away from the diagonal's first target, -1 back"));
        }
        if !(0.0..=1e6).contains(&run) || run.fract() != 0.0 {
            return Err(rows.error(row.line, "run", run, "a number from 1"));
        }
        lines.push(row.line);
        readings.push(Reading {
            diagonal: diagonal as usize - 1,
            run: run as u32,
            direction: if direction > 0.0 { Direction::Up } else { Direction::Down },
            position_mm: [x, y, z],
            deviation_mm: 1e-3 * deviation_um,
        });
    }
    let deviations: Vec<f64> = readings.iter().map(|reading| reading.deviation_mm).collect();
    if let Some(stuck) = stuck::longest(&deviations) {
        return Err(stuck.error(rows, &lines, "deviation_um", 1e3));
    }
    Test::new(readings).map_err(|refused| match refused {
        Refused::Twice { index, first } => {
            let [line, before] = [index, first].map(|index| lines.get(index).copied().unwrap_or(1));
            let found = format!("this target a second time in this run and direction, first in line {before}");
            rows.error(line, "deviation_um", found, "each target once a run and direction")
        }
        refused => anyhow!("{}: {refused}", rows.file.display()),
    })
}
