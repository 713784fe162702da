//! The rest of a machine, and the machine with the errors.

use super::model::PlanePoint;
use super::{LINEAR, Lie, PlaneErrors};
use crate::points::Points;
use crate::points::found::{place, range, rounded, rounded_urad, with_tool};
use crate::response::own_tip_errors;
use anyhow::{Result, anyhow, bail};
use trueaxis::machine::{LocationErrors, Row, Twist};
use trueaxis_metrology::volumetric::hats;
use trueaxis_tables::limits::raise;
use trueaxis_tables::{Grid, GridSource, Machine, Table};

/// Distance beyond the travel that counts as rounding, mm.
const REACH_MM: f64 = 1e-3;

/// The squareness between two axes, and its sign: dx = −C0Y·y + B0Z·z, dy = −A0Z·z.
pub(super) const fn squareness(axes: [usize; 2]) -> (&'static str, f64) {
    match axes {
        [0, 1] => ("C0Y", -1.0),
        [0, _] => ("B0Z", 1.0),
        _ => ("A0Z", -1.0),
    }
}

fn set_squareness(location: &mut LocationErrors, axes: [usize; 2], value: f64) {
    match axes {
        [0, 1] => location.c0y = value,
        [0, _] => location.b0z = value,
        _ => location.a0z = value,
    }
}

/// The machine without what the points show and without play. In a plane: translations in it of the two axes' tables, the squareness
/// between them, grids of these translations over these axes. On a line: these translations of its axis. An inclined plane shows
/// what is beyond all that the machine states.
fn rest(machine: &Machine, lie: Lie) -> Machine {
    let axes = lie.axes();
    let mut rest = machine.clone();
    rest.settings.compensation.orientation = false;
    if let Lie::Plane(_) = lie {
        set_squareness(&mut rest.settings.location, axes, 0.0);
        rest.grids.retain(|grid| !replaces(grid, axes));
    }
    for (own, table) in rest.settings.axes.iter_mut().zip(&mut rest.tables) {
        own.backlash = 0.0;
        let shown = !matches!(lie, Lie::Inclined(..)) && lie.free().iter().any(|axis| LINEAR[*axis] == own.axis);
        let Some(table) = table.as_mut().filter(|_| shown) else { continue };
        for axis in axes {
            table.given[axis] = false;
            table.rows.iter_mut().for_each(|row| (row.forward[axis], row.reverse[axis]) = (0.0, 0.0));
        }
    }
    rest
}

/// Whether a grid covers exactly these axes and states only translations along them.
fn replaces(grid: &Grid, axes: [usize; 2]) -> bool {
    let source = grid.source();
    (0..3).all(|axis| source.nodes[axis].is_empty() != axes.contains(&axis))
        && (0..6).all(|component| !source.given[component] || axes.contains(&component))
}

/// Refuses points that the machine cannot reach: another machine's, or in other units.
fn within_travel(points: &Points, machine: &Machine) -> Result<()> {
    for point in &points.points {
        for (axis, command) in LINEAR.into_iter().zip(point.command_mm) {
            let Some([low, high]) = machine.settings.axis(axis).map(|own| own.travel) else { continue };
            if !(low - REACH_MM..=high + REACH_MM).contains(&command) {
                bail!(
                    "line {}: column {}_mm: found {command}, beyond the travel of {}, needed {low} to {high} mm",
                    point.line,
                    axis.letter().to_ascii_lowercase(),
                    machine.settings.name
                );
            }
        }
    }
    Ok(())
}

/// Deviations in the plane without the tip errors of the rest of the machine.
pub(super) fn without_rest(points: &Points, machine: Option<&Machine>, lie: Lie) -> Result<Vec<PlanePoint>> {
    let mut errors = vec![[0.0; 3]; points.points.len()];
    if let Some(machine) = machine {
        for axis in lie.free().iter().map(|axis| LINEAR[*axis]) {
            if machine.settings.axis(axis).is_none() {
                bail!("{}: found no axis {}, along which the points vary", machine.settings.name, axis.letter());
            }
        }
        within_travel(points, machine)?;
        let rest = with_tool(&rest(machine, lie), points.tools_mm.first().copied().flatten());
        let places: Vec<_> = points.points.iter().map(|point| place(point.command_mm)).collect();
        (errors, _) = own_tip_errors(&rest, &places)?;
    }
    Ok(lie.readings(points, &errors))
}

