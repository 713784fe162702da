//! A machine that keeps itself true: the functions re-probe balls that stay in place, with the code of `trueaxis keep`.

use crate::shown::{result, table_result};
use crate::{Error, NeedsPerson, json, to_python, warn};
use anyhow::{Result, anyhow};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use trueaxis_evaluation::keep::{EntryKind, EvaluatedLog, Log, Overrides, Planning, State, time as checked};
use trueaxis_tables::output::Outputs;
use trueaxis_tables::text::read_text;

/// Calls a function with notes, without the interpreter's lock, and raises the notes as warnings.
fn noting<T: Send>(py: Python<'_>, work: impl FnOnce(&mut Vec<String>) -> Result<T> + Send) -> PyResult<T> {
    let mut notes = Vec::new();
    let found = py.detach(|| work(&mut notes));
    notes.iter().try_for_each(|note| warn(py, note))?;
    to_python(found)
}

fn time_of(time: Option<String>) -> PyResult<Option<String>> {
    let time = time.map(|time| checked(&time).map_err(|needed| format!("time: found {time:?}, {needed}"))).transpose();
    time.map_err(Error::new_err)
}

/// A re-probing with its arguments.
struct Asked {
    task: PathBuf,
    log: PathBuf,
    time: Option<String>,
    parts: Option<u64>,
    accept: Vec<String>,
    by_hand: bool,
}

impl Asked {
    fn check(&self, state: &State, notes: &mut Vec<String>) -> Result<EvaluatedLog> {
        state.accepts(&self.accept).map_err(|wrong| anyhow!("accept: {wrong}"))?;
        let text = read_text(&self.log, &['#', ';'])?;
        let allowed = Overrides { accept: &self.accept, by_hand: self.by_hand };
        state.check(&self.log(&text), allowed, &mut |note| notes.push(note))
    }

    fn log<'a>(&'a self, text: &'a str) -> Log<'a> {
        Log { file: &self.log, text, time: self.time.clone(), parts: self.parts }
    }

    /// Writes the history entry and the changes of a re-probing.
    fn put(&self, state: &State, evaluated: &EvaluatedLog) -> Result<()> {
        let mut outputs = Outputs::of([&self.task, &self.log]);
        state.stage(&mut outputs, &state.written(&evaluated.entry, &evaluated.files)?)?;
        Ok(outputs.commit()?)
    }
}

/// The document of a re-probing, with a sentence on each change under `changes`.
fn document<'py>(py: Python<'py>, evaluated: &EvaluatedLog) -> PyResult<Bound<'py, PyDict>> {
    let document = json::dictionary(py, &evaluated.document)?;
    document.set_item("changes", &evaluated.changes)?;
    Ok(document)
}

fn reprobing<'py>(py: Python<'py>, evaluated: &EvaluatedLog) -> PyResult<Bound<'py, PyAny>> {
    result("Reprobing", document(py, evaluated)?, Some(evaluated.document.shown()))
}

