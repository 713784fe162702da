//! Checks of a plan against machine and probe: travel, axes, room for the tip.

use super::artefact::{Artefact, Kind};
use super::faces;
use super::grid::Grid;
use super::place::Place;
use super::plan::{Plan, Step};
use super::target::Target;
use super::task::Task;
use anyhow::Result;
use trueaxis::machine::{AXES, Axis, AxisSettings};
use trueaxis_tables::Machine;
use trueaxis_tables::error::FileError;

/// Largest distance from a ball's middle at which it is touched, over the radii of ball and tip.
const MOST_BESIDE: f64 = 0.25;

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
        if let Kind::Grid(grid) = &artefact.kind {
            check_room(task, artefact, grid)?;
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

/// Checks that the tip has room before its touches in a hole, or between neighbouring balls, with the plate off its place, and
/// that it meets the ball or the hole there.
fn check_room(task: &Task, artefact: &Artefact, grid: &Grid) -> Result<()> {
    let probe = &task.probe;
    let (radius, off) = (0.5 * grid.diameter_mm, faces::off_place(probe));
    let where_ = format!("with the plate up to {off} mm (half of approach_mm) off its place");
    if probe.overtravel_mm < off {
        let needed = format!("at least {off} mm: it touches {where_}");
        return Err(at_line(task, artefact.line, "probe.overtravel_mm", format!("{} mm", probe.overtravel_mm), needed));
    }
    let most = MOST_BESIDE * (radius + probe.tip_radius_mm);
    if !grid.holes && off > most {
        let found = format!("a ball touched up to {off} mm (half of approach_mm) beside its middle");
        let needed = format!("at most {most} mm, a quarter of the radii of ball and tip: a smaller approach_mm");
        return Err(at_line(task, artefact.line, "plate.diameter_mm", found, needed));
    }
    let (room, word) = if grid.holes {
        // The tip arrives at the start of a touch from one side, by the way that takes up lost motion.
        let reach = radius - probe.tip_radius_mm;
        (reach - (reach - probe.approach_mm).abs().hypot(probe.take_up_mm) - off, "in a hole")
    } else {
        (grid.pitch_mm - 2.0 * (radius + probe.tip_radius_mm) - probe.approach_mm - off, "between two balls")
    };
    if room >= 0.0 {
        return Ok(());
    }
    let found = format!("{:.1} mm too little room {word} for a tip of {} mm radius", -room, probe.tip_radius_mm);
    let needed = format!("room for approach_mm ({}) and take_up_mm ({}) {where_}", probe.approach_mm, probe.take_up_mm);
    Err(at_line(task, artefact.line, "plate.diameter_mm", found, needed))
}

/// Checks that the probe travels between places no lower than it enters and leaves them.
pub(super) fn check_safe_z(task: &Task, place: &Place, key: &str, safe_z: f64, targets: &[Target]) -> Result<()> {
    let highest = targets.iter().map(|target| target.entry[2]).fold(f64::NEG_INFINITY, f64::max);
    if safe_z >= highest {
        return Ok(());
    }
    let found = format!("a way into and out of it at Z {highest:.3}, above safe_z_mm ({safe_z})");
    Err(at_line(task, place.line, key, found, format!("safe_z_mm of at least {highest:.3}, or a lower place")))
}

/// Found and needed, if a position is outside an axis' travel.
pub(super) fn beyond(own: &AxisSettings, q: f64) -> Option<(String, String)> {
    let [low, high] = own.travel;
    let (letter, unit) = (own.axis.letter(), if own.axis.is_rotary() { "°" } else { " mm" });
    let within = (low..=high).contains(&q);
    (!within).then(|| (format!("{letter} at {q:.3}{unit}"), format!("within its travel {low} to {high}{unit}")))
}

/// Key of an artefact's places in a task.
pub(super) fn key_of(artefact: &Artefact) -> &'static str {
    if artefact.grid().is_some() { "plate.placement" } else { "artefact.place" }
}

/// Checks that the machine can reach the touches.
pub(super) fn check_travel(task: &Task, machine: &Machine, plan: &Plan) -> Result<()> {
    for touch in &plan.touches {
        let artefact = &task.artefacts[touch.artefact];
        let place = artefact.places.get(touch.place);
        let (line, key) = place.map_or((artefact.line, "dial"), |place| (place.line, key_of(artefact)));
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
    let mut places =
        task.artefacts.iter().flat_map(|artefact| artefact.places.iter().map(|place| (place.line, key_of(artefact))));
    let (mut line, mut key) = (0, "artefact.place");
    for step in &plan.steps {
        let to = match step {
            Step::Pause(_) => {
                (line, key) = places.next().unwrap_or((line, key));
                continue;
            }
            Step::Rapid(to) => *to,
            Step::Feed([x, y, z]) => [Some(*x), Some(*y), Some(*z), None, None, None],
            Step::Remark(_) | Step::Probe(_) => continue,
        };
        for own in &machine.settings.axes {
            if let Some((at, needed)) = to[own.axis.index()].and_then(|q| beyond(own, q)) {
                let needed = format!("{needed}: room above the artefact, and beside it");
                return Err(at_line(task, line, key, format!("a way between touches with {at}"), needed));
            }
        }
    }
    Ok(())
}
