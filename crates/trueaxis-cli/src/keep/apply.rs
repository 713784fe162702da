//! `trueaxis keep apply`.

use super::CheckArguments;
use super::reprobing::{allowed, log, refused, show};
use crate::model::{note, text};
use crate::output::report_line;
use anyhow::Result;
use trueaxis_evaluation::keep::{Deed, State};
use trueaxis_tables::output::Outputs;

pub(super) fn run(arguments: &CheckArguments) -> Result<()> {
    let of = &arguments.reprobing;
    let state = State::alone(&of.task, &mut note)?;
    let allowed = allowed(arguments, &state)?;
    let mut taken = state.check(&log(of, &text(&of.log)?), allowed, &mut note)?;
    if taken.document.refused > 0 {
        super::table::put(&taken.document, of.json)?;
        return refused(&taken, &of.log);
    }
    taken.document.applied = taken.entry.deed == Deed::Update;
    let mut outputs = Outputs::of([&of.task, &of.log]);
    state.stage(&mut outputs, &state.written(&taken.entry, &taken.files)?)?;
    show(&mut outputs, &state, &taken, of)?;
    outputs.commit()?;
    taken.changes.iter().for_each(report_line);
    let done = if taken.document.applied { "updated" } else { "nothing to change" };
    report_line(format_args!("entry {}: {done}", taken.entry.entry));
    super::table::put(&taken.document, of.json)
}
