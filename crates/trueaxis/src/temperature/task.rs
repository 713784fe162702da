//! The thermal task: converts readings to growth lines.

use super::bytes::pair;
use super::file::{OfAxis, Thermal};
use super::lag::{Decay, place};
use super::sensor::{SensorState, SensorStatus};
use super::{KNOTS, LONGEST_TOOL_MM, LONGEST_UPDATE_S, SENSORS};
use crate::axis::{AXES, Axis};
use crate::compensation::ThermalLine;
use crate::real::Real;

/// Inputs of an update.
#[derive(Clone, Copy, Debug)]
pub struct Readings<'r> {
    /// Temperatures in the order of the file, °C; `None` without a reading. Absent entries count as missing.
    pub temperatures_c: &'r [Option<f64>],
    /// Speed of the spindle, rpm, in either sense; `None` if it is not known.
    pub spindle_rpm: Option<f64>,
    /// Length of the tool from the spindle's nose, mm: the lever of its tilt.
    pub tool_mm: f64,
}

/// Growth after an update.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Growth {
    /// Offset, mm (degrees), and slope of the line of each axis; `None` for an axis that the file does not name.
    pub lines: [Option<[f64; 2]>; AXES],
    /// State of each sensor.
    pub sensors: [SensorStatus; SENSORS],
    /// Sensors (bit 0: the first) beyond the ends of their curves, where the edge value applies.
    pub at_edge: u16,
    /// Whether the spindle's speed is missing: its share then does not change.
    pub spindle_missing: bool,
    /// Axes (bit 0: X) whose growth exceeds the limit of the step: they keep the previous line.
    pub beyond: u8,
    /// Whether every sensor has started. Until then all lines are zero: a growth from only some sensors is worse than
    /// none.
    pub complete: bool,
}

impl Growth {
    /// Returns the line of an axis for the step; `None` for an axis that the file does not name.
    pub fn line<R: Real>(&self, axis: Axis) -> Option<ThermalLine<R>> {
        let [offset, slope] = self.lines.get(axis.index()).copied().flatten()?;
        ThermalLine::new(offset, slope)
    }

    /// Whether every sensor and the spindle's speed are good, and the step accepts every growth.
    pub fn is_good(&self) -> bool {
        let sensors = self.sensors.iter().all(|status| *status == SensorStatus::Good);
        sensors && self.complete && !self.spindle_missing && self.beyond == 0
    }
}

/// State that one update passes to the next.
///
/// It starts in equilibrium: temperatures equal to the readings with which every sensor starts, the spindle long at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ThermalState {
    sensors: [SensorState; SENSORS],
    /// Share of every knot of the speed, in the last update and behind the lag.
    shares: [f64; KNOTS],
    responses: [f64; KNOTS],
    lines: [[f64; 2]; AXES],
}

impl ThermalState {
    /// The state before the first update.
    pub fn new() -> Self {
        Self::default()
    }

    /// Accepts the next plausible reading of a sensor (from 0) that has jumped, for example after it was replaced, or
    /// that is known to be sound before its first reading; the growth changes through its lag.
    pub fn accept(&mut self, sensor: usize) {
        if let Some(state) = self.sensors.get_mut(sensor) {
            state.accept();
        }
    }

    /// Temperatures behind their lags, °C; 0 for a sensor never read.
    pub fn lagged_c(&self) -> [f64; SENSORS] {
        self.sensors.map(|state| state.lagged)
    }
}

/// Place of a sensor's temperature on its curves.
#[derive(Clone, Copy)]
struct Place {
    /// Index of the cell's first knot among all sensors' knots, and the fraction within the cell.
    knot: usize,
    share: f64,
}

