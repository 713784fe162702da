//! Thermal growth in a recorded run: settings of the thermal task and readings of its sensors, identical on a host and in a
//! bare-metal image. The readings replace a board's sensors.
//!
//! ```text
//! magic "TAXISTMP" | version u16 | interval u32, cycles | length u32 | .ttherm | sensors u8 | rows u32 | readings | CRC-32
//! ```
//!
//! A row is the temperature of each sensor, mK from 0 °C, then the spindle's speed, rpm, each an i32; `i32::MIN` means no
//! reading. The sum covers everything before it; numbers are little-endian.
//!
//! Row k holds the sensor readings of cycle k · interval. Its growth is in force from the middle of the interval, so that a
//! slow task may compute it at any time within the first half.

use crate::CRC;
use core::fmt;
use trueaxis::temperature::{Growth, Readings, SENSORS, Thermal, ThermalError, ThermalState};

/// First bytes.
pub const MAGIC: [u8; 8] = *b"TAXISTMP";
/// Version of the layout.
pub const VERSION: u16 = 1;
/// No reading.
const MISSING: i32 = i32::MIN;

/// Why readings are refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum WarmingRefusal {
    /// Shorter than its numbers state.
    TooShort,
    /// Not a file of readings.
    Magic,
    /// A different version.
    Version,
    /// Wrong checksum: damaged.
    Checksum,
    /// Rows less than two cycles apart: no time between a reading and its growth in force.
    Interval,
    /// A number of sensors other than in the task's settings.
    Sensors,
    /// Invalid settings of the task.
    Growth(ThermalError),
}

impl fmt::Display for WarmingRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            WarmingRefusal::TooShort => f.write_str("shorter than it says"),
            WarmingRefusal::Magic => f.write_str("no readings"),
            WarmingRefusal::Version => f.write_str("readings of another version"),
            WarmingRefusal::Checksum => f.write_str("damaged: the sum is wrong"),
            WarmingRefusal::Interval => f.write_str("less than two cycles between two readings"),
            WarmingRefusal::Sensors => f.write_str("not as many sensors as the growth has"),
            WarmingRefusal::Growth(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for WarmingRefusal {}

/// Checked readings with the task's settings, which borrow the bytes in place.
#[derive(Clone, Copy, Debug)]
pub struct Warming<'a> {
    thermal: Thermal<'a>,
    interval: u32,
    readings: &'a [[u8; 4]],
}

/// State of the task between rows; its sensors have started before the first.
#[derive(Clone, Debug)]
pub struct Task {
    state: ThermalState,
    /// The previous row.
    last: Option<u32>,
}

impl Default for Task {
    fn default() -> Self {
        let mut state = ThermalState::new();
        (0..SENSORS).for_each(|sensor| state.accept(sensor));
        Task { state, last: None }
    }
}

fn number<const B: usize>(bytes: &[u8]) -> Result<([u8; B], &[u8]), WarmingRefusal> {
    bytes.split_first_chunk::<B>().map(|(number, rest)| (*number, rest)).ok_or(WarmingRefusal::TooShort)
}

impl<'a> Warming<'a> {
    /// Reads and checks the readings at the start of `bytes`; ignores bytes after them.
    ///
    /// # Errors
    /// The first defect found.
    pub fn parse(bytes: &'a [u8], machine_id: u32) -> Result<Self, WarmingRefusal> {
        let (magic, rest) = number::<8>(bytes)?;
        if magic != MAGIC {
            return Err(WarmingRefusal::Magic);
        }
        let (version, rest) = number(rest)?;
        if u16::from_le_bytes(version) != VERSION {
            return Err(WarmingRefusal::Version);
        }
        let (interval, rest) = number(rest)?;
        let (length, rest) = number(rest)?;
        let (growth, rest) =
            rest.split_at_checked(u32::from_le_bytes(length) as usize).ok_or(WarmingRefusal::TooShort)?;
        let ([sensors], rest) = number(rest)?;
        let (rows, rest) = number(rest)?;
        let values = (u32::from_le_bytes(rows) as usize).checked_mul(usize::from(sensors) + 1);
        let length = values.and_then(|values| values.checked_mul(4)).ok_or(WarmingRefusal::TooShort)?;
        let (readings, behind) = rest.split_at_checked(length).ok_or(WarmingRefusal::TooShort)?;
        let (sum, behind) = number(behind)?;
        let summed = bytes.get(..bytes.len() - behind.len() - sum.len()).ok_or(WarmingRefusal::TooShort)?;
        if CRC.checksum(summed) != u32::from_le_bytes(sum) {
            return Err(WarmingRefusal::Checksum);
        }
        let thermal = Thermal::parse(growth).map_err(WarmingRefusal::Growth)?;
        thermal.expect_machine(machine_id).map_err(WarmingRefusal::Growth)?;
        let interval = u32::from_le_bytes(interval);
        if interval < 2 {
            return Err(WarmingRefusal::Interval);
        }
        if usize::from(sensors) != thermal.sensors() {
            return Err(WarmingRefusal::Sensors);
        }
        Ok(Warming { thermal, interval, readings: readings.as_chunks().0 })
    }

