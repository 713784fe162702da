//! The desk's module: what the page asks of the crates of trueaxis. It has no formula of its own.
//!
//! Every export takes texts and numbers and gives a JSON document, a text or an array of numbers. Machines are the texts of
//! their files as a JSON object, `{"machine.toml": "…", "x.csv": "…"}`. What the crates refuse is thrown as the text that the
//! command line prints. The documents themselves come from `trueaxis-evaluation`, the runs from `trueaxis-sim`.
//!
//! A panic is reported to the page ([`panics`]) and ends the module; the page starts another.
#![forbid(unsafe_code)]

pub mod field;
mod files;
pub mod friction;
pub mod grinding;
pub mod helicoid;
pub mod machine;
pub mod panics;
pub mod roundness;
mod samples;
pub mod scope;
pub mod scope_settings;
mod shown;

use serde::Serialize;
use wasm_bindgen::prelude::*;

/// Version of the crates.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}

/// A result as the page takes it: the error's text, with its causes.
fn told<T>(result: anyhow::Result<T>) -> Result<T, JsError> {
    result.map_err(|error| JsError::new(&format!("{error:#}")))
}

/// A document as JSON.
fn json(document: &impl Serialize) -> anyhow::Result<String> {
    Ok(serde_json::to_string(document)?)
}
