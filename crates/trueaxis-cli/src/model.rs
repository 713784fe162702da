//! A machine's error model in memory: from machine.toml, its folder, or a compiled .tcomp.

use crate::output::tell;
use anyhow::{Context, Result, anyhow, bail};
use std::path::{Path, PathBuf};
use trueaxis::tcomp::Tcomp;
pub(crate) use trueaxis_evaluation::by_axes;
use trueaxis_evaluation::model::takes_rise;
pub(crate) use trueaxis_evaluation::model::{passes, thermal, with_compensation};
use trueaxis_tables::Machine;
use trueaxis_tables::files::Folder;
use trueaxis_tables::text::read_text;

/// A machine, whatever form it came in.
pub(crate) fn machine(path: &Path) -> Result<Machine> {
    if path.extension().is_some_and(|e| e == "tcomp") {
        let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        return Ok(Machine::from_tcomp(&parsed(&bytes, path)?));
    }
    source(path)
}

/// A machine in source form; separators other than commas and decimal commas are reported.
pub(crate) fn source(path: &Path) -> Result<Machine> {
    let (folder, name) = Folder::of_machine(path);
    tell_left(path);
    Ok(Machine::read_from(&folder, &name, &mut |how| tell(format_args!("note: {how}")))?)
}

/// Says where a command was ended while it wrote a file of this machine.
pub(crate) fn tell_left(path: &Path) {
    for note in trueaxis_tables::output::left_notes(files(path)) {
        tell(format_args!("note: {note}"));
    }
}

/// The files of a machine, whatever form it came in.
pub(crate) fn files(path: &Path) -> Vec<PathBuf> {
    let alone = || vec![path.to_path_buf()];
    if path.extension().is_some_and(|e| e == "tcomp") {
        alone()
    } else {
        Machine::files(path).unwrap_or_else(|_| alone())
    }
}

/// Parses compiled bytes; the error names the file they came from.
pub(crate) fn parsed<'b>(bytes: &'b [u8], machine: &Path) -> Result<Tcomp<'b>> {
    Tcomp::parse(bytes).map_err(|error| anyhow!("{}: {error}", machine.display()))
}

/// Kelvin above the reference temperature of the machine; none without a temperature.
pub(crate) fn rise(temperature_c: Option<f64>, machine: &Machine) -> Result<f64> {
    let kelvin = temperature_c.map_or(0.0, |t| t - machine.settings.reference_temperature_c);
    if !takes_rise(machine, kelvin) {
        bail!("--temperature-c: found {kelvin} K above the reference, needed a growth of at most 10 mm and 1e-3");
    }
    Ok(kelvin)
}

/// A file of another program, whose comments may be in any encoding.
pub(crate) fn text(file: &Path) -> Result<String> {
    Ok(read_text(file, &['#', ';'])?)
}
