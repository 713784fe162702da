//! Files of a machine as the page holds them.

use anyhow::{Context, Result};
use std::collections::BTreeMap;
use std::path::Path;
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;

/// Name of a machine's description among its files.
pub(crate) const DESCRIPTION: &str = "machine.toml";

/// Files from `{"name": "text", …}`.
pub(crate) fn memory(files: &str) -> Result<Memory> {
    let files: BTreeMap<String, String> = serde_json::from_str(files).context("the files of a machine")?;
    Ok(Memory::new(files))
}

/// The machine of these files; how their separators were recognised goes to `notes`.
pub(crate) fn machine(files: &str, notes: &mut Vec<String>) -> Result<Machine> {
    Ok(Machine::read_from(&memory(files)?, Path::new(DESCRIPTION), &mut |note| notes.push(note))?)
}
