//! One sensor: whether to accept its readings, and its lag.

use super::ThermalError;
use super::bytes::Bytes;
use super::lag::{Decay, place};
use super::{COLDEST_MK, FAILURES_C, KNOTS, LONGEST_MS, PERSISTS_S, START_READINGS, START_S, WARMEST_MK};

/// State of a sensor. Unless it is good, its share of the growth does not change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
#[non_exhaustive]
pub enum SensorStatus {
    /// No defect.
    #[default]
    Good = 0,
    /// No reading, or a non-finite one.
    Missing = 1,
    /// The reading is outside the plausible range, or is exactly a value that means no reading (85 °C, 0 °C)
    /// and is a step from the last accepted one.
    OutOfRange = 2,
    /// The reading has changed by more than is plausible, and has neither returned since nor stayed for an hour.
    Jumped = 3,
    /// The sensor repeats one bitwise equal reading although the others change.
    Stuck = 4,
    /// The sensor has not yet given three plausible readings that agree.
    Starting = 5,
}

/// Settings of a sensor, in place in the file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sensor<'a> {
    lag_s: f64,
    plausible: [f64; 2],
    jump_k: f64,
    rate_k_per_s: f64,
    stuck_s: f64,
    elsewhere_k: f64,
    knots: &'a [[u8; 4]],
}

fn kelvin(mk: i32) -> f64 {
    1e-3 * f64::from(mk)
}

impl<'a> Sensor<'a> {
    /// Reads and checks the next sensor; `number`, from 1, is for errors.
    pub(super) fn read(bytes: &mut Bytes<'a>, number: u8) -> Result<Sensor<'a>, ThermalError> {
        let lag = time(bytes.u32()?)?;
        let [least, most] = [bytes.i32()?, bytes.i32()?];
        let [jump, rate] = [bytes.u32()?, bytes.u32()?];
        let (stuck, elsewhere) = (time(bytes.u32()?)?, bytes.u32()?);
        if !(COLDEST_MK <= least && least < most && most <= WARMEST_MK) || jump == 0 {
            return Err(ThermalError::Plausible(number));
        }
        let count = knots(bytes.u8()?)?;
        let knots = bytes.pieces::<4>(count)?;
        let mut before = COLDEST_MK.saturating_sub(1);
        for knot in knots {
            let knot = i32::from_le_bytes(*knot);
            if knot <= before || knot > WARMEST_MK {
                return Err(ThermalError::KnotOrder(knot));
            }
            before = knot;
        }
        Ok(Sensor {
            lag_s: lag,
            plausible: [kelvin(least), kelvin(most)],
            jump_k: 1e-3 * f64::from(jump),
            rate_k_per_s: 1e-3 * f64::from(rate) / 60.0,
            stuck_s: stuck,
            elsewhere_k: 1e-3 * f64::from(elsewhere),
            knots,
        })
    }

    /// Number of knots.
    pub(super) fn knots(&self) -> usize {
        self.knots.len()
    }

    /// Finds a temperature among the knots, see [`place`].
    pub(super) fn place(&self, temperature: f64) -> (usize, f64, bool) {
        place(self.knots.iter().map(|knot| kelvin(i32::from_le_bytes(*knot))), temperature)
    }
}

pub(super) fn time(ms: u32) -> Result<f64, ThermalError> {
    if ms > LONGEST_MS { Err(ThermalError::Time(ms)) } else { Ok(1e-3 * f64::from(ms)) }
}

pub(super) fn knots(count: u8) -> Result<usize, ThermalError> {
    let size = usize::from(count);
    if (2..=KNOTS).contains(&size) { Ok(size) } else { Err(ThermalError::Knots(count)) }
}

/// State of a sensor from one update to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SensorState {
    /// The last accepted reading, °C.
    pub(super) good: Option<f64>,
    /// Time since then, s; during a start or a step, since the first of the readings that agree.
    since_s: f64,
    /// The last finite reading, °C, and the time for which it has not changed, s.
    last: f64,
    unchanged_s: f64,
    /// Mean of the others when this reading last changed, °C; `None` until another sensor has been read.
    others: Option<f64>,
    /// Whether the reading has jumped and not returned.
    jumped: bool,
    /// Number of successive readings of a start or a step that agree, and whether they differ at all.
    agreeing: u8,
    alive: bool,
    /// Whether to accept the next reading unconditionally.
    trusted: bool,
    /// Temperature behind the lag, °C.
    pub(super) lagged: f64,
    pub(super) status: SensorStatus,
}

