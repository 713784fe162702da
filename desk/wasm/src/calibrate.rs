//! Calibration with a touch probe: a program from a task, and errors and the corrected machine from its log.

use crate::becomes::Becomes;
use crate::files::{machine_of, texts};
use crate::{Refusal, json, to_js};
use anyhow::Result;
use serde::Serialize;
use std::path::Path;
use trueaxis_evaluation::calibrate::{Foreseen, Planning, Residuals, Task, solved};
use trueaxis_evaluation::shown::{Shown, Table};
use trueaxis_tables::Machine;
use wasm_bindgen::prelude::*;

/// A planned task.
#[derive(Serialize)]
struct Planned {
    /// The document printed by `trueaxis calibrate plan --json`.
    foreseen: Foreseen,
    /// The uncertainties expected.
    expected: Table,
    /// The program, or the sheet for a dial's readings.
    program: String,
    is_sheet: bool,
    notes: Vec<String>,
}

/// A solved log.
#[derive(Serialize)]
struct SolvedLog {
    /// Printed by `trueaxis calibrate solve`.
    shown: Shown,
    machine: String,
    touches: usize,
    residuals: Residuals,
    becomes: Becomes,
    notes: Vec<String>,
}

fn read(files: &str, name: &str, task: &str, notes: &mut Vec<String>) -> Result<(Task, Machine)> {
    Ok((Task::read(task, Path::new(name))?, machine_of(&texts(files)?, notes)?))
}

fn plan(files: &str, name: &str, task: &str) -> Result<String> {
    let mut notes = Vec::new();
    let (task, machine) = read(files, name, task, &mut notes)?;
    let Planning { program, foreseen, .. } = Planning::new(&task, &machine)?;
    json(&Planned { expected: foreseen.expected(), foreseen, program, is_sheet: task.is_read(), notes })
}

/// Plans a task on the machine of these files, whichever machine the task names: `foreseen`, `program`, `notes`. Errors refer
/// to the task by `name`.
#[wasm_bindgen]
pub fn calibrate_plan(files: &str, name: &str, task: &str) -> Result<String, Refusal> {
    to_js(plan(files, name, task))
}

fn solve(files: &str, name: &str, task: &str, log_name: &str, log: &str) -> Result<String> {
    let mut notes = Vec::new();
    let (task, machine) = read(files, name, task, &mut notes)?;
    let (plan, found) = solved(&task, &machine, log, Path::new(log_name), |note| notes.push(note))?;
    let becomes = Becomes::new(files, &found.additions(&task).of_record(log.as_bytes()))?;
    let document = found.document(&task, &machine);
    json(&SolvedLog {
        shown: document.shown(&found),
        machine: document.machine,
        touches: document.touches,
        residuals: Residuals::of(&task, &plan, &found),
        becomes,
        notes,
    })
}

/// Solves a log of the task's program: `shown`, `machine`, `touches`, `residuals`, `becomes` (the corrected machine), `notes`.
#[wasm_bindgen]
pub fn calibrate_solve(files: &str, name: &str, task: &str, log_name: &str, log: &str) -> Result<String, Refusal> {
    to_js(solve(files, name, task, log_name, log))
}
