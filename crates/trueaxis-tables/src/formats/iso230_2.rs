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
//! Or a matrix, one line per target position and one column per run and direction, as many instruments write it:
//!
//! ```text
//! X_mm,+1,-1,+2,-2              or    X_mm,fwd_1_um,rev_1_um,fwd_2_um,rev_2_um
//! -292.42,8.73,10.31,8.70,10.25
//! ```
//!
//! `+` (`↑`, `fwd`) is the approach in positive direction, the number the run; without a unit in the name the deviations are µm,
//! of a rotary axis µrad.
//!
//! As a table: the mean of all runs at each position, both directions apart if both were measured. The scatter is not kept.

use super::{ExportOptions, Exported, Imported};
use super::{losses, positioning};
use crate::Machine;
use crate::error::FileError;
use crate::sheet::Sheet;
use crate::source::{Source, fixed};
use std::collections::BTreeSet;
use std::fmt::Write;
use trueaxis::machine::{Axis, LocationErrors};
use trueaxis::range;

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
    /// How the file was read, where it has other separators or decimals: to be told once.
    pub dialect: Option<&'static str>,
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
}

/// Reads a measurement; `file` is only named in errors, `axis` is needed if the position column does not name it.
///
/// # Errors
/// A missing or unknown column, a value that is none, an approach twice or missing: with its line.
pub fn read_measurement(text: &str, file: &std::path::Path, axis: Option<Axis>) -> Result<Measurement, FileError> {
    read(text, &Source::new(file), axis)
}

fn read(text: &str, source: &Source, axis: Option<Axis>) -> Result<Measurement, FileError> {
    let mut sheet = Sheet::new(text.as_bytes(), source.file()).map_err(|error| match error.found.as_str() {
        "no header" => source.whole("no header", "X_mm,run,direction,deviation_um"),
        _ => error,
    })?;
    let mut reading = Reading { approaches: Vec::new(), seen: BTreeSet::new() };
    let names: Vec<String> = sheet.header().to_vec();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let axis = if names.iter().any(|name| run_column(name).is_some()) {
        matrix(&mut sheet, &names, source, axis, &mut reading)?
    } else {
        list(&mut sheet, &names, source, axis, &mut reading)?
    };
    let measurement = complete(axis, reading.approaches, source)?;
    Ok(Measurement { dialect: sheet.dialect(), ..measurement })
}

/// Approaches in the course of being read.
struct Reading {
    approaches: Vec<Approach>,
    seen: BTreeSet<(u64, u32, Direction)>,
}

impl Reading {
    /// Takes an approach that stands in these two columns.
    fn take(
        &mut self,
        sheet: &Sheet<'_>,
        axis: Axis,
        [target, column]: [usize; 2],
        approach: Approach,
    ) -> Result<(), FileError> {
        let Approach { position, run, direction, deviation } = approach;
        let name = |place: usize| sheet.header().get(place).map_or("", String::as_str);
        let (scale, range) = if axis.is_rotary() { (1e6, &range::ROTATION) } else { (1e3, &range::TRANSLATION) };
        for (place, value, range) in [(target, position, range::POSITION.of(axis)), (column, deviation / scale, range)]
        {
            super::within_sheet(sheet, name(place), value, range)?;
        }
        if !self.seen.insert(((position + 0.0).to_bits(), run, direction)) {
            let found = format!("position {position}, run {run} in this direction again");
            return Err(sheet.error("", found, "each approach once"));
        }
        self.approaches.push(approach);
        Ok(())
    }
}

/// One line per approach.
fn list(
    sheet: &mut Sheet<'_>,
    names: &[&str],
    source: &Source,
    axis: Option<Axis>,
    reading: &mut Reading,
) -> Result<Axis, FileError> {
    let columns = header(names, sheet.header_line(), source, axis)?;
    while sheet.next_row()? {
        let position = sheet.number(columns.position)?;
        let run = sheet.field(columns.run);
        let run = run
            .parse::<u32>()
            .ok()
            .filter(|run| *run > 0)
            .ok_or_else(|| sheet.error("run", format!("{run:?}"), "a whole number from 1"))?;
        let direction = match sheet.field(columns.direction) {
            "+" => Direction::Up,
            "-" => Direction::Down,
            other => return Err(sheet.error("direction", format!("{other:?}"), "+ or -")),
        };
        let deviation = sheet.number(columns.deviation)?;
        let places = [columns.position, columns.deviation];
        reading.take(sheet, columns.axis, places, Approach { position, run, direction, deviation })?;
    }
    Ok(columns.axis)
}

