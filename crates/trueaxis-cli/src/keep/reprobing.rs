//! `trueaxis keep begin` and `check`, and the parts that `apply` shares with them.

use super::{CheckArgs, ReprobingArgs};
use crate::model::{note, text};
use crate::output::{NeedsPerson, report_line};
use crate::report;
use anyhow::{Result, anyhow};
use std::path::Path;
use trueaxis_evaluation::keep::{Entry, EvaluatedLog, Log, Overrides, State};
use trueaxis_tables::output::Outputs;

pub(super) fn log<'a>(arguments: &'a ReprobingArgs, text: &'a str) -> Log<'a> {
    Log { file: &arguments.log, text, time: arguments.time.clone(), parts: arguments.parts }
}

pub(super) fn allowed<'a>(arguments: &'a CheckArgs, state: &State) -> Result<Overrides<'a>> {
    state.accepts(&arguments.accept).map_err(|wrong| anyhow!("--accept: {wrong}"))?;
    Ok(Overrides { accept: &arguments.accept, by_hand: arguments.by_hand })
}

/// If requested, stages the page of the history including the next entry.
pub(super) fn show(
    outputs: &mut Outputs,
    state: &State,
    evaluated: &EvaluatedLog,
    arguments: &ReprobingArgs,
) -> Result<()> {
    let Some(directory) = &arguments.report else { return Ok(()) };
    let entries: Vec<Entry> = state.history.entries.iter().chain([&evaluated.entry]).cloned().collect();
    let page = super::table::page(&state.machine.settings.name, &entries, Some(&evaluated.document));
    report::write(outputs, &page, directory, "keep.html")
}

/// Ends the command if a term is out of bounds.
pub(super) fn refused(evaluated: &EvaluatedLog, log: &Path) -> Result<()> {
    evaluated.refusal(log).map_or(Ok(()), |reason| Err(NeedsPerson(reason).into()))
}

pub(super) fn begin(arguments: &ReprobingArgs) -> Result<()> {
    let state = State::alone(&arguments.task, &mut note)?;
    let evaluated = state.begin(&log(arguments, &text(&arguments.log)?), &mut note)?;
    let mut outputs = Outputs::of([&arguments.task, &arguments.log]);
    state.stage(&mut outputs, &state.written(&evaluated.entry, &evaluated.files)?)?;
    show(&mut outputs, &state, &evaluated, arguments)?;
    outputs.commit()?;
    super::table::put(&evaluated.document, arguments.json)
}

pub(super) fn check(arguments: &CheckArgs) -> Result<()> {
    let of = &arguments.reprobing;
    let state = State::read(&of.task, &mut note)?;
    let allowed = allowed(arguments, &state)?;
    let evaluated = state.check(&log(of, &text(&of.log)?), allowed, &mut note)?;
    let mut outputs = Outputs::of([&of.task, &of.log]);
    show(&mut outputs, &state, &evaluated, of)?;
    outputs.commit()?;
    evaluated.changes.iter().for_each(|change| report_line(format_args!("would be: {change}")));
    super::table::put(&evaluated.document, of.json)?;
    refused(&evaluated, &of.log)
}
