//! The page of `trueaxis thermal fit`.

use maud::html;
use trueaxis_evaluation::thermal::{FittedRecording, ThermalDocument, figure, residuals};
use trueaxis_report::number::significant;
use trueaxis_report::{Page, Row, Table, summary};

/// The whole page; `source` is the name of the record.
pub(crate) fn page(source: &str, found: &FittedRecording, document: &ThermalDocument) -> String {
    let um = |value: f64| significant(value, 3);
    let cycles = document.cycles.iter().map(|own| {
        let share = format!("{:.1} %", 1e2 * own.left_um / own.drift_um.max(f64::MIN_POSITIVE));
        let held_out = if own.held_out { "held out" } else { "" };
        let cells = [um(own.drift_um), um(own.left_um), um(own.left_rms_um), share, held_out.into()];
        Row::new(format!("E{0}{0}, cycle {1}", own.axis, own.cycle), cells)
    });
    let cycles = Table::new(["", "largest drift, µm", "left, µm", "left RMS, µm", "left", ""], cycles);
    let spindle = document.spindle_lag_s.map(|lag| Row::new("spindle", [um(lag)]));
    let lags = document.sensors.iter().map(|sensor| Row::new(sensor.name.clone(), [um(sensor.lag_s)])).chain(spindle);
    let curves = document.axes.iter().flat_map(|axis| {
        axis.curves.iter().map(|curve| {
            let list = |values: &[f64], errors: &[f64]| {
                let pairs = values
                    .iter()
                    .zip(errors)
                    .map(|(value, error)| format!("{} ± {}", um(*value), significant(*error, 2)));
                pairs.collect::<Vec<_>>().join(", ")
            };
            let knots = curve.knots.iter().map(|knot| um(*knot)).collect::<Vec<_>>().join(", ");
            let offsets = list(&curve.offset_um, &curve.offset_error_um);
            let slopes = list(&curve.slope, &curve.slope_error);
            Row::new(format!("E{0}{0}, {1}", axis.axis, curve.of), [knots, offsets, slopes])
        })
    });
    let curves = Table::new(["", "knots, °C or rpm", "offset or growth, µm", "slope, µm/m, or tilt, µrad"], curves);
    let left_out = document.left_out.iter().map(|out| Row::new(out.name.clone(), [out.reason.to_owned()]));
    let unconfirmed = document.unconfirmed.iter().map(|own| {
        let why = format!("run in cycle {} only, so that no other cycle predicts it", own.cycle);
        Row::new(format!("{} rpm", own.rpm), [why])
    });
    let unconfirmed = Table::new(["speed", "why"], unconfirmed);
    let missing = document.missing.iter().map(|own| {
        let found = [own.rows.to_string(), format!("{:.0}", own.found_s), format!("{:.0}", own.interval_s)];
        Row::new(format!("line {}, cycle {}", own.line, own.cycle), found)
    });
    let missing = Table::new(["where", "rows", "time without a row, s", "elsewhere, s"], missing);
    let [drift, left] = document.held_out_um;
    let rows = format!("{} rows", document.rows);
    let axes = &found.recording.record.axes;
    let page = Page::new("Thermal growth")
        .top(summary([html! { (source) }, html! { (rows) }, html! { "zero at " (document.reference_c) " °C" }]))
        .top(html! {
            p.result {
                "Of a largest drift of " strong { (um(drift)) " µm" } " in cycles that took no part in the fit, "
                strong { (um(left)) " µm" } " remains."
            }
        })
        .top(cycles)
        .section(
            "Held-out cycles",
            html! { @for axis in axes { @if let Some(figure) = figure(found, *axis) { (figure) } } },
        )
        .section("Remaining drift", html! { @for axis in axes { (residuals(found, *axis)) } })
        .section("Curves", html! { (Table::new(["cause", "lag, s"], lags)) (curves) })
        .section("Left out", html! { (Table::new(["sensor", "why"], left_out)) });
    let page =
        if document.unconfirmed.is_empty() { page } else { page.section("Unconfirmed", html! { (unconfirmed) }) };
    let page = if document.missing.is_empty() { page } else { page.section("Missing rows", html! { (missing) }) };
    page.document()
}
