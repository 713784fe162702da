//! The page of `trueaxis circle`.

use maud::html;
use trueaxis_evaluation::circle::{Evaluation, Fitted, polar};
use trueaxis_report::{
    Page, Row, Table,
    number::{decimals, significant},
    summary,
};

/// The whole page; `source` is the name of the points' file.
pub(crate) fn page(source: &str, found: &Evaluation) -> String {
    let page = Page::new("Reference circles")
        .top(summary([html! { (source) }, html! { (found.points.len()) " points" }, html! { "ISO 12181-1" }]))
        .top(table(&found.circles));
    match polar(found, [true; 4]) {
        Some(figure) => page.section("Departures", figure),
        None => page,
    }
    .document()
}

fn table(circles: &[Fitted; 4]) -> Table {
    let row = |(name, circle): (&str, &Fitted)| match circle {
        Ok(circle) => {
            let [x, y, radius] = [circle.centre[0], circle.centre[1], circle.radius].map(|mm| decimals(mm, 6));
            Row::new(name, [x, y, radius, significant(1e3 * circle.zone, 4)])
        }
        Err(reason) => Row::whole(name, format!("none: {reason}")),
    };
    let rows = ["LSC", "MZC", "MCC", "MIC"].into_iter().zip(circles).map(row);
    Table::new(["circle", "centre x in mm", "centre y in mm", "radius in mm", "zone in µm"], rows)
}
