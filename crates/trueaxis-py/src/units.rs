//! Arguments with units, converted by the package's Python part to the units of the functions.

use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A dict or frame with the columns of `forms` in the units of their names, made from columns in other units. Anything else
/// stays as it is, except that a quantity becomes numbers in the unit of the columns.
pub(crate) fn framed<'py>(of: &Bound<'py, PyAny>, name: &str, forms: &[&[&str]]) -> PyResult<Bound<'py, PyAny>> {
    if !of.hasattr("columns")? && !of.is_instance_of::<PyDict>() && !has_unit(of)? {
        return Ok(of.clone());
    }
    let forms: Vec<Vec<&str>> = forms.iter().map(|form| form.to_vec()).collect();
    of.py().import("trueaxis._units")?.call_method1("frame", (of, name, forms))
}

/// A quantity, or a series that states its unit, as numbers in `unit`; anything else as it is.
pub(crate) fn in_unit<'py>(of: &Bound<'py, PyAny>, name: &str, unit: &str) -> PyResult<Bound<'py, PyAny>> {
    if !has_unit(of)? {
        return Ok(of.clone());
    }
    of.py().import("trueaxis._units")?.call_method1("in_unit", (of, name, unit))
}

fn has_unit(of: &Bound<'_, PyAny>) -> PyResult<bool> {
    Ok(of.hasattr("magnitude")? || of.hasattr("attrs")?)
}
