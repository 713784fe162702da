//! Reasons for refusing a file with thermal growth.

use core::fmt;

/// Why a file was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
#[non_exhaustive]
pub enum ThermalError {
    /// Shorter than its counts say.
    TooShort = 1,
    /// Longer than its counts say.
    TooLong = 2,
    /// Another kind of file.
    Magic = 3,
    /// Another version of the format.
    Version = 4,
    /// Damaged: the sum over the file is wrong.
    Checksum = 5,
    /// More sensors than supported.
    Sensors(u8) = 6,
    /// No axis, or more than six.
    Axes(u8) = 7,
    /// Number of knots of a curve out of range.
    Knots(u8) = 8,
    /// Knots that do not ascend, or are out of range: the first one, mK or rpm.
    KnotOrder(i32) = 9,
    /// A lag or time out of range, ms.
    Time(u32) = 10,
    /// The plausible readings of a sensor are an empty range, or its permitted change is zero; sensor from 1.
    Plausible(u8) = 11,
    /// An axis that does not exist, or is out of order.
    Axis(u8) = 12,
    /// A value that should be zero: at 0 rpm, or between the counts.
    NotZero(i32) = 13,
    /// A slope out of range, 10⁻¹².
    Slope(i32) = 14,
    /// The file belongs to another machine.
    WrongMachine {
        /// Id in the file.
        found: u32,
        /// Id of the machine in use.
        needed: u32,
    } = 15,
}

impl ThermalError {
    /// The numeric code.
    pub const fn code(&self) -> u8 {
        match self {
            ThermalError::TooShort => 1,
            ThermalError::TooLong => 2,
            ThermalError::Magic => 3,
            ThermalError::Version => 4,
            ThermalError::Checksum => 5,
            ThermalError::Sensors(_) => 6,
            ThermalError::Axes(_) => 7,
            ThermalError::Knots(_) => 8,
            ThermalError::KnotOrder(_) => 9,
            ThermalError::Time(_) => 10,
            ThermalError::Plausible(_) => 11,
            ThermalError::Axis(_) => 12,
            ThermalError::NotZero(_) => 13,
            ThermalError::Slope(_) => 14,
            ThermalError::WrongMachine { .. } => 15,
        }
    }
}

impl fmt::Display for ThermalError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ThermalError::TooShort => f.write_str("the file is shorter than its counts say"),
            ThermalError::TooLong => f.write_str("the file is longer than its counts say"),
            ThermalError::Magic => f.write_str("not a file of thermal growth (it does not start with TRUETHRM)"),
            ThermalError::Version => {
                write!(f, "another version of the format (version {} is needed)", super::VERSION)
            }
            ThermalError::Checksum => f.write_str("the file is damaged (its CRC-32 is wrong)"),
            ThermalError::Sensors(found) => write!(f, "found {found} sensors, needed at most {}", super::SENSORS),
            ThermalError::Axes(found) => write!(f, "found {found} axes, needed 1 to 6"),
            ThermalError::Knots(found) => write!(f, "found a curve of {found} knots, needed 2 to {}", super::KNOTS),
            ThermalError::KnotOrder(found) => {
                write!(f, "found a knot at {found} (mK or rpm), needed ascending ones within the range of the format")
            }
            ThermalError::Time(found) => write!(f, "found a time of {found} ms, needed up to {}", super::LONGEST_MS),
            ThermalError::Plausible(found) => {
                write!(f, "found no plausible reading of sensor {found}, needed a range and a change above zero")
            }
            ThermalError::Axis(found) => write!(f, "found axis {found}, needed 0 to 5 in ascending order"),
            ThermalError::NotZero(found) => write!(f, "found {found} where zero is needed"),
            ThermalError::Slope(found) => {
                write!(f, "found a slope of {found} 1e-12, needed at most {} either way", super::STEEPEST)
            }
            ThermalError::WrongMachine { found, needed } => {
                write!(f, "found on the machine {found:08x}, needed {needed:08x}")
            }
        }
    }
}

impl core::error::Error for ThermalError {}
