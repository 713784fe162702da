//! Linear measurements of Renishaw's laser software, `.rtl`.
//!
//! ```text
//! HEADER::
//! File type  : rtl
//! TARGET DATA::
//! Target-count: 3
//! Targets :
//! 0.000000  100.000000  200.000000
//! Flags: 0 0 2 0
//! USER-TEXT::
//! Axis:X
//! RUNS::
//! Run-count:2
//! DEVIATIONS::
//! Run Target Data:
//! 1   1      0.1
//! 1   2      1.4
//! 1   3      2.0
//! 2   3      2.9
//! 2   2      2.2
//! 2   1      0.8
//! EOF::
//! ```
//!
//! Targets in mm, over any number of lines; below `Run Target Data:` the number of the run, that of the target from 1, and the
//! deviation, measured − target, in µm: value = +E. The direction of a run is that in which its targets follow one another.
//! The runs are evaluated like those of [`iso230_2`].
//!
//! No specification is public: this is what programs that write or read the format agree on. Refused are files of another type
//! (angles, straightness), a run that turns round or is zero throughout (one program writes the missing direction of a
//! unidirectional measurement so), and counts that the file does not keep.

use super::iso230_2;
use super::{Imported, axis_of, within};
use crate::error::FileError;
use crate::origin::{Origin, numbered};
use trueaxis::machine::Axis;
use trueaxis::range;
use trueaxis_metrology::accuracy::{Approach, Direction, Measurement};

/// Most runs and targets that are read.
const MOST: usize = 100_000;

/// A row of the deviations, with its line.
struct Row {
    line: u32,
    run: u32,
    target: usize,
    deviation: f64,
}

/// Contents of a file.
#[derive(Default)]
struct Content {
    file_type: Option<String>,
    axis: Option<(u32, Axis)>,
    target_count: Option<(u32, usize)>,
    run_count: Option<(u32, usize)>,
    targets: Vec<(u32, f64)>,
    rows: Vec<Row>,
}

pub(super) fn import(text: &str, origin: &Origin, wanted: Option<Axis>) -> Result<Imported, FileError> {
    let content = content(text, origin)?;
    match content.file_type.as_deref() {
        Some("rtl") => {}
        Some(other) => return Err(origin.whole(format!("File type {other:?}"), "rtl, a linear measurement")),
        None => return Err(origin.whole("no File type below HEADER::", "File type : rtl")),
    }
    if content.rows.is_empty() {
        return Err(origin.whole("no rows below Run Target Data:", "the deviations of the runs"));
    }
    let axis = match (content.axis, wanted) {
        (Some((line, named)), Some(wanted)) if named != wanted => {
            return Err(origin.at(line, "Axis", named.letter(), format!("axis {}", wanted.letter())));
        }
        (Some((_, axis)), _) | (None, Some(axis)) => axis,
        (None, None) => return Err(origin.whole("no axis of one letter below USER-TEXT::", "the axis (--axis X)")),
    };
    if axis.is_rotary() {
        return Err(origin.whole(format!("axis {}", axis.letter()), "a linear axis: units of angles are not known"));
    }
    for (stated, found, name) in [
        (content.target_count, content.targets.len(), "Target-count"),
        (content.run_count, content.runs().count(), "Run-count"),
    ] {
        if let Some((line, count)) = stated
            && count != found
        {
            return Err(origin.at(line, name, count, format!("{found}, as the file has")));
        }
    }
    for (line, target) in &content.targets {
        within(origin, *line, "Targets", *target, &range::POSITION.linear)?;
    }
    let mut approaches = Vec::new();
    let mut lines = Vec::new();
    for rows in content.runs() {
        let positions =
            rows.iter().map(|row| target(row, &content.targets, origin)).collect::<Result<Vec<f64>, _>>()?;
        let direction = direction(rows, &positions, origin)?;
        for (row, position) in rows.iter().zip(positions) {
            within(origin, row.line, "Data", row.deviation / 1e3, &range::TRANSLATION)?;
            approaches.push(Approach { position, run: row.run, direction, deviation: row.deviation });
            lines.push(row.line);
        }
    }
    let measurement = Measurement::new(axis, numbered_runs(approaches))
        .map_err(|error| iso230_2::incomplete(&error, &lines, origin))?;
    iso230_2::imported(&measurement, vec![String::from("deviations in um, measured − target: +E")], origin)
}

/// The approaches with the runs of each direction numbered from 1.
fn numbered_runs(mut approaches: Vec<Approach>) -> Vec<Approach> {
    for direction in [Direction::Up, Direction::Down] {
        let own = approaches.iter().filter(|approach| approach.direction == direction);
        let mut numbers: Vec<u32> = own.map(|approach| approach.run).collect();
        numbers.dedup();
        for approach in approaches.iter_mut().filter(|approach| approach.direction == direction) {
            let place = numbers.iter().position(|number| *number == approach.run).unwrap_or_default();
            approach.run = place as u32 + 1;
        }
    }
    approaches
}

