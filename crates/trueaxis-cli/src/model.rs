//! A machine's error model in memory: from machine.toml, its folder, or a compiled .tcomp.

use crate::output::tell;
use anyhow::{Context, Result, anyhow, bail};
use std::path::{Path, PathBuf};
use trueaxis::Axis;
use trueaxis::compensation::{Compensation, requirement};
use trueaxis::tcomp::Tcomp;
use trueaxis_tables::Machine;

/// A machine, whatever form it came in.
pub(crate) fn machine(path: &Path) -> Result<Machine> {
    if path.extension().is_some_and(|e| e == "tcomp") {
        let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        return Ok(Machine::from_tcomp(&parsed(&bytes, path)?));
    }
    source(path)
}

/// A machine in source form; says how its tables are read where that is not commas and points.
pub(crate) fn source(path: &Path) -> Result<Machine> {
    Ok(Machine::read_telling(path, |how| tell(format_args!("note: {how}")))?)
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

/// Axes of the step: X, Y, Z, and the machine's rotary ones.
pub(crate) fn axis_count(machine: &Machine) -> usize {
    3 + machine.settings.axes.iter().filter(|a| a.axis.is_rotary()).count()
}

/// Builds the model that the machine's settings name and lends it out.
pub(crate) fn with_compensation<const N: usize, T>(
    machine: &Machine,
    passes: u8,
    user: impl FnOnce(&Compensation<'_, f64, f64, N>) -> Result<T>,
) -> Result<T> {
    let rows = |axis: Axis| machine.rows(axis);
    let mut memory = vec![0.0; requirement(&machine.settings, rows)];
    let compensation =
        Compensation::build(&machine.settings, rows, passes, &mut memory).map_err(|error| anyhow!("{error}"))?;
    user(&compensation)
}

/// A text file; comments (`#`, `;`) may be in any encoding, as instruments write them.
pub(crate) fn text(file: &Path) -> Result<String> {
    let bytes = std::fs::read(file).with_context(|| format!("cannot read {}", file.display()))?;
    let is_comment =
        |line: &[u8]| line.trim_ascii_start().starts_with(b"#") || line.trim_ascii_start().starts_with(b";");
    let lines = bytes.split(|byte| *byte == b'\n').zip(1..);
    for (line, number) in lines {
        if std::str::from_utf8(line).is_err() && !is_comment(line) {
            bail!("{}:{number}: found bytes that are not UTF-8, needed text in UTF-8", file.display());
        }
    }
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
