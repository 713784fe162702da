//! Machines that a calibration refuses.

use serde::Serialize;
use std::fmt;

/// A machine that is excluded from the figures because its probing or solution was refused, for example after too large a
/// drift.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RefusedMachine {
    /// Number of axes, 3 or 5.
    pub axes: usize,
    /// Seed.
    pub seed: u64,
    /// The message.
    pub reason: String,
}

impl fmt::Display for RefusedMachine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "machine {} with {} axes: {}", self.seed, self.axes, self.reason)
    }
}

impl std::error::Error for RefusedMachine {}
