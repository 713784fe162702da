//! A fine scan or a ballbar's record, read from CSV.

use super::{Circle, Options};
use crate::ballbar;
use crate::record::{self, Channel};
use crate::rows::{Column, Rows};
use anyhow::Result;
use std::path::PathBuf;
use trueaxis::Axis;
use trueaxis_metrology::periodic::{Place, Reading};
use trueaxis_tables::error::FileError;

const fn free(name: &'static str) -> Column {
    Column { name, needed: false }
}

/// Columns of a scan: position, error of one direction or of both; then those of a ballbar's record.
pub const COLUMNS: [Column; 11] = [
    free("position_mm"),
    free("position_deg"),
    free("error_um"),
    free("error_urad"),
    free("fwd_um"),
    free("rev_um"),
    free("fwd_urad"),
    free("rev_urad"),
    free("direction"),
    free("angle_deg"),
    free("deviation_um"),
];

/// Indices of [`COLUMNS`] that a linear axis has; those of a rotary axis follow each.
const POSITION: usize = 0;
const ERROR: usize = 2;
const FORWARD: [usize; 2] = [4, 6];
const DIRECTION: usize = 8;
const ANGLE: usize = 9;
const DEVIATION: usize = 10;

/// Readings of a circle closer to a reversal than this are left out: spikes and play, degrees.
const REVERSAL_DEG: f64 = 3.0;
const WAYS: &str = "1, + or fwd for positive travel, -1, - or rev for negative travel";
const NO_WAY: &str = "a column direction, since the travel turns round: 1, + or fwd; -1, - or rev";
const TURNS: &str = "1, + or ccw for counterclockwise, -1, - or cw for clockwise";

/// A record and its file.
#[derive(Clone, Debug)]
pub struct Recording {
    /// The file as errors name it.
    pub file: PathBuf,
    /// Its readings.
    pub readings: Vec<Reading>,
    /// Number of readings that were left out.
    pub left_out: usize,
}

fn direction(word: &str) -> Option<f64> {
    match word.to_ascii_lowercase().as_str() {
        "fwd" => Some(1.0),
        "rev" => Some(-1.0),
        _ => ballbar::direction(word),
    }
}

impl Recording {
    /// Reads the rows of a file opened with [`COLUMNS`]: a scan (`position_mm,error_um` with a `direction`, which the
    /// order of the rows gives if they do not turn round, or `position_mm,fwd_um,rev_um`; of a rotary axis in deg and urad), or
    /// a ballbar's `angle_deg,deviation_um,direction` if the options state its circle.
    ///
    /// # Errors
    /// A row that cannot be read, columns of neither form, a direction of 0, an error that no instrument reads or that stops
    /// changing half-way.
    pub fn read(rows: Rows<'_, 11>, options: &Options) -> Result<Recording> {
        let mut rows = rows.with_words("direction", direction);
        let rotary = usize::from(options.axis.is_rotary());
        let [position, error, forward, reverse] =
            [POSITION + rotary, ERROR + rotary, FORWARD[rotary], FORWARD[rotary] + 1];
        let has = |rows: &Rows<'_, 11>, all: &[usize]| all.iter().all(|column| rows.present[*column]);
        match &options.circle {
            Some(circle) if has(&rows, &[ANGLE, DEVIATION, DIRECTION]) => of_circle(&mut rows, circle, options.axis),
            None if has(&rows, &[position, error]) => {
                scan(&mut rows, position, |values, way| [(values[error], way), (f64::NAN, 0.0)], error)
            }
            None if has(&rows, &[position, forward, reverse]) => {
                scan(&mut rows, position, |values, _| [(values[forward], 1.0), (values[reverse], -1.0)], forward)
            }
            circle => {
                let names =
                    |all: &[usize]| all.iter().map(|column| COLUMNS[*column].name).collect::<Vec<_>>().join(", ");
                let of_bar = names(&[ANGLE, DEVIATION, DIRECTION]);
                let needed = match circle {
                    Some(_) => format!("the columns {of_bar}; no --radius-mm and --centre-mm for a scan"),
                    None => format!(
                        "the columns {}, or {}; for {of_bar} also --radius-mm and --centre-mm",
                        names(&[position, error]),
                        names(&[position, forward, reverse])
                    ),
                };
                let found = format!("columns {}", rows.header.join(", "));
                Err(FileError { file: rows.file.clone(), line: None, column: None, found, needed }.into())
            }
        }
    }
}

