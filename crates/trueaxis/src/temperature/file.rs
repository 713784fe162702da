//! The file: settings of the task, checked and read in place.

use super::ThermalError;
use super::bytes::{Bytes, pair};
use super::sensor::{Sensor, knots, time};
use super::{FASTEST_RPM, MAGIC, SENSORS, STEEPEST, VERSION};
use crate::axis::{AXES, Axis};
use crate::tcomp::checksum;

/// Settings of the thermal task, checked; the curves stay in the file's bytes.
#[derive(Clone, Copy, Debug)]
pub struct Thermal<'a> {
    machine_id: u32,
    crc: u32,
    pub(super) spindle_lag_s: f64,
    pub(super) speeds: &'a [[u8; 4]],
    sensors: u8,
    axes: u8,
    /// The bytes from the first sensor on.
    body: Bytes<'a>,
}

/// Data of one axis in the file.
#[derive(Clone, Copy, Debug)]
pub(super) struct OfAxis<'a> {
    pub(super) axis: Axis,
    pub(super) datum: f64,
    /// Offset and slope at the knots of all sensors, in sequence.
    pub(super) curves: &'a [[u8; 8]],
    /// Growth and tilt at the speeds.
    pub(super) spindle: &'a [[u8; 8]],
}

impl<'a> Thermal<'a> {
    /// Reads and checks a whole file: its form, its checksum, its values.
    ///
    /// Allocates nothing and never panics, whatever the bytes. Cost: linear in the file's length.
    ///
    /// # Errors
    /// The first defect found.
    pub fn parse(file: &'a [u8]) -> Result<Self, ThermalError> {
        let mut bytes = Bytes(file);
        if bytes.magic()? != MAGIC {
            return Err(ThermalError::Magic);
        }
        if bytes.u16()? != VERSION {
            return Err(ThermalError::Version);
        }
        let sum = file.last_chunk::<4>().map(|sum| u32::from_le_bytes(*sum));
        let crc = sum.ok_or(ThermalError::TooShort)?;
        if file.get(..file.len().saturating_sub(4)).map(checksum) != Some(crc) {
            return Err(ThermalError::Checksum);
        }
        let machine_id = bytes.u32()?;
        let (sensors, axes, speeds, zero) = (bytes.u8()?, bytes.u8()?, bytes.u8()?, bytes.u8()?);
        if usize::from(sensors) > SENSORS {
            return Err(ThermalError::Sensors(sensors));
        }
        if !(1..=AXES).contains(&usize::from(axes)) {
            return Err(ThermalError::Axes(axes));
        }
        if zero != 0 {
            return Err(ThermalError::NotZero(zero.into()));
        }
        let spindle_lag_s = time(bytes.u32()?)?;
        let speeds = bytes.pieces(if speeds == 0 { 0 } else { knots(speeds)? })?;
        check_speeds(speeds)?;
        let thermal = Thermal { machine_id, crc, spindle_lag_s, speeds, sensors, axes, body: bytes };
        thermal.check()?;
        Ok(thermal)
    }

    fn check(&self) -> Result<(), ThermalError> {
        let mut bytes = self.body;
        let mut curves = 0_usize;
        for number in 1..=self.sensors {
            curves = curves.saturating_add(Sensor::read(&mut bytes, number)?.knots());
        }
        let mut before = None;
        for _ in 0..self.axes {
            let axis = read_axis(&mut bytes, curves, self.speeds.len())?;
            if before >= Some(axis.axis) {
                return Err(ThermalError::Axis(axis.axis as u8));
            }
            before = Some(axis.axis);
            if let Some([_, slope]) =
                axis.curves.iter().map(pair).find(|[_, slope]| slope.unsigned_abs() > STEEPEST as u32)
            {
                return Err(ThermalError::Slope(slope));
            }
            let at_rest = axis.spindle.first().map_or([0; 2], pair);
            if let Some(found) = at_rest.into_iter().find(|value| *value != 0) {
                return Err(ThermalError::NotZero(found));
            }
        }
        bytes.u32()?;
        if bytes.0.is_empty() { Ok(()) } else { Err(ThermalError::TooLong) }
    }

    /// Refuses the file on any machine except the one with this id ([`crate::Tcomp::machine_id`]).
    ///
    /// # Errors
    /// [`ThermalError::WrongMachine`], with both ids.
    pub fn expect_machine(&self, id: u32) -> Result<(), ThermalError> {
        let found = self.machine_id;
        if found == id { Ok(()) } else { Err(ThermalError::WrongMachine { found, needed: id }) }
    }

    /// Id of the machine.
    pub fn machine_id(&self) -> u32 {
        self.machine_id
    }

    /// Checksum at the end of the file.
    pub fn crc(&self) -> u32 {
        self.crc
    }

    /// Number of sensors, in the order of [`super::Readings::temperatures_c`].
    pub fn sensors(&self) -> usize {
        self.sensors.into()
    }

    /// Whether the spindle's speed contributes to the growth.
    pub fn has_spindle(&self) -> bool {
        !self.speeds.is_empty()
    }

    /// The axes that grow, each with its datum q0, mm (degrees).
    pub fn axes(&self) -> impl Iterator<Item = (Axis, f64)> + '_ {
        self.each_axis().map(|of| (of.axis, of.datum))
    }

    /// All sensors in order; reading them cannot fail, since the file was checked.
    pub(super) fn each_sensor(&self) -> impl Iterator<Item = Sensor<'a>> + 'a {
        let mut bytes = self.body;
        (1..=self.sensors).map_while(move |number| Sensor::read(&mut bytes, number).ok())
    }

    /// All axes in order; reading them cannot fail, since the file was checked.
    pub(super) fn each_axis(&self) -> impl Iterator<Item = OfAxis<'a>> + 'a {
        let (mut bytes, mut curves) = (self.body, 0_usize);
        for number in 1..=self.sensors {
            curves = curves.saturating_add(Sensor::read(&mut bytes, number).map_or(0, |sensor| sensor.knots()));
        }
        let speeds = self.speeds.len();
        (0..self.axes).map_while(move |_| read_axis(&mut bytes, curves, speeds).ok())
    }
}

fn check_speeds(speeds: &[[u8; 4]]) -> Result<(), ThermalError> {
    let mut before = None;
    for (k, speed) in speeds.iter().enumerate() {
        let speed = u32::from_le_bytes(*speed);
        if speed > FASTEST_RPM || before >= Some(speed) || (k == 0 && speed != 0) {
            return Err(ThermalError::KnotOrder(i32::try_from(speed).unwrap_or(i32::MAX)));
        }
        before = Some(speed);
    }
    Ok(())
}

fn read_axis<'a>(bytes: &mut Bytes<'a>, curves: usize, speeds: usize) -> Result<OfAxis<'a>, ThermalError> {
    let number = bytes.u8()?;
    let axis = Axis::ALL.get(usize::from(number)).copied().ok_or(ThermalError::Axis(number))?;
    let datum = 1e-6 * bytes.i64()? as f64;
    Ok(OfAxis { axis, datum, curves: bytes.pieces(curves)?, spindle: bytes.pieces(speeds)? })
}
