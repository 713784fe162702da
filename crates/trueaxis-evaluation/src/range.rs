//! Numbers of a call that are out of their range.

use std::fmt;
use std::ops::RangeInclusive;

/// A number that is out of its range. Its text has the name as Python has it, `radius_mm: found 0, needed 0.001 to 100000 mm`.
#[derive(Clone, Debug, PartialEq)]
pub struct OutOfRange {
    name: &'static str,
    found: f64,
    range: RangeInclusive<f64>,
    unit: &'static str,
}

impl OutOfRange {
    /// Whether a number, if there is one, keeps to its range; NaN does not.
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

    /// The same with the name as the command line has it, `--radius-mm`.
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
