//! Refuses records that determine no model or contain a faulty sensor.

use super::{COLLINEAR, LEAST_CYCLES, LEAST_RANGE_K, LEAST_ROWS, LONGEST_GAP_S, REST_S, Record, span};
use core::fmt;
use std::string::String;
use std::vec::Vec;
use trueaxis::temperature::SENSORS;

/// Implausible change of a reading between rows: K at once, and the default K per minute.
const JUMP_K: f64 = 5.0;
/// See [`super::Settings::rate_k_per_min`].
pub const RATE_K_PER_MIN: f64 = 3.0;
/// A sensor may change this many times faster than at another time in the record, and in the model than ever in the record.
pub(super) const OWN_RATE: f64 = 2.0;
/// A sensor counts as stuck if it repeats a reading for this long, s, this many times longer than anywhere else, in this many
/// rows, while the others move by this much, K.
const STUCK_S: f64 = 1_800.0;
const STUCK_TIMES: f64 = 4.0;
const STUCK_ROWS: usize = 12;
const STUCK_ELSEWHERE_K: f64 = 3.0;
/// It also counts as stuck if the others move by this many of its resolution steps and it either leaps by this many steps when
/// released or repeats for a whole cycle; a sensor at a slowly changing place continues in single steps.
const STUCK_STEPS: f64 = 20.0;
const STUCK_LEAP_STEPS: f64 = 5.0;

/// Why a record is refused.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ThermalRefusal {
    /// Too few cycles.
    Cycles {
        /// Number of cycles in the record.
        found: usize,
    },
    /// The record lacks a cycle to be held out, or too few cycles remain.
    HeldOut {
        /// Number of the cycle.
        cycle: u32,
    },
    /// A cycle has too few rows.
    Rows {
        /// Number of the cycle.
        cycle: u32,
        /// Number of rows.
        found: usize,
    },
    /// No sensors, or more than the task supports.
    Sensors {
        /// Number of sensors in the record.
        found: usize,
    },
    /// No axis has a recorded drift.
    NoAxis,
    /// A value is not finite, or the times do not ascend.
    Row {
        /// Index of the row.
        index: usize,
    },
    /// A cycle cannot be held out in turn: the others are not enough.
    WithoutCycle {
        /// Number of the cycle.
        cycle: u32,
        /// What is wrong with the fit to the others.
        refusal: std::boxed::Box<ThermalRefusal>,
    },
    /// A row repeats the moment and measuring point of another.
    Twice {
        /// Index of the second row.
        index: usize,
        /// Index of the first row.
        first: usize,
    },
    /// A pause is neither short nor a rest.
    Gap {
        /// Index of the row after the pause.
        index: usize,
        /// Length of the pause, s.
        found_s: f64,
    },
    /// Rows are missing for longer than a lag.
    Missing {
        /// The missing rows.
        missing: super::Missing,
        /// Name of the sensor, or `spindle`.
        of: String,
        /// Lag of that sensor, s.
        lag_s: f64,
    },
    /// A cycle is interrupted by another.
    Mixed {
        /// Index of the row at which the cycle resumes.
        index: usize,
        /// Number of the cycle.
        cycle: u32,
    },
    /// A sensor jumps.
    Jump {
        /// Name of the sensor.
        sensor: String,
        /// Index of the row.
        index: usize,
        /// Change, K.
        found_k: f64,
        /// Largest plausible change, K.
        most_k: f64,
    },
    /// A sensor repeats one reading while the others move.
    Stuck {
        /// Name of the sensor.
        sensor: String,
        /// Index of the first repeated row.
        index: usize,
        /// Duration, s.
        found_s: f64,
        /// Movement of the other sensors' mean in that time, K.
        elsewhere_k: f64,
    },
    /// Nothing changes enough to identify a cause.
    NoExcitation {
        /// Range of the warmest sensor, K.
        found_k: f64,
    },
    /// Two sensors are too closely correlated.
    Collinear {
        /// Names of the sensors.
        sensors: [String; 2],
        /// Correlation of the sensors.
        found: f64,
    },
    /// No sensor predicts anything.
    NothingFound,
    /// The causes found are inseparable.
    Condition {
        /// Condition number of the scaled columns.
        found: f64,
    },
    /// The curves found cannot be encoded.
    Encoding(super::NotEncoded),
}

impl ThermalRefusal {
    /// Returns the row concerned.
    pub fn row(&self) -> Option<usize> {
        match self {
            Self::Row { index }
            | Self::Twice { index, .. }
            | Self::Gap { index, .. }
            | Self::Mixed { index, .. }
            | Self::Jump { index, .. }
            | Self::Stuck { index, .. } => Some(*index),
            Self::Missing { missing, .. } => Some(missing.index),
            _ => None,
        }
    }

