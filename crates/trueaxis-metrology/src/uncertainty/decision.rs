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
    verdict_within(interval, [f64::NEG_INFINITY, tolerance])
}

/// Decides on a value in `interval` that must lie between two limits; infinite: no limit on that side. Rule as [`verdict`].
///
/// ```
/// use trueaxis_metrology::uncertainty::{Interval, Verdict, verdict_within};
/// let within = |low, high| verdict_within(Interval { low, high }, [-10.0, 10.0]);
/// assert_eq!(within(-10.0, 9.0), Verdict::Pass);
/// assert_eq!(within(9.0, 11.0), Verdict::Undecided);
/// assert_eq!(within(-14.0, -11.0), Verdict::Fail);
/// ```
pub fn verdict_within(interval: Interval, [low, high]: [f64; 2]) -> Verdict {
    if interval.low >= low && interval.high <= high {
        Verdict::Pass
    } else if interval.low > high || interval.high < low {
        Verdict::Fail
    } else {
        Verdict::Undecided
    }
}
