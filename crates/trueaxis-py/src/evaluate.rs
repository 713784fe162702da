//! Evaluates records of tests with instruments; returns the documents of `trueaxis evaluate`.

use crate::machine::{self, Machine};
use crate::measured::Measured;
use crate::shown::result;
use crate::{Error, json, to_python, warn};
use anyhow::{Result, bail};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;
use std::sync::OnceLock;
use trueaxis_evaluation::rows::{Column, Rows};
use trueaxis_evaluation::shown::Shown;
use trueaxis_evaluation::{accuracy as positioning, diagonal, points as coordinates, probing, r_test, thermal_test};
use trueaxis_tables::Additions;

/// Reads and evaluates a record without the interpreter's lock; returns the document.
fn evaluated<'py, const C: usize, D: Serialize + Send>(
    py: Python<'py>,
    kind: &str,
    record: &Bound<'py, PyAny>,
    columns: &[Column; C],
    evaluate: impl FnOnce(&mut Rows<'_, C>, &str) -> Result<(D, Shown)> + Send,
) -> PyResult<Bound<'py, PyAny>> {
    decided(py, kind, record, columns, None, |rows, name| {
        let (document, shown) = evaluate(rows, name)?;
        Ok((document, shown, Additions::default()))
    })
}

/// Like [`evaluated`], with the decision on every finding for a machine.
fn decided<'py, const C: usize, D: Serialize + Send>(
    py: Python<'py>,
    kind: &str,
    record: &Bound<'py, PyAny>,
    columns: &[Column; C],
    machine: Option<&Machine>,
    evaluate: impl FnOnce(&mut Rows<'_, C>, &str) -> Result<(D, Shown, Additions)> + Send,
) -> PyResult<Bound<'py, PyAny>> {
    decided_with(py, kind, record, columns, machine, evaluate, |_| Ok(()))
}

/// Like [`decided`]; `add` adds to the document what only Python has.
fn decided_with<'py, const C: usize, D: Serialize + Send>(
    py: Python<'py>,
    kind: &str,
    record: &Bound<'py, PyAny>,
    columns: &[Column; C],
    machine: Option<&Machine>,
    evaluate: impl FnOnce(&mut Rows<'_, C>, &str) -> Result<(D, Shown, Additions)> + Send,
    add: impl FnOnce(&Bound<'py, PyDict>) -> PyResult<()>,
) -> PyResult<Bound<'py, PyAny>> {
    let measured = Measured::of_columns(record, "record", columns)?;
    let mut notes = Vec::new();
    let found = py.detach(|| {
        let name = measured.name().display().to_string();
        let (document, shown, additions) = evaluate(&mut measured.rows(columns, &mut notes)?, &name)?;
        let written = machine::decided(machine, &measured, || Ok(additions), &mut notes);
        Ok((document, shown, written))
    });
    notes.iter().try_for_each(|note| warn(py, note))?;
    let (document, shown, written) = to_python(found)?;
    let found = json::dictionary(py, &document)?;
    json::with_decisions(&found, written.as_deref())?;
    add(&found)?;
    result(kind, found, Some(shown))
}

fn in_um(left_mm: &[[f64; 3]]) -> Vec<f64> {
    left_mm.iter().flatten().map(|mm| 1e3 * mm).collect()
}

/// Adds residuals along X, Y, Z, one row a reading, if there are any.
fn with_residuals(document: &Bound<'_, PyDict>, left_um: Option<&Vec<f64>>) -> PyResult<()> {
    let Some(all) = left_um else { return Ok(()) };
    document.set_item("residuals_um", PyArray1::from_slice(document.py(), all).reshape([all.len() / 3, 3])?)
}

/// Reports an option that is out of its range by the name of the argument.
fn asked<T, E: std::fmt::Display>(checked: Result<T, E>) -> PyResult<T> {
    checked.map_err(|wrong| Error::new_err(wrong.to_string()))
}

