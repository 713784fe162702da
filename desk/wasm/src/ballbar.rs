//! Circular tests: figures after ISO 230-4, causes, and the resulting settings.
//!
//! The module keeps the latest evaluated test, so that the page can write it to the machine.

use crate::becomes::Becomes;
use crate::{Refusal, json, to_js};
use anyhow::{Context, Result, anyhow};
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::path::Path;
use trueaxis_evaluation::ballbar::{Options, Test};
use trueaxis_evaluation::friction::pair;
use trueaxis_evaluation::shown::Shown;
use trueaxis_tables::Additions;
use trueaxis_tables::finding::record_number;
use wasm_bindgen::prelude::*;

/// Inputs in addition to the record.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Request {
    radius_mm: f64,
    /// As `X,Y`.
    axes: String,
    /// Pitches of the periodic errors of X, Y, Z; null to search for the pitch.
    #[serde(default)]
    pitches_mm: [Option<f64>; 3],
}

/// An evaluated record.
#[derive(Serialize)]
struct Evaluated {
    /// Printed by `trueaxis ballbar`.
    shown: Shown,
    notes: Vec<String>,
}

thread_local! {
    static TEST: RefCell<Option<(Test, String)>> = RefCell::default();
}

fn evaluate(name: &str, bytes: &[u8], request: &str) -> Result<String> {
    TEST.take();
    let request: Request = serde_json::from_str(request).context("the request of a circular test")?;
    let axes = pair(&request.axes).map_err(|error| anyhow!("--axes: {error}"))?;
    let options = Options::new(request.radius_mm, axes, request.pitches_mm).map_err(|wrong| wrong.option())?;
    let mut notes = Vec::new();
    let test = Test::read(bytes, Path::new(name), &options, |note| notes.push(note))?;
    let evaluated = Evaluated { shown: test.document().shown(&test), notes };
    TEST.set(Some((test, record_number(bytes))));
    json(&evaluated)
}

/// Evaluates a record in any format that `trueaxis ballbar` reads: tables, plots, notes. `request`:
/// `{"radius_mm": 100, "axes": "X,Y", "pitches_mm": [10, null, null]}`.
#[wasm_bindgen]
pub fn ballbar_evaluate(name: &str, bytes: &[u8], request: &str) -> Result<String, Refusal> {
    to_js(evaluate(name, bytes, request))
}

fn settings(files: &str, compensated: bool) -> Result<String> {
    TEST.with_borrow(|test| {
        let (test, record) =
            test.as_ref().ok_or_else(|| anyhow!("found no circular test, needed one that was evaluated"))?;
        let additions = Additions { record: Some(record.clone()), ..test.additions(compensated) };
        json(&Becomes::new(files, &additions)?)
    })
}

/// The machine with the settings from the test: `files`, `settings` (`key`, `before`, `after`, `uncertainty`), `notes`.
/// `compensated`: whether its tables corrected it while the circles were run.
#[wasm_bindgen]
pub fn ballbar_settings(files: &str, compensated: bool) -> Result<String, Refusal> {
    to_js(settings(files, compensated))
}

/// Discards the test.
#[wasm_bindgen]
pub fn ballbar_forget() {
    TEST.take();
}
