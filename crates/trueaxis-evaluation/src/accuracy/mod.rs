//! ISO 230-2 before and after compensation.

mod shown;

pub use shown::of_tables;

use crate::by_axes;
use crate::model::with_compensation;
use crate::uncertainty::{per_length, reading};
use anyhow::{Context, Result, anyhow, bail};
use serde::Serialize;
use std::path::Path;
use trueaxis::Axis;
use trueaxis::compensation::{Direction as Travel, Query, ThermalLine};
use trueaxis::machine::{AxisOrder, ErrorModel};
use trueaxis_metrology::accuracy::{
    Accuracy, Approach, Direction, Measurement, evaluate as as_measured, evaluate_compensated,
};
use trueaxis_metrology::uncertainty::{Instrument, Positioning, Verdict, positioning, verdict};
use trueaxis_tables::Machine;
use trueaxis_tables::formats::iso230_2::{MeasurementFile, read_measurement};
use trueaxis_tables::uncertainty::Uncertainties;

/// Figures of a measured axis.
#[derive(Clone, Debug, Serialize)]
pub struct AccuracyDocument {
    /// As measured.
    pub measured: Accuracy,
    /// After subtracting the corrections of a machine's tables.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compensated: Option<Accuracy>,
    /// Bands of the measured figures, if the instrument's uncertainty is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<Positioning>,
    /// Verdict against a tolerance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verdict: Option<Judgement>,
}

/// A verdict on the bidirectional accuracy A (for a measurement in one direction: A↑ or A↓), uncertainty included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Judgement {
    /// The figure.
    pub figure: &'static str,
    /// Largest permitted value, µm.
    pub tolerance_um: f64,
    /// Pass or fail only if the tolerance is outside the band (ISO 14253-1).
    pub verdict: Verdict,
}

/// Number of draws per band: determines its ends to some 3 % of its width.
const TRIALS: usize = 2_000;
/// Seed of the draws.
const SEED: u64 = 1;

/// Bands of the figures of a linear axis, from the uncertainty of the instrument and of the axis' expansion that a machine
/// states.
///
/// # Errors
/// A rotary axis; an axis that the machine does not have; an instrument without an uncertainty.
pub fn bands(
    measurement: &Measurement,
    machine: &Machine,
    stated: &Uncertainties,
    coverage: f64,
) -> Result<Positioning> {
    let (axis, name) = (measurement.axis, &machine.settings.name);
    if axis.is_rotary() {
        bail!("axis {}: found a rotary axis, needed a linear one for the terms of [uncertainty]", axis.letter());
    }
    let own = machine.settings.axis(axis);
    let own = own.with_context(|| format!("{name}: found no axis {}, needed the one measured", axis.letter()))?;
    let ends = measurement.positions.first().zip(measurement.positions.last());
    let length = ends.map_or(0.0, |(first, last)| last - first).max(f64::MIN_POSITIVE);
    // mm to µm; per unit length both are millionths of each other.
    let instrument = Instrument {
        per_length: 1e3 * per_length(&stated.instrument, own.thermal.expansion_per_k, length),
        reading: 1e3 * reading(&stated.instrument),
    };
    if instrument.per_length == 0.0 && instrument.reading == 0.0 {
        bail!("{name}: found no uncertainty of the instrument above zero, needed [uncertainty] in its machine.toml");
    }
    positioning(measurement, instrument, coverage, TRIALS, SEED).map_err(|error| anyhow!("{error}"))
}

/// The verdict on A.
pub fn judge(bands: &Positioning, tolerance_um: f64) -> Option<Judgement> {
    let band = ["A", "A_up", "A_down"].into_iter().find_map(|figure| bands.of(figure))?;
    Some(Judgement { figure: band.figure, tolerance_um, verdict: verdict(band.interval, tolerance_um) })
}

/// Reads a measurement; `file` is only named in errors. Separators other than commas are reported to the callback.
///
/// # Errors
/// As [`read_measurement`].
pub fn read(text: &str, file: &Path, axis: Option<Axis>, note: &mut dyn FnMut(String)) -> Result<Measurement> {
    let MeasurementFile { measurement, dialect } = read_measurement(text, file, axis)?;
    if let Some(how) = dialect {
        note(format!("{}: {how}", file.display()));
    }
    Ok(measurement)
}

