//! A machine: its errors and corrections.

use crate::arrays::Numbers;
use crate::measured::Measured;
use crate::shown::result;
use crate::{Error, arrays, json, to_python, units, warn};
use numpy::{PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::PathBuf;
use std::sync::Arc;
use trueaxis::machine::{Axis, ErrorModel};
use trueaxis_evaluation::batch::{self, Positions};
use trueaxis_evaluation::compensate::{Arrival, Settings};
use trueaxis_evaluation::correct::position;
use trueaxis_evaluation::uncertainty::{Options, evaluate};
use trueaxis_evaluation::{check, model};
use trueaxis_metrology::cores::*;
use trueaxis_tables::Additions;
use trueaxis_tables::files::{Folder, Memory, Source};
use trueaxis_tables::finding::Decision;
use trueaxis_tables::text::counted;
use trueaxis_tables::uncertainty::Uncertainties;

/// A machine with its tables, read and checked.
#[pyclass(frozen, module = "trueaxis")]
pub(crate) struct Machine {
    pub(crate) machine: trueaxis_tables::Machine,
    pub(crate) stated: Stated,
    /// Where it was read.
    pub(crate) path: PathBuf,
    /// Its description, or the compiled file, among `files`.
    pub(crate) name: PathBuf,
    /// What it was read from, by names relative to its folder, and with what `with_table` and `with_setting` changed.
    pub(crate) files: Files,
    /// The files as they were read.
    pub(crate) read: Arc<Files>,
}

pub(crate) type Files = BTreeMap<PathBuf, Vec<u8>>;

/// Standard uncertainties that the machine's files state; `None` for a compiled file, which states none.
type Stated = Option<Uncertainties>;

/// Checked arguments of a look-up.
pub(crate) struct Asked<'py> {
    machine: trueaxis_tables::Machine,
    settings: Settings,
    arrival: Arrival,
    values: Numbers<'py>,
    /// The axis of each column.
    columns: Vec<Axis>,
}

#[pymethods]
impl Machine {
    /// Reads and checks a machine: a machine.toml, its folder, or a compiled .tcomp.
    ///
    /// Parameters
    /// ----------
    /// path : path-like
    ///     A machine.toml, its folder, or a compiled .tcomp.
    ///
    /// Returns
    /// -------
    /// Machine
    ///     The machine, read and checked.
    ///
    /// Raises
    /// ------
    /// trueaxis.Error
    ///     With file, line, the value found and the value needed.
    ///
    /// Examples
    /// --------
    /// >>> mill = trueaxis.Machine.load("compensation-tables/mill-3axis")
    /// >>> mill.columns
    /// ['x_mm', 'y_mm', 'z_mm']
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Machine> {
        let mut notes = Vec::new();
        let machine = py.detach(|| {
            let machine = model::machine(&path, &mut |note| notes.push(note))?;
            let (folder, name) = Folder::of_machine(&path);
            let compiled = model::is_compiled(&path);
            let stated = if compiled { None } else { Some(Uncertainties::read_from(&folder, &name)?) };
            let own = || Ok(vec![name.clone()]);
            let names = if compiled { own() } else { trueaxis_tables::Machine::files_of(&folder, &name) }?;
            let files = names.into_iter().map(|name| Ok((name.clone(), model::bytes(&folder.path(&name))?)));
            let files = files.collect::<anyhow::Result<Files>>()?;
            Ok(Machine { machine, stated, path: path.clone(), read: Arc::new(files.clone()), files, name })
        });
        for note in notes {
            warn(py, &note)?;
        }
        to_python(machine)
    }

    /// Name of the machine.
    #[getter]
    fn name(&self) -> &str {
        self.machine.settings.name.as_str()
    }

    /// Structural code of the machine, from the workpiece to the tool.
    #[getter]
    fn chain(&self) -> String {
        self.machine.settings.chain.to_string()
    }

