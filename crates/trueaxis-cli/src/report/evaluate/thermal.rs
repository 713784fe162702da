//! The page of `trueaxis evaluate thermal`.

use maud::html;
use trueaxis_evaluation::thermal_test::{Document, Test, distortions, temperatures};
use trueaxis_report::number::significant;
use trueaxis_report::{Page, Row, Table, summary};

/// The whole page; `source` is the name of the record.
pub(crate) fn page(source: &str, test: &Test, document: &Document) -> String {
    let rows = document.positions.iter().flat_map(|place| {
        place.channels.iter().map(move |of| {
            let unit = if of.unit == "um" { "µm" } else { "µrad" };
            let name = if document.positions.len() > 1 {
                format!("{}, position {}", of.name, place.position)
            } else {
                of.name.clone()
            };
            let [range, first, worst, from, end] =
                [of.range, of.first_period, of.worst_period, of.worst_from_min, of.end].map(|v| significant(v, 4));
            Row::new(name, [range, first, worst, from, end, unit.to_owned()])
        })
    });
    let figures = Table::new(["ISO 230-3", "range", "first period", "worst period", "from, min", "end", "unit"], rows);
    let mut page = Page::new("Thermal test")
        .top(summary([
            html! { (source) },
            html! { (document.test) },
            html! { (significant(document.duration_min, 4)) " min, period " (significant(document.period_min, 4)) " min" },
        ]))
        .top(super::super::warnings(&document.notes))
        .top(figures);
    for figure in distortions(test) {
        page = page.section("Distortion", figure);
    }
    if let Some(figure) = temperatures(test) {
        page = page.section("Temperature", figure);
    }
    page.document()
}
