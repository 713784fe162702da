//! Converts the command line's JSON documents to dictionaries.

use crate::to_python;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;
use trueaxis_tables::finding::Decision;

/// Converts a document that is not a table of keys, such as a list.
pub(crate) fn value<'py>(py: Python<'py>, document: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = to_python(trueaxis_evaluation::json::compact(document).map_err(Into::into))?;
    py.import("json")?.call_method1("loads", (text,))
}

/// Converts a document to a dictionary.
pub(crate) fn dictionary<'py>(py: Python<'py>, document: &impl Serialize) -> PyResult<Bound<'py, PyDict>> {
    Ok(value(py, document)?.cast_into()?)
}

/// Adds the decisions about a machine under `written`, as the commands do; adds nothing without a machine.
pub(crate) fn with_decisions(document: &Bound<'_, PyDict>, written: Option<&[Decision]>) -> PyResult<()> {
    let Some(written) = written else { return Ok(()) };
    document.set_item("written", value(document.py(), &written)?)
}
