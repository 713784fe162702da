//! Errors identified from points, as a document.

use super::{Points, PointsFit};
use crate::diagonal::Value;
use crate::uncertainty::{CovarianceDocument, Estimate};
use serde::Serialize;
use trueaxis_metrology::volumetric::{AXES, COMPONENTS, SMOOTHING};
use trueaxis_report::number::significant;
use trueaxis_tables::formats::machine_files;

/// One of the 21 errors.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Function {
    /// Name, such as `EXX`.
    pub name: String,
    /// `um` or `urad`.
    pub unit: &'static str,
    /// Smallest and largest value.
    pub range: [f64; 2],
    /// Root mean square of the standard errors of the nodes.
    pub standard_error: f64,
    /// Largest standard error of a node.
    pub worst_standard_error: f64,
}

/// Squarenesses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Squareness {
    /// A0Z.
    pub a0z_urad: Value,
    /// B0Z.
    pub b0z_urad: Value,
    /// C0Y.
    pub c0y_urad: Value,
}

/// Lengths of vectors over points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Left {
    /// Number of points.
    pub points: usize,
    /// Largest.
    pub max_um: f64,
    /// Root mean square.
    pub rms_um: f64,
    /// Line of the largest length.
    pub line: u32,
}

/// The JSON document.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointsDocument {
    /// Number of points in the file.
    pub points: usize,
    /// Number of nodes of X, Y, Z.
    pub nodes: [usize; 3],
    /// Errors that the tables contain.
    pub functions: Vec<Function>,
    /// Squareness.
    pub squareness: Squareness,
    /// Covariance of the squarenesses; its diagonal has the squares of their standard errors. The errors of the axes have too
    /// many nodes for a matrix.
    pub covariance: CovarianceDocument,
    /// Angular errors that the points do not determine, left at zero.
    pub unseen: Vec<String>,
    /// Deviation of the points, without the instrument's placement.
    pub before: Left,
    /// Residual of all points with the errors in the machine, by its own model.
    pub left: Left,
    /// Residual of every tenth point in a fit without them; null with fewer than 60 points.
    pub held_out: Option<Left>,
    /// Shift of the instrument, mm.
    pub shift_mm: [f64; 3],
    /// Rotation of the instrument, µrad.
    pub turn_urad: [f64; 3],
    /// Errors of the reflectors' offsets, from the second reflector on.
    pub offsets_um: Vec<[f64; 3]>,
    /// Standard deviation of a coordinate (with mean stated uncertainty), from the residuals.
    pub sigma_um: f64,
    /// Ratio of the residuals to the stated uncertainties; null if none are stated.
    pub sigma_over_stated: Option<f64>,
    /// Coordinates minus unknowns.
    pub degrees_of_freedom: usize,
    /// Number of unknowns.
    pub unknowns: usize,
    /// Number of conditions that fix the quantities which no point determines.
    pub conventions: usize,
    /// Rank of points and conditions.
    pub rank: usize,
    /// Condition number of the scaled columns.
    pub condition: f64,
    /// Weight of second differences of the tables relative to a reading.
    pub smoothing: f64,
    /// Remarks on the result.
    pub notes: Vec<String>,
}

/// Lengths of vectors, mm, with their lines.
pub(super) fn left(of: impl Iterator<Item = (u32, [f64; 3])>) -> Left {
    let mut found = Left { points: 0, max_um: 0.0, rms_um: 0.0, line: 0 };
    for (line, [x, y, z]) in of {
        let squared = 1e6 * (x * x + y * y + z * z);
        found.points += 1;
        found.rms_um += squared;
        if squared.sqrt() >= found.max_um {
            (found.max_um, found.line) = (squared.sqrt(), line);
        }
    }
    found.rms_um = (found.rms_um / found.points.max(1) as f64).sqrt();
    found
}

