//! Machines that a calibration refuses.

use serde::Serialize;
use std::fmt;

/// A machine that is missing from the figures: the probing or the solution was refused, as by a drift that is too large.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Refused {
    /// Axes of the machine, 3 or 5.
    pub axes: usize,
    /// Seed.
    pub seed: u64,
    /// The message.
    pub reason: String,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "machine {} with {} axes: {}", self.seed, self.axes, self.reason)
    }
}

impl std::error::Error for Refused {}
