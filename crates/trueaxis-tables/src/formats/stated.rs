//! Settings that an imported file states for an axis, as keys of `machine.toml`.

use super::decimal::{shortest, toml_value};
use super::own_comments;
use crate::Table;
use toml_edit::Value;
use trueaxis::machine::{Axis, AxisSettings, LocationErrors, Row};

/// Fewest points through which a cubic is drawn: an inner cell has a point beyond each of its ends.
const LEAST_FOR_CUBIC: usize = 4;

/// Settings of an axis for which the machine has no section: cubic interpolation, if the points allow it, and the range of the
/// table as the travel.
pub(crate) fn of_new_axis(axis: Axis, table: &Table) -> Vec<(String, Value)> {
    let interpolation = if table.rows.len() < LEAST_FOR_CUBIC { "linear" } else { "cubic" };
    let mut settings = vec![(String::from("interpolation"), Value::from(interpolation))];
    // A full circle wraps: its ends do not bound the travel.
    if let (Some(Row { position: low, .. }), Some(Row { position: high, .. })) = (table.rows.first(), table.rows.last())
        && !(axis.is_rotary() && (high - low - 360.0).abs() < 1e-9)
    {
        settings.push((own_comments::travel_key(axis).to_owned(), [*low, *high].into_iter().collect()));
    }
    settings
}

/// Settings of an axis from the comments of an ISG file.
pub(crate) fn of_axis(axis: &AxisSettings) -> Vec<(String, Value)> {
    own_comments::axis_items(axis)
        .into_iter()
        .filter_map(|(key, value)| Some((key.to_owned(), toml_value(key, &value).parse().ok()?)))
        .collect()
}

/// The nonzero location errors, with their keys and in their units, `C0Y_urad`, `EX0C_um`.
pub fn location_values(location: &LocationErrors) -> Vec<(String, f64)> {
    let squareness = [("A0Z", location.a0z), ("B0Z", location.b0z), ("C0Y", location.c0y)];
    let squareness = squareness.into_iter().map(|(name, value)| (format!("{name}_urad"), value, 1e6));
    let rotary = location.rotary.iter().zip(['A', 'B', 'C']).flat_map(|(errors, letter)| {
        errors.iter().zip(Axis::ALL).enumerate().map(move |(component, (value, direction))| {
            let (scale, unit) = if component < 3 { (1e3, "um") } else { (1e6, "urad") };
            (format!("E{}0{letter}_{unit}", direction.letter()), *value, scale)
        })
    });
    let given = squareness.chain(rotary).filter(|(_, value, _)| *value != 0.0);
    given.map(|(key, value, scale)| (key, shortest(value, scale))).collect()
}

/// The first rotary axis that has location errors but is missing from a machine, and their names, `EY0A`.
pub(crate) fn of_no_axis(location: &LocationErrors, axes: impl Fn(Axis) -> bool) -> Option<(Axis, String)> {
    let [.., a, b, c] = Axis::ALL;
    let of = location.rotary.iter().zip([a, b, c]).find(|(errors, axis)| !axes(*axis) && **errors != [0.0; 6])?;
    let (errors, axis) = of;
    let given = errors.iter().zip(Axis::ALL).filter(|(value, _)| **value != 0.0);
    let names: Vec<String> = given.map(|(_, moved)| format!("E{}0{}", moved.letter(), axis.letter())).collect();
    Some((axis, names.join(" ")))
}

/// [`location_values`] as values of `machine.toml`.
pub(crate) fn location(location: &LocationErrors) -> Vec<(String, Value)> {
    location_values(location).into_iter().map(|(key, value)| (key, Value::from(value))).collect()
}
