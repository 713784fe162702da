//! Errors identified from an R-test, as a document.

use super::{RTestFit, Record, name};
use crate::uncertainty::{CovarianceDocument, Estimate};
use serde::Serialize;
use trueaxis_tables::Machine;

/// A location error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Term {
    /// Name, such as `EX0C`.
    pub name: String,
    /// `um` or `urad`.
    pub unit: &'static str,
    /// Value of the error.
    pub value: f64,
    /// Standard error of the value.
    pub standard_error: f64,
    /// Value in the machine before the test.
    pub before: f64,
}

/// The JSON document.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RTestDocument {
    /// Number of readings in the record.
    pub readings: usize,
    /// Number of balls.
    pub balls: usize,
    /// Range of the displacements along X, Y, Z over all readings (ISO 10791-6, tests BK).
    pub range_um: [f64; 3],
    /// Location errors found.
    pub terms: Vec<Term>,
    /// Covariance of the location errors; its diagonal has the squares of their standard errors.
    pub covariance: CovarianceDocument,
    /// Offsets of the balls from their commanded places, workpiece's frame.
    pub balls_um: Vec<[f64; 3]>,
    /// Zero of the nest, tool's frame; null if the nest was calibrated.
    pub sensor_um: Option<[f64; 3]>,
    /// Root mean square of the readings, without the balls' places.
    pub rms_um: f64,
    /// Root mean square of the residuals.
    pub left_rms_um: f64,
    /// Largest residual.
    pub left_max_um: f64,
    /// Line of the largest residual.
    pub left_max_line: u32,
    /// Standard deviation of a coordinate.
    pub sigma_um: f64,
    /// Coordinates minus unknowns.
    pub degrees_of_freedom: usize,
    /// Rank: all unknowns.
    pub rank: usize,
    /// Condition number of the scaled columns.
    pub condition: f64,
    /// Remarks on the result.
    pub notes: Vec<String>,
}

/// Condition number from which poses are doubtful.
const DOUBTFUL_CONDITION: f64 = 100.0;

impl RTestDocument {
    /// The document of the errors found from a record on a machine.
    pub fn new(record: &Record, found: &RTestFit, machine: &Machine) -> RTestDocument {
        let scaled = |component: usize| if component < 3 { ("um", 1e3) } else { ("urad", 1e6) };
        let terms = found.terms.iter().map(|&((axis, component), value, error)| {
            let (unit, scale) = scaled(component);
            let before = machine.settings.location.of(axis).map_or(0.0, |own| own[component]);
            Term {
                name: name((axis, component)),
                unit,
                value: scale * value,
                standard_error: scale * error,
                before: scale * before,
            }
        });
        let estimates = found.terms.iter().map(|&(error, value, _)| {
            let (unit, factor) = scaled(error.1);
            Estimate { name: name(error), unit, factor, value }
        });
        let covariance = CovarianceDocument::of(estimates.collect(), |i, j| found.covariance[i][j]);
        let along = |c: usize| record.readings.iter().map(move |reading| 1e3 * reading.displacement_mm[c]);
        let range_um = [0, 1, 2].map(|c| along(c).fold(f64::MIN, f64::max) - along(c).fold(f64::MAX, f64::min));
        let mean = [0, 1, 2].map(|c| along(c).sum::<f64>() / record.readings.len().max(1) as f64);
        let squares: f64 = (0..3).flat_map(|c| along(c).map(move |um| (um - mean[c]).powi(2))).sum();
        let size = |[x, y, z]: [f64; 3]| 1e3 * (x * x + y * y + z * z).sqrt();
        let left = || found.left_mm.iter().map(|left| size(*left));
        let count = record.readings.len().max(1) as f64;
        let (left_max_line, left_max_um) = record
            .readings
            .iter()
            .zip(left())
            .map(|(reading, left)| (reading.line, left))
            .fold((0, 0.0), |worst, one| if one.1 >= worst.1 { one } else { worst });
        let mut notes = vec![format!(
            "the linear axes' own errors and the errors that are not fitted are removed, as {} predicts them in positive travel",
            machine.settings.name
        )];
        if let Some((apart, [first, again])) = record.repeated() {
            notes.push(format!(
                "a pose that was read again differs by {:.2} µm at most, lines {first} and {again}",
                1e3 * apart
            ));
        }
        if found.sensor_mm.is_none() {
            notes.push(
                "the nest is assumed to be calibrated to the spindle and tool_mm; --free-sensor makes its zero an unknown"
                    .into(),
            );
        }
        if found.condition > DOUBTFUL_CONDITION {
            notes.push(format!(
                "condition number {:.0}: some errors are that many times less accurate than the readings",
                found.condition
            ));
        }
        if found.clamped {
            notes.push("an axis is beyond its table, where the edge value is used".into());
        }
        RTestDocument {
            readings: record.readings.len(),
            balls: record.balls.len(),
            range_um,
            terms: terms.collect(),
            covariance,
            balls_um: found.balls_mm.iter().map(|ball| ball.map(|mm| 1e3 * mm)).collect(),
            sensor_um: found.sensor_mm.map(|zero| zero.map(|mm| 1e3 * mm)),
            rms_um: (squares / count).sqrt(),
            left_rms_um: (left().map(|um| um * um).sum::<f64>() / count).sqrt(),
            left_max_um,
            left_max_line,
            sigma_um: 1e3 * found.sigma_mm,
            degrees_of_freedom: found.degrees_of_freedom,
            rank: found.rank,
            condition: found.condition,
            notes,
        }
    }
}
