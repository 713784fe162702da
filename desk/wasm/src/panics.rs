//! A panic ends the module; before that it is reported to the worker that runs it.

use std::panic::PanicHookInfo;
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
extern "C" {
    /// The worker's: told what happened and where.
    #[wasm_bindgen(js_name = trueaxisPanicked)]
    fn panicked(what: &str);
}

fn report(info: &PanicHookInfo<'_>) {
    panicked(&info.to_string());
}

/// Called once when the module is loaded.
#[wasm_bindgen(start)]
pub fn start() {
    std::panic::set_hook(Box::new(report));
}

/// Panics: the page's check of itself, that a fault in the module is told and survived.
#[wasm_bindgen]
pub fn panic_on_purpose() {
    panic!("asked for by the page's check of itself");
}
