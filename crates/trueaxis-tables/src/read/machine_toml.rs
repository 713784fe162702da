//! `machine.toml`: keys, units and defaults.

use super::places::{Place, Places};
use super::section::{Found, Section};
use crate::error::FileError;
use crate::origin::Origin;
use std::cell::RefCell;
use toml::de::DeTable;
use trueaxis::error::Field;
use trueaxis::machine::{
    Axis, AxisSettings, ContourSettings, ErrorModel, FaultSettings, Interpolation, LocationErrors, Lookup,
    MachineSettings,
};

/// A table that the file names.
pub(super) struct TableReference {
    pub(super) axis: Axis,
    pub(super) file: String,
    pub(super) line: u32,
    pub(super) key: String,
}

/// The whole file.
pub(super) struct Description {
    pub(super) settings: MachineSettings,
    pub(super) tables: Vec<TableReference>,
    pub(super) places: Vec<Place>,
    /// Keys of numbers that were asked for, with their count.
    pub(super) numbers: Vec<(String, usize)>,
}

/// µm to mm: a division, so that the result is the double nearest to the decimal.
fn from_um(value: f64) -> f64 {
    value / 1e3
}

/// µrad to rad.
fn from_urad(value: f64) -> f64 {
    value / 1e6
}

/// µrad to degrees.
fn degrees_from_urad(value: f64) -> f64 {
    (value / 1e6).to_degrees()
}

/// Per minute to per second.
fn per_second(value: f64) -> f64 {
    value / 60.0
}

pub(super) fn read(text: &str, origin: &Origin) -> Result<Description, FileError> {
    let document = DeTable::parse(text).map_err(|error| {
        let before = error.span().map_or(0, |span| span.start);
        let line = 1 + text.as_bytes().iter().take(before).filter(|byte| **byte == b'\n').count();
        origin.at(u32::try_from(line).unwrap_or(0), "", error.message(), "a valid TOML file")
    })?;
    let numbers = RefCell::default();
    let root = Section::new(origin, text, document.get_ref(), &numbers);
    let mut places = Places::default();
    let name = root.string("name")?.ok_or_else(|| root.missing("name", "the name of the machine"))?;
    let chain =
        root.string("chain")?.ok_or_else(|| root.missing("chain", "the structural code, like \"w X' b Y Z t\""))?;
    let mut settings = MachineSettings {
        roundness: None,
        name: name.value.parse().map_err(|_| root.wrong(&name, "1 to 64 bytes"))?,
        chain: chain.value.parse().map_err(|_| root.wrong(&chain, "at most 48 bytes"))?,
        tool_mm: [0.0; 3],
        reference_temperature_c: 20.0,
        location: LocationErrors::default(),
        faults: FaultSettings::default(),
        contour: ContourSettings::default(),
        compensation: Default::default(),
        kinematics: Default::default(),
        axes: heapless::Vec::new(),
    };
    let links = trueaxis::machine::links(chain.value).map_err(|error| {
        let needed = format!("{} (at letter {} of the chain)", error.needed, error.found + 1.0);
        root.wrong(&chain, needed)
    })?;
    for (found, field) in [(name, Field::Name), (chain, Field::Chain)] {
        let Found { line, key, text, .. } = found;
        places.push(Place { field, axis: None, line, key, text, values: Vec::new() });
    }
    places.numbers(&mut settings.tool_mm, root.numbers("tool_mm")?, Field::Tool, None);
    let reference = root.number("reference_temperature_c")?;
    places.number(&mut settings.reference_temperature_c, reference, Field::ReferenceTemperature, None, |c| c);

    let mut tables = Vec::new();
    let sections = root.section("axis")?;
    for axis in Axis::ALL {
        let Some(link) = links.iter().find(|link| link.axis == axis) else { continue };
        let mut of_axis = AxisSettings::with_defaults(axis, link.carries_workpiece);
        let letter = axis.letter().to_string();
        if let Some(section) = sections.as_ref().map(|axes| axes.section(&letter)).transpose()?.flatten() {
            tables.extend(read_axis(section, &mut of_axis, &mut places)?);
        }
        // At most six letters, each once.
        let _ = settings.axes.push(of_axis);
    }
    if let Some(sections) = sections {
        let letters: Vec<String> = links.iter().map(|link| link.axis.letter().to_string()).collect();
        sections.finish(Some(&format!("an axis of the chain ({})", letters.join(" "))))?;
    }
    if let Some(section) = root.section("location")? {
        read_location(section, &mut settings, &mut places)?;
    }
    if let Some(section) = root.section("faults")? {
        read_faults(section, &mut settings.faults, &mut places)?;
    }
    if let Some(section) = root.section("contour")? {
        let lag = section.number("max_lag_mm")?;
        places.number(&mut settings.contour.max_lag_mm, lag, Field::Contour, None, |mm| mm);
        section.finish(None)?;
    }
    if let Some(section) = root.section("compensation")? {
        let models = [("nine", ErrorModel::Nine), ("volumetric", ErrorModel::Volumetric)];
        if let Some(model) = section.choice("model", models)? {
            settings.compensation.model = model;
        }
        if let Some(orientation) = section.boolean("orientation")? {
            settings.compensation.orientation = orientation;
        }
        let fade = section.number("fade_deg")?;
        places.number(&mut settings.compensation.fade_deg, fade, Field::Compensation, None, |degrees| degrees);
        section.finish(None)?;
    }
    if let Some(section) = root.section("kinematics")? {
        let to = &mut settings.kinematics;
        places.numbers(&mut to.tool_axis, section.numbers("tool_axis")?, Field::Kinematics, None);
        let cone = section.number("singular_cone_deg")?;
        places.number(&mut to.singular_cone_deg, cone, Field::Kinematics, None, |degrees| degrees);
        section.finish(None)?;
    }
    settings.roundness = super::roundness_toml::read(&root, &mut places)?;
    root.finish(None)?;
    Ok(Description { settings, tables, places: places.into_all(), numbers: numbers.into_inner() })
}

