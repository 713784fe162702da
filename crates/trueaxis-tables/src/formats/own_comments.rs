//! Settings for which an ISG CSV has no columns, as comment lines that other readers skip and this crate reads back.
//!
//! One item per line, each at most once, from the beginning of a line; numbers are decimals that reproduce the same double:
//!
//! ```text
//! // trueaxis chain: w C' A' Y' b X Z t
//! // trueaxis tool_mm: 0 0 -250
//! // trueaxis reference_temperature_c: 21
//! // trueaxis model: volumetric
//! // trueaxis axis A direction: -1
//! // trueaxis axis A offset_mm: 0 0 150
//! ```
//!
//! Keys and values are those of `machine.toml`.

use super::losses::numbers;
use crate::Machine;
use crate::error::FileError;
use crate::origin::{Origin, numbered};
use crate::text::counted;
use std::fmt::Write;
use trueaxis::check;
use trueaxis::machine::{
    Axis, AxisSettings, CompensationSettings, ErrorModel, Interpolation, KinematicsSettings, LocationErrors, Lookup,
    MachineSettings,
};

/// Mark of the comments written here.
const MARK: &str = "// trueaxis ";
const KEYS: &str =
    "chain, tool_mm, tool_axis, singular_cone_deg, reference_temperature_c, model, orientation or fade_deg";
const AXIS_KEYS: &str = "direction, interpolation, lookup, cross_lookup, travel_mm (travel_deg) or offset_mm";

/// One comment; `axis` is `None` for a setting of the machine.
struct Item<'t> {
    line: u32,
    axis: Option<Axis>,
    key: &'t str,
    value: &'t str,
}

/// Settings of the machine that differ from their defaults, as (section, key, value) in the words of `machine.toml`.
pub(super) fn machine_items(settings: &MachineSettings) -> Vec<(&'static str, &'static str, String)> {
    let mut items = Vec::new();
    if settings.tool_mm != [0.0; 3] {
        items.push(("", "tool_mm", numbers(&settings.tool_mm)));
    }
    if settings.reference_temperature_c != 20.0 {
        items.push(("", "reference_temperature_c", format!("{}", settings.reference_temperature_c)));
    }
    let (own, default) = (&settings.compensation, CompensationSettings::default());
    if own.model != default.model {
        items.push(("compensation", "model", String::from("volumetric")));
    }
    if own.orientation != default.orientation {
        items.push(("compensation", "orientation", format!("{}", own.orientation)));
    }
    if own.fade_deg != default.fade_deg {
        items.push(("compensation", "fade_deg", format!("{}", own.fade_deg)));
    }
    let (own, default) = (&settings.kinematics, KinematicsSettings::default());
    if own.tool_axis != default.tool_axis {
        items.push(("kinematics", "tool_axis", numbers(&own.tool_axis)));
    }
    if own.singular_cone_deg != default.singular_cone_deg {
        items.push(("kinematics", "singular_cone_deg", format!("{}", own.singular_cone_deg)));
    }
    items
}

/// Settings of an axis, as (key, value); the sense of a rotary axis always, the others if they are not at their defaults.
pub(super) fn axis_items(axis: &AxisSettings) -> Vec<(&'static str, String)> {
    let mut items = Vec::new();
    let default = AxisSettings::with_defaults(axis.axis, false);
    if axis.axis.is_rotary() {
        items.push(("direction", format!("{}", axis.direction)));
    }
    if axis.interpolation == Interpolation::Cubic {
        items.push(("interpolation", String::from("cubic")));
    }
    for (key, lookup) in [("lookup", axis.lookup), ("cross_lookup", axis.cross_lookup)] {
        if lookup == Lookup::Feedback {
            items.push((key, String::from("feedback")));
        }
    }
    if axis.travel != default.travel {
        items.push((travel_key(axis.axis), numbers(&axis.travel)));
    }
    if axis.offset_mm != [0.0; 3] {
        items.push(("offset_mm", numbers(&axis.offset_mm)));
    }
    items
}

