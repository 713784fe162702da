//! Roundness and spindle error from three probes, reference circles of a trace, probe angles.
//!
//! The module keeps the latest evaluation for its figure and curves.

use crate::{Refusal, json, to_js};
use anyhow::{Context, Result};
use serde::Serialize;
use std::cell::RefCell;
use std::path::Path;
use trueaxis_evaluation::rows::Rows;
use trueaxis_evaluation::shown::{Shown, Table};
use trueaxis_evaluation::{circle, probe_angles, roundness};
use trueaxis_sim::grinding;
use wasm_bindgen::prelude::*;

/// Revolutions of the sample readings.
const SAMPLE_REVOLUTIONS: u32 = 8;

enum Evaluated {
    Nothing,
    Readings(Box<roundness::Evaluation>),
    Trace(Box<circle::Evaluation>),
}

thread_local! {
    static EVALUATED: RefCell<Evaluated> = const { RefCell::new(Evaluated::Nothing) };
    static SEARCH: RefCell<Option<probe_angles::Search>> = const { RefCell::new(None) };
}

/// Tables and plots of an evaluation, its warnings, and the command line's notes.
#[derive(Serialize)]
struct Noted<'e> {
    warnings: &'e [String],
    shown: Shown,
    notes: Vec<String>,
}

fn evaluate(name: &str, text: &str, request: &str) -> Result<String> {
    EVALUATED.set(Evaluated::Nothing);
    let request: roundness::Request = serde_json::from_str(request).context("what is asked of the readings")?;
    let plan = request.plan()?;
    let mut notes = Vec::new();
    let mut rows = Rows::new(text.as_bytes(), Path::new(name), &roundness::COLUMNS, |note| notes.push(note))?;
    let readings = plan.read(&mut rows)?;
    drop(rows);
    notes.extend(readings.note(plan.points()));
    let separations = plan.separate(&readings, || {})?;
    let evaluation = plan.evaluate(&separations, &readings)?;
    let said = json(&Noted { warnings: &evaluation.document.warnings, shown: plan.shown(&evaluation), notes });
    EVALUATED.set(Evaluated::Readings(Box::new(evaluation)));
    said
}

/// Evaluates readings of three probes as `trueaxis roundness` does: tables, plots, warnings, notes.
#[wasm_bindgen]
pub fn roundness_evaluate(name: &str, text: &str, request: &str) -> Result<String, Refusal> {
    to_js(evaluate(name, text, request))
}

fn trace(name: &str, text: &str) -> Result<String> {
    EVALUATED.set(Evaluated::Nothing);
    let mut notes = Vec::new();
    let mut rows = Rows::new(text.as_bytes(), Path::new(name), &circle::COLUMNS, |note| notes.push(note))?;
    let evaluation = circle::Evaluation::read(&mut rows)?;
    drop(rows);
    let said = json(&Noted { warnings: &[], shown: evaluation.shown(), notes });
    EVALUATED.set(Evaluated::Trace(Box::new(evaluation)));
    said
}

/// Reference circles of a trace as `trueaxis circle` fits them: table, notes.
#[wasm_bindgen]
pub fn roundness_trace(name: &str, text: &str) -> Result<String, Refusal> {
    to_js(trace(name, text))
}

fn polar(lsc: bool, mzc: bool, mic: bool, mcc: bool) -> Result<String> {
    let shown = [lsc, mzc, mcc, mic];
    EVALUATED.with_borrow(|evaluated| {
        let figure = match evaluated {
            Evaluated::Nothing => None,
            Evaluated::Readings(readings) => Some(roundness::polar(readings, shown)),
            Evaluated::Trace(trace) => circle::polar(trace, shown),
        };
        figure.map(|figure| figure.to_html()).context("nothing has been evaluated")
    })
}

/// Polar plot of the latest evaluation with these circles, as HTML.
#[wasm_bindgen]
pub fn roundness_polar(lsc: bool, mzc: bool, mic: bool, mcc: bool) -> Result<String, Refusal> {
    to_js(polar(lsc, mzc, mic, mcc))
}

