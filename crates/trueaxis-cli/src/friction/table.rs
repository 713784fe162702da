//! The printed table.

use std::fmt::{Error, Write};
use trueaxis_evaluation::friction::FrictionDocument;
use trueaxis_report::number::significant;

/// The result as a text table.
pub(super) fn table(document: &FrictionDocument) -> Result<String, Error> {
    let mut text = format!("{} samples at {} Hz\n", document.samples, significant(1.0 / document.period_s, 4));
    for own in &document.axes {
        let (f, fe) = (&own.friction, &own.expanded_uncertainties.friction);
        let (d, de) = (&own.drive, &own.expanded_uncertainties.drive);
        writeln!(text, "\naxis {}, {} reversals; ± with 95 %", own.axis, own.reversals)?;
        let mut row = |name: &str, value: f64, error: Option<f64>, held: &str| {
            let error = error.map_or_else(|| held.to_owned(), |error| format!("± {}", significant(error, 2)));
            writeln!(text, "  {name:<36} {:>9}  {error}", significant(value, 4))
        };
        row("Coulomb friction F_c/K_vp, mm/s", f.coulomb_mm_per_s, fe.coulomb_mm_per_s, "held")?;
        row("pre-sliding z, µm", f.presliding_um, fe.presliding_um, "held")?;
        row("Stribeck share s", f.stribeck_share, fe.stribeck_share, "held")?;
        row("Stribeck velocity v_s, mm/s", f.stribeck_velocity_mm_per_s, fe.stribeck_velocity_mm_per_s, "held")?;
        row("viscous friction d/K_vp", f.viscous, fe.viscous, "held")?;
        let given = if own.drive_found { "held" } else { "the machine's" };
        row("position gain K_v, 1/s", d.position_gain_per_s, de.position_gain_per_s, given)?;
        row("velocity gain K_vp, 1/s", d.velocity_gain_per_s, de.velocity_gain_per_s, given)?;
        row("reset time τ, s", d.reset_time_s, de.reset_time_s, given)?;
        row("velocity feed-forward k_ff", d.velocity_feed_forward, de.velocity_feed_forward, given)?;
        writeln!(
            text,
            "  fit: {} µm left, {} % of the spikes explained, {} parameters, condition number {}",
            significant(own.residual_um, 3),
            significant(100.0 * own.explained, 4),
            own.fitted,
            significant(own.condition, 3)
        )?;
        let g = &own.glitch_um;
        for (name, size) in [("before", &g.before), ("predicted", &g.predicted), ("after", &g.after)] {
            writeln!(
                text,
                "  spikes {name:<9} {:>7} µm largest, {:>7} µm RMS",
                significant(size.max, 3),
                significant(size.rms, 3)
            )?;
        }
    }
    for warning in &document.warnings {
        writeln!(text, "note: {warning}")?;
    }
    Ok(text)
}
