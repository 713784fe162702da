//! Checks arrays from Python: shape, type and every number.

use crate::Error;
use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;

/// Largest size of a number, as in the command line's files.
const MOST: f64 = 1e9;

/// Copies an array of float64: another thread of the caller may change the array while the computation runs without the lock.
fn numbers(of: &Bound<'_, PyAny>, name: &str, needed: &str) -> PyResult<(Vec<usize>, Vec<f64>)> {
    let refused = |found: String| Error::new_err(format!("{name}: found {found}, needed {needed}"));
    let Ok(array) = of.cast::<PyUntypedArray>() else {
        return Err(refused(format!("{}", of.get_type().name()?)));
    };
    let Ok(array) = array.cast::<PyArrayDyn<f64>>() else {
        return Err(refused(format!("dtype {}", array.dtype())));
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
    let needed = format!("a numpy array of float64, shape {}, n at least 1", listed.join(" or "));
    let (shape, values) = numbers(of, name, &needed)?;
    match shape[..] {
        [count, width] if count > 0 && widths.contains(&width) => {
            check(&values, Some(width), name)?;
            Ok((width, values))
        }
        _ => Err(Error::new_err(format!("{name}: found {}, needed {needed}", shape_of(&shape)))),
    }
}

/// Reads one number per row of `of_rows`.
pub(crate) fn column(of: &Bound<'_, PyAny>, name: &str, count: usize, of_rows: &str) -> PyResult<Vec<f64>> {
    let needed = format!("a numpy array of float64, shape ({count},), one number a row of {of_rows}");
    let (shape, values) = numbers(of, name, &needed)?;
    if shape != [count] {
        return Err(Error::new_err(format!("{name}: found {}, needed {needed}", shape_of(&shape))));
    }
    check(&values, None, name)?;
    Ok(values)
}
