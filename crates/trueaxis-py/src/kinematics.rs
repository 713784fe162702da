//! Five-axis transformation and helicoids.

use crate::machine::{Machine, columns};
use crate::{Error, arrays, json, to_python, units};
use anyhow::Context;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use trueaxis::glam::DVec3;
use trueaxis::kinematics::{Choice, Kinematics, Tool};
use trueaxis::machine::Axis;
use trueaxis_evaluation::helicoid as flank;
use trueaxis_evaluation::inverse::Walk;

/// Tips (n, 3), tool axes (n, 3) and margins (n,).
type Tools<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>);
/// Positions (n, columns), branches (n,), margins (n,) and direction errors (n,).
type Poses<'py> =
    (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<u8>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

fn table<'py>(py: Python<'py>, values: Vec<f64>, width: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows = values.len() / width;
    PyArray1::from_vec(py, values).reshape([rows, width])
}

#[pymethods]
impl Machine {
    /// Compute where the tool is in the workpiece from positions of the axes.
    ///
    /// Parameters
    /// ----------
    /// positions : array-like or data frame
    ///     Axis positions, (n, 3), or with the columns that `columns` lists, mm and degrees; omitted rotary axes are at 0.
    /// tool_mm : sequence of float, optional
    ///     Vector from the last tool-side frame to the tip with all axes at zero; by default, the machine's.
    ///
    /// Returns
    /// -------
    /// tip : numpy.ndarray
    ///     Tip of the tool in the workpiece, mm, (n, 3).
    /// tool : numpy.ndarray
    ///     Direction of the tool, a unit vector from the tip to the spindle, (n, 3).
    /// margin : numpy.ndarray
    ///     Angle to the nearest singular pose, degrees, (n,).
    ///
    /// Raises
    /// ------
    /// trueaxis.Error
    ///     If an argument or a record is refused: what was found, and what is needed.
    ///
    /// Notes
    /// -----
    /// These are the columns of `trueaxis kinematics forward`.
    #[pyo3(signature = (positions, *, tool_mm = None))]
    fn forward<'py>(
        &self,
        py: Python<'py>,
        positions: &Bound<'py, PyAny>,
        tool_mm: Option<[f64; 3]>,
    ) -> PyResult<Tools<'py>> {
        let asked = self.asked(positions, None, false, false, None)?;
        let kinematics = self.kinematics(tool_mm)?;
        let positions = asked.positions();
        let (tips, tools, margins) = py.detach(|| {
            let (mut tips, mut tools, mut margins) = (Vec::new(), Vec::new(), Vec::new());
            for axes in (0..positions.count()).map(|row| positions.at(row)) {
                let Tool { tip, axis } = kinematics.forward(&axes);
                tips.extend(tip.to_array());
                tools.extend(axis.to_array());
                margins.push(kinematics.singularity_margin_deg(&axes));
            }
            (tips, tools, margins)
        });
        Ok((table(py, tips, 3)?, table(py, tools, 3)?, PyArray1::from_vec(py, margins)))
    }

    /// Compute axis positions from tips and directions of the tool.
    ///
    /// Parameters
    /// ----------
    /// tip : array-like
    ///     Tips of the tool in the workpiece, mm, (n, 3).
    /// tool : array-like
    ///     Directions of the tool, from the tip to the spindle, (n, 3).
    /// branch : {"nearest", "1", "2"}, default "nearest"
    ///     Solution of the rotary axes: the first, the second, or the one nearest to the row before, and to `start` for the
    ///     first row.
    /// start : sequence of float, optional
    ///     Angles of the rotary axes before the first row, degrees, in the order A, B, C; with branch="nearest".
    /// max_step_deg : float, optional
    ///     Largest step in degrees: refuses a larger one of a rotary axis from row to row, and any change of branch other than through the
    ///     singular pose.
    /// tool_mm : sequence of float, optional
    ///     Offset of the tool in mm; by default, that of the machine.
    ///
    /// Returns
    /// -------
    /// positions : numpy.ndarray
    ///     Positions of the axes with the columns that `columns` lists, mm and degrees.
    /// branch : numpy.ndarray
    ///     Branch of every row, 1 or 2.
    /// margin : numpy.ndarray
    ///     Angle to the nearest singular pose, degrees.
    /// left : numpy.ndarray
    ///     Angle between the direction asked for and the one reached, degrees.
    ///
    /// Raises
    /// ------
    /// trueaxis.Error
    ///     If an argument or a record is refused: what was found, and what is needed.
    ///
    /// Notes
    /// -----
    /// These are the columns of `trueaxis kinematics inverse`. The direction error is 0 outside the machine's singular
    /// cone.
    #[pyo3(signature = (tip, tool, *, branch = "nearest", start = None, max_step_deg = None, tool_mm = None))]
    fn inverse<'py>(
        &self,
        py: Python<'py>,
        tip: &Bound<'py, PyAny>,
        tool: &Bound<'py, PyAny>,
        branch: &str,
        start: Option<Vec<f64>>,
        max_step_deg: Option<f64>,
        tool_mm: Option<[f64; 3]>,
    ) -> PyResult<Poses<'py>> {
        let (_, tips) = arrays::rows(&units::in_unit(tip, "tip", "mm")?, "tip", &[3])?;
        let (_, tools) = arrays::rows(tool, "tool", &[3])?;
        if tips.len() != tools.len() {
            let (found, needed) = (tools.len() / 3, tips.len() / 3);
            return Err(Error::new_err(format!("tool: found {found} rows, needed {needed}, as tip has")));
        }
        let choice = match branch {
            "nearest" => Choice::Nearest,
            "1" => Choice::First,
            "2" => Choice::Second,
            found => {
                return Err(Error::new_err(format!("branch: found {found:?}, needed \"nearest\", \"1\" or \"2\"")));
            }
        };
        let kinematics = self.kinematics(tool_mm)?;
        let columns: Vec<Axis> = columns(&self.machine).collect();
        let mut walk = to_python(Walk::new(choice, max_step_deg).context("max_step_deg"))?;
        if let Some(start) = start {
            walk = to_python(walk.from_angles(&kinematics, &start).context("start"))?;
        }
        let found = py.detach(|| {
            let tools = tips.as_chunks::<3>().0.iter().zip(tools.as_chunks::<3>().0).enumerate();
            tools
                .map(|(row, (tip, axis))| {
                    let tool = Tool { tip: DVec3::from_array(*tip), axis: DVec3::from_array(*axis) };
                    Ok(walk.next(&kinematics, &tool).with_context(|| format!("row {row}"))?.chosen)
                })
                .collect::<anyhow::Result<Vec<_>>>()
        });
        let found = to_python(found)?;
        let positions = found.iter().flat_map(|of| columns.iter().map(|axis| of.axes[axis.index()])).collect();
        let branches = found.iter().map(|of| of.branch as u8);
        let margins = found.iter().map(|of| of.singularity_margin_deg);
        let left = found.iter().map(|of| of.direction_error_deg);
        let (branches, margins) = (PyArray1::from_iter(py, branches), PyArray1::from_iter(py, margins));
        Ok((table(py, positions, columns.len())?, branches, margins, PyArray1::from_iter(py, left)))
    }
}