/// One line per target position, one column per run and direction.
fn matrix(
    sheet: &mut Sheet<'_>,
    names: &[&str],
    source: &Source,
    axis: Option<Axis>,
    reading: &mut Reading,
) -> Result<Axis, FileError> {
    let line = sheet.header_line();
    let mut position = None;
    let mut runs = Vec::new();
    for (place, name) in names.iter().enumerate() {
        match (run_column(name), position_column(name)) {
            (Some(column), _) => {
                if runs.iter().any(|(_, other): &(usize, RunColumn)| {
                    (other.run, other.direction) == (column.run, column.direction)
                }) {
                    let found = format!("run {} in this direction again", column.run);
                    return Err(source.at(line, name, found, "each run and direction once"));
                }
                runs.push((place, column));
            }
            (None, Some(column)) if position.is_none() => position = Some((place, column, *name)),
            (None, Some(_)) => return Err(source.at(line, name, "a second such column", MATRIX)),
            (None, None) => return Err(source.at(line, name, format!("column {name:?}"), MATRIX)),
        }
    }
    let Some((target, (named, rotary), name)) = position else {
        return Err(source.at(line, "", "no column with the targets", MATRIX));
    };
    let axis = measured_axis(named, axis, name, line, source)?;
    let urad = runs.iter().filter_map(|(place, column)| Some((*place, column.urad?)));
    for (name, urad) in urad.map(|(place, urad)| (names.get(place).copied().unwrap_or_default(), urad)) {
        units(axis, rotary, urad, name, line, source)?;
    }
    units(axis, rotary, rotary, name, line, source)?;
    while sheet.next_row()? {
        let position = sheet.number(target)?;
        for (place, RunColumn { run, direction, .. }) in &runs {
            let deviation = sheet.number(*place)?;
            let approach = Approach { position, run: *run, direction: *direction, deviation };
            reading.take(sheet, axis, [target, *place], approach)?;
        }
    }
    Ok(axis)
}

const MATRIX: &str =
    "X_mm (or C_deg, position_mm, position_deg) and a column per run: +1, -1, +2, … or fwd_1_um, rev_1_um, …";

/// A column of a matrix.
struct RunColumn {
    run: u32,
    direction: Direction,
    /// Whether µrad; `None` where the name does not say.
    urad: Option<bool>,
}

/// `+1`, `-1`, `+2` …; `fwd_1_um`, `rev_1_um` … (`_urad` of a rotary axis).
fn run_column(name: &str) -> Option<RunColumn> {
    let (direction, rest) = [
        ("+", Direction::Up),
        ("-", Direction::Down),
        ("\u{2191}", Direction::Up),
        ("\u{2193}", Direction::Down),
        ("\u{2212}", Direction::Down),
        ("fwd_", Direction::Up),
        ("rev_", Direction::Down),
    ]
    .into_iter()
    .find_map(|(start, direction)| Some((direction, name.strip_prefix(start)?)))?;
    let (number, urad) = match rest.split_once('_') {
        None => (rest, None),
        Some((number, "um")) => (number, Some(false)),
        Some((number, "urad")) => (number, Some(true)),
        Some(_) => return None,
    };
    // Words carry their unit, as every other column does.
    if urad.is_none() && name.starts_with(|first: char| first.is_ascii_alphabetic()) {
        return None;
    }
    let run = number.bytes().all(|digit| digit.is_ascii_digit()).then(|| number.parse().ok()).flatten()?;
    (run > 0).then_some(RunColumn { run, direction, urad })
}

/// The axis of the file and the one that was asked for.
fn measured_axis(
    named: Option<Axis>,
    axis: Option<Axis>,
    name: &str,
    line: u32,
    source: &Source,
) -> Result<Axis, FileError> {
    match (named, axis) {
        (Some(named), Some(wanted)) if named != wanted => Err(source.at(
            line,
            name,
            format!("a measurement of {}", named.letter()),
            format!("axis {}", wanted.letter()),
        )),
        (Some(axis), _) | (None, Some(axis)) => Ok(axis),
        (None, None) => Err(source.at(line, name, "no axis", "the axis, or a column such as X_mm")),
    }
}

fn units(axis: Axis, degrees: bool, urad: bool, name: &str, line: u32, source: &Source) -> Result<(), FileError> {
    if axis.is_rotary() == degrees && degrees == urad {
        return Ok(());
    }
    let found = format!("{name} for axis {}", axis.letter());
    Err(source.at(line, name, found, "mm and um for X, Y, Z; deg and urad for A, B, C"))
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
    let axis = measured_axis(named, axis, name, line, source)?;
    if axis.is_rotary() != rotary || rotary != urad {
        let found = format!("{name} with {deviation_name} for axis {}", axis.letter());
        return Err(source.at(line, name, found, "mm and um for X, Y, Z; deg and urad for A, B, C"));
    }
    Ok(Columns { axis, position, run, direction, deviation })
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
    let directions = directions.into_iter().collect();
    Ok(Measurement { axis, approaches, positions, runs: runs.len(), directions, dialect: None })
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
    Ok(Imported {
        tables: vec![(axis, table)],
        location: LocationErrors::default(),
        settings: None,
        notes: measurement.dialect.map(str::to_owned).into_iter().collect(),
    })
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