fn read_axis(
    section: Section<'_>,
    settings: &mut AxisSettings,
    places: &mut Places,
) -> Result<Option<TableReference>, FileError> {
    let axis = settings.axis;
    let on = Some(axis);
    let rotary = axis.is_rotary();
    let unit = if rotary { "deg" } else { "mm" };
    let micro = if rotary { "urad" } else { "um" };
    let small = if rotary { degrees_from_urad } else { from_um };

    let table = section.string("table")?;
    let linear_or_cubic = [("linear", Interpolation::Linear), ("cubic", Interpolation::Cubic)];
    if let Some(choice) = section.choice("interpolation", linear_or_cubic)? {
        settings.interpolation = choice;
    }
    let where_to_look = [("command", Lookup::Command), ("feedback", Lookup::Feedback)];
    if let Some(choice) = section.choice("lookup", where_to_look)? {
        settings.lookup = choice;
    }
    if let Some(choice) = section.choice("cross_lookup", where_to_look)? {
        settings.cross_lookup = choice;
    }
    if rotary && let Some(direction) = section.number("direction")? {
        settings.direction = match direction.value {
            1.0 => 1,
            -1.0 => -1,
            _ => return Err(section.wrong(&direction, "1 or -1")),
        };
    }
    places.numbers(&mut settings.travel, section.numbers(&format!("travel_{unit}"))?, Field::Travel, on);
    let feed = section.number(&format!("max_feed_{unit}_per_min"))?;
    places.number(&mut settings.max_feed_per_s, feed, Field::MaxFeed, on, per_second);
    places.numbers(&mut settings.offset_mm, section.numbers("offset_mm")?, Field::Offset, on);
    places.numbers(&mut settings.measured_at_mm, section.numbers("measured_at_mm")?, Field::MeasuredAt, on);
    let backlash = section.number(&format!("backlash_{micro}"))?;
    places.number(&mut settings.backlash, backlash, Field::Backlash, on, small);
    let hysteresis = section.number(&format!("hysteresis_{micro}"))?;
    places.number(&mut settings.hysteresis, hysteresis, Field::Hysteresis, on, small);
    if let Some(resolution) = section.number(&format!("encoder_resolution_{micro}"))? {
        let mut step = 0.0;
        places.number(&mut step, Some(resolution), Field::Encoder, on, small);
        settings.encoder_resolution = Some(step);
    }

    if let Some(limits) = section.section("limits")? {
        let to = &mut settings.limits;
        let magnitude = limits.number(&format!("magnitude_{micro}"))?;
        places.number(&mut to.magnitude, magnitude, Field::Magnitude, on, small);
        let slope = limits.number(&format!("slope_{unit}_per_s"))?;
        places.number(&mut to.slope_per_s, slope, Field::Slope, on, |v| v);
        let acceleration = limits.number(&format!("acceleration_{unit}_per_s2"))?;
        places.number(&mut to.acceleration_per_s2, acceleration, Field::Acceleration, on, |a| a);
        limits.finish(None)?;
    }
    if let Some(thermal) = section.section("thermal")? {
        let to = &mut settings.thermal;
        let offset = thermal.number(&format!("offset_{micro}_per_k"))?;
        places.number(&mut to.offset_per_k, offset, Field::Thermal, on, small);
        let expansion = thermal.number(if rotary { "expansion_urad_per_rad_k" } else { "expansion_um_per_m_k" })?;
        // µm per m and µrad per rad are both millionths.
        places.number(&mut to.expansion_per_k, expansion, Field::Thermal, on, |millionths| millionths / 1e6);
        let datum = thermal.number(&format!("datum_{unit}"))?;
        places.number(&mut to.datum, datum, Field::Thermal, on, |q| q);
        thermal.finish(None)?;
    }
    let joint = section.numbers(&format!("joint_{unit}"))?;
    if !places.numbers(&mut settings.joint, joint, Field::Joint, on) {
        let [low, high] = settings.travel;
        settings.joint = [low - settings.limits.magnitude, high + settings.limits.magnitude];
    }
    section.finish(None)?;
    Ok(table.map(|Found { value, line, key, .. }| TableReference { axis, file: value.to_owned(), line, key }))
}

