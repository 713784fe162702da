//! Measured deviations of one axis, one line per approach, as ISO 230-2:2014 evaluates them.
//!
//! ```text
//! # comment
//! X_mm,run,direction,deviation_um
//! -292.42,1,+,8.73
//! -292.42,1,-,10.31
//! ```
//!
//! The first column is the target position: `X_mm` (`C_deg` for a rotary axis) or, if the axis is named elsewhere,
//! `position_mm` (`position_deg`). `run` counts from 1; `direction` is `+` if the target was approached in positive direction
//! and `-` otherwise; the deviation is actual − target, `deviation_um` (rotary: `deviation_urad`). Columns and lines may stand
//! in any order; each position, run and direction once, and every run at every position, so that no lost line goes unnoticed.
//!
//! As a table: the mean of all runs at each position, both directions apart if both were measured. The scatter is not kept.

use super::{ExportOptions, Exported, Imported};
use super::{losses, positioning};
use crate::Machine;
use crate::error::FileError;
use crate::source::{Source, fixed, numbered};
use std::collections::BTreeSet;
use std::fmt::Write;
use trueaxis::check::range;
use trueaxis::machine::{Axis, LocationErrors};

/// The way a target was approached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Direction {
    /// In positive direction, ↑ in ISO 230-2.
    Up,
    /// In negative direction, ↓ in ISO 230-2.
    Down,
}

/// One approach of a target position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Target position, mm (degrees).
    pub position: f64,
    /// Run, from 1.
    pub run: u32,
    /// Direction of approach.
    pub direction: Direction,
    /// Actual − target position, µm (µrad).
    pub deviation: f64,
}

/// A measurement of one axis; every position of `positions` has every run of every measured direction once.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// The axis.
    pub axis: Axis,
    /// All approaches, in the order of the file.
    pub approaches: Vec<Approach>,
    /// Target positions, increasing, mm (degrees).
    pub positions: Vec<f64>,
    /// Number of runs.
    pub runs: usize,
    /// The directions measured, `Up` first.
    pub directions: Vec<Direction>,
}

impl Measurement {
    /// The deviations at a position in a direction, µm (µrad), in the order of the file.
    pub fn deviations(&self, position: f64, direction: Direction) -> impl Iterator<Item = f64> {
        self.approaches
            .iter()
            .filter(move |approach| approach.position == position && approach.direction == direction)
            .map(|approach| approach.deviation)
    }

    /// Mean deviation at a position in a direction, µm (µrad); `None` where it was not measured.
    pub fn mean(&self, position: f64, direction: Direction) -> Option<f64> {
        let (sum, count) = self
            .deviations(position, direction)
            .fold((0.0, 0_u32), |(sum, count), deviation| (sum + deviation, count + 1));
        (count > 0).then(|| sum / f64::from(count))
    }
}

/// Where the columns stand.
struct Columns {
    axis: Axis,
    position: usize,
    run: usize,
    direction: usize,
    deviation: usize,
    deviation_name: &'static str,
    position_name: String,
}

/// Reads a measurement; `file` is only named in errors, `axis` is needed if the position column does not name it.
///
/// # Errors
/// A missing or unknown column, a value that is none, an approach twice or missing: with its line.
pub fn read_measurement(text: &str, file: &std::path::Path, axis: Option<Axis>) -> Result<Measurement, FileError> {
    read(text, &Source::new(file), axis)
}

fn read(text: &str, source: &Source, axis: Option<Axis>) -> Result<Measurement, FileError> {
    let mut columns: Option<Columns> = None;
    let mut approaches: Vec<Approach> = Vec::new();
    let mut seen = BTreeSet::new();
    // Spreadsheets begin UTF-8 files with a byte order mark.
    for (line, content) in numbered(text.trim_start_matches('\u{feff}')) {
        if content.trim().is_empty() || content.starts_with('#') {
            continue;
        }
        let record: Vec<&str> = content.split(',').map(str::trim).collect();
        let Some(columns) = &columns else {
            columns = Some(header(&record, line, source, axis)?);
            continue;
        };
        if record.len() != 4 {
            return Err(source.at(line, "", format!("{} values", record.len()), "4, as in the header"));
        }
        let field = |place: usize| record.get(place).copied().unwrap_or_default();
        let position = source.number(line, &columns.position_name, field(columns.position))?;
        let run = field(columns.run)
            .parse::<u32>()
            .ok()
            .filter(|run| *run > 0)
            .ok_or_else(|| source.at(line, "run", format!("{:?}", field(columns.run)), "a whole number from 1"))?;
        let direction = match field(columns.direction) {
            "+" => Direction::Up,
            "-" => Direction::Down,
            other => return Err(source.at(line, "direction", format!("{other:?}"), "+ or -")),
        };
        let deviation = source.number(line, columns.deviation_name, field(columns.deviation))?;
        let (scale, range) =
            if columns.axis.is_rotary() { (1e6, &range::ROTATION) } else { (1e3, &range::TRANSLATION) };
        super::within(source, line, &columns.position_name, position, range::POSITION.of(columns.axis))?;
        super::within(source, line, columns.deviation_name, deviation / scale, range)?;
        if !seen.insert(((position + 0.0).to_bits(), run, direction)) {
            let found = format!("position {position}, run {run} in this direction again");
            return Err(source.at(line, "", found, "each approach once"));
        }
        approaches.push(Approach { position, run, direction, deviation });
    }
    let Some(columns) = columns else {
        return Err(source.whole("no header", "X_mm,run,direction,deviation_um"));
    };
    complete(columns.axis, approaches, source)
}

