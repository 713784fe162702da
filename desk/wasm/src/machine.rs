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

/// Files of a sample machine.
#[wasm_bindgen]
pub fn machine_sample(name: &str) -> Result<String, JsError> {
    told(sample(name))
}

fn sample(name: &str) -> anyhow::Result<String> {
    const FILES: [(&str, &str); 4] = [
        ("machine.toml", include_str!("../../../compensation-tables/mill-3axis/machine.toml")),
        ("x.csv", include_str!("../../../compensation-tables/mill-3axis/x.csv")),
        ("y.csv", include_str!("../../../compensation-tables/mill-3axis/y.csv")),
        ("z.csv", include_str!("../../../compensation-tables/mill-3axis/z.csv")),
    ];
    anyhow::ensure!(name == "mill-3axis", "found {name}, needed mill-3axis");
    json(&std::collections::BTreeMap::from(FILES))
}
