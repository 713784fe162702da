//! Thermal growth: a model from a recorded warm-up, its text and the controller's file.

use crate::files::machine;
use crate::{Refusal, json, to_js};
use anyhow::{Context, Result, anyhow};
use serde::{Deserialize, Serialize};
use std::path::Path;
use trueaxis::tcomp::machine_id;
use trueaxis_evaluation::rows::Rows;
use trueaxis_evaluation::shown::Shown;
use trueaxis_evaluation::thermal::{COLUMNS, FittedRecording, Recording, model, settings, written};
use trueaxis_sim::warming::{Recording as Recorded, csv};
use wasm_bindgen::prelude::*;

/// Inputs in addition to the record.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Request {
    /// Cycles to hold out of the fit; the last one if empty.
    hold_out: Vec<u32>,
    /// Names of sensors to omit.
    without: Vec<String>,
}

/// A fitted record.
#[derive(Serialize)]
struct Fitted {
    /// Printed by `trueaxis thermal fit`.
    shown: Shown,
    /// The text that the command writes.
    toml: String,
    notes: Vec<String>,
}

fn fit(files: &str, name: &str, text: &str, request: &str) -> Result<String> {
    let request: Request = serde_json::from_str(request).context("the request of a fit")?;
    let mut notes = Vec::new();
    let machine = machine(files, &mut notes)?;
    let settings = settings(Some(&machine.settings), request.hold_out);
    let rows = Rows::new(text.as_bytes(), Path::new(name), &COLUMNS, |note| notes.push(note))?;
    let found = FittedRecording::of(Recording::read(rows, &request.without)?, &settings, &mut |_| {})?;
    let document = found.document();
    json(&Fitted { shown: document.shown(&found), toml: written(&found), notes })
}

/// The record that `trueaxis thermal simulate --at 0,0,-200,60` writes.
#[wasm_bindgen]
pub fn thermal_sample() -> String {
    // At one point: the fit of a record at four takes seconds.
    csv(&Recorded { seed: 1, shifts: 5, noise_um: 0.5, points: vec![[0.0, 0.0, -200.0, 60.0]] }.record())
}

/// Fits a recorded warm-up on the machine of these files: `shown`, `toml`, `notes`. `request`: `hold_out`,
/// `without`.
#[wasm_bindgen]
pub fn thermal_fit(files: &str, name: &str, text: &str, request: &str) -> Result<String, Refusal> {
    to_js(fit(files, name, text, request))
}

fn compile(files: &str, name: &str, text: &str) -> Result<Vec<u8>> {
    let settings = machine(files, &mut Vec::new())?.settings;
    let model = model(text, Path::new(name), &settings)?;
    model.encode(machine_id(&settings.name, &settings.chain)).map_err(|error| anyhow!("{name}: {error}"))
}

/// Compiles a thermal.toml into the controller's file, for the machine of these files.
#[wasm_bindgen]
pub fn thermal_compile(files: &str, name: &str, text: &str) -> Result<Vec<u8>, Refusal> {
    to_js(compile(files, name, text))
}
