//! Evaluates records of tests with instruments; returns the documents of `trueaxis evaluate`.

use crate::machine::{self, Machine};
use crate::measured::Measured;
use crate::{Error, documents, to_python, warn};
use anyhow::Result;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;
use trueaxis_evaluation::rows::{Column, Rows};
use trueaxis_evaluation::{diagonal, points as coordinates, probing, r_test, thermal_test};
use trueaxis_tables::Additions;

/// Reads and evaluates a record without the interpreter's lock; returns the document.
fn evaluated<'py, const C: usize, D: Serialize + Send>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    columns: &[Column; C],
    evaluate: impl FnOnce(&mut Rows<'_, C>, &str) -> Result<D> + Send,
) -> PyResult<Bound<'py, PyDict>> {
    decided(py, record, columns, None, |rows, name| Ok((evaluate(rows, name)?, Additions::default())))
}

/// Like [`evaluated`], with the decision on every finding for a machine.
fn decided<'py, const C: usize, D: Serialize + Send>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    columns: &[Column; C],
    machine: Option<&Machine>,
    evaluate: impl FnOnce(&mut Rows<'_, C>, &str) -> Result<(D, Additions)> + Send,
) -> PyResult<Bound<'py, PyDict>> {
    let measured = Measured::of_columns(record, "record", columns)?;
    let mut notes = Vec::new();
    let found = py.detach(|| {
        let name = measured.name().display().to_string();
        let (document, additions) = evaluate(&mut measured.rows(columns, &mut notes)?, &name)?;
        let written = machine::decided(machine, &measured, || Ok(additions), &mut notes);
        Ok((document, written))
    });
    notes.iter().try_for_each(|note| warn(py, note))?;
    let (document, written) = to_python(found)?;
    let found = documents::dictionary(py, &document)?.cast_into::<PyDict>()?;
    documents::with_decisions(&found, written.as_deref())?;
    Ok(found)
}

/// Reports an option that is out of its range by the name of the argument.
fn asked<T, E: std::fmt::Display>(checked: Result<T, E>) -> PyResult<T> {
    checked.map_err(|wrong| Error::new_err(wrong.to_string()))
}

/// Evaluates probing tests according to ISO 230-10; returns the document of `trueaxis evaluate probing --json`.
///
/// - record: a file, or a dict of arrays x_mm, y_mm[, z_mm][, run][, spindle_deg].
/// - feature: "ring", "sphere" or "point".
#[pyfunction]
#[pyo3(signature = (record, *, feature, diameter_mm = None))]
pub(crate) fn evaluate_probing<'py>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    feature: &str,
    diameter_mm: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
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
    evaluated(py, record, &probing::COLUMNS, |rows, _| {
        Ok(probing::ProbingDocument::new(&probing::Record::read(rows, feature, diameter_mm)?))
    })
}

/// Evaluates thermal tests according to ISO 230-3; returns the document of `trueaxis evaluate thermal --json`.
///
/// - record: a file, or a dict of arrays t_s[, position][, x1_um …][, ambient_c …].
/// - test: "etve", "spindle" or "axis".
#[pyfunction]
#[pyo3(signature = (record, *, test = "spindle", period_min = 60.0, distance_mm = None))]
pub(crate) fn evaluate_thermal<'py>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    test: &str,
    period_min: f64,
    distance_mm: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
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
    evaluated(py, record, &thermal_test::COLUMNS, |rows, _| {
        Ok(thermal_test::ThermalTestDocument::new(&thermal_test::read(rows)?, name, period_min, distance_mm))
    })
}

/// Evaluates diagonal and step-diagonal tests according to ISO 230-6; returns the document of
/// `trueaxis evaluate step-diagonal --json`. Writes no file.
///
/// - record: a file, or a dict of arrays diagonal, direction, x_mm, y_mm, z_mm, deviation_um[, run].
/// - machine: adds `written`, the command's decision on every setting found.
#[pyfunction]
#[pyo3(signature = (record, *, alignment_urad = None, machine = None))]
pub(crate) fn evaluate_step_diagonal<'py>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    alignment_urad: Option<f64>,
    machine: Option<Bound<'py, Machine>>,
) -> PyResult<Bound<'py, PyDict>> {
    asked(diagonal::check(alignment_urad))?;
    decided(py, record, &diagonal::COLUMNS, machine.as_ref().map(Bound::get), |rows, _| {
        let test = diagonal::read(rows)?;
        Ok((diagonal::DiagonalDocument::new(&test, alignment_urad), diagonal::additions(&test)))
    })
}

/// Evaluates an R-test according to ISO 10791-6, which determines location errors of the rotary axes; returns the document of
/// `trueaxis evaluate r-test --json`. `written` lists the decision on every location error found, except for a compiled
/// machine. Writes no file.
///
/// - record: a file, or a dict of arrays x_mm, y_mm, z_mm[, a_deg, b_deg, c_deg], dx_um, dy_um, dz_um[, ball].
/// - tool_mm: the nest's centre; by default, the machine's tool.
/// - without: location errors that keep the machine's values, such as "EX0C".
#[pyfunction]
#[pyo3(signature = (record, *, machine, tool_mm = None, without = Vec::new(), free_sensor = false))]
pub(crate) fn evaluate_r_test<'py>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    machine: &Bound<'py, Machine>,
    tool_mm: Option<[f64; 3]>,
    without: Vec<String>,
    free_sensor: bool,
) -> PyResult<Bound<'py, PyDict>> {
    if let Some(value) = tool_mm.iter().flatten().find(|value| value.is_nan() || value.abs() > 1e6) {
        return Err(Error::new_err(format!("tool_mm: found {value}, needed a finite number of at most 1e6 mm")));
    }
    let own = machine.get();
    let mut machine = own.0.clone();
    machine.settings.tool_mm = tool_mm.unwrap_or(machine.settings.tool_mm);
    let options = r_test::Options { without, free_sensor };
    decided(py, record, &r_test::COLUMNS, Some(own), move |rows, name| {
        let record = r_test::Record::read(rows)?;
        let found = r_test::identify(&record, name, &machine, &options)?;
        Ok((r_test::RTestDocument::new(&record, &found, &machine), found.additions()))
    })
}

/// Determines the 21 errors of X, Y, Z from measured coordinates; returns the document of `trueaxis evaluate points --json`.
///
/// - record: a file, or a dict of arrays x_mm, y_mm, z_mm, actual_x_mm, actual_y_mm, actual_z_mm[, u_um][, tool_x_mm …].
/// - machine: states chain, offsets and tool.
/// - nodes: numbers of nodes in the tables of X, Y, Z.
/// - without: angular errors that stay zero.
#[pyfunction]
#[pyo3(signature = (record, *, machine, nodes = None, without = Vec::new()))]
pub(crate) fn evaluate_points<'py>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    machine: &Bound<'py, Machine>,
    nodes: Option<Vec<usize>>,
    without: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let nodes = nodes.as_deref().map(coordinates::nodes).transpose();
    let nodes = asked(nodes.map_err(|wrong| format!("nodes: {wrong}")))?;
    let machine = &machine.get().0;
    let options = coordinates::Options { nodes, without };
    evaluated(py, record, &coordinates::COLUMNS, |rows, name| {
        let points = coordinates::Points::read(rows)?;
        let found =
            coordinates::identify(&points, machine, &options).map_err(|error| error.context(name.to_owned()))?;
        Ok(coordinates::PointsDocument::new(&points, &found))
    })
}
