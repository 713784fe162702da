//! Curves with a range that the touches leave as they were assumed.

use super::solve::Calibration;
use super::task::Task;
use super::terms::Term;
use trueaxis::machine::Axis;
use trueaxis_tables::text::counted;

/// A term counts as unseen if its standard error is above this share of its range.
const UNSEEN: f64 = 0.95;

impl Calibration {
    /// Curves with a range of which no degree is determined: axis and component.
    pub(super) fn unseen(&self) -> Vec<(Axis, u8)> {
        let terms = &self.observed.terms.terms;
        let is_free = |index: usize| {
            let range = self.observed.network.unknowns[index].uncertainty;
            range.is_some_and(|range| self.solution.standard_errors[index] > UNSEEN * range)
        };
        let mut curves: Vec<(Axis, u8)> = Vec::new();
        // The first degree of an axis along itself is its scale, which has no range.
        let has_range = |index: &usize| self.observed.network.unknowns[*index].uncertainty.is_some();
        for term in (0..terms.len()).filter(has_range).map(|index| &terms[index]) {
            curves.extend(term.curve_of().filter(|curve| !curves.contains(curve)));
        }
        let is_unseen = |curve: &(Axis, u8)| {
            let mut own = (0..terms.len()).filter(has_range).filter(|index| terms[*index].curve_of() == Some(*curve));
            own.all(is_free)
        };
        curves.retain(is_unseen);
        curves
    }

    /// What to say of them.
    pub(super) fn unseen_words(&self, task: &Task) -> Option<String> {
        let unseen = self.unseen();
        if unseen.is_empty() {
            return None;
        }
        let name = |&(axis, component): &(Axis, u8)| Term::Curve { axis, component, degree: 1 }.curve_name();
        let names: Vec<String> = unseen.iter().filter_map(name).collect();
        let lengths = task.stylus_lengths().len();
        let lacks = if lengths < 2
            && unseen.iter().any(|(axis, component)| *axis == Axis::Z && (3..5).contains(component))
        {
            "; a second length of the stylus (stylus_mm) would separate turns of Z about X and Y from its straightness"
        } else {
            ""
        };
        Some(format!(
            "{} not seen by these places, left at zero within the range assumed: {}{lacks}",
            counted(unseen.len(), "curve"),
            names.join(", ")
        ))
    }
}
