//! A crankpin ground with and without infeed correction, in slices.

use crate::files::machine;
use crate::{Refusal, json, to_js};
use anyhow::{Context, Result};
use std::cell::RefCell;
use std::collections::BTreeMap;
use trueaxis::roundness::{GaugeSettings, ProbeAngles};
use trueaxis_evaluation::probes::Probes;
use trueaxis_evaluation::simulated::grinding;
use trueaxis_sim::grinding::{Comparison, Request};
use trueaxis_tables::Machine;
use wasm_bindgen::prelude::*;

/// The sample machine with a gauge.
const SAMPLE: [(&str, &str); 2] = [
    ("machine.toml", include_str!("../../../compensation-tables/grinder/machine.toml")),
    ("x.csv", include_str!("../../../compensation-tables/grinder/x.csv")),
];

thread_local! {
    static COMPARISON: RefCell<Option<Comparison>> = const { RefCell::new(None) };
}

/// The sample grinder.
pub(crate) fn sample() -> Result<Machine> {
    machine(&grinding_machine(), &mut Vec::new())
}

/// Points, band and angles of a gauge in the form of the bench commands.
pub(crate) fn probes(gauge: &GaugeSettings) -> Probes {
    let of = Probes {
        n: usize::from(gauge.points),
        harmonics: Some([gauge.band.first, gauge.band.last]),
        ..Probes::default()
    };
    match gauge.angles {
        ProbeAngles::Slots { p, q } => Probes { p: Some(p.into()), q: Some(q.into()), ..of },
        ProbeAngles::Degrees { phi2, phi3 } => Probes { phi2_deg: Some(phi2), phi3_deg: Some(phi3), ..of },
    }
}

/// Files of the sample grinder.
#[wasm_bindgen]
pub fn grinding_machine() -> String {
    serde_json::json!(SAMPLE.into_iter().collect::<BTreeMap<_, _>>()).to_string()
}

fn open(files: &str, request: &str) -> Result<()> {
    COMPARISON.set(None);
    let request: Request = serde_json::from_str(request).context("what is asked of the run")?;
    request.check()?;
    COMPARISON.set(Some(Comparison::new(request.grinding(machine(files, &mut Vec::new())?)?)?));
    Ok(())
}

/// Prepares grinding without and with correction, as `firmware-sim grind` does.
#[wasm_bindgen]
pub fn grinding_open(files: &str, request: &str) -> Result<(), Refusal> {
    to_js(open(files, request))
}

const NOT_OPEN: &str = "no grinding has been prepared";

fn advance(cycles: u32) -> Result<f64> {
    COMPARISON.with_borrow_mut(|comparison| {
        let comparison = comparison.as_mut().context(NOT_OPEN)?;
        let more = comparison.advance(cycles.into())?;
        Ok(if more { comparison.share().min(0.999_999) } else { 1.0 })
    })
}

/// Runs at most `cycles` further cycles; returns the fraction done, 1 once both runs have ended.
#[wasm_bindgen]
pub fn grinding_advance(cycles: u32) -> Result<f64, Refusal> {
    to_js(advance(cycles))
}

fn plots() -> Result<String> {
    COMPARISON.with_borrow(|comparison| json(&grinding::plots(comparison.as_ref().context(NOT_OPEN)?.revolutions())))
}

/// Plots of the revolutions so far.
#[wasm_bindgen]
pub fn grinding_plots() -> Result<String, Refusal> {
    to_js(plots())
}

fn finish() -> Result<String> {
    let comparison = COMPARISON.take().context(NOT_OPEN)?;
    let request = comparison.grinding().clone();
    json(&grinding::shown(&request, &comparison.finish()?)?)
}

/// The result as `firmware-sim grind` shows it, without the elapsed time.
#[wasm_bindgen]
pub fn grinding_finish() -> Result<String, Refusal> {
    to_js(finish())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    #[test]
    fn slices_of_any_length_give_the_figures_of_one_run() {
        let request = json!({"revolutions": 8, "rate_hz": 4000.0, "speed_rpm": 20.0, "seed": 11});
        assert!(advance(1).is_err() && finish().is_err());
        open(&grinding_machine(), &request.to_string()).unwrap();
        while advance(777).unwrap() < 1.0 {}
        let drawn: Value = serde_json::from_str(&plots().unwrap()).unwrap();
        let found = finish().unwrap();
        let request: Request = serde_json::from_value(request).unwrap();
        let whole = request.grinding(sample().unwrap()).unwrap();
        let outcome = trueaxis_sim::grinding::simulate(&whole, &mut |_| {}).unwrap();
        let shown = grinding::shown(&whole, &outcome).unwrap();
        // Compared as texts, since numbers read back may differ in their last bit.
        assert_eq!(found, trueaxis_evaluation::json::compact(&shown).unwrap());
        let found: Value = serde_json::from_str(&found).unwrap();
        assert_eq!(found["plots"], drawn);
        assert_eq!(drawn[0]["curves"][1]["values"].as_array().unwrap().len(), 8);
        let evaluated = found["tables"][0]["rows"].as_array().unwrap();
        let evaluated = evaluated.iter().find(|row| row[0] == "revolutions evaluated").unwrap();
        assert!(evaluated[2]["value"].as_f64().unwrap() > 0.0);
    }

    #[test]
    fn unsuitable_requests_are_refused_as_on_the_command_line() {
        let refused = |request: Value| open(&grinding_machine(), &request.to_string()).unwrap_err().to_string();
        assert_eq!(refused(json!({"revolutions": 7})), "--revolutions: found 7, needed 8 to 10000");
        assert!(refused(json!({"gain": 0.9})).starts_with("--gain: found 0.9, needed above 0 and at most "));
        assert!(refused(json!({"speed_rpm": 5000.0})).starts_with("--speed-rpm: found 5000, needed 0.1 to "));
    }
}
