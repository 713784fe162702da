//! A calibration as text.

use anyhow::Result;
use std::fmt::Write;
use trueaxis_evaluation::calibrate::CalibrationDocument;
use trueaxis_report::number::significant;
use trueaxis_tables::text::degrees_of_freedom;

pub(super) fn table(d: &CalibrationDocument) -> Result<String> {
    let mut text = format!("{} touches on {}", d.touches, d.machine);
    text.push_str(if d.compensated { ", compensated while probed\n\n" } else { "\n\n" });
    for term in &d.terms {
        let (value, error) = (significant(term.value, 4), significant(term.standard_error, 2));
        writeln!(text, "{:<22} {value:>10} ± {error} {}", term.name, term.unit)?;
    }
    let error = significant(d.tip_radius_standard_error_um, 2);
    writeln!(text, "\nradius of the tip {:.5} mm ± {error} µm", d.tip_radius_mm)?;
    for size in &d.artefacts {
        writeln!(text, "{}: {:.5} for {}", size.name, size.found, size.stated)?;
    }
    let um = |value: f64| significant(value, 3);
    writeln!(
        text,
        "\nsigma of a touch {} µm ({} stated), measured {} µm RMS, {}, rank {}, condition {}",
        um(d.sigma_um),
        um(d.repeatability_um),
        um(d.signal_um),
        degrees_of_freedom(d.degrees_of_freedom),
        d.rank,
        significant(d.condition, 2)
    )?;
    for warning in &d.warnings {
        writeln!(text, "note: {warning}")?;
    }
    Ok(text)
}
