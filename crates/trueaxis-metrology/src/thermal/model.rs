//! Curves in mm, °C and rpm, and their encoding as the task's file.

use core::fmt;
use std::string::String;
use std::vec::Vec;
use trueaxis::Axis;
use trueaxis::tcomp::checksum;
use trueaxis::temperature::{self, MAGIC, Thermal, ThermalError, VERSION};

/// A sensor: its lag, plausible readings, and the knots of its curves.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorCurve {
    /// Name.
    pub name: String,
    /// Lag, s.
    pub lag_s: f64,
    /// Least and greatest plausible temperature, °C.
    pub plausible_c: [f64; 2],
    /// Plausible sudden change, K, and change per minute, K.
    pub jump_k: [f64; 2],
    /// A sensor counts as stuck after this time without a change, s (0: never), if the others have moved by `elsewhere_k`, K.
    pub stuck_s: f64,
    /// See `stuck_s`.
    pub elsewhere_k: f64,
    /// Knots, °C, ascending.
    pub knots_c: Vec<f64>,
}

/// Response to the spindle's speed.
#[derive(Clone, Debug, PartialEq)]
pub struct Spindle {
    /// Lag, s.
    pub lag_s: f64,
    /// Knots, rpm, ascending from 0.
    pub knots_rpm: Vec<f64>,
}

/// Curves of one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisCurves {
    /// The axis.
    pub axis: Axis,
    /// Position at which the slope's contribution is zero, mm (degrees).
    pub datum: f64,
    /// For each sensor at each of its knots: offset, mm (degrees), and slope.
    pub sensors: Vec<Vec<[f64; 2]>>,
    /// At each speed: growth, mm (degrees), and tilt, rad; empty without a spindle.
    pub spindle: Vec<[f64; 2]>,
}

/// Thermal growth of a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Sensors, in the order in which the task receives their readings.
    pub sensors: Vec<SensorCurve>,
    /// The spindle, if its speed contributes.
    pub spindle: Option<Spindle>,
    /// Axes in the order X Y Z A B C.
    pub axes: Vec<AxisCurves>,
}

/// Why a model cannot be encoded.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum NotEncoded {
    /// A value is outside the range of the format.
    Figure {
        /// Name of the value.
        what: &'static str,
        /// The value, in the file's unit.
        found: f64,
    },
    /// A list's length differs from the number of knots.
    Count {
        /// Index of the axis' sensor or speed curve, from 0.
        index: usize,
        /// Number of values.
        found: usize,
        /// Number of knots.
        needed: usize,
    },
    /// The task's validation refuses the file.
    Refused(ThermalError),
}