/// Plan the re-probing program of a task and the standard error expected of every term.
///
/// Parameters
/// ----------
/// task : path-like
///     A keep.toml (docs/calibration.md), which states the machine's folder relative to its own.
///
/// Returns
/// -------
/// KeepPlan
///     The document of `trueaxis keep plan --json`, with the program's text under `program_text`.
///
/// Raises
/// ------
/// trueaxis.Error
///     With file and line: balls that do not separate the terms, a bound below the smallest change that they
///     show.
///
/// Notes
/// -----
/// The standard errors assume that the balls' places at the first probing are exact; the bounds have the same unit.
#[pyfunction]
pub(crate) fn keep_plan(py: Python<'_>, task: PathBuf) -> PyResult<Bound<'_, PyAny>> {
    let planned = noting(py, |notes| {
        let state = State::read(&task, &mut |note| notes.push(note))?;
        Planning::new(&state.task, &state.machine)
    })?;
    let document = json::dictionary(py, &planned.foreseen)?;
    document.set_item("program_text", planned.program)?;
    let text = format!("{} touches, about {:.0} min\n", planned.foreseen.touches, planned.foreseen.minutes.ceil());
    table_result("KeepPlan", document, "Probing program", (text, planned.foreseen.expected()))
}

/// Evaluate the first probing, with which the later ones are compared, and add it to the history.
///
/// Parameters
/// ----------
/// task : path-like
///     The keep.toml of the machine (docs/calibration.md), which states the machine's folder relative to its own.
/// log : path-like
///     Log of the re-probing program, as the control wrote it.
/// time : str, optional
///     Time of the probing, UTC, such as "2026-05-04T06:00:00Z".
/// parts : int, optional
///     Number of parts made until then, as the control counts them.
///
/// Returns
/// -------
/// Reprobing
///     The document of `trueaxis keep begin`.
///
/// Raises
/// ------
/// trueaxis.Error
///     As calibrate_solve does, and while another command changes the machine.
///
/// Notes
/// -----
/// Changes nothing of the machine except keep/history.jsonl in its folder, which gains a line.
#[pyfunction]
#[pyo3(signature = (task, log, *, time = None, parts = None))]
pub(crate) fn keep_begin(
    py: Python<'_>,
    task: PathBuf,
    log: PathBuf,
    time: Option<String>,
    parts: Option<u64>,
) -> PyResult<Bound<'_, PyAny>> {
    let asked = Asked { task, log, time: time_of(time)?, parts, accept: Vec::new(), by_hand: false };
    let evaluated = noting(py, |notes| {
        let note = &mut |note| notes.push(note);
        let state = State::alone(&asked.task, note)?;
        let evaluated = state.begin(&asked.log(&read_text(&asked.log, &['#', ';'])?), note)?;
        asked.put(&state, &evaluated)?;
        Ok(evaluated)
    })?;
    reprobing(py, &evaluated)
}

/// Compute the changes that a log would make, and the reasons.
///
/// Parameters
/// ----------
/// task : path-like
///     The keep.toml of the machine (docs/calibration.md), which states the machine's folder relative to its own.
/// log : path-like
///     Log of the re-probing program, as the control wrote it.
/// time : str, optional
///     Time of the probing, UTC, such as "2026-05-04T06:00:00Z".
/// parts : int, optional
///     Number of parts made until then, as the control counts them.
/// accept : sequence of str, optional
///     Names of terms that are accepted out of their bounds.
/// by_hand : bool, default False
///     Whether tables that somebody has changed since the last entry of the history are accepted.
/// files : bool, default False
///     True adds the machine's changed files under `files`, a dict of texts by name.
///
/// Returns
/// -------
/// Reprobing
///     The document of `trueaxis keep check --json`, with a sentence on each change under `changes`.
///
/// Raises
/// ------
/// trueaxis.Error
///     With file and line: a history without its first entry, a log of another task or an earlier one, tables
///     changed by hand.
///
/// Notes
/// -----
/// Writes no file.
///
/// The document contains, for every term, the error that remains after the tables, its standard error, the sum of
/// the updates before and after this one (`from`, `to`), the bounds, and the verdict `keep`, `update` or `refused`
/// with its `reason`. `refused` counts the terms that a person must decide on.
#[pyfunction]
#[pyo3(signature = (task, log, *, time = None, parts = None, accept = Vec::new(), by_hand = false, files = false))]
pub(crate) fn keep_check(
    py: Python<'_>,
    task: PathBuf,
    log: PathBuf,
    time: Option<String>,
    parts: Option<u64>,
    accept: Vec<String>,
    by_hand: bool,
    files: bool,
) -> PyResult<Bound<'_, PyAny>> {
    let asked = Asked { task, log, time: time_of(time)?, parts, accept, by_hand };
    let evaluated = noting(py, |notes| {
        let state = State::read(&asked.task, &mut |note| notes.push(note))?;
        asked.check(&state, notes)
    })?;
    let document = document(py, &evaluated)?;
    if files {
        let texts = PyDict::new(py);
        for (name, bytes) in evaluated.files.iter().filter_map(|(name, bytes)| Some((name, bytes.as_ref()?))) {
            texts.set_item(name, String::from_utf8_lossy(bytes))?;
        }
        document.set_item("files", texts)?;
    }
    result("Reprobing", document, Some(evaluated.document.shown()))
}