/// Travel of rows that state no direction.
#[derive(Default)]
struct Order {
    last: Option<f64>,
    is_rising: bool,
    is_falling: bool,
}

impl Order {
    /// Takes the next position, and returns whether the travel turns round before it.
    fn turns(&mut self, position: f64) -> bool {
        let before = self.last.unwrap_or(position);
        if position > before && self.is_falling || position < before && self.is_rising {
            return true;
        }
        self.is_rising |= position > before;
        self.is_falling |= position < before;
        self.last = Some(position);
        false
    }
}

/// Reads a scan; `of` gives the readings of a row with their directions, NaN for none. `named`: column of the first of them.
fn scan(
    rows: &mut Rows<'_, 11>,
    position: usize,
    of: impl Fn(&[f64; 11], f64) -> [(f64, f64); 2],
    named: usize,
) -> Result<Recording> {
    // Two columns name their directions; one without a column of directions is read in the order of its rows.
    let has_way = rows.present[DIRECTION];
    let in_order = !has_way && COLUMNS[named].name.starts_with("error");
    let mut order = Order::default();
    let (mut readings, mut lines) = (Vec::new(), Vec::new());
    while let Some(row) = rows.next()? {
        let way = if has_way { row.values[DIRECTION] } else { 1.0 };
        if way == 0.0 {
            return Err(rows.error(row.line, "direction", 0, WAYS));
        }
        if in_order && order.turns(row.values[position]) {
            let found = format!("{} against the travel before it", row.values[position]);
            return Err(rows.error(row.line, COLUMNS[position].name, found, NO_WAY));
        }
        for (error, way) in of(&row.values, way).into_iter().filter(|(error, _)| error.is_finite()) {
            if COLUMNS[named].name.ends_with("_um") {
                record::displacement(rows, row.line, COLUMNS[named].name, [error, 0.0])?;
            }
            let (position, is_negative) = (row.values[position], way < 0.0);
            let own = Place { position, is_negative, share: 1.0 };
            readings.push(Reading { own, other: None, along: position, pass: usize::from(is_negative), error });
            lines.push(row.line);
        }
    }
    if order.is_falling {
        for own in &mut readings {
            (own.own.is_negative, own.pass) = (true, 1);
        }
    }
    let values: Vec<f64> = readings.iter().map(|own| own.error).collect();
    record::alive(rows, &lines, &[Channel { name: COLUMNS[named].name, values: &values, scale: 1.0 }])?;
    Ok(Recording { file: rows.file.clone(), readings, left_out: 0 })
}

fn of_circle(rows: &mut Rows<'_, 11>, circle: &Circle, axis: Axis) -> Result<Recording> {
    let (mut readings, mut lines, mut angles) = (Vec::new(), Vec::new(), Vec::new());
    let mut left_out = 0;
    while let Some(row) = rows.next()? {
        let (degrees, error, sense) = (row.values[ANGLE], row.values[DEVIATION], row.values[DIRECTION]);
        if sense == 0.0 {
            return Err(rows.error(row.line, "direction", 0, TURNS));
        }
        record::displacement(rows, row.line, "deviation_um", [error, 0.0])?;
        angles.push(degrees);
        lines.push(row.line);
        let to_reversal = (degrees / 90.0 - (degrees / 90.0).round()).abs() * 90.0;
        if to_reversal < REVERSAL_DEG {
            left_out += 1;
            continue;
        }
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let place = |of: usize, share: f64, rate: f64| Place {
            position: circle.centre_mm.get(circle.axes[of].index()).copied().unwrap_or_default()
                + circle.radius_mm * share,
            is_negative: sense * rate < 0.0,
            share,
        };
        let both = [place(0, cosine, -sine), place(1, sine, cosine)];
        let [own, other] = if circle.axes[0] == axis { both } else { [both[1], both[0]] };
        let (along, pass) = (degrees.rem_euclid(360.0), usize::from(sense < 0.0));
        readings.push(Reading { own, other: Some(other), along, pass, error });
    }
    if let Some(most) = record::radians(&angles) {
        return Err(rows.error(lines[most], "angle_deg", angles[most], record::DEGREES));
    }
    let values: Vec<f64> = readings.iter().map(|own| own.error).collect();
    record::alive(rows, &lines, &[Channel { name: "deviation_um", values: &values, scale: 1.0 }])?;
    Ok(Recording { file: rows.file.clone(), readings, left_out })
}
