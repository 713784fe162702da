//! `trueaxis keep undo`.

use super::UndoArguments;
use super::state::{State, tables};
use super::write::{change, compiled, enter};
use crate::output::tell;
use anyhow::{Context, Result, bail};
use std::fs;
use trueaxis_evaluation::keep::{Deed, Entry, sum};
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::output::Outputs;

pub(super) fn run(arguments: &UndoArguments) -> Result<()> {
    let state = State::read(&arguments.task)?;
    let number = state.history.undoable(arguments.entry)?;
    state.untouched(arguments.by_hand)?;
    let mut after = state.files.clone();
    let mut new: Vec<(String, Option<Vec<u8>>)> = Vec::new();
    for (file, entry, before) in state.history.put_back(number) {
        let bytes = match &before {
            None => None,
            Some(check) => {
                let copy = state.kept(entry, &file);
                let bytes = fs::read(&copy).with_context(|| format!("cannot read {}", copy.display()))?;
                let own = sum(&bytes);
                if own != *check {
                    bail!("{}: found {own}, needed {check} as entry {entry} kept it", copy.display());
                }
                Some(bytes)
            }
        };
        match &bytes {
            Some(bytes) => after.insert(file.clone(), bytes.clone()),
            None => after.remove(&file),
        };
        new.push((file, bytes));
    }
    // machine.toml names the others, and comes last.
    new.sort_by_key(|(file, _)| state.name.to_str() == Some(file));
    new.retain(|(file, bytes)| state.files.get(file) != bytes.as_ref());
    let memory = Memory::new(after.iter().map(|(name, bytes)| (name, bytes.clone())));
    Machine::read_untabled(&memory, &state.name, &mut |_| {})?;
    let begun = state.history.beginning()?;
    let entry = Entry {
        entry: state.history.next(),
        deed: Deed::Undo,
        time: arguments.time.clone(),
        parts: None,
        plan: begun.plan.clone(),
        log: None,
        undone: Some(number),
        sigma_um: None,
        measured: Vec::new(),
        balls: Vec::new(),
        totals: state.history.entries[number as usize - 2].totals.clone(),
        files: Vec::new(),
        tables: [state.tables(), tables(&after)],
    };
    let mut outputs = Outputs::of([&arguments.task]);
    let files = change(&mut outputs, &state, entry.entry, &new)?;
    enter(&mut outputs, &state, &Entry { files, ..entry.clone() })?;
    for (file, bytes) in &new {
        if let Some(bytes) = bytes {
            outputs.put(&state.folder.join(file), bytes)?;
        }
    }
    compiled(&mut outputs, &state, &after)?;
    outputs.commit()?;
    // A table that there was not is named by nothing now; left there, it would stand in the way of the next one.
    for (file, _) in new.iter().filter(|(_, bytes)| bytes.is_none()) {
        let path = state.folder.join(file);
        fs::remove_file(&path).with_context(|| format!("cannot remove {}", path.display()))?;
    }
    for (file, bytes) in &new {
        let how = if bytes.is_some() { "put back" } else { "taken away" };
        tell(format_args!("{how} {}", state.folder.join(file).display()));
    }
    tell(format_args!("entry {}: as before entry {number}", entry.entry));
    Ok(())
}
