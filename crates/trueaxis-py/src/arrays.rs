//! Arrays from Python: whatever NumPy makes an array of, its shape, and every number.

use crate::Error;
use numpy::{
    PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use trueaxis_metrology::cores::*;

/// Numbers that a thread takes at a time.
pub(crate) const CHUNK: usize = 12_288;
/// Largest size of a number, as in the command line's files.
const MOST: f64 = 1e9;

/// Numbers row by row: an array's own memory, or a copy.
pub(crate) enum Numbers<'py> {
    Lent(PyReadonlyArrayDyn<'py, f64>),
    Own(Vec<f64>),
}

impl Numbers<'_> {
    /// The numbers. If another thread writes the array during the call, the figures mix old and new numbers, as NumPy's do.
    pub(crate) fn as_slice(&self) -> &[f64] {
        match self {
            // Only arrays stored row by row are lent.
            Numbers::Lent(array) => array.as_slice().unwrap_or(&[]),
            Numbers::Own(values) => values,
        }
    }

    fn copied(self) -> Vec<f64> {
        match self {
            Numbers::Lent(_) => self.as_slice().to_vec(),
            Numbers::Own(values) => values,
        }
    }
}

/// Converts an array-like of integers or floats to float64; raises TypeError for any other type, such as complex numbers, text
/// or objects. A float64 array stored row by row is lent.
fn numbers<'py>(of: &Bound<'py, PyAny>, name: &str, needed: &str) -> PyResult<(Vec<usize>, Numbers<'py>)> {
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
    let array: PyReadonlyArrayDyn<'py, f64> = array.try_readonly()?;
    let shape = array.shape().to_vec();
    // `as_slice` also accepts arrays stored column by column.
    let lent = array.is_c_contiguous() && array.as_slice().is_ok();
    let copy = || array.as_array().iter().copied().collect();
    Ok((shape, if lent { Numbers::Lent(array) } else { Numbers::Own(copy()) }))
}

fn shape_of(shape: &[usize]) -> String {
    let lengths: Vec<String> = shape.iter().map(usize::to_string).collect();
    format!("shape ({}{})", lengths.join(", "), if shape.len() == 1 { "," } else { "" })
}

/// Refuses the first value that is not a finite number of a sensible size, with its index.
fn check(values: &[f64], columns: Option<usize>, name: &str) -> PyResult<()> {
    let wrong = |value: &f64| value.is_nan() || value.abs() > MOST;
    // Found out on all cores and without a branch a number; only a refusal looks for the place.
    let are_sound = |values: &[f64]| {
        let mut all = true;
        for value in values {
            all &= value.abs() <= MOST;
        }
        all
    };
    let sound = values.par_chunks(CHUNK).all(are_sound);
    let at = if sound { None } else { values.iter().position(wrong) };
    let Some(at) = at else { return Ok(()) };
    let place = columns.map_or(format!("{at}"), |columns| format!("{}, {}", at / columns, at % columns));
    Err(Error::new_err(format!("{name}[{place}]: found {}, needed a number of at most {MOST:e}", values[at])))
}

/// Reads an array whose number of columns is one of `widths`; returns that number and the values row by row.
pub(crate) fn rows(of: &Bound<'_, PyAny>, name: &str, widths: &[usize]) -> PyResult<(usize, Vec<f64>)> {
    lent_rows(of, name, widths).map(|(width, values)| (width, values.copied()))
}

fn lent_rows<'py>(of: &Bound<'py, PyAny>, name: &str, widths: &[usize]) -> PyResult<(usize, Numbers<'py>)> {
    let listed: Vec<String> = widths.iter().map(|width| format!("(n, {width})")).collect();
    let needed = format!("an array of real numbers, shape {}, n at least 1", listed.join(" or "));
    let (shape, values) = numbers(of, name, &needed)?;
    match shape[..] {
        [count, width] if count > 0 && widths.contains(&width) => {
            check(values.as_slice(), Some(width), name)?;
            Ok((width, values))
        }
        _ => Err(Error::new_err(format!("{name}: found {}, needed {needed}", shape_of(&shape)))),
    }
}

/// Reads an array with the columns of one of `forms`, in that order, or a data frame that has them under these names, in any
/// order and with others beside them. The widest form that a data frame has is read.
pub(crate) fn named(of: &Bound<'_, PyAny>, name: &str, forms: &[&[&str]]) -> PyResult<(usize, Vec<f64>)> {
    lent(of, name, forms).map(|(width, values)| (width, values.copied()))
}

/// [`named`] without a copy of an array's memory.
pub(crate) fn lent<'py>(of: &Bound<'py, PyAny>, name: &str, forms: &[&[&str]]) -> PyResult<(usize, Numbers<'py>)> {
    let widths: Vec<usize> = forms.iter().map(|form| form.len()).collect();
    if !is_frame(of)? {
        return lent_rows(of, name, &widths);
    }
    let columns: Vec<String> = columns_of(of)?;
    let whole = |form: &&&[&str]| form.iter().all(|column| columns.iter().any(|own| own == column));
    let Some(form) = forms.iter().filter(whole).max_by_key(|form| form.len()) else {
        let needed: Vec<String> = forms.iter().map(|form| form.join(", ")).collect();
        let found = format!("columns {}", columns.join(", "));
        return Err(Error::new_err(format!("{name}: found {found}, needed {}", needed.join(" or "))));
    };
    let picked = form.iter().map(|column| of.get_item(column)).collect::<PyResult<Vec<_>>>()?;
    lent_rows(&of.py().import("numpy")?.call_method1("column_stack", (picked,))?, name, &[form.len()])
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
    check(values.as_slice(), None, name)?;
    Ok(values.copied())
}
