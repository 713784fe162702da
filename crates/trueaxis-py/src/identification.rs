//! Identifies errors of rotary axes, and friction, from measurements.

use crate::machine::{Machine, decided};
use crate::measured::Measured;
use crate::shown::result;
use crate::{Error, json, to_python, warn};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use trueaxis::Axis;
use trueaxis_evaluation::shown::Shown;
use trueaxis_evaluation::{friction as circles, identify as ball};
use trueaxis_metrology::identification::Offsets;
use trueaxis_tables::Additions;
use trueaxis_tables::formats::write_axis_csv;

/// Identify the six errors of a rotary axis from readings of a ball that RTCP holds in place.
///
/// Parameters
/// ----------
/// readings : array-like or data frame or path-like or file object
///     A file, or an array (n, 6), columns angle_deg, l_mm, h_mm, dx_um, dy_um, dz_um. Rows of an array count
///     from line 2.
/// axis : {"A", "B", "C"}
///     The axis that turns.
/// machine : Machine, optional
///     States the sense of the axis; the function removes the errors of its linear axes. Unless it is a
///     compiled file, adds `written`, the decision on every error for the machine's current files: key, old,
///     found, written (None if the stated value stays), and why.
/// start_mm : sequence of float, optional
///     Position of X, Y, Z in mm in the first set-up at the first angle, with `machine`; RTCP moves them from there.
/// free_offsets : bool, default False
///     Whether one offset per set-up, constant in machine directions, is fitted too: the gauges were zeroed in every set-up.
/// table : bool, default False
///     True adds the axis' table as CSV text under `table`.
/// residuals : bool, default False
///     True adds the residual of every reading along X, Y, Z under `residuals_um`, (n, 3), by angle, then by set-up.
///
/// Returns
/// -------
/// Identification
///     The document of `trueaxis identify --json`.
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
#[pyo3(signature = (readings, *, axis, machine = None, start_mm = None, free_offsets = false, table = false,
    residuals = false))]
pub(crate) fn identify<'py>(
    py: Python<'py>,
    readings: &Bound<'py, PyAny>,
    axis: &str,
    machine: Option<Bound<'py, Machine>>,
    start_mm: Option<[f64; 3]>,
    free_offsets: bool,
    table: bool,
    residuals: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let axis = match axis {
        "A" => Axis::A,
        "B" => Axis::B,
        "C" => Axis::C,
        found => return Err(Error::new_err(format!("axis: found {found:?}, needed \"A\", \"B\" or \"C\""))),
    };
    if start_mm.is_some() && machine.is_none() {
        return Err(Error::new_err("start_mm: found no machine, needed the one measured"));
    }
    if let Some(value) = start_mm.iter().flatten().find(|value| value.is_nan() || value.abs() > 1e6) {
        return Err(Error::new_err(format!("start_mm: found {value}, needed a finite number of at most 1e6 mm")));
    }
    let measured = Measured::of(readings, "readings", &[&ball::COLUMNS.map(|column| column.name)])?;
    let machine = machine.as_ref().map(Bound::get);
    let offsets = if free_offsets { Offsets::Free } else { Offsets::Known };
    let mut notes = Vec::new();
    let found = py.detach(|| {
        let readings = ball::Readings::read(&mut measured.rows(&ball::COLUMNS, &mut notes)?)?;
        let known = machine.map(|Machine { machine, .. }| ball::Known {
            machine,
            file: machine.settings.name.as_str(),
            start_mm: start_mm.unwrap_or_default(),
        });
        let name = measured.name().display().to_string();
        let mut found = ball::identify(readings, &name, axis, offsets, known)?;
        let table = if table { Some(write_axis_csv(&found.table()?, axis)) } else { None };
        let additions = || machine.map_or(Ok(Additions::default()), |machine| found.additions(&machine.machine));
        let written = decided(machine, &measured, additions, &mut notes);
        let left = residuals.then(|| found.residuals_um());
        Ok((found.document, table, written, left))
    });
    notes.iter().try_for_each(|note| warn(py, note))?;
    let (document, table, written, left) = to_python(found)?;
    let found = json::dictionary(py, &document)?;
    json::with_decisions(&found, written.as_deref())?;
    if let Some(left) = left {
        let left: Vec<Vec<f64>> = left.into_iter().map(Vec::from).collect();
        found.set_item("residuals_um", PyArray2::from_vec2(py, &left)?)?;
    }
    if let Some(table) = table {
        found.set_item("table", table)?;
    }
    result("Identification", found, Some(document.shown(axis)))
}

