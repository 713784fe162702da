//! A part before it is cut: the code of `trueaxis predict`.

use crate::machine::Machine;
use crate::shown::result;
use crate::{Error, json, raised};
use pyo3::prelude::*;
use std::path::PathBuf;
use trueaxis_evaluation::predict::{
    Growth, Options, PartFiles, advise as advice_on, elsewhere, growth_model, own_task, predict as evaluate,
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
/// advise : bool, default False
///     True adds what to measure, where to put the part and in which direction to cut under `advice`.
///
/// Returns
/// -------
/// PredictedPart
///     The document of `trueaxis predict --json`; `budget` has all contributions as a data frame, `to_frame` the verdicts.
///
/// Raises
/// ------
/// trueaxis.Error
///     With file and line: a part or a program that is refused, features that their lines do not cut, a program that leaves
///     the travel of the machine.
///
/// Notes
/// -----
/// Values are those of exact transforms; the interval contains the true value with 95 %, over the drawn machines. Constant
/// temperatures of the part's file are included, by the `thermal.toml` beside the machine's file if there is one; servo,
/// recorded temperatures and process are not.
#[pyfunction]
#[pyo3(signature = (machine, part, program = None, *, at_mm = None, trials = 10_000, seed = 1, advise = false))]
pub(crate) fn predict<'py>(
    py: Python<'py>,
    machine: &Bound<'py, Machine>,
    part: PathBuf,
    program: Option<PathBuf>,
    at_mm: Option<[f64; 3]>,
    trials: u64,
    seed: u64,
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
    let predicted = || {
        let PartFiles { part: mut own, program, .. } = PartFiles::read(&part, program.as_deref(), "program")?;
        own.at_mm = at_mm.unwrap_or(own.at_mm);
        if let Some(celsius) = own.temperature.machine_c {
            own.growth = Some(Growth::constant(growth_model(machine, path)?, celsius)?);
        }
        let mut document = evaluate(machine, stated, &program, &own, Options { trials, seed })?;
        if advise {
            let read = |name: &str| own_task(&part, name, path);
            let mut advice = advice_on(machine, stated, &program, &own, &document, &read)?;
            advice.elsewhere = Some(elsewhere(machine, stated, &program, &own, &document)?);
            document.advice = Some(advice);
        }
        anyhow::Ok(document)
    };
    let document = py.detach(predicted).map_err(|error| raised(&error, format!("{error:#}")))?;
    result("PredictedPart", json::dictionary(py, &document)?, Some(document.shown()))
}