/// Evaluates a measurement and, with a machine, the deviations that its tables would leave (errors name the machine by the
/// path).
///
/// # Errors
/// A single run; a machine without a table of that axis.
pub fn evaluate(
    measurement: &Measurement,
    file: &Path,
    machine: Option<(&Machine, &Path)>,
) -> Result<AccuracyDocument> {
    let measured = as_measured(measurement).map_err(|error| anyhow!("{}: {error}", file.display()))?;
    let compensated = match machine {
        None => None,
        Some((machine, path)) => {
            let mut tables = machine.clone();
            // A measurement along one axis involves no levers.
            tables.settings.compensation.model = ErrorModel::Nine;
            if tables.rows(measurement.axis).is_none() {
                bail!("{}: found no table of axis {}, needed one", path.display(), measurement.axis.letter());
            }
            Some(by_axes!(tables.settings.step_axes().count(), after(&tables, measurement))?)
        }
    };
    Ok(AccuracyDocument { measured, compensated, uncertainty: None, verdict: None })
}

/// The deviations minus the error that the machine's own look-up gives for the axis alone, in the direction of approach.
fn after<const N: usize>(tables: &Machine, measurement: &Measurement) -> Result<Accuracy> {
    let axes = AxisOrder::<N>::with_spare_slots(&tables.settings).map_err(|error| anyhow!("{error}"))?.axes();
    let slot = axes.iter().position(|a| *a == measurement.axis).context("the axis is not in the machine")?;
    with_compensation::<N, _>(tables, 1, |compensation| {
        let own = |position: f64, direction: Direction| {
            let travel = if direction == Direction::Down { Travel::NEGATIVE } else { Travel::POSITIVE };
            let error = |q: f64, travel: Travel| {
                let mut at = [0.0; N];
                at[slot] = q;
                let (at, thermal) = (compensation.coordinates(&at), [ThermalLine::default(); N]);
                let mut directions = [Travel::POSITIVE; N];
                directions[slot] = travel;
                compensation.errors(&Query::at(&at, &directions, &thermal), &mut 0)[slot]
            };
            // The other axes do not move: they add the same error everywhere.
            let constant = {
                let first = tables.rows(measurement.axis).and_then(<[_]>::first);
                let own = first.map_or(0.0, |row| row.forward[measurement.axis.index()]);
                let start = first.map_or(0.0, |row| row.position);
                let own = if measurement.axis.is_rotary() { own.to_degrees() } else { own };
                error(start, Travel::POSITIVE) - own
            };
            let value = error(position, travel) - constant;
            if measurement.axis.is_rotary() { value.to_radians() * 1e6 } else { value * 1e3 }
        };
        evaluate_compensated(measurement, own).map_err(|error| anyhow!("{error}"))
    })
}

/// Figures of an axis' own table, without a measurement: its error at every line, backlash included, in both directions.
///
/// A table has no scatter: E, M and B come from the table alone, A equals E, and R is at most the reversal. `None` without a
/// table, or if the table does not give the axis' own error.
pub fn of_table(machine: &Machine, axis: Axis) -> Option<Accuracy> {
    let (settings, table) = machine.axes().find(|(own, _)| own.axis == axis)?;
    let (table, own) = (table?, axis.index());
    if !*table.given.get(own)? {
        return None;
    }
    let (micro, backlash) =
        if axis.is_rotary() { (1e6, settings.backlash.to_radians()) } else { (1e3, settings.backlash) };
    let mut approaches = Vec::new();
    for row in &table.rows {
        let (up, down) = (row.forward.get(own)? * micro, (row.reverse.get(own)? + backlash) * micro);
        for run in [1, 2] {
            for (direction, deviation) in [(Direction::Up, up), (Direction::Down, down)] {
                approaches.push(Approach { position: row.position, run, direction, deviation });
            }
        }
    }
    as_measured(&Measurement::new(axis, approaches).ok()?).ok()
}