    /// Error model that the machine states: nine or volumetric.
    #[getter]
    fn model(&self) -> &'static str {
        model::name(self.machine.settings.compensation.model)
    }

    /// Columns of positions: x_mm, y_mm, z_mm, then the machine's rotary axes in the order a_deg, b_deg, c_deg.
    #[getter]
    fn columns(&self) -> Vec<String> {
        let unit = |axis: Axis| if axis.is_rotary() { "deg" } else { "mm" };
        columns(&self.machine).map(|axis| format!("{}_{}", axis.letter().to_ascii_lowercase(), unit(axis))).collect()
    }

    /// Compile the machine for a controller.
    ///
    /// Parameters
    /// ----------
    /// rate_hz : float, default 10000.0
    ///     Servo rate of the controller, 10 Hz to 1 MHz, at which its build has to accept the machine.
    ///
    /// Returns
    /// -------
    /// bytes
    ///     The .tcomp file that `trueaxis tables compile` writes.
    ///
    /// Raises
    /// ------
    /// trueaxis.Error
    ///     If a controller refuses the machine: with its file, the value found and the value needed.
    ///
    /// Notes
    /// -----
    /// Remarks of `trueaxis tables check` become warnings.
    #[pyo3(signature = (*, rate_hz = 10_000.0))]
    fn compile<'py>(&self, py: Python<'py>, rate_hz: f64) -> PyResult<Bound<'py, PyBytes>> {
        if !(10.0..=1e6).contains(&rate_hz) {
            return Err(Error::new_err(format!("rate_hz: found {rate_hz}, needed 10 to 1000000")));
        }
        if self.stated.is_none() {
            return Err(Error::new_err("machine: found a compiled file, needed a machine.toml"));
        }
        let files = Memory::new(self.files.iter().map(|(name, bytes)| (name, bytes.as_slice())));
        let bytes = to_python(py.detach(|| check::compiled(&self.machine, &files, &self.name, rate_hz)))?;
        for warning in trueaxis_tables::check(&self.machine, rate_hz) {
            warn(py, &warning.to_string())?;
        }
        Ok(PyBytes::new(py, &bytes))
    }

    /// Two machines are equal if their settings, tables and uncertainties are.
    fn __eq__(&self, other: &Machine) -> bool {
        self.machine == other.machine && self.stated == other.stated
    }

    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        (self.name(), self.chain()).hash(&mut hasher);
        hasher.finish()
    }

    /// Pickled are the files, so that a worker needs no folder.
    fn __reduce__<'py>(slf: &Bound<'py, Machine>) -> PyResult<(Bound<'py, PyAny>, Restored<'py>)> {
        let (py, own) = (slf.py(), slf.get());
        let pickled = |of: &Files| {
            let files = PyDict::new(py);
            for (name, bytes) in of {
                files.set_item(name, PyBytes::new(py, bytes))?;
            }
            Ok::<_, PyErr>(files)
        };
        let restore = py.import("trueaxis._native")?.getattr("_restored_machine")?;
        Ok((restore, (own.path.clone(), own.name.clone(), pickled(&own.files)?, pickled(&own.read)?)))
    }

    fn __repr__(&self) -> String {
        format!("<trueaxis.Machine {:?}, {}, {}>", self.name(), self.chain(), self.model())
    }

    /// Compute the error of the tool tip at commanded positions: actual − ideal.
    ///
    /// Parameters
    /// ----------
    /// positions : array-like or data frame
    ///     Positions (n, 3), or with the columns that `columns` lists, mm and degrees; omitted rotary axes are at 0.
    /// model : {"nine", "volumetric", "exact"}, optional
    ///     Error model; by default, that of the machine. "exact" uses transforms.
    /// reverse : bool, default False
    ///     Whether all axes travel in the negative direction.
    /// in_order : bool, default False
    ///     Whether the direction of each axis follows from the row before.
    /// temperature_c : float, optional
    ///     Temperature of the machine for its thermal growth, °C; by default, its reference temperature.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray
    ///     Errors along X, Y, Z, µm, (n, 3): the columns ex_um, ey_um, ez_um of `trueaxis compensate`.
    ///
    /// Raises
    /// ------
    /// trueaxis.Error
    ///     If an argument or a record is refused: what was found, and what is needed.
    ///
    /// Notes
    /// -----
    /// Beyond a table's end, it uses the table's edge value and warns.
    ///
    /// Examples
    /// --------
    /// >>> mill = trueaxis.Machine.load("compensation-tables/mill-3axis")
    /// >>> mill.error([[20.5, 10, -200]]).round(3)
    /// array([[-0.857, 10.272,  6.618]])
    #[pyo3(signature = (positions, *, model = None, reverse = false, in_order = false, temperature_c = None))]
    fn error<'py>(
        &self,
        py: Python<'py>,
        positions: &Bound<'py, PyAny>,
        model: Option<&str>,
        reverse: bool,
        in_order: bool,
        temperature_c: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.asked(positions, model, reverse, in_order, temperature_c)?
            .errors(py, |[x, y, z], _| [1e3 * x, 1e3 * y, 1e3 * z])
    }

    /// Compute the error of the tool's direction at commanded positions: a small rotation, actual − ideal.
    ///
    /// Parameters
    /// ----------
    /// positions : array-like or data frame
    ///     Positions (n, 3), or with the columns that `columns` lists, mm and degrees; omitted rotary axes are at 0.
    /// model : {"volumetric", "exact"}, optional
    ///     Error model; by default, that of the machine. The nine-term model has no orientation.
    /// reverse : bool, default False
    ///     Whether all axes travel in the negative direction.
    /// in_order : bool, default False
    ///     Whether the direction of each axis follows from the row before.
    /// temperature_c : float, optional
    ///     Temperature of the machine for its thermal growth, °C; by default, its reference temperature.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray
    ///     Rotations about X, Y, Z, µrad, (n, 3): ea_urad, eb_urad, ec_urad of `trueaxis compensate --orientation`.
    ///
    /// Raises
    /// ------
    /// trueaxis.Error
    ///     If an argument or a record is refused: what was found, and what is needed.

    #[pyo3(signature = (positions, *, model = None, reverse = false, in_order = false, temperature_c = None))]
    fn orientation_error<'py>(
        &self,
        py: Python<'py>,
        positions: &Bound<'py, PyAny>,
        model: Option<&str>,
        reverse: bool,
        in_order: bool,
        temperature_c: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let asked = self.asked(positions, model, reverse, in_order, temperature_c)?.with_orientation()?;
        asked.errors(py, |_, [a, b, c]| [1e6 * a, 1e6 * b, 1e6 * c])
    }

    /// Compute the corrections of commanded positions.
    ///
    /// Parameters
    /// ----------
    /// positions : array-like or data frame
    ///     Positions (n, 3), or with the columns that `columns` lists, mm and degrees; omitted rotary axes are at 0.
    /// model : {"nine", "volumetric", "exact"}, optional
    ///     Error model; by default, that of the machine. "exact" uses transforms.
    /// reverse : bool, default False
    ///     Whether all axes travel in the negative direction.
    /// in_order : bool, default False
    ///     Whether the direction of each axis follows from the row before.
    /// temperature_c : float, optional
    ///     Temperature of the machine for its thermal growth, °C; by default, its reference temperature.
    /// inverse_passes : int, optional
    ///     Passes of the exact inverse, 1 to 8; by default, as many as 1e-3 µm needs, and until it converges with
    ///     "exact".
    /// orientation : bool, default False
    ///     The rotary axes also correct the tool's direction; positions + correction then also equals ca_deg,
    ///     cb_deg, cc_deg of `--orientation`.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray
    ///     What has to be added to the positions, mm and degrees, in their shape.
    ///
    /// Raises
    /// ------
    /// trueaxis.Error
    ///     If an argument or a record is refused: what was found, and what is needed.
    ///
    /// Notes
    /// -----
    /// positions + correction brings the tool to the positions and equals the columns cx_mm, cy_mm, cz_mm of `trueaxis
    /// compensate`.
    ///
    /// Examples
    /// --------
    /// >>> mill = trueaxis.Machine.load("compensation-tables/mill-3axis")
    /// >>> mill.correction([[20.5, 10, -200]]).round(6)
    /// array([[ 0.0009, -0.0103, -0.0066]])
    #[pyo3(signature = (positions, *, model = None, reverse = false, in_order = false, temperature_c = None,
        inverse_passes = None, orientation = false))]
    fn correction<'py>(
        &self,
        py: Python<'py>,
        positions: &Bound<'py, PyAny>,
        model: Option<&str>,
        reverse: bool,
        in_order: bool,
        temperature_c: Option<f64>,
        inverse_passes: Option<u8>,
        orientation: bool,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        if let Some(passes) = inverse_passes.filter(|passes| !(1..=8).contains(passes)) {
            return Err(Error::new_err(format!("inverse_passes: found {passes}, needed 1 to 8")));
        }
        let mut asked = self.asked(positions, model, reverse, in_order, temperature_c)?;
        if orientation {
            asked = asked.with_orientation()?;
        }
        asked.settings.passes = inverse_passes;
        asked.corrections(py)
    }

    /// Compute the uncertainty of the corrected position.
    ///
    /// Parameters
    /// ----------
    /// at : sequence of float, optional
    ///     An additional position to evaluate: X, Y, Z in mm, then the rotary axes in degrees.
    /// volume_mm : Sequence[sequence of float], optional
    ///     [low, high] of X, Y, Z; None means the travel.
    /// pose_deg : Mapping[str, float], optional
    ///     Angles of the rotary axes throughout the volume, such as {"A": 30}.
    /// points : int, default 9
    ///     Number of points along each linear axis, 2 to 51.
    /// confidence : float, default 95.0
    ///     50 to 99.99 %.
    /// trials : int, default 10000
    ///     Number of random machines.
    /// seed : int, default 1
    ///     The same seed gives the same machines.
    ///
    /// Returns
    /// -------
    /// Uncertainty
    ///     The document of `trueaxis uncertainty --json`.
    ///
    /// Raises
    /// ------
    /// trueaxis.Error
    ///     If the machine's files state no uncertainty, or an argument is out of its range.
    ///
    /// Notes
    /// -----
    /// The covariance is Σ = Σ_k s_k s_kᵀ, where s_k is the displacement of the tip by one standard uncertainty of
    /// figure k; random machines verify it. The document contains, in µm along X, Y, Z of the machine, standard_um,
    /// expanded_um = factor · standard_um, and radius_um of the sphere that contains the tip.
    #[pyo3(signature = (*, at = None, volume_mm = None, pose_deg = None, points = 9, confidence = 95.0, trials = 10_000,
        seed = 1))]
    fn uncertainty<'py>(
        &self,
        py: Python<'py>,
        at: Option<Vec<f64>>,
        volume_mm: Option<[Option<[f64; 2]>; 3]>,
        pose_deg: Option<BTreeMap<String, f64>>,
        points: usize,
        confidence: f64,
        trials: usize,
        seed: u64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let Machine { machine, stated: Some(stated), .. } = self else {
            return Err(Error::new_err(
                "machine: found a compiled file, which states no uncertainty, needed a machine.toml",
            ));
        };
        let at = at.map(|at| position(&at, machine)).transpose();
        let at = at.map_err(|wrong| Error::new_err(format!("at: {wrong}")))?;
        let pose = pose_deg.unwrap_or_default().into_iter().map(|(letter, degrees)| {
            let axis = Axis::ALL.into_iter().find(|axis| letter == axis.letter().to_string());
            let axis = axis.ok_or_else(|| format!("pose_deg: found {letter:?}, needed a rotary axis of the machine"));
            axis.and_then(|axis| match degrees.is_finite() {
                true => Ok((axis, degrees)),
                false => Err(format!("pose_deg: found {degrees}, needed a finite number")),
            })
        });
        let pose_deg = pose.collect::<Result<_, String>>().map_err(Error::new_err)?;
        let volume_mm = volume_mm.unwrap_or_default();
        if let Some(found) = volume_mm.iter().flatten().flatten().find(|mm| !mm.is_finite()) {
            return Err(Error::new_err(format!("volume_mm: found {found}, needed a finite number")));
        }
        let options = Options { at, volume_mm, pose_deg, points, coverage: confidence / 100.0, trials, seed };
        let document = to_python(py.detach(|| evaluate(machine, stated, &options)))?;
        result("Uncertainty", json::dictionary(py, &document)?, Some(document.shown()))
    }
}

