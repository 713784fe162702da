//! A recorded warm-up, read from CSV.

use super::document::MissingDocument;
use crate::record::{self, Channel, FINEST_UM};
use crate::rows::{Column, Rows};
use anyhow::{Result, anyhow};
use std::path::PathBuf;
use trueaxis::Axis;
use trueaxis::temperature::{SENSORS, WARMEST_MK};
use trueaxis_metrology::thermal::{Missing, Record, Sample, ThermalRefusal};

const fn needed(name: &'static str) -> Column {
    Column { name, needed: true }
}

const fn free(name: &'static str) -> Column {
    Column { name, needed: false }
}

/// Temperatures of the sensors, by their names.
const TEMPERATURES: [&str; SENSORS] = [
    "T1_c", "T2_c", "T3_c", "T4_c", "T5_c", "T6_c", "T7_c", "T8_c", "T9_c", "T10_c", "T11_c", "T12_c", "T13_c",
    "T14_c", "T15_c", "T16_c",
];

/// `N` columns, of which the last are the temperatures of all sensors: `first`, followed by the sensors that it lacks, all of
/// them optional.
pub const fn with_temperatures<const N: usize>(first: &[Column]) -> [Column; N] {
    let mut all = [free(""); N];
    let mut at = 0;
    while at < N {
        all[at] = if at < first.len() { first[at] } else { free(TEMPERATURES[at - (N - SENSORS)]) };
        at += 1;
    }
    all
}

/// Columns that a record may have.
pub const COLUMNS: [Column; TEMPERATURE + SENSORS] = with_temperatures(&[
    needed("t_s"),
    needed("cycle"),
    free("spindle_rpm"),
    free("x_mm"),
    free("y_mm"),
    free("z_mm"),
    free("tool_mm"),
    free("ex_um"),
    free("ey_um"),
    free("ez_um"),
    needed("T1_c"),
]);
/// Hottest sensor temperature that the task accepts, °C: the hot end of a printer.
const HOTTEST_C: f64 = WARMEST_MK as f64 * 1e-3;
/// First column of a drift and first column of a temperature.
const DRIFT: usize = 7;
const TEMPERATURE: usize = 10;

/// A record and its file.
#[derive(Clone, Debug)]
pub struct Recording {
    /// The file as errors name it.
    pub file: PathBuf,
    /// The record read from it.
    pub record: Record,
    /// Line of the file for every row.
    lines: Vec<u32>,
}

impl Recording {
    /// Reads the rows of a file opened with [`COLUMNS`], except the sensors named in `without` (`T3`).
    ///
    /// # Errors
    /// A row that cannot be read, an invalid cycle number, a temperature that no machine has, a drift that no probe reads or
    /// that stops changing half-way, a sensor in `without` that does not exist.
    pub fn read(mut rows: Rows<'_, 26>, without: &[String]) -> Result<Recording> {
        let file = rows.file.clone();
        let name = |sensor: usize| COLUMNS[TEMPERATURE + sensor].name.trim_end_matches("_c");
        let there: Vec<usize> = (0..SENSORS).filter(|sensor| rows.present[TEMPERATURE + sensor]).collect();
        if let Some(unknown) = without.iter().find(|out| there.iter().all(|sensor| name(*sensor) != out.as_str())) {
            let names: Vec<&str> = there.iter().map(|sensor| name(*sensor)).collect();
            return Err(anyhow!("--without: found {unknown}, needed one of {}", names.join(", ")));
        }
        let sensors: Vec<usize> =
            there.into_iter().filter(|sensor| without.iter().all(|out| name(*sensor) != out.as_str())).collect();
        let axes: Vec<Axis> = Axis::ALL.into_iter().take(3).filter(|axis| rows.present[DRIFT + axis.index()]).collect();
        let (mut lines, mut samples) = (Vec::new(), Vec::new());
        while let Some(row) = rows.next()? {
            let [t_s, cycle, spindle_rpm, x, y, z, tool_mm, ..] = row.values;
            if !(0.0..=1e6).contains(&cycle) || cycle.fract() != 0.0 {
                return Err(rows.error(row.line, "cycle", cycle, "a whole number from 0 to 1000000"));
            }
            for sensor in &sensors {
                let (value, column) = (row.values[TEMPERATURE + sensor], COLUMNS[TEMPERATURE + sensor].name);
                if !(-60.0..=HOTTEST_C).contains(&value) {
                    let needed = format!("-60 to {HOTTEST_C} degrees Celsius");
                    return Err(rows.error(row.line, column, value, needed));
                }
            }
            for axis in &axes {
                let column = DRIFT + axis.index();
                record::displacement(&rows, row.line, COLUMNS[column].name, [row.values[column], 0.0])?;
            }
            lines.push(row.line);
            samples.push(Sample {
                t_s,
                temperatures_c: sensors.iter().map(|sensor| row.values[TEMPERATURE + sensor]).collect(),
                spindle_rpm,
                cycle: cycle as u32,
                position_mm: [x, y, z],
                tool_mm,
                error_mm: axes.iter().map(|axis| 1e-3 * row.values[DRIFT + axis.index()]).collect(),
            });
        }
        let drifts: Vec<Vec<f64>> =
            (0..axes.len()).map(|axis| samples.iter().map(|sample: &Sample| sample.error_mm[axis]).collect()).collect();
        let channels = axes.iter().zip(&drifts);
        let channels =
            channels.map(|(axis, values)| Channel { name: COLUMNS[DRIFT + axis.index()].name, values, scale: 1e3 });
        let channels: Vec<Channel<'_>> = channels.collect();
        for channel in &channels {
            let ends =
                channel.values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(*v), h.max(*v)]);
            let range_um = 1e3 * (ends[1] - ends[0]);
            if range_um > 0.0 && range_um < FINEST_UM {
                let found = format!("a drift of {range_um:.2e} um over the whole record");
                let needed = format!("{FINEST_UM} um at least, or a column of zeros: it may be in mm");
                return Err(rows.error(1, channel.name, found, needed));
            }
        }
        record::alive(&rows, &lines, &channels)?;
        let sensors = sensors.into_iter().map(|sensor| name(sensor).to_owned()).collect();
        Ok(Recording { file, record: Record { sensors, axes, samples }, lines })
    }

    /// The document entry of missing rows, with their line.
    pub(super) fn missing(&self, missing: &Missing) -> MissingDocument {
        let Missing { cycle, index, rows, found_s, interval_s, .. } = *missing;
        MissingDocument { line: self.lines.get(index).copied().unwrap_or(1), cycle, rows, found_s, interval_s }
    }

    /// A refusal at its line and column.
    pub fn refused(&self, refused: &ThermalRefusal) -> anyhow::Error {
        let text = refused.to_string();
        let Some(line) = refused.row().and_then(|row| self.lines.get(row)) else {
            return anyhow!("{}: {text}", self.file.display());
        };
        let column = match refused {
            ThermalRefusal::Mixed { .. } => "cycle".to_owned(),
            refused => refused.sensor().map_or_else(|| "t_s".to_owned(), |sensor| format!("{sensor}_c")),
        };
        let first = match refused {
            ThermalRefusal::Twice { first, .. } => {
                self.lines.get(*first).map(|line| format!(" (first in line {line})"))
            }
            ThermalRefusal::Jump { sensor, .. } => Some(format!(
                "; --rate-k-per-min admits a sensor that warms faster, --without {sensor} leaves out one that is not needed"
            )),
            _ => None,
        };
        anyhow!("{}:{line}: column {column}: {text}{}", self.file.display(), first.unwrap_or_default())
    }
}
