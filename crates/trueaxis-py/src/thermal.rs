//! Fits thermal growth to a recorded warm-up.

use crate::machine::Machine;
use crate::measured::Measured;
use crate::shown::result;
use crate::{documents, raised, warn};
use pyo3::prelude::*;
use trueaxis_evaluation::thermal::{COLUMNS, FittedRecording, Recording, settings, written};

/// Fit lags of sensors and curves of growth to cycles recorded according to ISO 230-3.
///
/// Parameters
/// ----------
/// record : dict of array-likes or data frame or path-like
///     A file, or a dict of arrays t_s, cycle, T1_c[, …, T16_c][, spindle_rpm], ex_um[, ey_um, ez_um][, x_mm,
///     y_mm, z_mm, tool_mm]. Rows of the arrays count from line 2.
/// machine : Machine, optional
///     States reference temperature and datums; by default, 20 °C and 0 mm.
/// hold_out : sequence of int, optional
///     Cycles to exclude from the fit; by default, the last one.
/// without : sequence of str, optional
///     Sensors to omit, such as "T3".
/// toml : bool, default False
///     Whether the result has the text of a thermal.toml under `toml`.
///
/// Returns
/// -------
/// ThermalFit
///     The document of `trueaxis thermal fit --json`, and with toml=True the text of a thermal.toml under
///     `toml`.
///
/// Raises
/// ------
/// trueaxis.Error
///     With line and column: a sensor that jumps, sticks or is missing, rows missing for longer than a lag, a
///     record in which nothing moves.
///
/// Notes
/// -----
/// The drift of the tool relative to the workpiece, actual − ideal, µm, is e = c + Σ_j [O_j(θ_j) + S_j(θ_j) (q −
/// q0)] + Σ_k x_k (G_k + Θ_k L), θ_j' = (T_j − θ_j)/τ_j, x_k' = (h_k(n) − x_k)/τ.
///
/// If an otherwise even record lacks rows, `missing` lists them, each with a warning.
#[pyfunction]
#[pyo3(signature = (record, *, machine = None, hold_out = Vec::new(), without = Vec::new(), toml = false))]
pub(crate) fn thermal_fit<'py>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    machine: Option<Bound<'py, Machine>>,
    hold_out: Vec<u32>,
    without: Vec<String>,
    toml: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let measured = Measured::of_columns(record, "record", &COLUMNS)?;
    let settings = settings(machine.as_ref().map(|machine| &machine.get().machine.settings), hold_out);
    let mut notes = Vec::new();
    let found = py.detach(|| {
        let recording = Recording::read(measured.rows(&COLUMNS, &mut notes)?, &without)?;
        FittedRecording::of(recording, &settings, &mut |_| {})
    });
    notes.iter().try_for_each(|note| warn(py, note))?;
    // Python calls the command line's option an argument, without dashes.
    let found = found.map_err(|error| raised(&error, format!("{error:#}").trim_start_matches("--").to_owned()))?;
    let document = found.document();
    document.missing.iter().try_for_each(|own| warn(py, &own.to_string()))?;
    let shown = document.shown(&found);
    let document = documents::dictionary(py, &document)?;
    if toml {
        document.set_item("toml", written(&found))?;
    }
    result("ThermalFit", document, Some(shown))
}
