//! Numbers of a call that are outside their range.

use std::fmt;
use std::ops::RangeInclusive;

/// A number outside its range. Displays under its Python name: `radius_mm: found 0, needed 0.001 to 100000 mm`.
#[derive(Clone, Debug, PartialEq)]
pub struct OutOfRange {
    name: &'static str,
    found: f64,
    range: RangeInclusive<f64>,
    unit: &'static str,
}

impl OutOfRange {
    /// Checks that a number is in its range; `None` passes, NaN does not.
    ///
    /// # Errors
    /// The number with its range.
    pub fn check(
        name: &'static str,
        found: impl Into<Option<f64>>,
        range: RangeInclusive<f64>,
        unit: &'static str,
    ) -> Result<(), OutOfRange> {
        match found.into() {
            Some(found) if !range.contains(&found) => Err(OutOfRange { name, found, range, unit }),
            _ => Ok(()),
        }
    }

    /// The error under its command-line name, `--radius-mm`.
    pub fn option(&self) -> anyhow::Error {
        anyhow::anyhow!("--{}: {}", self.name.replace('_', "-"), self.sentence())
    }

    fn sentence(&self) -> String {
        format!("found {}, needed {} to {} {}", self.found, self.range.start(), self.range.end(), self.unit)
    }
}

impl fmt::Display for OutOfRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.name, self.sentence())
    }
}

impl std::error::Error for OutOfRange {}
