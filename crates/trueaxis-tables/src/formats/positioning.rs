//! An axis' own positioning error, as one-dimensional formats need it.
//!
//! Sign for an axis that carries the workpiece: its carriage moves by −q with the error −e, so the tool moves relative to the
//! workpiece by q + e, as on the tool side. For linear axes E is therefore the table's own error on either side. For rotary
//! axes see [`to_position_unit`].

use crate::{Machine, Table};
use trueaxis::machine::{Axis, AxisSettings};

/// Positioning error at one position, in the unit and sense of the axis' own positions (mm, degrees): actual − commanded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub(super) position: f64,
    pub(super) forward: f64,
    /// Backlash included.
    pub(super) reverse: f64,
}

/// Factor from a table's own error (mm or rad, tool relative to workpiece) to the axis' positions (mm or degrees).
///
/// A rotary axis on the tool side turns by direction · q, so an error w moves it by direction · w; on the workpiece side the
/// carriage turns by direction · q with the error −w. With the default directions (+1, and −1 if primed) both give +w.
pub(super) fn to_position_unit(machine: &Machine, settings: &AxisSettings) -> f64 {
    if !settings.axis.is_rotary() {
        return 1.0;
    }
    let workpiece_side = machine.settings.chain.split('b').next().unwrap_or_default();
    let sense = f64::from(settings.direction);
    let sense = if workpiece_side.contains(settings.axis.letter()) { -sense } else { sense };
    sense * (180.0 / std::f64::consts::PI)
}

/// The axis' own error at every point of its table.
pub(super) fn points(machine: &Machine, settings: &AxisSettings, table: &Table) -> Vec<Point> {
    let factor = to_position_unit(machine, settings);
    let own = |twist: &[f64; 6]| twist.get(settings.axis.index()).copied().unwrap_or(0.0) * factor;
    table
        .rows
        .iter()
        .map(|row| Point {
            position: row.position,
            forward: own(&row.forward),
            reverse: own(&row.reverse) + settings.backlash,
        })
        .collect()
}

/// The axes to write, with their tables.
pub(super) fn chosen(machine: &Machine, only: Option<Axis>) -> impl Iterator<Item = (&AxisSettings, &Table)> {
    machine
        .axes()
        .filter(move |(settings, _)| only.is_none_or(|axis| axis == settings.axis))
        .filter_map(|(settings, table)| table.map(|table| (settings, table)))
}

/// Name of an error, like `EYX`.
pub(super) fn error_name(axis: Axis, component: usize) -> String {
    let direction = Axis::ALL.get(component).map_or('?', |direction| direction.letter());
    format!("E{direction}{}", axis.letter())
}

/// The mean of both directions, for formats without direction; lists the largest difference as dropped.
pub(super) fn mean_of_directions(
    settings: &AxisSettings,
    points: &[Point],
    dropped: &mut Vec<String>,
) -> Vec<(f64, f64)> {
    let widest = points.iter().map(|point| (point.reverse - point.forward).abs()).fold(0.0, f64::max);
    if widest > 0.0 {
        let (value, unit) = if settings.axis.is_rotary() { (widest, "degrees") } else { (widest * 1e3, "um") };
        dropped.push(format!(
            "difference between the directions of axis {} (up to {value:.4} {unit}; the mean of both is written)",
            settings.axis.letter()
        ));
    }
    points.iter().map(|point| (point.position, 0.5 * (point.forward + point.reverse))).collect()
}
