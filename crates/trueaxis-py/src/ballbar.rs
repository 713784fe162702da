//! Circular tests.

use crate::machine::{Machine, decided};
use crate::measured::Measured;
use crate::shown::result;
use crate::{Error, json, to_python, warn};
use numpy::PyArray1;
use pyo3::prelude::*;
use trueaxis_evaluation::ballbar::{Options, Test};
use trueaxis_evaluation::friction::pair;

/// Evaluate a circular test according to ISO 230-4 and determine the causes of its deviation.
///
/// Parameters
/// ----------
/// record : array-like or data frame or path-like or file object
///     A file that the command reads; or an array (n, 3) of a bar, columns angle_deg, deviation_um and
///     direction (1 counterclockwise, -1 clockwise); or an array (n, 4), command and position in mm of the
///     first axis, then of the second. Rows of an array count from line 2.
/// radius_mm : float
///     Nominal radius in mm.
/// axes : str, default "X,Y"
///     The two axes of the circles' plane, in its sense: "X,Y", "Z,X" or "Y,Z", or a pair the other way round.
/// pitch_x_mm : float, optional
///     Pitch of the periodic error of X, of its screw or encoder, mm; by default, it is searched for.
/// pitch_y_mm : float, optional
///     Pitch of a periodic error of Y in mm; by default, it is searched for.
/// pitch_z_mm : float, optional
///     Pitch of a periodic error of Z in mm; by default, it is searched for.
/// machine : Machine, optional
///     Adds `written`, the command's decision on every setting found.
/// compensated : bool, default False
///     Whether the machine's tables corrected it during the record.
/// traces : bool, default False
///     True adds arrays with one number per reading: angle_deg; direction; centred_um, the deviation about the
///     circle's centre; left_um, the residual of the causes.
///
/// Returns
/// -------
/// Ballbar
///     The document of `trueaxis ballbar --json`.
///
/// Raises
/// ------
/// trueaxis.Error
///     If an argument or a record is refused: what was found, and what is needed.
///
/// Notes
/// -----
/// Writes no file.
#[pyfunction]
#[pyo3(signature = (record, *, radius_mm, axes = "X,Y", pitch_x_mm = None, pitch_y_mm = None, pitch_z_mm = None,
    machine = None, compensated = false, traces = false))]
pub(crate) fn ballbar<'py>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    radius_mm: f64,
    axes: &str,
    pitch_x_mm: Option<f64>,
    pitch_y_mm: Option<f64>,
    pitch_z_mm: Option<f64>,
    machine: Option<Bound<'py, Machine>>,
    compensated: bool,
    traces: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let axes = pair(axes).map_err(|error| Error::new_err(format!("axes: {error}")))?;
    let [a, b] = axes.map(|axis| axis.letter().to_ascii_lowercase());
    let positions = [format!("{a}_cmd_mm"), format!("{a}_mm"), format!("{b}_cmd_mm"), format!("{b}_mm")];
    let forms: [&[&str]; 2] = [&["angle_deg", "deviation_um", "direction"], &positions.each_ref().map(String::as_str)];
    let measured = Measured::of(record, "record", &forms)?;
    let options = to_python(Options::new(radius_mm, axes, [pitch_x_mm, pitch_y_mm, pitch_z_mm]).map_err(Into::into))?;
    let machine = machine.as_ref().map(Bound::get);
    let mut notes = Vec::new();
    let found = py.detach(|| {
        let bytes = measured.bytes()?;
        let name = measured.name();
        let test = Test::read(&bytes, name, &options, |note| notes.push(note))?;
        let document = test.document();
        let written = decided(machine, &measured, || Ok(test.additions(compensated)), &mut notes);
        Ok((test, document, written))
    });
    notes.iter().try_for_each(|note| warn(py, note))?;
    let (test, document, written) = to_python(found)?;
    let found = json::dictionary(py, &document)?;
    json::with_decisions(&found, written.as_deref())?;
    if traces {
        let angles = test.readings.iter().map(|reading| reading.angle_rad.to_degrees());
        let ways = test.readings.iter().map(|reading| if reading.counterclockwise { 1.0 } else { -1.0 });
        found.set_item("angle_deg", PyArray1::<f64>::from_iter(py, angles))?;
        found.set_item("direction", PyArray1::<f64>::from_iter(py, ways))?;
        for (name, part) in [("centred_um", 0), ("left_um", 1)] {
            let values = test.found.centred.iter().map(|deviation| 1e3 * deviation[part]);
            found.set_item(name, PyArray1::<f64>::from_iter(py, values))?;
        }
    }
    result("Ballbar", found, Some(document.shown(&test)))
}
