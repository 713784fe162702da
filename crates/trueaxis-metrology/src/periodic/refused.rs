//! Why a record determines no periodic error.

use core::fmt;
use std::format;
use std::string::String;

/// What a harmonic cannot be told from at equidistant points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AliasOf {
    /// A constant: the spacing is a multiple of its wavelength.
    Constant,
    /// A harmonic of a period.
    Harmonic {
        /// The period.
        period: f64,
        /// Number of the harmonic.
        number: usize,
    },
    /// A longer wave of this length.
    Wave(f64),
}

/// Why a record determines no periodic error. Lengths in the unit of the positions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PeriodicRefusal {
    /// A period that is not positive and finite.
    NotAPeriod {
        /// The value.
        found: f64,
    },
    /// A reading that is not finite.
    NotAReading {
        /// Index of the reading, from 0.
        index: usize,
    },
    /// More harmonics than can be fitted.
    TooMany {
        /// Harmonics asked for.
        found: usize,
    },
    /// The scan is shorter than three periods.
    TooShort {
        /// The period.
        period: f64,
        /// Length of the scan.
        length: f64,
    },
    /// Fewer than four points in a period of a harmonic, unevenly spaced.
    TooCoarse {
        /// The period.
        period: f64,
        /// Number of the harmonic.
        number: usize,
        /// Mean distance of the points.
        spacing: f64,
    },
    /// Fewer than four equidistant points in a period of a harmonic.
    Aliased {
        /// The period.
        period: f64,
        /// Number of the harmonic.
        number: usize,
        /// Distance of the points.
        spacing: f64,
        /// What it looks like.
        of: AliasOf,
    },
    /// Two periods closer together than the scan resolves.
    TooClose {
        /// The periods.
        periods: [f64; 2],
        /// Length of the scan.
        length: f64,
    },
    /// Fewer readings than the fit needs.
    TooFew {
        /// Readings.
        found: usize,
        /// Readings needed.
        needed: usize,
    },
    /// The positions do not separate a harmonic from the rest of the error.
    Unseparated {
        /// The period.
        period: f64,
        /// Number of the harmonic.
        number: usize,
    },
}

/// A length to four digits at most, with its unit.
fn short(length: f64, unit: &str) -> String {
    let size = if length > 0.0 { length.log10().floor() as i32 } else { 0 };
    let scale = 10_f64.powi(3 - size);
    // The reciprocal of a power of ten is not exact: as many decimals as the digits need.
    let text = format!("{:.*}", (3 - size).clamp(0, 9) as usize, (length * scale).round() / scale);
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if unit.is_empty() { text.into() } else { format!("{text} {unit}") }
}

/// Displayed without units: [`PeriodicRefusal::in_unit`] has them.
impl fmt::Display for PeriodicRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.in_unit(""))
    }
}

impl AliasOf {
    fn in_unit(self, unit: &str) -> String {
        match self {
            AliasOf::Constant => "a constant".into(),
            AliasOf::Harmonic { period, number } => format!("harmonic {number} of the period {}", short(period, unit)),
            AliasOf::Wave(length) => format!("a wave of {}", short(length, unit)),
        }
    }
}

impl PeriodicRefusal {
    /// Returns the sentence, with the unit of the positions.
    pub fn in_unit(&self, unit: &str) -> String {
        let of = |length: f64| short(length, unit);
        match *self {
            PeriodicRefusal::NotAPeriod { found } => format!("found a period of {found}, needed one above 0"),
            PeriodicRefusal::NotAReading { .. } => "found a value that is not finite, needed numbers".into(),
            PeriodicRefusal::TooMany { found } => {
                format!("found {found} harmonics, needed 1 to {}", super::MOST_HARMONICS)
            }
            PeriodicRefusal::TooShort { period, length } => format!(
                "found positions over {}, needed {} at least, three periods of {}",
                of(length),
                of(super::LEAST_PERIODS * period),
                of(period)
            ),
            PeriodicRefusal::TooCoarse { period, number, spacing } => format!(
                "found points {} apart in the mean, needed {} at most: four in a period of harmonic {number} of {}",
                of(spacing),
                of(needed(period, number)),
                of(period)
            ),
            PeriodicRefusal::Aliased { period, number, spacing, of: alias } => format!(
                "found points every {}, at which harmonic {number} of the period {} looks like {}, needed points every {} at most",
                of(spacing),
                of(period),
                alias.in_unit(unit),
                of(needed(period, number))
            ),
            PeriodicRefusal::TooClose { periods: [one, other], length } => {
                let apart = (1.0 / one - 1.0 / other).abs();
                let needed = match apart > 0.0 {
                    true => format!("{} at least to separate them", of(1.0 / apart)),
                    false => "two that differ".into(),
                };
                format!("found the periods {} and {} over {}, needed {needed}", of(one), of(other), of(length))
            }
            PeriodicRefusal::TooFew { found, needed } => {
                format!("found {found} readings, needed {needed} at least")
            }
            PeriodicRefusal::Unseparated { period, number } => format!(
                "found positions that do not separate harmonic {number} of the period {} from the slow error, needed points at \
                 most {} apart throughout",
                of(period),
                of(needed(period, number))
            ),
        }
    }
}

/// Distance of points, four in a period of a harmonic.
fn needed(period: f64, number: usize) -> f64 {
    period / (super::LEAST_POINTS * number as f64)
}

impl core::error::Error for PeriodicRefusal {}

impl PeriodicRefusal {
    /// Returns the index of the refused reading, from 0; `None` if the refusal concerns no single one.
    pub fn row(&self) -> Option<usize> {
        match *self {
            PeriodicRefusal::NotAReading { index } => Some(index),
            _ => None,
        }
    }
}
