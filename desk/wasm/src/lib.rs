//! The desk's module: the page's interface to the crates of trueaxis. It contains no formulas.
//!
//! Every export takes texts and numbers and returns a JSON document, a text or an array of numbers. A machine is a JSON object
//! with the texts of its files, `{"machine.toml": "…", "x.csv": "…"}`. An error of the crates is thrown as the text that the
//! command line prints ([`Refusal`]). The documents come from `trueaxis-evaluation`, the runs from `trueaxis-sim`.
//!
//! A panic is reported to the page ([`panics`]) and ends the module; the page starts a new one.
#![forbid(unsafe_code)]

pub mod ballbar;
mod becomes;
pub mod calibrate;
pub mod evaluate;
pub mod field;
mod files;
pub mod friction;
pub mod grinding;
pub mod helicoid;
pub mod keep;
pub mod machine;
pub mod panics;
pub mod predict;
pub mod rehearsal;
pub mod roundness;
mod samples;
pub mod scope;
pub mod scope_settings;
mod shown;
pub mod thermal;
pub mod uncertainty;

use serde::Serialize;
use std::fmt;
use trueaxis_tables::text::printable;
use wasm_bindgen::prelude::*;

#[cfg(target_arch = "wasm32")]
#[wasm_bindgen]
extern "C" {
    /// The worker's callback for the progress of the current call.
    #[wasm_bindgen(js_name = trueaxisProgress)]
    fn progress(what: &str);
}

/// A build without a page has no worker to notify.
#[cfg(not(target_arch = "wasm32"))]
fn progress(_: &str) {}

/// Version of the crates.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}

/// Reason for a refusal by an export, thrown on the page as an `Error` with this text. A program that calls the exports
/// without a page reads the text directly.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal(String);

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refusal {}

impl From<Refusal> for JsValue {
    fn from(refused: Refusal) -> JsValue {
        JsError::new(&refused.0).into()
    }
}

/// Converts a result for the page: the error's text with its causes, on one line even if it quotes several lines.
fn to_js<T>(result: anyhow::Result<T>) -> Result<T, Refusal> {
    result.map_err(|error| Refusal(printable(&format!("{error:#}")).replace('\n', "\\n")))
}

/// A document as JSON.
fn json(document: &impl Serialize) -> anyhow::Result<String> {
    Ok(trueaxis_evaluation::json::compact(document)?)
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_refusal_is_one_line_whatever_it_repeats() {
        let refused = super::helicoid::helicoid_csv("{\"a\\nb\\u001b\": 1}").unwrap_err().to_string();
        assert!(refused.starts_with("unknown field `a\\nb\\u{1b}`, expected one of"), "{refused}");
    }
}
