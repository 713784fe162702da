//! The Python module: passes arrays to the crates' functions and returns arrays. It contains no formula.
//!
//! It releases the interpreter's lock during computations.

mod arrays;
mod ballbar;
mod calibrate;
mod documents;
mod edit;
mod evaluate;
mod identification;
mod json;
mod keep;
mod kinematics;
mod learn;
mod machine;
mod measured;
mod path;
mod predict;
mod shown;
mod simulation;
mod thermal;
mod transfer;
mod units;

use pyo3::create_exception;
use pyo3::exceptions::{PyFileNotFoundError, PyValueError};
use pyo3::prelude::*;
use std::io;
use trueaxis_sim::SimError;
use trueaxis_tables::error::FileError;

create_exception!(
    trueaxis,
    Error,
    PyValueError,
    "Refused input: place, value found and value needed, in the words of the command line."
);

create_exception!(
    trueaxis,
    NeedsPerson,
    Error,
    "A term of a re-probing is out of its bounds: nothing is changed, and a person has to decide; exit code 3 of `trueaxis keep`."
);

/// Converts an error of the crates; see [`raised`].
fn to_python<T>(result: anyhow::Result<T>) -> PyResult<T> {
    result.map_err(|error| raised(&error, format!("{error:#}")))
}

/// The exception for an error, with this text: FileNotFoundError for a file that does not exist, else the module's own.
fn raised(error: &anyhow::Error, text: String) -> PyErr {
    let missing = |cause: &(dyn std::error::Error + 'static)| {
        let io = match cause.downcast_ref() {
            Some(SimError::Unread { error, .. }) => Some(error),
            _ => cause.downcast_ref::<io::Error>(),
        };
        io.is_some_and(|error| error.kind() == io::ErrorKind::NotFound)
            || cause.downcast_ref().is_some_and(FileError::is_missing)
    };
    if error.chain().any(missing) { PyFileNotFoundError::new_err(text) } else { Error::new_err(text) }
}

/// Raises a note of the command line as a Python warning.
fn warn(py: Python<'_>, note: &str) -> PyResult<()> {
    let text = std::ffi::CString::new(note.replace('\0', " "))?;
    PyErr::warn(py, &py.get_type::<pyo3::exceptions::PyUserWarning>(), &text, 1)
}

/// Errors and corrections of machine tools over NumPy arrays: the module computes the numbers that `trueaxis` prints.
///
/// Positions are in mm and degrees, errors in µm: actual − ideal, of the tool relative to the workpiece.
#[pymodule(name = "_native")]
fn python(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("Error", module.py().get_type::<Error>())?;
    module.add("NeedsPerson", module.py().get_type::<NeedsPerson>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<machine::Machine>()?;
    module.add_function(wrap_pyfunction!(machine::restored_machine, module)?)?;
    module.add_class::<path::Path>()?;
    module.add_class::<simulation::Program>()?;
    module.add_function(wrap_pyfunction!(simulation::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(kinematics::helicoid, module)?)?;
    module.add_function(wrap_pyfunction!(identification::identify, module)?)?;
    module.add_function(wrap_pyfunction!(identification::friction, module)?)?;
    module.add_function(wrap_pyfunction!(ballbar::ballbar, module)?)?;
    module.add_function(wrap_pyfunction!(calibrate::calibrate_plan, module)?)?;
    module.add_function(wrap_pyfunction!(calibrate::calibrate_solve, module)?)?;
    module.add_function(wrap_pyfunction!(keep::keep_plan, module)?)?;
    module.add_function(wrap_pyfunction!(keep::keep_begin, module)?)?;
    module.add_function(wrap_pyfunction!(keep::keep_check, module)?)?;
    module.add_function(wrap_pyfunction!(keep::keep_apply, module)?)?;
    module.add_function(wrap_pyfunction!(keep::keep_undo, module)?)?;
    module.add_function(wrap_pyfunction!(keep::keep_history, module)?)?;
    module.add_function(wrap_pyfunction!(thermal::thermal_fit, module)?)?;
    module.add_function(wrap_pyfunction!(thermal::thermal_compile, module)?)?;
    module.add_function(wrap_pyfunction!(learn::learn, module)?)?;
    module.add_function(wrap_pyfunction!(predict::predict, module)?)?;
    module.add_function(wrap_pyfunction!(transfer::import_table, module)?)?;
    module.add_function(wrap_pyfunction!(transfer::export_table, module)?)?;
    module.add_function(wrap_pyfunction!(evaluate::accuracy, module)?)?;
    module.add_function(wrap_pyfunction!(evaluate::evaluate_probing, module)?)?;
    module.add_function(wrap_pyfunction!(evaluate::evaluate_thermal, module)?)?;
    module.add_function(wrap_pyfunction!(evaluate::evaluate_step_diagonal, module)?)?;
    module.add_function(wrap_pyfunction!(evaluate::evaluate_r_test, module)?)?;
    module.add_function(wrap_pyfunction!(evaluate::evaluate_points, module)?)?;
    module.add_function(wrap_pyfunction!(documents::circle, module)?)?;
    module.add_function(wrap_pyfunction!(documents::trace_roundness, module)?)?;
    module.add_function(wrap_pyfunction!(documents::roundness, module)?)?;
    module.add_function(wrap_pyfunction!(documents::probe_angles, module)?)
}
