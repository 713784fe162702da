//! The result in plain text and in tables, at the top of the page.

use super::{AxisReport, ErrorSize, FaultEntry, Report};
use maud::{Markup, html};
use trueaxis_report::{
    Row, Table, emphasised,
    number::{count, decimals, percent, quantity, significant},
};

/// Summary, tables, faults and notes.
pub(super) fn top(report: &Report) -> Markup {
    html! {
        (run(report))
        p.result { (result(report)) }
        div.tables {
            (contour_table(report))
            @if report.latency.steps > 0 { (latency_table(report)) }
        }
        @if !report.axes.is_empty() { (axis_table(&report.axes)) }
        h3 { "Faults" }
        @if report.faults.is_empty() { p { "None." } } @else { (fault_table(&report.faults)) }
        @if !report.notes.is_empty() {
            h3 { "Notes" }
            ul { @for note in &report.notes { li { (note) } } }
        }
    }
}

fn run(report: &Report) -> Markup {
    let named = [("machine", &report.machine), ("chain", &report.chain), ("program", &report.program)];
    let named = named.into_iter().filter(|(_, value)| !value.is_empty());
    let mut parts: Vec<Markup> = named.map(|(name, value)| emphasised(name, value)).collect();
    let rate = significant(report.servo_rate_hz, 4);
    parts.push(html! { (count(report.cycles)) " servo cycles at " (rate) " Hz" });
    if report.servo_rate_hz > 0.0 {
        let seconds = report.cycles as f64 / report.servo_rate_hz;
        parts.push(html! { (quantity(seconds, "s")) " of machine time" });
    }
    trueaxis_report::summary(parts)
}

fn result(report: &Report) -> Markup {
    let before = report.contour_error.uncompensated.max_um;
    let after = report.contour_error.full.unwrap_or(report.contour_error.compensated).max_um;
    let size = |um: f64| html! { strong { (quantity(um, "µm")) } };
    let verb = if after < before { "fell" } else { "rose" };
    let share = if before > 0.0 { format!(" (to {})", percent(after, before)) } else { String::new() };
    html! {
        "The largest contour error of the tool tip "
        @if (after - before).abs() > 0.0 {
            (verb) " from " (size(before)) " to " (size(after)) (share) "."
        } @else {
            "stayed at " (size(before)) "."
        }
    }
}

fn contour_table(report: &Report) -> Table {
    let errors = &report.contour_error;
    let row = |name: &str, size: &ErrorSize| {
        let share = percent(size.max_um, errors.uncompensated.max_um);
        Row::new(name, [significant(size.max_um, 3), significant(size.rms_um, 3), share])
    };
    let rows = [
        row("without compensation", &errors.uncompensated),
        row("with compensation", &errors.compensated),
        row("perfect geometry", &errors.servo_only),
    ];
    let rows = rows.into_iter().chain(errors.full.as_ref().map(|full| row("full", full)));
    Table::new(["", "max in µm", "RMS in µm", "max, share of the first"], rows)
        .caption("Contour error of the true tool tip")
}

fn latency_table(report: &Report) -> Markup {
    let latency = &report.latency;
    let columns = ["min", "p50", "p99", "p99.99", "max"];
    let rest = [latency.p50_ns, latency.p99_ns, latency.p99_99_ns, latency.max_ns].map(count);
    let table = Table::new(columns, [Row::new(count(latency.min_ns), rest)]).caption("Latency of the step in ns");
    html! {
        div {
            (table)
            p {
                (count(latency.over_budget)) " of " (count(latency.steps)) " steps over the budget of "
                (count(latency.budget_ns)) " ns; " (count(latency.missed_deadlines)) " longer than the period of "
                (count(latency.period_ns)) " ns."
            }
        }
    }
}

/// Largest magnitude of a series; NaN if it has no defined value.
fn largest(series: &[[f64; 2]]) -> f64 {
    let magnitudes = series.iter().map(|point| point[1].abs()).filter(|value| value.is_finite());
    magnitudes.max_by(f64::total_cmp).unwrap_or(f64::NAN)
}

fn axis_table(axes: &[AxisReport]) -> Table {
    let row = |axis: &AxisReport| {
        let [magnitude, slope, acceleration] =
            if axis.rotary { ["µrad", "mrad/s", "rad/s²"] } else { ["µm", "mm/s", "m/s²"] };
        let used = |series: &[[f64; 2]], limit: f64, unit: &str| {
            let found = largest(series);
            [quantity(found, unit), quantity(limit, unit), percent(found, limit)]
        };
        let correction = used(&axis.correction, axis.magnitude_limit, magnitude);
        let slope = used(&axis.slope, axis.slope_limit, slope);
        let cells = correction.into_iter().chain(slope).chain([quantity(axis.acceleration_limit, acceleration)]);
        Row::new(&axis.name, cells)
    };
    let head = ["axis", "largest correction", "limit", "used", "largest slope", "limit", "used", "acceleration limit"];
    Table::new(head, axes.iter().map(row)).caption("Correction and its limits")
}

fn fault_table(faults: &[FaultEntry]) -> Table {
    let rows = faults.iter().map(|fault| {
        let time = decimals(if fault.time_s.is_finite() { fault.time_s } else { 0.0 }, 4);
        Row::new(format!("{time} s"), [fault.code.clone(), count(fault.cycles), fault.description.clone()])
    });
    Table::new(["first at", "code", "cycles", "description"], rows).words(&[1, 3])
}