/// The machine, whose own errors of the same kind are replaced by these, and remarks.
pub(super) fn filled(
    machine: &Machine,
    lie: Lie,
    errors: &PlaneErrors,
    points: &Points,
) -> Result<(Machine, Vec<String>)> {
    let axes = lie.axes();
    let in_plane = matches!(lie, Lie::Plane(_));
    let mut filled = machine.clone();
    let before = filled.grids.len();
    filled.grids.retain(|grid| !in_plane || !replaces(grid, axes));
    let mut changes = Vec::new();
    if filled.grids.len() < before {
        changes.push("the machine's grid of these errors is replaced".into());
    }
    let (name, sign) = squareness(axes);
    let shear = if let PlaneErrors::Tables(tables) = errors { tables.shear[0] } else { 0.0 };
    if in_plane {
        set_squareness(&mut filled.settings.location, axes, rounded_urad(sign * shear));
    }
    for (k, axis) in lie.free().iter().copied().enumerate() {
        let Some(slot) = filled.settings.axes.iter().position(|own| own.axis == LINEAR[axis]) else { continue };
        let table = filled.tables[slot].take();
        filled.tables[slot] = match errors {
            PlaneErrors::Tables(of) => Some(merged(table.as_ref(), axes, &of.nodes_mm[k], &of.errors[k])),
            _ => {
                table.filter(|table| keeps(table, axes)).map(|table| merged(Some(&table), axes, &[], &[vec![], vec![]]))
            }
        };
    }
    if let PlaneErrors::Grid(of) = errors {
        let z = LINEAR.iter().position(|axis| !axes.contains(&axis.index())).unwrap_or_default();
        let mut source = GridSource { ..GridSource::default() };
        let [low, high] = range(points.points.iter().map(|point| point.command_mm[z]));
        source.measured_at_mm[z] = 0.5 * (low + high);
        for (k, axis) in axes.into_iter().enumerate() {
            source.nodes[axis].clone_from(&of.nodes_mm[k]);
            source.given[axis] = true;
        }
        let twist = |value: &[f64; 2]| {
            let mut twist = [0.0; 6];
            axes.iter().zip(value).for_each(|(axis, mm)| twist[*axis] = rounded(*mm, 1e3));
            twist
        };
        source.values = of.values.iter().map(twist).collect();
        filled.grids.push(Grid::new(source).map_err(|_| anyhow!("found errors that no grid can store"))?);
        changes
            .push(format!("{name} and the positioning and straightness of both axes in the plane are within the map"));
    }
    changes.extend(raise(&mut filled));
    Ok((filled, changes))
}

/// Whether a table states anything but translations along these axes.
fn keeps(table: &Table, axes: [usize; 2]) -> bool {
    (0..6).any(|c| table.given[c] && !axes.contains(&c))
}

/// A table with new translations along two directions at these nodes, and everything else as it was: linear between its lines,
/// which stay. No nodes: without these translations.
fn merged(own: Option<&Table>, axes: [usize; 2], nodes: &[f64], errors: &[Vec<f64>; 2]) -> Table {
    let lines: Vec<f64> = own.iter().flat_map(|table| &table.rows).map(|row| row.position).collect();
    let keeps = own.is_some_and(|table| keeps(table, axes));
    let mut positions: Vec<f64> = nodes.to_vec();
    if keeps || nodes.is_empty() {
        positions.extend(&lines);
    }
    positions.sort_by(f64::total_cmp);
    positions.dedup_by(|next, kept| *next - *kept < 1e-6);
    let kept = |position: f64, of: &dyn Fn(&Row) -> Twist| -> Twist {
        let Some(table) = own.filter(|_| keeps) else { return [0.0; 6] };
        let [(low, share_low), (high, share_high)] = hats(&lines, position);
        let [low, high] = [low, high].map(|line| of(&table.rows[line]));
        std::array::from_fn(|c| share_low * low[c] + share_high * high[c])
    };
    let rows = positions.into_iter().map(|position| {
        let (mut forward, mut reverse) = (kept(position, &|row| row.forward), kept(position, &|row| row.reverse));
        for (axis, of) in axes.into_iter().zip(errors) {
            let value = if nodes.is_empty() {
                0.0
            } else {
                hats(nodes, position).into_iter().map(|(node, share)| share * of[node]).sum()
            };
            (forward[axis], reverse[axis]) = (rounded(value, 1e3), rounded(value, 1e3));
        }
        Row { position, forward, reverse }
    });
    let mut given = own.map_or([false; 6], |table| table.given);
    axes.iter().for_each(|axis| given[*axis] = !nodes.is_empty());
    Table { given, bidirectional: keeps && own.is_some_and(|table| table.bidirectional), rows: rows.collect() }
}
