//! `trueaxis keep begin` and `check`, and what `apply` has in common with them.

use super::state::State;
use super::write::{enter, show};
use super::{CheckArguments, LookArguments};
use crate::model;
use crate::output::{NeedsPerson, tell};
use anyhow::{Result, bail};
use trueaxis_evaluation::calibrate::{Plan, read_log, trips};
use trueaxis_evaluation::keep::{self, Deed, Document, Entry, LogFile, Look, plan, sum};
use trueaxis_tables::output::Outputs;

/// A log read, and the plan that it belongs to.
pub(super) struct Read {
    pub(super) plan: Plan,
    pub(super) trips: Vec<trueaxis_evaluation::calibrate::Logged>,
    pub(super) log: LogFile,
}

pub(super) fn read(state: &State, arguments: &LookArguments) -> Result<Read> {
    let file = &arguments.log;
    let text = model::text(file)?;
    let plan = plan(&state.keep, &state.machine)?;
    let log =
        read_log(&text, file, state.keep.task.dialect, |how| tell(format_args!("note: {}: {how}", file.display())))?;
    let trips = trips(&state.keep.task, &plan, &log, file)?;
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Read { plan, trips, log: LogFile { file: name, crc: sum(text.as_bytes()) } })
}

/// An entry with nothing changed.
pub(super) fn entry(state: &State, arguments: &LookArguments, read: &Read, look: &Look, deed: Deed) -> Entry {
    let tables = state.tables();
    Entry {
        entry: state.history.next(),
        deed,
        time: arguments.time.clone(),
        parts: arguments.parts,
        plan: format!("{:08x}", read.plan.identity),
        log: Some(read.log.clone()),
        undone: None,
        sigma_um: Some(1e3 * look.calibration.solution.sigma_mm),
        measured: look.measured(&state.keep),
        balls: look.balls.clone(),
        totals: Default::default(),
        files: Vec::new(),
        tables: [tables.clone(), tables],
    }
}

pub(super) fn begin(arguments: &LookArguments) -> Result<()> {
    let state = State::read(&arguments.task)?;
    let read = read(&state, arguments)?;
    let look = keep::begin(&state.keep, &state.machine, &read.plan, &read.trips, &arguments.log)?;
    let entry = entry(&state, arguments, &read, &look, Deed::Begin);
    let mut document = look.document(&state.keep, &state.machine.settings.name, entry.entry);
    document.notes.push("the beginning: later looks are held against the places of these balls".into());
    let mut outputs = Outputs::of([&arguments.task, &arguments.log]);
    enter(&mut outputs, &state, &entry)?;
    show(&mut outputs, &state, &entry, &document, arguments.report.as_deref())?;
    outputs.commit()?;
    super::table::put(&document, arguments.json)
}

/// A look against the history.
pub(super) fn taken(arguments: &CheckArguments, state: &State) -> Result<(Read, Look, Document)> {
    let of = &arguments.look;
    if let Some(unknown) = arguments.accept.iter().find(|name| state.keep.terms.iter().all(|kept| kept.name != **name))
    {
        let names: Vec<&str> = state.keep.terms.iter().map(|kept| kept.name.as_str()).collect();
        bail!("--accept: found {unknown:?}, needed one of {}", names.join(", "));
    }
    state.history.beginning()?;
    state.untouched(arguments.by_hand)?;
    let read = read(state, of)?;
    let identity = format!("{:08x}", read.plan.identity);
    state.history.follows(&identity, &read.log.crc, of.time.as_deref(), of.parts)?;
    let (known, totals) = (state.history.balls()?, state.history.totals());
    let look = keep::look(
        &state.keep,
        &state.machine,
        &read.plan,
        &read.trips,
        &of.log,
        &keep::Before { known, totals: &totals, accepted: &arguments.accept },
    )?;
    let mut document = look.document(&state.keep, &state.machine.settings.name, state.history.next());
    let before = state.history.entries.iter().rev().find_map(|entry| entry.parts);
    if let Some(since) = of.parts.zip(before).map(|(now, before)| now - before) {
        let every = state.keep.every_parts;
        if since > u64::from(every) {
            document.notes.push(format!("{since} parts since the last look, {every} are stated"));
        }
    }
    Ok((read, look, document))
}

/// A refusal in words, where a term is out of its bounds.
pub(super) fn within(look: &Look, log: &std::path::Path) -> Result<()> {
    let reasons: Vec<String> = look.refused().map(|(name, reason)| format!("{name} {reason}")).collect();
    if reasons.is_empty() {
        return Ok(());
    }
    let reasons = reasons.join("; ");
    Err(NeedsPerson(format!(
        "{}: {reasons}: nothing is changed; has the ball been moved, has something been hit? --accept TERM lets it pass",
        log.display()
    ))
    .into())
}

pub(super) fn check(arguments: &CheckArguments) -> Result<()> {
    let state = State::read(&arguments.look.task)?;
    let (read, look, document) = taken(arguments, &state)?;
    // The new files are made here too, though not written: a refusal then shows up before anything is applied.
    let changes = keep::changes(&state.keep, &look, &state.machine, &state.source, &state.name)?;
    if let Some(directory) = &arguments.look.report {
        let entry = entry(&state, &arguments.look, &read, &look, Deed::Look);
        let mut outputs = Outputs::of([&arguments.look.task, &arguments.look.log]);
        show(&mut outputs, &state, &entry, &document, Some(directory))?;
        outputs.commit()?;
    }
    changes.notes.iter().for_each(|note| tell(format_args!("would be: {note}")));
    super::table::put(&document, arguments.look.json)?;
    within(&look, &arguments.look.log)
}
