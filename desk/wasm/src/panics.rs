//! Reports a panic to the worker that runs the module; the panic then ends the module.

use std::panic::PanicHookInfo;
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
extern "C" {
    /// The worker's callback; receives the message and location.
    #[wasm_bindgen(js_name = trueaxisPanicked)]
    fn panicked(what: &str);
}

fn report(info: &PanicHookInfo<'_>) {
    panicked(&info.to_string());
}

/// Installs the panic hook when the module is loaded.
#[wasm_bindgen(start)]
pub fn start() {
    std::panic::set_hook(Box::new(report));
}

/// Panics, so that the page can test that it reports and survives a fault in the module.
#[wasm_bindgen]
pub fn panic_on_purpose() {
    panic!("asked for by the page's check of itself");
}
