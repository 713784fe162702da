//! Calibration with a touch probe: computes a program from a task, and the machine's errors from the program's log.

use crate::shown::{result, table_result};
use crate::{json, to_python, warn};
use anyhow::{Context, Result};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use trueaxis_evaluation::calibrate::{Planning, Task, solved};
use trueaxis_tables::files::Folder;
use trueaxis_tables::text::read_text;
use trueaxis_tables::{Additions, Machine};

/// A task and its machine; the task states the machine's folder relative to its own.
struct Read {
    task: Task,
    folder: Folder,
    name: PathBuf,
    machine: Machine,
}

fn read(path: &Path, notes: &mut Vec<String>) -> Result<Read> {
    let task = Task::read(&read_text(path, &['#', ';'])?, path)?;
    let (folder, name) = Folder::of_machine(&path.parent().unwrap_or(Path::new("")).join(&task.machine));
    let machine = Machine::read_from(&folder, &name, &mut |note| notes.push(note))?;
    Ok(Read { task, folder, name, machine })
}

/// Plan the probing program of a task and the standard error expected of every term.
///
/// Parameters
/// ----------
/// task : path-like
///     A task.toml (docs/calibration.md), which states the machine's folder relative to its own.
///
/// Returns
/// -------
/// CalibrationPlan
///     The document of `trueaxis calibrate plan --json`, with the program's text, or the sheet for the
///     readings of a dial indicator, under `program_text`.
///
/// Raises
/// ------
/// trueaxis.Error
///     With file and line if a place is outside the machine's travel or the set-up cannot separate its terms.
///
/// Notes
/// -----
/// Standard errors are σ √((JᵀJ)⁻¹)_kk, with the stated repeatability σ of a touch and the Jacobian J at the
/// planned touches. The document states their units.
#[pyfunction]
pub(crate) fn calibrate_plan(py: Python<'_>, task: PathBuf) -> PyResult<Bound<'_, PyAny>> {
    let mut notes = Vec::new();
    let planned = py.detach(|| {
        let read = read(&task, &mut notes)?;
        Ok((read.task.words(), Planning::new(&read.task, &read.machine)?))
    });
    notes.iter().try_for_each(|note| warn(py, note))?;
    let (what, planned) = to_python(planned)?;
    let document = json::dictionary(py, &planned.foreseen)?;
    document.set_item("program_text", planned.program)?;
    let text = format!("{} {what}, about {:.0} min\n", planned.foreseen.touches, planned.foreseen.minutes.ceil());
    table_result("CalibrationPlan", document, "Probing program", (text, planned.foreseen.expected()))
}

/// Compute a machine's errors from the log of a probing program.
///
/// Parameters
/// ----------
/// task : path-like
///     The task from which the program was planned.
/// log : path-like
///     The control's log, the filled sheet of a dial indicator, or a CSV file with columns id, x_mm, y_mm, z_mm[,
///     a_deg, b_deg, c_deg], tripped.
/// files : bool, default False
///     True adds the machine's changed files under `files`, a dict of texts by name.
/// force : bool, default False
///     Takes every value found instead of the rule's decision, like `--force`.
/// residuals : bool, default False
///     True adds the residual of every touch, positive outside the surface, under `residuals_um`.
///
/// Returns
/// -------
/// Calibration
///     The document of `trueaxis calibrate solve --json`.
///
/// Raises
/// ------
/// trueaxis.Error
///     With file and line: a log of another task, touches that are missing, repeated or off their artefact, an
///     artefact whose size is out of range, a drift larger than the measured errors, terms that cannot be
///     separated.
///
/// Notes
/// -----
/// `written` lists the decision on every value: key, old, found, written (None if the stated value stays), and why.
/// Writes no file.
///
/// One least-squares fit solves for touches, places, sizes, tip and drift together. Errors are actual − ideal, of
/// the tool relative to the workpiece, with units in their names (µrad, µm, ppm); standard errors have the same
/// names.
#[pyfunction]
#[pyo3(signature = (task, log, *, files = false, force = false, residuals = false))]
pub(crate) fn calibrate_solve(
    py: Python<'_>,
    task: PathBuf,
    log: PathBuf,
    files: bool,
    force: bool,
    residuals: bool,
) -> PyResult<Bound<'_, PyAny>> {
    let asked_residuals = residuals;
    let mut notes = Vec::new();
    let found = py.detach(|| {
        let read = read(&task, &mut notes)?;
        let text = read_text(&log, &['#', ';'])?;
        let (_, found) = solved(&read.task, &read.machine, &text, &log, |note| notes.push(note))?;
        let record = std::fs::read(&log).with_context(|| log.display().to_string())?;
        let additions = Additions { force, ..found.additions(&read.task).of_record(&record) };
        let decisions = additions.decide(&read.folder, &read.name)?;
        let edited = additions.edit(&read.folder, &read.name)?;
        let document = found.document(&read.task, &read.machine);
        let shown = document.shown(&found);
        let residuals: Vec<f64> = found.solution.residuals_mm.iter().map(|mm| 1e3 * mm).collect();
        Ok((document, shown, decisions, (edited.files, residuals)))
    });
    notes.iter().try_for_each(|note| warn(py, note))?;
    let (document, shown, decisions, (edited, residuals)) = to_python(found)?;
    let document = json::dictionary(py, &document)?;
    json::with_decisions(&document, Some(&decisions))?;
    if asked_residuals {
        document.set_item("residuals_um", PyArray1::from_vec(py, residuals))?;
    }
    if files {
        let texts = PyDict::new(py);
        for (name, text) in edited {
            texts.set_item(name.to_string_lossy(), text)?;
        }
        document.set_item("files", texts)?;
    }
    result("Calibration", document, Some(shown))
}