fn orbit() -> Result<String> {
    EVALUATED.with_borrow(|evaluated| match evaluated {
        Evaluated::Readings(found) => Ok(roundness::orbit(found).to_html()),
        _ => anyhow::bail!("no readings have been evaluated"),
    })
}

/// Orbit of the spindle axis in the latest evaluated readings, single revolutions and their mean, as HTML.
#[wasm_bindgen]
pub fn roundness_orbit() -> Result<String, Refusal> {
    to_js(orbit())
}

/// Sample readings and their evaluation request.
#[derive(Serialize)]
struct Sample {
    name: &'static str,
    text: String,
    request: roundness::Request,
}

fn sample() -> Result<String> {
    let grinding = grinding::Request::default().grinding(crate::grinding::sample()?)?;
    let gauge = grinding.gauge()?;
    let mut text = String::from("h1_um,h2_um,h3_um\n");
    for [h1, h2, h3] in grinding::readings(&grinding, SAMPLE_REVOLUTIONS)? {
        text += &format!("{h1:.4},{h2:.4},{h3:.4}\n");
    }
    let arm = gauge.arm.map(|arm| [arm.lengths.crank_mm, arm.lengths.wheel_mm, arm.lengths.pin_mm]);
    let probes = crate::grinding::probes(gauge);
    let noise_gain_limit = trueaxis_metrology::separation::NOISE_GAIN_LIMIT;
    let request = roundness::Request { probes, arm, upr: gauge.filter, noise_gain_limit };
    json(&Sample { name: "grinder-probes.csv", text, request })
}

/// Simulated readings of the sample grinder's gauge: name, text, request.
#[wasm_bindgen]
pub fn roundness_sample() -> Result<String, Refusal> {
    to_js(sample())
}

fn angles(probes: &str) -> Result<String> {
    json(&probe_angles::curve(&serde_json::from_str(probes).context("the angles of the probes")?)?)
}

/// Noise gain of an arrangement of probes over the band, even of a blind one; fast enough for every move of a slider.
#[wasm_bindgen]
pub fn probe_angles_curve(probes: &str) -> Result<String, Refusal> {
    to_js(angles(probes))
}

fn open(request: &str) -> Result<f64> {
    let request: probe_angles::Request = serde_json::from_str(request).context("what is searched for")?;
    let search = request.search()?;
    let steps = search.steps() as f64;
    SEARCH.set(Some(search));
    Ok(steps)
}

/// Prepares the search for the best pairs; returns its number of steps.
#[wasm_bindgen]
pub fn probe_angles_open(request: &str) -> Result<f64, Refusal> {
    to_js(open(request))
}

/// Runs that many steps of the search; returns the fraction done, 1 at the end.
#[wasm_bindgen]
pub fn probe_angles_advance(steps: u32) -> Result<f64, Refusal> {
    to_js(SEARCH.with_borrow_mut(|search| Ok(search.as_mut().context(NO_SEARCH)?.advance(steps as usize))))
}

const NO_SEARCH: &str = "no search has been prepared";

/// The best pairs and their table.
#[derive(Serialize)]
struct Found {
    best: Vec<probe_angles::Pair>,
    table: Table,
}

fn finish() -> Result<String> {
    let found = SEARCH.take().context(NO_SEARCH)?.finish()?;
    json(&Found { table: found.table(), best: found.best })
}

