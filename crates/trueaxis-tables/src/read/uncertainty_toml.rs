//! `[uncertainty]`, `[uncertainty.location]`, `[[uncertainty.correlation]]` and `[axis.*.uncertainty]` of `machine.toml`.

use super::section::{KeyValue, Section};
use super::units::{degrees_from_urad, from_um, from_urad, same};
use crate::error::FileError;
use crate::uncertainty::{AxisUncertainty, Figure, Instrument, LocationUncertainty, Uncertainties};
use trueaxis::machine::Axis;

/// Largest standard uncertainties: the largest values of the quantities themselves, in the units of the file.
const MOST_UM: f64 = 1000.0;
pub(super) const UM: Bounds = Bounds { most: MOST_UM, needed: "a standard uncertainty of 0 to 1000 um" };
pub(super) const URAD: Bounds = Bounds { most: 10_000.0, needed: "a standard uncertainty of 0 to 10000 urad" };
const MILLIONTHS: Bounds = Bounds { most: 1000.0, needed: "a standard uncertainty of 0 to 1000 millionths" };
const MISALIGNMENT: Bounds = Bounds { most: 100.0, needed: "a standard uncertainty of 0 to 100 mm" };
const SERVO: Bounds = Bounds { most: 1e6, needed: "a standard uncertainty of 0 to 1e6" };
const KELVIN: Bounds = Bounds { most: 100.0, needed: "a standard uncertainty of 0 to 100 K" };

/// Range of a standard uncertainty, from zero.
pub(super) struct Bounds {
    pub(super) most: f64,
    pub(super) needed: &'static str,
}

impl Bounds {
    pub(super) fn contains(&self, value: f64) -> bool {
        (0.0..=self.most).contains(&value)
    }
}

fn stated(
    section: &Section<'_>,
    key: &str,
    bounds: &Bounds,
    convert: fn(f64) -> f64,
) -> Result<Option<f64>, FileError> {
    let Some(found) = section.number(key)? else { return Ok(None) };
    if !bounds.contains(found.value) {
        return Err(section.wrong(&found, bounds.needed));
    }
    Ok(Some(convert(found.value)))
}

fn millionths(value: f64) -> f64 {
    value / 1e6
}

/// Degrees of freedom, at least one: the scatter of two readings has one.
fn degrees_of_freedom(section: &Section<'_>) -> Result<Option<f64>, FileError> {
    degrees(section, "degrees_of_freedom")
}

/// Reads the degrees of freedom of a single figure, `C0Y_degrees_of_freedom` beside `C0Y_urad`, into the list of a section.
fn own_degrees(section: &Section<'_>, name: &str, to: &mut Vec<(String, f64)>) -> Result<(), FileError> {
    to.extend(degrees(section, &format!("{name}_degrees_of_freedom"))?.map(|degrees| (name.to_owned(), degrees)));
    Ok(())
}

fn degrees(section: &Section<'_>, key: &str) -> Result<Option<f64>, FileError> {
    let Some(found) = section.number(key)? else { return Ok(None) };
    if !(1.0..=1e9).contains(&found.value) {
        return Err(section.wrong(&found, "1 to 1e9 degrees of freedom"));
    }
    Ok(Some(found.value))
}

/// Reads the `uncertainty` of a section with these figures, in their order; 0: not stated.
pub(super) fn uncertainties_of<const N: usize>(figures: &Section<'_>, keys: [&str; N]) -> Result<[f64; N], FileError> {
    let mut found = [0.0; N];
    let Some(section) = figures.section("uncertainty")? else { return Ok(found) };
    for (to, key) in found.iter_mut().zip(keys) {
        *to = stated(&section, key, &SERVO, same)?.unwrap_or(0.0);
    }
    degrees_of_freedom(&section)?;
    section.finish(None)?;
    Ok(found)
}

/// Standard uncertainties of the resonance (Hz) and the damping of a drive, which are not compiled.
pub(super) fn of_resonance(drive: &Section<'_>) -> Result<[Option<KeyValue<f64>>; 2], FileError> {
    let Some(section) = drive.section("uncertainty")? else { return Ok([None, None]) };
    Ok([section.number("resonance_hz")?, section.number("resonance_damping")?])
}

/// All that a machine with these axes states, without the columns of its tables; `of_axes`: the sections of the axes.
pub(super) fn read(
    root: &Section<'_>,
    axes: &[Axis],
    of_axes: Vec<AxisUncertainty>,
) -> Result<Uncertainties, FileError> {
    let mut found = Uncertainties { axes: of_axes, ..Uncertainties::default() };
    let Some(section) = root.section("uncertainty")? else { return Ok(found) };
    found.instrument = Instrument {
        device_per_length: stated(&section, "device_um_per_m", &MILLIONTHS, millionths)?,
        device: stated(&section, "device_um", &UM, from_um)?,
        misalignment: stated(&section, "misalignment_mm", &MISALIGNMENT, same)?,
        temperature_k: stated(&section, "temperature_k", &KELVIN, same)?,
        temperature_difference_k: difference(&section)?,
        expansion_per_k: stated(&section, "expansion_um_per_m_k", &MILLIONTHS, millionths)?,
        eve: stated(&section, "eve_um", &UM, from_um)?,
        sensor_k: stated(&section, "sensor_k", &KELVIN, same)?,
        degrees_of_freedom: degrees_of_freedom(&section)?,
    };
    if let Some(records) = section.strings("records")? {
        found.records = records.value.into_iter().map(str::to_owned).collect();
    }
    if let Some(section) = section.section("location")? {
        found.location = read_location(section, axes)?;
    }
    found.correlations = super::correlation_toml::read(&section, &found)?;
    section.finish(None)?;
    Ok(found)
}

