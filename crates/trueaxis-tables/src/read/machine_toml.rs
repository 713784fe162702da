//! `machine.toml`: keys, units and defaults.

use super::common_lag::{self, DriveUncertainty};
use super::grid_toml::GridReference;
use super::keys::Keys;
use super::section::{KeyValue, Section};
use super::units::{degrees_from_urad, from_um, from_urad, per_second, same};
use crate::error::FileError;
use crate::origin::Origin;
use crate::text::line_at;
use crate::uncertainty::{AxisUncertainty, Uncertainties};
use std::cell::RefCell;
use toml::de::DeTable;
use trueaxis::machine::{
    Axis, AxisSettings, ContourSettings, ErrorModel, FaultSettings, Interpolation, LocationErrors, Lookup,
    MachineSettings, PERIODIC_CAPACITY, PeriodicSettings,
};

/// A table that the file names.
pub(super) struct TableReference {
    pub(super) axis: Axis,
    pub(super) file: String,
    pub(super) line: u32,
    pub(super) key: String,
}

/// The content of the whole file.
pub(super) struct Description {
    pub(super) settings: MachineSettings,
    pub(super) tables: Vec<TableReference>,
    pub(super) grids: Vec<GridReference>,
    pub(super) keys: Keys,
    /// Without those in the CSV of the axes.
    pub(super) uncertainties: Uncertainties,
    /// Keys of requested numbers, with their count.
    pub(super) numbers: Vec<(String, usize)>,
}