/// Arguments of [`restored_machine`].
type Restored<'py> = (PathBuf, PathBuf, Bound<'py, PyDict>, Bound<'py, PyDict>);

/// A machine from its pickled files.
#[pyfunction(name = "_restored_machine")]
pub(crate) fn restored_machine(path: PathBuf, name: PathBuf, files: Files, read: Files) -> PyResult<Machine> {
    to_python(machine_of(path, name, files, Arc::new(read)))
}

/// A machine from its files in memory.
pub(crate) fn machine_of(path: PathBuf, name: PathBuf, files: Files, read: Arc<Files>) -> anyhow::Result<Machine> {
    let parsed = || {
        let memory = Memory::new(files.iter().map(|(name, bytes)| (name, bytes.as_slice())));
        if !model::is_compiled(&path) {
            let machine = trueaxis_tables::Machine::read_from(&memory, &name, &mut |_| {})?;
            return Ok::<_, anyhow::Error>((machine, Some(Uncertainties::read_from(&memory, &name)?)));
        }
        let bytes = memory.read(&name)?;
        Ok((trueaxis_tables::Machine::from_tcomp(&model::parsed(&bytes, &path)?), None))
    };
    let (machine, stated) = parsed()?;
    Ok(Machine { machine, stated, path, name, files, read })
}