/// A temperature difference: signed, since it is not an uncertainty.
fn difference(section: &Section<'_>) -> Result<Option<f64>, FileError> {
    let Some(found) = section.number("temperature_difference_k")? else { return Ok(None) };
    if found.value.abs() > 100.0 {
        return Err(section.wrong(&found, "-100 to 100 K from the reference temperature"));
    }
    Ok(Some(found.value))
}

fn read_location(section: Section<'_>, axes: &[Axis]) -> Result<LocationUncertainty, FileError> {
    let mut found = LocationUncertainty::default();
    for (to, key) in found.squareness.iter_mut().zip(["A0Z_urad", "B0Z_urad", "C0Y_urad"]) {
        *to = stated(&section, key, &URAD, from_urad)?;
        own_degrees(&section, &key[..3], &mut found.own_degrees_of_freedom)?;
    }
    for (errors, axis) in found.rotary.iter_mut().zip([Axis::A, Axis::B, Axis::C]) {
        if !axes.contains(&axis) {
            continue;
        }
        for (to, moved) in errors.iter_mut().zip(Axis::ALL) {
            let (unit, bounds, convert): (_, _, fn(f64) -> f64) =
                if moved.is_rotary() { ("urad", &URAD, from_urad) } else { ("um", &UM, from_um) };
            let name = format!("E{}0{}", moved.letter(), axis.letter());
            *to = stated(&section, &format!("{name}_{unit}"), bounds, convert)?;
            own_degrees(&section, &name, &mut found.own_degrees_of_freedom)?;
        }
    }
    found.degrees_of_freedom = degrees_of_freedom(&section)?;
    section.finish(None)?;
    Ok(found)
}

/// Reads `[axis.*.uncertainty]`; nothing is stated if the axis has none.
pub(super) fn read_axis(axis: &Section<'_>, of: Axis) -> Result<AxisUncertainty, FileError> {
    let mut found = AxisUncertainty::unstated(of);
    if let Some(drive) = axis.section("drive")? {
        let [resonance, damping] = of_resonance(&drive)?.map(|stated| stated.map(|stated| stated.value));
        (found.resonance_hz, found.resonance_damping) = (resonance, damping);
    }
    read_servo(axis, &mut found)?;
    let Some(section) = axis.section("uncertainty")? else { return Ok(found) };
    let (micro, bounds, convert): (_, _, fn(f64) -> f64) =
        if of.is_rotary() { ("urad", &URAD, from_urad) } else { ("um", &UM, from_um) };
    if !of.is_rotary() {
        found.scale = stated(&section, "scale_ppm", &MILLIONTHS, millionths)?;
        own_degrees(&section, "scale", &mut found.own_degrees_of_freedom)?;
    }
    found.backlash = stated(&section, &format!("backlash_{micro}"), bounds, convert)?;
    own_degrees(&section, "backlash", &mut found.own_degrees_of_freedom)?;
    found.repeatability = stated(&section, &format!("repeatability_{micro}"), bounds, convert)?;
    found.growth = stated(&section, &format!("growth_{micro}"), bounds, convert)?;
    own_degrees(&section, "growth", &mut found.own_degrees_of_freedom)?;
    for (to, moved) in found.columns.iter_mut().zip(Axis::ALL) {
        let (unit, bounds, convert): (_, _, fn(f64) -> f64) =
            if moved.is_rotary() { ("urad", &URAD, from_urad) } else { ("um", &UM, from_um) };
        let name = format!("E{}{}", moved.letter(), of.letter());
        *to = stated(&section, &format!("{name}_{unit}"), bounds, convert)?;
        own_degrees(&section, &name, &mut found.own_degrees_of_freedom)?;
    }
    found.degrees_of_freedom = degrees_of_freedom(&section)?;
    section.finish(None)?;
    Ok(found)
}

/// Reads `[axis.*.drive.uncertainty]` and `[axis.*.friction.uncertainty]`, whose keys are known by then.
fn read_servo(axis: &Section<'_>, found: &mut AxisUncertainty) -> Result<(), FileError> {
    for (name, degrees) in ["drive", "friction"].into_iter().zip(&mut found.servo_degrees_of_freedom) {
        let Some(figures) = axis.section(name)? else { continue };
        let Some(section) = figures.section("uncertainty")? else { continue };
        *degrees = degrees_of_freedom(&section)?;
        for (to, figure) in found.servo.iter_mut().zip(Figure::ALL).filter(|(_, figure)| figure.section() == name) {
            let convert: fn(f64) -> f64 = match (figure, found.axis.is_rotary()) {
                (Figure::Presliding, false) => from_um,
                (Figure::Presliding, true) => degrees_from_urad,
                _ => same,
            };
            *to = stated(&section, figure.key(found.axis), &SERVO, convert)?;
        }
    }
    Ok(())
}
