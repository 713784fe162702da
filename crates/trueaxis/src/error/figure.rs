//! Numbers in refusals.

use core::fmt;

/// Prints a number in its shortest form: 1e308 without 309 digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure(pub f64);

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if self.0.is_finite() && (size >= 1e16 || (size > 0.0 && size < 1e-9)) {
            write!(f, "{:e}", self.0)
        } else {
            write!(f, "{}", self.0)
        }
    }
}
