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
//! That is what `usrmotLoadComp` (src/emc/motion/usrmotintf.cc) and `compute_screw_comp` (control.c) do, in 2.5 to 2.10. The
//! two examples in LinuxCNC's INI documentation contradict each other in the sign of type 1; the program is followed here.
//!
//! LinuxCNC reads as far as it understands and then stops without a word: a comment, a header, a blank line or a comma ends the
//! table there, and `BACKLASH` of the joint is no longer used. Everything that it would cut off, skip or misread is an error
//! here: lines that are not three numbers, points that do not increase, more than 256 points, lines longer than its buffer.

use super::losses;
use super::positioning::{self, Point};
use super::{ExportOptions, Exported, Imported};
use crate::Machine;
use crate::error::FileError;
use crate::source::{Source, fixed, numbered};
use std::fmt::Write;
use trueaxis::machine::{Axis, LocationErrors};

/// Most points of a joint (`EMCMOT_COMP_SIZE`).
pub const MAX_POINTS: usize = 256;
/// Longest line, without its end, that LinuxCNC's buffer of 255 bytes takes in one piece.
pub const MAX_LINE: usize = 253;

/// `COMP_FILE_TYPE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CompFileType {
    /// 0: nominal, actual position in positive and in negative travel.
    Positions,
    /// 1: nominal, what is added to the command in positive and in negative travel.
    Trims,
}

impl CompFileType {
    /// Value of a file for the error at a nominal position.
    fn written(self, nominal: f64, error: f64) -> f64 {
        match self {
            CompFileType::Positions => nominal + error,
            CompFileType::Trims => 0.0 - error,
        }
    }

    /// Error for the value of a file.
    fn error(self, nominal: f64, value: f64) -> f64 {
        match self {
            CompFileType::Positions => value - nominal,
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
    source: &Source,
    axis: Option<Axis>,
    file_type: CompFileType,
) -> Result<Imported, FileError> {
    let axis = axis.ok_or_else(|| source.whole("no axis: a COMP_FILE does not name its joint", "the axis"))?;
    let to_table = if axis.is_rotary() { std::f64::consts::PI / 180.0 } else { 1.0 };
    let mut lines = Vec::new();
    let mut blank = None;
    for (line, content) in numbered(text) {
        if content.starts_with('\u{feff}') {
            return Err(source.at(line, "", "a byte order mark: LinuxCNC would read nothing", "plain text"));
        }
        if content.trim().is_empty() {
            blank = blank.or(Some(line));
            continue;
        }
        if let Some(blank) = blank {
            return Err(source.at(blank, "", "a blank line: LinuxCNC stops reading there", "three numbers"));
        }
        if content.len() > MAX_LINE {
            let found = format!("{} bytes: LinuxCNC would read the rest as another line", content.len());
            return Err(source.at(line, "", found, format!("at most {MAX_LINE} bytes")));
        }
        // Text after the third number is ignored by LinuxCNC: only what is clearly a comment may be.
        let numbers = content.find(['#', ';']).map_or(content, |start| content.split_at(start).0);
        let fields: Vec<&str> = numbers.split_whitespace().collect();
        let [nominal, forward, reverse] = fields.as_slice() else {
            let found = format!("{:?} ({} fields): LinuxCNC stops or misreads there", content.trim(), fields.len());
            return Err(source.at(line, "", found, "three numbers separated by blanks: nominal forward reverse"));
        };
        let nominal = source.number(line, "nominal", nominal)?;
        let error = |column: &str, text: &str| {
            let value = source.number(line, column, text)?;
            Ok(file_type.error(nominal, value) * to_table)
        };
        let (forward, reverse) = (error("forward", forward)?, error("reverse", reverse)?);
        if lines.len() == MAX_POINTS {
            return Err(source.at(
                line,
                "",
                format!("point {}", MAX_POINTS + 1),
                format!("at most {MAX_POINTS} points"),
            ));
        }
        lines.push((line, super::single(nominal, axis.index(), forward, reverse)));
    }
    let table = super::table(axis, super::only(axis.index()), lines, source)?;
    Ok(Imported { tables: vec![(axis, table)], location: LocationErrors::default(), settings: None })
}

pub(super) fn export(
    machine: &Machine,
    options: &ExportOptions,
    file_type: CompFileType,
    source: &Source,
    exported: &mut Exported,
) -> Result<(), FileError> {
    for (settings, table) in positioning::chosen(machine, options.axis) {
        let letter = settings.axis.letter();
        if table.rows.len() > MAX_POINTS {
            let found = format!("{} points in the table of axis {letter}", table.rows.len());
            return Err(source.whole(found, format!("at most {MAX_POINTS}")));
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
        exported.notes.push(format!(
            "COMP_FILE = {name} and COMP_FILE_TYPE = {} in the [JOINT_n] of {letter}; BACKLASH is then not used",
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