/// The best pairs as `trueaxis probe-angles` lists them.
#[wasm_bindgen]
pub fn probe_angles_finish() -> Result<String, Refusal> {
    to_js(finish())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    #[test]
    fn the_sample_is_evaluated_drawn_and_a_fault_in_it_named() {
        let sample: Value = serde_json::from_str(&sample().unwrap()).unwrap();
        let (text, request) = (sample["text"].as_str().unwrap(), sample["request"].to_string());
        let found: Value = serde_json::from_str(&evaluate("probes.csv", text, &request).unwrap()).unwrap();
        assert_eq!(found["shown"]["summary"][0], "8 revolutions of 1024 points");
        assert_eq!(found["warnings"], json!([]));
        let plot = |title: &str| {
            let plots = found["shown"]["plots"].as_array().unwrap();
            plots.iter().find(|plot| plot["title"].as_str().unwrap().starts_with(title)).unwrap().clone()
        };
        // The pin's lobes: 2 µm of the second harmonic, falling with k^1.5.
        let amplitudes = plot("Amplitude of every harmonic");
        for (i, k) in [(0, 2.0_f64), (1, 3.0), (8, 10.0)] {
            let amplitude = amplitudes["curves"][0]["values"][i].as_f64().unwrap();
            assert_eq!(amplitudes["at"][i], k);
            assert!((amplitude - 2.0 * (2.0 / k).powf(1.5)).abs() < 0.01, "{k}: {amplitude}");
        }
        let motion = plot("Error motion of the spindle");
        assert_eq!(motion["curves"].as_array().unwrap().len(), 6);
        assert_eq!(motion["curves"][0]["values"].as_array().unwrap().len(), 1024);
        assert!(orbit().unwrap().contains("<svg"));
        let svg = polar(true, false, false, false).unwrap();
        assert!(svg.contains("LSC") && !svg.contains("MZC") && svg.contains("Magnification"));

        let error = evaluate("probes.csv", &text.replacen("\n", "\nx", 1), &request).unwrap_err();
        assert!(error.to_string().starts_with("probes.csv:2: column h1_um: found \"x"), "{error}");
        assert!(polar(true, true, true, true).is_err());
        let error = evaluate("probes.csv", text, &json!({"probes": {"n": 100}}).to_string()).unwrap_err();
        assert_eq!(error.to_string(), "--n: found 100, needed a power of two from 64 to 4096");
    }

    #[test]
    fn a_trace_has_four_circles() {
        let text = "x_mm,y_mm\n3,0\n0,3\n-3,0\n0,-3.002\n2,2\n";
        let found: Value = serde_json::from_str(&trace("t.csv", text).unwrap()).unwrap();
        assert_eq!(found["shown"]["summary"][0], "5 points");
        let (table, mcc) = (&found["shown"]["tables"][0], 2);
        assert_eq!(table["header"][3], "radius, mm");
        assert!(table["rows"][mcc][3]["value"].as_f64().unwrap() > 3.0);
        assert!(polar(false, false, true, true).unwrap().contains("MIC"));
        assert!(orbit().is_err());
    }

    /// The arrangement published in CN1927535, and one that is blind to every second harmonic.
    #[test]
    fn noise_gain_of_good_and_blind_angles() {
        let of = |probes: Value| -> Value { serde_json::from_str(&angles(&probes.to_string()).unwrap()).unwrap() };
        let published = of(json!({"n": 1024, "phi2_deg": 90.0, "phi3_deg": 181.05}));
        assert!((published["worst"]["worst_noise_gain"].as_f64().unwrap() - 19.3).abs() < 0.05);
        assert_eq!(published["noise_gains"].as_array().unwrap().len(), 99);
        let blind = of(json!({"n": 360 / 45 * 16, "phi2_deg": 120.0, "phi3_deg": 120.0}));
        assert!(blind["worst"].is_null());
        assert!(blind["blind"].as_array().unwrap().contains(&json!(4)), "{}", blind["blind"]);
    }

    #[test]
    fn a_search_in_slices_finds_the_best_pair() {
        assert_eq!(open(&json!({"probes": {"n": 512}, "count": 2}).to_string()).unwrap(), 170.0);
        while SEARCH.with_borrow_mut(|search| search.as_mut().unwrap().advance(7)) < 1.0 {}
        let found = SEARCH.take().unwrap().finish().unwrap();
        // Expected values from a search over all pairs with the complex gain.
        assert_eq!((found.best[0].p, found.best[0].q), (Some(155), Some(172)));
        assert!(probe_angles::Request { probes: Default::default(), count: 0 }.search().is_err());
    }
}
