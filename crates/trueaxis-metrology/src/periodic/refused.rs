//! Why a record determines no periodic error.

use core::fmt;

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

/// A length to four digits at most.
struct Short(f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = if self.0 > 0.0 { self.0.log10().floor() as i32 } else { 0 };
        let scale = 10_f64.powi(3 - size);
        let rounded = (self.0 * scale).round() / scale;
        // The reciprocal of a power of ten is not exact: as many decimals as the digits need.
        let text = std::format!("{rounded:.*}", (3 - size).clamp(0, 9) as usize);
        f.write_str(if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text })
    }
}

/// Displayed without units: the positions' own.
impl fmt::Display for PeriodicRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            PeriodicRefusal::NotAPeriod { found } => write!(f, "found a period of {found}, needed one above 0"),
            PeriodicRefusal::NotAReading { .. } => f.write_str("found a value that is not finite, needed numbers"),
            PeriodicRefusal::TooMany { found } => {
                write!(f, "found {found} harmonics, needed 1 to {}", super::MOST_HARMONICS)
            }
            PeriodicRefusal::TooShort { period, length } => write!(
                f,
                "found positions over {}, needed {} at least, three periods of {period}",
                Short(length),
                Short(super::LEAST_PERIODS * period)
            ),
            PeriodicRefusal::TooCoarse { period, number, spacing } => write!(
                f,
                "found points {} apart in the mean, needed {} at most: four in a period of harmonic {number} of {period}",
                Short(spacing),
                Short(needed(period, number))
            ),
            PeriodicRefusal::Aliased { period, number, spacing, of } => {
                write!(
                    f,
                    "found points every {}, at which harmonic {number} of the period {period} looks like ",
                    Short(spacing)
                )?;
                match of {
                    AliasOf::Constant => f.write_str("a constant")?,
                    AliasOf::Harmonic { period, number } => write!(f, "harmonic {number} of the period {period}")?,
                    AliasOf::Wave(length) => write!(f, "a wave of {}", Short(length))?,
                }
                write!(f, ", needed points every {} at most", Short(needed(period, number)))
            }
            PeriodicRefusal::TooClose { periods: [one, other], length } => {
                let apart = (1.0 / one - 1.0 / other).abs();
                write!(f, "found the periods {one} and {other} over {}, needed ", Short(length))?;
                if apart > 0.0 {
                    write!(f, "{} at least to separate them", Short(1.0 / apart))
                } else {
                    f.write_str("two that differ")
                }
            }
            PeriodicRefusal::TooFew { found, needed } => write!(f, "found {found} readings, needed {needed} at least"),
            PeriodicRefusal::Unseparated { period, number } => write!(
                f,
                "found positions that do not separate harmonic {number} of the period {period} from the slow error, needed points \
                 at most {} apart throughout",
                Short(needed(period, number))
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
