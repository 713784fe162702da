//! Errors identified from points in a plane, as a document.

use super::machine::squareness;
use super::selection::{mean_square, square};
use super::{LINEAR, Lie, PlaneErrors, PlaneFit, Transfer};
use crate::diagonal::Value;
use crate::points::document::left;
use crate::points::{Function, Left};
use serde::Serialize;
use trueaxis_report::number::significant;
use trueaxis_tables::formats::machine_files;

/// Tilt that is noted, as a share of the points' length.
const TILTED: f64 = 1e-4;

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
    /// `plane`: of two axes; `line`: along an axis; `inclined plane`.
    pub shape: &'static str,
    /// Letters of the axes of the plane; of a line's axis and the axis across it; for an inclined plane, of the axes next to its
    /// two directions.
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
    /// Terms that points which lie like these do not determine, and the combinations of them that they do.
    pub not_determined: Vec<String>,
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
            shape: found.shape(),
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
            not_determined: not_determined(found),
            left_alone: left_alone(found),
            transfer: found.transfer.clone(),
            notes: notes(found),
        }
    }

    /// Files of the machine with the errors, as (name, text), if there is one; `source` is the name of the points' file.
    pub fn files(&self, found: &PlaneFit, source: &str) -> Option<Vec<(String, String)>> {
        let comment = format!(
            "Measured: {} of {source}, {}; held out {} um RMS.",
            self.points_sentence(found),
            self.model,
            significant(self.held_out.rms_um, 3)
        );
        found.machine.as_ref().map(|machine| machine_files(machine, &comment))
    }

    /// The points in words.
    pub(super) fn points_sentence(&self, found: &PlaneFit) -> String {
        format!("{} {}", self.points, found.lie.sentence())
    }
}

impl PlaneFit {
    fn shape(&self) -> &'static str {
        match self.lie {
            Lie::Plane(_) => "plane",
            Lie::Line(_) => "line",
            Lie::Inclined(..) => "inclined plane",
        }
    }

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
    let shown = found.lie.free().len();
    let degrees_of_freedom = found.fitted().degrees_of_freedom as f64;
    let term = |name: String, unit, [value, error]: [f64; 2], sign: f64| {
        let of = Value { value: 1e6 * sign * value, standard_error: 1e6 * error, degrees_of_freedom };
        PlaneTerm { name, unit, of }
    };
    if let Lie::Inclined(..) = found.lie {
        let own = found.inclined_terms().iter();
        let own = own.map(|of| term(of.name().into(), of.unit(), [of.value, of.standard_error], 1.0));
        return (own.collect(), Vec::new());
    }
    let (name, sign) = squareness(found.axes);
    let mut terms: Vec<PlaneTerm> = letters
        .iter()
        .zip(tables.scale)
        .take(shown)
        .map(|(letter, of)| term(format!("scale {letter}"), "ppm", of, 1.0))
        .collect();
    if let Lie::Plane(_) = found.lie {
        terms.push(term(name.into(), "urad", tables.shear, sign));
    }
    let mut functions = Vec::new();
    for (axis, letter) in letters.iter().enumerate().take(shown) {
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

/// Terms that the alignment of a line, or the inclination of a plane, leaves undetermined.
fn not_determined(found: &PlaneFit) -> Vec<String> {
    match found.lie {
        Lie::Plane(_) => Vec::new(),
        Lie::Line([u, v]) => {
            let (u, v) = (LINEAR[u].letter(), LINEAR[v].letter());
            vec![
                format!("slope of E{v}{u}: the direction in which the line was set"),
                format!("{}: needs a second line across it, set at a known angle", squareness(sorted(found.axes)).0),
            ]
        }
        Lie::Inclined(..) => found.inclined.1.clone(),
    }
}

fn sorted([u, v]: [usize; 2]) -> [usize; 2] {
    [u.min(v), u.max(v)]
}

/// Errors of the free axes, and axes, that the points do not show.
fn left_alone(found: &PlaneFit) -> Vec<String> {
    if let Lie::Inclined(..) = found.lie {
        return vec!["all errors of X, Y, Z but these terms".into()];
    }
    let others: Vec<char> =
        LINEAR.iter().filter(|axis| !found.axes.contains(&axis.index())).map(|axis| axis.letter()).collect();
    let rotations = others.iter().copied().chain("ABC".chars());
    let shown = found.lie.free().iter().map(|axis| LINEAR[*axis].letter());
    let mut left: Vec<String> =
        shown.flat_map(|axis| rotations.clone().map(move |of| format!("E{of}{axis}"))).collect();
    let across = LINEAR.iter().filter(|axis| !found.lie.free().contains(&axis.index()));
    left.extend(across.map(|axis| format!("axis {}", axis.letter())));
    left
}

fn notes(found: &PlaneFit) -> Vec<String> {
    let [u, v] = found.letters();
    let mut notes = vec![match found.lie {
        Lie::Plane(_) => {
            format!("the placement of the plate is removed; errors over {u} and {v} are zero at the reference position")
        }
        Lie::Line(_) => {
            format!("the placement of the line is removed; errors over {u} are zero at the reference position")
        }
        Lie::Inclined(..) => {
            "the placement of the plate is removed; terms are those beyond what a machine states".into()
        }
    }];
    if found.tilt > TILTED {
        notes.push(format!(
            "the points vary across their {} by {} of their length: errors of the other axes, and squareness to them, enter with \
             this share",
            found.shape(),
            significant(found.tilt, 2)
        ));
    }
    if let Some(letter) = found.unused.map(|axis| LINEAR[axis].letter()) {
        let v = v.to_ascii_lowercase();
        notes.push(format!(
            "E{letter}{u}: deviations along {letter} were measured too and are not evaluated; a record with actual_{v}_mm as \
             commanded shows them"
        ));
    }
    notes.extend(not_determined(found).into_iter().map(|of| format!("not determined: {of}")));
    notes.push(format!(
        "left alone, as these points do not show them: {}; values of them that a machine states are subtracted first",
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
