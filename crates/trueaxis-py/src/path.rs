//! A programmed path, and the contour error of positions near it.

use crate::{Error, arrays, to_python, units, warn};
use anyhow::anyhow;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path as FilePath, PathBuf};
use trueaxis::contour::{ContourSearch, Method};
use trueaxis_evaluation::path::{Alive, PathFile, ProgrammedPath, StuckAxis};
use trueaxis_tables::text::read_text;

/// A programmed path of lines, arcs and NURBS.
#[pyclass(frozen, module = "trueaxis")]
pub(crate) struct Path(ProgrammedPath);

/// Feet and errors in the order of the rows.
#[derive(Default)]
struct Feet {
    segment: Vec<u32>,
    u: Vec<f64>,
    error_um: Vec<f64>,
    vector_um: Vec<f64>,
    evaluations: Vec<u32>,
    bracketed: Vec<bool>,
}

#[pymethods]
impl Path {
    /// Reads a path: the PATH.json of `trueaxis contour`.
    ///
    /// Parameters
    /// ----------
    /// path : path-like
    ///     A path file: JSON of segments (docs/formats.md).
    ///
    /// Returns
    /// -------
    /// Path
    ///     The path.
    ///
    /// Raises
    /// ------
    /// trueaxis.Error
    ///     If an argument or a record is refused: what was found, and what is needed.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Path> {
        Path::cut(py, || Ok(read_text(&path, &[])?), &path)
    }

    /// Read a path from the text of a PATH.json.
    ///
    /// Parameters
    /// ----------
    /// text : str
    ///     JSON of segments (docs/formats.md).
    ///
    /// Returns
    /// -------
    /// Path
    ///     The path.
    ///
    /// Raises
    /// ------
    /// trueaxis.Error
    ///     If an argument or a record is refused: what was found, and what is needed.
    #[staticmethod]
    fn from_json(py: Python<'_>, text: String) -> PyResult<Path> {
        Path::cut(py, || Ok(text), FilePath::new("path"))
    }

    /// Number of segments.
    #[getter]
    fn segments(&self) -> usize {
        self.0.segments()
    }

    /// Find the foot of every actual position: the point of the path nearest to it, about its reference.
    ///
    /// Parameters
    /// ----------
    /// segment : array-like
    ///     Index of the segment of the path on which the reference of each position lies, (n,).
    /// u : array-like
    ///     Parameter of that reference within its segment, 0 to 1, (n,).
    /// actual : array-like or data frame
    ///     (n, 3), mm, or a data frame with the columns x_mm, y_mm, z_mm.
    /// max_lag_mm : float, default 1.0
    ///     Path length that is searched on either side of the reference, mm.
    /// method : {"guarded", "bisection"}, default "guarded"
    ///     Method that narrows a bracket.
    ///
    /// Returns
    /// -------
    /// ContourError
    ///     Foot, distance and vector of every position, as arrays by the columns of `trueaxis contour`.
    ///
    /// Raises
    /// ------
    /// trueaxis.Error
    ///     With the row: a reference that is not on the path, a coordinate that does not change while the path
    ///     moves along it.
    ///
    /// Notes
    /// -----
    /// Returns the columns of `trueaxis contour` as arrays: segment and u of the foot, error_um (the distance to it),
    /// vector_um (n, 3; actual − foot), evaluations, bracketed.
    #[pyo3(signature = (segment, u, actual, *, max_lag_mm = 1.0, method = "guarded"))]
    fn contour_error<'py>(
        &self,
        py: Python<'py>,
        segment: &Bound<'py, PyAny>,
        u: &Bound<'py, PyAny>,
        actual: &Bound<'py, PyAny>,
        max_lag_mm: f64,
        method: &str,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (_, actual) = {
            let forms: &[&[&str]] = &[&["x_mm", "y_mm", "z_mm"]];
            arrays::named(&units::framed(actual, "actual", forms)?, "actual", forms)?
        };
        let count = actual.len() / 3;
        let segment = arrays::column(segment, "segment", count, "actual")?;
        let u = arrays::column(u, "u", count, "actual")?;
        let method = match method {
            "guarded" => Method::Guarded,
            "bisection" => Method::Bisection,
            found => {
                return Err(Error::new_err(format!("method: found {found:?}, needed \"guarded\" or \"bisection\"")));
            }
        };
        let feet = to_python(py.detach(|| {
            let search = ContourSearch::new(max_lag_mm, method).map_err(|error| anyhow!("max_lag_mm: {error}"))?;
            self.feet(&search, &segment, &u, &actual)
        }))?;
        let found = PyDict::new(py);
        found.set_item("segment", PyArray1::from_vec(py, feet.segment))?;
        found.set_item("u", PyArray1::from_vec(py, feet.u))?;
        found.set_item("error_um", PyArray1::from_vec(py, feet.error_um))?;
        found.set_item("vector_um", PyArray1::from_vec(py, feet.vector_um).reshape([count, 3])?)?;
        found.set_item("evaluations", PyArray1::from_vec(py, feet.evaluations))?;
        found.set_item("bracketed", PyArray1::from_vec(py, feet.bracketed))?;
        Ok(found)
    }
}

impl Path {
    fn cut(py: Python<'_>, text: impl FnOnce() -> anyhow::Result<String> + Send, name: &FilePath) -> PyResult<Path> {
        let mut notes = Vec::new();
        let path = py.detach(|| PathFile::read(&text()?, name)?.cut(&mut |note| notes.push(note)));
        for note in notes {
            warn(py, &note)?;
        }
        to_python(path).map(Path)
    }

    fn feet(&self, search: &ContourSearch<f64>, segment: &[f64], u: &[f64], actual: &[f64]) -> anyhow::Result<Feet> {
        let (mut feet, mut alive) = (Feet::default(), Alive::default());
        for (row, ((segment, u), position)) in segment.iter().zip(u).zip(actual.as_chunks::<3>().0).enumerate() {
            let found = self
                .0
                .foot(search, [*segment, *u], *position)
                .map_err(|wrong| anyhow!("{}[{row}]: found {}, needed {}", wrong.field, wrong.found, wrong.needed))?;
            alive.put(row, &found, *position);
            feet.segment.push(found.segment);
            feet.u.push(found.u);
            feet.error_um.push(found.error_um);
            feet.vector_um.extend(found.vector_um);
            feet.evaluations.push(found.evaluations.into());
            feet.bracketed.push(found.bracketed);
        }
        alive.check().map_err(|StuckAxis { row, axis, found }| {
            anyhow!("actual[{row}, {axis}]: found {found}, needed {}", StuckAxis::NEEDED)
        })?;
        Ok(feet)
    }
}