impl SensorState {
    /// Judges a reading and, if it is accepted, updates the lag; `others`: mean of the other sensors, °C.
    pub(super) fn update(&mut self, of: &Sensor<'_>, dt_s: f64, reading: Option<f64>, others: Option<f64>) {
        self.since_s += dt_s;
        self.status = self.judge(of, dt_s, reading, others);
        let Some(reading) = reading.filter(|_| self.status == SensorStatus::Good) else { return };
        self.lagged = match self.good {
            None => reading,
            Some(before) => Decay::new(dt_s, of.lag_s).respond(self.lagged, before, reading),
        };
        self.good = Some(reading);
        (self.since_s, self.agreeing) = (0.0, 0);
        (self.jumped, self.trusted) = (false, false);
    }

    fn judge(&mut self, of: &Sensor<'_>, dt_s: f64, reading: Option<f64>, others: Option<f64>) -> SensorStatus {
        let Some(reading) = reading.filter(|reading| reading.is_finite()) else {
            self.agreeing = 0;
            return SensorStatus::Missing;
        };
        let [least, most] = of.plausible;
        // A failure value never becomes plausible with time, and is not a step from which a sensor has to return.
        let a_step = self.good.is_none_or(|good| (reading - good).abs() > of.jump_k);
        if !(least..=most).contains(&reading) || (a_step && FAILURES_C.contains(&reading)) {
            self.agreeing = 0;
            return SensorStatus::OutOfRange;
        }
        let agrees = (reading - self.last).abs() <= of.jump_k + of.rate_k_per_s * dt_s;
        let differs = reading != self.last;
        if self.good.is_some() && reading == self.last {
            self.unchanged_s += dt_s;
        } else {
            (self.last, self.unchanged_s, self.others) = (reading, 0.0, others);
        }
        self.others = self.others.or(others);
        let Some(good) = self.good else {
            self.follow(agrees, differs);
            let started = self.agreeing >= START_READINGS && self.since_s >= START_S;
            return if started || self.trusted { SensorStatus::Good } else { SensorStatus::Starting };
        };
        // After a jump the sensor may have come off: time alone does not make its reading plausible.
        let passed_s = if self.jumped { 0.0 } else { self.since_s };
        if !self.trusted && (reading - good).abs() > of.jump_k + of.rate_k_per_s * passed_s {
            self.agreeing = if self.jumped { self.agreeing } else { 0 };
            self.jumped = true;
            self.follow(agrees, differs);
            if !(self.agreeing >= START_READINGS && self.since_s >= PERSISTS_S && self.alive) {
                return SensorStatus::Jumped;
            }
        }
        let moved = others.zip(self.others).map_or(0.0, |(now, then)| (now - then).abs());
        if of.stuck_s > 0.0 && self.unchanged_s >= of.stuck_s && moved >= of.elsewhere_k {
            return SensorStatus::Stuck;
        }
        SensorStatus::Good
    }

    /// Counts a reading of a start or a step: continues the sequence, or restarts it.
    fn follow(&mut self, agrees: bool, differs: bool) {
        if agrees && self.agreeing > 0 {
            self.agreeing = self.agreeing.saturating_add(1);
            self.alive |= differs;
        } else {
            (self.agreeing, self.since_s, self.alive) = (1, 0.0, false);
        }
    }

    /// Accepts the next plausible reading unconditionally; the lag continues from its current value.
    pub(super) fn accept(&mut self) {
        self.trusted = true;
        self.unchanged_s = 0.0;
    }
}
