//! Volume for which the tables must be valid.

use super::{CollapseError, CollapseOptions, FREE_NODES, LINEAR, wrong};
use crate::Machine;
use trueaxis::machine::{AXES, Axis, AxisSettings, PeriodicSettings};

/// The working volume and the pose of the rotary axes, checked against the machine.
#[derive(Clone, Debug)]
pub(super) struct Volume {
    /// Indices of X, Y, Z among the machine's axes.
    pub(super) slots: [Option<usize>; 3],
    /// Ends, mm; both zero for an axis that the machine lacks.
    pub(super) ends: [[f64; 2]; 3],
    /// Nodes of the tables, ends included; one node at zero for an axis that the machine lacks.
    pub(super) nodes: [Vec<f64>; 3],
    pub(super) reference: [f64; 3],
    /// Whether the axis' table distinguishes directions.
    pub(super) two_sided_table: [bool; 3],
    /// Whether the axis' error depends on the direction, through its table or backlash.
    pub(super) two_sided: [bool; 3],
    /// Positions of all axes, the rotary ones at the pose.
    pose: [f64; AXES],
}

impl Volume {
    pub(super) fn new(machine: &Machine, options: &CollapseOptions) -> Result<Volume, CollapseError> {
        let axes = &machine.settings.axes;
        let mut volume = Volume {
            slots: LINEAR.map(|axis| axes.iter().position(|own| own.axis == axis)),
            ends: [[0.0; 2]; 3],
            nodes: [vec![0.0], vec![0.0], vec![0.0]],
            reference: [0.0; 3],
            two_sided_table: [false; 3],
            two_sided: [false; 3],
            pose: pose(machine, options)?,
        };
        if volume.slots.iter().all(Option::is_none) {
            return Err(wrong("machine", None, "no linear axis", "at least one of X, Y, Z"));
        }
        for (i, axis) in LINEAR.into_iter().enumerate() {
            let wanted = options.volume_mm[i];
            let Some(slot) = volume.slots[i] else {
                if let Some([low, high]) = wanted {
                    let found = format!("{low}:{high}");
                    return Err(wrong("volume", Some(axis), found, "no range: the machine has no such axis"));
                }
                continue;
            };
            let own = &axes[slot];
            let table = machine.tables[slot].as_ref();
            let positions: Vec<f64> = table.iter().flat_map(|t| &t.rows).map(|row| row.position).collect();
            let [low, high] = ends(own, &positions, wanted)?;
            volume.ends[i] = [low, high];
            volume.nodes[i] = nodes([low, high], &positions);
            volume.two_sided_table[i] = table.is_some_and(|t| t.rows.iter().any(|row| row.forward != row.reverse));
            let periods = || machine.settings.periods_of(axis).any(PeriodicSettings::is_two_sided);
            volume.two_sided[i] = volume.two_sided_table[i] || own.backlash != 0.0 || periods();
            let reference = options.reference_mm.map_or(0.5 * (low + high), |mm| mm[i]);
            if !(low..=high).contains(&reference) {
                let needed = format!("a position in the volume, {low} to {high} mm");
                return Err(wrong("reference", Some(axis), reference, needed));
            }
            volume.reference[i] = reference;
        }
        Ok(volume)
    }

    /// Positions of all axes for a point of the volume.
    pub(super) fn position(&self, point: [f64; 3]) -> [f64; AXES] {
        self.filled(self.pose, point)
    }

    /// Directions of all axes (1: negative travel).
    pub(super) fn direction(&self, reverse: [f64; 3]) -> [f64; AXES] {
        self.filled([0.0; AXES], reverse)
    }

    fn filled(&self, mut all: [f64; AXES], linear: [f64; 3]) -> [f64; AXES] {
        for (slot, value) in self.slots.iter().zip(linear) {
            if let Some(to) = slot.and_then(|slot| all.get_mut(slot)) {
                *to = value;
            }
        }
        all
    }
}

