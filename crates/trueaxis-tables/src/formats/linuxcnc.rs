//! LinuxCNC `COMP_FILE`: one joint, lines of three numbers, `nominal forward reverse`, in machine units (mm or degrees).
//!
//! LinuxCNC adds a trim to the commanded joint position, chosen by the sign of the commanded velocity and interpolated
//! linearly between the nominals; outside the table it holds the end values. With E = actual − commanded:
//!
//! | `COMP_FILE_TYPE` | second and third number | trim that LinuxCNC adds |
//! |---|---|---|
//! | 0 | actual position, nominal + E, moving in positive and negative direction | nominal − actual = −E |
//! | 1 | the trim itself, −E | as written |
//!
//! `usrmotLoadComp` (src/emc/motion/usrmotintf.cc) and `compute_screw_comp` (control.c) do this in 2.5 to 2.10. The two
//! examples in LinuxCNC's INI documentation contradict each other in the sign of type 1; this module follows the program.
//!
//! The file does not state its type. Read as the wrong type, its errors are as large as its positions, and [`recognise`]
//! detects the type by that. It refuses a file that could be either, unless the caller states the type.
//!
//! LinuxCNC stops reading, without a message, at the first text that it does not understand: a comment, a header, a blank line
//! or a comma ends the table, and LinuxCNC then ignores `BACKLASH` of the joint. This module refuses everything that LinuxCNC
//! would cut off, skip or misread: lines that are not three numbers, a point given twice, more than 256 points, lines longer
//! than its buffer. Lines that are not in ascending order, as in instrument reports, are sorted, with a note.

use super::decimal::difference;
use super::losses;
use super::positioning::{self, Point};
use super::{ExportOptions, Exported, Imported};
use crate::Machine;
use crate::error::FileError;
use crate::origin::{Origin, numbered};
use crate::text::fixed;
use std::fmt::Write;
use trueaxis::machine::Axis;

/// Most points of a joint (`EMCMOT_COMP_SIZE`).
pub const MAX_POINTS: usize = 256;
/// Longest line, without its line end, that LinuxCNC's buffer of 255 bytes takes in one read.
pub const MAX_LINE: usize = 253;

/// `COMP_FILE_TYPE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CompFileType {
    /// 0: nominal, actual position in positive and in negative travel.
    Positions,
    /// 1: nominal, trim added to the command in positive and in negative travel.
    Trims,
}

impl CompFileType {
    /// File value for an error at a nominal position.
    fn written(self, nominal: f64, error: f64) -> f64 {
        match self {
            CompFileType::Positions => nominal + error,
            CompFileType::Trims => 0.0 - error,
        }
    }

    /// Error for a file value at a nominal position.
    fn error(self, nominal: f64, value: f64) -> f64 {
        match self {
            CompFileType::Positions => difference(value, nominal),
            CompFileType::Trims => 0.0 - value,
        }
    }

    fn number(self) -> u8 {
        match self {
            CompFileType::Positions => 0,
            CompFileType::Trims => 1,
        }
    }
}

pub(super) fn import(
    text: &str,
    origin: &Origin,
    axis: Option<Axis>,
    file_type: CompFileType,
) -> Result<Imported, FileError> {
    let axis = axis.ok_or_else(|| origin.whole("no axis: a COMP_FILE does not name its joint", "the axis"))?;
    let mut points = points(text, origin)?;
    contradicts(&points, file_type, origin)?;
    let mut notes = Vec::new();
    if points.windows(2).any(|pair| matches!(pair, [(_, [before, ..]), (_, [nominal, ..])] if nominal < before)) {
        points.sort_by(|(_, [one, ..]), (_, [other, ..])| one.total_cmp(other));
        notes.push(String::from(
            "the nominals do not increase, as LinuxCNC requires: the lines are used in their order",
        ));
    }
    let to_table = if axis.is_rotary() { std::f64::consts::PI / 180.0 } else { 1.0 };
    let mut lines = Vec::new();
    for (line, [nominal, forward, reverse]) in points {
        let [forward, reverse] = [forward, reverse].map(|value| file_type.error(nominal, value) * to_table);
        lines.push((line, super::single(nominal, axis.index(), forward, reverse)));
    }
    let table = super::table(axis, super::only(axis.index()), lines, origin)?;
    Ok(Imported { tables: vec![(axis, table)], notes, ..Imported::default() })
}

