//! Thermal growth: a model from a recorded warm-up, its text and the controller's file.

use crate::files::machine;
use crate::{Refused, json, to_js};
use anyhow::{Context, Result, anyhow};
use serde::{Deserialize, Serialize};
use std::path::Path;
use trueaxis::tcomp::machine_id;
use trueaxis_evaluation::rows::Rows;
use trueaxis_evaluation::shown::Shown;
use trueaxis_evaluation::thermal::{COLUMNS, Found, Recording, model, settings, worst, written};
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

/// Drift of an axis in a held-out cycle, at the point where it is largest.
#[derive(Serialize)]
struct Drift {
    axis: char,
    cycle: u32,
    /// X, Y, Z and the tool length.
    point_mm: [f64; 4],
    hours: Vec<f64>,
    measured_um: Vec<f64>,
    /// Drift computed by the task.
    said_um: Vec<f64>,
    left_um: Vec<f64>,
}

/// A fitted record.
#[derive(Serialize)]
struct Fitted {
    /// Printed by `trueaxis thermal fit`.
    shown: Shown,
    drifts: Vec<Drift>,
    /// The text that the command writes.
    toml: String,
    notes: Vec<String>,
}

fn drift(found: &Found, axis: trueaxis::Axis) -> Option<Drift> {
    let series = worst(found, axis)?;
    let column = |take: fn(&[f64; 3]) -> f64| series.rows.iter().map(take).collect();
    Some(Drift {
        axis: axis.letter(),
        cycle: series.cycle,
        point_mm: series.point_mm,
        hours: column(|row| row[0] / 3600.0),
        measured_um: column(|row| 1e3 * row[1]),
        said_um: column(|row| 1e3 * row[2]),
        left_um: column(|row| 1e3 * (row[1] - row[2])),
    })
}

fn fit(files: &str, name: &str, text: &str, request: &str) -> Result<String> {
    let request: Request = serde_json::from_str(request).context("the request of a fit")?;
    let mut notes = Vec::new();
    let machine = machine(files, &mut notes)?;
    let settings = settings(Some(&machine.settings), request.hold_out);
    let rows = Rows::new(text.as_bytes(), Path::new(name), &COLUMNS, |note| notes.push(note))?;
    let found = Found::of(Recording::read(rows, &request.without)?, &settings, &mut |_| {})?;
    let (document, axes) = (found.document(), found.recording.record.axes.iter());
    notes.extend(document.missing.iter().map(|own| format!("{name}: {own}")));
    json(&Fitted {
        shown: document.shown(),
        drifts: axes.filter_map(|axis| drift(&found, *axis)).collect(),
        toml: written(&found),
        notes,
    })
}

/// Fits a recorded warm-up on the machine of these files: `shown`, `drifts`, `toml`, `notes`. `request`: `hold_out`,
/// `without`.
#[wasm_bindgen]
pub fn thermal_fit(files: &str, name: &str, text: &str, request: &str) -> Result<String, Refused> {
    to_js(fit(files, name, text, request))
}

fn compile(files: &str, name: &str, text: &str) -> Result<Vec<u8>> {
    let settings = machine(files, &mut Vec::new())?.settings;
    let model = model(text, Path::new(name), &settings)?;
    model.encode(machine_id(&settings.name, &settings.chain)).map_err(|error| anyhow!("{name}: {error}"))
}

/// Compiles a thermal.toml into the controller's file, for the machine of these files.
#[wasm_bindgen]
pub fn thermal_compile(files: &str, name: &str, text: &str) -> Result<Vec<u8>, Refused> {
    to_js(compile(files, name, text))
}
