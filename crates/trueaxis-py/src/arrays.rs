//! Arrays from Python: whatever NumPy makes an array of, its shape, and every number.

use crate::Error;
use numpy::{
    PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// Largest size of a number, as in the command line's files.
const MOST: f64 = 1e9;

/// Copies an array-like of integers or floats as float64; raises TypeError for any other type, such as complex numbers, text
/// or objects.
///
/// It copies, because another thread of the caller may change the array while the computation runs without the lock.
fn numbers(of: &Bound<'_, PyAny>, name: &str, needed: &str) -> PyResult<(Vec<usize>, Vec<f64>)> {
    let numpy = of.py().import("numpy")?;
    let refused = |found: String| PyTypeError::new_err(format!("{name}: found {found}, needed {needed}"));
    // Rows of unequal lengths make no array.
    let ragged = |error: PyErr| match error.is_instance_of::<PyValueError>(of.py()) {
        true => Error::new_err(format!("{name}: found {}, needed {needed}", error.value(of.py()))),
        false => error,
    };
    let array = numpy.call_method1("asarray", (of,)).map_err(ragged)?.cast_into::<PyUntypedArray>()?;
    if !matches!(array.dtype().kind(), b'i' | b'u' | b'f') {
        let single = array.ndim() == 0;
        let found = if single { of.get_type().name()?.to_string() } else { format!("dtype {}", array.dtype()) };
        return Err(refused(found));
    }
    let array = match array.cast::<PyArrayDyn<f64>>() {
        Ok(array) => array.clone(),
        Err(_) => array.call_method1("astype", ("float64",))?.cast_into::<PyArrayDyn<f64>>()?,
    };
    let array: PyReadonlyArrayDyn<'_, f64> = array.try_readonly()?;
    let shape = array.shape().to_vec();
    let values = match array.as_slice() {
        // `as_slice` also accepts arrays stored column by column.
        Ok(values) if array.is_c_contiguous() => values.to_vec(),
        _ => array.as_array().iter().copied().collect(),
    };
    Ok((shape, values))
}

fn shape_of(shape: &[usize]) -> String {
    let lengths: Vec<String> = shape.iter().map(usize::to_string).collect();
    format!("shape ({}{})", lengths.join(", "), if shape.len() == 1 { "," } else { "" })
}

/// Refuses the first value that is not a finite number of a sensible size, with its index.
fn check(values: &[f64], columns: Option<usize>, name: &str) -> PyResult<()> {
    let Some(at) = values.iter().position(|value| value.is_nan() || value.abs() > MOST) else { return Ok(()) };
    let place = columns.map_or(format!("{at}"), |columns| format!("{}, {}", at / columns, at % columns));
    Err(Error::new_err(format!("{name}[{place}]: found {}, needed a number of at most {MOST:e}", values[at])))
}

/// Reads an array whose number of columns is one of `widths`; returns that number and the values row by row.
pub(crate) fn rows(of: &Bound<'_, PyAny>, name: &str, widths: &[usize]) -> PyResult<(usize, Vec<f64>)> {
    let listed: Vec<String> = widths.iter().map(|width| format!("(n, {width})")).collect();
    let needed = format!("an array of real numbers, shape {}, n at least 1", listed.join(" or "));
    let (shape, values) = numbers(of, name, &needed)?;
    match shape[..] {
        [count, width] if count > 0 && widths.contains(&width) => {
            check(&values, Some(width), name)?;
            Ok((width, values))
        }
        _ => Err(Error::new_err(format!("{name}: found {}, needed {needed}", shape_of(&shape)))),
    }
}

/// Reads an array with the columns of one of `forms`, in that order, or a data frame that has them under these names, in any
/// order and with others beside them. The widest form that a data frame has is read.
pub(crate) fn named(of: &Bound<'_, PyAny>, name: &str, forms: &[&[&str]]) -> PyResult<(usize, Vec<f64>)> {
    let widths: Vec<usize> = forms.iter().map(|form| form.len()).collect();
    if !is_frame(of)? {
        return rows(of, name, &widths);
    }
    let columns: Vec<String> = columns_of(of)?;
    let whole = |form: &&&[&str]| form.iter().all(|column| columns.iter().any(|own| own == column));
    let Some(form) = forms.iter().filter(whole).max_by_key(|form| form.len()) else {
        let needed: Vec<String> = forms.iter().map(|form| form.join(", ")).collect();
        let found = format!("columns {}", columns.join(", "));
        return Err(Error::new_err(format!("{name}: found {found}, needed {}", needed.join(" or "))));
    };
    let picked = form.iter().map(|column| of.get_item(column)).collect::<PyResult<Vec<_>>>()?;
    rows(&of.py().import("numpy")?.call_method1("column_stack", (picked,))?, name, &[form.len()])
}

/// Whether an object has named columns, as a data frame has.
pub(crate) fn is_frame(of: &Bound<'_, PyAny>) -> PyResult<bool> {
    of.hasattr("columns")
}

/// Names of a data frame's columns.
pub(crate) fn columns_of(frame: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    frame.getattr("columns")?.try_iter()?.map(|column| Ok(column?.str()?.to_string())).collect()
}

/// Reads one number per row of `of_rows`.
pub(crate) fn column(of: &Bound<'_, PyAny>, name: &str, count: usize, of_rows: &str) -> PyResult<Vec<f64>> {
    let needed = format!("an array of real numbers, shape ({count},), one number a row of {of_rows}");
    let (shape, values) = numbers(of, name, &needed)?;
    if shape != [count] {
        return Err(Error::new_err(format!("{name}: found {}, needed {needed}", shape_of(&shape))));
    }
    check(&values, None, name)?;
    Ok(values)
}
