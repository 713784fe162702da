//! A circular test: the recorded circle as readings, and what it tells as a document and as figures.
//!
//! The mathematics is [`trueaxis_metrology::ballbar`].

mod document;
mod polar;
mod values;

pub use document::{Document, Pair, Share, Ways, name};
pub use polar::{left, polar};
pub use values::values;

use crate::rows::{Column, Rows};
use anyhow::{Result, anyhow};
use trueaxis_metrology::ballbar::{Evaluation, Reading, Refused, evaluate};

/// Columns of a record: angle of the command, deviation of the radius, direction.
pub const COLUMNS: [Column; 3] = [
    Column { name: "angle_deg", needed: true },
    Column { name: "deviation_um", needed: true },
    Column { name: "direction", needed: true },
];

/// A circular test, evaluated.
#[derive(Clone, Debug)]
pub struct Test {
    /// Nominal radius, mm.
    pub radius_mm: f64,
    /// What the bar read.
    pub readings: Vec<Reading>,
    /// What it tells.
    pub found: Evaluation,
}

impl Test {
    /// Reads all rows of [`COLUMNS`] and evaluates them; `pitches_mm` of X and Y where they are known.
    ///
    /// # Errors
    /// A row that cannot be read, a direction that is 0, a record that tells nothing.
    pub fn read(rows: &mut Rows<'_, 3>, radius_mm: f64, pitches_mm: [Option<f64>; 2]) -> Result<Test> {
        let (mut lines, mut readings) = (Vec::new(), Vec::new());
        while let Some(row) = rows.next()? {
            let [angle_deg, deviation_um, direction] = row.values;
            if direction == 0.0 {
                return Err(rows.error(row.line, "direction", 0, "1 counterclockwise or -1 clockwise"));
            }
            lines.push(row.line);
            readings.push(Reading {
                angle_rad: angle_deg.to_radians(),
                deviation_mm: 1e-3 * deviation_um,
                counterclockwise: direction > 0.0,
            });
        }
        Test::of(radius_mm, readings, pitches_mm).map_err(|refused| match refused {
            Refused::NotAReading { index } => {
                let line = lines.get(index).copied().unwrap_or(1);
                rows.error(line, "deviation_um", "a deviation as large as the circle", "less than half the radius")
            }
            refused => anyhow!("{}: {refused}", rows.file.display()),
        })
    }

    /// Evaluates readings.
    ///
    /// # Errors
    /// [`Refused`].
    pub fn of(radius_mm: f64, readings: Vec<Reading>, pitches_mm: [Option<f64>; 2]) -> Result<Test, Refused> {
        let found = evaluate(radius_mm, &readings, pitches_mm)?;
        Ok(Test { radius_mm, readings, found })
    }
}
