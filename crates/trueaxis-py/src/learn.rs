//! Learning from part to part: the code of `trueaxis learn`.

use crate::measured::Measured;
use crate::shown::result;
use crate::{Error, json, to_python, warn};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;
use trueaxis_evaluation::learn::{COLUMNS, Record, learned};
use trueaxis_evaluation::model;
use trueaxis_metrology::learning::{DEFAULT_CUTOFF_MM, DEFAULT_FORGET, DEFAULT_GAIN, Law};

/// Learn a correction over path length for the next part of a program from the contour error of the last one.
///
/// Parameters
/// ----------
/// record : path-like
///     One part, cycle by cycle: a file with the columns s_mm, ex_um, ey_um, ez_um[, measured], after comments that state
///     program_id, machine_id and length_mm.
/// table : path-like, optional
///     The .tlearn whose correction acted on the part; by default, none.
/// gain : float, optional
///     Gain L of the law, above 0 and below 2; by default, the command's.
/// forget : float, optional
///     Forgetting f of the law, above 0 to 1; by default, the command's.
/// cutoff_mm : float, optional
///     Cut-off along the path, mm: errors of longer wavelength are learned; by default, the command's.
///
/// Returns
/// -------
/// Learned
///     The document of `trueaxis learn --json`, with the content of the .tlearn for the next part under `table`, as bytes.
///
/// Raises
/// ------
/// trueaxis.Error
///     With file and line: a record that does not reach over the path, a table of another machine or program, a value of the
///     law that is out of its range.
///
/// Notes
/// -----
/// The law is u ← f u − L Q e, with the contour error e, the correction u and a Gaussian low-pass Q without phase, half at the
/// cut-off. Writes no file.
#[pyfunction]
#[pyo3(signature = (record, *, table = None, gain = DEFAULT_GAIN, forget = DEFAULT_FORGET, cutoff_mm = DEFAULT_CUTOFF_MM))]
pub(crate) fn learn<'py>(
    py: Python<'py>,
    record: PathBuf,
    table: Option<PathBuf>,
    gain: f64,
    forget: f64,
    cutoff_mm: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let law = Law { gain, forget, cutoff_mm };
    law.check().map_err(|error| Error::new_err(error.to_string().replace("cutoff-mm", "cutoff_mm")))?;
    let mut notes = Vec::new();
    let found = py.detach(|| {
        let measured = Measured::File(record.clone());
        let bytes = measured.bytes()?;
        let read = Record::read(&bytes[..], &record, || measured.rows(&COLUMNS, &mut notes))?;
        let old =
            table.as_ref().map(|table| Ok::<_, anyhow::Error>((table.as_path(), model::bytes(table)?))).transpose()?;
        let (document, lesson, file) =
            learned(law, &read, old.as_ref().map(|(table, bytes)| (*table, bytes.as_slice())))?;
        let shown = document.shown(&lesson);
        Ok((document, shown, file))
    });
    notes.iter().try_for_each(|note| warn(py, note))?;
    let (document, shown, file) = to_python(found)?;
    let found = json::dictionary(py, &document)?;
    found.set_item("table", PyBytes::new(py, &file))?;
    result("Learned", found, Some(shown))
}
