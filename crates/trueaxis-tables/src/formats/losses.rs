//! Lists data that a format cannot hold, one sentence each, with values.

use super::positioning::error_name;
use crate::{Machine, Table};
use trueaxis::machine::links;
use trueaxis::machine::{
    Axis, AxisSettings, CompensationSettings, ErrorModel, Interpolation, KinematicsSettings, LocationErrors, Lookup,
    ThermalGrowth,
};

/// Numbers separated by blanks, each in the shortest form that reads back.
pub(super) fn numbers(values: &[f64]) -> String {
    values.iter().map(|value| format!("{}", value + 0.0)).collect::<Vec<String>>().join(" ")
}

/// Largest magnitude among some components of a table.
fn largest(table: &Table, components: std::ops::Range<usize>, except: Option<usize>) -> f64 {
    let rows = table.rows.iter().flat_map(|row| [&row.forward, &row.reverse]);
    let values = rows.flat_map(|twist| twist.iter().enumerate());
    values
        .filter(|(component, _)| components.contains(component) && Some(*component) != except)
        .fold(0.0, |most, (_, value)| f64::max(most, value.abs()))
}

/// A length in mm and an angle in rad as `12 um, 7 urad`, without zeros.
fn micro(length: f64, angle: f64) -> String {
    let part = |value: f64, scale: f64, unit: &str| {
        (value != 0.0).then(|| format!("{} {unit}", crate::text::fixed(value * scale, 3)))
    };
    [part(length, 1e3, "um"), part(angle, 1e6, "urad")].into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// Losses of a format without cross terms: the errors of this axis in other directions.
pub(super) fn cross_terms(settings: &AxisSettings, table: &Table, dropped: &mut Vec<String>) {
    let axis = settings.axis;
    let names: Vec<String> = (0..6)
        .filter(|&component| component != axis.index())
        .filter(|&component| largest(table, component..component + 1, None) != 0.0)
        .map(|component| error_name(axis, component))
        .collect();
    if !names.is_empty() {
        let own = Some(axis.index());
        let figures = micro(largest(table, 0..3, own), largest(table, 3..6, own));
        dropped.push(format!("{} of axis {} (up to {figures})", names.join(", "), axis.letter()));
    }
}

/// Settings that no other format has: thermal growth, periods, and backlash of axes without a table.
pub(super) fn settings_losses(machine: &Machine, only: Option<Axis>, dropped: &mut Vec<String>) {
    for (settings, table) in machine.axes() {
        if only.is_some_and(|axis| axis != settings.axis) {
            continue;
        }
        if settings.thermal != (ThermalGrowth { datum: settings.thermal.datum, ..ThermalGrowth::default() }) {
            dropped.push(format!("thermal growth of axis {}", settings.axis.letter()));
        }
        for period in machine.settings.periods_of(settings.axis) {
            let (unit, micro) = if settings.axis.is_rotary() { ("deg", "urad") } else { ("mm", "um") };
            let most = crate::text::micro(settings.axis, period.bound(0));
            let (letter, length) = (settings.axis.letter(), period.period);
            dropped.push(format!("period of {length} {unit} of axis {letter} (up to {most:.2} {micro})"));
        }
        if table.is_none() && settings.backlash != 0.0 {
            dropped.push(format!("backlash of axis {}, which has no table", settings.axis.letter()));
        }
    }
}

/// Location errors, for a format without them.
pub(super) fn location_losses(machine: &Machine, dropped: &mut Vec<String>) {
    let location = &machine.settings.location;
    if *location == LocationErrors::default() {
        return;
    }
    let squareness = [("A0Z", location.a0z), ("B0Z", location.b0z), ("C0Y", location.c0y)];
    let mut named: Vec<String> = squareness
        .into_iter()
        .filter(|(_, angle)| *angle != 0.0)
        .map(|(name, angle)| format!("{name} {}", micro(0.0, angle)))
        .collect();
    for (errors, axis) in location.rotary.iter().zip(['A', 'B', 'C']) {
        for (component, (value, direction)) in errors.iter().zip(Axis::ALL).enumerate() {
            if *value != 0.0 {
                let figure = if component < 3 { micro(*value, 0.0) } else { micro(0.0, *value) };
                named.push(format!("E{}0{axis} {figure}", direction.letter()));
            }
        }
    }
    dropped.push(format!("location errors {}", named.join(", ")));
}

/// Losses of a format of single axes: chain, offsets, levers, tool, and the use of the tables.
pub(super) fn machine_losses(machine: &Machine, only: Option<Axis>, dropped: &mut Vec<String>) {
    let settings = &machine.settings;
    location_losses(machine, dropped);
    let links = links(&settings.chain).unwrap_or_default();
    let letters = |which: &dyn Fn(&&trueaxis::machine::Link) -> bool| {
        links.iter().filter(which).map(|link| link.axis.letter().to_string()).collect::<Vec<String>>().join(" ")
    };
    let (rotary, primed) = (letters(&|link| link.axis.is_rotary()), letters(&|link| link.carries_workpiece));
    let parts: Vec<String> = [("rotary", rotary), ("carrying the workpiece", primed)]
        .into_iter()
        .filter(|(_, letters)| !letters.is_empty())
        .map(|(what, letters)| format!("{what}: {letters}"))
        .collect();
    if !parts.is_empty() {
        dropped.push(format!("chain {} ({})", settings.chain, parts.join("; ")));
    }
    if settings.tool_mm != [0.0; 3] {
        dropped.push(format!("tool_mm {}", numbers(&settings.tool_mm)));
    }
    let kinematics = KinematicsSettings::default();
    if settings.kinematics.tool_axis != kinematics.tool_axis {
        dropped.push(format!("tool_axis {}", numbers(&settings.kinematics.tool_axis)));
    }
    if settings.kinematics.singular_cone_deg != kinematics.singular_cone_deg {
        dropped.push(format!("singular_cone_deg {}", settings.kinematics.singular_cone_deg));
    }
    if settings.compensation != CompensationSettings::default() {
        let CompensationSettings { model, orientation, fade_deg } = settings.compensation;
        let model = if model == ErrorModel::Nine { "nine" } else { "volumetric" };
        dropped.push(format!("compensation settings: model {model}, orientation {orientation}, fade_deg {fade_deg}"));
    }
    for (axis, table) in machine.axes().filter(|(axis, _)| only.is_none_or(|only| only == axis.axis)) {
        let letter = axis.axis.letter();
        if axis.offset_mm != [0.0; 3] {
            dropped.push(format!("offset_mm {} of axis {letter}", numbers(&axis.offset_mm)));
        }
        let Some(table) = table else { continue };
        let angle = largest(table, 3..6, None);
        if axis.measured_at_mm != [0.0; 3] && angle != 0.0 {
            dropped.push(format!(
                "measured_at_mm {} of axis {letter}: its error is valid there, elsewhere its angular errors of up to {} change it",
                numbers(&axis.measured_at_mm),
                micro(0.0, angle)
            ));
        }
        if axis.interpolation == Interpolation::Cubic {
            dropped.push(format!("cubic interpolation of axis {letter}: the control has its own"));
        }
        if axis.lookup == Lookup::Feedback {
            dropped.push(format!("look-up of axis {letter} at the feedback"));
        }
    }
}
