//! Reading `thermal.toml`.

use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;
use trueaxis::Axis;
use trueaxis::machine::MachineSettings;
use trueaxis_metrology::thermal::{AxisCurves, Model, SensorCurve, Spindle};
use trueaxis_tables::error::FileError;
use trueaxis_tables::text::{counted, line_at};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    reference_temperature_c: Spanned<f64>,
    #[serde(default)]
    sensor: Vec<Sensor>,
    spindle: Option<SpindleSection>,
    axis: Spanned<BTreeMap<String, AxisSection>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Sensor {
    name: Spanned<String>,
    #[serde(default)]
    lag_s: f64,
    plausible_c: Option<[f64; 2]>,
    jump_k: Option<f64>,
    rate_k_per_min: Option<f64>,
    stuck_s: Option<f64>,
    elsewhere_k: Option<f64>,
    knots_c: Spanned<Vec<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SpindleSection {
    lag_s: f64,
    knots_rpm: Spanned<Vec<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AxisSection {
    datum_mm: Option<Spanned<f64>>,
    datum_deg: Option<Spanned<f64>>,
    uncertainty_um: Option<Spanned<f64>>,
    uncertainty_urad: Option<Spanned<f64>>,
    #[serde(default)]
    sensor: BTreeMap<String, Spanned<SensorCurves>>,
    spindle: Option<Spanned<SpindleCurves>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SensorCurves {
    offset_um: Option<Vec<f64>>,
    slope_um_per_m: Option<Vec<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SpindleCurves {
    growth_um: Option<Vec<f64>>,
    tilt_urad: Option<Vec<f64>>,
}

/// Builds refusals at a place in the text.
struct Place<'t> {
    file: &'t Path,
    text: &'t str,
}

impl Place<'_> {
    fn at(&self, offset: usize, key: &str, found: impl ToString, needed: impl ToString) -> FileError {
        FileError {
            file: self.file.into(),
            line: Some(line_at(self.text, offset)),
            column: Some(key.into()),
            found: found.to_string(),
            needed: needed.to_string(),
        }
    }
}

/// Reads the text of a `thermal.toml` for a machine; `file` is only named in errors.
///
/// # Errors
/// The error and its line: an invalid key, an axis that the machine does not have, a curve whose number of values differs from
/// that of its knots, a reference temperature or datum other than the machine's, for which its tables are valid.
pub fn model(text: &str, file: &Path, machine: &MachineSettings) -> Result<Model, FileError> {
    with_uncertainties(text, file, machine).map(|(model, _)| model)
}

/// As [`model`], with the axes of the model and the standard uncertainty of each axis' growth, mm or degrees, where stated.
///
/// # Errors
/// As [`model`]; an uncertainty outside 0 to 1000 µm.
#[expect(clippy::type_complexity, reason = "one caller beside `model`")]
pub(crate) fn with_uncertainties(
    text: &str,
    file: &Path,
    machine: &MachineSettings,
) -> Result<(Model, Vec<(Axis, Option<f64>)>), FileError> {
    let place = Place { file, text };
    let read: File = toml::from_str(text).map_err(|error| {
        let span = error.span().unwrap_or(0..0);
        let found = text.get(span.clone()).unwrap_or_default().lines().next().unwrap_or_default();
        place.at(span.start, "", format!("{found:?}"), format!("a thermal.toml: {}", error.message()))
    })?;
    let reference = *read.reference_temperature_c.get_ref();
    if reference != machine.reference_temperature_c {
        let needed = format!("{}, as the machine's tables", machine.reference_temperature_c);
        return Err(place.at(read.reference_temperature_c.span().start, "reference_temperature_c", reference, needed));
    }
    let mut sensors: Vec<SensorCurve> = Vec::new();
    for sensor in &read.sensor {
        let name = sensor.name.get_ref();
        if name.is_empty() || sensors.iter().any(|known| known.name == *name) {
            return Err(place.at(sensor.name.span().start, "sensor.name", name, "a unique name"));
        }
        let knots = sensor.knots_c.get_ref();
        ascending(&place, &sensor.knots_c, "sensor.knots_c")?;
        let plain = SensorCurve::new(name, sensor.lag_s, knots.clone());
        sensors.push(SensorCurve {
            plausible_c: sensor.plausible_c.unwrap_or(plain.plausible_c),
            jump_k: [sensor.jump_k.unwrap_or(plain.jump_k[0]), sensor.rate_k_per_min.unwrap_or(plain.jump_k[1])],
            stuck_s: sensor.stuck_s.unwrap_or(plain.stuck_s),
            elsewhere_k: sensor.elsewhere_k.unwrap_or(plain.elsewhere_k),
            ..plain
        });
    }
    let spindle = match &read.spindle {
        None => None,
        Some(section) => {
            ascending(&place, &section.knots_rpm, "spindle.knots_rpm")?;
            let knots = section.knots_rpm.get_ref();
            if knots.first() != Some(&0.0) {
                let found = format!("{knots:?}");
                return Err(place.at(
                    section.knots_rpm.span().start,
                    "spindle.knots_rpm",
                    found,
                    "knots from 0 rpm on",
                ));
            }
            Some(Spindle { lag_s: section.lag_s, knots_rpm: knots.clone() })
        }
    };
    let (mut axes, mut uncertainties) = (Vec::new(), Vec::new());
    for (letter, section) in read.axis.get_ref() {
        let axis = letter.parse().ok().and_then(Axis::from_letter).filter(|axis| machine.axis(*axis).is_some());
        let Some(axis) = axis else {
            let needed = format!("an axis of the chain {}", machine.chain);
            return Err(place.at(read.axis.span().start, &format!("axis.{letter}"), letter, needed));
        };
        axes.push(of_axis(&place, axis, section, &sensors, spindle.as_ref(), machine)?);
        uncertainties.push((axis, uncertainty(&place, axis, section)?));
    }
    axes.sort_by_key(|of| of.axis);
    uncertainties.sort_by_key(|(axis, _)| *axis);
    Ok((Model { sensors, spindle, axes }, uncertainties))
}

/// Standard uncertainty of an axis' growth, which is not compiled.
fn uncertainty(place: &Place<'_>, axis: Axis, section: &AxisSection) -> Result<Option<f64>, FileError> {
    let (unit, other) = if axis.is_rotary() { ("urad", "um") } else { ("um", "urad") };
    let all = [&section.uncertainty_um, &section.uncertainty_urad];
    let [own, wrong] = if axis.is_rotary() { [all[1], all[0]] } else { all };
    let key = |unit: &str| format!("axis.{}.uncertainty_{unit}", axis.letter());
    if let Some(wrong) = wrong {
        return Err(place.at(wrong.span().start, &key(other), wrong.get_ref(), key(unit)));
    }
    let Some(own) = own else { return Ok(None) };
    let value = *own.get_ref();
    if !(0.0..=1000.0).contains(&value) {
        return Err(place.at(
            own.span().start,
            &key(unit),
            value,
            format!("a standard uncertainty of 0 to 1000 {unit}"),
        ));
    }
    Ok(Some(if axis.is_rotary() { (1e-6 * value).to_degrees() } else { 1e-3 * value }))
}

fn ascending(place: &Place<'_>, knots: &Spanned<Vec<f64>>, key: &str) -> Result<(), FileError> {
    let own = knots.get_ref();
    let sound = (2..=trueaxis::temperature::KNOTS).contains(&own.len())
        && own.iter().all(|knot| knot.is_finite())
        && own.windows(2).all(|pair| pair[0] < pair[1]);
    let needed = format!("2 to {} ascending knots", trueaxis::temperature::KNOTS);
    if sound { Ok(()) } else { Err(place.at(knots.span().start, key, format!("{own:?}"), needed)) }
}

fn of_axis(
    place: &Place<'_>,
    axis: Axis,
    section: &AxisSection,
    sensors: &[SensorCurve],
    spindle: Option<&Spindle>,
    machine: &MachineSettings,
) -> Result<AxisCurves, FileError> {
    let letter = axis.letter();
    let needed = machine.axis(axis).map_or(0.0, |of| of.thermal.datum);
    let given = if axis.is_rotary() { &section.datum_deg } else { &section.datum_mm };
    let datum = given.as_ref().map_or(needed, |datum| *datum.get_ref());
    if let Some(given) = given.as_ref().filter(|_| datum != needed) {
        let key = format!("axis.{letter}.datum_{}", if axis.is_rotary() { "deg" } else { "mm" });
        let needed = format!("{needed}, the datum of [axis.{letter}.thermal] in machine.toml");
        return Err(place.at(given.span().start, &key, datum, needed));
    }
    let known = |name: &String| sensors.iter().any(|sensor| sensor.name == *name);
    if let Some((name, curve)) = section.sensor.iter().find(|(name, _)| !known(name)) {
        let key = format!("axis.{letter}.sensor.{name}");
        return Err(place.at(curve.span().start, &key, name, "the name of a [[sensor]]"));
    }
    // µm and µm/m; for a rotary axis µrad and µrad/rad, its positions in degrees.
    let small = if axis.is_rotary() { 1e-6_f64.to_degrees() } else { 1e-3 };
    let curve = |key: &str, offset: usize, knots: usize, given: [&Option<Vec<f64>>; 2]| {
        let mut values = vec![[0.0; 2]; knots];
        for (part, (given, scale)) in given.into_iter().zip([small, 1e-6]).enumerate() {
            let Some(given) = given else { continue };
            if given.len() != knots {
                let needed = format!("one for each of {knots} knots");
                let key = format!("axis.{letter}.{key}");
                return Err(place.at(offset, &key, counted(given.len(), "value"), needed));
            }
            for (value, given) in values.iter_mut().zip(given) {
                value[part] = scale * given;
            }
        }
        Ok(values)
    };
    let of_sensor = |sensor: &SensorCurve| {
        let knots = sensor.knots_c.len();
        let Some(own) = section.sensor.get(&sensor.name) else { return Ok(vec![[0.0; 2]; knots]) };
        let (offset, own) = (own.span().start, own.get_ref());
        curve(&format!("sensor.{}", sensor.name), offset, knots, [&own.offset_um, &own.slope_um_per_m])
    };
    let speeds = spindle.map_or(0, |spindle| spindle.knots_rpm.len());
    let of_spindle = match &section.spindle {
        None => vec![[0.0; 2]; speeds],
        Some(own) => {
            let (offset, own) = (own.span().start, own.get_ref());
            curve("spindle", offset, speeds, [&own.growth_um, &own.tilt_urad])?
        }
    };
    Ok(AxisCurves {
        axis,
        datum,
        sensors: sensors.iter().map(of_sensor).collect::<Result<_, FileError>>()?,
        spindle: of_spindle,
    })
}
