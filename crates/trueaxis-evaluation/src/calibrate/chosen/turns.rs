//! Poses of the rotary axes at which a ball on the table is touched, and for which the machine is to be known.

use crate::calibrate::task::Task;
use trueaxis::machine::Axis;
use trueaxis_tables::Machine;

/// Angles of C, degrees; one outside the travel is taken a turn further.
const QUARTERS: [f64; 3] = [90.0, 180.0, 270.0];
/// Least tilt that is worth a pose, degrees.
const LEAST: f64 = 5.0;

/// Rotary axes that turn in a task with a ball to be placed.
pub(super) fn turning(task: &Task, machine: &Machine) -> Vec<Axis> {
    let is_open = task.artefacts.iter().any(|of| of.is_ball() && of.places.is_empty());
    let has = |axis: &Axis| !angles(task, machine, *axis).is_empty();
    let axes = [Axis::A, Axis::B, Axis::C].into_iter().filter(has);
    axes.filter(|_| is_open && task.wanted.rotary).collect()
}

/// Angles of an axis beside zero.
fn angles(task: &Task, machine: &Machine, axis: Axis) -> Vec<f64> {
    let Some([low, high]) = machine.settings.axis(axis).map(|own| own.travel) else { return Vec::new() };
    if axis == Axis::C {
        let within = |deg: f64| [deg, deg - 360.0].into_iter().find(|deg| (low..=high).contains(deg));
        return QUARTERS.into_iter().filter_map(within).collect();
    }
    let [from, to] = task.wishes.tilts_deg;
    [from.max(low), to.min(high)].into_iter().filter(|deg: &f64| deg.abs() >= LEAST).collect()
}

/// All combinations of the angles of these axes, zero first.
pub(super) fn poses(task: &Task, machine: &Machine, axes: &[Axis]) -> Vec<[f64; 3]> {
    let mut all = vec![[0.0; 3]];
    for axis in axes {
        let own = angles(task, machine, *axis);
        let turned = |pose: &[f64; 3], deg: f64| {
            let mut pose = *pose;
            pose[axis.index() % 3] = deg;
            pose
        };
        let more: Vec<[f64; 3]> = own.iter().flat_map(|deg| all.iter().map(move |pose| turned(pose, *deg))).collect();
        all.extend(more);
    }
    all
}

/// Lists of poses for a ball in one place: each axis turned alone, and all together. Without rotary axes, the zero pose alone.
pub(super) fn patterns(task: &Task, machine: &Machine) -> Vec<Vec<[f64; 3]>> {
    let axes = turning(task, machine);
    let mut all: Vec<Vec<[f64; 3]>> = axes.iter().map(|axis| poses(task, machine, &[*axis])).collect();
    if axes.len() != 1 {
        all.push(poses(task, machine, &axes));
    }
    all
}