pub(super) fn travel_key(axis: Axis) -> &'static str {
    if axis.is_rotary() { "travel_deg" } else { "travel_mm" }
}

/// The comment lines of a machine.
pub(super) fn written(machine: &Machine) -> String {
    let mut text = format!("{MARK}chain: {}\n", machine.settings.chain);
    for (_, key, value) in machine_items(&machine.settings) {
        let _ = writeln!(text, "{MARK}{key}: {value}");
    }
    for axis in &machine.settings.axes {
        for (key, value) in axis_items(axis) {
            let _ = writeln!(text, "{MARK}axis {} {key}: {value}", axis.axis.letter());
        }
    }
    text
}

/// The settings that the comments of a file give; `None` without such comments.
pub(super) fn read(text: &str, origin: &Origin) -> Result<Option<MachineSettings>, FileError> {
    let items = items(text, origin)?;
    let Some(first) = items.first() else { return Ok(None) };
    let Some(chain) = items.iter().find(|item| item.axis.is_none() && item.key == "chain") else {
        return Err(origin.at(first.line, first.key, "no chain beside it", "a comment // trueaxis chain: w … b … t"));
    };
    let mut settings = settings_of(chain, origin)?;
    for item in &items {
        match item.axis {
            None => machine_item(item, &mut settings, origin)?,
            Some(axis) => {
                let Some(own) = settings.axes.iter_mut().find(|own| own.axis == axis) else {
                    let found = format!("axis {}, which is not in the chain {}", axis.letter(), chain.value);
                    return Err(origin.at(item.line, item.key, found, "an axis of the chain"));
                };
                axis_item(item, own, origin)?;
            }
        }
    }
    for axis in &mut settings.axes {
        let [low, high] = axis.travel;
        axis.joint = [low - axis.limits.magnitude, high + axis.limits.magnitude];
    }
    check::settings(&settings).map_err(|error| {
        let of = |item: &&Item<'_>| {
            let key = error.key().map(|key| key.to_string()).unwrap_or_default();
            item.axis == error.axis && key.rsplit('.').next() == Some(item.key)
        };
        match items.iter().find(of) {
            Some(item) => origin.at(item.line, item.key, format!("{:?}", item.value), error.needed),
            None => origin.at(chain.line, chain.key, format!("{:?}: {error}", chain.value), error.needed),
        }
    })?;
    Ok(Some(settings))
}

fn items<'t>(text: &'t str, origin: &Origin) -> Result<Vec<Item<'t>>, FileError> {
    let mut items: Vec<Item<'t>> = Vec::new();
    for (line, content) in numbered(text) {
        let Some(content) = content.trim().strip_prefix(MARK) else { continue };
        let Some((name, value)) = content.split_once(':') else {
            return Err(origin.at(line, "", format!("{content:?}"), "a key, a colon and a value"));
        };
        let (name, value) = (name.trim(), value.trim());
        let (axis, key) = match name.strip_prefix("axis ").and_then(|of_axis| of_axis.trim().split_once(' ')) {
            Some((letter, key)) => {
                let mut letters = letter.chars();
                let axis = letters.next().and_then(Axis::from_letter).filter(|_| letters.next().is_none());
                let needed = "one of X Y Z A B C";
                (Some(axis.ok_or_else(|| origin.at(line, name, format!("axis {letter:?}"), needed))?), key.trim())
            }
            None => (None, name),
        };
        if let Some(before) = items.iter().find(|before| before.axis == axis && before.key == key) {
            return Err(origin.at(line, name, format!("it again, already on line {}", before.line), "it once"));
        }
        items.push(Item { line, axis, key, value });
    }
    Ok(items)
}

