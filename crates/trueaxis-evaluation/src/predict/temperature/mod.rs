//! Growth of the machine and of the part while the part is cut.
//!
//! ```text
//! K(q, t) = O(t) + S(t) (q − q0)       growth of an axis, actual − ideal, from the machine's temperatures until t
//! c(q, t) = −K(q + c, t)               what the thermal compensation adds, with the same temperatures
//! p       = p_cut / (1 + α (T_p − 20 °C))     the part when it is measured, about the program's zero
//! ```
//!
//! Uncorrected, the drives get no c; corrected they do, as far as the limits of the axes admit. What is not known of K then
//! remains: the sensors, the coefficients, and what the model of the growth itself leaves. It is taken as the same for the
//! whole part.

mod document;
mod known;
mod model;
mod part;
mod record;
mod warm;

pub(super) use document::document;
pub use document::{AxisGrowth, SensorTemperature, SetupStart, TemperatureDocument};
pub(super) use known::{add_terms, part_length};
pub use model::GrowthModel;
pub(super) use model::Lines;
pub(super) use part::read_temperature;
pub use part::{Expansion, PartTemperature};
pub use record::{TEMPERATURES, TemperatureRecord};
pub(super) use warm::Warm;

use anyhow::Result;
use model::Line;
use record::Reading;
use std::path::PathBuf;
use trueaxis_tables::error::FileError;

/// A day, s.
const DAY_S: f64 = 86_400.0;

/// When a program starts in a record of temperatures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// So many seconds after its first row.
    After(f64),
    /// At this `t_s` of a record whose times count from midnight.
    At(f64),
}

impl Start {
    /// Seconds since midnight of a time on the clock, `HH:MM`.
    pub fn clock(text: &str) -> Option<f64> {
        let (hours, minutes) = text.split_once(':')?;
        let is_number = |digits: &str| digits.bytes().all(|of| of.is_ascii_digit());
        let part =
            |digits: &str, most: u32| digits.parse::<u32>().ok().filter(|found| is_number(digits) && *found <= most);
        let minutes = part(minutes, 59).filter(|_| minutes.len() == 2)?;
        Some(f64::from(3600 * part(hours, 23)? + 60 * minutes))
    }
}

/// Growth of a machine while a part is cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Growth {
    model: GrowthModel,
    /// In the order of the model's sensors; times count from the start of the first program. One alone: a constant temperature.
    readings: Vec<Reading>,
    /// The line of every reading.
    lines: Vec<Lines>,
    /// Whether a sensor is beyond the ends of its curves.
    is_beyond: bool,
    record: Option<Recorded>,
}

/// Where the temperatures were recorded.
#[derive(Clone, Debug, PartialEq)]
struct Recorded {
    file: PathBuf,
    /// `t_s` of the first row.
    first_s: f64,
    /// Start of the first program after the first row, s.
    start_s: f64,
    /// Names of the sensors.
    sensors: Vec<String>,
    /// Sensors of the record that the model does not take.
    unused: Vec<String>,
}

impl Growth {
    /// Growth of a machine that has long had this temperature, at every sensor, with its spindle at rest.
    ///
    /// Cost: one update of the thermal task.
    ///
    /// # Errors
    /// A temperature that the model does not take.
    pub fn constant(model: GrowthModel, machine_c: f64) -> Result<Growth> {
        let temperatures_c = vec![machine_c; model.sensors().len().max(1)];
        let reading = Reading { t_s: 0.0, temperatures_c, spindle_rpm: 0.0, tool_mm: model.tool_mm, line: 0 };
        let (lines, is_beyond) = model.lines(std::slice::from_ref(&reading)).map_err(|(_, found)| {
            anyhow::anyhow!("machine_c: found {machine_c}, {found}; needed a temperature that the thermal model takes")
        })?;
        Ok(Growth { model, readings: vec![reading], lines, is_beyond, record: None })
    }

