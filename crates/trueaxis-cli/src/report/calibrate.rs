//! The page of `trueaxis calibrate solve`.

use maud::html;
use trueaxis::Axis;
use trueaxis_evaluation::calibrate::{Calibration, CalibrationDocument, Plan, Task, curves, drift, residuals};
use trueaxis_report::number::significant;
use trueaxis_report::{Page, Row, Table, summary};

/// The whole page; `source` is the name of the log.
pub(crate) fn page(
    source: &str,
    task: &Task,
    plan: &Plan,
    found: &Calibration,
    document: &CalibrationDocument,
) -> String {
    let terms = document.terms.iter().map(|term| {
        let value = format!("{} {}", significant(term.value, 4), term.unit);
        Row::new(term.name.clone(), [value, format!("± {}", significant(term.standard_error, 2))])
    });
    let sizes = document.artefacts.iter().map(|size| {
        Row::new(
            size.name.clone(),
            [format!("{}", size.stated), format!("{:.5}", size.found), significant(size.standard_error, 2)],
        )
    });
    let network = Table::new(
        ["network", ""],
        [
            Row::new("sigma of a touch, µm", [significant(document.sigma_um, 3)]),
            Row::new("stated, µm", [significant(document.repeatability_um, 3)]),
            Row::new("measured, µm RMS", [significant(document.signal_um, 3)]),
            Row::new("degrees of freedom", [document.degrees_of_freedom.to_string()]),
            Row::new("unknowns, rank", [document.rank.to_string()]),
            Row::new("condition", [significant(document.condition, 2)]),
            Row::new("radius of the tip, mm", [format!("{:.5}", document.tip_radius_mm)]),
        ],
    );
    let touches = format!("{} touches", document.touches);
    let mut page = Page::new("Calibration")
        .top(summary([html! { (source) }, html! { (document.machine) }, html! { (touches) }]))
        .top(super::warnings(&document.warnings))
        .section("Errors found", Table::new(["term", "value", "standard error"], terms));
    let figures: Vec<_> = [Axis::X, Axis::Y, Axis::Z].into_iter().filter_map(|axis| curves(found, axis)).collect();
    if !figures.is_empty() {
        page = page.section("Curves", html! { @for figure in figures { (figure) } });
    }
    page = page.section("Residuals", html! { (residuals(task, plan, found)) (network) });
    if let Some(figure) = drift(found) {
        page = page.section("Drift", figure);
    }
    let sizes = Table::new(["artefact", "stated", "found, mm or °", "± µm or µrad"], sizes);
    page.section("Artefacts", sizes).document()
}
