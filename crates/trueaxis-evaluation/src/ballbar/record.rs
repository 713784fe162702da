//! Reads a record of circles in any of its formats.

use super::telemetry::{is_telemetry, positions};
use super::{Options, Test};
use crate::record::{self, Channel};
use crate::rows::{Column, Rows};
use anyhow::{Result, anyhow};
use std::path::Path;
use trueaxis_metrology::ballbar::{BallbarRefusal, Position, Reading, readings};
use trueaxis_tables::error::FileError;

/// Columns of a ballbar's record, then those of a record of positions: time, command and reading of X, Y and Z.
pub const COLUMNS: [Column; 10] = [
    column("angle_deg"),
    column("deviation_um"),
    column("direction"),
    column("t_s"),
    column("x_cmd_mm"),
    column("x_mm"),
    column("y_cmd_mm"),
    column("y_mm"),
    column("z_cmd_mm"),
    column("z_mm"),
];

const fn column(name: &'static str) -> Column {
    Column { name, needed: false }
}

impl Test {
    /// Reads a record in any of four forms and evaluates it: bar readings (`angle_deg,deviation_um,direction`); commands and
    /// positions (`x_cmd_mm,x_mm,y_cmd_mm,y_mm` and the like; `t_s` is ignored); the lines of LinuxCNC's `halsampler`,
    /// recognised by the missing header: command and position of the first axis, then of the second, with or without the
    /// sample number before; or a controller's telemetry, recognised by its zero bytes. Separators other than commas, decimal
    /// commas, and damaged or missing frames are reported to the callback.
    ///
    /// # Errors
    /// An unreadable row, a direction of 0, columns of neither form, a record that determines nothing.
    ///
    /// Cost: 56 bytes per position, otherwise that of [`trueaxis_metrology::ballbar::evaluate`].
    pub fn read(bytes: &[u8], file: &Path, options: &Options, note: impl FnMut(String)) -> Result<Test> {
        if is_telemetry(bytes) {
            return positions_of(&positions(bytes, file, options.axes, note)?, &[], file, options);
        }
        if is_halsampler(bytes) {
            let (positions, lines) = halsampler(bytes, file)?;
            return positions_of(&positions, &lines, file, options);
        }
        let mut rows = Rows::new(bytes, file, &COLUMNS, note)?.with_words("direction", direction);
        let has = |name: &str| COLUMNS.iter().zip(rows.present).any(|(column, present)| present && column.name == name);
        let bar = ["angle_deg", "deviation_um", "direction"];
        let own = options.axes.map(|axis| axis.letter().to_ascii_lowercase());
        let positions = own.map(|letter| [format!("{letter}_cmd_mm"), format!("{letter}_mm")]);
        if bar.iter().all(|name| has(name)) {
            of_bar(&mut rows, options)
        } else if positions.iter().flatten().all(|name| has(name)) {
            let slots = options.axes.map(|axis| 4 + 2 * axis.index());
            of_positions(&mut rows, slots, options)
        } else {
            let needed = format!("the columns {}, or {}", bar.join(", "), positions.concat().join(", "));
            Err(whole(file, format!("columns {}", rows.header.join(", ")), needed))
        }
    }
}

/// Parses a direction that is not a plain number.
pub(crate) fn direction(word: &str) -> Option<f64> {
    match word.to_ascii_lowercase().as_str() {
        "+" | "+1" | "ccw" => Some(1.0),
        "-" | "\u{2212}" | "\u{2212}1" | "cw" => Some(-1.0),
        _ => None,
    }
}

fn of_bar(rows: &mut Rows<'_, 10>, options: &Options) -> Result<Test> {
    let (mut lines, mut readings, mut angles) = (Vec::new(), Vec::new(), Vec::new());
    while let Some(row) = rows.next()? {
        let [angle_deg, deviation_um, direction, ..] = row.values;
        angles.push(angle_deg);
        if direction == 0.0 {
            return Err(rows.error(
                row.line,
                "direction",
                0,
                "1, + or ccw for counterclockwise, -1, - or cw for clockwise",
            ));
        }
        record::displacement(rows, row.line, "deviation_um", [deviation_um, 0.0])?;
        lines.push(row.line);
        readings.push(Reading {
            angle_rad: angle_deg.to_radians(),
            deviation_mm: 1e-3 * deviation_um,
            counterclockwise: direction > 0.0,
        });
    }
    if let Some(most) = record::radians(&angles) {
        return Err(rows.error(lines[most], "angle_deg", angles[most], record::DEGREES));
    }
    let values: Vec<f64> = readings.iter().map(|reading| reading.deviation_mm).collect();
    record::alive(rows, &lines, &[Channel { name: "deviation_um", values: &values, scale: 1e3 }])?;
    Test::of(readings, false, options).map_err(|refused| match refused {
        BallbarRefusal::NotAReading { index } => {
            let line = lines.get(index).copied().unwrap_or(1);
            rows.error(line, "deviation_um", "a deviation as large as the circle", "less than half the radius")
        }
        refused => anyhow!("{}: {refused}", rows.file.display()),
    })
}