    /// Growth of a machine while its temperatures are those of a record; before the record it was in equilibrium.
    ///
    /// # Errors
    /// A record without a sensor or the speed that the model needs, or with a reading that the controller's task does not take;
    /// a start outside the record.
    pub fn recorded(model: GrowthModel, record: &TemperatureRecord, start: Start) -> Result<Growth> {
        let refused = |line: Option<u32>, column: &str, found: String, needed: String| {
            let column = (!column.is_empty()).then(|| column.to_owned());
            FileError { file: record.file.clone(), line, column, found, needed }
        };
        let mut sensors = model.sensors().to_vec();
        if sensors.is_empty() {
            sensors.extend(record.sensors.first().cloned());
        }
        let columns = || format!("temperatures {}", record.sensors.join(", "));
        let place = |name: &String| {
            let found = record.sensors.iter().position(|own| own == name);
            found.ok_or_else(|| {
                refused(Some(1), "", columns(), format!("the column {name}_c, a sensor of thermal.toml"))
            })
        };
        let places = sensors.iter().map(place).collect::<Result<Vec<_>, _>>()?;
        if model.needs_spindle() && !record.has_spindle {
            let needed = "the column spindle_rpm, which thermal.toml takes";
            return Err(refused(Some(1), "", columns(), needed.into()).into());
        }
        let [first, last] = [record.readings.first(), record.readings.last()].map(|of| of.map_or(0.0, |of| of.t_s));
        let at = match start {
            Start::After(seconds) => first + seconds,
            // After midnight, t_s goes on.
            Start::At(seconds) if seconds < first && seconds + DAY_S <= last => seconds + DAY_S,
            Start::At(seconds) => seconds,
        };
        if !(first..=last).contains(&at) {
            let line = record.readings.last().map(|of| of.line);
            let found = format!("a program that starts at {at} s");
            return Err(refused(line, "t_s", found, format!("a start within the record, {first} to {last} s")).into());
        }
        let of = |reading: &Reading| Reading {
            t_s: reading.t_s - at,
            temperatures_c: places.iter().map(|place| reading.temperatures_c[*place]).collect(),
            tool_mm: if record.has_tool { reading.tool_mm } else { model.tool_mm },
            ..reading.clone()
        };
        let readings: Vec<Reading> = record.readings.iter().map(of).collect();
        let (lines, is_beyond) = model.lines(&readings).map_err(|(index, found)| {
            let line = readings.get(index).map(|of| of.line);
            refused(line, "", found, "readings that the thermal task of the controller takes".into())
        })?;
        let unused = record.sensors.iter().filter(|name| !sensors.contains(name)).cloned().collect();
        let recorded = Recorded { file: record.file.clone(), first_s: first, start_s: at - first, sensors, unused };
        Ok(Growth { model, readings, lines, is_beyond, record: Some(recorded) })
    }

    /// Whether it follows a record.
    pub(super) fn is_recorded(&self) -> bool {
        self.record.is_some()
    }

    /// Growth at a time since the start of the first program, s: between two readings in proportion to time.
    pub(super) fn at(&self, t_s: f64) -> Lines {
        between(
            &self.readings,
            t_s,
            |index| self.lines[index],
            |early, late, share| {
                std::array::from_fn(|axis| {
                    let [early, late]: [Line; 2] = [early[axis], late[axis]];
                    let mix = |from: f64, to: f64| from + share * (to - from);
                    let (offset, slope) = (mix(early.offset, late.offset), mix(early.slope, late.slope));
                    Line { offset, slope, datum: early.datum }
                })
            },
        )
    }

    /// Refuses a record that ends before the last cut.
    fn lasts(&self, until_s: f64) -> Result<(), FileError> {
        let (Some(record), Some(last)) = (&self.record, self.readings.last()) else { return Ok(()) };
        if until_s <= last.t_s {
            return Ok(());
        }
        let time = |of: f64| format!("{:.1} s", of);
        let begun = last.t_s + record.start_s;
        Err(FileError {
            file: record.file.clone(),
            line: Some(last.line),
            column: Some("t_s".into()),
            found: format!("the last row {} after the first", time(begun)),
            needed: format!(
                "rows until {}: the program starts at {} and the last feature is cut {} later",
                time(record.start_s + until_s),
                time(record.start_s),
                time(until_s)
            ),
        })
    }
}

/// A value at a time between two readings; that of the first or last one beyond them.
fn between<T>(readings: &[Reading], t_s: f64, value: impl Fn(usize) -> T, mix: impl FnOnce(T, T, f64) -> T) -> T {
    let after = readings.partition_point(|reading| reading.t_s <= t_s);
    let last = readings.len() - 1;
    match after {
        0 => value(0),
        after if after > last => value(last),
        after => {
            let [early, late] = [readings[after - 1].t_s, readings[after].t_s];
            mix(value(after - 1), value(after), (t_s - early) / (late - early))
        }
    }
}