    /// Settings of the task.
    pub fn thermal(&self) -> &Thermal<'a> {
        &self.thermal
    }

    /// Number of the row that the sensors give in a cycle; `None` if they are not read in it.
    pub fn read_in(&self, cycle: u32) -> Option<u32> {
        (cycle.is_multiple_of(self.interval) && cycle / self.interval < self.rows()).then(|| cycle / self.interval)
    }

    /// The cycle from which the growth of a row is in force.
    pub fn in_force_from(&self, row: u32) -> u32 {
        row.saturating_mul(self.interval).saturating_add(self.interval / 2)
    }

    /// Number of rows.
    pub fn rows(&self) -> u32 {
        (self.readings.len() / (self.thermal.sensors() + 1)) as u32
    }

    /// Updates the task with a row, `period_ns` between two cycles, with a tool of length zero. Skipped rows count as
    /// elapsed time. `None` beyond the last row, and for a row that is not after the previous one.
    pub fn update(&self, task: &mut Task, row: u32, period_ns: u32) -> Option<Growth> {
        let passed = task.last.map_or(Some(0), |last| row.checked_sub(last).filter(|rows| *rows > 0))?;
        let sensors = self.thermal.sensors();
        let start = (row as usize).checked_mul(sensors + 1)?;
        let values = self.readings.get(start..start.checked_add(sensors + 1)?)?;
        let mut values =
            values.iter().map(|value| i32::from_le_bytes(*value)).map(|value| (value != MISSING).then_some(value));
        let mut temperatures_c = [None; SENSORS];
        for (to, value) in temperatures_c.iter_mut().zip(values.by_ref().take(sensors)) {
            *to = value.map(|millikelvin| 1e-3 * f64::from(millikelvin));
        }
        let spindle_rpm = values.next().flatten().map(f64::from);
        let temperatures_c = temperatures_c.get(..sensors)?;
        let dt_s = 1e-9 * f64::from(period_ns) * f64::from(self.interval) * f64::from(passed);
        task.last = Some(row);
        Some(self.thermal.update(&mut task.state, dt_s, &Readings { temperatures_c, spindle_rpm, tool_mm: 0.0 }))
    }
}

/// A row before it is written: temperatures, °C, and the spindle's speed, rpm; `None` for a missing reading.
#[cfg(feature = "std")]
pub type Reading = (std::vec::Vec<Option<f64>>, Option<f64>);