impl fmt::Display for NotEncoded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Figure { what, found } => write!(f, "{what}: found {found}, beyond the range of the file's field"),
            Self::Count { index, found, needed } => {
                write!(f, "values of curve {}: found {found}, needed one for each of {needed} knots", index + 1)
            }
            Self::Refused(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for NotEncoded {}

fn whole(what: &'static str, value: f64, unit: f64) -> Result<i32, NotEncoded> {
    let found = (value / unit).round();
    // Also refuses NaN.
    if found.abs() <= f64::from(i32::MAX) { Ok(found as i32) } else { Err(NotEncoded::Figure { what, found }) }
}

fn positive(what: &'static str, value: f64, unit: f64) -> Result<[u8; 4], NotEncoded> {
    let found = whole(what, value, unit)?;
    u32::try_from(found).map(u32::to_le_bytes).map_err(|_| NotEncoded::Figure { what, found: found.into() })
}

impl Model {
    /// Encodes the task's file for the machine with this id ([`trueaxis::tcomp::machine_id`]).
    ///
    /// Values are rounded to the units of the format: mK, ms, 10⁻⁶ mm, 10⁻¹², nrad.
    ///
    /// # Errors
    /// [`NotEncoded`]; the encoded file is parsed again with the task's validation.
    pub fn encode(&self, machine_id: u32) -> Result<Vec<u8>, NotEncoded> {
        let count = |count: usize| u8::try_from(count).unwrap_or(u8::MAX);
        let speeds = self.spindle.as_ref().map_or(&[][..], |spindle| &spindle.knots_rpm);
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(machine_id.to_le_bytes());
        bytes.extend([count(self.sensors.len()), count(self.axes.len()), count(speeds.len()), 0]);
        bytes.extend(positive("lag of the spindle, ms", self.spindle.as_ref().map_or(0.0, |s| s.lag_s), 1e-3)?);
        for speed in speeds {
            bytes.extend(positive("speed, rpm", *speed, 1.0)?);
        }
        for sensor in &self.sensors {
            sensor.encode(&mut bytes)?;
        }
        for axis in &self.axes {
            self.encode_axis(axis, speeds.len(), &mut bytes)?;
        }
        bytes.extend(checksum(&bytes).to_le_bytes());
        Thermal::parse(&bytes).map_err(NotEncoded::Refused)?;
        Ok(bytes)
    }

    fn encode_axis(&self, axis: &AxisCurves, speeds: usize, bytes: &mut Vec<u8>) -> Result<(), NotEncoded> {
        let counts = self.sensors.iter().map(|sensor| sensor.knots_c.len());
        let given = axis.sensors.iter().map(Vec::len);
        if axis.sensors.len() != self.sensors.len() || axis.spindle.len() != speeds {
            let found = axis.sensors.len() + axis.spindle.len();
            return Err(NotEncoded::Count { index: 0, found, needed: self.sensors.len() + speeds });
        }
        if let Some((index, (found, needed))) = given.zip(counts).enumerate().find(|(_, (a, b))| a != b) {
            return Err(NotEncoded::Count { index, found, needed });
        }
        let datum = (1e6 * axis.datum).round();
        if datum.is_nan() || datum.abs() > 1e18 {
            return Err(NotEncoded::Figure { what: "datum", found: axis.datum });
        }
        bytes.push(axis.axis as u8);
        bytes.extend((datum as i64).to_le_bytes());
        for [offset, slope] in axis.sensors.iter().flatten() {
            bytes.extend(whole("offset, nm", *offset, 1e-6)?.to_le_bytes());
            bytes.extend(whole("slope, 1e-12", *slope, 1e-12)?.to_le_bytes());
        }
        for [growth, tilt] in &axis.spindle {
            bytes.extend(whole("growth of the spindle, nm", *growth, 1e-6)?.to_le_bytes());
            bytes.extend(whole("tilt of the spindle, nrad", *tilt, 1e-9)?.to_le_bytes());
        }
        Ok(())
    }
}

impl SensorCurve {
    /// Creates a curve with the usual plausibility limits: −30 to 120 °C, 3 K at once and 5 K a minute, never stuck.
    pub fn new(name: &str, lag_s: f64, knots_c: Vec<f64>) -> Self {
        SensorCurve {
            name: name.into(),
            lag_s,
            plausible_c: [-30.0, 120.0],
            jump_k: [3.0, 5.0],
            stuck_s: 0.0,
            elsewhere_k: 3.0,
            knots_c,
        }
    }

    fn encode(&self, bytes: &mut Vec<u8>) -> Result<(), NotEncoded> {
        bytes.extend(positive("lag, ms", self.lag_s, 1e-3)?);
        for limit in self.plausible_c {
            bytes.extend(whole("plausible temperature, mK", limit, 1e-3)?.to_le_bytes());
        }
        for change in self.jump_k {
            bytes.extend(positive("plausible change, mK", change, 1e-3)?);
        }
        bytes.extend(positive("time of a stuck sensor, ms", self.stuck_s, 1e-3)?);
        bytes.extend(positive("change of the others, mK", self.elsewhere_k, 1e-3)?);
        let knots = self.knots_c.len();
        if knots > temperature::KNOTS {
            return Err(NotEncoded::Refused(ThermalError::Knots(u8::try_from(knots).unwrap_or(u8::MAX))));
        }
        bytes.push(knots as u8);
        for knot in &self.knots_c {
            bytes.extend(whole("knot, mK", *knot, 1e-3)?.to_le_bytes());
        }
        Ok(())
    }
}
