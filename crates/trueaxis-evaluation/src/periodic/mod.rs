//! Errors that repeat within a pitch, from a fine scan of an axis or a ballbar's record.
//!
//! ```text
//! CSV ─► Recording ─► Test ─► PeriodicDocument, tables and plots, additions to a machine
//! ```
//!
//! The mathematics is in [`trueaxis_metrology::periodic`].

mod document;
mod machine;
mod record;
mod shown;

pub use document::{HarmonicFound, LeftFound, PeriodFound, PeriodicDocument};
pub use record::{COLUMNS, Recording};

use crate::range::OutOfRange;
use anyhow::Result;
use std::ops::RangeInclusive;
use trueaxis::Axis;
use trueaxis_metrology::periodic::{Found, Reading, identify};

/// Accepted periods and radii, mm or degrees.
const LENGTHS: RangeInclusive<f64> = 1e-3..=1e5;

/// The circle of a ballbar's record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    /// Nominal radius, mm.
    pub radius_mm: f64,
    /// The plane: angles count from the first axis towards the second.
    pub axes: [Axis; 2],
    /// Axis positions X, Y, Z of the centre, mm.
    pub centre_mm: [f64; 3],
}

/// What the record does not contain.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// The axis whose periods are sought.
    pub axis: Axis,
    /// The periods, mm or degrees.
    pub periods: Vec<f64>,
    /// Harmonics of each period; `None`: as many as the points permit and the readings justify.
    pub harmonics: Option<usize>,
    /// The circle; `None` for a scan.
    pub circle: Option<Circle>,
}

impl Options {
    /// Checks the figures.
    ///
    /// # Errors
    /// A period or radius outside 0.001 to 100000; a circle whose plane does not have the axis.
    pub fn check(&self) -> Result<()> {
        let [name, unit] = if self.axis.is_rotary() { ["period_deg", "deg"] } else { ["period_mm", "mm"] };
        let own = |period: &f64| OutOfRange::check(name, *period, LENGTHS, unit);
        self.periods.iter().try_for_each(own).map_err(|wrong| wrong.option())?;
        let Some(circle) = &self.circle else { return Ok(()) };
        OutOfRange::check("radius_mm", circle.radius_mm, LENGTHS, "mm").map_err(|wrong| wrong.option())?;
        if !circle.axes.contains(&self.axis) {
            let [one, other] = circle.axes.map(Axis::letter);
            anyhow::bail!("--axes: found {one},{other}, needed a plane with axis {}", self.axis.letter());
        }
        Ok(())
    }

    /// Unit of the positions.
    fn unit(&self) -> &'static str {
        if self.axis.is_rotary() { "deg" } else { "mm" }
    }
}

/// An evaluated record.
#[derive(Clone, Debug)]
pub struct Test {
    /// Parameters of the evaluation.
    pub options: Options,
    /// The readings.
    pub readings: Vec<Reading>,
    /// Number of readings left out, close to a reversal on a circle.
    pub left_out: usize,
    /// Result of the evaluation.
    pub found: Found,
}

impl Test {
    /// Evaluates a record.
    ///
    /// # Errors
    /// [`trueaxis_metrology::periodic::PeriodicRefusal`], with the name of the file.
    pub fn of(recording: Recording, options: &Options) -> Result<Test> {
        let Recording { file, readings, left_out } = recording;
        let found = identify(&readings, &options.periods, options.harmonics)
            .map_err(|refused| anyhow::anyhow!("{}: {}", file.display(), refused.in_unit(options.unit())))?;
        Ok(Test { options: options.clone(), readings, left_out, found })
    }
}