/// Returns the axis of a letter.
pub(crate) fn axis_of(letter: char) -> PyResult<Axis> {
    let known = Axis::ALL.into_iter().find(|axis| axis.letter() == letter);
    known.ok_or_else(|| Error::new_err(format!("axis: found {letter:?}, needed X, Y, Z, A, B or C")))
}

/// Returns the error model of this name.
pub(crate) fn model_of(name: Option<&str>) -> PyResult<Option<ErrorModel>> {
    match name {
        None => Ok(None),
        Some("nine") => Ok(Some(ErrorModel::Nine)),
        Some("volumetric") => Ok(Some(ErrorModel::Volumetric)),
        Some(found) => Err(Error::new_err(format!("model: found {found:?}, needed \"nine\" or \"volumetric\""))),
    }
}

/// Whether all rows of `N` columns lie within the ends of their columns; without a branch a number.
fn are_within<const N: usize>(rows: &[f64], ends: &[[f64; 2]]) -> bool {
    let Some(ends) = ends.first_chunk::<N>() else { return false };
    let mut all = true;
    for row in rows.as_chunks::<N>().0 {
        for k in 0..N {
            all &= (row[k] >= ends[k][0]) & (row[k] <= ends[k][1]);
        }
    }
    all
}

/// X, Y, Z and the machine's rotary axes.
pub(crate) fn columns(machine: &trueaxis_tables::Machine) -> impl Iterator<Item = Axis> {
    Axis::ALL.into_iter().filter(|axis| !axis.is_rotary() || machine.settings.axis(*axis).is_some())
}

