//! The printed table.

use std::fmt::{Error, Write};
use trueaxis::Axis;
use trueaxis_evaluation::identify::{IdentificationDocument, names};
use trueaxis_tables::text::{counted, degrees_of_freedom};

/// The result as a text table.
pub(super) fn table(document: &IdentificationDocument, axis: Axis) -> Result<String, Error> {
    let mut text = format!(
        "axis {}, {}, {}\n\n",
        document.axis,
        counted(document.set_ups.len(), "set-up"),
        counted(document.angles.len(), "angle")
    );
    write!(text, "{:>9}", "angle_deg")?;
    for name in names(axis) {
        write!(text, " {name:>9}")?;
    }
    writeln!(text, " {:>11} {:>9}", "residual_um", "condition")?;
    for angle in &document.angles {
        write!(text, "{:>9.3}", angle.angle_deg)?;
        for value in angle.values {
            write!(text, " {value:>9.3}")?;
        }
        writeln!(text, " {:>11.3} {:>9.2}", angle.residual_um, angle.condition)?;
    }
    write!(text, "{:>9}", "std. err.")?;
    for value in names(axis).iter().filter_map(|name| document.standard_errors.get(&name.to_lowercase())) {
        write!(text, " {:>9.3}", value.as_f64().unwrap_or(f64::NAN))?;
    }
    writeln!(text, "   (root mean square over the angles)")?;
    write!(text, "{:>9}", "± 95 %")?;
    for value in names(axis).iter().filter_map(|name| document.expanded_uncertainties.get(&name.to_lowercase())) {
        write!(text, " {:>9.3}", value.as_f64().unwrap_or(f64::NAN))?;
    }
    let freedom = degrees_of_freedom(document.degrees_of_freedom);
    writeln!(text, "   (Student's factor, {freedom})\n")?;
    let worst = document.angles.iter().map(|angle| angle.condition).fold(0.0, f64::max);
    let rank = document.angles.iter().map(|angle| angle.rank).min().unwrap_or(0);
    writeln!(text, "sigma of a reading  {:.3} µm, {freedom}", document.sigma_um)?;
    writeln!(text, "rank                {rank} of 6 at every angle, condition number at most {worst:.2}")?;
    writeln!(text, "location errors     {}", document.location_sentence())?;
    for set_up in &document.set_ups {
        if let Some([x, y, z]) = set_up.offset_um {
            writeln!(text, "offset at L {} H {}: {x:.3}, {y:.3}, {z:.3} µm", set_up.l_mm, set_up.h_mm)?;
        }
    }
    for warning in &document.warnings {
        writeln!(text, "note: {warning}")?;
    }
    Ok(text)
}
