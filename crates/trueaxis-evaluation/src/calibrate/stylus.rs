//! Styli of different lengths: each has its own tip and its own place of the reference.

use super::artefact::Artefact;
use super::kinematics::Ideal;
use super::place::Place;
use super::plan::{Plan, Planned};
use super::task::Task;
use anyhow::Result;
use trueaxis::machine::MachineSettings;
use trueaxis_tables::Machine;

/// A stylus of this length, from the spindle's nose (the origin of the last tool-side frame) to the centre of its tip, mm;
/// `None`: as the machine's `tool_mm` states.
pub(super) type Stylus = Option<f64>;

/// Tip of a stylus from the last tool-side frame, mm.
pub(crate) fn tool_mm(settings: &MachineSettings, stylus: Stylus) -> [f64; 3] {
    let axis = settings.kinematics.tool_axis;
    let size = axis.iter().map(|part| part * part).sum::<f64>().sqrt();
    // The tool axis points from the tip to the spindle.
    let unit = if size > 0.0 { axis.map(|part| part / size) } else { [0.0, 0.0, 1.0] };
    stylus.map_or(settings.tool_mm, |length| unit.map(|part| if part == 0.0 { 0.0 } else { -length * part }))
}

/// The machine with a stylus.
pub(super) fn with_stylus(machine: &Machine, stylus: Stylus) -> Machine {
    let mut machine = machine.clone();
    machine.settings.tool_mm = tool_mm(&machine.settings, stylus);
    machine
}

/// A place as the machine reaches it with another stylus.
pub(super) fn moved(settings: &MachineSettings, place: &Place, stylus: Stylus) -> Place {
    let [from, to] = [place.stylus_mm, stylus].map(|stylus| tool_mm(settings, stylus));
    // Positions of X, Y and Z are those of the tip but for the tool.
    let at_mm = std::array::from_fn(|k| place.at_mm[k] + from[k] - to[k]);
    Place { at_mm, stylus_mm: stylus, ..place.clone() }
}

impl Task {
    /// Lengths of all styli in the order of their first use; at least one.
    pub(super) fn stylus_lengths(&self) -> Vec<Stylus> {
        let mut all: Vec<Stylus> = Vec::new();
        for place in self.artefacts.iter().flat_map(|artefact| &artefact.places) {
            if !all.contains(&place.stylus_mm) {
                all.push(place.stylus_mm);
            }
        }
        if all.is_empty() {
            all.push(None);
        }
        all
    }

    /// Index among [`Task::stylus_lengths`] of the stylus in a set-up: that of the place that is set up.
    pub(super) fn stylus_of(&self, set_up: usize) -> usize {
        let all = self.stylus_lengths();
        let mut places = self.artefacts.iter().flat_map(|artefact: &Artefact| &artefact.places);
        let own = places.nth(set_up).map(|place| place.stylus_mm);
        own.and_then(|own| all.iter().position(|stylus| *stylus == own)).unwrap_or(0)
    }
}

impl Plan {
    /// Index of the stylus of a touch.
    pub(super) fn stylus_of(&self, task: &Task, touch: &Planned) -> usize {
        self.visits.get(touch.visit).map_or(0, |visit| if task.is_read() { 0 } else { task.stylus_of(visit.set_up) })
    }
}

/// Words for a stylus in the text of a set-up; empty for the machine's own tool.
pub(super) fn words(stylus: Stylus) -> String {
    stylus.map_or(String::new(), |length| format!(", with the stylus of {length} mm"))
}

/// The ideal geometry with each stylus.
pub(super) fn ideals(task: &Task, machine: &Machine) -> Result<Vec<Ideal>> {
    task.stylus_lengths().into_iter().map(|stylus| Ok(Ideal::new(&with_stylus(machine, stylus))?)).collect()
}
