//! A machine drawn from the uncertainties that its files state.

use super::{Conditions, Stream};
use crate::model::is_declared;
use anyhow::{Result, bail};
use trueaxis::machine::{Axis, AxisSettings, Row, wraps};
use trueaxis_metrology::uncertainty::Draws;
use trueaxis_tables::uncertainty::{AxisUncertainty, Uncertainties};
use trueaxis_tables::{Machine, Table};

/// Whether the machine states an uncertainty that [`drawn`] draws from.
pub fn is_stated(stated: &Uncertainties) -> bool {
    let location = &stated.location;
    let any = |own: &AxisUncertainty| {
        own.scale.is_some()
            || own.backlash.is_some()
            || own.columns.iter().any(Option::is_some)
            || own.points.iter().any(Option::is_some)
    };
    location.squareness.iter().chain(location.rotary.iter().flatten()).any(Option::is_some)
        || stated.axes.iter().any(any)
}

/// The machine with errors drawn from normal distributions about its own, with the standard deviations stated: location
/// errors, scales, lost motion, and points of tables. What its files do not state stays as it is.
///
/// # Errors
/// A scale to be drawn for an axis with neither table nor travel.
pub fn drawn(machine: &Machine, stated: &Uncertainties, conditions: &Conditions) -> Result<Machine> {
    let mut draws = conditions.draws(Stream::Machine);
    let mut drawn = machine.clone();
    let location = &mut drawn.settings.location;
    let squareness = [&mut location.a0z, &mut location.b0z, &mut location.c0y];
    for (value, u) in squareness.into_iter().zip(stated.location.squareness) {
        *value += u.map_or(0.0, |u| u * draws.normal());
    }
    let rotary = location.rotary.iter_mut().flatten();
    for (value, u) in rotary.zip(stated.location.rotary.iter().flatten()) {
        *value += u.map_or(0.0, |u| u * draws.normal());
    }
    let axes = drawn.settings.axes.iter_mut().zip(&mut drawn.tables);
    for (own, table) in axes {
        if let Some(stated) = stated.of(own.axis) {
            draw_axis(own, table, stated, &mut draws)?;
        }
    }
    Ok(drawn)
}

fn draw_axis(
    own: &mut AxisSettings,
    table: &mut Option<Table>,
    stated: &AxisUncertainty,
    draws: &mut Draws,
) -> Result<()> {
    if let Some(u) = stated.backlash {
        own.backlash = (own.backlash + u * draws.normal()).max(0.0);
    }
    if let Some(u) = stated.scale {
        let scale = u * draws.normal();
        if table.is_none() {
            *table = Some(empty(own)?);
        }
        add(table, own.axis, own.axis.index(), |_, position| scale * position);
    }
    for component in 0..6 {
        // Every point once, also where the table has another number of them.
        let u = |point| stated.of_point(component, point).unwrap_or_default();
        add(table, own.axis, component, |point, _| match u(point) {
            0.0 => 0.0,
            u => u * draws.normal(),
        });
    }
    Ok(())
}

/// Adds to a component of every row; the ends of a table around a whole turn stay equal.
fn add(table: &mut Option<Table>, axis: Axis, component: usize, mut by: impl FnMut(usize, f64) -> f64) {
    let Some(table) = table else { return };
    for (point, row) in table.rows.iter_mut().enumerate() {
        let by = by(point, row.position);
        row.forward[component] += by;
        row.reverse[component] += by;
        table.given[component] |= by != 0.0;
    }
    let around = wraps(axis, table.rows.as_slice());
    if let (true, [first, .., last]) = (around, table.rows.as_mut_slice()) {
        (last.forward, last.reverse) = (first.forward, first.reverse);
    }
}

fn empty(own: &AxisSettings) -> Result<Table> {
    if !is_declared(own) {
        let letter = own.axis.letter();
        bail!("found no travel of {letter}, needed axis.{letter}.travel_mm or its table, for the scale to be drawn");
    }
    let rows = own.travel.map(|position| Row { position, forward: [0.0; 6], reverse: [0.0; 6] }).to_vec();
    Ok(Table { given: [false; 6], bidirectional: false, rows })
}
