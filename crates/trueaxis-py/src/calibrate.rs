//! Calibration with a touch probe: from a task to a program, from its log to the errors of the machine.

use crate::{documents, to_python, warn};
use anyhow::Result;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use trueaxis_evaluation::calibrate::{Planning, Task, solved};
use trueaxis_tables::files::Folder;
use trueaxis_tables::text::read_text;
use trueaxis_tables::{Additions, Machine};

/// A task with its machine, whose folder it names from its own.
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

/// The probing program of a task and the expected standard error of every term: the document of
/// `trueaxis calibrate plan --json`, and the program's text under `program_text`.
///
/// Standard errors are σ √((JᵀJ)⁻¹)_kk with the stated repeatability σ of a touch and J at the planned touches; units are
/// beside them. task: a task.toml, docs/calibration.md; the machine's folder counts from it.
///
/// Raises trueaxis.Error with file and line: a place out of the machine's travel, a set-up that cannot separate its terms.
#[pyfunction]
pub(crate) fn calibrate_plan(py: Python<'_>, task: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let mut notes = Vec::new();
    let planned = py.detach(|| {
        let read = read(&task, &mut notes)?;
        Planning::new(&read.task, &read.machine)
    });
    notes.iter().try_for_each(|note| warn(py, note))?;
    let planned = to_python(planned)?;
    let document = documents::dictionary(py, &planned.foreseen)?.cast_into::<PyDict>()?;
    document.set_item("program_text", planned.program)?;
    Ok(document)
}

/// The errors of a machine from the log of a probing program: the document of `trueaxis calibrate solve --json`, under `written`
/// the decision on every value (key, old, found, written, or None if the stated value stays, and why), and with files=True the
/// machine's changed files under `files`, a dict of texts by name.
///
/// One least-squares network of touches, places, sizes, tip and drift. Errors are actual − ideal, of the tool relative to the
/// workpiece: µrad, µm, ppm by their names; standard errors under the same names. task: the one that the program was planned
/// from. log: the control's, or a CSV id, x_mm, y_mm, z_mm[, a_deg, b_deg, c_deg], tripped. force:
/// as --force, every value found instead of the rule's. Nothing is written.
///
/// Raises trueaxis.Error with file and line: a log of another task, touches that are missing, doubled or off their artefact, an
/// artefact outside its size, a drift larger than the measured errors, terms that cannot be separated.
#[pyfunction]
#[pyo3(signature = (task, log, *, files = false, force = false))]
pub(crate) fn calibrate_solve(
    py: Python<'_>,
    task: PathBuf,
    log: PathBuf,
    files: bool,
    force: bool,
) -> PyResult<Bound<'_, PyDict>> {
    let mut notes = Vec::new();
    let found = py.detach(|| {
        let read = read(&task, &mut notes)?;
        let text = read_text(&log, &['#', ';'])?;
        let (_, found) = solved(&read.task, &read.machine, &text, &log, |note| notes.push(note))?;
        let record = std::fs::read(&log).map_err(|error| anyhow::anyhow!("{}: {error}", log.display()))?;
        let additions = Additions { force, ..found.additions(&read.task).of_record(&record) };
        let decisions = additions.decide(&read.folder, &read.name)?;
        let edited = additions.edit(&read.folder, &read.name)?;
        Ok((found.document(&read.task, &read.machine), decisions, edited.files))
    });
    notes.iter().try_for_each(|note| warn(py, note))?;
    let (document, decisions, edited) = to_python(found)?;
    let document = documents::dictionary(py, &document)?.cast_into::<PyDict>()?;
    documents::with_decisions(&document, Some(&decisions))?;
    if files {
        let texts = PyDict::new(py);
        for (name, text) in edited {
            texts.set_item(name.to_string_lossy(), text)?;
        }
        document.set_item("files", texts)?;
    }
    Ok(document)
}
