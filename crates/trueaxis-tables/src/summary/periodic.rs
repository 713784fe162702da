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
    /// Amplitudes of the harmonics 1, 2, … in positive travel.
    pub amplitudes_micro: Vec<f64>,
    /// The same in negative travel, if it differs.
    pub reverse_amplitudes_micro: Option<Vec<f64>>,
}

pub(super) fn period(settings: &PeriodicSettings) -> PeriodSummary {
    let amplitudes = |pairs: &[[f64; 2]]| pairs.iter().map(|[a, b]| micro(settings.axis, a.hypot(*b))).collect();
    PeriodSummary {
        period: settings.period,
        amplitudes_micro: amplitudes(&settings.harmonics),
        reverse_amplitudes_micro: settings.is_two_sided().then(|| amplitudes(&settings.reverse)),
    }
}

impl PeriodSummary {
    /// Writes the line of an axis' section; `unit` is mm or deg, `micro` µm or µrad.
    pub(super) fn line(&self, f: &mut fmt::Formatter<'_>, unit: &str, micro: &str) -> fmt::Result {
        let list = |all: &[f64]| all.iter().map(|amplitude| format!("{amplitude:.2}")).collect::<Vec<_>>().join(", ");
        write!(
            f,
            "\n  periodic   {} {unit}: harmonics of {} {micro}",
            short(self.period),
            list(&self.amplitudes_micro)
        )?;
        match &self.reverse_amplitudes_micro {
            Some(reverse) => write!(f, ", in negative travel {} {micro}", list(reverse)),
            None => Ok(()),
        }
    }
}