/// Identify the friction of two axes and the figures of their drives from recorded circles.
///
/// Parameters
/// ----------
/// record : array-like or data frame or path-like or file object
///     A file that the command reads, or an array (n, 5): time in s, then command and reading in mm of the
///     first axis and of the second. Rows of an array count from line 2.
/// axes : str
///     The two axes of the circles' plane, in its sense: "X,Y", "Z,X" or "Y,Z", or a pair the other way round.
/// machine : Machine, optional
///     States the figures of its drives; adds `written`, the decision on every figure, as in `identify`.
/// find_drive : bool, default False
///     Whether the drives' figures are found even if the machine states them.
/// find_resonance : bool, default False
///     Whether the resonance of motor and load of each axis is searched for too; this takes several times as long.
/// read_after_us : float, optional
///     Time of the encoder's reading, µs after the command of its row takes effect (negative: before); used if the
///     drives' figures are found too.
/// residuals : bool, default False
///     True adds the recorded minus the modelled following error of both axes under `residuals_um`, (samples, 2), and their
///     times from the record's first row under `residuals_t_s`. The fit weighs the stretches around reversals; with stated
///     figures of the drives it leaves out starts and stops, which have residuals all the same.
/// toml : bool, default False
///     True adds the sections of a machine.toml under `toml`.
///
/// Returns
/// -------
/// Friction
///     The document of `trueaxis friction --json`.
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
#[pyo3(signature = (record, *, axes, machine = None, find_drive = false, find_resonance = false, read_after_us = None,
    residuals = false, toml = false))]
pub(crate) fn friction<'py>(
    py: Python<'py>,
    record: &Bound<'py, PyAny>,
    axes: &str,
    machine: Option<Bound<'py, Machine>>,
    find_drive: bool,
    find_resonance: bool,
    read_after_us: Option<f64>,
    residuals: bool,
    toml: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let axes = circles::pair(axes).map_err(|error| Error::new_err(format!("axes: {error}")))?;
    let read_after_s = read_after_us.map(circles::read_after_s).transpose();
    let read_after_s = read_after_s.map_err(|error| Error::new_err(format!("read_after_us: {error}")))?;
    let columns = circles::columns(axes);
    let [first, second] = axes.map(|axis| 1 + 2 * axis.index());
    let names = [0, first, first + 1, second, second + 1].map(|column| columns[column].name);
    let measured = Measured::of(record, "record", &[&names])?;
    let machine = machine.as_ref().map(Bound::get);
    let mut notes = Vec::new();
    let found = py.detach(|| {
        let given = match machine.filter(|_| !find_drive) {
            Some(Machine { machine, .. }) => circles::drives(machine, machine.settings.name.as_str(), axes)?,
            None => [None; 2],
        };
        let mut recording = circles::Recording::read(measured.rows(&columns, &mut notes)?, axes)?;
        recording.record.read_after_s = read_after_s;
        let (mut found, mut document) = circles::fit(&recording, given, &mut |_, _| {})?;
        if find_resonance {
            document = circles::resonances(&recording, &mut found, &mut |_, _| {})?;
        }
        let left = if residuals { Some(circles::residuals(&recording, &found)?) } else { None };
        let sections = toml.then(|| circles::sections(measured.name(), &found));
        let written = decided(machine, &measured, || Ok(circles::additions(&found)), &mut notes);
        let shown = Shown { plots: circles::spikes(&found), ..document.shown() };
        Ok((document, shown, sections, written, left))
    });
    notes.iter().try_for_each(|note| warn(py, note))?;
    let (document, shown, sections, written, left) = to_python(found)?;
    let found = json::dictionary(py, &document)?;
    json::with_decisions(&found, written.as_deref())?;
    if let Some((sample_s, [first, second])) = left {
        let t_s = (0..first.len()).map(|k| k as f64 * sample_s).collect();
        let rows: Vec<Vec<f64>> = first.iter().zip(&second).map(|(a, b)| vec![1e3 * a, 1e3 * b]).collect();
        found.set_item("residuals_um", PyArray2::from_vec2(py, &rows)?)?;
        found.set_item("residuals_t_s", PyArray1::from_vec(py, t_s))?;
    }
    if let Some(sections) = sections {
        found.set_item("toml", sections)?;
    }
    result("Friction", found, Some(shown))
}
