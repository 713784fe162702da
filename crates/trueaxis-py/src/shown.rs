//! Results in the types of the package: the document of a command with its presentation.

use crate::documents::value;
use maud::Render;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trueaxis_evaluation::shown::{Plot, Shown};

/// Tables and plots of a result, as the command line, the report and the desk present it.
#[pyclass(frozen, module = "trueaxis._native")]
pub(crate) struct Presentation(Shown);

#[pymethods]
impl Presentation {
    /// The result as the command prints it.
    fn text(&self) -> String {
        self.0.text()
    }

    /// Title, sentences, tables, plots, polar plots and map as dictionaries.
    fn parts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        value(py, &self.0)
    }

    /// The figures of the report, as HTML: plots, polar plots, map.
    fn figures(&self) -> Vec<String> {
        let plots = self.0.plots.iter().map(|plot: &Plot| plot.figure(false));
        let polars = self.0.polars.iter().map(|polar| polar.figure());
        let map = self.0.map.iter().map(|map| map.figure());
        plots.chain(polars).chain(map).map(|figure| figure.render().into_string()).collect()
    }
}

/// Makes a result of the package's type `kind`.
pub(crate) fn result<'py>(
    kind: &str,
    document: Bound<'py, PyDict>,
    shown: Option<Shown>,
) -> PyResult<Bound<'py, PyAny>> {
    let types = document.py().import("trueaxis._types")?;
    types.getattr(kind)?.call1((document, shown.map(Presentation)))
}
