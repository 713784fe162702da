//! Names of the keys of `machine.toml`, and their unit suffixes.

use super::field::Field;
use crate::axis::Axis;
use core::fmt;

impl Field {
    /// Returns the key in `machine.toml`, with the axis if it belongs to one; `None` if the setting is not in the file.
    ///
    /// ```
    /// use trueaxis::{error::Field, machine::Axis};
    ///
    /// let key = Field::Magnitude.key(Some(Axis::C)).unwrap();
    /// assert_eq!(key.to_string(), "axis.C.limits.magnitude_urad");
    /// ```
    #[doc(hidden)]
    pub fn key(self, axis: Option<Axis>) -> Option<Key> {
        let [linear, rotary] = self.pattern()?;
        Some(Key { pattern: if axis.is_some_and(Axis::is_rotary) { rotary } else { linear }, axis })
    }
}

/// Full name of a key, or of a section, of `machine.toml`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    pattern: &'static str,
    axis: Option<Axis>,
}

impl Key {
    /// Converts a value of the core (mm, degrees, rad, seconds) to the unit of the name's suffix, to twelve digits.
    pub fn in_its_unit(&self, value: f64) -> f64 {
        let name = self.pattern.strip_suffix("_per_k").unwrap_or(self.pattern);
        let is_of_axis = name.starts_with("axis.");
        let factor = if name.starts_with("roundness.") {
            1.0
        } else if name.contains("expansion") || name.ends_with("_um_per_m_per_s2") {
            1e6
        } else if name.ends_with("_um") || name.ends_with("_um_per_deg_per_s2") {
            1e3
        } else if name.ends_with("_urad") {
            if is_of_axis { 1e6_f64.to_radians() } else { 1e6 }
        } else if name.ends_with("_per_min") {
            60.0
        } else {
            1.0
        };
        let scaled = value * factor;
        let digits = libm::floor(libm::log10(libm::fabs(scaled)));
        if factor == 1.0 || !digits.is_finite() || libm::fabs(digits) > 200.0 {
            return scaled;
        }
        let (up, down) = (libm::exp10((11.0 - digits).max(0.0)), libm::exp10((digits - 11.0).max(0.0)));
        libm::round(scaled * up / down) / up * down
    }

    /// Whether the name contains its axis.
    pub(super) fn names_its_axis(&self) -> bool {
        self.axis.is_some() && self.pattern.contains('*')
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.pattern.split_once('*'), self.axis) {
            (None, _) => f.write_str(self.pattern),
            (Some((before, behind)), Some(axis)) => write!(f, "{before}{}{behind}", axis.letter()),
            // Without an axis: the section of all axes.
            (Some((before, _)), None) => f.write_str(before.split('.').next().unwrap_or(before)),
        }
    }
}
