//! The page of `trueaxis evaluate probing`.

use maud::html;
use trueaxis_evaluation::probing::{Document, Record, form};
use trueaxis_report::number::significant;
use trueaxis_report::{Page, Row, Table, summary};

/// The whole page; `source` is the name of the record, `figures` those of all runs.
pub(crate) fn page(source: &str, record: &Record, document: &Document, figures: &[(&'static str, String)]) -> String {
    let dash = || "–".to_owned();
    let rows = document.runs.iter().map(|run| {
        let [x, y, z] = run.centre_mm.map(|mm| format!("{mm:.4}"));
        let diameter = run.diameter_mm.map_or_else(dash, |mm| format!("{mm:.4}"));
        let form = run.form_um.map_or_else(dash, |um| significant(um, 3));
        Row::new(format!("run {}", run.run), [run.points.to_string(), x, y, z, diameter, form])
    });
    let runs = Table::new(["ISO 230-10", "points", "X, mm", "Y, mm", "Z, mm", "diameter, mm", "P_FTU, µm"], rows);
    let figures = figures.iter().map(|(name, of)| Row::new(*name, [of.clone()]));
    let mut page = Page::new("Probing test")
        .top(summary([html! { (source) }, html! { (document.feature) }, html! { (document.runs.len()) " runs" }]))
        .top(super::super::warnings(&document.notes))
        .top(Table::new(["figure", "value"], figures))
        .section("Runs", runs);
    if let Some(figure) = form(record) {
        page = page.section("Form", figure);
    }
    page.document()
}
