//! Checks that the trips of a log belong to the plan's touches.

use super::log::{Log, Logged};
use super::plan::{Plan, Planned};
use super::task::Task;
use anyhow::Result;
use std::path::Path;
use trueaxis::machine::AXES;
use trueaxis_tables::error::FileError;

/// Largest distance of a trip from the line of its probing move, mm: encoders follow a straight line.
const OFF_LINE: f64 = 0.1;
/// A trip within this distance of the start of its probing move is one at the start, mm; also the tolerance at its end.
const AT_START: f64 = 0.02;
/// Distinguishes a log in inches from a trip at another place.
const MM_PER_INCH: f64 = 25.4;
/// Largest deviation of a rotary axis from its pose, degrees.
const TURNED: f64 = 0.02;

/// The trip of every touch, in the order of the plan.
///
/// # Errors
/// With the line of the log: another task's log, a touch that is missing or not in the plan, a trip outside its probing move.
pub fn trips(task: &Task, plan: &Plan, log: &Log, file: &Path) -> Result<Vec<Logged>> {
    let error = |line: Option<u32>, found: String, needed: String| -> anyhow::Error {
        FileError { file: file.into(), line, column: None, found, needed }.into()
    };
    let count = plan.touches.len();
    if let Some((identity, line)) = log.identity.filter(|(identity, _)| *identity != plan.identity) {
        let found = format!("the log of program {identity:08x}");
        let needed = format!("that of {}, which {} plans", plan.number(), task.file.display());
        return Err(error(Some(line), found, needed));
    }
    if let Some((id, logged)) = log.touches.iter().find(|(id, _)| **id > count) {
        let found = format!("touch {id}");
        return Err(error(Some(logged.line), found, format!("touches 1 to {count}, as {} plans", task.file.display())));
    }
    let mut trips = Vec::with_capacity(count);
    let mut before = None;
    for (index, touch) in plan.touches.iter().enumerate() {
        let id = index + 1;
        let Some(logged) = log.touches.get(&id) else {
            let have = log.touches.len();
            let found = format!("no touch {id} ({have} of {count} touches)");
            return Err(error(before, found, format!("all {count} touches, touch {id} after this line")));
        };
        before = Some(logged.line);
        check(task, touch, id, logged).map_err(|(found, needed)| {
            let mut inches = *logged;
            inches.position[..3].iter_mut().for_each(|q| *q *= MM_PER_INCH);
            let (found, needed) = match check(task, touch, id, &inches) {
                Ok(()) => (
                    format!("touch {id} on its probing move only if its numbers are inches"),
                    "a log in mm (grblHAL: $13=0)".into(),
                ),
                Err(_) => (found, needed),
            };
            error(Some(logged.line), found, needed)
        })?;
        // The plan supplies angles that the log does not state.
        let mut trip = *logged;
        for k in 0..3 {
            if !logged.rotary[k] {
                trip.position[3 + k] = touch.start[3 + k];
            }
        }
        trips.push(trip);
    }
    Ok(trips)
}

fn check(task: &Task, touch: &Planned, id: usize, logged: &Logged) -> Result<(), (String, String)> {
    let name = &task.artefacts[touch.artefact].name;
    let whole = task.probe.approach_mm + task.probe.overtravel_mm;
    let from: [f64; 3] = std::array::from_fn(|k| logged.position[k] - touch.start[k]);
    let way: [f64; 3] = std::array::from_fn(|k| (touch.end[k] - touch.start[k]) / whole);
    let along: f64 = (0..3).map(|k| from[k] * way[k]).sum();
    let lateral = (0..3).map(|k| (from[k] - along * way[k]).powi(2)).sum::<f64>().sqrt();
    let at = |what: &str| format!("touch {id} on {name} tripped {what}");
    if lateral > OFF_LINE {
        let found = at(&format!("{lateral:.3} mm beside its probing move"));
        return Err((found, "a trip on that move: not at rapid, not of another program".into()));
    }
    if along < AT_START {
        let found = at(&format!("{along:.3} mm after the start of its probing move"));
        return Err((
            found,
            format!("a trip after {AT_START} to {whole} mm: not at rapid, not with the probe deflected"),
        ));
    }
    if along > whole + AT_START {
        let found = at(&format!("{along:.3} mm after the start of its probing move"));
        return Err((found, format!("a trip within {whole} mm")));
    }
    let turned = (3..AXES).find(|k| logged.rotary[k - 3] && (logged.position[*k] - touch.start[*k]).abs() > TURNED);
    if let Some(k) = turned {
        let letter = ['A', 'B', 'C'][k - 3];
        let found = at(&format!("with {letter} at {}", logged.position[k]));
        return Err((found, format!("{letter} at {}", touch.start[k])));
    }
    Ok(())
}
