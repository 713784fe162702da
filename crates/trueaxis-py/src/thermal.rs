//! Fits thermal growth to a recorded warm-up.

use crate::machine::Machine;
use crate::measured::Measured;
use crate::shown::result;
use crate::{Error, json, raised, to_python, warn};
use anyhow::anyhow;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::PathBuf;
use trueaxis::tcomp::machine_id;
use trueaxis_evaluation::thermal::{COLUMNS, FittedRecording, Recording, model, settings, with_rate, written};
use trueaxis_tables::text::read_text;

/// Fit lags of sensors and curves of growth to cycles recorded according to ISO 230-3.
///
/// Parameters
/// ----------
/// record : dict of array-likes or data frame or path-like or file object
///     A file, or a dict of arrays t_s, cycle, T1_c[, …, T16_c][, spindle_rpm], ex_um[, ey_um, ez_um][, x_mm,
///     y_mm, z_mm, tool_mm]. Rows of the arrays count from line 2.
/// machine : Machine, optional
///     States reference temperature and datums; by default, 20 °C and 0 mm.
/// hold_out : sequence of int, optional
///     Cycles to exclude from the fit; all of them: each in turn. By default, the last one.
/// without : sequence of str, optional
///     Sensors to omit, such as "T3".
/// rate_k_per_min : float, optional
///     Largest rate at which a sensor warms or cools, K/min, 0.1 to 1000; a faster change is refused as a jump. By default,
///     that of the command.
/// residuals : bool, default False
///     True adds the measured minus the predicted drift under `residuals_um`, (rows, axes), each relative to the first row of
///     its cycle at the same measuring point.
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
#[pyo3(signature = (record, *, machine = None, hold_out = Vec::new(), without = Vec::new(),
    rate_k_per_min = None, residuals = false, toml = false))]
pub(crate) fn thermal_fit<'py>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    machine: Option<Bound<'py, Machine>>,
    hold_out: Vec<u32>,
    without: Vec<String>,
    rate_k_per_min: Option<f64>,
    residuals: bool,
    toml: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let measured = Measured::of_columns(record, "record", &COLUMNS)?;
    let settings = settings(machine.as_ref().map(|machine| &machine.get().machine.settings), hold_out);
    // Python calls the command line's options arguments.
    let settings = with_rate(settings, rate_k_per_min)
        .map_err(|error| raised(&error, error.to_string().replace("--rate-k-per-min", "rate_k_per_min")))?;
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
    let document = json::dictionary(py, &document)?;
    if residuals {
        document.set_item("residuals_um", PyArray2::from_vec2(py, &found.residuals_um())?)?;
    }
    if toml {
        document.set_item("toml", written(&found))?;
    }
    result("ThermalFit", document, Some(shown))
}

/// Compile thermal growth into the file that the controller's task reads.
///
/// Parameters
/// ----------
/// thermal : ThermalFit or path-like
///     A fit made with toml=True, or a thermal.toml.
/// machine : Machine
///     The machine whose growth it is; its reference temperature and datums must be those of the fit.
///
/// Returns
/// -------
/// bytes
///     The .ttherm file that `trueaxis thermal compile` writes.
///
/// Raises
/// ------
/// trueaxis.Error
///     With file and line: an axis that the machine does not have, another reference temperature or datum.
#[pyfunction]
#[pyo3(signature = (thermal, *, machine))]
pub(crate) fn thermal_compile<'py>(
    py: Python<'py>,
    thermal: &Bound<'py, PyAny>,
    machine: &Bound<'py, Machine>,
) -> PyResult<Bound<'py, PyBytes>> {
    let (file, text) = match thermal.extract::<PathBuf>() {
        Ok(file) => {
            let text = to_python(read_text(&file, &['#']).map_err(Into::into))?;
            (file, text)
        }
        Err(_) => match thermal.getattr("toml").and_then(|text| text.extract::<String>()) {
            Ok(text) => (PathBuf::from("thermal"), text),
            Err(_) => {
                let found = thermal.get_type().name()?;
                let needed = "a thermal.toml, or a result of thermal_fit with toml=True";
                return Err(Error::new_err(format!("thermal: found {found}, needed {needed}")));
            }
        },
    };
    let settings = &machine.get().machine.settings;
    let bytes = to_python(py.detach(|| {
        let model = model(&text, &file, settings)?;
        let id = machine_id(&settings.name, &settings.chain);
        model.encode(id).map_err(|error| anyhow!("{}: {error}", file.display()))
    }))?;
    Ok(PyBytes::new(py, &bytes))
}
