//! The page of `trueaxis ballbar`.

use maud::html;
use trueaxis_evaluation::ballbar::{BallbarDocument, Test, left, polar, values};
use trueaxis_report::number::significant;
use trueaxis_report::{Page, Row, Table, summary};

/// The whole page; `source` is the name of the record.
pub(crate) fn page(source: &str, test: &Test, document: &BallbarDocument) -> String {
    let um = |value: Option<f64>| value.map_or_else(|| "–".into(), |um| significant(um, 4));
    let figures = Table::new(
        ["ISO 230-4", "both directions", "counterclockwise", "clockwise"],
        [
            Row::new("G, µm", [um(document.g_b_um), um(document.g_um.ccw), um(document.g_um.cw)]),
            Row::new("F max, µm", ["".into(), um(document.f_max_um.ccw), um(document.f_max_um.cw)]),
            Row::new("F min, µm", ["".into(), um(document.f_min_um.ccw), um(document.f_min_um.cw)]),
            Row::new("H, µm", [um(document.h_um), "".into(), "".into()]),
        ],
    );
    let causes = values(document).into_iter().map(|[name, value, error]| Row::new(name, [value, error]));
    let causes = Table::new(["cause", "value", "± with 95 %"], causes);
    let shares = document.shares.iter().map(|share| {
        let rms = format!("{} µm", significant(share.rms_um, 3));
        Row::new(share.cause.clone(), [format!("{:.1} %", 100.0 * share.share), rms])
    });
    let readings = format!("{} readings", document.readings);
    let radius = format!("plane {}, radius {} mm", document.plane, document.radius_mm);
    Page::new("Circular test")
        .top(summary([html! { (source) }, html! { (readings) }, html! { (radius) }]))
        .top(super::warnings(&document.warnings))
        .top(figures)
        .section("Deviation", polar(test))
        .section("Causes", html! { (causes) (Table::new(["cause", "share", "RMS"], shares)) })
        .section("Residuals", left(test))
        .document()
}
