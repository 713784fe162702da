//! Tables and plots of a calibration.

use super::document::CalibrationDocument;
use super::solve::Calibration;
use super::task::words;
use super::terms::Term;
use crate::shown::{Cell, Curve, EXPANDED, Look, Plot, Quantity, Shown, Table, Uncertainty, half_width};
use trueaxis::machine::Axis;
use trueaxis_report::BARS;

/// Steps of a curve over the travel.
const STEPS: usize = 20;

impl CalibrationDocument {
    /// Tables of the document, and the curves and the drift found by its calibration.
    pub fn shown(&self, found: &Calibration) -> Shown {
        let freedom = found.solution.error_degrees_of_freedom();
        let known = |standard_error: f64| Uncertainty::of(standard_error, freedom);
        let terms = self
            .terms
            .iter()
            .map(|term| Quantity::new(term.name.as_str(), term.unit, term.value, known(term.standard_error)));
        let tip = known(1e-3 * self.tip_radius_standard_error_um);
        // Dials have no tip.
        let is_read = self.tip_radius_mm <= 1e-6;
        let tip = (!is_read).then(|| Quantity::new("radius of the tip", "mm", self.tip_radius_mm, tip));
        let sizes = self.artefacts.iter().map(|size| {
            let found = Cell::fixed(size.found, 5);
            vec![size.name.as_str().into(), Cell::shortest(size.stated), found, known(size.standard_error).cell()]
        });
        let head = ["artefact", "stated", "found", &format!("{EXPANDED}, µm or µrad")];
        let sizes = Table::new("Artefacts, mm or °", head, sizes);
        let [one, all] = words(is_read);
        let sigma = format!("sigma of a {one}, µm");
        let network = [
            (sigma.as_str(), Cell::number(self.sigma_um, 3)),
            ("stated, µm", Cell::number(self.repeatability_um, 3)),
            ("measured, µm RMS", Cell::number(self.signal_um, 3)),
            ("degrees of freedom", Cell::count(self.degrees_of_freedom)),
            ("unknowns, rank", Cell::count(self.rank)),
            ("condition", Cell::number(self.condition, 2)),
        ];
        let compensated = self.compensated.then(|| "compensated while probed".to_owned());
        let touches = format!("{} {all} on {}", self.touches, self.machine);
        Shown {
            title: "Calibration".into(),
            summary: std::iter::once(touches).chain(compensated).collect(),
            notes: self.warnings.clone(),
            tables: vec![Table::quantities("Terms", terms.chain(tip)), Table::figures("Network", network), sizes],
            plots: [Axis::X, Axis::Y, Axis::Z]
                .into_iter()
                .filter_map(|axis| curves(found, axis))
                .chain(drift(found))
                .collect(),
            ..Shown::default()
        }
    }
}

/// A column of values and standard errors, mm.
fn curve(name: String, colour: usize, column: &[[f64; 2]], found: &Calibration) -> Curve {
    let freedom = found.solution.error_degrees_of_freedom();
    let expanded = column.iter().map(|[_, error]| half_width(1e3 * error, freedom)).collect();
    Curve { expanded, ..Curve::new(name, colour, column.iter().map(|[value, _]| 1e3 * value).collect()) }
}

/// The curves of an axis, including its scale; `None` if the calibration found none.
fn curves(found: &Calibration, axis: Axis) -> Option<Plot> {
    let terms = &found.observed.terms;
    if !terms.terms.iter().any(|term| matches!(term, Term::Curve { axis: of, .. } if *of == axis)) {
        return None;
    }
    let (letter, at) = (axis.letter(), terms.grid(axis, STEPS));
    let curves = (0..3).zip(["X", "Y", "Z"]).map(|(component, direction)| {
        let column: Vec<_> = at.iter().map(|q| found.shape(axis, component, *q, true)).collect();
        curve(format!("E{direction}{letter}"), component.into(), &column, found)
    });
    Some(Plot {
        section: "Curves",
        title: format!("Errors found of axis {letter}"),
        x: (letter.to_string(), "mm"),
        y: ("error", "µm"),
        look: Look::Dotted,
        caption: BARS,
        curves: curves.collect(),
        at,
        ..Plot::default()
    })
}

/// Drift of the reference since its first probing; `None` without a reference.
fn drift(found: &Calibration) -> Option<Plot> {
    let knots = &found.observed.knots;
    if knots.len() < 2 {
        return None;
    }
    let curves = ["X", "Y", "Z"].into_iter().enumerate().map(|(k, name)| {
        let at = |list: &[f64], knot: Option<usize>| knot.map_or(0.0, |index| list[index + k]);
        let column = knots
            .iter()
            .map(|&(_, knot)| [at(&found.solution.values, knot), at(&found.solution.standard_errors, knot)]);
        curve(name.into(), k, &column.collect::<Vec<_>>(), found)
    });
    Some(Plot {
        section: "Drift",
        title: "Drift of the reference since its first probing".into(),
        x: ("time without pauses".into(), "min"),
        y: ("drift", "µm"),
        look: Look::Dotted,
        caption: BARS,
        at: knots.iter().map(|(time_s, _)| time_s / 60.0).collect(),
        curves: curves.collect(),
        ..Plot::default()
    })
}
