//! A machine's error model in memory: from machine.toml, its folder, or a compiled .tcomp.

use crate::output::tell;
use anyhow::{Context, Result, anyhow, bail};
use std::path::{Path, PathBuf};
use trueaxis::Axis;
use trueaxis::check;
use trueaxis::compensation::ThermalLine;
use trueaxis::tcomp::Tcomp;
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
    Ok(Machine::read_from(&folder, &name, &mut |how| tell(format_args!("note: {how}")))?)
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

pub(crate) use trueaxis_evaluation::model::{by_axes, with_compensation};

/// Look-ups of the exact inverse: those asked for, or as many as the machine needs.
pub(crate) fn passes(machine: &Machine, asked: Option<u8>) -> Result<u8> {
    let needed = || check::machine_passes(&machine.settings, |axis| machine.rows(axis));
    asked.map_or_else(needed, Ok).map_err(|error| anyhow!("{error}"))
}

/// Kelvin above the reference temperature of the machine; none without a temperature.
pub(crate) fn rise(temperature_c: Option<f64>, machine: &Machine) -> Result<f64> {
    let kelvin = temperature_c.map_or(0.0, |t| t - machine.settings.reference_temperature_c);
    for settings in &machine.settings.axes {
        if ThermalLine::<f64>::for_axis(&settings.thermal, kelvin).is_none() {
            bail!("--temperature-c: found {kelvin} K above the reference, needed a growth of at most 10 mm and 1e-3");
        }
    }
    Ok(kelvin)
}

/// Thermal growth of the axes of the step.
pub(crate) fn thermal<const N: usize>(machine: &Machine, axes: &[Axis; N], kelvin: f64) -> [ThermalLine<f64>; N] {
    axes.map(|axis| {
        let own = machine.settings.axis(axis);
        own.and_then(|own| ThermalLine::for_axis(&own.thermal, kelvin)).unwrap_or_default()
    })
}

/// A file of another program, whose comments may be in any encoding.
pub(crate) fn text(file: &Path) -> Result<String> {
    Ok(read_text(file, &['#', ';'])?)
}
