//! The page of `trueaxis evaluate points`.

use maud::html;
use trueaxis_evaluation::points::{Document, Found, Left, Points, errors, map, residuals};
use trueaxis_report::number::significant;
use trueaxis_report::{Page, Row, Table, side_by_side, summary};

/// The whole page; `source` is the name of the points' file.
pub(crate) fn page(source: &str, points: &Points, found: &Found, document: &Document) -> String {
    let functions = document.functions.iter().map(|of| {
        let [low, high] = of.range.map(|value| significant(value, 3));
        let unit = if of.unit == "um" { "µm" } else { "µrad" };
        Row::new(of.name.clone(), [low, high, significant(of.standard_error, 2), unit.to_owned()])
    });
    let squareness = [
        ("A0Z", document.squareness.a0z_urad),
        ("B0Z", document.squareness.b0z_urad),
        ("C0Y", document.squareness.c0y_urad),
    ]
    .into_iter()
    .map(|(name, of)| {
        let value = significant(of.value, 3);
        Row::new(name, [value.clone(), value, significant(of.standard_error, 2), "µrad".to_owned()])
    });
    let terms = Table::new(["error", "from", "to", "standard error", "unit"], functions.chain(squareness));
    let of = |name: &str, left: Left| {
        Row::new(
            name,
            [left.points.to_string(), significant(left.max_um, 3), significant(left.rms_um, 3), left.line.to_string()],
        )
    };
    let rows = [of("measured", document.before), of("left", document.left)];
    let rows = rows.into_iter().chain(document.held_out.map(|left| of("held out", left)));
    let deviations = Table::new(["µm", "points", "largest", "RMS", "largest in line"], rows);
    let mut page = Page::new("Measured points")
        .top(summary([
            html! { (source) },
            html! { (document.points) " points" },
            html! { "rank " (document.rank) " of " (document.unknowns) },
            html! { "condition number " (significant(document.condition, 3)) },
        ]))
        .top(super::super::warnings(&document.notes))
        .top(deviations)
        .section("What is left", side_by_side(residuals(points, found)))
        .section("Where it is left", map(points, found));
    for figure in errors(found) {
        page = page.section("Errors", figure);
    }
    page.section("All errors", terms).document()
}
