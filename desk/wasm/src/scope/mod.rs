//! Runs of a part program through the real step, in slices; several in parallel, each identified by a number.

mod documents;
mod request;
mod session;
mod traces;

use crate::{Refusal, json, to_js};
use anyhow::{Context, Result};
use session::Session;
use std::cell::RefCell;
use std::collections::BTreeMap;
use wasm_bindgen::prelude::*;

/// The open scopes.
#[derive(Default)]
struct Open {
    last: u32,
    sessions: BTreeMap<u32, Session>,
}

thread_local! {
    static OPEN: RefCell<Open> = RefCell::default();
}

fn opened(request: &str) -> Result<u32> {
    let session = Session::open(request)?;
    Ok(OPEN.with_borrow_mut(|open| {
        open.last += 1;
        open.sessions.insert(open.last, session);
        open.last
    }))
}

fn with<T>(scope: u32, ask: impl FnOnce(&mut Session) -> Result<T>) -> Result<T> {
    OPEN.with_borrow_mut(|open| {
        ask(open.sessions.get_mut(&scope).with_context(|| format!("scope {scope}: found closed, needed open"))?)
    })
}

/// Opens a scope, ready to run; returns its number.
///
/// `request`: JSON of `machine` (texts of its files by name), `program` (`{"builtin": name}` or `{"name", "text", "files"}`),
/// `settings` (TOML as `firmware-sim scenario` prints, any part of it), and optionally `model` (`"nine"`, `"volumetric"`),
/// `orientation`, `exchanges` (further machines by the name that an event gives) and `kinds` (names of the machines to run).
#[wasm_bindgen]
pub fn scope_open(request: &str) -> Result<u32, Refusal> {
    to_js(opened(request))
}

/// Describes the scope: machine, program with its lines, cycles, axes with the limits of their corrections, notes.
#[wasm_bindgen]
pub fn scope_describe(scope: u32) -> Result<String, Refusal> {
    to_js(with(scope, |session| json(&session.describe()?)))
}

/// The programmed path, a few thousand points: x, y, z in mm (machine coordinates; with rotary axes, workpiece coordinates),
/// line, 1 while cutting.
#[wasm_bindgen]
pub fn scope_path(scope: u32) -> Result<Vec<f32>, Refusal> {
    to_js(with(scope, |session| Ok(session.path())))
}

/// Runs at most `cycles` further cycles; returns cycle, cycles, time, and whether the run has ended.
#[wasm_bindgen]
pub fn scope_advance(scope: u32, cycles: u32) -> Result<String, Refusal> {
    to_js(with(scope, |session| json(&session.advance(cycles))))
}

/// Names of the columns of [`scope_traces`].
#[wasm_bindgen]
pub fn scope_columns(scope: u32) -> Result<Vec<String>, Refusal> {
    to_js(with(scope, |session| Ok(session.traces.names())))
}

/// The run so far, row after row: a few thousand of its cycles, including those at which an error, a fault, a limited
/// correction or a correction is largest. NaN once a machine has stopped.
#[wasm_bindgen]
pub fn scope_traces(scope: u32) -> Result<Vec<f64>, Refusal> {
    to_js(with(scope, |session| Ok(session.traces.rows())))
}

/// Figures so far, as in `firmware-sim run --json`.
#[wasm_bindgen]
pub fn scope_figures(scope: u32) -> Result<String, Refusal> {
    to_js(with(scope, |session| json(&session.figures())))
}

/// Applies an act before the run's next cycle, or later: a fault or an event as in a scenario, with `@now` or a time. `{"act",
/// "files"}` also contains the files of the machine whose tables are exchanged. Returns the recorded list, act and time.
#[wasm_bindgen]
pub fn scope_act(scope: u32, act: &str) -> Result<String, Refusal> {
    to_js(with(scope, |session| json(&session.act(act)?)))
}

/// The scenario with all acts: TOML, the command line that repeats it, and the files that it names.
#[wasm_bindgen]
pub fn scope_scenario(scope: u32) -> Result<String, Refusal> {
    to_js(with(scope, |session| json(&session.reproduction()?)))
}

/// Closes a scope and frees its memory.
#[wasm_bindgen]
pub fn scope_close(scope: u32) {
    OPEN.with_borrow_mut(|open| open.sessions.remove(&scope));
}

/// The shipped programs: names, descriptions, texts.
#[wasm_bindgen]
pub fn scope_programs() -> Result<String, Refusal> {
    to_js(json(&documents::programs()))
}

#[cfg(test)]
mod tests;
