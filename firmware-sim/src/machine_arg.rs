//! Machines named on the command line, and the files that a command must not overwrite.

use crate::console::report_line;
use anyhow::{Result, bail};
use firmware_sim::samples::sample_machine;
use std::path::Path;
use trueaxis_tables::Machine;
use trueaxis_tables::output::{Outputs, left_notes};

/// Reads a machine.toml, given by its path, its folder, or a sample's name.
pub(crate) fn read_machine(option: &str, given: &Path) -> Result<Machine> {
    let path = if given.exists() { given.to_path_buf() } else { sample_machine(&given.to_string_lossy()) };
    if !path.exists() {
        bail!(
            "{option}: found no file or sample \"{}\", needed a machine.toml, its folder, or mill-3axis, mill-5axis, mill-turn, head-5axis or grinder",
            given.display()
        );
    }
    for note in Machine::files(&path).map(left_notes).unwrap_or_default() {
        report_line(format_args!("note: {note}"));
    }
    Ok(Machine::read(&path)?)
}

/// Files that a command must not overwrite: those of machines, named as for [`read_machine`], and others.
pub(crate) fn outputs_of<'p>(
    machines: impl IntoIterator<Item = &'p Path>,
    others: impl IntoIterator<Item = &'p Path>,
) -> Outputs {
    let files = machines.into_iter().flat_map(|given| {
        let path = if given.exists() { given.to_path_buf() } else { sample_machine(&given.to_string_lossy()) };
        Machine::files(&path).unwrap_or_else(|_| vec![path])
    });
    Outputs::of(files.chain(others.into_iter().map(Path::to_path_buf)))
}