/// Decides on a record's findings by the commands' rule, for the machine's current files; writes nothing. Returns `None`
/// without a machine, for a compiled one, which states nothing, and if the machine cannot accept the findings; then a note
/// gives the reason.
pub(crate) fn decided(
    machine: Option<&Machine>,
    record: &Measured,
    additions: impl FnOnce() -> anyhow::Result<Additions>,
    notes: &mut Vec<String>,
) -> Option<Vec<Decision>> {
    let machine = machine.filter(|machine| machine.stated.is_some())?;
    let (folder, name) = Folder::of_machine(&machine.path);
    let decide = || -> anyhow::Result<_> {
        let additions = additions()?.of_record(&record.bytes()?);
        additions.edit(&folder, &name)?;
        Ok(additions.decide(&folder, &name)?)
    };
    let note = |error| format!("{}: nothing is decided about the machine: {error:#}", record.name().display());
    decide().map_err(|error| notes.push(note(error))).ok()
}

impl Machine {
    /// Checks the positions of a call against the declared travel.
    pub(crate) fn asked<'py>(
        &self,
        positions: &Bound<'py, PyAny>,
        model: Option<&str>,
        reverse: bool,
        in_order: bool,
        temperature_c: Option<f64>,
    ) -> PyResult<Asked<'py>> {
        let mut machine = self.machine.clone();
        // `trueaxis compensate` without `--orientation` does the same.
        machine.settings.compensation.orientation = false;
        let exact = model == Some("exact");
        if let Some(model) = model.filter(|_| !exact) {
            let own = model_of(Some(model)).map_err(|_| {
                Error::new_err(format!("model: found {model:?}, needed \"nine\", \"volumetric\" or \"exact\""))
            })?;
            machine.settings.compensation.model = own.unwrap_or(machine.settings.compensation.model);
        }
        let arrival = match (reverse, in_order) {
            (true, true) => return Err(Error::new_err("reverse: found in_order too, needed one of both")),
            (true, false) => Arrival::Negative,
            (false, true) => Arrival::in_order(&machine),
            (false, false) => Arrival::Positive,
        };
        let kelvin = temperature_c.map_or(0.0, |celsius| celsius - machine.settings.reference_temperature_c);
        let mut columns: Vec<Axis> = columns(&machine).collect();
        let names = self.columns();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let forms: &[&[&str]] = if names.len() == 3 { &[&names] } else { &[&names[..3], &names] };
        let (width, values) = arrays::lent(&units::framed(positions, "positions", forms)?, "positions", forms)?;
        columns.truncate(width);
        let travel = |axis: Axis| machine.settings.axis(axis).map(|own| own.travel);
        let travels: Vec<_> = columns.iter().map(|axis| travel(*axis)).collect();
        let ends: Vec<[f64; 2]> = travels.iter().map(|own| own.unwrap_or([f64::MIN, f64::MAX])).collect();
        let rows = values.as_slice();
        // As in the check of the numbers: only a refusal looks for the place.
        let of_chunk = |rows: &[f64]| match width {
            3 => are_within::<3>(rows, &ends),
            4 => are_within::<4>(rows, &ends),
            5 => are_within::<5>(rows, &ends),
            _ => are_within::<6>(rows, &ends),
        };
        let refused = !rows.par_chunks(arrays::CHUNK / width * width).all(of_chunk);
        for (row, values) in rows.chunks_exact(width).enumerate().filter(|_| refused) {
            for (column, (travel, value)) in travels.iter().zip(values).enumerate() {
                if let Some([low, high]) = travel.filter(|[low, high]| value < low || value > high) {
                    return Err(Error::new_err(format!(
                        "positions[{row}, {column}]: found {value}, needed the declared travel, {low} to {high}"
                    )));
                }
            }
        }
        let settings = Settings { exact, passes: None, kelvin };
        Ok(Asked { machine, settings, arrival, values, columns })
    }
}

