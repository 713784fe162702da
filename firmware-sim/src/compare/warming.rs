//! Thermal growth of a comparison: sensor readings from CSV, and the thermal task on the host.

use super::image;
use anyhow::{Context, Result, anyhow, bail};
use std::path::Path;
use trueaxis::temperature::{FASTEST_RPM, Growth, SENSORS, Thermal};
use trueaxis_evaluation::rows::{Column, Rows};
use trueaxis_evaluation::thermal::with_temperatures;
use trueaxis_recording::warming::{Reading, Task, Warming, write};
use trueaxis_tables::text::counted;

/// Columns that the readings may have.
const COLUMNS: [Column; TEMPERATURE + SENSORS] =
    with_temperatures(&[Column { name: "t_s", needed: true }, Column { name: SPEED, needed: false }]);
/// Index of the first temperature column.
const TEMPERATURE: usize = 2;
const SPEED: &str = "spindle_rpm";
/// Bound on a sensor reading, °C; the task decides whether it is plausible.
const MOST_C: f64 = 1e4;

/// Builds the growth input of image and host: the machine's compiled growth with its sensor readings, row by row at
/// equal intervals, the first row in the first cycle. An empty cell is a missing reading. `note` receives a note
/// on how a file with other separators is read.
///
/// # Errors
/// The file cannot be read; the growth belongs to another machine; the sensors are not those of the growth, the
/// intervals are unequal, or the image has no room for all readings.
pub fn read(
    growth: &Path,
    temperatures: &Path,
    period_s: f64,
    machine_id: u32,
    note: impl FnMut(String),
) -> Result<Vec<u8>> {
    let bytes = std::fs::read(growth).with_context(|| format!("cannot read {}", growth.display()))?;
    let refused = |error| anyhow!("{}: {error}", growth.display());
    let thermal = Thermal::parse(&bytes).map_err(refused)?;
    thermal.expect_machine(machine_id).map_err(refused)?;
    let sensors = thermal.sensors();
    let file = std::fs::File::open(temperatures).with_context(|| format!("cannot read {}", temperatures.display()))?;
    let mut rows = Rows::new(file, temperatures, &COLUMNS, note)?.with_gaps();
    let [_, has_speed, there @ ..] = rows.present;
    if there.iter().enumerate().any(|(k, there)| *there != (k < sensors)) || (thermal.has_spindle() && !has_speed) {
        let needed =
            COLUMNS.iter().take(TEMPERATURE + sensors).filter(|column| column.name != SPEED || thermal.has_spindle());
        let needed: Vec<&str> = needed.map(|column| column.name).collect();
        let found = rows.header.join(", ");
        bail!(
            "{}: found columns {found}, needed {} for {}",
            temperatures.display(),
            needed.join(", "),
            growth.display()
        );
    }
    let (mut times, mut readings) = (Vec::new(), Vec::<Reading>::new());
    while let Some(row) = rows.next()? {
        for (value, column) in row.values.iter().zip(&COLUMNS).skip(1) {
            let most = if column.name == SPEED { f64::from(FASTEST_RPM) } else { MOST_C };
            if value.abs() > most {
                return Err(rows.error(row.line, column.name, value, format!("-{most} to {most}")));
            }
        }
        let there = |value: f64| (!value.is_nan()).then_some(value);
        let [t_s, rpm, ref celsius @ ..] = row.values;
        times.push((row.line, t_s));
        readings.push((celsius.iter().take(sensors).map(|c| there(*c)).collect(), there(rpm).filter(|_| has_speed)));
    }
    let [(_, first), (_, second), ..] = times[..] else {
        bail!("{}: found {}, needed at least 2", temperatures.display(), counted(times.len(), "row"));
    };
    let interval = ((second - first) / period_s).round();
    for (k, (line, t_s)) in times.iter().enumerate() {
        let even = (t_s - first - k as f64 * interval * period_s).abs() <= 0.5 * period_s;
        if t_s.is_nan() || (k > 0 && !((2.0..=1e9).contains(&interval) && even)) {
            let found = if t_s.is_nan() { "nothing".to_owned() } else { t_s.to_string() };
            let needed = format!("even times, two or more cycles of {period_s} s apart");
            return Err(rows.error(*line, "t_s", found, needed));
        }
    }
    let (length, (_, room)) = (times.len(), image::WARMING);
    let bytes = write(&bytes, interval as u32, &readings);
    if bytes.len() as u64 > room {
        let found = format!("{}, with {} {} bytes", counted(length, "row"), growth.display(), bytes.len());
        bail!("{}: found {found}, needed at most {room}", temperatures.display());
    }
    Ok(bytes)
}

/// The thermal task on the host, run at the image's cycles.
#[derive(Debug)]
pub(super) struct Heating<'a> {
    warming: Warming<'a>,
    task: Task,
    waiting: Option<(u32, Growth)>,
}

impl<'a> Heating<'a> {
    pub(super) fn new(warming: Warming<'a>) -> Self {
        Heating { warming, task: Task::default(), waiting: None }
    }

    /// The growth that takes effect in this cycle.
    pub(super) fn cycle(&mut self, number: u32, period_ns: u32) -> Option<Growth> {
        if let Some(row) = self.warming.read_in(number) {
            let growth = self.warming.update(&mut self.task, row, period_ns);
            self.waiting = growth.map(|growth| (self.warming.in_force_from(row), growth));
        }
        self.waiting.take_if(|(from, _)| *from <= number).map(|(_, growth)| growth)
    }
}
