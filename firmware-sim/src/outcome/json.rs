//! The outcome as JSON.

use super::Outcome;
use serde::Serialize;
use trueaxis_sim::run::Figures;
use trueaxis_sim::{Scenario, Settings};

#[derive(Serialize)]
struct LatencyJson {
    min: u64,
    p50: u64,
    p99: u64,
    p99_99: u64,
    max: u64,
}

/// The document that `--json` prints.
#[derive(Serialize)]
pub struct Json {
    machine: String,
    program: String,
    settings: Settings,
    cycles: u64,
    servo_rate_hz: f64,
    #[serde(flatten)]
    figures: Figures,
    latency_ns: LatencyJson,
    budget_ns: u64,
    over_budget: u64,
    missed_deadlines: u64,
    simulated_s: f64,
    wall_s: f64,
    notes: Vec<String>,
}

impl Outcome {
    /// The outcome as one JSON document.
    pub fn json(&self, scenario: &Scenario) -> Json {
        let latency = self.latency.summary();
        Json {
            machine: scenario.machine.settings.name.as_str().into(),
            program: scenario.program.name.clone(),
            settings: scenario.settings.clone(),
            cycles: self.cycles,
            servo_rate_hz: scenario.rate_hz(),
            figures: self.figures(scenario),
            latency_ns: LatencyJson {
                min: latency.min_ns,
                p50: latency.p50_ns,
                p99: latency.p99_ns,
                p99_99: latency.p99_99_ns,
                max: latency.max_ns,
            },
            budget_ns: latency.budget_ns,
            over_budget: latency.over_budget,
            missed_deadlines: latency.missed_deadlines,
            simulated_s: self.cycles as f64 * scenario.period_s(),
            wall_s: self.wall_s,
            notes: self.notes(),
        }
    }
}
