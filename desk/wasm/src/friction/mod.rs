//! Friction of two axes: a record, dropped or simulated, what is found in it, and the circles run again with it.
//!
//! A record and what was found stay in the module between the calls; a simulation goes on in slices.

mod bench;

use crate::{Refused, json, told};
use anyhow::Result;
use bench::Bench;
use std::cell::RefCell;
use trueaxis_sim::Settings;
use wasm_bindgen::prelude::*;

#[cfg(target_arch = "wasm32")]
#[wasm_bindgen]
extern "C" {
    /// The worker's: told how far a call under way has come.
    #[wasm_bindgen(js_name = trueaxisProgress)]
    fn progress(what: &str);
}

/// Without a page there is no worker to be told.
#[cfg(not(target_arch = "wasm32"))]
fn progress(_: &str) {}

thread_local! {
    static BENCH: RefCell<Bench> = RefCell::default();
}

fn with<T>(user: impl FnOnce(&mut Bench) -> Result<T>) -> Result<T, Refused> {
    told(BENCH.with_borrow_mut(user))
}

/// Reads a record of `axes` (`X,Y`): samples, period, notes. Found before is forgotten.
#[wasm_bindgen]
pub fn friction_read(name: &str, text: &str, axes: &str) -> Result<String, Refused> {
    with(|bench| json(&bench.read(name, text, axes)?))
}

/// The simulator's settings unless others are given.
#[wasm_bindgen]
pub fn friction_settings() -> Result<String, Refused> {
    told(json(&Settings::default()))
}

/// Begins to simulate circles on a machine; its record or the comparison without or with what was found.
#[wasm_bindgen]
pub fn friction_start(files: &str, request: &str) -> Result<(), Refused> {
    with(|bench| bench.start(files, request))
}

/// Simulates some cycles further: the share that is done, 1 at the end.
#[wasm_bindgen]
pub fn friction_advance(cycles: f64) -> Result<f64, Refused> {
    with(|bench| bench.advance(cycles))
}

/// The record at hand: samples, period.
#[wasm_bindgen]
pub fn friction_record() -> Result<String, Refused> {
    with(|bench| json(&bench.simulated_record()?))
}

/// Following errors of the record for drawing.
#[wasm_bindgen]
pub fn friction_trace(points: usize) -> Result<String, Refused> {
    with(|bench| json(&bench.recording()?.trace(points)))
}

/// The simulated record as CSV.
#[wasm_bindgen]
pub fn friction_csv() -> Result<String, Refused> {
    with(|bench| bench.csv())
}

/// Finds friction, and the drives where the machine does not state them or `find_drive` asks for it: the command line's
/// document, spikes, circles, settings as TOML.
#[wasm_bindgen]
pub fn friction_fit(files: &str, find_drive: bool) -> Result<String, Refused> {
    with(|bench| json(&bench.fit(files, find_drive, &mut progress)?))
}

/// The simulated circles without and with what was found.
#[wasm_bindgen]
pub fn friction_closed() -> Result<String, Refused> {
    with(|bench| json(&bench.closed()?))
}

/// The machine of `files` with what of the figures found is written: `files`, `changes`, `notes`.
#[wasm_bindgen]
pub fn friction_becomes(files: &str) -> Result<String, Refused> {
    with(|bench| json(&bench.becomes(files)?))
}
