//! The lines printed by `trueaxis thermal fit`.

use anyhow::Result;
use std::fmt::Write;
use trueaxis_evaluation::thermal::ThermalDocument;
use trueaxis_report::number::significant;

pub(super) fn table(d: &ThermalDocument) -> Result<String> {
    let mut text = format!("{} rows, curves zero at {} °C\n\nlag, s\n", d.rows, d.reference_c);
    for sensor in &d.sensors {
        writeln!(text, "  {:<10} {:>9}", sensor.name, significant(sensor.lag_s, 3))?;
    }
    if let Some(lag) = d.spindle_lag_s {
        writeln!(text, "  {:<10} {:>9}", "spindle", significant(lag, 3))?;
    }
    for axis in &d.axes {
        writeln!(text, "\nE{0}{0}: {1} µm RMS left by the fit", axis.axis, significant(axis.rms_um, 3))?;
        for curve in &axis.curves {
            let unit = if curve.of == "spindle" { ["rpm", "µrad"] } else { ["°C", "µm/m"] };
            let parts = [("µm", &curve.offset_um, &curve.offset_error_um), (unit[1], &curve.slope, &curve.slope_error)];
            for (of, values, errors) in parts {
                if values.iter().all(|value| *value == 0.0) {
                    continue;
                }
                write!(text, "  {:<10}", curve.of)?;
                for ((knot, value), error) in curve.knots.iter().zip(values).zip(errors) {
                    write!(
                        text,
                        "  {} ± {} {of} at {} {}",
                        significant(*value, 3),
                        significant(*error, 2),
                        significant(*knot, 3),
                        unit[0]
                    )?;
                }
                writeln!(text)?;
            }
        }
    }
    writeln!(text, "\ncycle  axis   drift, µm    left, µm    RMS, µm    left")?;
    for own in &d.cycles {
        writeln!(
            text,
            "{:>5}  {:<4} {:>11} {:>11} {:>10}  {:>5.1} %{}",
            own.cycle,
            own.axis,
            significant(own.drift_um, 3),
            significant(own.left_um, 3),
            significant(own.left_rms_um, 3),
            1e2 * own.left_um / own.drift_um.max(f64::MIN_POSITIVE),
            if own.held_out { "  held out" } else { "" }
        )?;
    }
    for out in &d.left_out {
        writeln!(text, "left out: {}, {}", out.name, out.reason)?;
    }
    for own in &d.unconfirmed {
        writeln!(
            text,
            "unconfirmed: {} rpm, run in cycle {} only, so that no other cycle predicts it",
            own.rpm, own.cycle
        )?;
    }
    for own in &d.missing {
        writeln!(text, "{own}")?;
    }
    let [drift, left] = d.held_out_um;
    writeln!(
        text,
        "\nheld out: {} µm left of a largest drift of {} µm ({:.1} %)",
        significant(left, 3),
        significant(drift, 3),
        1e2 * left / drift.max(f64::MIN_POSITIVE)
    )?;
    Ok(text)
}
