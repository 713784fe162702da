//! Tables of other controls: the code of `trueaxis tables import` and `export`.

use crate::machine::{Machine, axis_of};
use crate::shown::text_result;
use crate::{Error, json, raised};
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;
use trueaxis_evaluation::model::files;
use trueaxis_evaluation::transfer::{self, ImportOptions, TransferDocument, unit};
use trueaxis_tables::formats::marlin::Area;
use trueaxis_tables::formats::{ExportOptions, Loss};

/// Names the command line's options as the arguments of the functions.
fn in_arguments<T>(result: anyhow::Result<T>) -> PyResult<T> {
    result.map_err(|error| {
        let text =
            format!("{error:#}").replace("--from", "format").replace("--to", "format").replace("--area", "area_mm");
        raised(&error, text.replace("--comp-file-type", "comp_file_type").replace("--", ""))
    })
}

fn transferred<'py>(py: Python<'py>, document: &TransferDocument, lines: &[String]) -> PyResult<Bound<'py, PyAny>> {
    text_result("Transfer", json::dictionary(py, document)?, lines.join("\n"))
}

/// Read another control's compensation file into a machine's folder.
///
/// Parameters
/// ----------
/// file : path-like
///     The file.
/// folder : path-like
///     Folder of the machine. An existing machine gets the tables of the file's axes, added or replaced, and keeps the rest,
///     comments included; a bed mesh replaces an earlier one. Without a machine, one is made.
/// format : str
///     Format of the file: linuxcnc (linuxcnc-0, linuxcnc-1), siemens, isg, iso230-2, columns, rtl, bed-mesh, heightmap,
///     marlin or grid.
/// axis : {"X", "Y", "Z", "A", "B", "C"}, optional
///     Axis of the file, if the file does not name it.
/// comp_file_type : {0, 1}, optional
///     COMP_FILE_TYPE of a LinuxCNC file; by default, its numbers tell.
/// unit : {"mm", "um", "inch"}, optional
///     Unit of lengths, needed for linuxcnc and siemens, whose files do not state it, and for columns that do not.
/// columns : dict of str, optional
///     Names of the columns position, forward and reverse, for format="columns".
/// area_mm : sequence of float, optional
///     Lowest X and Y and highest X and Y of a mesh's points, mm, for format="marlin".
/// mesh : str, optional
///     Name of one of several meshes, for format="bed-mesh".
/// new : bool, default False
///     Whether an existing folder is refused.
///
/// Returns
/// -------
/// Transfer
///     The files written, and what was set; it prints what `trueaxis tables import` prints.
///
/// Raises
/// ------
/// trueaxis.Error
///     With file and line if the file is not of the format, or the controller would refuse the machine; nothing is written.
///
/// Notes
/// -----
/// Either all files are written or none.
#[pyfunction]
#[pyo3(signature = (file, folder, *, format, axis = None, comp_file_type = None, unit = None, columns = None, area_mm = None,
    mesh = None, new = false))]
pub(crate) fn import_table<'py>(
    py: Python<'py>,
    file: PathBuf,
    folder: PathBuf,
    format: &str,
    axis: Option<char>,
    comp_file_type: Option<u8>,
    unit: Option<&str>,
    columns: Option<BTreeMap<String, String>>,
    area_mm: Option<Vec<f64>>,
    mesh: Option<String>,
    new: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let of = in_arguments(transfer::format_to_read(format, checked(comp_file_type)?))?;
    let area = area_mm.map(|area| {
        let found = format!("{area:?}");
        Area::try_from(area).map_err(|_| {
            Error::new_err(format!("area_mm: found {found}, needed the lowest X and Y and the highest, mm"))
        })
    });
    let columns = columns.map(|names| {
        let parts: Vec<String> = names.iter().map(|(key, name)| format!("{key}={name}")).collect();
        parts.join(",")
    });
    let options = ImportOptions {
        format: of,
        recognise: format == "linuxcnc" && comp_file_type.is_none(),
        axis: axis.map(axis_of).transpose()?,
        unit: in_arguments(unit.map(|name| self::unit(name, of)).transpose())?,
        columns: columns.as_deref(),
        area: area.transpose()?,
        mesh: mesh.as_deref(),
        new,
    };
    let mut lines = Vec::new();
    let found = py.detach(|| transfer::import(&options, &file, &folder, &mut |line| lines.push(line)));
    transferred(py, &in_arguments(found)?, &lines)
}

/// Write a machine's tables in another control's format.
///
/// Parameters
/// ----------
/// machine : Machine
///     The machine.
/// file : path-like
///     File to write; if the format needs one for each axis, the letter of the axis goes before the extension.
/// format : str
///     The format: linuxcnc (linuxcnc-0, linuxcnc-1), siemens, isg or iso230-2.
/// axis : {"X", "Y", "Z", "A", "B", "C"}, optional
///     The only axis to write; by default, every axis with a table.
/// comp_file_type : {0, 1}, optional
///     COMP_FILE_TYPE of a LinuxCNC file; by default, 0.
/// drop : bool, default False
///     Whether settings that the format cannot store are left out and listed, instead of refused.
/// step : float, optional
///     Distance of the points onto which tables are resampled, mm or degrees, for format="siemens".
///
/// Returns
/// -------
/// Transfer
///     The files written, and what was left out; it prints what `trueaxis tables export` prints.
///
/// Raises
/// ------
/// trueaxis.Error
///     If the format cannot store the tables: all that would be lost.
#[pyfunction]
#[pyo3(signature = (machine, file, *, format, axis = None, comp_file_type = None, drop = false, step = None))]
pub(crate) fn export_table<'py>(
    py: Python<'py>,
    machine: &Bound<'py, Machine>,
    file: PathBuf,
    format: &str,
    axis: Option<char>,
    comp_file_type: Option<u8>,
    drop: bool,
    step: Option<f64>,
) -> PyResult<Bound<'py, PyAny>> {
    let own = machine.get();
    if own.stated.is_none() {
        return Err(Error::new_err("machine: found a compiled file, needed a machine.toml"));
    }
    let of = in_arguments(transfer::format_to_write(format, checked(comp_file_type)?))?;
    let loss = if drop { Loss::Drop } else { Loss::Refuse };
    let options = ExportOptions { loss, axis: axis.map(axis_of).transpose()?, step, source: own.path.clone() };
    let mut lines = Vec::new();
    let say = &mut |line| lines.push(line);
    let found = py.detach(|| transfer::export(of, &own.machine, files(&own.path), &options, &file, say));
    let document = in_arguments(found)?;
    transferred(py, &document, &lines)
}

/// Refuses a COMP_FILE_TYPE that LinuxCNC does not have.
fn checked(comp_file_type: Option<u8>) -> PyResult<Option<u8>> {
    match comp_file_type {
        Some(found) if found > 1 => Err(Error::new_err(format!("comp_file_type: found {found}, needed 0 or 1"))),
        of => Ok(of),
    }
}
