//! A machine: its errors and corrections.

use crate::{Error, arrays, told, warn};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use std::path::PathBuf;
use trueaxis::machine::{AXES, Axis, ErrorModel};
use trueaxis_evaluation::batch::{self, Settings};
use trueaxis_evaluation::model;
use trueaxis_tables::text::counted;

/// A machine with its tables, read and checked.
#[pyclass(frozen, module = "trueaxis")]
pub(crate) struct Machine(pub(crate) trueaxis_tables::Machine);

/// Checked arguments of a look-up.
pub(crate) struct Asked {
    machine: trueaxis_tables::Machine,
    settings: Settings,
    pub(crate) positions: Vec<[f64; AXES]>,
    /// Axis of every column.
    columns: Vec<Axis>,
}

#[pymethods]
impl Machine {
    /// Reads and checks a machine: a machine.toml, its folder, or a compiled .tcomp.
    ///
    /// Raises trueaxis.Error with file, line, what was found and what is needed.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Machine> {
        let mut notes = Vec::new();
        let machine = py.detach(|| model::machine(&path, &mut |note| notes.push(note)));
        for note in notes {
            warn(py, &note)?;
        }
        told(machine).map(Machine)
    }

    /// Name of the machine.
    #[getter]
    fn name(&self) -> &str {
        self.0.settings.name.as_str()
    }

    /// Structural code of the machine, from the workpiece to the tool.
    #[getter]
    fn chain(&self) -> String {
        self.0.settings.chain.to_string()
    }

    /// The machine's own error model, nine or volumetric.
    #[getter]
    fn model(&self) -> &'static str {
        model::name(self.0.settings.compensation.model)
    }

    /// Columns of positions: x_mm, y_mm, z_mm, then the machine's rotary axes in the order a_deg, b_deg, c_deg.
    #[getter]
    fn columns(&self) -> Vec<String> {
        let unit = |axis: Axis| if axis.is_rotary() { "deg" } else { "mm" };
        columns(&self.0).map(|axis| format!("{}_{}", axis.letter().to_ascii_lowercase(), unit(axis))).collect()
    }

    fn __repr__(&self) -> String {
        format!("<trueaxis.Machine {:?}, {}, {}>", self.name(), self.chain(), self.model())
    }

    /// Error of the tool tip at commanded positions, actual − ideal, µm: an array (n, 3).
    ///
    /// positions: (n, 3) or the machine's columns, mm and degrees; rotary axes left out stand at 0. Columns ex_um, ey_um,
    /// ez_um of `trueaxis compensate`. Beyond a table's end its edge value is clamped, with a warning.
    #[pyo3(signature = (positions, *, model = None, reverse = false, temperature_c = None))]
    fn error<'py>(
        &self,
        py: Python<'py>,
        positions: &Bound<'py, PyAny>,
        model: Option<&str>,
        reverse: bool,
        temperature_c: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let asked = self.asked(positions, model, reverse, temperature_c)?;
        let found = py.detach(|| {
            let mut errors = vec![[0.0; 3]; asked.positions.len()];
            let clamped = batch::errors(&asked.machine, &asked.settings, &asked.positions, &mut errors)?;
            let um = errors.as_flattened().iter().map(|mm| mm * 1e3).collect();
            Ok((um, clamped))
        });
        let (um, clamped) = told(found)?;
        asked.shaped(py, um, clamped, 3)
    }

    /// Corrections of commanded positions: an array of the shape of `positions`, mm and degrees, to be added to them.
    ///
    /// positions + correction is where the axes must be sent so that the tool stands at the position: columns cx_mm, cy_mm,
    /// cz_mm of `trueaxis compensate`. The arguments are those of `error`.
    #[pyo3(signature = (positions, *, model = None, reverse = false, temperature_c = None, inverse_passes = None))]
    fn correction<'py>(
        &self,
        py: Python<'py>,
        positions: &Bound<'py, PyAny>,
        model: Option<&str>,
        reverse: bool,
        temperature_c: Option<f64>,
        inverse_passes: Option<u8>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        if let Some(passes) = inverse_passes.filter(|passes| !(1..=8).contains(passes)) {
            return Err(Error::new_err(format!("inverse_passes: found {passes}, needed 1 to 8")));
        }
        let mut asked = self.asked(positions, model, reverse, temperature_c)?;
        asked.settings.passes = inverse_passes;
        let found = py.detach(|| {
            let mut corrections = vec![[0.0; AXES]; asked.positions.len()];
            let clamped = batch::corrections(&asked.machine, &asked.settings, &asked.positions, &mut corrections)?;
            let mut values = Vec::with_capacity(corrections.len() * asked.columns.len());
            for row in &corrections {
                values.extend(asked.columns.iter().map(|axis| row[axis.index()]));
            }
            Ok((values, clamped))
        });
        let (values, clamped) = told(found)?;
        asked.shaped(py, values, clamped, asked.columns.len())
    }
}

