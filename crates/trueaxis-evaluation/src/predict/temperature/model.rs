//! Growth lines of a machine from temperatures.

use super::record::Reading;
use crate::thermal::with_uncertainties;
use anyhow::{Result, anyhow, bail};
use std::path::Path;
use trueaxis::machine::{AXES, Axis};
use trueaxis::temperature::{Growth as Updated, Readings, SensorStatus, Thermal, ThermalState};
use trueaxis_tables::Machine;

/// Growth of an axis along itself, offset + slope (q − datum): mm, on a rotary axis degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Line {
    pub(crate) offset: f64,
    pub(crate) slope: f64,
    pub(crate) datum: f64,
}

/// Growth of the axes by [`Axis::index`].
pub(crate) type Lines = [Line; AXES];

impl Line {
    /// Growth at a position.
    pub(crate) fn at(&self, q: f64) -> f64 {
        self.offset + self.slope * (q - self.datum)
    }

    /// What has to be added to a position so that the axis arrives there in spite of its growth.
    pub(crate) fn correction(&self, q: f64) -> f64 {
        -self.at(q) / (1.0 + self.slope)
    }
}

/// How the machine's axes grow with its temperatures.
#[derive(Clone, Debug, PartialEq)]
pub struct GrowthModel {
    pub(super) by: By,
    /// Positions at which the slopes add nothing, by axis.
    datums: [f64; AXES],
    pub(super) reference_c: f64,
    /// Length of the tool from the spindle's nose, mm, where no record states it.
    pub(super) tool_mm: f64,
}

/// Where the growth is stated.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum By {
    /// One temperature, `[axis.X.thermal]` of machine.toml: offset and expansion per kelvin.
    Temperature([[f64; 2]; AXES]),
    /// Sensors with their lags, `thermal.toml`.
    Sensors(Sensors),
}

/// A `thermal.toml`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sensors {
    /// The task's file.
    bytes: Vec<u8>,
    pub(super) names: Vec<String>,
    pub(super) has_spindle: bool,
    /// Axes that it names, each with the standard uncertainty of its growth, mm, if stated.
    pub(super) axes: Vec<(Axis, Option<f64>)>,
}

impl GrowthModel {
    /// The growth that a machine states: the text of its `thermal.toml`, if it has one, with the file that errors name; else
    /// `[axis.X.thermal]` of its machine.toml.
    ///
    /// # Errors
    /// A text that is not a thermal model of this machine; a machine that states no growth.
    pub fn of(machine: &Machine, thermal: Option<(&str, &Path)>) -> Result<GrowthModel> {
        let mut datums = [0.0; AXES];
        let mut per_kelvin = [[0.0; 2]; AXES];
        for own in &machine.settings.axes {
            datums[own.axis.index()] = own.thermal.datum;
            per_kelvin[own.axis.index()] = [own.thermal.offset_per_k, own.thermal.expansion_per_k];
        }
        let by = match thermal {
            Some((text, file)) => {
                let (model, uncertainties) = with_uncertainties(text, file, &machine.settings)?;
                let bytes = model.encode(0).map_err(|error| anyhow!("{}: {error}", file.display()))?;
                By::Sensors(Sensors {
                    bytes,
                    names: model.sensors.into_iter().map(|sensor| sensor.name).collect(),
                    has_spindle: model.spindle.is_some(),
                    axes: uncertainties,
                })
            }
            None if per_kelvin == [[0.0; 2]; AXES] => bail!(
                "{}: found no growth of any axis, needed a thermal.toml beside machine.toml, or offset_um_per_k or \
                 expansion_um_per_m_k in [axis.X.thermal]",
                machine.settings.name
            ),
            None => By::Temperature(per_kelvin),
        };
        let [x, y, z] = machine.settings.tool_mm;
        let tool_mm = (x * x + y * y + z * z).sqrt();
        Ok(GrowthModel { by, datums, reference_c: machine.settings.reference_temperature_c, tool_mm })
    }

    /// The sensors that it needs; none if it takes one temperature.
    pub(super) fn sensors(&self) -> &[String] {
        match &self.by {
            By::Temperature(_) => &[],
            By::Sensors(own) => &own.names,
        }
    }

    /// Whether it takes the spindle's speed.
    pub(super) fn needs_spindle(&self) -> bool {
        matches!(&self.by, By::Sensors(own) if own.has_spindle)
    }

    /// Growth at every reading, whose temperatures are in the order of [`GrowthModel::sensors`], and whether a sensor is beyond
    /// the ends of its curves. It starts in equilibrium.
    ///
    /// # Errors
    /// The index of a reading that the controller's task does not take, and why.
    pub(super) fn lines(&self, readings: &[Reading]) -> Result<(Vec<Lines>, bool), (usize, String)> {
        match &self.by {
            By::Temperature(per_kelvin) => {
                let of = |reading: &Reading| {
                    let kelvin = reading.temperatures_c.first().map_or(0.0, |celsius| celsius - self.reference_c);
                    self.line(|axis| per_kelvin[axis].map(|per_kelvin| kelvin * per_kelvin))
                };
                Ok((readings.iter().map(of).collect(), false))
            }
            By::Sensors(own) => self.updated(own, readings),
        }
    }

    fn line(&self, of: impl Fn(usize) -> [f64; 2]) -> Lines {
        std::array::from_fn(|axis| {
            let [offset, slope] = of(axis);
            Line { offset, slope, datum: self.datums[axis] }
        })
    }

    /// The growth that the controller's task computes.
    fn updated(&self, own: &Sensors, readings: &[Reading]) -> Result<(Vec<Lines>, bool), (usize, String)> {
        let thermal = Thermal::parse(&own.bytes).map_err(|error| (0, error.to_string()))?;
        let mut state = ThermalState::new();
        (0..own.names.len()).for_each(|sensor| state.accept(sensor));
        let (mut lines, mut beyond, mut before) = (Vec::with_capacity(readings.len()), false, None);
        for (index, reading) in readings.iter().enumerate() {
            let temperatures: Vec<Option<f64>> = reading.temperatures_c.iter().map(|celsius| Some(*celsius)).collect();
            let dt_s = before.map_or(0.0, |before| reading.t_s - before);
            before = Some(reading.t_s);
            let readings = Readings {
                temperatures_c: &temperatures,
                spindle_rpm: Some(reading.spindle_rpm),
                tool_mm: reading.tool_mm,
            };
            let growth = thermal.update(&mut state, dt_s, &readings);
            if !growth.is_good() {
                return Err((index, fault(&growth, &own.names)));
            }
            beyond |= growth.at_edge != 0;
            lines.push(self.line(|axis| growth.lines[axis].unwrap_or([0.0; 2])));
        }
        Ok((lines, beyond))
    }
}

/// What the task finds wrong.
fn fault(growth: &Updated, names: &[String]) -> String {
    let bad = growth.sensors.iter().zip(names).find(|(status, _)| **status != SensorStatus::Good);
    let Some((status, name)) = bad else { return String::from("a growth of more than 10 mm or 1e-3") };
    let what = match status {
        SensorStatus::OutOfRange => "is out of its plausible range",
        SensorStatus::Jumped => "has jumped",
        SensorStatus::Stuck => "is stuck",
        _ => "has no good reading",
    };
    format!("sensor {name} {what}")
}
