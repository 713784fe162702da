//! Circular tests: reads recorded circles and presents the results as a document and as figures.
//!
//! The mathematics is [`trueaxis_metrology::ballbar`].

mod document;
mod machine;
mod polar;
mod record;
mod shown;
mod telemetry;

pub use document::{BallbarDocument, Pair, Share, Ways, name};
pub use record::COLUMNS;
pub(crate) use record::direction;

use crate::range::OutOfRange;
use std::ops::RangeInclusive;
use trueaxis::Axis;
use trueaxis_metrology::ballbar::{BallbarRefusal, Evaluation, Reading, evaluate};

/// Accepted radii and pitches, mm.
const LENGTHS_MM: RangeInclusive<f64> = 1e-3..=1e5;

/// Parameters that the record does not contain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Nominal radius of the circle, mm.
    pub radius_mm: f64,
    /// The plane: angles count from the first axis towards the second.
    pub axes: [Axis; 2],
    /// Pitch of each axis' periodic error, mm; `None` to search for it.
    pub pitches_mm: [Option<f64>; 2],
}

impl Options {
    /// A circle of this radius in the plane of these axes; `pitches_mm` are for X, Y, Z.
    ///
    /// # Errors
    /// A length outside 0.001 to 100000 mm.
    pub fn new(radius_mm: f64, axes: [Axis; 2], pitches_mm: [Option<f64>; 3]) -> Result<Options, OutOfRange> {
        let [x, y, z] = pitches_mm;
        let lengths = [("pitch_x_mm", x), ("pitch_y_mm", y), ("pitch_z_mm", z), ("radius_mm", Some(radius_mm))];
        for (name, length) in lengths {
            OutOfRange::check(name, length, LENGTHS_MM, "mm")?;
        }
        let pitches_mm = axes.map(|axis| pitches_mm.get(axis.index()).copied().flatten());
        Ok(Options { radius_mm, axes, pitches_mm })
    }
}

/// An evaluated circular test.
#[derive(Clone, Debug)]
pub struct Test {
    /// Parameters of the evaluation.
    pub options: Options,
    /// Whether the readings are computed from commanded and actual positions.
    pub of_positions: bool,
    /// Readings of the bar.
    pub readings: Vec<Reading>,
    /// Result of the evaluation.
    pub found: Evaluation,
}

impl Test {
    /// Evaluates readings.
    ///
    /// # Errors
    /// [`BallbarRefusal`].
    pub fn of(readings: Vec<Reading>, of_positions: bool, options: &Options) -> Result<Test, BallbarRefusal> {
        let found = evaluate(options.radius_mm, &readings, options.pitches_mm)?;
        Ok(Test { options: *options, of_positions, readings, found })
    }
}
