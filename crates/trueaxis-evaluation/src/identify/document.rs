//! The identified errors, as a document.

use super::Readings;
use crate::uncertainty::{CovarianceDocument, Estimate, band_factor, expanded};
use serde::Serialize;
use serde_json::{Map, Value};
use trueaxis::Axis;
use trueaxis::machine::Twist;
use trueaxis_metrology::identification::{Identified, IdentifiedAngle, Location};

/// The JSON document.
#[derive(Clone, Debug, Serialize)]
pub struct IdentificationDocument {
    /// Letter of the axis.
    pub axis: String,
    /// Set-ups of the ball.
    pub set_ups: Vec<SetUp>,
    /// Errors at every angle.
    pub angles: Vec<Angle>,
    /// Standard deviation of one reading, from the residuals of all angles.
    pub sigma_um: f64,
    /// Root mean square of the standard errors over the angles.
    pub standard_errors: Map<String, Value>,
    /// Half-widths of 95 % intervals: standard errors times Student's factor.
    pub expanded_uncertainties: Map<String, Value>,
    /// Number of readings minus the unknowns that they determine.
    pub degrees_of_freedom: usize,
    /// Whether the errors include location errors: "inside" or "removed".
    pub location: &'static str,
    /// Number of combinations that no reading observes and that the convention of free offsets fixes; 0 without free offsets.
    pub null_space: usize,
    /// Remarks on the result, a sentence each.
    pub warnings: Vec<String>,
}

/// Where a ball was set up.
#[derive(Clone, Debug, Serialize)]
pub struct SetUp {
    /// Distance below the intersection of the rotary axes, mm.
    pub l_mm: f64,
    /// Distance beside the intersection, mm.
    pub h_mm: f64,
    /// The offset found, if offsets are free.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset_um: Option<[f64; 3]>,
}

/// Errors at an angle.
#[derive(Clone, Debug, Serialize)]
pub struct Angle {
    /// Position of the axis.
    pub angle_deg: f64,
    #[serde(flatten)]
    errors: Map<String, Value>,
    /// Root mean square of the readings' residuals.
    pub residual_um: f64,
    /// Condition number.
    pub condition: f64,
    /// Rank: 6 if all errors are determined.
    pub rank: u8,
    standard_errors: Map<String, Value>,
    expanded_uncertainties: Map<String, Value>,
    /// Covariance of the errors at this angle; its diagonal has the squares of their standard errors. Errors of different angles
    /// are independent if the offsets are known; free offsets correlate them too, which it does not show.
    pub covariance: CovarianceDocument,
    /// The errors, µm and µrad.
    #[serde(skip)]
    pub values: [f64; 6],
    /// Standard errors of `values`, µm and µrad.
    #[serde(skip)]
    pub deviations: [f64; 6],
}

/// Names of the six errors as columns of a table, `EXC_um` to `ECC_urad`.
pub fn names(axis: Axis) -> [String; 6] {
    Axis::ALL.map(|moved| {
        let unit = if moved.is_rotary() { "urad" } else { "um" };
        format!("E{}{}_{unit}", moved.letter(), axis.letter())
    })
}

/// Converts mm and rad to µm and µrad.
pub fn micro(twist: &Twist) -> [f64; 6] {
    let [x, y, z, a, b, c] = *twist;
    [1e3 * x, 1e3 * y, 1e3 * z, 1e6 * a, 1e6 * b, 1e6 * c]
}

fn named(axis: Axis, values: [f64; 6]) -> Map<String, Value> {
    names(axis).iter().zip(values).map(|(name, value)| (name.to_lowercase(), Value::from(value))).collect()
}

fn covariance(axis: Axis, angle: &IdentifiedAngle) -> CovarianceDocument {
    let estimates = Axis::ALL.into_iter().zip(names(axis)).zip(angle.errors).map(|((moved, name), value)| {
        let (unit, factor) = if moved.is_rotary() { ("urad", 1e6) } else { ("um", 1e3) };
        Estimate { name: name.to_lowercase(), unit, factor, value }
    });
    CovarianceDocument::of(estimates.collect(), |i, j| angle.covariance[i][j])
}

impl IdentificationDocument {
    pub(super) fn new(readings: &Readings, found: &Identified, warnings: Vec<String>) -> IdentificationDocument {
        let count = found.angles.len().max(1) as f64;
        let factor = band_factor(found.degrees_of_freedom as f64);
        let mean = std::array::from_fn(|i| {
            let squares = found.angles.iter().map(|angle| micro(&angle.standard_errors)[i].powi(2));
            (squares.sum::<f64>() / count).sqrt()
        });
        let set_ups = readings.balls.iter().enumerate().map(|(s, ball)| SetUp {
            l_mm: ball.vertical_mm,
            h_mm: ball.horizontal_mm,
            offset_um: found.offsets_mm.get(s).map(|offset| offset.map(|value| 1e3 * value)),
        });
        let angles = readings.angles_deg.iter().zip(&found.angles).map(|(&angle_deg, angle)| {
            let (values, deviations) = (micro(&angle.errors), micro(&angle.standard_errors));
            Angle {
                angle_deg,
                errors: named(found.axis, values),
                residual_um: 1e3 * angle.residual_mm,
                condition: angle.condition,
                rank: angle.rank,
                standard_errors: named(found.axis, deviations),
                expanded_uncertainties: named(found.axis, deviations.map(|error| factor * error)),
                covariance: covariance(found.axis, angle),
                values,
                deviations,
            }
        });
        IdentificationDocument {
            axis: found.axis.letter().to_string(),
            set_ups: set_ups.collect(),
            angles: angles.collect(),
            sigma_um: 1e3 * found.sigma_mm,
            expanded_uncertainties: expanded(&named(found.axis, mean), found.degrees_of_freedom as f64),
            standard_errors: named(found.axis, mean),
            degrees_of_freedom: found.degrees_of_freedom,
            location: match found.location {
                Location::Inside => "inside",
                Location::Removed => "removed",
            },
            null_space: found.null_space,
            warnings,
        }
    }

    /// Explains `location` in a sentence.
    pub fn location_sentence(&self) -> &'static str {
        match (self.location, self.axis.as_str()) {
            ("inside", _) => "inside: the errors contain the axis' location errors and the zero of the gauges",
            (_, "C") => "removed: EXC, EYC, EZC have no mean; constant angular errors are inside",
            _ => {
                "removed: the translations have no mean, and the angular errors lack the part that rotates with the axis"
            }
        }
    }
}
