//! Friction of two axes: a dropped or simulated record, the friction identified in it, and the circles repeated with it.
//!
//! The module keeps the record and the results between the calls; a simulation runs in slices.

mod bench;

use crate::{Refusal, json, progress, to_js};
use anyhow::Result;
use bench::Bench;
use std::cell::RefCell;
use trueaxis_sim::Settings;
use wasm_bindgen::prelude::*;

thread_local! {
    static BENCH: RefCell<Bench> = RefCell::default();
}

fn with<T>(user: impl FnOnce(&mut Bench) -> Result<T>) -> Result<T, Refusal> {
    to_js(BENCH.with_borrow_mut(user))
}

/// Reads a record of `axes` (`X,Y`): samples, period, notes. Discards earlier results.
#[wasm_bindgen]
pub fn friction_read(name: &str, text: &str, axes: &str) -> Result<String, Refusal> {
    with(|bench| json(&bench.read(name, text, axes)?))
}

/// The simulator's default settings.
#[wasm_bindgen]
pub fn friction_settings() -> Result<String, Refusal> {
    to_js(json(&Settings::default()))
}

/// Begins to simulate circles on a machine: as the record, or for comparison without or with the identified friction.
#[wasm_bindgen]
pub fn friction_start(files: &str, request: &str) -> Result<(), Refusal> {
    with(|bench| bench.start(files, request))
}

/// Simulates some further cycles; returns the fraction done, 1 at the end.
#[wasm_bindgen]
pub fn friction_advance(cycles: f64) -> Result<f64, Refusal> {
    with(|bench| bench.advance(cycles))
}

/// The simulated record: samples, period.
#[wasm_bindgen]
pub fn friction_record() -> Result<String, Refusal> {
    with(|bench| json(&bench.simulated_record()?))
}

/// Following errors of the record, for plotting.
#[wasm_bindgen]
pub fn friction_trace(points: usize) -> Result<String, Refusal> {
    with(|bench| json(&bench.recording()?.trace(points)))
}

/// The simulated record as CSV.
#[wasm_bindgen]
pub fn friction_csv() -> Result<String, Refusal> {
    with(|bench| bench.csv())
}

/// Identifies friction, and the drives if the machine does not state them or `find_drive` is set: tables and plots,
/// largest spikes, settings as TOML.
#[wasm_bindgen]
pub fn friction_fit(files: &str, find_drive: bool) -> Result<String, Refusal> {
    with(|bench| json(&bench.fit(files, find_drive, &mut progress)?))
}

/// Tables and plots of the simulated circles without and with the identified friction.
#[wasm_bindgen]
pub fn friction_closed() -> Result<String, Refusal> {
    with(|bench| json(&bench.closed()?))
}

/// The machine of `files` with those identified figures that are written: `files`, `changes`, `notes`.
#[wasm_bindgen]
pub fn friction_becomes(files: &str) -> Result<String, Refusal> {
    with(|bench| json(&bench.becomes(files)?))
}
