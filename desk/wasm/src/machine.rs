//! A machine and its tables.

use crate::files::machine;
use crate::{json, told};
use serde::Serialize;
use wasm_bindgen::prelude::*;

/// A machine that was read.
#[derive(Serialize)]
struct Opened {
    name: String,
    axes: Vec<String>,
    notes: Vec<String>,
}

fn opened(files: &str) -> anyhow::Result<String> {
    let mut notes = Vec::new();
    let machine = machine(files, &mut notes)?;
    let axes = machine.settings.axes.iter().map(|own| own.axis.letter().to_string()).collect();
    json(&Opened { name: machine.settings.name.as_str().to_owned(), axes, notes })
}

/// Reads and checks a machine: name, axes, notes.
#[wasm_bindgen]
pub fn machine_open(files: &str) -> Result<String, JsError> {
    told(opened(files))
}
