//! A part before it is cut: the code of `trueaxis predict`.

use crate::machine::Machine;
use crate::measured::Measured;
use crate::shown::result;
use crate::{Error, json, raised, warn};
use pyo3::prelude::*;
use std::path::PathBuf;
use trueaxis_evaluation::predict::{
    Options, PartFiles, Start, TEMPERATURES, TemperatureRecord, advise as advice_on, elsewhere, growth_model, own_task,
    predict as evaluate, predict_with_servo,
};

/// Predict whether a part will be in tolerance on a machine, before it is cut.
///
/// Parameters
/// ----------
/// machine : Machine
///     A machine in source form; its files state the uncertainties.
/// part : path-like
///     The part's file: features by lines of the program, tolerances, instruments.
/// program : path-like, optional
///     The G-code file; by default, the part's `program`, beside its file.
/// at_mm : sequence of float, optional
///     Another place of the program's zero in the machine: X, Y, Z in mm; by default, that of the part's file.
/// trials : int, default 10000
///     Number of machines drawn at random, 200 to 1000000.
/// seed : int, default 1
///     The same seed draws the same machines.
/// thermal : dict of array-likes or data frame or path-like or file object, optional
///     Temperatures while the part is cut: a file, or a dict of arrays t_s, T1_c[, …, T16_c][, spindle_rpm][, tool_mm], in
///     s, °C, rpm and mm. Rows of the arrays count from line 2. They replace `machine_c` of the part's file.
/// start : float, optional
///     Start of the program, s after the first row of `thermal`; by default, 0.
/// at : str, optional
///     Start of the program on the clock, "HH:MM", if t_s of `thermal` counts from midnight.
/// servo : bool, default False
///     True simulates the servo where the program cuts the features, which takes seconds to minutes: `everything_um` of each
///     feature is the value with all that the machine configures against its error.
/// rate_hz : float, default 10000
///     Servo rate, Hz.
/// exact_drives : bool, default False
///     True takes the figures of the drives as exactly stated, which saves a run of the servo for each uncertain one.
/// advise : bool, default False
///     True adds what to measure, where to put the part and in which direction to cut under `advice`.
///
/// Returns
/// -------
/// PredictedPart
///     The document of `trueaxis predict --json`; `to_frame` has the verdicts, `budget` all contributions, and with
///     advise=True `advice_measurements` what to measure and `advice_after` every characteristic before and after, as data
///     frames.
///
/// Raises
/// ------
/// trueaxis.Error
///     With file and line: a part or a program that is refused, features that their lines do not cut, a program that leaves
///     the travel of the machine, a record that ends before the part is cut; a moving axis without figures of its drive.
///
/// Notes
/// -----
/// Values are those of exact transforms, µm; the interval contains the true value with 95 %, over the drawn machines. The
/// growth is that of the `thermal.toml` beside the machine's file if there is one, else of its `[axis.X.thermal]`. Without
/// `servo` and temperatures these are not included; the process never is.
#[pyfunction]
#[pyo3(signature = (machine, part, program = None, *, at_mm = None, trials = 10_000, seed = 1, thermal = None, start = None,
    at = None, servo = false, rate_hz = 10_000.0, exact_drives = false,
    advise = false))]
pub(crate) fn predict<'py>(
    py: Python<'py>,
    machine: &Bound<'py, Machine>,
    part: PathBuf,
    program: Option<PathBuf>,
    at_mm: Option<[f64; 3]>,
    trials: u64,
    seed: u64,
    thermal: Option<Bound<'py, PyAny>>,
    start: Option<f64>,
    at: Option<&str>,
    servo: bool,
    rate_hz: f64,
    exact_drives: bool,
    advise: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let Machine { machine, stated: Some(stated), path, .. } = machine.get() else {
        return Err(Error::new_err(
            "machine: found a compiled file, which states no uncertainty, needed a machine.toml",
        ));
    };
    if let Some(found) = at_mm.iter().flatten().find(|mm| !mm.is_finite()) {
        return Err(Error::new_err(format!("at_mm: found {found}, needed a finite number")));
    }
    let begin = begin(start, at, thermal.is_some())?;
    let measured = thermal.map(|thermal| Measured::of_columns(&thermal, "thermal", &TEMPERATURES)).transpose()?;
    let mut notes = Vec::new();
    let predicted = || {
        let PartFiles { part: mut own, program, .. } = PartFiles::read(&part, program.as_deref(), "program")?;
        own.at_mm = at_mm.unwrap_or(own.at_mm);
        let read = |measured: &Measured| TemperatureRecord::read(measured.rows(&TEMPERATURES, &mut notes)?);
        let record = measured.as_ref().map(read).transpose()?;
        let own = own.warmed(record.as_ref().map(|record| (record, begin)), || growth_model(machine, path))?;
        let options = Options { trials, seed };
        if advise {
            own.require_instruments()?;
        }
        let mut document = if servo {
            let exact = exact_drives.then(|| stated.clone().with_exact_drives());
            let known = (machine, exact.as_ref().unwrap_or(stated));
            predict_with_servo(known, &program, &own, options, rate_hz, &mut |_, _| {})?
        } else {
            evaluate(machine, stated, &program, &own, options)?
        };
        if advise {
            let read = |name: &str| own_task(&part, name, path);
            let mut advice = advice_on(machine, stated, &program, &own, &document, &read)?;
            advice.elsewhere = Some(elsewhere(machine, stated, &program, &own, &document)?);
            document.advice = Some(advice);
        }
        anyhow::Ok(document)
    };
    let document = py.detach(predicted);
    notes.iter().try_for_each(|note| warn(py, note))?;
    let document = document.map_err(|error| raised(&error, format!("{error:#}")))?;
    result("PredictedPart", json::dictionary(py, &document)?, Some(document.shown()))
}

/// When the program starts in a record of temperatures.
fn begin(start: Option<f64>, at: Option<&str>, has_record: bool) -> PyResult<Start> {
    match (start, at) {
        (None, None) => return Ok(Start::After(0.0)),
        _ if !has_record => {
            let name = if start.is_some() { "start" } else { "at" };
            return Err(Error::new_err(format!("{name}: found no record of temperatures, needed thermal")));
        }
        (Some(_), Some(_)) => return Err(Error::new_err("at: found start and at, needed one of the two")),
        (Some(seconds), None) if seconds.is_finite() => Some(Start::After(seconds)),
        (Some(found), None) => return Err(Error::new_err(format!("start: found {found}, needed a finite number"))),
        (None, Some(text)) => Start::clock(text).map(Start::At),
    }
    .ok_or_else(|| {
        let found = at.unwrap_or_default();
        Error::new_err(format!("at: found {found:?}, needed hours and minutes, 00:00 to 23:59"))
    })
}