/// Evaluate the positions of an axis according to ISO 230-2.
///
/// Parameters
/// ----------
/// record : dict of array-likes or data frame or path-like or file object
///     Deviations: a file, or a dict or data frame with its columns: X_mm, run, direction (+ or -) and deviation_um, or X_mm
///     and a column for each run, +1, -1, +2, ….
/// axis : {"X", "Y", "Z", "A", "B", "C"}, optional
///     The axis measured, if the file does not state it.
/// machine : Machine, optional
///     Adds `compensated`, the figures that its tables would leave.
/// instrument : Machine, optional
///     A machine whose files state the uncertainty of the instrument: adds `uncertainty`, the bands of the
///     measured figures.
/// tolerance_um : float, optional
///     Adds `verdict`, uncertainty included (ISO 14253-1).
/// confidence : float, default 95.0
///     Of the bands, 50 to 99.99 %.
///
/// Returns
/// -------
/// Accuracy
///     The document of `trueaxis tables accuracy --json`.
///
/// Raises
/// ------
/// trueaxis.Error
///     If an argument or a record is refused: what was found, and what is needed.
///
/// Examples
/// --------
/// >>> mill = trueaxis.Machine.load("compensation-tables/mill-3axis")
/// >>> found = trueaxis.accuracy("compensation-tables/mill-3axis/x-iso230-2.csv", instrument=mill, tolerance_um=40)
/// >>> print(found.figures["A, bidirectional accuracy"])
/// 33.856 ± 4.1 µm
/// >>> found.verdict.verdict
/// 'pass'
#[pyfunction]
#[pyo3(signature = (record, *, axis = None, machine = None, instrument = None, tolerance_um = None, confidence = 95.0))]
pub(crate) fn accuracy<'py>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    axis: Option<char>,
    machine: Option<Bound<'py, Machine>>,
    instrument: Option<Bound<'py, Machine>>,
    tolerance_um: Option<f64>,
    confidence: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let axis = axis.map(machine::axis_of).transpose()?;
    if !(50.0..=99.99).contains(&confidence) {
        return Err(Error::new_err(format!("confidence: found {confidence}, needed 50 to 99.99 %")));
    }
    if let Some(found) = tolerance_um.filter(|tolerance| !(0.0..=1e6).contains(tolerance)) {
        return Err(Error::new_err(format!("tolerance_um: found {found}, needed 0 to 1e6 um")));
    }
    let instrument = match instrument.as_ref().map(Bound::get) {
        None if tolerance_um.is_some() => {
            return Err(Error::new_err("instrument: found none, needed the machine that states its uncertainty"));
        }
        None => None,
        Some(Machine { machine, stated: Some(stated), .. }) => Some((machine, stated)),
        Some(_) => return Err(Error::new_err("instrument: found a compiled file, needed a machine.toml")),
    };
    let machine = machine.as_ref().map(Bound::get);
    let measured = Measured::of_words(record, "record")?;
    let record = measured.name();
    let mut notes = Vec::new();
    let found = py.detach(|| {
        let text = measured.text()?;
        let measurement = positioning::read(&text, record, axis, &mut |note| notes.push(note))?;
        let given = machine.map(|machine| (&machine.machine, machine.path.as_path()));
        let mut document = positioning::evaluate(&measurement, record, given)?;
        if let Some((machine, stated)) = instrument {
            let bands = positioning::bands(&measurement, machine, stated, confidence / 100.0)?;
            document.verdict = tolerance_um.and_then(|tolerance| positioning::judge(&bands, tolerance));
            document.uncertainty = Some(bands);
        }
        Ok(document)
    });
    notes.iter().try_for_each(|note| warn(py, note))?;
    let document = to_python(found)?;
    result("Accuracy", json::dictionary(py, &document)?, Some(document.shown()))
}

