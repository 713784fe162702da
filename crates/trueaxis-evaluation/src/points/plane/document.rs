//! Errors identified from points in a plane, as a document.

use super::machine::squareness;
use super::selection::{mean_square, square};
use super::{LINEAR, PlaneErrors, PlaneFit, Transfer};
use crate::diagonal::Value;
use crate::points::document::left;
use crate::points::{Function, Left};
use serde::Serialize;
use trueaxis_report::number::significant;
use trueaxis_tables::formats::machine_files;

/// A model that was compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CandidateDocument {
    /// Name of the model.
    pub model: String,
    /// Number of unknowns.
    pub unknowns: usize,
    /// Number of unknowns that the points determine.
    pub rank: usize,
    /// Root mean square of the predictions' errors at held-out points, µm; null if the points do not determine the model.
    pub held_out_um: Option<f64>,
    /// Root mean square of the residuals of all points, µm.
    pub left_um: f64,
    /// Coordinates minus rank.
    pub degrees_of_freedom: usize,
}

/// A scale or squareness.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlaneTerm {
    /// `scale X`, `C0Y` and the like.
    pub name: String,
    /// `ppm` or `urad`.
    pub unit: &'static str,
    /// Value and standard error.
    #[serde(flatten)]
    pub of: Value,
}

/// The JSON document.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlaneDocument {
    /// Number of points in the file.
    pub points: usize,
    /// Letters of the axes along which the points vary.
    pub plane: [char; 2],
    /// Name of the chosen model.
    pub model: String,
    /// All models that were compared.
    pub models: Vec<CandidateDocument>,
    /// Deviations of the points in the plane, without the plate's placement.
    pub before: Left,
    /// Residuals of all points.
    pub left: Left,
    /// Residuals of the points in fits that each lack a tenth of them, among these the point.
    pub held_out: Left,
    /// Standard deviation of a coordinate, from the residuals: noise and what the model does not describe.
    pub sigma_um: f64,
    /// Ratio of the residuals to the stated uncertainties; null if none are stated.
    pub sigma_over_stated: Option<f64>,
    /// Coordinates minus rank.
    pub degrees_of_freedom: usize,
    /// Number of unknowns of the chosen model.
    pub unknowns: usize,
    /// Number of them that the points determine.
    pub rank: usize,
    /// Scales and squareness; empty for a map.
    pub terms: Vec<PlaneTerm>,
    /// Errors that the tables contain; empty for a map.
    pub functions: Vec<Function>,
    /// Largest errors of the map along both axes, µm; null for tables.
    pub map_um: Option<[f64; 2]>,
    /// Nodes of the tables or of the grid along both axes.
    pub nodes: [usize; 2],
    /// Largest difference between grid and map at the points, µm; null for tables.
    pub grid_off_um: Option<f64>,
    /// Shift of the plate, mm.
    pub shift_mm: [f64; 2],
    /// Rotation of the plate from the first axis toward the second, µrad.
    pub turn_urad: f64,
    /// Errors and axes that the points do not show.
    pub left_alone: Vec<String>,
    /// Test on another record; null without one.
    pub transfer: Option<Transfer>,
    /// Remarks on the result.
    pub notes: Vec<String>,
}

impl PlaneDocument {
    /// The document of the errors found; `stated`: whether the record states uncertainties.
    pub fn new(found: &PlaneFit, stated: bool) -> PlaneDocument {
        let fitted = found.fitted();
        let mean_weight = found.points.iter().map(|point| point.weight).sum::<f64>() / found.points.len().max(1) as f64;
        let of = |residuals: &[[f64; 2]]| {
            let lines = found.points.iter().zip(residuals).map(|(point, [u, v])| (point.line, [*u, *v, 0.0]));
            left(lines)
        };
        let held_out = found.candidates[found.chosen].held_out.as_deref().unwrap_or_default();
        let (terms, functions) = terms(found);
        let (mut nodes, mut map_um, mut grid_off_um) = ([0; 2], None, None);
        match &found.errors {
            PlaneErrors::None => {}
            PlaneErrors::Tables(tables) => nodes = [0, 1].map(|k| tables.nodes_mm[k].len()),
            PlaneErrors::Grid(grid) => {
                nodes = [0, 1].map(|k| grid.nodes_mm[k].len());
                map_um =
                    Some([0, 1].map(|k| 1e3 * grid.values.iter().fold(0.0, |most: f64, of| most.max(of[k].abs()))));
                grid_off_um = Some(1e3 * grid.off_mm);
            }
        }
        let [u, v, turn] = found.placement;
        PlaneDocument {
            points: found.points.len(),
            plane: found.letters(),
            model: found.model(),
            models: models(found),
            before: of(&found.left_of(0)),
            left: of(&found.left_of(found.chosen)),
            held_out: of(held_out),
            sigma_um: 1e3 * fitted.sigma / mean_weight,
            sigma_over_stated: stated.then_some(fitted.sigma),
            degrees_of_freedom: fitted.degrees_of_freedom,
            unknowns: fitted.model.unknowns(),
            rank: fitted.rank,
            terms,
            functions,
            map_um,
            nodes,
            grid_off_um,
            shift_mm: [u, v],
            turn_urad: 1e6 * turn,
            left_alone: left_alone(found),
            transfer: found.transfer.clone(),
            notes: notes(found),
        }
    }