fn header(record: &[&str], line: u32, source: &Source, axis: Option<Axis>) -> Result<Columns, FileError> {
    let needed =
        "the columns X_mm (or C_deg, position_mm, position_deg), run, direction, deviation_um (deviation_urad)";
    let mut position = None;
    let (mut run, mut direction, mut deviation) = (None, None, None);
    for (place, &name) in record.iter().enumerate() {
        let before = match name {
            "run" => run.replace(place),
            "direction" => direction.replace(place),
            "deviation_um" => deviation.replace((place, false, "deviation_um")).map(|before| before.0),
            "deviation_urad" => deviation.replace((place, true, "deviation_urad")).map(|before| before.0),
            _ => match position_column(name) {
                Some(column) => position.replace((place, column, name)).map(|before| before.0),
                None => return Err(source.at(line, name, format!("column {name:?}"), needed)),
            },
        };
        if before.is_some() {
            return Err(source.at(line, name, "a second such column", needed));
        }
    }
    let (Some((position, (named, rotary), name)), Some(run), Some(direction), Some((deviation, urad, deviation_name))) =
        (position, run, direction, deviation)
    else {
        return Err(source.at(line, "", "a header without all of them", needed));
    };
    let axis = match (named, axis) {
        (Some(named), Some(wanted)) if named != wanted => {
            return Err(source.at(
                line,
                name,
                format!("a measurement of {}", named.letter()),
                format!("axis {}", wanted.letter()),
            ));
        }
        (Some(axis), _) | (None, Some(axis)) => axis,
        (None, None) => return Err(source.at(line, name, "no axis", "the axis, or a column such as X_mm")),
    };
    if axis.is_rotary() != rotary || rotary != urad {
        let found = format!("{name} with {deviation_name} for axis {}", axis.letter());
        return Err(source.at(line, name, found, "mm and um for X, Y, Z; deg and urad for A, B, C"));
    }
    Ok(Columns { axis, position, run, direction, deviation, deviation_name, position_name: name.to_owned() })
}

/// Axis (if named) and whether degrees, of `X_mm`, `C_deg`, `position_mm`, `position_deg`.
fn position_column(name: &str) -> Option<(Option<Axis>, bool)> {
    let (axis, rotary) = match name.split_once('_')? {
        (axis, "mm") => (axis, false),
        (axis, "deg") => (axis, true),
        _ => return None,
    };
    if axis == "position" {
        return Some((None, rotary));
    }
    let mut letters = axis.chars();
    let named = letters.next().and_then(Axis::from_letter)?;
    letters.next().is_none().then_some((Some(named), rotary))
}

/// Every run at every position in every measured direction.
fn complete(axis: Axis, approaches: Vec<Approach>, source: &Source) -> Result<Measurement, FileError> {
    let mut positions: Vec<f64> = approaches.iter().map(|approach| approach.position).collect();
    positions.sort_by(f64::total_cmp);
    positions.dedup();
    let runs: BTreeSet<u32> = approaches.iter().map(|approach| approach.run).collect();
    let directions: BTreeSet<Direction> = approaches.iter().map(|approach| approach.direction).collect();
    if approaches.is_empty() {
        return Err(source.whole("no approaches", "at least one line after the header"));
    }
    let there: BTreeSet<(u64, u32, Direction)> = approaches
        .iter()
        .map(|approach| ((approach.position + 0.0).to_bits(), approach.run, approach.direction))
        .collect();
    for position in &positions {
        for run in &runs {
            for direction in &directions {
                if !there.contains(&((position + 0.0).to_bits(), *run, *direction)) {
                    let way = if *direction == Direction::Up { "+" } else { "-" };
                    let found = format!("no approach of {position} in run {run}, direction {way}");
                    return Err(source.whole(found, "every run at every position in the measured directions"));
                }
            }
        }
    }
    Ok(Measurement { axis, approaches, positions, runs: runs.len(), directions: directions.into_iter().collect() })
}

pub(super) fn import(text: &str, source: &Source, axis: Option<Axis>) -> Result<Imported, FileError> {
    let measurement = read(text, source, axis)?;
    let axis = measurement.axis;
    let scale = if axis.is_rotary() { 1e6 } else { 1e3 };
    let mut lines = Vec::with_capacity(measurement.positions.len());
    for &position in &measurement.positions {
        let [up, down] = [Direction::Up, Direction::Down].map(|direction| measurement.mean(position, direction));
        let (Some(forward), Some(reverse)) = (up.or(down), down.or(up)) else { continue };
        lines.push((0, super::single(position, axis.index(), forward / scale, reverse / scale)));
    }
    let table = super::table(axis, super::only(axis.index()), lines, source)?;
    Ok(Imported { tables: vec![(axis, table)], location: LocationErrors::default(), settings: None })
}

/// The axis' own error as a measurement of one run without scatter, backlash included, to 1 nm (0.001 µrad).
pub(super) fn export(machine: &Machine, options: &ExportOptions, exported: &mut Exported) {
    for (settings, table) in positioning::chosen(machine, options.axis) {
        let axis = settings.axis;
        losses::cross_terms(settings, table, &mut exported.dropped);
        let (unit, micro, scale) =
            if axis.is_rotary() { ("deg", "urad", 1e6 * std::f64::consts::PI / 180.0) } else { ("mm", "um", 1e3) };
        let mut text = format!("{}_{unit},run,direction,deviation_{micro}\n", axis.letter());
        for point in positioning::points(machine, settings, table) {
            let _ = writeln!(text, "{},1,+,{}", point.position, fixed(point.forward * scale, 3));
            let _ = writeln!(text, "{},1,-,{}", point.position, fixed(point.reverse * scale, 3));
        }
        exported.files.push((format!("{}-iso230-2.csv", axis.letter().to_ascii_lowercase()), text));
    }
    losses::settings_losses(machine, options.axis, &mut exported.dropped);
    losses::machine_losses(machine, options.axis, &mut exported.dropped);
}