/// Whether the travel is declared, that is, differs from the default.
fn declared(own: &AxisSettings) -> bool {
    own.travel != AxisSettings::with_defaults(own.axis, false).travel
}

fn ends(own: &AxisSettings, positions: &[f64], wanted: Option<[f64; 2]>) -> Result<[f64; 2], CollapseError> {
    let axis = Some(own.axis);
    let Some([low, high]) = wanted else {
        return match positions {
            _ if declared(own) => Ok(own.travel),
            [first, .., last] => Ok([*first, *last]),
            _ => {
                let needed = "a declared travel, a table, or a volume";
                Err(wrong("volume", axis, "neither travel nor table", needed))
            }
        };
    };
    let found = format!("{low}:{high}");
    if !(low.is_finite() && high.is_finite()) {
        return Err(wrong("volume", axis, found, "finite numbers, mm"));
    }
    // The nodes have to be distinguishable.
    if high - low < 1e-3 {
        return Err(wrong("volume", axis, found, "the lower end first and at least 0.001 mm between the two"));
    }
    let [from, to] = own.travel;
    if low < from || high > to {
        return Err(wrong("volume", axis, found, format!("a range within the travel, {from} to {to} mm")));
    }
    Ok([low, high])
}

fn nodes([low, high]: [f64; 2], positions: &[f64]) -> Vec<f64> {
    if positions.is_empty() {
        let step = (high - low) / (FREE_NODES - 1) as f64;
        return (0..FREE_NODES).map(|k| if k + 1 == FREE_NODES { high } else { low + step * k as f64 }).collect();
    }
    // A line next to an end would make a tiny cell, whose slope is rounding noise.
    let inside = positions.iter().copied().filter(|q| *q > low + 1e-6 && *q < high - 1e-6);
    std::iter::once(low).chain(inside).chain(std::iter::once(high)).collect()
}

fn pose(machine: &Machine, options: &CollapseOptions) -> Result<[f64; AXES], CollapseError> {
    let mut pose = [0.0; AXES];
    for (k, (axis, angle)) in options.pose_deg.iter().enumerate() {
        let known = machine.settings.axes.iter().any(|own| own.axis == *axis);
        if !axis.is_rotary() || !known {
            return Err(wrong("pose", Some(*axis), angle, "rotary axes of the machine"));
        }
        if options.pose_deg.iter().take(k).any(|(before, _)| before == axis) {
            return Err(wrong("pose", Some(*axis), angle, "every axis once"));
        }
    }
    for (to, own) in pose.iter_mut().zip(&machine.settings.axes).filter(|(_, own)| own.axis.is_rotary()) {
        let named = options.pose_deg.iter().find(|(axis, _)| *axis == own.axis);
        let angle = named.map_or(0.0, |(_, angle)| *angle);
        let [from, until] = own.travel;
        if !angle.is_finite() || angle < from || angle > until {
            let needed = format!("an angle within the travel, {from} to {until} degrees");
            return Err(wrong("pose", Some(own.axis), angle, needed));
        }
        if angle != 0.0 && carries_linear(&machine.settings.chain, own.axis) {
            return Err(wrong(
                "pose",
                Some(own.axis),
                angle,
                "0: the axis carries a linear one and turns its nine terms",
            ));
        }
        *to = angle;
    }
    Ok(pose)
}

/// Whether a linear axis is further from the bed on the same side.
fn carries_linear(chain: &str, axis: Axis) -> bool {
    let (workpiece, tool) = chain.split_once('b').unwrap_or((chain, ""));
    let beyond = match (workpiece.split_once(axis.letter()), tool.split_once(axis.letter())) {
        (Some((beyond, _)), _) | (_, Some((_, beyond))) => beyond,
        _ => "",
    };
    beyond.chars().any(|letter| matches!(letter, 'X' | 'Y' | 'Z'))
}
