//! Volumetric error over the working volume.

use crate::files::machine;
use crate::{Refusal, json, to_js};
use anyhow::Context;
use trueaxis_evaluation::field::{self as fields, Settings};
use wasm_bindgen::prelude::*;

fn settings(request: &str) -> anyhow::Result<Settings> {
    serde_json::from_str(request).context("the request of a field")
}

fn rows(files: &str, request: &str) -> anyhow::Result<Vec<f32>> {
    fields::rows(&machine(files, &mut Vec::new())?, &settings(request)?)
}

fn figures(files: &str, request: &str) -> anyhow::Result<String> {
    json(&fields::figures(&machine(files, &mut Vec::new())?, &settings(request)?)?)
}

/// The field as rows of nine numbers: x, y, z, mm; error before and error after, µm. `request`: [`Settings`] as JSON.
#[wasm_bindgen]
pub fn field(files: &str, request: &str) -> Result<Vec<f32>, Refusal> {
    to_js(rows(files, request))
}

/// Figures of the field before and after, under both models: [`fields::Figures`] as JSON.
#[wasm_bindgen]
pub fn field_figures(files: &str, request: &str) -> Result<String, Refusal> {
    to_js(figures(files, request))
}
