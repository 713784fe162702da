//! Decision on a value and a tolerance.

use super::Interval;
use serde::Serialize;

/// A verdict on a value that must not exceed a tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The value is within the tolerance, uncertainty included.
    Pass,
    /// The value exceeds the tolerance, uncertainty included.
    Fail,
    /// The tolerance lies within the uncertainty: neither can be proved.
    Undecided,
}

/// Decides on a value in `interval` that must be at most `tolerance`.
///
/// ```text
/// high ≤ tolerance: pass        low > tolerance: fail        else: undecided
/// ```
///
/// An interval of coverage p leaves at most (1 − p)/2 on the wrong side. The default rule of the standard has a conformance
/// probability of 95 %: an interval of coverage 90 %; one of 95 % is stricter. Source: ISO 14253-1:2017, clause 5.
pub fn verdict(interval: Interval, tolerance: f64) -> Verdict {
    if interval.high <= tolerance {
        Verdict::Pass
    } else if interval.low > tolerance {
        Verdict::Fail
    } else {
        Verdict::Undecided
    }
}
