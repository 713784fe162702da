//! `trueaxis keep apply`.

use super::CheckArguments;
use super::look::{entry, taken, within};
use super::state::{State, tables};
use super::write::{change, compiled, enter, show};
use crate::output::tell;
use anyhow::Result;
use trueaxis_evaluation::keep::{self, Deed};
use trueaxis_tables::output::Outputs;

pub(super) fn run(arguments: &CheckArguments) -> Result<()> {
    let of = &arguments.look;
    let state = State::read(&of.task)?;
    let (read, look, mut document) = taken(arguments, &state)?;
    if document.refused > 0 {
        super::table::put(&document, of.json)?;
        return within(&look, &of.log);
    }
    let changes = keep::changes(&state.keep, &look, &state.machine, &state.source, &state.name)?;
    let deed = if changes.files.is_empty() { Deed::Look } else { Deed::Update };
    let mut entry = entry(&state, of, &read, &look, deed);
    entry.totals = look.totals(&state.keep);
    let mut after = state.files.clone();
    for (name, text) in &changes.files {
        after.insert(name.to_string_lossy().into_owned(), text.clone().into_bytes());
    }
    entry.tables[1] = tables(&after);
    let mut outputs = Outputs::of([&of.task, &of.log]);
    let new: Vec<(String, Option<Vec<u8>>)> = changes
        .files
        .iter()
        .map(|(name, text)| (name.to_string_lossy().into_owned(), Some(text.clone().into_bytes())))
        .collect();
    entry.files = change(&mut outputs, &state, entry.entry, &new)?;
    enter(&mut outputs, &state, &entry)?;
    for (name, bytes) in &new {
        outputs.put(&state.folder.join(name), bytes.as_deref().unwrap_or_default())?;
    }
    if deed == Deed::Update {
        compiled(&mut outputs, &state, &after)?;
    }
    document.applied = deed == Deed::Update;
    show(&mut outputs, &state, &entry, &document, of.report.as_deref())?;
    outputs.commit()?;
    changes.notes.iter().for_each(tell);
    tell(format_args!("entry {}: {}", entry.entry, if document.applied { "updated" } else { "nothing to change" }));
    super::table::put(&document, of.json)
}
