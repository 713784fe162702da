//! A machine's error model in memory: from machine.toml, its folder, or a compiled .tcomp.

use crate::output::report_line;
use anyhow::{Result, bail};
use std::path::Path;
pub(crate) use trueaxis_evaluation::by_axes;
use trueaxis_evaluation::model::{self, takes_rise};
pub(crate) use trueaxis_evaluation::model::{files, parsed};
use trueaxis_tables::Machine;
use trueaxis_tables::text::read_text;

/// Reads a machine in either form.
pub(crate) fn machine(path: &Path) -> Result<Machine> {
    model::machine(path, &mut note)
}

/// Reads a machine in source form; reports separators other than commas and decimal commas.
pub(crate) fn source(path: &Path) -> Result<Machine> {
    model::source(path, &mut note)
}

/// Prints a note on how an input was read.
pub(crate) fn note(text: String) {
    report_line(format_args!("note: {text}"));
}

/// Kelvin above the machine's reference temperature; 0 without a temperature.
pub(crate) fn rise(temperature_c: Option<f64>, machine: &Machine) -> Result<f64> {
    let kelvin = temperature_c.map_or(0.0, |t| t - machine.settings.reference_temperature_c);
    if !takes_rise(machine, kelvin) {
        bail!("--temperature-c: found {kelvin} K above the reference, needed a growth of at most 10 mm and 1e-3");
    }
    Ok(kelvin)
}

/// Reads a file of another program, whose comments may be in any encoding.
pub(crate) fn text(file: &Path) -> Result<String> {
    Ok(read_text(file, &['#', ';'])?)
}