/// An error model by its name.
pub(crate) fn model_of(name: Option<&str>) -> PyResult<Option<ErrorModel>> {
    match name {
        None => Ok(None),
        Some("nine") => Ok(Some(ErrorModel::Nine)),
        Some("volumetric") => Ok(Some(ErrorModel::Volumetric)),
        Some(found) => Err(Error::new_err(format!("model: found {found:?}, needed \"nine\" or \"volumetric\""))),
    }
}

/// X, Y, Z and the machine's rotary axes.
pub(crate) fn columns(machine: &trueaxis_tables::Machine) -> impl Iterator<Item = Axis> {
    Axis::ALL.into_iter().filter(|axis| !axis.is_rotary() || machine.settings.axis(*axis).is_some())
}

impl Machine {
    /// Positions of a call, checked against the declared travel.
    pub(crate) fn asked(
        &self,
        positions: &Bound<'_, PyAny>,
        model: Option<&str>,
        reverse: bool,
        temperature_c: Option<f64>,
    ) -> PyResult<Asked> {
        let mut machine = self.0.clone();
        // As `trueaxis compensate` without --orientation.
        machine.settings.compensation.orientation = false;
        if let Some(model) = model_of(model)? {
            machine.settings.compensation.model = model;
        }
        let kelvin = temperature_c.map_or(0.0, |celsius| celsius - machine.settings.reference_temperature_c);
        let mut columns: Vec<Axis> = columns(&machine).collect();
        let widths = if columns.len() == 3 { vec![3] } else { vec![3, columns.len()] };
        let (width, values) = arrays::rows(positions, "positions", &widths)?;
        columns.truncate(width);
        let travel = |axis: Axis| machine.settings.axis(axis).map(|own| own.travel);
        let travels: Vec<_> = columns.iter().map(|axis| (axis.index(), travel(*axis))).collect();
        let mut all = vec![[0.0; AXES]; values.len() / width];
        for (row, (position, values)) in all.iter_mut().zip(values.chunks_exact(width)).enumerate() {
            for (column, ((index, travel), value)) in travels.iter().zip(values).enumerate() {
                position[*index] = *value;
                if let Some([low, high]) = travel.filter(|[low, high]| value < low || value > high) {
                    return Err(Error::new_err(format!(
                        "positions[{row}, {column}]: found {value}, needed the declared travel, {low} to {high}"
                    )));
                }
            }
        }
        Ok(Asked { machine, settings: Settings { passes: None, reverse, kelvin }, positions: all, columns })
    }
}

impl Asked {
    fn shaped<'py>(
        &self,
        py: Python<'py>,
        values: Vec<f64>,
        clamped: usize,
        width: usize,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let count = self.positions.len();
        if clamped > 0 {
            let all = counted(count, "position");
            warn(py, &format!("{clamped} of {all} beyond a table's end, where its edge value is clamped"))?;
        }
        PyArray1::from_vec(py, values).reshape([count, width])
    }
}
