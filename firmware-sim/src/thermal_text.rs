//! JSON of a warming.

use firmware_sim::report::thermal::lags;
use serde::Serialize;
use trueaxis_sim::warming::{Outcome, Warming};

#[derive(Serialize)]
struct Axis {
    axis: char,
    drift_um: f64,
    left_um: f64,
}

#[derive(Serialize)]
struct Lag<'o> {
    name: &'o str,
    lag_s: f64,
}

/// The document that `--json` prints.
#[derive(Serialize)]
pub(crate) struct Json<'o> {
    machine: &'o str,
    seed: u64,
    shifts: u32,
    rows: usize,
    lags: Vec<Lag<'o>>,
    left_out: Vec<&'o str>,
    held_out_shift: Vec<Axis>,
    judged_shift: Vec<Axis>,
    largest_drift_um: f64,
    largest_left_um: f64,
    left_share: f64,
    drift_rms_um: f64,
    left_rms_um: f64,
    largest_step_of_a_correction_um: f64,
    share_of_the_limits: f64,
    settled: bool,
    stopped: bool,
    #[serde(rename = "told")]
    reported: bool,
    failed: Option<&'static str>,
}

/// The JSON document.
pub(crate) fn json<'o>(warming: &'o Warming, outcome: &'o Outcome) -> Json<'o> {
    let held_out = outcome.recorded.iter().filter(|own| own.held_out).map(|own| Axis {
        axis: own.axis.letter(),
        drift_um: 1e3 * own.drift_mm,
        left_um: 1e3 * own.left_mm,
    });
    let judged = outcome.axes_mm.iter().zip(['X', 'Y', 'Z']);
    let judged = judged.map(|([drift, left], axis)| Axis { axis, drift_um: 1e3 * drift, left_um: 1e3 * left });
    Json {
        machine: &warming.machine.settings.name,
        seed: warming.seed,
        shifts: warming.shifts,
        rows: outcome.record.samples.len(),
        lags: lags(outcome).map(|(name, lag_s)| Lag { name, lag_s }).collect(),
        left_out: outcome.found.left_out.iter().map(|out| out.name.as_str()).collect(),
        held_out_shift: held_out.collect(),
        judged_shift: judged.collect(),
        largest_drift_um: 1e3 * outcome.largest_mm[0],
        largest_left_um: 1e3 * outcome.largest_mm[1],
        left_share: outcome.left_share(),
        drift_rms_um: 1e3 * outcome.rms_mm[0],
        left_rms_um: 1e3 * outcome.rms_mm[1],
        largest_step_of_a_correction_um: 1e3 * outcome.largest_step_mm,
        share_of_the_limits: outcome.of_limits,
        settled: !outcome.unsettled,
        stopped: outcome.stopped,
        reported: outcome.reported,
        failed: outcome.failed,
    }
}
