//! A run as one document.

use super::figures::Figures;
use super::kind::{Kind, feedback_refused};
use super::tally::{MOST_FAULT_SPANS, Tallies};
use crate::program::Note;
use crate::scenario::Scenario;
use crate::settings::Settings;
use serde::Serialize;
use trueaxis_tables::Warning;
use trueaxis_tables::text::counted;

/// Figures of a completed run, with its inputs. `T`: timing added by a host that measures it.
#[derive(Clone, Debug, Serialize)]
pub struct RunDocument<T> {
    /// Name of the machine.
    pub machine: String,
    /// Name of the program.
    pub program: String,
    /// All settings.
    pub settings: Settings,
    /// Cycles of the program.
    pub cycles: u64,
    /// Servo rate, Hz.
    pub servo_rate_hz: f64,
    /// Figures of the machines side by side.
    #[serde(flatten)]
    pub figures: Figures,
    /// Cost of the steps.
    #[serde(flatten)]
    pub timing: Option<T>,
    /// Time of the program, s.
    pub simulated_s: f64,
    /// Time that the host needed, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall_s: Option<f64>,
    /// Remarks on the run.
    pub notes: Vec<String>,
    /// Words of the program without effect.
    pub noted: Vec<Note>,
}

impl<T> RunDocument<T> {
    /// Builds the document of a run of `cycles` of a scenario on these machines, without timing.
    pub fn of(scenario: &Scenario, cycles: u64, machines: &[(Kind, Tallies)]) -> RunDocument<T> {
        RunDocument {
            machine: scenario.machine.settings.name.as_str().into(),
            program: scenario.program.name.clone(),
            settings: scenario.settings.clone(),
            cycles,
            servo_rate_hz: scenario.rate_hz(),
            figures: Figures::of(scenario, machines),
            timing: None,
            simulated_s: cycles as f64 * scenario.period_s(),
            wall_s: None,
            notes: notes(scenario, cycles, machines),
            noted: scenario.program.notes.clone(),
        }
    }
}

/// If the limits restrict a correction in more than this share of the cycles, they are too low for the program: corners and
/// reversals alone come to a quarter of it.
const HELD_BACK: f64 = 0.01;

/// Remarks on the corrected run and the one with everything on, of `cycles`, as far as they are among the machines.
pub fn notes(scenario: &Scenario, cycles: u64, machines: &[(Kind, Tallies)]) -> Vec<String> {
    let of = |kind| machines.iter().find(|(own, _)| *own == kind).map(|(_, tallies)| tallies);
    let (compensated, full) = (of(Kind::Compensated), of(Kind::Full));
    let mut notes = Vec::new();
    if !scenario.machine.states_errors() {
        notes.push(Warning::NoErrorsStated.to_string());
    }
    if compensated.is_some_and(|compensated| compensated.stopped) {
        notes.push("a stop request ended the corrected run".into());
    }
    let clipped = compensated.map(|compensated| compensated.clipped.notes(&scenario.machine.settings, "cycle"));
    let before = notes.len();
    notes.extend(clipped.into_iter().flatten());
    let held_back = compensated.map_or(0, |compensated| compensated.limited_cycles);
    if notes.len() == before && held_back as f64 > HELD_BACK * cycles as f64 {
        notes.push(format!(
            "limits held the correction back in {held_back} of {}: slope_mm_per_s or acceleration_mm_per_s2 of an axis is too \
             low for this program (trueaxis tables check names it)",
            counted(cycles as usize, "cycle")
        ));
    }
    let refused = full.and_then(|_| feedback_refused(&scenario.machine.settings, scenario.period_s()));
    notes.extend(refused.map(|why| format!("everything on: the run has no contour feedback: {why}")));
    let withdrawn = full.into_iter().flat_map(|full| &full.withdrawn);
    notes.extend(withdrawn.map(|withdrawn| withdrawn.note(scenario.period_s())));
    notes.extend(full.zip(compensated).and_then(|(full, compensated)| note_of_full(full, compensated)));
    if let Some(more) = compensated.map(|compensated| compensated.more_faults).filter(|more| *more > 0) {
        notes.push(format!(
            "faults: the first {MOST_FAULT_SPANS} are listed; faults follow in {}",
            counted(more as usize, "cycle")
        ));
    }
    notes
}

/// A note if the run with everything on was stopped and the corrected one was not, or if their faults differ.
fn note_of_full(full: &Tallies, compensated: &Tallies) -> Option<String> {
    if full.stopped && !compensated.stopped {
        return Some("a stop request ended the run with everything on".into());
    }
    let (in_full, in_compensated) = (full.fault_cycles(), compensated.fault_cycles());
    (in_full != in_compensated).then(|| {
        let counted = |cycles| counted(cycles as usize, "cycle");
        format!(
            "faults in {} with everything on, in {} of the corrected run",
            counted(in_full),
            counted(in_compensated)
        )
    })
}
