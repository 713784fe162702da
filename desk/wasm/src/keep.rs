//! Updates of a machine by re-probing balls: the plan, checking a log against the history, the updated machine.

use crate::becomes::Becomes;
use crate::files::texts;
use crate::{Refusal, json, to_js};
use anyhow::{Context, Result, anyhow};
use serde::{Deserialize, Serialize};
use std::path::Path;
use trueaxis_evaluation::keep::{Entry, Foreseen, HISTORY, KeepTask, Log, Overrides, Planning, State, listed, time};
use trueaxis_evaluation::shown::{Shown, Table};
use trueaxis_tables::files::Memory;
use wasm_bindgen::prelude::*;

/// A planned re-probing.
#[derive(Serialize)]
struct Planned {
    /// The document printed by `trueaxis keep plan --json`.
    foreseen: Foreseen,
    /// The uncertainties expected.
    expected: Table,
    program: String,
    notes: Vec<String>,
}

/// Inputs in addition to a log.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Request {
    /// Text of the history; empty before the first probing.
    history: String,
    /// Whether this re-probing becomes the reference for later ones, as the first one did.
    begin: bool,
    time: Option<String>,
    parts: Option<u64>,
    accept: Vec<String>,
    by_hand: bool,
}

/// An evaluated re-probing.
#[derive(Serialize)]
struct Evaluated {
    /// Printed by `trueaxis keep begin` or `check`.
    shown: Shown,
    machine: String,
    /// Number of the entry.
    entry: u32,
    touches: usize,
    /// Reason why an operator must check the machine.
    refusal: Option<String>,
    /// The updated machine, unless nothing is updated.
    becomes: Option<Becomes>,
    /// The history ending with this re-probing, unless it is refused.
    entries: Table,
    /// Texts that `begin` or `apply` writes, by their names in the machine's folder, in the same order.
    written: Vec<(String, String)>,
    /// The new text of the history.
    history: String,
    notes: Vec<String>,
}

/// The task's state on the machine of these files, whichever machine the task names.
fn state(files: &str, name: &str, task: &str, history: &str, notes: &mut Vec<String>) -> Result<State> {
    let task = KeepTask::read(task, Path::new(name))?;
    State::of_texts(task, Memory::new(texts(files)?), history, &mut |note| notes.push(note))
}

fn plan(files: &str, name: &str, task: &str) -> Result<String> {
    let mut notes = Vec::new();
    let state = state(files, name, task, "", &mut notes)?;
    let Planning { program, foreseen, .. } = Planning::new(&state.task, &state.machine)?;
    json(&Planned { expected: foreseen.expected(), foreseen, program, notes })
}

/// Plans the re-probing of a task on the machine of these files, whichever machine the task names: `foreseen`, `program`,
/// `notes`. Errors refer to the task by `name`.
#[wasm_bindgen]
pub fn keep_plan(files: &str, name: &str, task: &str) -> Result<String, Refusal> {
    to_js(plan(files, name, task))
}

fn evaluate(files: &str, name: &str, task: &str, log_name: &str, log: &str, request: &str) -> Result<String> {
    let request: Request = serde_json::from_str(request).context("the request of a re-probing")?;
    let mut notes = Vec::new();
    let state = state(files, name, task, &request.history, &mut notes)?;
    let time = request.time.map(|given| time(&given).map_err(|needed| anyhow!("--time: found {given:?}, {needed}")));
    let log = Log { file: Path::new(log_name), text: log, time: time.transpose()?, parts: request.parts };
    let note = &mut |note| notes.push(note);
    let evaluated = if request.begin || request.history.is_empty() {
        state.begin(&log, note)?
    } else {
        state.accepts(&request.accept).map_err(|wrong| anyhow!("--accept: {wrong}"))?;
        state.check(&log, Overrides { accept: &request.accept, by_hand: request.by_hand }, note)?
    };
    let refusal = evaluated.refusal(log.file);
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).ok();
    let mut written = Vec::new();
    let mut entries: Vec<Entry> = state.history.entries.clone();
    if refusal.is_none() {
        // The machine view compiles the controller's files; this module returns texts only.
        let all = state.written(&evaluated.entry, &evaluated.files)?.into_iter();
        written.extend(all.filter_map(|(name, bytes)| Some((name.to_string_lossy().into_owned(), text(bytes)?))));
        entries.push(evaluated.entry);
    }
    let history = written.iter().find(|(name, _)| name == HISTORY).map_or(request.history, |(_, text)| text.clone());
    let changed: Vec<(String, String)> =
        evaluated.files.into_iter().filter_map(|(name, bytes)| Some((name, text(bytes?)?))).collect();
    let becomes =
        (!changed.is_empty()).then(|| Becomes::with(texts(files)?, changed, evaluated.changes, &[])).transpose()?;
    json(&Evaluated {
        shown: evaluated.document.shown(),
        machine: evaluated.document.machine,
        entry: evaluated.document.entry,
        touches: evaluated.document.touches,
        refusal,
        becomes,
        entries: listed(&entries),
        written,
        history,
        notes,
    })
}

/// Evaluates the log of a re-probing; with an empty history, it is the first one. `request`: `history`, `begin`, `time`,
/// `parts`, `accept`, `by_hand`. Returns `shown`, `machine`, `entry`, `touches`, `refusal`, `becomes`, `entries`, `written`, `history`,
/// `notes`.
#[wasm_bindgen]
pub fn keep_evaluate(
    files: &str,
    name: &str,
    task: &str,
    log_name: &str,
    log: &str,
    request: &str,
) -> Result<String, Refusal> {
    to_js(evaluate(files, name, task, log_name, log, request))
}
