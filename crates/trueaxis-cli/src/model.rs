//! A machine's error model in memory: from machine.toml, its folder, or a compiled .tcomp.

use anyhow::{Context, Result, anyhow};
use std::path::Path;
use trueaxis::Axis;
use trueaxis::compensation::{Compensation, Storage};
use trueaxis::tcomp::Tcomp;
use trueaxis_tables::{Machine, compile};

/// The compiled bytes of a machine, whatever form it came in.
pub(crate) fn compiled(machine: &Path) -> Result<Vec<u8>> {
    if machine.extension().is_some_and(|e| e == "tcomp") {
        return std::fs::read(machine).with_context(|| format!("cannot read {}", machine.display()));
    }
    let read = Machine::read(machine)?;
    compile(&read).map_err(|error| anyhow!("{}: {error}", machine.display()))
}

/// Parses compiled bytes; the error names the file they came from.
pub(crate) fn parsed<'b>(bytes: &'b [u8], machine: &Path) -> Result<Tcomp<'b>> {
    Tcomp::parse(bytes).map_err(|error| anyhow!("{}: {error}", machine.display()))
}

/// Axes of the step: X, Y, Z, and the machine's rotary ones.
pub(crate) fn axis_count(tables: &Tcomp<'_>) -> usize {
    3 + tables.settings().axes.iter().filter(|a| a.axis.is_rotary()).count()
}

/// Builds the nine-term model and lends it out.
pub(crate) fn with_compensation<const N: usize, T>(
    tables: &Tcomp<'_>,
    passes: u8,
    user: impl FnOnce(&Compensation<'_, f64, f64, N>) -> Result<T>,
) -> Result<T> {
    let rows = |axis: Axis| tables.table(axis);
    let need = Compensation::<f64, f64, N>::requirement(tables.settings(), rows);
    let (mut lines, mut knots, mut guide) = (vec![0.0; need.lines], vec![0.0; need.knots], vec![0; need.guide]);
    let storage = Storage { lines: &mut lines, knots: &mut knots, guide: &mut guide };
    let compensation =
        Compensation::build(tables.settings(), rows, passes, storage).map_err(|error| anyhow!("{error}"))?;
    user(&compensation)
}