fn read_location(section: Section<'_>, settings: &mut MachineSettings, places: &mut Places) -> Result<(), FileError> {
    let location = &mut settings.location;
    for (key, to) in [("A0Z_urad", &mut location.a0z), ("B0Z_urad", &mut location.b0z), ("C0Y_urad", &mut location.c0y)]
    {
        places.number(to, section.number(key)?, Field::Location, None, from_urad);
    }
    for (errors, axis) in location.rotary.iter_mut().zip([Axis::A, Axis::B, Axis::C]) {
        if !settings.axes.iter().any(|known| known.axis == axis) {
            continue;
        }
        for (error, direction) in errors.iter_mut().zip(Axis::ALL) {
            let (unit, convert) =
                if direction.is_rotary() { ("urad", from_urad as fn(f64) -> f64) } else { ("um", from_um as _) };
            let found = section.number(&format!("E{}0{}_{unit}", direction.letter(), axis.letter()))?;
            places.number(error, found, Field::Location, Some(axis), convert);
        }
    }
    section.finish(None)
}

fn read_faults(section: Section<'_>, faults: &mut FaultSettings, places: &mut Places) -> Result<(), FileError> {
    for (key, pair) in
        [("resume", &mut faults.resume), ("feedback_jump", &mut faults.feedback_jump), ("stuck", &mut faults.stuck)]
    {
        for (limit, unit) in pair.iter_mut().zip(["mm", "deg"]) {
            places.number(limit, section.number(&format!("{key}_{unit}"))?, Field::Faults, None, |limit| limit);
        }
    }
    let factor = section.number("command_jump_factor")?;
    places.number(&mut faults.command_jump_factor, factor, Field::Faults, None, |factor| factor);
    section.finish(None)
}