impl Asked<'_> {
    /// Also corrects the tool's orientation.
    fn with_orientation(mut self) -> PyResult<Self> {
        if !self.settings.exact && self.machine.settings.compensation.model == ErrorModel::Nine {
            return Err(Error::new_err(
                "model: found nine, which has no orientation, needed \"volumetric\" or \"exact\"",
            ));
        }
        self.machine.settings.compensation.orientation = true;
        Ok(self)
    }

    pub(crate) fn positions(&self) -> Positions<'_> {
        Positions { values: self.values.as_slice(), columns: &self.columns }
    }

    /// Evaluates what `of` makes of the errors of tip and orientation.
    fn errors<'py>(
        self,
        py: Python<'py>,
        of: impl Fn([f64; 3], [f64; 3]) -> [f64; 3] + Sync + Send,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let Asked { machine, settings, .. } = &self;
        let (arrival, positions) = (self.arrival.clone(), self.positions());
        written(py, positions.count(), 3, |errors| {
            batch::errors(machine, settings, arrival, positions, of, errors.as_chunks_mut().0)
        })
    }

    fn corrections<'py>(self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let Asked { machine, settings, .. } = &self;
        let (arrival, positions) = (self.arrival.clone(), self.positions());
        written(py, positions.count(), self.columns.len(), |corrections| {
            batch::corrections(machine, settings, arrival, positions, corrections)
        })
    }
}

/// An array of `count` rows that `write` fills without the interpreter's lock, in the array's own memory; `write` returns the
/// number of positions beyond a table's end.
fn written<'py>(
    py: Python<'py>,
    count: usize,
    width: usize,
    write: impl FnOnce(&mut [f64]) -> anyhow::Result<usize> + Send,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let array = PyArray2::<f64>::zeros(py, [count, width], false);
    let mut results = array.try_readwrite()?;
    let values = results.as_slice_mut()?;
    let clamped = to_python(py.detach(|| write(values)))?;
    drop(results);
    if clamped > 0 {
        let all = counted(count, "position");
        warn(py, &format!("{clamped} of {all} beyond a table's end, where its edge value is used"))?;
    }
    Ok(array)
}