impl Thermal<'_> {
    /// Returns the growth after `dt_s` more seconds with these readings.
    ///
    /// Readings are assumed linear in time since the last update, so the interval may have any length from a cycle to
    /// a day; after a longer one the task restarts. An interval that is NaN or not above zero changes only the status of
    /// the sensors and the tool's length. Bounded time: an exponential and a search among 8 knots per sensor, a sum over
    /// sensors and axes. Allocates nothing, never panics.
    pub fn update(&self, state: &mut ThermalState, dt_s: f64, readings: &Readings<'_>) -> Growth {
        if dt_s > LONGEST_UPDATE_S {
            *state = ThermalState::new();
        }
        let dt_s = if dt_s > 0.0 && dt_s <= LONGEST_UPDATE_S { dt_s } else { 0.0 };
        let mut growth = Growth {
            lines: [None; AXES],
            sensors: [SensorStatus::Good; SENSORS],
            at_edge: 0,
            spindle_missing: self.turn(state, dt_s, readings.spindle_rpm),
            beyond: 0,
            complete: true,
        };
        let places = self.sense(state, dt_s, readings.temperatures_c, &mut growth);
        let tool_mm = readings.tool_mm.limit(0.0, LONGEST_TOOL_MM);
        for (of, axis) in self.each_axis().map(|of| (of, of.axis.index())) {
            let [offset, slope] = self.line(&of, state, &places, tool_mm);
            let (Some(kept), Some(line)) = (state.lines.get_mut(axis), growth.lines.get_mut(axis)) else { continue };
            if !growth.complete {
                *kept = [0.0; 2];
            } else if ThermalLine::<f64>::new(offset, slope).is_some() {
                *kept = [offset, slope];
            } else {
                growth.beyond |= 1 << axis;
            }
            *line = Some(*kept);
        }
        growth
    }

    /// Updates the spindle's response; returns whether its speed is missing.
    fn turn(&self, state: &mut ThermalState, dt_s: f64, rpm: Option<f64>) -> bool {
        if !self.has_spindle() {
            return false;
        }
        let Some(rpm) = rpm.filter(|rpm| rpm.is_finite()) else { return true };
        let knots = self.speeds.iter().map(|speed| f64::from(u32::from_le_bytes(*speed)));
        let (cell, share, _) = place(knots, rpm.abs());
        let decay = Decay::new(dt_s, self.spindle_lag_s);
        for (k, (before, response)) in state.shares.iter_mut().zip(&mut state.responses).enumerate() {
            let now = if k == cell {
                1.0 - share
            } else if k == cell.saturating_add(1) {
                share
            } else {
                0.0
            };
            *response = decay.respond(*response, *before, now);
            *before = now;
        }
        false
    }

    /// Judges every sensor, updates its lag and finds its place on the curves.
    fn sense(
        &self,
        state: &mut ThermalState,
        dt_s: f64,
        temperatures: &[Option<f64>],
        growth: &mut Growth,
    ) -> [Place; SENSORS] {
        let known = || state.sensors.iter().filter_map(|sensor| sensor.good);
        let (sum, count) = known().fold((0.0, 0.0), |(sum, count), good| (sum + good, count + 1.0));
        let mut places = [Place { knot: 0, share: 0.0 }; SENSORS];
        let mut first = 0_usize;
        let readings = temperatures.iter().copied().chain(core::iter::repeat(None));
        let each = self.each_sensor().zip(&mut state.sensors).zip(readings).zip(&mut places).zip(&mut growth.sensors);
        for (bit, ((((sensor, own), reading), at), status)) in each.enumerate() {
            let others = own.good.map_or((sum, count), |good| (sum - good, count - 1.0));
            own.update(&sensor, dt_s, reading, (others.1 > 0.0).then(|| others.0 / others.1));
            *status = own.status;
            growth.complete &= own.good.is_some();
            let (cell, share, beyond) = sensor.place(own.lagged);
            growth.at_edge |= u16::from(beyond) << bit;
            *at = Place { knot: first.saturating_add(cell), share };
            first = first.saturating_add(sensor.knots());
        }
        places
    }

    fn line(&self, of: &OfAxis<'_>, state: &ThermalState, places: &[Place; SENSORS], tool_mm: f64) -> [f64; 2] {
        let (mut offset, mut slope) = (0.0, 0.0);
        let at = |knot: usize| of.curves.get(knot).map_or([0; 2], pair).map(f64::from);
        for place in places.iter().take(self.sensors()) {
            let (low, high) = (at(place.knot), at(place.knot.saturating_add(1)));
            let [here, steep] = [0, 1].map(|i| {
                let [low, high] = [low, high].map(|values| values.get(i).copied().unwrap_or(0.0));
                low + place.share * (high - low)
            });
            offset += 1e-6 * here;
            slope += 1e-12 * steep;
        }
        for (value, response) in of.spindle.iter().zip(state.responses) {
            let [growth, tilt] = pair(value).map(f64::from);
            offset += response * (1e-6 * growth + 1e-9 * tilt * tool_mm);
        }
        [offset, slope]
    }
}
