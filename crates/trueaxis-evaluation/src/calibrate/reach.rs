//! Checks of a plan against machine and probe: travel, axes, room for the tip.

use super::artefact::Kind;
use super::faces;
use super::plan::{Plan, Step};
use super::task::Task;
use anyhow::Result;
use trueaxis::machine::{AXES, Axis, AxisSettings};
use trueaxis_tables::Machine;
use trueaxis_tables::error::FileError;

fn at_line(task: &Task, line: u32, key: &str, found: String, needed: String) -> anyhow::Error {
    let column = (!key.is_empty()).then(|| key.to_owned());
    FileError { file: task.file.clone(), line: Some(line), column, found, needed }.into()
}

/// Checks that the tip fits between two faces of a gauge, and beside a block above its base.
pub(super) fn check_steps(task: &Task) -> Result<()> {
    for artefact in &task.artefacts {
        if let Kind::Block(of) = &artefact.kind
            && let Some(place) = artefact.places.iter().find(|place| faces::depths(of, place, &task.probe).is_none())
        {
            let found = format!("{} too low beside a tip of {} mm radius", artefact.name, task.probe.tip_radius_mm);
            let needed = format!(
                "a smaller tip or approach_mm, or the block on its longer side: two rows of touches above its base, which \
                 may be {} mm (half of approach_mm) off its place",
                faces::off_place(&task.probe)
            );
            return Err(at_line(task, place.line, "artefact.place.normal", found, needed));
        }
        let Kind::Gauge { steps_mm } = &artefact.kind else { continue };
        let room = 2.0 * task.probe.tip_radius_mm + task.probe.approach_mm;
        if let Some(step) = steps_mm.windows(2).map(|pair| pair[1] - pair[0]).find(|step| *step <= room) {
            let found = format!("faces {step} mm apart");
            let needed = format!("more than {room} mm: the tip and its approach between them");
            return Err(at_line(task, artefact.line, "artefact.steps_mm", found, needed));
        }
    }
    Ok(())
}

/// Found and needed, if a position is outside an axis' travel.
pub(super) fn beyond(own: &AxisSettings, q: f64) -> Option<(String, String)> {
    let [low, high] = own.travel;
    let (letter, unit) = (own.axis.letter(), if own.axis.is_rotary() { "°" } else { " mm" });
    let within = (low..=high).contains(&q);
    (!within).then(|| (format!("{letter} at {q:.3}{unit}"), format!("within its travel {low} to {high}{unit}")))
}

/// Checks that the machine can reach the touches.
pub(super) fn check_travel(task: &Task, machine: &Machine, plan: &Plan) -> Result<()> {
    for touch in &plan.touches {
        let artefact = &task.artefacts[touch.artefact];
        let place = artefact.places.get(touch.place);
        let (line, key) = place.map_or((artefact.line, "dial"), |place| (place.line, "artefact.place"));
        for own in &machine.settings.axes {
            let k = own.axis.index();
            if let Some((at, needed)) = [touch.start[k], touch.end[k]].into_iter().find_map(|q| beyond(own, q)) {
                return Err(at_line(task, line, key, format!("a {} with {at}", task.word()), needed));
            }
        }
        if let Some(k) = (3..AXES)
            .find(|k| touch.start[*k] != 0.0 && !machine.settings.axes.iter().any(|own| own.axis.index() == *k))
        {
            let found = format!("an angle of {}", Axis::ALL[k].letter());
            return Err(at_line(task, line, "artefact.place.rotary_deg", found, "axes that the machine has".into()));
        }
    }
    Ok(())
}

/// Checks that the moves between touches stay within the travels too: the probe needs room above an artefact.
pub(super) fn check_ways(task: &Task, machine: &Machine, plan: &Plan) -> Result<()> {
    let mut places = task.artefacts.iter().flat_map(|artefact| &artefact.places);
    let mut line = 0;
    for step in &plan.steps {
        let to = match step {
            Step::Pause(_) => {
                line = places.next().map_or(line, |place| place.line);
                continue;
            }
            Step::Rapid(to) => *to,
            Step::Feed([x, y, z]) => [Some(*x), Some(*y), Some(*z), None, None, None],
            Step::Remark(_) | Step::Probe(_) => continue,
        };
        for own in &machine.settings.axes {
            if let Some((at, needed)) = to[own.axis.index()].and_then(|q| beyond(own, q)) {
                let needed = format!("{needed}: room above the artefact, and beside it");
                return Err(at_line(task, line, "artefact.place", format!("a way between touches with {at}"), needed));
            }
        }
    }
    Ok(())
}
