//! A machine from its files, and its error model in memory.

use anyhow::{Context, Result, anyhow};
use std::path::{Path, PathBuf};
use trueaxis::Axis;
use trueaxis::check;
use trueaxis::compensation::{Compensation, ThermalLine, requirement};
use trueaxis::machine::{AxisSettings, ErrorModel};
use trueaxis::tcomp::Tcomp;
use trueaxis_tables::files::Folder;
use trueaxis_tables::output::left_notes;
use trueaxis_tables::{Machine, Table};

/// A machine from its machine.toml, its folder, or a compiled .tcomp; `note` receives the notes of [`source`].
///
/// # Errors
/// A file that cannot be read, with file, line, the value found and the value needed.
pub fn machine(path: &Path, note: &mut dyn FnMut(String)) -> Result<Machine> {
    if is_compiled(path) {
        return Ok(Machine::from_tcomp(&parsed(&bytes(path)?, path)?));
    }
    source(path, note)
}

/// The content of a file.
///
/// # Errors
/// The file cannot be read.
pub fn bytes(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))
}

/// A machine in source form; `note` receives remarks on separators other than commas, on decimal commas, and on files left by
/// a command that was interrupted while writing.
///
/// # Errors
/// As [`machine`].
pub fn source(path: &Path, note: &mut dyn FnMut(String)) -> Result<Machine> {
    left(path).into_iter().for_each(&mut *note);
    let (folder, name) = Folder::of_machine(path);
    Ok(Machine::read_from(&folder, &name, note)?)
}

/// A sentence on every file of this machine that an interrupted command left behind.
pub fn left(path: &Path) -> Vec<String> {
    left_notes(files(path))
}

/// The files of a machine in any form.
pub fn files(path: &Path) -> Vec<PathBuf> {
    let alone = || vec![path.to_path_buf()];
    if is_compiled(path) { alone() } else { Machine::files(path).unwrap_or_else(|_| alone()) }
}

/// Parses compiled bytes; the error names the file they came from.
///
/// # Errors
/// As [`Tcomp::parse`].
pub fn parsed<'b>(bytes: &'b [u8], machine: &Path) -> Result<Tcomp<'b>> {
    Tcomp::parse(bytes).map_err(|error| anyhow!("{}: {error}", machine.display()))
}

/// Whether the path names a compiled machine.
pub fn is_compiled(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "tcomp")
}

/// Builds the model that the machine's settings name and lends it to `user`; `passes` of the exact inverse, 1 to 8.
///
/// # Errors
/// As [`Compensation::build`] and `user`.
pub fn with_compensation<const N: usize, T>(
    machine: &Machine,
    passes: u8,
    user: impl FnOnce(&Compensation<'_, f64, f64, N>) -> Result<T>,
) -> Result<T> {
    user(&compensation(machine, passes, &mut Vec::new())?)
}

/// As [`with_compensation`], built in the caller's `memory`.
pub(crate) fn compensation<'m, const N: usize>(
    machine: &'m Machine,
    passes: u8,
    memory: &'m mut Vec<f64>,
) -> Result<Compensation<'m, f64, f64, N>> {
    let rows = |axis: Axis| machine.rows(axis);
    memory.resize(requirement(&machine.settings, rows), 0.0);
    Compensation::build(&machine.settings, rows, &machine.grids(), passes, memory).map_err(|error| anyhow!("{error}"))
}

/// Calls a function generic over the number of slots of the step with that for so many axes: three for three, six for more,
/// some of them spare ([`AxisOrder::with_spare_slots`](trueaxis::machine::AxisOrder::with_spare_slots)).
#[macro_export]
macro_rules! by_axes {
    ($count:expr, $($function:ident)::+ ($($argument:expr),*)) => {
        match $count {
            3 => $($function)::+::<3>($($argument),*),
            _ => $($function)::+::<6>($($argument),*),
        }
    };
}

/// Look-ups of the exact inverse: the requested number, or as many as the machine needs.
///
/// # Errors
/// A machine that needs more than 8, or whose errors are too steep for any number.
pub fn passes(machine: &Machine, asked: Option<u8>) -> Result<u8> {
    let bounds = check::GridBounds::of(&machine.grids());
    let needed = || check::machine_passes(&machine.settings, |axis| machine.rows(axis), &bounds);
    asked.map_or_else(needed, Ok).map_err(|error| anyhow!("{error}"))
}

/// Thermal growth of the axes of the step, `kelvin` above the machine's reference temperature.
pub fn thermal<const N: usize>(machine: &Machine, axes: &[Axis; N], kelvin: f64) -> [ThermalLine<f64>; N] {
    axes.map(|axis| {
        let own = machine.settings.axis(axis);
        own.and_then(|own| ThermalLine::for_axis(&own.thermal, kelvin)).unwrap_or_default()
    })
}

/// Whether the step accepts all axes' growth at `kelvin` above the reference temperature: at most 10 mm and 1e-3.
pub fn takes_rise(machine: &Machine, kelvin: f64) -> bool {
    machine.settings.axes.iter().all(|own| ThermalLine::<f64>::for_axis(&own.thermal, kelvin).is_some())
}

/// Range of an axis, mm or degrees: its declared travel, or the range of its table if none is declared.
pub fn range(own: &AxisSettings, table: Option<&Table>) -> [f64; 2] {
    let rows = table.map(|table| table.rows.as_slice()).and_then(|rows| rows.first().zip(rows.last()));
    match rows {
        Some((first, last)) if !is_declared(own) => [first.position, last.position],
        _ => own.travel,
    }
}

/// Whether the machine's description states the travel of the axis.
pub fn is_declared(own: &AxisSettings) -> bool {
    own.travel != AxisSettings::with_defaults(own.axis, false).travel
}

/// The error model's name in a machine's description: `nine` or `volumetric`.
pub fn name(model: ErrorModel) -> &'static str {
    match model {
        ErrorModel::Nine => "nine",
        ErrorModel::Volumetric => "volumetric",
    }
}
