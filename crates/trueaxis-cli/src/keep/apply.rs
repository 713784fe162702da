//! `trueaxis keep apply`.

use super::CheckArgs;
use super::reprobing::{allowed, log, refused, show};
use crate::model::{note, text};
use crate::output::report_line;
use anyhow::Result;
use trueaxis_evaluation::keep::{EntryKind, State};
use trueaxis_tables::output::Outputs;

pub(super) fn run(arguments: &CheckArgs) -> Result<()> {
    let of = &arguments.reprobing;
    let state = State::alone(&of.task, &mut note)?;
    let allowed = allowed(arguments, &state)?;
    let mut evaluated = state.check(&log(of, &text(&of.log)?), allowed, &mut note)?;
    if evaluated.document.refused > 0 {
        super::table::put(&evaluated.document, of.json)?;
        return refused(&evaluated, &of.log);
    }
    evaluated.document.applied = evaluated.entry.kind == EntryKind::Update;
    let mut outputs = Outputs::of([&of.task, &of.log]);
    state.stage(&mut outputs, &state.written(&evaluated.entry, &evaluated.files)?)?;
    show(&mut outputs, &state, &evaluated, of)?;
    outputs.commit()?;
    evaluated.changes.iter().for_each(report_line);
    let done = if evaluated.document.applied { "updated" } else { "nothing to change" };
    report_line(format_args!("entry {}: {done}", evaluated.entry.entry));
    super::table::put(&evaluated.document, of.json)
}
