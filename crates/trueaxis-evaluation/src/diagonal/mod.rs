//! Diagonal and step-diagonal displacement tests: reads a record and presents the results as a document and as figures.
//!
//! The mathematics is [`trueaxis_metrology::diagonal`].

mod document;
mod shown;

pub use document::{DiagonalDocument, DiagonalFigures, Point, Shape, Steps, Value, additions};

use crate::range::OutOfRange;
use crate::record;
use crate::rows::{Column, Rows};
use anyhow::{Result, anyhow};
use trueaxis_metrology::accuracy::Direction;
use trueaxis_metrology::diagonal::{DiagonalRefusal, Reading, Test};
use trueaxis_tables::text::counted;

/// Columns of a record.
pub const COLUMNS: [Column; 7] = [
    Column { name: "diagonal", needed: true },
    Column { name: "run", needed: false },
    Column { name: "direction", needed: true },
    Column { name: "x_mm", needed: true },
    Column { name: "y_mm", needed: true },
    Column { name: "z_mm", needed: true },
    Column { name: "deviation_um", needed: true },
];

/// Largest deviation, µm: 0.5 % of a diagonal of two metres.
const MOST_UM: f64 = 1e4;
/// Positions closer together than this, as a share of the box, are identical.
const SAME: f64 = 1e-4;

/// Checks the range of the mirror's alignment.
///
/// # Errors
/// Outside 0.001 to 100000 µrad.
pub fn check(alignment_urad: Option<f64>) -> Result<(), OutOfRange> {
    OutOfRange::check("alignment_urad", alignment_urad, 1e-3..=1e5, "µrad")
}

/// Reads all rows of [`COLUMNS`].
///
/// # Errors
/// An unreadable row, a diagonal that is not 1 to 4 or is missing, a repeated target, or a missing one that other diagonals or
/// runs have, a laser that is stuck or reads an impossible value, lines that are not the four diagonals of a box.
pub fn read(rows: &mut Rows<'_, 7>) -> Result<Test> {
    let (mut lines, mut readings) = (Vec::new(), Vec::new());
    while let Some(row) = rows.next()? {
        let [diagonal, run, direction, x, y, z, deviation_um] = row.values;
        if ![1.0, 2.0, 3.0, 4.0].contains(&diagonal) {
            return Err(rows.error(row.line, "diagonal", diagonal, "1, 2, 3 or 4"));
        }
        if direction == 0.0 {
            return Err(rows.error(row.line, "direction", 0, "1 away from the diagonal's first target, -1 back"));
        }
        if !(0.0..=1e6).contains(&run) || run.fract() != 0.0 {
            return Err(rows.error(row.line, "run", run, "a number from 1"));
        }
        if deviation_um.abs() > MOST_UM {
            let needed =
                format!("at most {MOST_UM} um either way: the column has another unit, or the laser lost its beam");
            return Err(rows.error(row.line, "deviation_um", deviation_um, needed));
        }
        lines.push(row.line);
        readings.push(Reading {
            diagonal: diagonal as usize - 1,
            run: run as u32,
            direction: if direction > 0.0 { Direction::Up } else { Direction::Down },
            position_mm: [x, y, z],
            deviation_mm: 1e-3 * deviation_um,
        });
    }
    let deviations: Vec<f64> = readings.iter().map(|reading| reading.deviation_mm).collect();
    if let Some(stuck) = record::longest(&deviations) {
        return Err(stuck.error(rows, &lines, "deviation_um", 1e3));
    }
    whole(rows, &lines, &readings)?;
    Test::new(readings).map_err(|refused| match refused {
        DiagonalRefusal::Twice { index, first } => {
            let [line, before] = [index, first].map(|index| lines.get(index).copied().unwrap_or(1));
            let found = format!("this target a second time in this run and direction, first in line {before}");
            rows.error(line, "deviation_um", found, "each target once a run and direction")
        }
        refused => anyhow!("{}: {refused}", rows.file.display()),
    })
}

/// Refuses a diagonal or run with fewer readings than the others, naming the missing position: without the first reading of a
/// diagonal, a different box would result.
fn whole(rows: &Rows<'_, 7>, lines: &[u32], readings: &[Reading]) -> Result<()> {
    let ends = |c: usize| {
        let all = readings.iter().map(|reading| reading.position_mm[c]);
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], q| [low.min(q), high.max(q)])
    };
    let ends = [0, 1, 2].map(ends);
    let share = |c: usize, q: f64| (q - ends[c][0]) / (ends[c][1] - ends[c][0]).max(f64::MIN_POSITIVE);
    let of = |diagonal: usize| readings.iter().filter(move |reading| reading.diagonal == diagonal);
    // Direction of each axis along a diagonal, from its start; relative to it, every diagonal takes the same path.
    let backward = [0, 1, 2, 3].map(|diagonal| {
        let away = of(diagonal).find(|reading| reading.direction == Direction::Up).or(of(diagonal).next_back());
        [0, 1, 2].map(|c| away.is_some_and(|first| share(c, first.position_mm[c]) > 0.5))
    });
    let turned =
        |diagonal: usize, way: [f64; 3]| [0, 1, 2].map(|c| if backward[diagonal][c] { 1.0 - way[c] } else { way[c] });
    for (direction, word) in [(Direction::Up, "away"), (Direction::Down, "back")] {
        let (mut names, mut parts) = (Vec::new(), Vec::<Vec<([f64; 3], usize)>>::new());
        for (index, reading) in readings.iter().enumerate().filter(|(_, reading)| reading.direction == direction) {
            let name = (reading.diagonal, reading.run);
            let part = names.iter().position(|known| *known == name).unwrap_or_else(|| {
                names.push(name);
                parts.push(Vec::new());
                names.len() - 1
            });
            let way = [0, 1, 2].map(|c| share(c, reading.position_mm[c]));
            parts[part].push((turned(reading.diagonal, way), index));
        }
        let same = |one: &([f64; 3], usize), other: &([f64; 3], usize)| {
            one.0.iter().zip(other.0).all(|(one, other)| (one - other).abs() < SAME)
        };
        if let Some(missing) = record::missing(&parts, same) {
            let (diagonal, run) = names[missing.part];
            let [like, row] = missing.like;
            let (way, index) = parts[like][row];
            let way = turned(diagonal, way);
            let [x, y, z] = [0, 1, 2].map(|c| (1e6 * (ends[c][0] + way[c] * (ends[c][1] - ends[c][0]))).round() / 1e6);
            let [found, needed] = missing.rows;
            return Err(anyhow!(
                "{}: diagonal {}, run {run}, {word}: found {found} of {needed} readings, none at X {x}, Y {y}, Z {z} mm, needed \
                 the same targets as on diagonal {}, run {} (line {})",
                rows.file.display(),
                diagonal + 1,
                names[like].0 + 1,
                names[like].1,
                lines[index]
            ));
        }
        let runs: Vec<Vec<usize>> =
            [0, 1, 2, 3].map(|diagonal| (0..names.iter().filter(|name| name.0 == diagonal).count()).collect()).to_vec();
        let absent =
            readings.iter().map(|reading| reading.diagonal).collect::<std::collections::HashSet<_>>().len() < 4;
        if let Some(missing) = record::missing(&runs, |one, other| one == other).filter(|_| !absent) {
            let [found, needed] = missing.rows;
            return Err(anyhow!(
                "{}: diagonal {}: found {} {word}, needed {needed} as on diagonal {}",
                rows.file.display(),
                missing.part + 1,
                counted(found, "run"),
                missing.like[0] + 1
            ));
        }
    }
    Ok(())
}
