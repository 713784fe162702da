//! The page of `trueaxis evaluate r-test`.

use maud::html;
use trueaxis_evaluation::r_test::{Document, Found, Record, displacements, left};
use trueaxis_report::number::significant;
use trueaxis_report::{Page, Row, Table, summary};

/// The whole page; `source` is the name of the record.
pub(crate) fn page(source: &str, record: &Record, found: &Found, document: &Document) -> String {
    let terms = document.terms.iter().map(|of| {
        let unit = if of.unit == "um" { "µm" } else { "µrad" };
        let value = format!("{} {unit}", significant(of.value, 4));
        Row::new(of.name.clone(), [value, significant(of.standard_error, 2), significant(of.before, 4)])
    });
    Page::new("R-test")
        .top(summary([
            html! { (source) },
            html! { (document.readings) " readings" },
            html! { "left " (significant(document.left_rms_um, 3)) " µm RMS of " (significant(document.rms_um, 3)) },
            html! { "rank " (document.rank) ", condition number " (significant(document.condition, 3)) },
        ]))
        .top(super::super::warnings(&document.notes))
        .top(Table::new(["location error", "found", "standard error", "machine has"], terms))
        .section("Displacement", displacements(record))
        .section("What is left", left(found))
        .document()
}