impl Machine {
    fn kinematics(&self, tool_mm: Option<[f64; 3]>) -> PyResult<Kinematics<f64>> {
        let kinematics =
            to_python(Kinematics::<f64>::new(&self.machine.settings).map_err(|error| anyhow::anyhow!("{error}")))?;
        let Some(tool) = tool_mm else { return Ok(kinematics) };
        if let Some(value) = tool.iter().find(|value| value.is_nan() || value.abs() > 1e6) {
            return Err(Error::new_err(format!("tool_mm: found {value}, needed a finite number of at most 1e6 mm")));
        }
        Ok(kinematics.with_tool(DVec3::from(tool)))
    }
}

/// Compute the displacements of five axes that keep a tool normal to the flank of a helical gear.
///
/// Parameters
/// ----------
/// gcode : bool, default False
///     Whether the result has the program under `program`.
/// **request : Any
///     Options of `trueaxis helicoid` with underscores; ranges are texts START:STOP:COUNT.
///
/// Returns
/// -------
/// Helicoid
///     The document of `trueaxis helicoid --json`, and with gcode=True the program under `program`.
///
/// Raises
/// ------
/// trueaxis.Error
///     If an argument or a record is refused: what was found, and what is needed.
///
/// Notes
/// -----
/// For example,
/// helicoid(module_mm=4.0, teeth=20, pressure_angle_deg=20.0, helix_angle_deg=15.0, u_rad="0.2:0.6:9",
/// theta_rad="0:0.3:7", form="vertical", pivot_mm=150.0).
#[pyfunction]
#[pyo3(signature = (*, gcode = false, **request))]
pub(crate) fn helicoid<'py>(
    py: Python<'py>,
    gcode: bool,
    request: Option<Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let request = request.unwrap_or_else(|| PyDict::new(py));
    let text: String = py.import("json")?.call_method1("dumps", (request,))?.extract()?;
    let (document, program, notes) = to_python(py.detach(|| {
        let request: flank::Request = serde_json::from_str(&text).map_err(|error| {
            // The error's line and column refer to a text that the caller has never seen.
            let said = error.to_string();
            anyhow::anyhow!("{}", said.split(" at line ").next().unwrap_or_default())
        })?;
        let job = flank::Job::new(&request)?;
        let document = flank::HelicoidDocument::new(&job, job.points()?);
        let program = if gcode { Some(job.program()?) } else { None };
        let notes: Vec<String> = job.notes();
        Ok((document, program, notes))
    }))?;
    notes.iter().try_for_each(|note| crate::warn(py, note))?;
    let found = json::dictionary(py, &document)?;
    if let Some(program) = program {
        found.set_item("program", program)?;
    }
    crate::shown::result("Helicoid", found, Some(document.shown()))
}