/// The bytes of readings for a growth; values that do not fit an i32 are written as missing.
#[cfg(feature = "std")]
pub fn write(growth: &[u8], interval: u32, rows: &[Reading]) -> std::vec::Vec<u8> {
    let mut bytes = std::vec::Vec::new();
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(interval.to_le_bytes());
    bytes.extend((growth.len() as u32).to_le_bytes());
    bytes.extend(growth);
    bytes.push(rows.first().map_or(0, |(temperatures, _)| temperatures.len() as u8));
    bytes.extend((rows.len() as u32).to_le_bytes());
    let whole = |value: f64| {
        if value.abs() < f64::from(i32::MAX) { value.round() as i32 } else { MISSING }
    };
    for (temperatures, rpm) in rows {
        for temperature in temperatures {
            bytes.extend(temperature.map_or(MISSING, |celsius| whole(1e3 * celsius)).to_le_bytes());
        }
        bytes.extend(rpm.map_or(MISSING, whole).to_le_bytes());
    }
    let sum = CRC.checksum(&bytes);
    bytes.extend(sum.to_le_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;
    use std::vec::Vec;
    use trueaxis::Axis;

    const ID: u32 = 0x1234_5678;
    /// Offset of the sensor's lag in [`growth`].
    const LAG_AT: usize = 22;

    /// One sensor without lag; Z grows linearly by 10 µm over 20 K.
    fn growth() -> Vec<u8> {
        let mut bytes = Vec::new();
        bytes.extend(*b"TRUETHRM");
        bytes.extend(1_u16.to_le_bytes());
        bytes.extend(ID.to_le_bytes());
        bytes.extend([1, 1, 0, 0]);
        bytes.extend(0_u32.to_le_bytes());
        bytes.extend(0_u32.to_le_bytes());
        for limit in [-50_000_i32, 100_000] {
            bytes.extend(limit.to_le_bytes());
        }
        for limit in [50_000_u32, 50_000, 0, 0] {
            bytes.extend(limit.to_le_bytes());
        }
        bytes.push(2);
        for knot in [20_000_i32, 40_000] {
            bytes.extend(knot.to_le_bytes());
        }
        bytes.push(2);
        bytes.extend(0_i64.to_le_bytes());
        for value in [0_i32, 0, 10_000, 0] {
            bytes.extend(value.to_le_bytes());
        }
        let sum = CRC.checksum(&bytes);
        bytes.extend(sum.to_le_bytes());
        bytes
    }

    fn bytes() -> Vec<u8> {
        write(&growth(), 100, &[(vec![Some(20.0)], Some(0.0)), (vec![None], None), (vec![Some(30.0)], Some(5.0))])
    }

    #[test]
    fn growth_follows_the_readings_and_stays_constant_without_one() {
        let bytes = bytes();
        let warming = Warming::parse(&bytes, ID).unwrap();
        assert_eq!((warming.rows(), warming.in_force_from(2)), (3, 250));
        assert_eq!([0, 1, 100, 200, 300].map(|cycle| warming.read_in(cycle)), [Some(0), None, Some(1), Some(2), None]);
        let mut task = Task::default();
        let lines =
            [0, 1, 2].map(|row| warming.update(&mut task, row, 1_000_000).unwrap().lines[Axis::Z.index()].unwrap()[0]);
        assert_eq!(lines[..2], [0.0, 0.0]);
        assert!((lines[2] - 5e-3).abs() < 1e-12, "{lines:?}");
        assert!(warming.update(&mut task, 3, 1_000_000).is_none());
        assert!(warming.update(&mut task, 2, 1_000_000).is_none(), "a row again");
    }

    /// With a lag, a skipped row counts as the same time as a row that was read.
    #[test]
    fn a_row_left_out_is_time_that_passes() {
        let mut lagging = growth();
        lagging.truncate(lagging.len() - 4);
        lagging[LAG_AT..LAG_AT + 4].copy_from_slice(&60_000_u32.to_le_bytes());
        let sum = CRC.checksum(&lagging);
        lagging.extend(sum.to_le_bytes());
        let rows = [20.0, 25.0, 30.0].map(|celsius| (vec![Some(celsius)], None));
        let bytes = write(&lagging, 10_000, &rows);
        let warming = Warming::parse(&bytes, ID).unwrap();
        let after = |rows: &[u32]| {
            let mut task = Task::default();
            let grown = rows.iter().map(|row| warming.update(&mut task, *row, 1_000_000).unwrap()).last().unwrap();
            grown.lines[Axis::Z.index()].unwrap()[0]
        };
        let (all, left_out) = (after(&[0, 1, 2]), after(&[0, 2]));
        assert!(all > 1e-4 && (all - left_out).abs() < 1e-15, "{all} {left_out}");
    }

    #[test]
    fn damaged_files_are_refused() {
        let good = bytes();
        for length in 0..good.len() {
            assert!(Warming::parse(&good[..length], ID).is_err(), "{length} bytes");
        }
        for at in 0..good.len() {
            let mut bytes = good.clone();
            bytes[at] ^= 4;
            assert!(Warming::parse(&bytes, ID).is_err(), "byte {at}");
        }
        assert!(matches!(Warming::parse(&good, ID + 1), Err(WarmingRefusal::Growth(_))));
        let longer: Vec<u8> = good.iter().copied().chain([0; 9]).collect();
        assert!(Warming::parse(&longer, ID).is_ok());
        let two = write(&growth(), 100, &[(vec![Some(20.0), None], None)]);
        assert_eq!(Warming::parse(&two, ID).unwrap_err(), WarmingRefusal::Sensors);
        let too_short = write(&growth(), 1, &[(vec![Some(20.0)], None)]);
        assert_eq!(Warming::parse(&too_short, ID).unwrap_err(), WarmingRefusal::Interval);
    }
}