/// Evaluate probing tests according to ISO 230-10.
///
/// Parameters
/// ----------
/// record : dict of array-likes or data frame or path-like or file object
///     A file, or a dict of arrays x_mm, y_mm[, z_mm][, run][, spindle_deg].
/// feature : {"ring", "sphere", "point"}
///     What was probed.
/// diameter_mm : float, optional
///     Calibrated diameter of the ring or sphere, mm.
///
/// Returns
/// -------
/// Probing
///     The document of `trueaxis evaluate probing --json`.
///
/// Raises
/// ------
/// trueaxis.Error
///     If an argument or a record is refused: what was found, and what is needed.
#[pyfunction]
#[pyo3(signature = (record, *, feature, diameter_mm = None))]
pub(crate) fn evaluate_probing<'py>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    feature: &str,
    diameter_mm: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let feature = match feature {
        "ring" => probing::Feature::Ring,
        "sphere" => probing::Feature::Sphere,
        "point" => probing::Feature::Point,
        found => {
            let needed = "\"ring\", \"sphere\" or \"point\"";
            return Err(Error::new_err(format!("feature: found {found:?}, needed {needed}")));
        }
    };
    asked(probing::check(diameter_mm))?;
    evaluated(py, "Probing", record, &probing::COLUMNS, |rows, _| {
        let record = probing::Record::read(rows, feature, diameter_mm)?;
        let document = probing::ProbingDocument::new(&record);
        let shown = document.shown(&record);
        Ok((document, shown))
    })
}

/// Evaluate thermal tests according to ISO 230-3.
///
/// Parameters
/// ----------
/// record : dict of array-likes or data frame or path-like or file object
///     A file, or a dict of arrays t_s[, position][, x1_um …][, ambient_c …].
/// test : {"etve", "spindle", "axis"}, default "spindle"
///     The test of ISO 230-3: environmental temperature variation error, rotating spindle or moving linear axis.
/// period_min : float, default 60.0
///     Length of a period, min.
/// distance_mm : float, optional
///     Distance of the probes at both heights, mm.
///
/// Returns
/// -------
/// ThermalTest
///     The document of `trueaxis evaluate thermal --json`.
///
/// Raises
/// ------
/// trueaxis.Error
///     If an argument or a record is refused: what was found, and what is needed.
#[pyfunction]
#[pyo3(signature = (record, *, test = "spindle", period_min = 60.0, distance_mm = None))]
pub(crate) fn evaluate_thermal<'py>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    test: &str,
    period_min: f64,
    distance_mm: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let name = match test {
        "etve" => "etve",
        "spindle" => "spindle",
        "axis" => "axis",
        found => {
            let needed = "\"etve\", \"spindle\" or \"axis\"";
            return Err(Error::new_err(format!("test: found {found:?}, needed {needed}")));
        }
    };
    asked(thermal_test::check(period_min, distance_mm))?;
    evaluated(py, "ThermalTest", record, &thermal_test::COLUMNS, |rows, _| {
        let test = thermal_test::read(rows)?;
        let document = thermal_test::ThermalTestDocument::new(&test, name, period_min, distance_mm);
        let shown = document.shown(&test);
        Ok((document, shown))
    })
}

/// Evaluate diagonal and step-diagonal tests according to ISO 230-6.
///
/// Parameters
/// ----------
/// record : dict of array-likes or data frame or path-like or file object
///     A file, or a dict of arrays diagonal, direction, x_mm, y_mm, z_mm, deviation_um[, run].
/// alignment_urad : float, optional
///     Standard uncertainty of the alignment of the mirror and the beam to a diagonal, µrad; without it, scales are not
///     known.
/// machine : Machine, optional
///     Adds `written`, the command's decision on every setting found.
///
/// Returns
/// -------
/// StepDiagonal
///     The document of `trueaxis evaluate step-diagonal --json`.
///
/// Raises
/// ------
/// trueaxis.Error
///     If an argument or a record is refused: what was found, and what is needed.
///
/// Notes
/// -----
/// Writes no file.
#[pyfunction]
#[pyo3(signature = (record, *, alignment_urad = None, machine = None))]
pub(crate) fn evaluate_step_diagonal<'py>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    alignment_urad: Option<f64>,
    machine: Option<Bound<'py, Machine>>,
) -> PyResult<Bound<'py, PyAny>> {
    asked(diagonal::check(alignment_urad))?;
    decided(py, "StepDiagonal", record, &diagonal::COLUMNS, machine.as_ref().map(Bound::get), |rows, _| {
        let test = diagonal::read(rows)?;
        let document = diagonal::DiagonalDocument::new(&test, alignment_urad);
        let shown = document.shown(&test);
        Ok((document, shown, diagonal::additions(&test)))
    })
}

