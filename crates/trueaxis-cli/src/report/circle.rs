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
        .top(table(found));
    match polar(found, [true; 4]) {
        Some(figure) => page.section("Departures", figure),
        None => page,
    }
    .document()
}

fn table(found: &Evaluation) -> Table {
    let centre = found.section.letters();
    let row = |(name, circle): (&str, &Fitted)| match circle {
        Ok(circle) => {
            let centre = found.section.centre(circle.centre).into_iter().map(|(_, mm)| mm);
            let lengths = centre.chain([circle.radius]).map(|mm| decimals(mm, 6));
            Row::new(name, lengths.chain([significant(1e3 * circle.zone, 4)]).collect::<Vec<_>>())
        }
        Err(reason) => Row::whole(name, format!("none: {reason}")),
    };
    let rows = ["LSC", "MZC", "MCC", "MIC"].into_iter().zip(&found.circles).map(row);
    let centre: Vec<String> = centre.into_iter().map(|letter| format!("centre {letter} in mm")).collect();
    let names = ["circle"].into_iter().chain(centre.iter().map(String::as_str));
    Table::new(names.chain(["radius in mm", "zone in µm"]), rows)
}
