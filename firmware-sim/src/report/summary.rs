//! The result in plain words and in tables, at the top of the page.

use super::{
    AxisReport, ErrorSize, Report,
    number::{count, decimals, escape, significant},
};

/// Summary, tables, faults and notes.
pub(super) fn html(report: &Report) -> String {
    [
        run(report),
        format!("<p class=\"result\">{}</p>\n", result(report)),
        "<div class=\"tables\">\n".to_owned(),
        contour_table(report),
        latency_table(report),
        "</div>\n".to_owned(),
        axis_table(&report.axes),
        faults(report),
        notes(report),
    ]
    .concat()
}

fn run(report: &Report) -> String {
    let mut parts = Vec::new();
    for (name, value) in [("machine", &report.machine), ("chain", &report.chain), ("program", &report.program)] {
        if !value.is_empty() {
            parts.push(format!("{name} <strong>{}</strong>", escape(value)));
        }
    }
    parts.push(format!("{} servo cycles at {} Hz", count(report.cycles), significant(report.servo_rate_hz, 4)));
    if report.servo_rate_hz > 0.0 {
        parts.push(format!("{} s of machine time", significant(report.cycles as f64 / report.servo_rate_hz, 3)));
    }
    format!("<p class=\"run\">{}</p>\n", parts.join(" · "))
}

fn result(report: &Report) -> String {
    let before = report.contour_error.uncompensated.max_um;
    let after = report.contour_error.compensated.max_um;
    let verb = if after < before {
        "fell"
    } else if after > before {
        "rose"
    } else {
        "stayed"
    };
    let from_to = if verb == "stayed" {
        format!("at <strong>{} µm</strong>", significant(before, 3))
    } else {
        format!("from <strong>{} µm</strong> to <strong>{} µm</strong>", significant(before, 3), significant(after, 3))
    };
    let share =
        if before > 0.0 && verb != "stayed" { format!(" (to {})", percent(after, before)) } else { String::new() };
    format!("The largest contour error of the tool tip {verb} {from_to}{share}.")
}

fn percent(part: f64, whole: f64) -> String {
    let ratio = 100.0 * part / whole;
    if whole > 0.0 && ratio.is_finite() {
        format!("{} %", significant(ratio, if ratio < 10.0 { 2 } else { 3 }))
    } else {
        "–".to_owned()
    }
}

fn contour_table(report: &Report) -> String {
    let errors = &report.contour_error;
    let row = |name: &str, size: &ErrorSize| {
        format!(
            "<tr><th>{name}</th><td>{}</td><td>{}</td><td>{}</td></tr>\n",
            significant(size.max_um, 3),
            significant(size.rms_um, 3),
            percent(size.max_um, errors.uncompensated.max_um)
        )
    };
    format!(
        "<table><caption>Contour error of the true tool tip</caption>\n<thead><tr><th></th><th>max in µm</th>\
         <th>RMS in µm</th><th>max against uncompensated</th></tr></thead>\n<tbody>\n{}{}{}</tbody></table>\n",
        row("uncompensated", &errors.uncompensated),
        row("compensated", &errors.compensated),
        row("servo only (perfect geometry)", &errors.servo_only)
    )
}

fn latency_table(report: &Report) -> String {
    let latency = &report.latency;
    if latency.steps == 0 {
        return String::new();
    }
    let columns = [
        ("min", latency.min_ns),
        ("p50", latency.p50_ns),
        ("p99", latency.p99_ns),
        ("p99.99", latency.p99_99_ns),
        ("max", latency.max_ns),
    ];
    let heads: String = columns.iter().map(|column| format!("<th>{}</th>", column.0)).collect();
    let cells: String = columns.iter().map(|column| format!("<td>{}</td>", count(column.1))).collect();
    format!(
        "<div><table><caption>Latency of the step in ns</caption>\n<thead><tr>{heads}</tr></thead>\n\
         <tbody><tr>{cells}</tr></tbody></table>\n<p>{} of {} steps over the budget of {} ns; \
         {} longer than the period of {} ns.</p></div>\n",
        count(latency.over_budget),
        count(latency.steps),
        count(latency.budget_ns),
        count(latency.missed_deadlines),
        count(latency.period_ns)
    )
}

/// Largest magnitude of a series; `None` if it has no defined value.
fn largest(series: &[[f64; 2]]) -> Option<f64> {
    series.iter().map(|point| point[1].abs()).filter(|value| value.is_finite()).max_by(f64::total_cmp)
}

fn axis_table(axes: &[AxisReport]) -> String {
    if axes.is_empty() {
        return String::new();
    }
    let row = |axis: &AxisReport| {
        let [magnitude, slope, acceleration] =
            if axis.rotary { ["µrad", "mrad/s", "rad/s²"] } else { ["µm", "mm/s", "m/s²"] };
        let pair = |series: &[[f64; 2]], limit: f64, unit: &str| {
            let found = largest(series).unwrap_or(f64::NAN);
            format!(
                "<td>{} {unit}</td><td>{} {unit}</td><td>{}</td>",
                significant(found, 3),
                significant(limit, 3),
                percent(found, limit)
            )
        };
        format!(
            "<tr><th>{}</th>{}{}<td>{} {acceleration}</td></tr>\n",
            escape(&axis.name),
            pair(&axis.correction, axis.magnitude_limit, magnitude),
            pair(&axis.slope, axis.slope_limit, slope),
            significant(axis.acceleration_limit, 3)
        )
    };
    format!(
        "<table><caption>Correction and its limits</caption>\n<thead><tr><th>axis</th>\
         <th>largest correction</th><th>limit</th><th>used</th><th>largest slope</th><th>limit</th><th>used</th>\
         <th>acceleration limit</th></tr></thead>\n<tbody>\n{}</tbody></table>\n",
        axes.iter().map(row).collect::<String>()
    )
}

fn faults(report: &Report) -> String {
    if report.faults.is_empty() {
        return "<h3>Faults</h3>\n<p>None.</p>\n".to_owned();
    }
    let rows: String = report
        .faults
        .iter()
        .map(|fault| {
            format!(
                "<tr><td>{} s</td><td class=\"words\">{}</td><td>{}</td><td class=\"words\">{}</td></tr>\n",
                decimals(if fault.time_s.is_finite() { fault.time_s } else { 0.0 }, 4),
                escape(&fault.code),
                count(fault.cycles),
                escape(&fault.description)
            )
        })
        .collect();
    format!(
        "<h3>Faults</h3>\n<table><thead><tr><th>first at</th><th class=\"words\">code</th><th>cycles</th>\
         <th class=\"words\">what happened</th></tr></thead>\n<tbody>\n{rows}</tbody></table>\n"
    )
}

fn notes(report: &Report) -> String {
    if report.notes.is_empty() {
        return String::new();
    }
    let items: String = report.notes.iter().map(|note| format!("<li>{}</li>\n", escape(note))).collect();
    format!("<h3>Notes</h3>\n<ul>\n{items}</ul>\n")
}