/// Evaluate an R-test according to ISO 10791-6, which determines location errors of the rotary axes.
///
/// Parameters
/// ----------
/// record : dict of array-likes or data frame or path-like or file object
///     A file, or a dict of arrays x_mm, y_mm, z_mm[, a_deg, b_deg, c_deg], dx_um, dy_um, dz_um[, ball].
/// machine : Machine
///     The machine that was measured.
/// tool_mm : sequence of float, optional
///     The nest's centre; by default, the machine's tool.
/// without : sequence of str, optional
///     Location errors that keep the machine's values, such as "EX0C".
/// free_sensor : bool, default False
///     Whether the zero of the nest is fitted too.
/// residuals : bool, default False
///     True adds the residual of every reading along X, Y, Z under `residuals_um`, (n, 3).
///
/// Returns
/// -------
/// RTest
///     The document of `trueaxis evaluate r-test --json`.
///
/// Raises
/// ------
/// trueaxis.Error
///     If an argument or a record is refused: what was found, and what is needed.
///
/// Notes
/// -----
/// `written` lists the decision on every location error found, except for a compiled machine. Writes no file.
#[pyfunction]
#[pyo3(signature = (record, *, machine, tool_mm = None, without = Vec::new(), free_sensor = false, residuals = false))]
pub(crate) fn evaluate_r_test<'py>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    machine: &Bound<'py, Machine>,
    tool_mm: Option<[f64; 3]>,
    without: Vec<String>,
    free_sensor: bool,
    residuals: bool,
) -> PyResult<Bound<'py, PyAny>> {
    if let Some(value) = tool_mm.iter().flatten().find(|value| value.is_nan() || value.abs() > 1e6) {
        return Err(Error::new_err(format!("tool_mm: found {value}, needed a finite number of at most 1e6 mm")));
    }
    let own = machine.get();
    let mut machine = own.machine.clone();
    machine.settings.tool_mm = tool_mm.unwrap_or(machine.settings.tool_mm);
    let options = r_test::Options { without, free_sensor };
    let left = OnceLock::new();
    let evaluate = |rows: &mut Rows<'_, { r_test::COLUMNS.len() }>, name: &str| {
        let record = r_test::Record::read(rows)?;
        let found = r_test::identify(&record, name, &machine, &options)?;
        let _ = left.set(in_um(&found.left_mm));
        let document = r_test::RTestDocument::new(&record, &found, &machine);
        let shown = document.shown(&record, &found);
        Ok((document, shown, found.additions()))
    };
    decided_with(py, "RTest", record, &r_test::COLUMNS, Some(own), evaluate, |document| {
        with_residuals(document, left.get().filter(|_| residuals))
    })
}

/// The document of measured points.
#[derive(Serialize)]
#[serde(untagged)]
enum Coordinates {
    Volume(Box<coordinates::PointsDocument>),
    Plane(Box<coordinates::PlaneDocument>),
}

