//! Thermal tests after ISO 230-3: reads a record and evaluates it to a document. The mathematics is in
//! [`trueaxis_metrology::drift`].
//!
//! Five probes measure a mandrel: x1, y1, z at its tip and x2, y2 a distance L further up, towards the spindle. The tilts
//! follow, right-handed about the machine's axes: A = −(y2 − y1)/L, B = (x2 − x1)/L.

mod document;
mod shown;

pub use document::{Channel, Place, Temperature, ThermalTestDocument};

use crate::range::OutOfRange;
use crate::record;
use crate::rows::{Column, Row, Rows};
use anyhow::Result;
use trueaxis_tables::text::counted;

/// Displacements and temperatures of a record.
pub const COLUMNS: [Column; 10] = [
    Column { name: "t_s", needed: true },
    Column { name: "position", needed: false },
    Column { name: "x1_um", needed: false },
    Column { name: "y1_um", needed: false },
    Column { name: "z_um", needed: false },
    Column { name: "x2_um", needed: false },
    Column { name: "y2_um", needed: false },
    Column { name: "ambient_c", needed: false },
    Column { name: "spindle_c", needed: false },
    Column { name: "machine_c", needed: false },
];
/// First displacement and first temperature among the columns.
const DISPLACEMENTS: std::ops::Range<usize> = 2..7;
const TEMPERATURES: std::ops::Range<usize> = 7..10;
/// The tests of ISO 230-3: environmental temperature variation error, rotating spindle, moving linear axis.
pub const KINDS: [&str; 3] = ["etve", "spindle", "axis"];
/// Minimum number of readings at a position.
const LEAST: usize = 10;
/// Temperature that no shop has, °C.
const HOTTEST_C: f64 = 150.0;

/// A test with one series per position; microns, degrees Celsius, seconds from the first reading.
#[derive(Clone, Debug, PartialEq)]
pub struct Test {
    /// Positions of the moving axis, 0 if the record names none.
    pub positions: Vec<i64>,
    /// Times at every position.
    pub times_s: Vec<Vec<f64>>,
    /// x1, y1, z, x2, y2 at every position; empty if not recorded.
    pub displacements_um: Vec<[Vec<f64>; 5]>,
    /// Times of the temperatures: all rows.
    pub all_times_s: Vec<f64>,
    /// ambient, spindle, machine; empty if not recorded.
    pub temperatures_c: [Vec<f64>; 3],
    /// Longest time without a reading, and the line after which it begins.
    pub gap_s: (f64, u32),
}

/// Checks the period and the distance of the probes.
///
/// # Errors
/// A period outside 0.1 to 100000 min, a distance outside 1 to 10000 mm.
pub fn check(period_min: f64, distance_mm: Option<f64>) -> Result<(), OutOfRange> {
    OutOfRange::check("period_min", period_min, 0.1..=1e5, "min")?;
    OutOfRange::check("distance_mm", distance_mm, 1.0..=1e4, "mm")
}

