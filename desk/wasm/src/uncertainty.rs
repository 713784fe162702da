//! Uncertainty of the corrected position.

use crate::files::{DESCRIPTION, machine, memory};
use crate::{Refusal, json, to_js};
use anyhow::{Context, Result, anyhow};
use serde::{Deserialize, Serialize};
use std::path::Path;
use trueaxis_evaluation::correct::position;
use trueaxis_evaluation::shown::Shown;
use trueaxis_evaluation::uncertainty::{Options, evaluate};
use trueaxis_tables::uncertainty::Uncertainties;
use wasm_bindgen::prelude::*;

/// Options of the evaluation.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Request {
    /// Additional position to evaluate, or an empty list.
    at: Vec<f64>,
    points: usize,
    confidence_percent: f64,
    trials: usize,
    seed: u64,
}

/// Result of the evaluation.
#[derive(Serialize)]
struct Known {
    /// Printed by `trueaxis uncertainty`.
    shown: Shown,
    /// The point with the largest radius, and that radius by derivatives, µm.
    worst: (String, f64),
    /// Distances of the tip at the worst point, µm, over the random machines in ascending order: every hundredth of them.
    distances_um: Vec<f64>,
    notes: Vec<String>,
}

fn known(files: &str, request: &str) -> Result<String> {
    let request: Request = serde_json::from_str(request).context("the request of an uncertainty")?;
    let mut notes = Vec::new();
    let machine = machine(files, &mut notes)?;
    let stated = Uncertainties::read_from(&memory(files)?, Path::new(DESCRIPTION))?;
    let at = match request.at.as_slice() {
        [] => None,
        at => Some(position(at, &machine).map_err(|wrong| anyhow!("--at: {wrong}"))?),
    };
    let options = Options {
        at,
        points: request.points,
        coverage: request.confidence_percent / 100.0,
        trials: request.trials,
        seed: request.seed,
        ..Options::default()
    };
    let document = evaluate(&machine, &stated, &options)?;
    let distances_um = document.distances_um();
    let worst = (document.worst.place(), document.worst.jacobian.radius_um);
    json(&Known { shown: document.shown(), worst, distances_um, notes })
}

/// The uncertainty of the corrected position over the working volume: `shown`, `worst`, `distances_um`, `notes`. `request`: `at`,
/// `points`, `confidence_percent`, `trials`, `seed`.
#[wasm_bindgen]
pub fn uncertainty(files: &str, request: &str) -> Result<String, Refusal> {
    to_js(known(files, request))
}