fn of_positions(rows: &mut Rows<'_, 10>, slots: [usize; 2], options: &Options) -> Result<Test> {
    let (mut positions, mut lines) = (Vec::new(), Vec::new());
    while let Some(row) = rows.next()? {
        let at = |place: usize| slots.map(|slot| row.values.get(slot + place).copied().unwrap_or_default());
        positions.push(Position { command: at(0), actual: at(1) });
        lines.push(row.line);
    }
    positions_of(&positions, &lines, &rows.file, options)
}

fn positions_of(positions: &[Position], lines: &[u32], file: &Path, options: &Options) -> Result<Test> {
    let of = |refused: BallbarRefusal| match refused {
        BallbarRefusal::NotAReading { index } => {
            let line = lines.get(index).map_or_else(String::new, |line| format!(":{line}"));
            anyhow!("{}{line}: found a position that is not finite, needed numbers", file.display())
        }
        refused => anyhow!("{}: {refused}", file.display()),
    };
    for (c, axis) in options.axes.into_iter().enumerate() {
        let [command, actual] = [|own: &Position| own.command, |own: &Position| own.actual]
            .map(|of| positions.iter().map(|own| of(own)[c]).collect::<Vec<f64>>());
        if let Some(stuck) = record::left_behind(&command, &actual) {
            let (letter, line) = (axis.letter().to_ascii_lowercase(), lines.get(stuck.from));
            let found = format!("{} for {} readings in a row while the command moves", stuck.value, stuck.count);
            let needed = "a sensor whose readings change".into();
            let column = Some(format!("{letter}_mm"));
            return Err(FileError { file: file.into(), line: line.copied(), column, found, needed }.into());
        }
    }
    let readings = readings(options.radius_mm, positions).map_err(of)?;
    Test::of(readings, true, options).map_err(|refused| match refused {
        BallbarRefusal::NotAReading { .. } => {
            let found = "a position farther from the circle than half its radius";
            whole(file, found.into(), "actual positions of the commanded circle, in mm".into())
        }
        refused => anyhow!("{}: {refused}", file.display()),
    })
}

/// Whether the first line consists of numbers separated by blanks.
fn is_halsampler(bytes: &[u8]) -> bool {
    let mut lines = bytes.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.find(|line| !line.is_empty()).unwrap_or_default();
    let words = first.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    let mut count = 0;
    for word in words {
        count += 1;
        if std::str::from_utf8(word).ok().and_then(|word| word.parse::<f64>().ok()).is_none() {
            return false;
        }
    }
    count > 1
}

/// Reads the samples and their lines; refuses a line that says `overrun` or has other columns, and a gap in the numbers.
fn halsampler(bytes: &[u8], file: &Path) -> Result<(Vec<Position>, Vec<u32>)> {
    let (mut positions, mut lines) = (Vec::new(), Vec::new());
    let mut last: Option<f64> = None;
    for (number, line) in (1..).zip(bytes.split(|byte| *byte == b'\n')) {
        let line = String::from_utf8_lossy(line);
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let values: Option<Vec<f64>> = words.iter().map(|word| word.parse().ok()).collect();
        let refused = |found: String, needed: &str| {
            let (file, found) = (file.into(), found.chars().take(80).collect());
            Err(FileError { file, line: Some(number), column: None, found, needed: needed.into() }.into())
        };
        match values.as_deref() {
            Some([]) => continue,
            Some(&[ref sample @ .., a_command, a, b_command, b]) if sample.len() <= 1 => {
                if let (Some(last), Some(sample)) = (last, sample.first())
                    && *sample != last + 1.0
                {
                    return refused(format!("sample {sample} after {last}"), "every cycle, none lost");
                }
                last = sample.first().copied();
                positions.push(Position { command: [a_command, b_command], actual: [a, b] });
                lines.push(number);
            }
            _ => {
                let needed =
                    "command and position of the first axis, of the second, or these after the sample's number";
                return refused(format!("{:?}", line.trim()), needed);
            }
        }
    }
    Ok((positions, lines))
}

fn whole(file: &Path, found: String, needed: String) -> anyhow::Error {
    FileError { file: file.into(), line: None, column: None, found, needed }.into()
}