/// Apply the changes from a log and add them to the history.
///
/// Parameters
/// ----------
/// task : path-like
///     The keep.toml of the machine (docs/calibration.md), which states the machine's folder relative to its own.
/// log : path-like
///     Log of the re-probing program, as the control wrote it.
/// time : str, optional
///     Time of the probing, UTC, such as "2026-05-04T06:00:00Z".
/// parts : int, optional
///     Number of parts made until then, as the control counts them.
/// accept : sequence of str, optional
///     Names of terms that are accepted out of their bounds.
/// by_hand : bool, default False
///     Whether tables that somebody has changed since the last entry of the history are accepted.
///
/// Returns
/// -------
/// Reprobing
///     The document of `trueaxis keep apply`, with `applied` and `changes`.
///
/// Raises
/// ------
/// trueaxis.NeedsPerson
///     And writes nothing if a term is out of its bounds. Raises trueaxis.Error as keep_check does, and while
///     another command changes the machine.
///
/// Notes
/// -----
/// The arguments are those of keep_check.
///
/// The function writes all files or none, as the command does: it copies replaced files to keep/NUMBER and
/// recompiles tcomp and ttherm files.
#[pyfunction]
#[pyo3(signature = (task, log, *, time = None, parts = None, accept = Vec::new(), by_hand = false))]
pub(crate) fn keep_apply(
    py: Python<'_>,
    task: PathBuf,
    log: PathBuf,
    time: Option<String>,
    parts: Option<u64>,
    accept: Vec<String>,
    by_hand: bool,
) -> PyResult<Bound<'_, PyAny>> {
    let asked = Asked { task, log, time: time_of(time)?, parts, accept, by_hand };
    let (evaluated, refusal) = noting(py, |notes| {
        let state = State::alone(&asked.task, &mut |note| notes.push(note))?;
        let mut evaluated = asked.check(&state, notes)?;
        let refusal = evaluated.refusal(&asked.log);
        if refusal.is_none() {
            asked.put(&state, &evaluated)?;
            evaluated.document.applied = evaluated.entry.kind == EntryKind::Update;
        }
        Ok((evaluated, refusal))
    })?;
    match refusal {
        Some(reason) => Err(NeedsPerson::new_err(reason)),
        None => reprobing(py, &evaluated),
    }
}

/// Restore the machine's files to their state before an entry of the history, like `trueaxis keep undo`.
///
/// Parameters
/// ----------
/// task : path-like
///     The keep.toml of the machine (docs/calibration.md), which states the machine's folder relative to its own.
/// entry : int, optional
///     The first entry to undo, with all later ones; None undoes the last update in effect.
/// time : str, optional
///     Time of the undo, UTC, such as "2026-05-04T06:00:00Z".
/// by_hand : bool, default False
///     Whether the tables are replaced even if somebody has changed them since the last entry of the history.
///
/// Returns
/// -------
/// dict[str, Any]
///     The new entry in the form of keep_history.
///
/// Raises
/// ------
/// trueaxis.Error
///     Nothing to undo, tables changed by hand, copies that are missing or damaged.
#[pyfunction]
#[pyo3(signature = (task, entry = None, *, time = None, by_hand = false))]
pub(crate) fn keep_undo(
    py: Python<'_>,
    task: PathBuf,
    entry: Option<u32>,
    time: Option<String>,
    by_hand: bool,
) -> PyResult<Bound<'_, PyAny>> {
    let time = time_of(time)?;
    let undone = noting(py, |notes| {
        let note = &mut |note| notes.push(note);
        let state = State::alone(&task, note)?;
        let undone = state.undone(entry, time, by_hand, note)?;
        state.put_back(Outputs::of([&task]), &undone)?;
        Ok(undone)
    })?;
    json::value(py, &undone.entry)
}

/// Return the history of a task's machine: the entries of `trueaxis keep history --json`.
///
/// Parameters
/// ----------
/// task : path-like
///     The keep.toml of the machine (docs/calibration.md), which states the machine's folder relative to its own.
///
/// Returns
/// -------
/// list of dict
///     The entries of `trueaxis keep history --json`, the first one first.
///
/// Raises
/// ------
/// trueaxis.Error
///     If an argument or a record is refused: what was found, and what is needed.
#[pyfunction]
pub(crate) fn keep_history(py: Python<'_>, task: PathBuf) -> PyResult<Bound<'_, PyAny>> {
    let entries = noting(py, |notes| Ok(State::read(&task, &mut |note| notes.push(note))?.history.entries))?;
    json::value(py, &entries)
}
