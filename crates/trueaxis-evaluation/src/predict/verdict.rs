//! The words of a verdict.

use trueaxis_metrology::uncertainty::{Interval, Verdict, verdict_within};

/// `conforms`, `does not conform` or `undecided`, after ISO 14253-1.
pub(super) fn verdict_of(interval: Interval, limits: [f64; 2]) -> &'static str {
    match verdict_within(interval, limits) {
        Verdict::Pass => "conforms",
        Verdict::Fail => "does not conform",
        Verdict::Undecided => "undecided",
    }
}