impl Content {
    /// The rows of each run.
    fn runs(&self) -> impl Iterator<Item = &[Row]> {
        self.rows.chunk_by(|before, row| before.run == row.run)
    }
}

/// Position of a row's target.
fn target(row: &Row, targets: &[(u32, f64)], origin: &Origin) -> Result<f64, FileError> {
    let found = row.target.checked_sub(1).and_then(|index| targets.get(index));
    found.map(|(_, position)| *position).ok_or_else(|| {
        origin.at(row.line, "Target", row.target, format!("1 to {}, the targets of the file", targets.len()))
    })
}

/// Direction of travel of a run over these positions.
fn direction(rows: &[Row], positions: &[f64], origin: &Origin) -> Result<Direction, FileError> {
    let Some(first) = rows.first() else { return Ok(Direction::Up) };
    if rows.len() > 1 && rows.iter().all(|row| row.deviation == 0.0) {
        let found = format!("run {} zero throughout, as if it had not been measured", first.run);
        return Err(origin.at(first.line, "Data", found, "runs that were measured"));
    }
    let rises = |pair: &[f64]| matches!(pair, [before, after] if after > before);
    let falls = |pair: &[f64]| matches!(pair, [before, after] if after < before);
    match (positions.windows(2).all(rises), positions.windows(2).all(falls)) {
        (true, false) => Ok(Direction::Up),
        (false, true) => Ok(Direction::Down),
        _ => {
            let found = format!("run {} with targets that do not follow one another", first.run);
            Err(origin.at(first.line, "Target", found, "two targets or more in one direction of travel"))
        }
    }
}

/// Part of a file that is being read.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    Other,
    Targets,
    Rows,
}

/// Splits a file into its sections.
fn content(text: &str, origin: &Origin) -> Result<Content, FileError> {
    let mut content = Content::default();
    let (mut section, mut part) = (String::new(), Part::Other);
    for (line, text) in numbered(text.trim_start_matches('\u{feff}')) {
        let text = text.trim();
        if let Some(name) = text.strip_suffix("::") {
            (section, part) = (name.trim().to_uppercase(), Part::Other);
            continue;
        }
        let pair = text.split_once(':').map(|(key, value)| (key.trim(), value.trim()));
        let whole = |name: &str, text: &str| {
            let value = text.parse::<usize>().ok().filter(|value| *value <= MOST);
            value
                .map(|value| (line, value))
                .ok_or_else(|| origin.at(line, name, format!("{text:?}"), format!("a whole number up to {MOST}")))
        };
        match (section.as_str(), pair) {
            ("HEADER", Some(("File type", value))) => content.file_type = Some(value.to_lowercase()),
            ("USER-TEXT", Some(("Axis", value))) => {
                content.axis = axis_of(value).map(|axis| (line, axis));
            }
            ("TARGET DATA", Some(("Target-count", value))) => {
                content.target_count = Some(whole("Target-count", value)?)
            }
            ("TARGET DATA", Some(("Targets", ""))) => part = Part::Targets,
            ("RUNS", Some(("Run-count", value))) => content.run_count = Some(whole("Run-count", value)?),
            ("DEVIATIONS", Some(("Run Target Data", ""))) => part = Part::Rows,
            (_, Some(_)) => part = Part::Other,
            (_, None) if part == Part::Targets => {
                for text in text.split_whitespace() {
                    content.targets.push((line, origin.number(line, "Targets", text)?));
                }
            }
            (_, None) if part == Part::Rows && !text.is_empty() => content.rows.push(row(line, text, origin)?),
            (_, None) => {}
        }
        if content.rows.len() > MOST || content.targets.len() > MOST {
            return Err(origin.at(line, "", format!("more than {MOST} rows"), "a measurement of an axis"));
        }
    }
    Ok(content)
}

/// A row of the deviations.
fn row(line: u32, text: &str, origin: &Origin) -> Result<Row, FileError> {
    let fields: Vec<&str> = text.split_whitespace().collect();
    let [run, target, deviation] = fields.as_slice() else {
        let needed = "the numbers of the run and of the target, and the deviation";
        return Err(origin.at(line, "", format!("{text:?}"), needed));
    };
    let number = |name: &str, text: &str| {
        text.parse::<u32>()
            .ok()
            .filter(|number| *number > 0 && *number as usize <= MOST)
            .ok_or_else(|| origin.at(line, name, format!("{text:?}"), "a whole number from 1"))
    };
    Ok(Row {
        line,
        run: number("Run", run)?,
        target: number("Target", target)? as usize,
        deviation: origin.number(line, "Data", deviation)?,
    })
}
