//! MEASURED.csv as a ball test: every set-up at every angle.

use crate::record::{self, Channel};
use crate::rows::{Column, Row, Rows};
use anyhow::{Result, anyhow};
use std::path::Path;
use trueaxis::Axis;
use trueaxis_metrology::identification::{AngleReadings, Ball, BallTest};
use trueaxis_tables::text::counted;

/// Columns of the readings.
pub const COLUMNS: [Column; 6] = [
    Column { name: "angle_deg", needed: true },
    Column { name: "l_mm", needed: true },
    Column { name: "h_mm", needed: true },
    Column { name: "dx_um", needed: true },
    Column { name: "dy_um", needed: true },
    Column { name: "dz_um", needed: true },
];

/// Angles closer than this are equal, degrees: a hundredth of the finest rotary encoder's resolution.
pub const SAME_ANGLE_DEG: f64 = 1e-6;

/// A test as read from a file, angles in degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    /// Positions of the axis, increasing.
    pub angles_deg: Vec<f64>,
    /// The set-ups.
    pub balls: Vec<Ball>,
    /// Deviations by angle, then by set-up, mm.
    pub deviations_mm: Vec<Vec<[f64; 3]>>,
}

/// A row of one set-up.
struct Reading {
    line: u32,
    angle_deg: f64,
    deviation_mm: [f64; 3],
}

struct SetUp {
    ball: Ball,
    readings: Vec<Reading>,
}

impl Readings {
    /// Reads and checks all rows of [`COLUMNS`]; those of each set-up are in increasing order of the angle.
    ///
    /// # Errors
    /// A row that cannot be read, angles that do not increase or exceed a full turn, fewer than three set-ups, a set-up
    /// without a row at an angle of the others, a deviation beyond a probe's travel, a probe that stops changing half-way.
    pub fn read(rows: &mut Rows<'_, 6>) -> Result<Readings> {
        let file = rows.file.clone();
        let set_ups = by_set_up(rows)?;
        if set_ups.len() < 3 {
            let named: Vec<String> = set_ups.iter().map(|set_up| name(set_up.ball)).collect();
            return Err(anyhow!(
                "{}: columns l_mm, h_mm: found {} ({}), needed at least 3 that are not on one line",
                file.display(),
                counted(named.len(), "set-up"),
                named.join("; ")
            ));
        }
        let mut angles_deg: Vec<f64> = set_ups.iter().flat_map(|s| s.readings.iter().map(|r| r.angle_deg)).collect();
        angles_deg.sort_by(f64::total_cmp);
        angles_deg.dedup_by(|next, kept| same(*next, *kept));
        within_a_circle(rows, &set_ups, &angles_deg)?;
        let deviations_mm = angles_deg
            .iter()
            .map(|&angle| set_ups.iter().map(|set_up| reading_at(&file, set_up, angle)).collect())
            .collect::<Result<_>>()?;
        Ok(Readings { angles_deg, balls: set_ups.iter().map(|set_up| set_up.ball).collect(), deviations_mm })
    }

    /// The test of an axis that turns by `direction` times its position.
    pub fn test(&self, axis: Axis, direction: f64) -> BallTest {
        let angles = self.angles_deg.iter().zip(&self.deviations_mm);
        let angles = angles
            .map(|(angle, deviations_mm)| AngleReadings {
                angle_rad: (direction * angle).to_radians(),
                deviations_mm: deviations_mm.clone(),
            })
            .collect();
        BallTest { axis, balls: self.balls.clone(), angles }
    }
}

/// Name of a set-up in messages.
fn name(ball: Ball) -> String {
    format!("l_mm {}, h_mm {}", ball.vertical_mm, ball.horizontal_mm)
}

fn same(one: f64, other: f64) -> bool {
    (one - other).abs() <= SAME_ANGLE_DEG
}

fn by_set_up(rows: &mut Rows<'_, 6>) -> Result<Vec<SetUp>> {
    let mut set_ups: Vec<SetUp> = Vec::new();
    let (mut lines, mut angles, mut values_um) = (Vec::new(), Vec::new(), [const { Vec::new() }; 3]);
    while let Some(Row { line, values }) = rows.next()? {
        let [angle_deg, vertical_mm, horizontal_mm, dx, dy, dz] = values;
        lines.push(line);
        angles.push(angle_deg);
        for ((values, value), column) in values_um.iter_mut().zip([dx, dy, dz]).zip(&COLUMNS[3..]) {
            record::displacement(rows, line, column.name, [value, 0.0])?;
            values.push(value);
        }
        let ball = Ball { vertical_mm, horizontal_mm };
        let reading = Reading { line, angle_deg, deviation_mm: [dx, dy, dz].map(|value| 1e-3 * value) };
        let Some(set_up) = set_ups.iter_mut().find(|set_up| set_up.ball == ball) else {
            set_ups.push(SetUp { ball, readings: vec![reading] });
            continue;
        };
        if let Some(before) = set_up.readings.last().filter(|before| before.angle_deg + SAME_ANGLE_DEG >= angle_deg) {
            if let Some(twin) = set_up.readings.iter().find(|before| same(before.angle_deg, angle_deg)) {
                let found = format!("a second row for {} at {angle_deg}, as in line {}", name(ball), twin.line);
                return Err(rows.error(line, "angle_deg", found, "one row for each set-up and angle"));
            }
            let needed =
                format!("more than {} of line {} (angles of a set-up increase)", before.angle_deg, before.line);
            return Err(rows.error(line, "angle_deg", angle_deg, needed));
        }
        set_up.readings.push(reading);
    }
    if let Some(most) = record::radians(&angles) {
        return Err(rows.error(lines[most], "angle_deg", angles[most], record::DEGREES));
    }
    let channels = [0, 1, 2].map(|c| Channel { name: COLUMNS[3 + c].name, values: &values_um[c], scale: 1.0 });
    record::alive(rows, &lines, &channels)?;
    Ok(set_ups)
}

/// Refuses angles beyond a full turn, which may end with the angle that closes the circle.
fn within_a_circle(rows: &Rows<'_, 6>, set_ups: &[SetUp], angles_deg: &[f64]) -> Result<()> {
    let (Some(&first), Some(&last)) = (angles_deg.first(), angles_deg.last()) else { return Ok(()) };
    if last - first <= 360.0 + SAME_ANGLE_DEG {
        return Ok(());
    }
    let readings = set_ups.iter().flat_map(|set_up| &set_up.readings);
    let line = readings.filter(|reading| same(reading.angle_deg, last)).map(|reading| reading.line).min();
    let needed = format!("at most {}, a full turn after the first angle {first}", first + 360.0);
    Err(rows.error(line.unwrap_or(1), "angle_deg", last, needed))
}

fn reading_at(file: &Path, set_up: &SetUp, angle: f64) -> Result<[f64; 3]> {
    let row = set_up.readings.iter().find(|reading| same(reading.angle_deg, angle));
    row.map(|reading| reading.deviation_mm).ok_or_else(|| {
        anyhow!(
            "{}: column angle_deg: found no row at angle {angle} for the set-up {}, needed one for each set-up and angle",
            file.display(),
            name(set_up.ball)
        )
    })
}
