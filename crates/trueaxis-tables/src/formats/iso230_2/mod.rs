//! Measured deviations of one axis, one line per approach, as ISO 230-2:2014 evaluates them.
//!
//! ```text
//! # comment
//! X_mm,run,direction,deviation_um
//! -292.42,1,+,14.79
//! -292.42,1,-,16.41
//! ```
//!
//! The first column is the target position: `X_mm` (`C_deg` for a rotary axis) or, if the axis is named elsewhere,
//! `position_mm` (`position_deg`). `run` counts from 1; `direction` is `+` if the target was approached in positive direction
//! and `-` otherwise; the deviation is actual − target, `deviation_um` (rotary: `deviation_urad`). Columns and lines may be in
//! any order. Each position, run and direction must occur once, and every run at every position, so that a lost line is
//! noticed.
//!
//! The other layout is a matrix, one line per target position and one column per run and direction, as many instruments write
//! it:
//!
//! ```text
//! X_mm,+1,-1,+2,-2              or    X_mm,fwd_1_um,rev_1_um,fwd_2_um,rev_2_um
//! -292.42,8.73,10.31,8.70,10.25
//! ```
//!
//! `+` (`↑`, `fwd`) is the approach in positive direction, the number is the run; without a unit in the name the deviations
//! are in µm, for a rotary axis in µrad.
//!
//! The table has the mean of all runs at each position: separately for both directions if both were measured and differ by
//! more than the scatter of their runs explains, else the mean of both. The scatter is dropped. If only one direction was
//! measured, the table applies to both, with a note.

mod columns;

use super::{ExportOptions, Exported, Imported};
use super::{losses, positioning};
use crate::Machine;
use crate::error::FileError;
use crate::origin::Origin;
use crate::sheet::Sheet;
use crate::text::fixed;
use columns::{Columns, Layout};
use std::fmt::Write;
use std::path::Path;
use trueaxis::machine::Axis;
use trueaxis::range;
use trueaxis_metrology::accuracy::{AccuracyError, Approach, Direction, Measurement};

/// A measurement as read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasurementFile {
    /// The measurement.
    pub measurement: Measurement,
    /// Unusual separators and decimals: to be reported once.
    pub dialect: Option<&'static str>,
}

/// Reads a measurement; `file` is only named in errors, `axis` is needed if the position column does not name it.
///
/// # Errors
/// A missing or unknown column, an invalid value, an approach given twice or missing: with its line.
pub fn read_measurement(text: &str, file: &Path, axis: Option<Axis>) -> Result<MeasurementFile, FileError> {
    read(text, &Origin::new(file), axis)
}

fn read(text: &str, origin: &Origin, axis: Option<Axis>) -> Result<MeasurementFile, FileError> {
    let mut sheet = Sheet::new(text.as_bytes(), origin.file()).map_err(|error| match error.found.as_str() {
        "no header" => origin.whole("no header", "X_mm,run,direction,deviation_um"),
        _ => error,
    })?;
    let Columns { axis, position: target, layout } = columns::read(&sheet, axis)?;
    let (scale, range) = if axis.is_rotary() { (1e6, &range::ROTATION) } else { (1e3, &range::TRANSLATION) };
    let (mut approaches, mut lines) = (Vec::new(), Vec::new());
    while sheet.next_row()? {
        let position = sheet.number(target)?;
        super::within_sheet(&sheet, target, position, range::POSITION.of(axis))?;
        let mut take = |sheet: &mut Sheet<'_>, column, run, direction| {
            let deviation = sheet.number(column)?;
            super::within_sheet(sheet, column, deviation / scale, range)?;
            approaches.push(Approach { position, run, direction, deviation });
            Ok::<_, FileError>(())
        };
        match &layout {
            Layout::List { run, direction, deviation } => {
                let (run, direction) = (run_of(&sheet, *run)?, direction_of(&sheet, *direction)?);
                take(&mut sheet, *deviation, run, direction)?;
            }
            Layout::Matrix(runs) => {
                for of in runs {
                    take(&mut sheet, of.column, of.run, of.direction)?;
                }
            }
        }
        lines.resize(approaches.len(), sheet.line());
    }
    let measurement = Measurement::new(axis, approaches).map_err(|error| incomplete(&error, &lines, origin))?;
    Ok(MeasurementFile { measurement, dialect: sheet.dialect() })
}

