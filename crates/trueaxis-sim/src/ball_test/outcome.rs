//! The whole sequence and its results.

use super::corrected::{identified, table, tip_errors};
use super::cycle::AxisCycle;
use super::{BallCycle, rotary_only};
use crate::error::{Result, SimError};
use serde::Serialize;
use trueaxis::Axis;
use trueaxis::machine::Twist;
use trueaxis_metrology::identification::{BallTest, Identified, Observation, Offsets, identify, solve_angle};
use trueaxis_tables::Table;
use trueaxis_tables::formats::write_axis_csv;

/// Size of the true tip error, µm.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct TipError {
    /// Largest magnitude.
    pub max: f64,
    /// Root mean square of the magnitude.
    pub rms: f64,
}

/// True tip error at an angle: root mean square of its magnitude over the set-ups, µm.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Stop {
    /// Angle of the axis.
    pub angle_deg: f64,
    /// Without correction.
    pub before_um: f64,
    /// With the correction of the identified tables.
    pub after_um: f64,
}

/// One axis: readings, identified errors, remaining errors.
#[derive(Debug)]
pub struct AxisOutcome {
    /// The axis.
    pub axis: Axis,
    /// The readings.
    pub readings: BallTest,
    /// Angles of the stops, degrees.
    pub stops_deg: Vec<f64>,
    /// Identified errors.
    pub found: Identified,
    /// The table made from them.
    pub table: Table,
    /// True tip error over the angle.
    pub over_angle: Vec<Stop>,
    /// Without correction.
    pub before: TipError,
    /// With the correction.
    pub after: TipError,
}

/// Result of the sequence.
#[derive(Debug)]
pub struct Outcome {
    /// Results for C, then A.
    pub axes: Vec<AxisOutcome>,
    /// Both axes together, without correction.
    pub before: TipError,
    /// Both axes together, with correction.
    pub after: TipError,
}

/// Runs the sequence.
pub(super) fn run(test: &BallCycle) -> Result<Outcome> {
    let plant = rotary_only(&test.machine)?;
    let mut found = Vec::new();
    for (stream, axis) in [(0, Axis::C), (1, Axis::A)] {
        let cycle = AxisCycle::of(axis);
        let readings = cycle.measure(test, &plant, stream)?;
        let errors = identify(&readings, Offsets::Known)
            .map_err(|error| SimError::Identification { at: format!("axis {}", axis.letter()), error })?;
        found.push((cycle, readings, errors));
    }
    let at_zero = shared_pose(&found)?;
    let found: Vec<_> = found
        .into_iter()
        .map(|(cycle, readings, errors)| {
            let table = table(&cycle.stops_deg, &errors, &at_zero);
            (cycle, readings, errors, table)
        })
        .collect();
    let tables: Vec<(Axis, Table)> = found.iter().map(|(cycle, _, _, table)| (cycle.axis, table.clone())).collect();
    let known = identified(&plant, &tables);
    let mut axes = Vec::new();
    for (cycle, readings, found, table) in found {
        let set_ups: Vec<Vec<[[f64; 3]; 2]>> =
            cycle.balls.iter().map(|&ball| tip_errors(&cycle, &plant, &known, ball)).collect::<Result<_>>()?;
        let over_angle = cycle.judged_deg.iter().enumerate().map(|(k, &angle_deg)| {
            let size = |which: usize| {
                let squares = set_ups.iter().map(|errors| square_um2(&errors[k][which]));
                (squares.sum::<f64>() / set_ups.len() as f64).sqrt()
            };
            Stop { angle_deg, before_um: size(0), after_um: size(1) }
        });
        let size = |which: usize| size_of(set_ups.iter().flatten().map(|errors| square_um2(&errors[which])));
        axes.push(AxisOutcome {
            axis: cycle.axis,
            readings,
            over_angle: over_angle.collect(),
            before: size(0),
            after: size(1),
            stops_deg: cycle.stops_deg,
            found,
            table,
        });
    }
    let both = |pick: fn(&AxisOutcome) -> TipError| TipError {
        max: axes.iter().map(|axis| pick(axis).max).fold(0.0, f64::max),
        // Both axes count equally, however many angles they have.
        rms: (axes.iter().map(|axis| pick(axis).rms.powi(2)).sum::<f64>() / axes.len().max(1) as f64).sqrt(),
    };
    Ok(Outcome { before: both(|axis| axis.before), after: both(|axis| axis.after), axes })
}

/// Errors of C and A together with both at 0, from the readings of both cycles there.
///
/// Uses six set-ups at one pose: with either axis' own estimate, the noise of that one stop would be carried to levers that
/// were not measured at it.
fn shared_pose(found: &[(AxisCycle, BallTest, Identified)]) -> Result<Twist> {
    let mut seen = Vec::new();
    for (_, readings, _) in found {
        for at_zero in readings.angles.iter().filter(|angle| angle.angle_rad == 0.0) {
            let pairs = readings.balls.iter().zip(&at_zero.deviations_mm);
            seen.extend(pairs.map(|(&ball, &deviation_mm)| Observation { ball, deviation_mm }));
        }
    }
    Ok(solve_angle(Axis::C, 0.0, &seen)
        .map_err(|error| SimError::Identification { at: "A and C at 0".into(), error })?
        .errors)
}

fn square_um2(error_mm: &[f64; 3]) -> f64 {
    error_mm.iter().map(|value| (1e3 * value).powi(2)).sum()
}

fn size_of(squares: impl Iterator<Item = f64>) -> TipError {
    let (mut sum, mut largest, mut count) = (0.0, 0.0, 0.0_f64);
    for square in squares {
        sum += square;
        largest = f64::max(largest, square);
        count += 1.0;
    }
    TipError { max: f64::sqrt(largest), rms: (sum / count.max(1.0)).sqrt() }
}

impl Outcome {
    /// Files of the test, name and text: the readings in the format that `trueaxis identify` reads, and the resulting tables.
    pub fn files(&self) -> Vec<(String, String)> {
        let mut files = Vec::new();
        for of in &self.axes {
            let letter = of.axis.letter().to_ascii_lowercase();
            let mut text = String::from("angle_deg,l_mm,h_mm,dx_um,dy_um,dz_um\n");
            for (angle, readings) in of.stops_deg.iter().zip(&of.readings.angles) {
                for (ball, deviation) in of.readings.balls.iter().zip(&readings.deviations_mm) {
                    let [x, y, z] = deviation.map(|value| 1e3 * value);
                    text += &format!("{angle},{},{},{x:.6},{y:.6},{z:.6}\n", ball.vertical_mm, ball.horizontal_mm);
                }
            }
            files.push((format!("measured-{letter}.csv"), text));
            files.push((format!("{letter}.csv"), write_axis_csv(&of.table, of.axis)));
        }
        files
    }
}