/// The settings of a machine of this chain, all at their defaults.
fn settings_of(chain: &Item<'_>, origin: &Origin) -> Result<MachineSettings, FileError> {
    let wrong = |needed: String| origin.at(chain.line, chain.key, format!("{:?}", chain.value), needed);
    let links = trueaxis::machine::links(chain.value)
        .map_err(|error| wrong(format!("{} (at letter {} of the chain)", error.needed, error.found + 1.0)))?;
    if links.is_empty() {
        return Err(wrong(String::from("at least one axis in the chain")));
    }
    let mut axes = heapless::Vec::new();
    for axis in Axis::ALL {
        if let Some(link) = links.iter().find(|link| link.axis == axis) {
            // At most six letters, each once.
            let _ = axes.push(AxisSettings::with_defaults(axis, link.carries_workpiece));
        }
    }
    Ok(MachineSettings {
        name: "imported".parse().unwrap_or_default(),
        chain: chain.value.parse().map_err(|_| wrong(String::from("at most 48 bytes")))?,
        tool_mm: [0.0; 3],
        reference_temperature_c: 20.0,
        location: LocationErrors::default(),
        faults: Default::default(),
        contour: Default::default(),
        compensation: CompensationSettings::default(),
        kinematics: KinematicsSettings::default(),
        axes,
        roundness: None,
        crosstalk: Default::default(),
        periodic: Default::default(),
    })
}

fn machine_item(item: &Item<'_>, settings: &mut MachineSettings, origin: &Origin) -> Result<(), FileError> {
    match item.key {
        "chain" => {}
        "tool_mm" => settings.tool_mm = list(item, origin)?,
        "reference_temperature_c" => [settings.reference_temperature_c] = list(item, origin)?,
        "model" => {
            let models = [("nine", ErrorModel::Nine), ("volumetric", ErrorModel::Volumetric)];
            settings.compensation.model = choice(item, models, origin)?;
        }
        "orientation" => {
            settings.compensation.orientation = choice(item, [("true", true), ("false", false)], origin)?;
        }
        "fade_deg" => [settings.compensation.fade_deg] = list(item, origin)?,
        "tool_axis" => settings.kinematics.tool_axis = list(item, origin)?,
        "singular_cone_deg" => [settings.kinematics.singular_cone_deg] = list(item, origin)?,
        other => return Err(origin.at(item.line, "", format!("{other:?}"), KEYS)),
    }
    Ok(())
}

fn axis_item(item: &Item<'_>, axis: &mut AxisSettings, origin: &Origin) -> Result<(), FileError> {
    let lookup_choices = [("command", Lookup::Command), ("feedback", Lookup::Feedback)];
    match item.key {
        "direction" if axis.axis.is_rotary() => axis.direction = choice(item, [("1", 1), ("-1", -1)], origin)?,
        "interpolation" => {
            let choices = [("linear", Interpolation::Linear), ("cubic", Interpolation::Cubic)];
            axis.interpolation = choice(item, choices, origin)?;
        }
        "lookup" => axis.lookup = choice(item, lookup_choices, origin)?,
        "cross_lookup" => axis.cross_lookup = choice(item, lookup_choices, origin)?,
        key if key == travel_key(axis.axis) => axis.travel = list(item, origin)?,
        "offset_mm" => axis.offset_mm = list(item, origin)?,
        other => {
            let found = format!("{other:?} of axis {}", axis.axis.letter());
            return Err(origin.at(item.line, "", found, format!("{AXIS_KEYS}; direction of a rotary axis only")));
        }
    }
    Ok(())
}

fn list<const N: usize>(item: &Item<'_>, origin: &Origin) -> Result<[f64; N], FileError> {
    let values = item.value.split_whitespace().map(|text| origin.number(item.line, item.key, text));
    let values = values.collect::<Result<Vec<f64>, FileError>>()?;
    <[f64; N]>::try_from(values)
        .map_err(|values| origin.at(item.line, item.key, counted(values.len(), "number"), format!("{N}")))
}

fn choice<T, const N: usize>(item: &Item<'_>, choices: [(&str, T); N], origin: &Origin) -> Result<T, FileError> {
    let needed = choices.iter().map(|(name, _)| *name).collect::<Vec<&str>>().join(" or ");
    let chosen = choices.into_iter().find(|(name, _)| *name == item.value).map(|(_, value)| value);
    chosen.ok_or_else(|| origin.at(item.line, item.key, format!("{:?}", item.value), needed))
}
