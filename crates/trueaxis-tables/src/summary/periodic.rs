//! Errors of an axis that repeat within a period.

use crate::text::{micro, short};
use serde::Serialize;
use std::fmt;
use trueaxis::machine::PeriodicSettings;

/// A period of an axis. Lengths in the axis' unit, mm or degrees, small ones in µm or µrad.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PeriodSummary {
    /// Length of the period.
    pub period: f64,
    /// Cosine and sine of the harmonics 1, 2, … in positive travel.
    pub harmonics_micro: Vec<[f64; 2]>,
    /// The same in negative travel, if it differs.
    pub reverse_micro: Option<Vec<[f64; 2]>>,
}

pub(super) fn period(settings: &PeriodicSettings) -> PeriodSummary {
    let in_micro = |pairs: &[[f64; 2]]| pairs.iter().map(|pair| pair.map(|part| micro(settings.axis, part))).collect();
    PeriodSummary {
        period: settings.period,
        harmonics_micro: in_micro(&settings.harmonics),
        reverse_micro: settings.is_two_sided().then(|| in_micro(&settings.reverse)),
    }
}

impl PeriodSummary {
    /// Writes the line of an axis' section; `unit` is mm or deg, `micro` µm or µrad.
    pub(super) fn line(&self, f: &mut fmt::Formatter<'_>, unit: &str, micro: &str) -> fmt::Result {
        let list =
            |all: &[[f64; 2]]| all.iter().map(|[a, b]| format!("{:.2}", a.hypot(*b))).collect::<Vec<_>>().join(", ");
        let amplitudes = list(&self.harmonics_micro);
        write!(f, "\n  periodic   {} {unit}: harmonics of {amplitudes} {micro}", short(self.period))?;
        match &self.reverse_micro {
            Some(reverse) => write!(f, ", in negative travel {} {micro}", list(reverse)),
            None => Ok(()),
        }
    }
}
