//! `trueaxis keep begin` and `check`, and the parts that `apply` shares with them.

use super::{CheckArguments, ReprobingArguments};
use crate::model::{note, text};
use crate::output::{NeedsPerson, report_line};
use crate::report;
use anyhow::{Result, anyhow};
use std::path::Path;
use trueaxis_evaluation::keep::{Entry, Let, Log, State, Taken};
use trueaxis_tables::output::Outputs;

pub(super) fn log<'a>(arguments: &'a ReprobingArguments, text: &'a str) -> Log<'a> {
    Log { file: &arguments.log, text, time: arguments.time.clone(), parts: arguments.parts }
}

pub(super) fn allowed<'a>(arguments: &'a CheckArguments, state: &State) -> Result<Let<'a>> {
    state.accepts(&arguments.accept).map_err(|wrong| anyhow!("--accept: {wrong}"))?;
    Ok(Let { accept: &arguments.accept, by_hand: arguments.by_hand })
}

/// If requested, stages the page of the history including the next entry.
pub(super) fn show(outputs: &mut Outputs, state: &State, taken: &Taken, arguments: &ReprobingArguments) -> Result<()> {
    let Some(directory) = &arguments.report else { return Ok(()) };
    let entries: Vec<Entry> = state.history.entries.iter().chain([&taken.entry]).cloned().collect();
    let page = super::table::page(&state.machine.settings.name, &entries, Some(&taken.document));
    report::write(outputs, &page, directory, "keep.html")
}

/// Ends the command if a term is out of bounds.
pub(super) fn refused(taken: &Taken, log: &Path) -> Result<()> {
    taken.refusal(log).map_or(Ok(()), |reason| Err(NeedsPerson(reason).into()))
}

pub(super) fn begin(arguments: &ReprobingArguments) -> Result<()> {
    let state = State::alone(&arguments.task, &mut note)?;
    let taken = state.begin(&log(arguments, &text(&arguments.log)?), &mut note)?;
    let mut outputs = Outputs::of([&arguments.task, &arguments.log]);
    state.stage(&mut outputs, &state.written(&taken.entry, &taken.files)?)?;
    show(&mut outputs, &state, &taken, arguments)?;
    outputs.commit()?;
    super::table::put(&taken.document, arguments.json)
}

pub(super) fn check(arguments: &CheckArguments) -> Result<()> {
    let of = &arguments.reprobing;
    let state = State::read(&of.task, &mut note)?;
    let allowed = allowed(arguments, &state)?;
    let taken = state.check(&log(of, &text(&of.log)?), allowed, &mut note)?;
    let mut outputs = Outputs::of([&of.task, &of.log]);
    show(&mut outputs, &state, &taken, of)?;
    outputs.commit()?;
    taken.changes.iter().for_each(|change| report_line(format_args!("would be: {change}")));
    super::table::put(&taken.document, of.json)?;
    refused(&taken, &of.log)
}
