//! A circular test: the recorded circle as readings, and what it tells as a document and as figures.
//!
//! The mathematics is [`trueaxis_metrology::ballbar`].

mod document;
mod machine;
mod polar;
mod record;
mod values;

pub use document::{Document, Pair, Share, Ways, name};
pub use polar::{left, polar};
pub use record::COLUMNS;
pub use values::values;

use std::ops::RangeInclusive;
use trueaxis::Axis;
use trueaxis_metrology::ballbar::{Evaluation, Reading, Refused, evaluate};

/// Radii and pitches that are taken, mm.
pub const LENGTHS_MM: RangeInclusive<f64> = 1e-3..=1e5;

/// What is to be known beside the record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Nominal radius of the circle, mm.
    pub radius_mm: f64,
    /// The plane: angles count from the first axis towards the second.
    pub axes: [Axis; 2],
    /// Pitch of the periodic error of either axis, mm; searched where it is not known.
    pub pitches_mm: [Option<f64>; 2],
}

/// A circular test, evaluated.
#[derive(Clone, Debug)]
pub struct Test {
    /// How it was evaluated.
    pub options: Options,
    /// Made of commanded and actual positions.
    pub of_positions: bool,
    /// What the bar read.
    pub readings: Vec<Reading>,
    /// What it tells.
    pub found: Evaluation,
}

impl Test {
    /// Evaluates readings.
    ///
    /// # Errors
    /// [`Refused`].
    pub fn of(readings: Vec<Reading>, of_positions: bool, options: &Options) -> Result<Test, Refused> {
        let found = evaluate(options.radius_mm, &readings, options.pitches_mm)?;
        Ok(Test { options: *options, of_positions, readings, found })
    }
}