/// Reads all rows of [`COLUMNS`].
///
/// # Errors
/// A row that cannot be read, a time that does not increase, no displacement at all, too few readings, an impossible
/// temperature or displacement, a probe that stops changing half-way, a missing position in a fixed sequence.
pub fn read(rows: &mut Rows<'_, 10>) -> Result<Test> {
    let present = rows.present;
    let recorded: Vec<usize> = DISPLACEMENTS.filter(|&c| present[c]).collect();
    if recorded.is_empty() {
        return Err(rows.error(1, "x1_um", "no displacement", "at least one of x1_um, y1_um, z_um, x2_um, y2_um"));
    }
    let all = rows.all()?;
    let mut before = f64::NEG_INFINITY;
    for row in &all {
        let [time, position, ..] = row.values;
        if time <= before {
            return Err(rows.error(row.line, "t_s", time, format!("more than {before} of the line before")));
        }
        before = time;
        if position.fract() != 0.0 {
            return Err(rows.error(row.line, "position", position, "the number of a position"));
        }
        for c in TEMPERATURES {
            if row.values[c].abs() > HOTTEST_C {
                let needed = format!("a temperature of at most {HOTTEST_C} °C");
                return Err(rows.error(row.line, COLUMNS[c].name, row.values[c], needed));
            }
        }
    }
    let start = all.first().map_or(0.0, |row| row.values[0]);
    let mut test = Test {
        positions: Vec::new(),
        times_s: Vec::new(),
        displacements_um: Vec::new(),
        all_times_s: all.iter().map(|row| row.values[0] - start).collect(),
        temperatures_c: [7, 8, 9]
            .map(|c| if present[c] { all.iter().map(|row| row.values[c]).collect() } else { Vec::new() }),
        gap_s: (0.0, 1),
    };
    for pair in all.windows(2) {
        let gap = pair[1].values[0] - pair[0].values[0];
        if gap > test.gap_s.0 {
            test.gap_s = (gap, pair[0].line);
        }
    }
    for row in &all {
        let number = row.values[1] as i64;
        if !test.positions.contains(&number) {
            test.positions.push(number);
        }
    }
    test.positions.sort_unstable();
    in_turn(rows, &all, &test.positions)?;
    for &number in &test.positions {
        let own: Vec<_> = all.iter().filter(|row| row.values[1] as i64 == number).collect();
        if own.len() < LEAST {
            let line = own.last().map_or(1, |row| row.line);
            return Err(rows.error(
                line,
                "t_s",
                format!("{} at position {number}", counted(own.len(), "reading")),
                format!("at least {LEAST}"),
            ));
        }
        let lines: Vec<u32> = own.iter().map(|row| row.line).collect();
        let series = |c: usize| -> Vec<f64> { own.iter().map(|row| row.values[c]).collect() };
        let first = own.first().map_or([0.0; 10], |row| row.values);
        for row in &own {
            for &c in &recorded {
                record::displacement(rows, row.line, COLUMNS[c].name, [row.values[c], first[c]])?;
            }
        }
        let channels: Vec<(usize, Vec<f64>)> = recorded.iter().map(|&c| (c, series(c))).collect();
        let channels: Vec<record::Channel<'_>> = (channels.iter())
            .map(|(c, values)| record::Channel { name: COLUMNS[*c].name, values, scale: 1.0 })
            .collect();
        record::alive(rows, &lines, &channels)?;
        test.times_s.push(own.iter().map(|row| row.values[0] - start).collect());
        test.displacements_um.push([2, 3, 4, 5, 6].map(|c| if present[c] { series(c) } else { Vec::new() }));
    }
    Ok(test)
}

/// Positions do not follow a fixed sequence if more than this share of the rows breaks it.
const OUT_OF_TURN: f64 = 0.05;

/// Refuses a missing row if the positions follow one another in a fixed sequence.
fn in_turn(rows: &Rows<'_, 10>, all: &[Row<10>], positions: &[i64]) -> Result<()> {
    let pairs = || all.windows(2).map(|pair| [pair[0].values[1] as i64, pair[1].values[1] as i64]);
    let behind = |from: i64| positions.iter().max_by_key(|to| pairs().filter(|pair| *pair == [from, **to]).count());
    let next: Vec<(i64, i64)> = positions.iter().filter_map(|&from| Some((from, *behind(from)?))).collect();
    let follows = |[from, to]: [i64; 2]| next.contains(&(from, to));
    let broken = pairs().filter(|pair| !follows(*pair)).count();
    if next.iter().any(|(from, to)| from == to) || broken as f64 > OUT_OF_TURN * all.len() as f64 {
        return Ok(());
    }
    let Some((k, [from, to])) = pairs().enumerate().find(|(_, pair)| !follows(*pair)) else { return Ok(()) };
    let needed = next.iter().find(|(own, _)| *own == from).map_or(from, |(_, to)| *to);
    let needed = format!("{needed}, which follows {from} everywhere else: a row is missing");
    Err(rows.error(all[k + 1].line, "position", to, needed))
}
