//! Temperatures while a part is cut, read from CSV.

use crate::rows::{Column, Rows};
use crate::thermal::COLUMNS;
use anyhow::Result;
use std::path::PathBuf;
use trueaxis::temperature::{SENSORS, WARMEST_MK};

/// Number of the columns of a record.
pub(super) const COUNT: usize = COLUMNS.len();
/// Columns of the record by their names: those of `thermal fit`, of which the number of the cycle may be absent.
const TIME: usize = 0;
const CYCLE: usize = 1;
const SPINDLE: usize = 2;
const TOOL: usize = 6;
const TEMPERATURE: usize = COUNT - SENSORS;

/// Columns that a record of temperatures may have: `t_s` and `T1_c` are needed; a record of `thermal fit` also is one.
pub const TEMPERATURES: [Column; COUNT] = {
    let mut columns = COLUMNS;
    columns[CYCLE].needed = false;
    columns
};

/// Temperatures, speed of the spindle and length of the tool at a moment.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Reading {
    pub(crate) t_s: f64,
    /// In the order of the record's sensors.
    pub(crate) temperatures_c: Vec<f64>,
    pub(crate) spindle_rpm: f64,
    pub(crate) tool_mm: f64,
    pub(crate) line: u32,
}

/// A record of temperatures.
#[derive(Clone, Debug, PartialEq)]
pub struct TemperatureRecord {
    /// The file as errors name it.
    pub file: PathBuf,
    /// Names of the sensors: T1 to T16.
    pub sensors: Vec<String>,
    pub(crate) readings: Vec<Reading>,
    pub(crate) has_spindle: bool,
    pub(crate) has_tool: bool,
}

impl TemperatureRecord {
    /// Reads the rows of a file opened with [`TEMPERATURES`].
    ///
    /// # Errors
    /// A row that cannot be read, times that go backwards, a temperature that no machine has.
    pub fn read(mut rows: Rows<'_, COUNT>) -> Result<TemperatureRecord> {
        let there: Vec<usize> = (TEMPERATURE..COUNT).filter(|column| rows.present[*column]).collect();
        let sensors = there.iter().map(|column| TEMPERATURES[*column].name.trim_end_matches("_c").to_owned()).collect();
        let mut readings: Vec<Reading> = Vec::new();
        while let Some(row) = rows.next()? {
            let t_s = row.values[TIME];
            if let Some(before) = readings.last().filter(|before| t_s < before.t_s) {
                return Err(rows.error(row.line, "t_s", t_s, format!("at least {}, as in the row before", before.t_s)));
            }
            for column in &there {
                let (value, hottest) = (row.values[*column], f64::from(WARMEST_MK) * 1e-3);
                if !(-60.0..=hottest).contains(&value) {
                    let needed = format!("-60 to {hottest} degrees Celsius");
                    return Err(rows.error(row.line, TEMPERATURES[*column].name, value, needed));
                }
            }
            let reading = Reading {
                t_s,
                temperatures_c: there.iter().map(|column| row.values[*column]).collect(),
                spindle_rpm: row.values[SPINDLE],
                tool_mm: row.values[TOOL],
                line: row.line,
            };
            // Several measuring points at one moment: the temperatures are the same.
            match readings.last_mut().filter(|before| before.t_s == t_s) {
                Some(before) => *before = reading,
                None => readings.push(reading),
            }
        }
        let [has_spindle, has_tool] = [SPINDLE, TOOL].map(|column| rows.present[column]);
        Ok(TemperatureRecord { file: rows.file.clone(), sensors, readings, has_spindle, has_tool })
    }
}