/// Determine the errors of X, Y, Z from measured coordinates.
///
/// Points throughout a volume give the 21 errors. Points in a plane or on a line give affine terms, tables of one dimension or a
/// smooth map, whichever predicts held-out points best.
///
/// Parameters
/// ----------
/// record : dict of array-likes or data frame or path-like or file object
///     A file, or a dict of arrays x_mm, y_mm, z_mm, actual_x_mm, actual_y_mm, actual_z_mm[, u_um][, tool_x_mm
///     …].
/// machine : Machine, optional
///     Machine that states chain, offsets, tool and `measured_at_mm`. Points in a plane or on a line may do without one.
/// nodes : sequence of int, optional
///     Numbers of evenly spaced nodes in the tables of X, Y, Z; by default, the levels of the points, else 11; in a plane, those
///     that predict best.
/// without : sequence of str, optional
///     Angular errors to leave at zero, such as "EBX".
/// against : dict of array-likes or data frame or path-like or file object, optional
///     Points in a plane or on a line: a second record, of another plate or another day, on which the errors are tested.
/// residuals : bool, default False
///     True adds the residual of every point under `residuals_um`: along X, Y, Z, (n, 3); in a plane along its two axes, (n, 2).
///
/// Returns
/// -------
/// MeasuredPoints or MeasuredPlane
///     The document of `trueaxis evaluate points --json`.
///
/// Raises
/// ------
/// trueaxis.Error
///     If an argument or a record is refused: what was found, and what is needed.
#[pyfunction]
#[pyo3(signature = (record, *, machine = None, nodes = None, without = Vec::new(), against = None, residuals = false))]
pub(crate) fn evaluate_points<'py>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    machine: Option<&Bound<'py, Machine>>,
    nodes: Option<Vec<usize>>,
    without: Vec<String>,
    against: Option<&Bound<'py, PyAny>>,
    residuals: bool,
) -> PyResult<Bound<'py, PyAny>> {
    use coordinates::{COLUMNS, Options, PlaneDocument, Points, PointsDocument};
    let nodes = nodes.as_deref().map(coordinates::nodes).transpose();
    let nodes = asked(nodes.map_err(|wrong| format!("nodes: {wrong}")))?;
    let machine = machine.map(|machine| &machine.get().machine);
    let options = Options { nodes, without };
    let measured = Measured::of_columns(record, "record", &COLUMNS)?;
    let other = against.map(|other| Measured::of_columns(other, "against", &COLUMNS)).transpose()?;
    let mut notes = Vec::new();
    let found = py.detach(|| {
        let name = measured.name().display().to_string();
        let points = Points::read(&mut measured.rows(&COLUMNS, &mut notes)?)?;
        if points.are_flat() {
            let read = |other: &Measured, notes: &mut Vec<String>| Points::read(&mut other.rows(&COLUMNS, notes)?);
            let against = other.as_ref().map(|other| read(other, &mut notes)).transpose()?;
            let other_name = other.as_ref().map(|other| other.name().display().to_string()).unwrap_or_default();
            let against = against.as_ref().map(|points| (points, other_name.as_str()));
            let found = coordinates::identify_plane(&points, machine, &options, against);
            let found = found.map_err(|error| error.context(name))?;
            let document = PlaneDocument::new(&found, points.stated);
            let shown = document.shown(&found);
            let left: Vec<f64> = found.left_mm().into_iter().flatten().map(|mm| 1e3 * mm).collect();
            return Ok(("MeasuredPlane", Coordinates::Plane(Box::new(document)), shown, left, 2));
        }
        if other.is_some() {
            bail!("against: found points along X, Y and Z, needed points in a plane or on a line");
        }
        let Some(machine) = machine else {
            bail!("machine: found none, needed one for points along X, Y and Z");
        };
        let found = coordinates::identify(&points, machine, &options).map_err(|error| error.context(name))?;
        let document = PointsDocument::new(&points, &found);
        let shown = document.shown(&points, &found);
        Ok(("MeasuredPoints", Coordinates::Volume(Box::new(document)), shown, in_um(&found.left_mm), 3))
    });
    notes.iter().try_for_each(|note| warn(py, note))?;
    let (kind, document, shown, left, directions) = to_python(found)?;
    let found = json::dictionary(py, &document)?;
    if residuals {
        let rows = [left.len() / directions, directions];
        found.set_item("residuals_um", PyArray1::from_vec(py, left).reshape(rows)?)?;
    }
    result(kind, found, Some(shown))
}
