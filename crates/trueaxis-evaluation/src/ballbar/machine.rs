//! Results of a circular test as machine settings.

use super::Test;
use super::document::squareness;
use trueaxis_metrology::ballbar::Cause;
use trueaxis_tables::Additions;
use trueaxis_tables::finding::{AGREE, Finding, Fit, Known};

impl Test {
    /// Squareness of the plane and backlash of its axes, as findings for a machine. `compensated`: the machine's tables
    /// corrected it during the test, so the circles show the residual; otherwise they show the whole error.
    ///
    /// A scale mismatch is the difference of two scales and determines neither; the test does not locate a bow along its axis;
    /// lag, play and cyclic error have no place in a table.
    pub fn additions(&self, compensated: bool) -> Additions {
        let (name, sense) = squareness(self.options.axes);
        let finding = |key: String, cause: Cause, factor: f64| {
            let term = self.found.term(cause)?;
            let found =
                Known::new(factor * term.value, factor.abs() * term.standard_error, self.found.degrees_of_freedom);
            Some(Finding { key, found, on_top: compensated, ..Finding::default() })
        };
        // The axes' encoders are square to one another regardless of the machine, so a squareness of zero from positions is
        // not a finding.
        let squareness = finding(format!("location.{name}_urad"), Cause::Squareness, 1e6 * sense);
        let seen = |own: &Finding| {
            !self.of_positions || own.found.value.abs() > AGREE * own.found.uncertainty.unwrap_or_default()
        };
        let mut findings = Vec::from_iter(squareness.filter(seen));
        for (number, axis) in (0..).zip(self.options.axes) {
            findings.extend(finding(format!("axis.{}.backlash_um", axis.letter()), Cause::Backlash(number), 1e3));
        }
        let rms = |part: usize| {
            let squares = self.found.centred.iter().map(|deviation| deviation[part].powi(2));
            (squares.sum::<f64>() / self.found.centred.len().max(1) as f64).sqrt()
        };
        let fit = Fit { before_mm: rms(0), left_mm: rms(1), noise_mm: None, is_angle: false };
        Additions { findings, fit: Some(fit), compensated, ..Additions::default() }
    }
}
