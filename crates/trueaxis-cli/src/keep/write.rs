//! Files that `keep` writes: copies of those it replaces, the history, the controller's files, the report.

use super::state::{HISTORY, State};
use crate::report;
use anyhow::{Result, anyhow};
use std::collections::BTreeMap;
use std::path::Path;
use trueaxis::tcomp::machine_id;
use trueaxis_evaluation::keep::{Changed, Document, Entry, sum};
use trueaxis_tables::files::Memory;
use trueaxis_tables::output::Outputs;
use trueaxis_tables::text::decode;
use trueaxis_tables::{Machine, compile};

/// Stages copies of the files that are about to be replaced (`None`: taken away), in the folder of the entry.
pub(super) fn change(
    outputs: &mut Outputs,
    state: &State,
    entry: u32,
    new: &[(String, Option<Vec<u8>>)],
) -> Result<Vec<Changed>> {
    let mut changed = Vec::new();
    for (file, bytes) in new {
        let before = state.files.get(file);
        if let Some(before) = before {
            let copy = state.kept(entry, file);
            outputs.folder(copy.parent().unwrap_or(Path::new("")))?;
            outputs.put(&copy, before)?;
        }
        let of = |bytes: &Vec<u8>| sum(bytes);
        changed.push(Changed { file: file.clone(), before: before.map(of), after: bytes.as_ref().map(of) });
    }
    Ok(changed)
}

/// Stages the history with one more entry: before the tables, so that what an interrupted command has changed is known.
pub(super) fn enter(outputs: &mut Outputs, state: &State, entry: &Entry) -> Result<()> {
    let history = state.folder.join(HISTORY);
    outputs.folder(history.parent().unwrap_or(Path::new("")))?;
    Ok(outputs.put(&history, state.history.with(entry).as_bytes())?)
}

/// Stages the controller's files of a machine whose files are these.
pub(super) fn compiled(outputs: &mut Outputs, state: &State, files: &BTreeMap<String, Vec<u8>>) -> Result<()> {
    if state.keep.tcomp.is_none() && state.keep.ttherm.is_none() {
        return Ok(());
    }
    let memory = Memory::new(files.iter().map(|(name, bytes)| (name, bytes.clone())));
    let machine = Machine::read_from(&memory, &state.name, &mut |_| {})?;
    if let Some(tcomp) = &state.keep.tcomp {
        outputs.put(&state.folder.join(tcomp), &compile(&machine)?)?;
    }
    if let (Some(thermal), Some(ttherm)) = (&state.keep.thermal, &state.keep.ttherm) {
        let path = state.folder.join(thermal);
        let text = decode(files.get(thermal).cloned().unwrap_or_default(), &path, &['#'])?;
        let model = trueaxis_evaluation::thermal::model(&text, &path, &machine.settings)?;
        let id = machine_id(&machine.settings.name, &machine.settings.chain);
        let bytes = model.encode(id).map_err(|error| anyhow!("{}: {error}", path.display()))?;
        outputs.put(&state.folder.join(ttherm), &bytes)?;
    }
    Ok(())
}

/// Stages the page of the history with an entry that comes next, where it is asked for.
pub(super) fn show(
    outputs: &mut Outputs,
    state: &State,
    entry: &Entry,
    document: &Document,
    directory: Option<&Path>,
) -> Result<()> {
    let Some(directory) = directory else { return Ok(()) };
    let entries: Vec<Entry> = state.history.entries.iter().chain([entry]).cloned().collect();
    let page = report::keep::page(&state.machine.settings.name, &entries, Some(document));
    report::write(outputs, &page, directory, "keep.html")
}