pub(super) fn read(text: &str, origin: &Origin) -> Result<Description, FileError> {
    let document = DeTable::parse(text).map_err(|error| {
        let line = error.span().map_or(1, |span| line_at(text, span.start));
        origin.at(line, "", error.message(), "a valid TOML file")
    })?;
    let numbers = RefCell::default();
    let root = Section::new(origin, text, document.get_ref(), &numbers);
    let name = root.string("name")?.ok_or_else(|| root.missing("name", "the name of the machine"))?;
    let chain =
        root.string("chain")?.ok_or_else(|| root.missing("chain", "the structural code, like \"w X' b Y Z t\""))?;
    let mut settings = MachineSettings {
        roundness: None,
        crosstalk: Default::default(),
        periodic: Default::default(),
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
    root.store_all(&mut settings.tool_mm, "tool_mm")?;
    root.store(&mut settings.reference_temperature_c, "reference_temperature_c", same)?;

    let (mut tables, mut uncertain, mut drives) = (Vec::new(), Vec::new(), Vec::new());
    let sections = root.section("axis")?;
    for axis in Axis::ALL {
        let Some(link) = links.iter().find(|link| link.axis == axis) else { continue };
        let mut of_axis = AxisSettings::with_defaults(axis, link.carries_workpiece);
        let letter = axis.letter().to_string();
        if let Some(section) = sections.as_ref().map(|axes| axes.section(&letter)).transpose()?.flatten() {
            let (table, own, drive) = read_axis(section, &mut of_axis, &mut settings.periodic)?;
            tables.extend(table);
            uncertain.push(own);
            drives.push(drive);
        } else {
            uncertain.push(AxisUncertainty::unstated(axis));
            drives.push(DriveUncertainty::default());
        }
        // At most six letters, each once.
        let _ = settings.axes.push(of_axis);
    }
    if let Some(sections) = sections {
        let letters: Vec<String> = links.iter().map(|link| link.axis.letter().to_string()).collect();
        sections.finish(Some(&format!("an axis of the chain ({})", letters.join(" "))))?;
    }
    common_lag::apply(&mut settings, &drives);
    if let Some(section) = root.section("location")? {
        read_location(section, &mut settings)?;
    }
    if let Some(section) = root.section("faults")? {
        read_faults(section, &mut settings.faults)?;
    }
    if let Some(section) = root.section("contour")? {
        section.store(&mut settings.contour.max_lag_mm, "max_lag_mm", same)?;
        settings.contour.feedback = super::servo_toml::read_feedback(&section)?;
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
        section.store(&mut settings.compensation.fade_deg, "fade_deg", same)?;
        section.finish(None)?;
    }
    if let Some(section) = root.section("kinematics")? {
        let to = &mut settings.kinematics;
        section.store_all(&mut to.tool_axis, "tool_axis")?;
        section.store(&mut to.singular_cone_deg, "singular_cone_deg", same)?;
        section.finish(None)?;
    }
    settings.roundness = super::roundness_toml::read(&root)?;
    settings.crosstalk = super::crosstalk_toml::read(&root)?;
    let grids = super::grid_toml::read(&root)?;
    let axes: Vec<Axis> = links.iter().map(|link| link.axis).collect();
    let uncertainties = super::uncertainty_toml::read(&root, &axes, uncertain)?;
    root.finish(None)?;
    let keys = Keys::new(text, document.get_ref());
    Ok(Description { settings, tables, grids, keys, uncertainties, numbers: numbers.into_inner() })
}

fn read_axis(
    section: Section<'_>,
    settings: &mut AxisSettings,
    periodic: &mut heapless::Vec<PeriodicSettings, PERIODIC_CAPACITY>,
) -> Result<(Option<TableReference>, AxisUncertainty, DriveUncertainty), FileError> {
    let axis = settings.axis;
    let rotary = axis.is_rotary();
    let unit = if rotary { "deg" } else { "mm" };
    let micro = if rotary { "urad" } else { "um" };
    let small = if rotary { degrees_from_urad } else { from_um };

    let table = section.string("table")?;
    let linear_or_cubic = [("linear", Interpolation::Linear), ("cubic", Interpolation::Cubic)];
    if let Some(choice) = section.choice("interpolation", linear_or_cubic)? {
        settings.interpolation = choice;
    }
    let lookup_choices = [("command", Lookup::Command), ("feedback", Lookup::Feedback)];
    if let Some(choice) = section.choice("lookup", lookup_choices)? {
        settings.lookup = choice;
    }
    if let Some(choice) = section.choice("cross_lookup", lookup_choices)? {
        settings.cross_lookup = choice;
    }
    if rotary && let Some(direction) = section.number("direction")? {
        settings.direction = match direction.value {
            1.0 => 1,
            -1.0 => -1,
            _ => return Err(section.wrong(&direction, "1 or -1")),
        };
    }
    section.store_all(&mut settings.travel, &format!("travel_{unit}"))?;
    section.store(&mut settings.max_feed_per_s, &format!("max_feed_{unit}_per_min"), per_second)?;
    section.store_all(&mut settings.offset_mm, "offset_mm")?;
    section.store_all(&mut settings.measured_at_mm, "measured_at_mm")?;
    section.store(&mut settings.backlash, &format!("backlash_{micro}"), small)?;
    section.store(&mut settings.hysteresis, &format!("hysteresis_{micro}"), small)?;
    let resolution = section.number(&format!("encoder_resolution_{micro}"))?;
    settings.encoder_resolution = resolution.map(|resolution| small(resolution.value));

    if let Some(limits) = section.section("limits")? {
        let to = &mut settings.limits;
        limits.store(&mut to.magnitude, &format!("magnitude_{micro}"), small)?;
        limits.store(&mut to.slope_per_s, &format!("slope_{unit}_per_s"), same)?;
        limits.store(&mut to.acceleration_per_s2, &format!("acceleration_{unit}_per_s2"), same)?;
        limits.finish(None)?;
    }
    if let Some(thermal) = section.section("thermal")? {
        let to = &mut settings.thermal;
        thermal.store(&mut to.offset_per_k, &format!("offset_{micro}_per_k"), small)?;
        let expansion = if rotary { "expansion_urad_per_rad_k" } else { "expansion_um_per_m_k" };
        // µm per m and µrad per rad are both millionths.
        thermal.store(&mut to.expansion_per_k, expansion, |millionths| millionths / 1e6)?;
        thermal.store(&mut to.datum, &format!("datum_{unit}"), same)?;
        thermal.finish(None)?;
    }
    if !section.store_all(&mut settings.joint, &format!("joint_{unit}"))? {
        let [low, high] = settings.travel;
        settings.joint = [low - settings.limits.magnitude, high + settings.limits.magnitude];
    }
    let (servo, drive) = super::servo_toml::read_axis(&section, axis)?;
    settings.servo = servo;
    super::periodic_toml::read(&section, axis, periodic)?;
    let uncertainty = super::uncertainty_toml::read_axis(&section, axis)?;
    section.finish(None)?;
    let table =
        table.map(|KeyValue { value, line, key, .. }| TableReference { axis, file: value.to_owned(), line, key });
    Ok((table, uncertainty, drive))
}

fn read_location(section: Section<'_>, settings: &mut MachineSettings) -> Result<(), FileError> {
    let location = &mut settings.location;
    for (key, to) in [("A0Z_urad", &mut location.a0z), ("B0Z_urad", &mut location.b0z), ("C0Y_urad", &mut location.c0y)]
    {
        section.store(to, key, from_urad)?;
    }
    for (errors, axis) in location.rotary.iter_mut().zip([Axis::A, Axis::B, Axis::C]) {
        if !settings.axes.iter().any(|known| known.axis == axis) {
            continue;
        }
        for (error, direction) in errors.iter_mut().zip(Axis::ALL) {
            let (unit, convert) =
                if direction.is_rotary() { ("urad", from_urad as fn(f64) -> f64) } else { ("um", from_um as _) };
            section.store(error, &format!("E{}0{}_{unit}", direction.letter(), axis.letter()), convert)?;
        }
    }
    section.finish(None)
}

fn read_faults(section: Section<'_>, faults: &mut FaultSettings) -> Result<(), FileError> {
    for (key, pair) in
        [("resume", &mut faults.resume), ("feedback_jump", &mut faults.feedback_jump), ("stuck", &mut faults.stuck)]
    {
        for (limit, unit) in pair.iter_mut().zip(["mm", "deg"]) {
            section.store(limit, &format!("{key}_{unit}"), same)?;
        }
    }
    section.store(&mut faults.command_jump_factor, "command_jump_factor", same)?;
    section.finish(None)
}
