//! Rehearsals: the log that a task's program would give on a machine whose true errors are drawn.

use crate::becomes::values;
use crate::files::{DESCRIPTION, machine_of, memory, texts};
use crate::{Refusal, json, to_js};
use anyhow::{Context, Result, bail};
use serde::Serialize;
use std::path::Path;
use trueaxis_evaluation::calibrate::Task;
use trueaxis_evaluation::keep::{KeepTask, State};
use trueaxis_evaluation::shown::{Cell, Table};
use trueaxis_evaluation::simulated::rehearsal::{self, Conditions, Drift, drawn, is_stated};
use trueaxis_tables::Machine;
use trueaxis_tables::files::Memory;
use trueaxis_tables::uncertainty::Uncertainties;
use wasm_bindgen::prelude::*;

/// A rehearsed log.
#[derive(Serialize)]
struct Rehearsed {
    log: String,
    /// Location errors and lost motion of the machine shown and of the true one.
    truth: Table,
}

/// Conditions of the command line's seed, without drift.
fn conditions(seed: u32, set_up: u32) -> Conditions {
    Conditions { noise_um: None, drift: Drift::Size(0.0), seed: seed.into(), set_up: set_up.into() }
}

/// The machine drawn about the one of these files, within the uncertainties that they state.
fn truth(files: &str, known: &Machine, conditions: &Conditions) -> Result<Machine> {
    let stated = Uncertainties::read_from(&memory(files)?, Path::new(DESCRIPTION))?;
    if !is_stated(&stated) {
        bail!(
            "{DESCRIPTION}: found no uncertainty to draw the true errors from, needed [uncertainty.location] or \
             [axis.X.uncertainty] there"
        );
    }
    drawn(known, &stated, conditions).context(DESCRIPTION)
}

fn rehearsed(log: String, known: &Machine, truth: &Machine) -> Result<String> {
    let rows = values(known).into_iter().zip(values(truth));
    let rows = rows.filter(|(known, truth)| known.1 != 0.0 || truth.1 != 0.0);
    let rows = rows.map(|((key, known), (_, truth))| vec![key.into(), Cell::fixed(known, 2), Cell::fixed(truth, 2)]);
    json(&Rehearsed { log, truth: Table::new("True errors of the rehearsal", ["", "in the files", "true"], rows) })
}

fn calibrate(files: &str, name: &str, task: &str, seed: u32) -> Result<String> {
    let (task, known) = (Task::read(task, Path::new(name))?, machine_of(&texts(files)?, &mut Vec::new())?);
    let conditions = conditions(seed, seed);
    let truth = truth(files, &known, &conditions)?;
    rehearsed(rehearsal::calibrate(&task, &known, &truth, &conditions)?, &known, &truth)
}

/// The log that `trueaxis calibrate simulate --seed` writes for a task on the machine of these files: `log`, `truth`.
#[wasm_bindgen]
pub fn calibrate_rehearse(files: &str, name: &str, task: &str, seed: u32) -> Result<String, Refusal> {
    to_js(calibrate(files, name, task, seed))
}

fn keep(files: &str, name: &str, task: &str, seed: u32, moved: bool) -> Result<String> {
    let task = KeepTask::read(task, Path::new(name))?;
    let state = State::of_texts(task, Memory::new(texts(files)?), "", &mut |_| {})?;
    let (known, conditions) = (&state.machine, conditions(seed, 1));
    let truth = if moved { truth(files, known, &conditions)? } else { known.clone() };
    rehearsed(rehearsal::keep(&state.task, known, &truth, &conditions)?, known, &truth)
}

/// The log that `trueaxis keep simulate --seed` writes, of a machine that has `moved` within its uncertainties or of the one
/// that its files state. The balls stay where they are. Returns `log`, `truth`.
#[wasm_bindgen]
pub fn keep_rehearse(files: &str, name: &str, task: &str, seed: u32, moved: bool) -> Result<String, Refusal> {
    to_js(keep(files, name, task, seed, moved))
}