    /// Returns the sensor concerned.
    pub fn sensor(&self) -> Option<&str> {
        match self {
            Self::Jump { sensor, .. } | Self::Stuck { sensor, .. } => Some(sensor),
            _ => None,
        }
    }
}

impl fmt::Display for ThermalRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cycles { found } => write!(
                f,
                "cycles: found {found}, needed at least {LEAST_CYCLES}: one is held out, and each of the others is predicted from the rest"
            ),
            Self::HeldOut { cycle } => {
                write!(f, "found no cycle {cycle} to hold out, or fewer than two left for the fit")
            }
            Self::WithoutCycle { cycle, refusal } => {
                write!(f, "cycle {cycle} held out in turn: {refusal}; or hold out other cycles")
            }
            Self::Rows { cycle, found } => write!(f, "rows of cycle {cycle}: found {found}, needed at least {LEAST_ROWS}"),
            Self::Sensors { found } => write!(f, "found {found} sensors, needed 1 to {SENSORS}"),
            Self::NoAxis => f.write_str("found no drift of any axis, needed ex_um, ey_um or ez_um"),
            Self::Row { .. } => f.write_str("found a figure that is not finite or a time that does not ascend"),
            Self::Twice { .. } => f.write_str("found the moment and the measuring point of another row again, needed each row once"),
            Self::Gap { found_s, .. } => write!(
                f,
                "found a pause of {found_s:.0} s, needed at most {LONGEST_GAP_S} s, or a rest of {REST_S} s after which \
                 the machine is in equilibrium"
            ),
            Self::Missing { missing, of, lag_s } => write!(
                f,
                "found no temperature for {:.0} s where cycle {} lacks {} of its rows, {:.0} s apart elsewhere, needed one in \
                 {lag_s:.0} s, the lag of {of}: leave the cycle out, or record it again",
                missing.unknown_s, missing.cycle, missing.rows, missing.interval_s
            ),
            Self::Mixed { cycle, .. } => write!(f, "found cycle {cycle} again, needed each cycle in one piece"),
            Self::Jump { sensor, found_k, most_k, .. } => {
                write!(f, "found {sensor} {found_k:.3} K away from the row before, needed at most {most_k:.3} K")
            }
            Self::Stuck { sensor, found_s, elsewhere_k, .. } => write!(
                f,
                "found {sensor} at one reading for {found_s:.0} s while the others moved {elsewhere_k:.1} K, needed a \
                 sensor that follows the machine"
            ),
            Self::NoExcitation { found_k } => write!(
                f,
                "found sensors that move by {found_k:.2} K at most and one speed of the spindle, needed {LEAST_RANGE_K} K \
                 or a change of speed"
            ),
            Self::Collinear { sensors: [one, other], found } => write!(
                f,
                "found {one} and {other} running together (correlation {found:.5}), needed sensors that differ: their \
                 shares cannot be separated, leave one out"
            ),
            Self::NothingFound => f.write_str(
                "found no sensor from which one cycle is predicted by the others, needed one near where the machine grows",
            ),
            Self::Condition { found } => write!(
                f,
                "found causes that cannot be separated (condition {found:.1e}), needed cycles in which they differ"
            ),
            Self::Encoding(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for ThermalRefusal {}

pub(super) fn check(record: &Record, rate_k_per_min: Option<f64>) -> Result<(), ThermalRefusal> {
    let sensors = record.sensors.len();
    if !(1..=SENSORS).contains(&sensors) {
        return Err(ThermalRefusal::Sensors { found: sensors });
    }
    if record.axes.is_empty() {
        return Err(ThermalRefusal::NoAxis);
    }
    rows(record)?;
    let cycles = record.cycles();
    if cycles.len() < LEAST_CYCLES {
        return Err(ThermalRefusal::Cycles { found: cycles.len() });
    }
    for cycle in cycles {
        let found = record.samples.iter().filter(|sample| sample.cycle == cycle).count();
        if found < LEAST_ROWS {
            return Err(ThermalRefusal::Rows { cycle, found });
        }
    }
    for sensor in 0..sensors {
        jumps(record, sensor, rate_k_per_min)?;
        stuck(record, sensor)?;
    }
    let ranges = (0..sensors).map(|sensor| span(record.readings(sensor)));
    let found_k = ranges.map(|[low, high]| high - low).fold(0.0, f64::max);
    let [slow, fast] = span(record.samples.iter().map(|sample| sample.spindle_rpm.abs()));
    if found_k < LEAST_RANGE_K && slow == fast {
        return Err(ThermalRefusal::NoExcitation { found_k });
    }
    collinear(record)
}

fn rows(record: &Record) -> Result<(), ThermalRefusal> {
    let (sensors, axes) = (record.sensors.len(), record.axes.len());
    let mut known: Vec<u32> = Vec::new();
    for (index, sample) in record.samples.iter().enumerate() {
        let figures = sample.temperatures_c.iter().chain(&sample.error_mm).chain(&sample.position_mm);
        let sound = figures.chain([&sample.t_s, &sample.spindle_rpm, &sample.tool_mm]).all(|figure| figure.is_finite());
        let before = index.checked_sub(1).map(|before| &record.samples[before]);
        let step = before.map_or(1.0, |before| sample.t_s - before.t_s);
        if !sound || step < 0.0 || sample.temperatures_c.len() != sensors || sample.error_mm.len() != axes {
            return Err(ThermalRefusal::Row { index });
        }
        let moment = |row: &usize| record.samples[*row].t_s == sample.t_s;
        let point = |own: &super::Sample| (own.position_mm, own.tool_mm);
        if let Some(first) =
            (0..index).rev().take_while(moment).find(|row| point(&record.samples[*row]) == point(sample))
        {
            return Err(ThermalRefusal::Twice { index, first });
        }
        if step > LONGEST_GAP_S && step < REST_S {
            return Err(ThermalRefusal::Gap { index, found_s: step });
        }
        if before.is_none_or(|before| before.cycle != sample.cycle) {
            if known.contains(&sample.cycle) {
                return Err(ThermalRefusal::Mixed { index, cycle: sample.cycle });
            }
            known.push(sample.cycle);
        }
    }
    Ok(())
}

/// Rate of a sensor before each row, K/s; none where lags restart, and between rows of the same moment.
fn rates(record: &Record, sensor: usize) -> Vec<Option<f64>> {
    let readings: Vec<f64> = record.readings(sensor).collect();
    let rate = |row: usize| {
        let step_s = (!record.begins(row)).then(|| record.samples[row].t_s - record.samples[row - 1].t_s)?;
        (step_s > 0.0).then(|| (readings[row] - readings[row - 1]) / step_s)
    };
    (0..readings.len()).map(rate).collect()
}

/// Fastest rate of a sensor in the record, K/min, beyond a step of `sudden_k` at once.
pub(super) fn fastest_k_per_min(record: &Record, sensor: usize, sudden_k: f64) -> f64 {
    let beyond = |(row, rate): (usize, Option<f64>)| {
        let step_s = record.samples[row].t_s - record.samples[row.max(1) - 1].t_s;
        rate.map_or(0.0, |rate| 60.0 * (rate.abs() - sudden_k / step_s))
    };
    rates(record, sensor).into_iter().enumerate().map(beyond).fold(0.0, f64::max)
}

/// A heated bed moves faster than any machine, but it does so in every cycle, or over several rows; a sensor that fails jumps
/// once, or there and back.
fn jumps(record: &Record, sensor: usize, rate_k_per_min: Option<f64>) -> Result<(), ThermalRefusal> {
    let rates = rates(record, sensor);
    let stated = rate_k_per_min.unwrap_or(RATE_K_PER_MIN) / 60.0;
    let cycle = |row: usize| record.samples[row].cycle;
    let mut before = 0.0;
    for (index, rate) in rates.iter().enumerate() {
        if record.begins(index) {
            before = 0.0;
            continue;
        }
        let [last, reading] = [index - 1, index].map(|row| record.samples[row].temperatures_c[sensor]);
        let rest = (index + 1..rates.len()).take_while(|row| !record.begins(*row));
        let after = rest.filter_map(|row| rates[row]).next().unwrap_or(0.0);
        let step_s = record.samples[index].t_s - record.samples[index - 1].t_s;
        let (found_k, mut most_k) = ((reading - last).abs(), JUMP_K + stated * step_s);
        if let Some(rate) = rate.filter(|_| found_k > most_k && rate_k_per_min.is_none()) {
            // Rates in the same direction, without a return right before or after.
            let alike = |other: f64| if other * rate > 0.0 { other.abs() } else { 0.0 };
            let returns =
                [before, after].into_iter().any(|other: f64| other * rate < 0.0 && 2.0 * other.abs() > rate.abs());
            let elsewhere = rates.iter().enumerate().filter(|(row, _)| cycle(*row) != cycle(index));
            let own = elsewhere.filter_map(|(_, other)| other.map(alike)).chain([before, after].map(alike));
            let own = own.fold(0.0, f64::max);
            most_k = if returns { most_k } else { most_k.max(OWN_RATE * own * step_s) };
        }
        if found_k > most_k {
            return Err(ThermalRefusal::Jump { sensor: record.sensors[sensor].clone(), index, found_k, most_k });
        }
        before = rate.unwrap_or(before);
    }
    Ok(())
}

/// Mean of the other sensors at a row; without others, the speed in thousands of rpm.
fn others(record: &Record, sensor: usize, row: usize) -> f64 {
    let sample = &record.samples[row];
    let others = sample.temperatures_c.iter().enumerate().filter(|(other, _)| *other != sensor);
    let (sum, count) = others.fold((0.0, 0.0), |(sum, count), (_, reading)| (sum + reading, count + 1.0));
    if count > 0.0 { sum / count } else { 1e-3 * sample.spindle_rpm.abs() }
}

fn stuck(record: &Record, sensor: usize) -> Result<(), ThermalRefusal> {
    // Runs continue over a rest: no machine returns to exactly the same reading.
    let runs = runs(record, sensor, true);
    let seconds = |run: &[usize; 2]| record.samples[run[1] - 1].t_s - record.samples[run[0]].t_s;
    let moved = |run: &[usize; 2]| {
        let [low, high] = span((run[0]..run[1]).map(|row| others(record, sensor, row)));
        high - low
    };
    let resolution_k = runs
        .windows(2)
        .map(|pair| [pair[0][0], pair[1][0]].map(|row| record.samples[row].temperatures_c[sensor]))
        .map(|[one, other]| (one - other).abs())
        .fold(f64::INFINITY, f64::min);
    let [low, high] = span(record.readings(sensor));
    let by_time: Vec<f64> = runs.iter().map(seconds).collect();
    for (k, run) in runs.iter().enumerate() {
        let (found_s, elsewhere_k) = (by_time[k], moved(run));
        if found_s < STUCK_S || run[1] - run[0] < STUCK_ROWS || elsewhere_k < STUCK_ELSEWHERE_K {
            continue;
        }
        // Runs elsewhere in the record reflect the resolution: a slowly changing place repeats a reading for a while. If the
        // resolution is fine compared with the others' movement and the sensor catches up by many steps at once, it was stuck,
        // however often that happened.
        let usual = by_time.iter().enumerate().filter(|(other, _)| *other != k).map(|(_, s)| *s).fold(0.0, f64::max);
        let fine = resolution_k * STUCK_STEPS <= elsewhere_k && high - low >= LEAST_RANGE_K;
        let reading = |row: usize| record.samples[row].temperatures_c[sensor];
        let ends = |row: usize| row == 0 || row == record.samples.len() || record.begins(row);
        let leaps = !ends(run[1]) && (reading(run[1]) - reading(run[0])).abs() >= STUCK_LEAP_STEPS * resolution_k;
        let all_along = ends(run[0]) && ends(run[1]);
        if found_s >= STUCK_TIMES * usual || fine && (leaps || all_along) {
            return Err(ThermalRefusal::Stuck {
                sensor: record.sensors[sensor].clone(),
                index: run[0],
                found_s,
                elsewhere_k,
            });
        }
    }
    Ok(())
}

/// First row and end of each stretch over which a sensor repeats one reading; `over_rests`: stretches may contain rests.
fn runs(record: &Record, sensor: usize, over_rests: bool) -> Vec<[usize; 2]> {
    let readings: Vec<f64> = record.readings(sensor).collect();
    let (mut runs, mut from) = (Vec::new(), 0);
    for row in 1..=readings.len() {
        if row == readings.len() || readings[row] != readings[from] || (!over_rests && record.begins(row)) {
            runs.push([from, row]);
            from = row;
        }
    }
    runs
}

/// Longest time over which a sensor repeats one reading, s.
pub(super) fn longest_run_s(record: &Record, sensor: usize) -> f64 {
    let seconds = |[from, to]: [usize; 2]| record.samples[to - 1].t_s - record.samples[from].t_s;
    runs(record, sensor, false).into_iter().map(seconds).fold(0.0, f64::max)
}

fn collinear(record: &Record) -> Result<(), ThermalRefusal> {
    let centred: Vec<Vec<f64>> = (0..record.sensors.len())
        .map(|sensor| {
            let mean = record.readings(sensor).sum::<f64>() / record.samples.len() as f64;
            record.readings(sensor).map(|reading| reading - mean).collect()
        })
        .collect();
    let dot = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
    for one in 0..centred.len() {
        for other in 0..one {
            let norms = dot(&centred[one], &centred[one]) * dot(&centred[other], &centred[other]);
            let found = dot(&centred[one], &centred[other]) / norms.sqrt().max(f64::MIN_POSITIVE);
            // Only sensors that move.
            let moves = |sensor| span(record.readings(sensor)).into_iter().rev().reduce(|high, low| high - low);
            if found.abs() > COLLINEAR && moves(one) >= Some(LEAST_RANGE_K) && moves(other) >= Some(LEAST_RANGE_K) {
                let sensors = [other, one].map(|sensor| record.sensors[sensor].clone());
                return Err(ThermalRefusal::Collinear { sensors, found });
            }
        }
    }
    Ok(())
}
