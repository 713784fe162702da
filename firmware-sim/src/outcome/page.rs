//! The outcome as content of the report page.

use super::Outcome;
use crate::report::{ContourErrors, FaultEntry, Report};
use crate::series::Series;
use trueaxis_sim::Scenario;

impl Outcome {
    /// The contents of the HTML page; `series` has recorded the runs.
    pub fn report(&self, scenario: &Scenario, series: &Series) -> Report {
        let mut contour = series.contour();
        let mut length = 0.0;
        for step in &scenario.program.moves {
            contour.program_lines.push((length, step.line));
            length += step.length();
        }
        Report {
            orientation: series.orientation(),
            title: "Compensated servo step".into(),
            machine: scenario.machine.settings.name.as_str().into(),
            program: scenario.program.name.clone(),
            chain: scenario.machine.settings.chain.as_str().into(),
            servo_rate_hz: scenario.rate_hz(),
            cycles: self.cycles,
            contour_error: ContourErrors {
                uncompensated: self.uncompensated.error,
                compensated: self.compensated.error,
                servo_only: self.servo_only.error,
                full: self.full.as_ref().map(|full| full.error),
            },
            contour,
            path: series.path(),
            circle: series.circle(),
            reversals: series.reversals(),
            axes: series.axes(),
            latency: self.latency.summary(),
            latency_buckets: self.latency.buckets().collect(),
            faults: self
                .faults(scenario)
                .map(|f| FaultEntry {
                    time_s: f.time_s,
                    code: f.code.to_string(),
                    description: format!("{} on axis {}, program line {}", f.fault, f.axis, f.line),
                    cycles: f.cycles,
                })
                .collect(),
            notes: setting_notes(scenario).chain(self.notes(scenario)).collect(),
        }
    }
}

/// Settings that differ from the default.
fn setting_notes(scenario: &Scenario) -> impl Iterator<Item = String> {
    let changes = scenario.settings.changes().into_iter();
    changes.map(|(key, value, default)| format!("setting {key} = {value} (default {default})"))
}
