//! JSON and summary of a warming.

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

fn lags(outcome: &Outcome) -> Vec<Lag<'_>> {
    let model = &outcome.found.model;
    let sensors = model.sensors.iter().map(|sensor| Lag { name: &sensor.name, lag_s: sensor.lag_s });
    sensors.chain(model.spindle.iter().map(|spindle| Lag { name: "spindle", lag_s: spindle.lag_s })).collect()
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
        lags: lags(outcome),
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

/// The summary as plain text.
pub(crate) fn summary(warming: &Warming, outcome: &Outcome) -> String {
    let mut text = format!(
        "machine  {}\nrecord   {} shifts, {} rows, probe {} µm, seed {}\nlags     ",
        warming.machine.settings.name,
        warming.shifts,
        outcome.record.samples.len(),
        warming.noise_um,
        warming.seed
    );
    let lags: Vec<String> = lags(outcome).iter().map(|lag| format!("{} {:.0} s", lag.name, lag.lag_s)).collect();
    text += &lags.join(", ");
    let out: Vec<&str> = outcome.found.left_out.iter().map(|out| out.name.as_str()).collect();
    text += &format!("\nleft out {}\n\n", if out.is_empty() { "none".into() } else { out.join(", ") });
    text += "largest, µm                       drift     left\n";
    for own in outcome.recorded.iter().filter(|own| own.held_out) {
        let name = format!("E{0}{0}, held-out shift", own.axis.letter());
        text += &format!("  {name:<28} {:>8.2} {:>8.2}\n", 1e3 * own.drift_mm, 1e3 * own.left_mm);
    }
    for ([drift, left], axis) in outcome.axes_mm.iter().zip(['X', 'Y', 'Z']) {
        let name = format!("E{axis}{axis}, judged shift");
        text += &format!("  {name:<28} {:>8.2} {:>8.2}\n", 1e3 * drift, 1e3 * left);
    }
    let [drift, left] = outcome.rms_mm;
    text += &format!("  {:<28} {:>8.2} {:>8.2}\n", "RMS, judged shift", 1e3 * drift, 1e3 * left);
    text += &format!(
        "\nremaining of the largest drift, in a shift of another kind: {:.1} %\n\
         largest step of a correction in a cycle {:.3} µm, {:.0} % of the limiter's limits{}\n",
        1e2 * outcome.left_share(),
        1e3 * outcome.largest_step_mm,
        1e2 * outcome.of_limits,
        if outcome.unsettled { ", not always settled" } else { "" }
    );
    if let Some(failed) = outcome.failed {
        text += &format!(
            "{failed} failed half-way: {}\n",
            if outcome.reported { "reported, its share frozen" } else { "it has no share" }
        );
    }
    text
}
