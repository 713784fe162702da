//! The page of `trueaxis evaluate step-diagonal`.

use maud::html;
use trueaxis_evaluation::diagonal::{Document, deviations, shapes};
use trueaxis_metrology::diagonal::Test;
use trueaxis_report::number::significant;
use trueaxis_report::{Page, Row, Table, summary};

/// The whole page; `source` is the name of the record.
pub(crate) fn page(source: &str, test: &Test, document: &Document) -> String {
    let um = |value: Option<f64>| value.map_or_else(|| "–".into(), |um| significant(um, 4));
    let rows = document.diagonals.iter().map(|of| {
        let cells = [Some(of.e_um), of.b_um, Some(of.m_um), of.r_um].map(um);
        Row::new(format!("diagonal {}", of.diagonal), cells)
    });
    let largest = [Some(document.e_d_um), document.b_d_um, Some(document.m_d_um), document.r_d_um].map(um);
    let figures = Table::new(
        ["ISO 230-6", "E(D), µm", "B(D), µm", "M(D), µm", "R(D), µm"],
        rows.chain([Row::new("largest", largest)]),
    );
    let mut terms: Vec<(String, String, String)> = Vec::new();
    let mut put = |name: &str, unit: &str, value: f64, error: f64| {
        terms.push((name.into(), format!("{} {unit}", significant(value, 4)), significant(error, 2)));
    };
    put("squareness A0Z", "µrad", document.a0z.value, document.a0z.standard_error);
    put("squareness B0Z", "µrad", document.b0z.value, document.b0z.standard_error);
    put("squareness C0Y", "µrad", document.c0y.value, document.c0y.standard_error);
    put("diagonal scale", "ppm", document.scale.value, document.scale.standard_error);
    for scales in document.steps.iter().filter_map(|steps| steps.scales_ppm) {
        for (of, name) in scales.into_iter().zip(["scale X", "scale Y", "scale Z"]) {
            put(name, "ppm", of.value, of.standard_error);
        }
    }
    let terms = terms.into_iter().map(|(name, value, error)| Row::new(name, [value, error]));
    let mut page = Page::new("Diagonal displacement test")
        .top(summary([
            html! { (source) },
            html! { (document.test) " test" },
            html! { (document.readings) " readings" },
        ]))
        .top(super::super::warnings(&document.limits))
        .top(figures)
        .section("Deviation", deviations(test))
        .section("What the diagonals tell", Table::new(["term", "value", "standard error"], terms));
    for figure in shapes(document) {
        page = page.section("What the steps tell", figure);
    }
    page.document()
}
