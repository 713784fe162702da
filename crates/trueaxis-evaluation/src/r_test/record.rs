//! RECORD.csv of an R-test.

use crate::record;
use crate::rows::{Column, Rows};
use anyhow::{Result, anyhow};
use std::collections::HashMap;
use trueaxis::machine::AXES;

/// Columns of a record.
pub const COLUMNS: [Column; 10] = [
    Column { name: "x_mm", needed: true },
    Column { name: "y_mm", needed: true },
    Column { name: "z_mm", needed: true },
    Column { name: "a_deg", needed: false },
    Column { name: "b_deg", needed: false },
    Column { name: "c_deg", needed: false },
    Column { name: "dx_um", needed: true },
    Column { name: "dy_um", needed: true },
    Column { name: "dz_um", needed: true },
    Column { name: "ball", needed: false },
];

/// One reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Line of the file.
    pub line: u32,
    /// Commanded position of X Y Z A B C, mm and degrees.
    pub place: [f64; AXES],
    /// Displacement of the tool from the ball, actual − commanded, machine directions, mm.
    pub displacement_mm: [f64; 3],
    /// Index of the ball.
    pub ball: usize,
}

/// The record of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// All readings.
    pub readings: Vec<Reading>,
    /// Numbers of the balls.
    pub balls: Vec<i64>,
}

impl Record {
    /// Reads all rows of [`COLUMNS`].
    ///
    /// # Errors
    /// A row that cannot be read or is repeated, a displacement beyond the probes' travel, a probe that stops changing.
    pub fn read(rows: &mut Rows<'_, 10>) -> Result<Record> {
        let (mut readings, mut balls, mut read) = (Vec::new(), Vec::new(), HashMap::new());
        while let Some(row) = rows.next()? {
            let [x, y, z, a, b, c, dx, dy, dz, ball] = row.values;
            if ball.fract() != 0.0 {
                return Err(rows.error(row.line, "ball", ball, "the number of a ball"));
            }
            // A pose may be read again to check drift; the last digits of a probe do not repeat.
            let key = [a, b, c, ball, dx, dy, dz].map(|value| (value + 0.0).to_bits());
            if let Some(first) = read.insert(key, row.line) {
                let found = format!("the angles, ball and readings of line {first} again");
                return Err(rows.error(row.line, "dx_um", found, "a row for every reading"));
            }
            let displacement_mm = [dx, dy, dz].map(|um| 1e-3 * um);
            for (mm, name) in displacement_mm.into_iter().zip(["dx_um", "dy_um", "dz_um"]) {
                record::displacement(rows, row.line, name, [1e3 * mm, 0.0])?;
            }
            let ball = balls.iter().position(|known| *known == ball as i64).unwrap_or_else(|| {
                balls.push(ball as i64);
                balls.len() - 1
            });
            readings.push(Reading { line: row.line, place: [x, y, z, a, b, c], displacement_mm, ball });
        }
        let lines: Vec<u32> = readings.iter().map(|reading: &Reading| reading.line).collect();
        for (c, name) in ["dx_um", "dy_um", "dz_um"].into_iter().enumerate() {
            let values: Vec<f64> = readings.iter().map(|reading| reading.displacement_mm[c]).collect();
            if let Some(stuck) = record::longest(&values) {
                return Err(stuck.error(rows, &lines, name, 1e3));
            }
        }
        let poses: Vec<Vec<[f64; 3]>> = (0..balls.len())
            .map(|ball| {
                let own = readings.iter().filter(|reading: &&Reading| reading.ball == ball);
                own.map(|reading| [3, 4, 5].map(|axis| reading.place[axis])).collect()
            })
            .collect();
        if let Some(missing) = record::missing(&poses, |one, other| one == other) {
            let [like, row] = missing.like;
            let ([a, b, c], [found, needed]) = (poses[like][row], missing.rows);
            return Err(anyhow!(
                "{}: ball {}: found {found} of {needed} readings, none at A {a}, B {b}, C {c} degrees, needed the same poses as for ball {}",
                rows.file.display(),
                balls[missing.part],
                balls[like]
            ));
        }
        Ok(Record { readings, balls })
    }

    /// Largest distance, mm, between a repeated reading of a pose and the first reading of that pose, and their lines.
    pub fn repeated(&self) -> Option<(f64, [u32; 2])> {
        let mut first = HashMap::new();
        let mut largest: Option<(f64, [u32; 2])> = None;
        for reading in &self.readings {
            let [.., a, b, c] = reading.place;
            let before = first.entry(([a, b, c].map(|deg| (deg + 0.0).to_bits()), reading.ball)).or_insert(reading);
            if before.line == reading.line {
                continue;
            }
            let squares = (0..3).map(|k| (reading.displacement_mm[k] - before.displacement_mm[k]).powi(2));
            let apart = squares.sum::<f64>().sqrt();
            if largest.is_none_or(|(most, _)| apart > most) {
                largest = Some((apart, [before.line, reading.line]));
            }
        }
        largest
    }
}
