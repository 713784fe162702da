//! The outcome as JSON.

use super::{Outcome, Reported};
use serde::Serialize;
use trueaxis_sim::run::{AngleSize, ErrorSize, Tallies};
use trueaxis_sim::{Scenario, Settings};

#[derive(Serialize)]
struct Size {
    max: f64,
    rms: f64,
}

#[derive(Serialize)]
struct ErrorJson {
    uncompensated: Size,
    compensated: Size,
    servo_only: Size,
    /// Machines with dynamic parts only.
    #[serde(skip_serializing_if = "Option::is_none")]
    full: Option<Size>,
}

/// Without the perfect machine: the step would report errors that its tables have and that machine does not.
#[derive(Serialize)]
struct EstimateJson {
    uncompensated: Size,
    compensated: Size,
    #[serde(skip_serializing_if = "Option::is_none")]
    full: Option<Size>,
}

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
    contour_error_um: ErrorJson,
    /// Programs with rotary axes only.
    #[serde(skip_serializing_if = "Option::is_none")]
    orientation_error_urad: Option<ErrorJson>,
    /// The same as the step itself reports them.
    #[serde(skip_serializing_if = "Option::is_none")]
    estimated_contour_error_um: Option<EstimateJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    estimated_orientation_error_urad: Option<EstimateJson>,
    latency_ns: LatencyJson,
    budget_ns: u64,
    over_budget: u64,
    missed_deadlines: u64,
    faults: Vec<Reported>,
    stopped: bool,
    limited_cycles: u64,
    simulated_s: f64,
    wall_s: f64,
    notes: Vec<String>,
}

impl Outcome {
    fn each(&self, size: impl Fn(&Tallies) -> Size) -> ErrorJson {
        ErrorJson {
            uncompensated: size(&self.uncompensated),
            compensated: size(&self.compensated),
            servo_only: size(&self.servo_only),
            full: self.full.as_ref().map(size),
        }
    }

    /// The outcome as one JSON document.
    pub fn json(&self, scenario: &Scenario) -> Json {
        let length = |size: &ErrorSize| Size { max: size.max_um, rms: size.rms_um };
        let angle = |size: &AngleSize| Size { max: size.max_urad, rms: size.rms_urad };
        let estimate = |size: &dyn Fn(&Tallies) -> Size| {
            let of_the_imperfect = || EstimateJson {
                uncompensated: size(&self.uncompensated),
                compensated: size(&self.compensated),
                full: self.full.as_ref().map(size),
            };
            scenario.five_axis.then(of_the_imperfect)
        };
        let latency = self.latency.summary();
        Json {
            machine: scenario.machine.settings.name.as_str().into(),
            program: scenario.program.name.clone(),
            settings: scenario.settings.clone(),
            cycles: self.cycles,
            servo_rate_hz: scenario.rate_hz(),
            contour_error_um: self.each(|run| length(&run.error)),
            orientation_error_urad: scenario.five_axis.then(|| self.each(|run| angle(&run.orientation))),
            estimated_contour_error_um: estimate(&|run| length(&run.estimated)),
            estimated_orientation_error_urad: estimate(&|run| angle(&run.estimated_orientation)),
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
            faults: self.faults(scenario).collect(),
            stopped: self.compensated.stopped,
            limited_cycles: self.compensated.limited_cycles,
            simulated_s: self.cycles as f64 * scenario.period_s(),
            wall_s: self.wall_s,
            notes: self.notes(),
        }
    }
}