/// Lines and their three numbers.
fn points(text: &str, origin: &Origin) -> Result<Vec<(u32, [f64; 3])>, FileError> {
    let mut lines = Vec::new();
    let mut blank = None;
    for (line, content) in numbered(text) {
        if content.starts_with('\u{feff}') {
            return Err(origin.at(line, "", "a byte order mark: LinuxCNC would read nothing", "plain text"));
        }
        if content.trim().is_empty() {
            blank = blank.or(Some(line));
            continue;
        }
        if let Some(blank) = blank {
            return Err(origin.at(blank, "", "a blank line: LinuxCNC stops reading there", "three numbers"));
        }
        if content.len() > MAX_LINE {
            let found = format!("{} bytes: LinuxCNC would read the rest as another line", content.len());
            return Err(origin.at(line, "", found, format!("at most {MAX_LINE} bytes")));
        }
        // LinuxCNC ignores text after the third number; only a clear comment is accepted there.
        let numbers = content.find(['#', ';']).map_or(content, |start| content.split_at(start).0);
        let fields: Vec<&str> = numbers.split_whitespace().collect();
        let [nominal, forward, reverse] = fields.as_slice() else {
            let found = format!("{:?} ({} fields): LinuxCNC stops or misreads there", content.trim(), fields.len());
            return Err(origin.at(line, "", found, "three numbers separated by blanks: nominal forward reverse"));
        };
        let nominal = origin.number(line, "nominal", nominal)?;
        let (forward, reverse) = (origin.number(line, "forward", forward)?, origin.number(line, "reverse", reverse)?);
        if lines.len() == MAX_POINTS {
            return Err(origin.at(
                line,
                "",
                format!("point {}", MAX_POINTS + 1),
                format!("at most {MAX_POINTS} points"),
            ));
        }
        lines.push((line, [nominal, forward, reverse]));
    }
    Ok(lines)
}

/// Values above this cannot be errors of an axis, mm or degrees.
const LARGEST: f64 = 5.0;
/// One type must make the errors smaller than the other by this factor.
const CLEARLY: f64 = 10.0;

/// Largest errors of the file as type 0 and as type 1.
fn largest(points: &[(u32, [f64; 3])]) -> [f64; 2] {
    [CompFileType::Positions, CompFileType::Trims].map(|of| {
        let errors = points.iter().flat_map(|(_, [nominal, a, b])| [of.error(*nominal, *a), of.error(*nominal, *b)]);
        errors.fold(0.0, |most: f64, error| most.max(error.abs()))
    })
}

/// Detects the type of a file from its numbers: read as the wrong type, its errors are as large as its positions.
///
/// # Errors
/// Invalid lines, and a file that could be either type, for which the type has to be given.
pub fn recognise(text: &str, file: &std::path::Path) -> Result<CompFileType, FileError> {
    let origin = Origin::new(file);
    let [positions, trims] = largest(&points(text, &origin)?);
    if positions <= LARGEST && positions * CLEARLY <= trims {
        return Ok(CompFileType::Positions);
    }
    if trims <= LARGEST && trims * CLEARLY <= positions {
        return Ok(CompFileType::Trims);
    }
    if positions > LARGEST && trims > LARGEST {
        // Neither type gives a table: the range check of its numbers refuses the file, with the line.
        return Ok(CompFileType::Positions);
    }
    Err(origin.whole(
        format!("errors up to {positions} read as type 0 and {trims} read as type 1 (mm or degrees)"),
        "numbers that identify the type, or --comp-file-type 0 or 1",
    ))
}

/// Refuses a given type that the numbers clearly contradict.
fn contradicts(points: &[(u32, [f64; 3])], given: CompFileType, origin: &Origin) -> Result<(), FileError> {
    let [positions, trims] = largest(points);
    let (own, other, number) = match given {
        CompFileType::Positions => (positions, trims, 1),
        CompFileType::Trims => (trims, positions, 0),
    };
    if own > LARGEST && other * CLEARLY <= own && other <= LARGEST {
        let found =
            format!("errors up to {own} mm or degrees read as type {}, {other} as type {number}", given.number());
        return Err(origin.whole(found, format!("--comp-file-type {number}")));
    }
    Ok(())
}

pub(super) fn export(
    machine: &Machine,
    options: &ExportOptions,
    file_type: CompFileType,
    origin: &Origin,
    exported: &mut Exported,
) -> Result<(), FileError> {
    for (settings, table) in positioning::chosen(machine, options.axis) {
        let letter = settings.axis.letter();
        if table.rows.len() > MAX_POINTS {
            let found = format!("{} points in the table of axis {letter}", table.rows.len());
            return Err(origin.whole(found, format!("at most {MAX_POINTS}")));
        }
        losses::cross_terms(settings, table, &mut exported.dropped);
        let points = positioning::points(machine, settings, table);
        if let (true, Some(first), Some(last)) = (settings.axis.is_rotary(), points.first(), points.last())
            && (last.position - first.position - 360.0).abs() < 1e-9
        {
            exported.dropped.push(format!(
                "wrapping of axis {letter}: LinuxCNC holds the end values outside {} to {}",
                first.position, last.position
            ));
        }
        let decimals = if settings.axis.is_rotary() { 7 } else { 6 };
        let name = format!("{}.comp", letter.to_ascii_lowercase());
        let unit = if settings.axis.is_rotary() { "" } else { ", LINEAR_UNITS = mm" };
        exported.notes.push(format!(
            "COMP_FILE = {name} and COMP_FILE_TYPE = {} in the [JOINT_n] of {letter}{unit}; BACKLASH is then not used",
            file_type.number()
        ));
        exported.files.push((name, file(&points, file_type, decimals)));
    }
    losses::settings_losses(machine, options.axis, &mut exported.dropped);
    losses::machine_losses(machine, options.axis, &mut exported.dropped);
    Ok(())
}

fn file(points: &[Point], file_type: CompFileType, decimals: usize) -> String {
    let mut text = String::new();
    for point in points {
        let [forward, reverse] =
            [point.forward, point.reverse].map(|error| fixed(file_type.written(point.position, error), decimals));
        let _ = writeln!(text, "{} {forward} {reverse}", point.position);
    }
    text
}
