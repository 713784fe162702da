//! Results in the types of the package: the document of a command with its presentation.

use crate::json::value;
use maud::Render;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trueaxis_evaluation::shown::{Plot, Shown, Table};

/// Tables and plots of a result, as the command line, the report and the desk present it.
#[pyclass(frozen, module = "trueaxis._native")]
pub(crate) struct Presentation {
    shown: Option<Shown>,
    /// What the command prints, where it is not all of `shown`.
    text: Option<String>,
}

#[pymethods]
impl Presentation {
    /// The result as the command prints it.
    fn text(&self) -> String {
        let shown = || self.shown.as_ref().map(Shown::text);
        self.text.clone().or_else(shown).unwrap_or_default()
    }

    /// Title, sentences, tables, plots, polar plots and map as dictionaries.
    fn parts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.shown.as_ref().map_or_else(|| Ok(PyDict::new(py).into_any()), |shown| value(py, shown))
    }

    /// The figures of the report, as HTML: plots, polar plots, map.
    fn figures(&self) -> Vec<String> {
        let Some(shown) = &self.shown else { return Vec::new() };
        let plots = shown.plots.iter().map(|plot: &Plot| plot.figure(false));
        let polars = shown.polars.iter().map(|polar| polar.figure());
        let map = shown.map.iter().map(|map| map.figure());
        plots.chain(polars).chain(map).map(|figure| figure.render().into_string()).collect()
    }
}

/// Makes a result of the package's type `kind`.
pub(crate) fn result<'py>(
    kind: &str,
    document: Bound<'py, PyDict>,
    shown: Option<Shown>,
) -> PyResult<Bound<'py, PyAny>> {
    presented(kind, document, shown.map(|shown| Presentation { shown: Some(shown), text: None }))
}

/// Makes a result of which the command prints a text.
pub(crate) fn text_result<'py>(kind: &str, document: Bound<'py, PyDict>, text: String) -> PyResult<Bound<'py, PyAny>> {
    presented(kind, document, Some(Presentation { shown: None, text: Some(text) }))
}

/// Makes a result of which the command prints this table alone, after `text`.
pub(crate) fn table_result<'py>(
    kind: &str,
    document: Bound<'py, PyDict>,
    title: &str,
    (text, table): (String, Table),
) -> PyResult<Bound<'py, PyAny>> {
    let text = text + &table.to_string();
    let shown = Shown { title: title.into(), tables: vec![table], ..Shown::default() };
    presented(kind, document, Some(Presentation { shown: Some(shown), text: Some(text) }))
}

fn presented<'py>(
    kind: &str,
    document: Bound<'py, PyDict>,
    presentation: Option<Presentation>,
) -> PyResult<Bound<'py, PyAny>> {
    let types = document.py().import("trueaxis._types")?;
    types.getattr(kind)?.call1((document, presentation))
}