fn run_of(sheet: &Sheet<'_>, column: usize) -> Result<u32, FileError> {
    let text = sheet.field(column);
    let run = text.parse().ok().filter(|run| *run > 0);
    run.ok_or_else(|| sheet.error("run", format!("{text:?}"), "a whole number from 1"))
}

fn direction_of(sheet: &Sheet<'_>, column: usize) -> Result<Direction, FileError> {
    match sheet.field(column) {
        "+" => Ok(Direction::Up),
        "-" => Ok(Direction::Down),
        other => Err(sheet.error("direction", format!("{other:?}"), "+ or -")),
    }
}

/// The error for an approach given twice, with its line, or missing.
pub(super) fn incomplete(error: &AccuracyError, lines: &[u32], origin: &Origin) -> FileError {
    let text = error.to_string();
    let (found, needed) = text.split_once(", needed ").unwrap_or((&text, "a complete measurement"));
    let found = found.trim_start_matches("found ");
    match error {
        AccuracyError::Twice { index, .. } => origin.at(lines.get(*index).copied().unwrap_or(0), "", found, needed),
        _ => origin.whole(found, needed),
    }
}

pub(super) fn import(text: &str, origin: &Origin, axis: Option<Axis>) -> Result<Imported, FileError> {
    let MeasurementFile { measurement, dialect } = read(text, origin, axis)?;
    imported(&measurement, dialect.map(str::to_owned).into_iter().collect(), origin)
}

/// The table of a measurement: the means of its runs.
pub(super) fn imported(measurement: &Measurement, notes: Vec<String>, origin: &Origin) -> Result<Imported, FileError> {
    let axis = measurement.axis;
    let scale = if axis.is_rotary() { 1e6 } else { 1e3 };
    let same = measurement.reversal_within_scatter();
    let mut lines = Vec::with_capacity(measurement.positions.len());
    for &position in &measurement.positions {
        let [up, down] = [Direction::Up, Direction::Down].map(|direction| measurement.mean(position, direction));
        let (Some(mut forward), Some(mut reverse)) = (up.or(down), down.or(up)) else { continue };
        if same.is_some() {
            forward = 0.5 * (forward + reverse);
            reverse = forward;
        }
        lines.push((0, super::single(position, axis.index(), forward / scale, reverse / scale)));
    }
    let mut table = super::table(axis, super::only(axis.index()), lines, origin)?;
    // The table includes both directions nevertheless: a backlash setting would be corrected a second time.
    table.bidirectional |= same.is_some();
    let micro = if axis.is_rotary() { "µrad" } else { "µm" };
    let mean_of_both = same.map(|[found, expected]| {
        format!(
            "the table is the mean of both directions: they differ by {found:.2} {micro} RMS; the scatter of \
             the runs alone explains {expected:.2}"
        )
    });
    let one_way = (measurement.directions.len() == 1).then(|| one_way(axis));
    let notes = notes.into_iter().chain(mean_of_both).chain(one_way).collect();
    Ok(Imported { tables: vec![(axis, table)], notes, ..Imported::default() })
}

/// A note on a table that was measured in one direction.
pub(super) fn one_way(axis: Axis) -> String {
    let key = if axis.is_rotary() { "backlash_urad" } else { "backlash_um" };
    format!(
        "one direction of approach: the table is valid for both, without lost motion, which {key} of the axis states"
    )
}

/// Writes the axis' own error as a measurement of one run without scatter, backlash included, to 1 nm (0.001 µrad).
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