impl PointsDocument {
    /// The document of the errors found from points.
    pub fn new(points: &Points, found: &PointsFit) -> PointsDocument {
        let lines = || points.points.iter().map(|point| point.line);
        let errors = &found.errors;
        let mut functions = Vec::new();
        for (axis, letter) in AXES.into_iter().enumerate() {
            for (component, of) in COMPONENTS.into_iter().enumerate() {
                if component >= 3 && !found.basis.seen[axis][component] {
                    continue;
                }
                let (unit, scale) = if component < 3 { ("um", 1e3) } else { ("urad", 1e6) };
                let values = errors.errors[axis][component].iter().map(|value| scale * value);
                let range = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
                let deviations = || errors.standard_errors[axis][component].iter().map(|value| scale * value);
                let squares: f64 = deviations().map(|value| value * value).sum();
                functions.push(Function {
                    name: format!("E{of}{letter}"),
                    unit,
                    range,
                    standard_error: (squares / deviations().count().max(1) as f64).sqrt(),
                    worst_standard_error: deviations().fold(0.0, f64::max),
                });
            }
        }
        let value = |k: usize| Value {
            value: 1e6 * errors.squareness[k],
            standard_error: 1e6 * errors.squareness_errors[k],
            degrees_of_freedom: errors.degrees_of_freedom as f64,
        };
        let estimates = ["A0Z", "B0Z", "C0Y"].into_iter().zip(errors.squareness);
        let estimates =
            estimates.map(|(name, value)| Estimate { name: name.into(), unit: "urad", factor: 1e6, value }).collect();
        let covariance = CovarianceDocument::of(estimates, |i, j| errors.squareness_covariance[i][j]);
        let mean = (points.points.iter().map(|point| point.sigma_mm.powi(2)).sum::<f64>()
            / points.points.len().max(1) as f64)
            .sqrt();
        let held_out = || found.held_out_mm.iter().map(|(index, left)| (points.points[*index].line, *left));
        let [tx, ty, tz, a, b, c] = errors.placement;
        PointsDocument {
            points: points.points.len(),
            nodes: [0, 1, 2].map(|axis| found.basis.nodes_mm[axis].len()),
            functions,
            squareness: Squareness { a0z_urad: value(0), b0z_urad: value(1), c0y_urad: value(2) },
            covariance,
            unseen: found.unseen.clone(),
            before: left(lines().zip(found.deviations_mm.iter().copied())),
            left: left(lines().zip(found.left_mm.iter().copied())),
            held_out: (!found.held_out_mm.is_empty()).then(|| left(held_out())),
            shift_mm: [tx, ty, tz],
            turn_urad: [a, b, c].map(|rad| 1e6 * rad),
            offsets_um: errors.offsets_mm.iter().map(|offset| offset.map(|mm| 1e3 * mm)).collect(),
            sigma_um: 1e3 * errors.sigma * mean,
            sigma_over_stated: points.stated.then_some(errors.sigma),
            degrees_of_freedom: errors.degrees_of_freedom,
            unknowns: errors.unknowns,
            conventions: errors.conventions,
            rank: errors.rank,
            condition: errors.condition,
            smoothing: SMOOTHING,
            notes: notes(points, found),
        }
    }
}

impl PointsDocument {
    /// Files of the machine with the errors, as (name, text); `source` is the name of the points' file.
    pub fn files(&self, found: &PointsFit, source: &str) -> Vec<(String, String)> {
        let comment = format!(
            "Measured: {} points of {source}; left {} um RMS, held out {} um RMS.",
            self.points,
            significant(self.left.rms_um, 3),
            self.held_out.map_or_else(|| "-".into(), |left| significant(left.rms_um, 3))
        );
        machine_files(&found.machine, &comment)
    }
}

fn notes(points: &Points, found: &PointsFit) -> Vec<String> {
    let mut notes = vec![
        "the instrument is on the workpiece's side; its placement is removed, errors are zero at the reference position, \
         straightnesses have no slope"
            .to_owned(),
    ];
    if !found.unseen.is_empty() {
        notes.push(format!(
            "{}: no lever in these points separates them from translations of the same axis; with them at zero, the tables are valid for {}",
            found.unseen.join(" "),
            if points.tools_mm.len() > 1 { "these reflector offsets" } else { "this reflector offset" }
        ));
    }
    if found.held_out_mm.is_empty() {
        notes.push(
            "every point is fitted: the record has fewer than 60, or too few remain when one in ten is held out".into(),
        );
    }
    if found.errors.sigma > 2.0 && points.stated {
        notes.push(format!(
            "the residuals are {:.1} times as large as the stated uncertainties allow",
            found.errors.sigma
        ));
    }
    notes.extend(found.limits.iter().cloned());
    notes
}
