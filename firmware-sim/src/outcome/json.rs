//! The outcome as JSON.

use super::Outcome;
use serde::Serialize;
use trueaxis_sim::Scenario;
use trueaxis_sim::run::RunDocument;

#[derive(Serialize)]
struct LatencyJson {
    min: u64,
    p50: u64,
    p99: u64,
    p99_99: u64,
    max: u64,
}

/// Duration of the steps, ns, and the number above the budget.
#[derive(Serialize)]
pub struct Cost {
    latency_ns: LatencyJson,
    budget_ns: u64,
    over_budget: u64,
    missed_deadlines: u64,
}

impl Outcome {
    /// The document that `--json` prints.
    pub fn json(&self, scenario: &Scenario) -> RunDocument<Cost> {
        let latency = self.latency.summary();
        let cost = Cost {
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
        };
        let mut document = RunDocument::of(scenario, self.cycles, &self.machines());
        document.notes.splice(0..0, self.notes_on_time());
        RunDocument { timing: Some(cost), wall_s: Some(self.wall_s), ..document }
    }
}