    /// Files of the machine with the errors, as (name, text), if there is one; `source` is the name of the points' file.
    pub fn files(&self, found: &PlaneFit, source: &str) -> Option<Vec<(String, String)>> {
        let comment = format!(
            "Measured: {} points of {source} over {} and {}, {}; held out {} um RMS.",
            self.points,
            self.plane[0],
            self.plane[1],
            self.model,
            significant(self.held_out.rms_um, 3)
        );
        found.machine.as_ref().map(|machine| machine_files(machine, &comment))
    }
}

impl PlaneFit {
    /// Residuals of the points in a candidate's fit, mm.
    pub(super) fn left_of(&self, candidate: usize) -> Vec<[f64; 2]> {
        self.points.iter().map(|point| self.candidates[candidate].fitted.left(point)).collect()
    }
}

fn models(found: &PlaneFit) -> Vec<CandidateDocument> {
    let rms = |of: &[[f64; 2]]| 1e3 * mean_square(&found.points, of.iter().copied().map(square)).sqrt();
    let document = |(number, of): (usize, &super::Candidate)| CandidateDocument {
        model: of.fitted.model.name(),
        unknowns: of.fitted.model.unknowns(),
        rank: of.fitted.rank,
        held_out_um: of.held_out.as_deref().map(rms),
        left_um: rms(&found.left_of(number)),
        degrees_of_freedom: of.fitted.degrees_of_freedom,
    };
    found.candidates.iter().enumerate().map(document).collect()
}

fn terms(found: &PlaneFit) -> (Vec<PlaneTerm>, Vec<Function>) {
    let PlaneErrors::Tables(tables) = &found.errors else { return Default::default() };
    let letters = found.letters();
    let degrees_of_freedom = found.fitted().degrees_of_freedom as f64;
    let term = |name: String, unit, [value, error]: [f64; 2], sign: f64| {
        let of = Value { value: 1e6 * sign * value, standard_error: 1e6 * error, degrees_of_freedom };
        PlaneTerm { name, unit, of }
    };
    let (name, sign) = squareness(found.axes);
    let mut terms: Vec<PlaneTerm> =
        letters.iter().zip(tables.scale).map(|(letter, of)| term(format!("scale {letter}"), "ppm", of, 1.0)).collect();
    terms.push(term(name.into(), "urad", tables.shear, sign));
    let mut functions = Vec::new();
    for (axis, letter) in letters.iter().enumerate() {
        for (direction, along) in letters.iter().enumerate() {
            let errors = &tables.standard_errors[axis][direction];
            let [low, high] = crate::points::found::range(tables.errors[axis][direction].iter().copied());
            functions.push(Function {
                name: format!("E{along}{letter}"),
                unit: "um",
                range: [1e3 * low, 1e3 * high],
                standard_error: 1e3 * (errors.iter().map(|of| of * of).sum::<f64>() / errors.len() as f64).sqrt(),
                worst_standard_error: 1e3 * errors.iter().copied().fold(0.0, f64::max),
            });
        }
    }
    (terms, functions)
}

/// Errors of the free axes, and axes, that points in this plane do not show.
fn left_alone(found: &PlaneFit) -> Vec<String> {
    let others = LINEAR.iter().filter(|axis| !found.axes.contains(&axis.index())).map(|axis| axis.letter());
    let other: String = others.collect();
    let mut left: Vec<String> = found
        .letters()
        .iter()
        .flat_map(|axis| format!("{other}ABC").chars().map(|of| format!("E{of}{axis}")).collect::<Vec<_>>())
        .collect();
    left.push(format!("axis {other}"));
    left
}

fn notes(found: &PlaneFit) -> Vec<String> {
    let [u, v] = found.letters();
    let mut notes = vec![format!(
        "the placement of the plate is removed; errors over {u} and {v} are zero at the reference position"
    )];
    notes.push(format!(
        "left alone, as points in this plane do not show them: {}; values of them that a machine states are subtracted first",
        left_alone(found).join(" ")
    ));
    match &found.errors {
        PlaneErrors::None => {
            notes.push("no model predicts held-out points better than the placement alone: nothing to write".into())
        }
        PlaneErrors::Grid(_) => {
            notes.push("beyond the measured points the map holds the value of the nearest edge".into())
        }
        PlaneErrors::Tables(_) => {}
    }
    notes.extend(found.transfer.iter().map(Transfer::sentence));
    notes.extend(found.changes.iter().cloned());
    notes
}
