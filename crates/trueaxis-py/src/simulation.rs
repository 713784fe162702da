//! Simulation of a part program on a machine.

use crate::machine::Machine;
use crate::shown::table_result;
use crate::{Error, json, to_python, warn};
use anyhow::Context;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use trueaxis::machine::ErrorModel;
use trueaxis_evaluation::shown::{Cell, Table};
use trueaxis_sim::event::EventScript;
use trueaxis_sim::learning::LearnedTable;
use trueaxis_sim::plant::fault::FaultScript;
use trueaxis_sim::program::{self, BUILTIN_NAMES, Offsets, ReadOptions, Source, ToolTable};
use trueaxis_sim::run::{Column, Kind, Moment, Run, RunDocument, Sample, Size, columns};
use trueaxis_sim::scenario::choose_model;
use trueaxis_sim::{Scenario, Settings};

/// Number of cycles between two checks for a keyboard interrupt.
const STRETCH: u64 = 1 << 15;

/// A part program, read and checked.
#[pyclass(frozen, module = "trueaxis")]
pub(crate) struct Program {
    program: program::Program,
    has_offsets: bool,
}

#[pymethods]
impl Program {
    /// Names of the shipped programs.
    #[classattr]
    const SHIPPED: [&'static str; 6] = BUILTIN_NAMES;

    /// Read a G-code file, or a shipped program by its name, like `--program` of `firmware-sim run`.
    ///
    /// Parameters
    /// ----------
    /// path : path-like
    ///     G-code file, or the name of a shipped program.
    /// tool_table : path-like, optional
    ///     A tool table of LinuxCNC.
    /// offsets : path-like, optional
    ///     A parameter file of LinuxCNC, or a .toml file.
    /// block_delete : bool, default False
    ///     Whether lines that begin with `/` are skipped.
    ///
    /// Returns
    /// -------
    /// Program
    ///     The program, read and checked.
    ///
    /// Raises
    /// ------
    /// trueaxis.Error
    ///     If an argument or a record is refused: what was found, and what is needed.
    #[staticmethod]
    #[pyo3(signature = (path, *, tool_table = None, offsets = None, block_delete = false))]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        tool_table: Option<PathBuf>,
        offsets: Option<PathBuf>,
        block_delete: bool,
    ) -> PyResult<Program> {
        to_python(py.detach(|| {
            let options =
                ReadOptions::from_files(tool_table.as_deref(), offsets.as_deref(), block_delete)?.beside(&path);
            Program::read(&Source::read(&path)?, &options)
        }))
    }

    /// Read a program from its text; tool_table and offsets are texts too.
    ///
    /// Parameters
    /// ----------
    /// text : str
    ///     G-code.
    /// name : str, default "program"
    ///     Name of the program in results and errors.
    /// tool_table : str, optional
    ///     Text of a tool table of LinuxCNC.
    /// offsets : str, optional
    ///     Text of a parameter file of LinuxCNC, or of a .toml file.
    /// block_delete : bool, default False
    ///     Whether lines that begin with `/` are skipped.
    ///
    /// Returns
    /// -------
    /// Program
    ///     The program, read and checked.
    ///
    /// Raises
    /// ------
    /// trueaxis.Error
    ///     If an argument or a record is refused: what was found, and what is needed.
    ///
    /// Examples
    /// --------
    /// >>> trueaxis.Program.from_text("G21 G90 F1500\nG1 X10\nM2\n").moves
    /// 1
    #[staticmethod]
    #[pyo3(signature = (text, *, name = "program", tool_table = None, offsets = None, block_delete = false))]
    fn from_text(
        py: Python<'_>,
        text: String,
        name: &str,
        tool_table: Option<&str>,
        offsets: Option<&str>,
        block_delete: bool,
    ) -> PyResult<Program> {
        to_python(py.detach(|| {
            let tools = tool_table.map(|text| ToolTable::parse(text, "tool_table")).transpose()?;
            let offsets = offsets.map(|text| Offsets::parse(text, "offsets")).transpose()?;
            let source = Source { name: name.to_owned(), bytes: text.into_bytes().into(), file: name.to_owned() };
            Program::read(&source, &ReadOptions { tools, offsets, block_delete, ..ReadOptions::default() })
        }))
    }

    /// Name of the program.
    #[getter]
    fn name(&self) -> &str {
        &self.program.name
    }

    /// Number of moves.
    #[getter]
    fn moves(&self) -> usize {
        self.program.moves.len()
    }

    fn __repr__(&self) -> String {
        format!("<trueaxis.Program {:?}, moves {}>", self.name(), self.moves())
    }
}

impl Program {
    fn read(source: &Source, options: &ReadOptions) -> anyhow::Result<Program> {
        let program = program::Program::read(&source.name, &source.bytes, &source.file, options)?;
        Ok(Program { program, has_offsets: options.offsets.is_some() })
    }
}

/// A value of a setting, which `toml` writes in TOML.
#[derive(FromPyObject)]
enum Value {
    Whole(i64),
    Number(f64),
    Numbers(Vec<f64>),
    Texts(Vec<String>),
}

impl Value {
    fn toml(&self) -> String {
        let number = |value: &f64| if value.is_nan() { "nan".into() } else { format!("{value:?}") };
        match self {
            Value::Whole(value) => value.to_string(),
            Value::Number(value) => number(value),
            Value::Numbers(values) => format!("[{}]", values.iter().map(number).collect::<Vec<_>>().join(", ")),
            Value::Texts(values) => format!("{values:?}"),
        }
    }
}

/// Trace of one machine, by column.
struct Trace {
    kind: Kind,
    columns: Vec<Column>,
    values: Vec<Vec<f64>>,
}

impl Trace {
    fn row(&mut self, moment: &Moment, sample: &Sample) {
        for (values, column) in self.values.iter_mut().zip(&self.columns) {
            values.push(column.value(moment, sample));
        }
    }

    /// Returns the columns as arrays; those of integers as int64.
    fn table(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let table = PyDict::new(py);
        for (column, values) in self.columns.iter().zip(self.values) {
            if column.decimals == 0 {
                let whole = values.iter().map(|value| *value as i64);
                table.set_item(&column.name, PyArray1::from_iter(py, whole))?;
            } else {
                table.set_item(&column.name, PyArray1::from_vec(py, values))?;
            }
        }
        Ok(table)
    }
}

/// Traces of the machines of a run, of every Nth cycle.
struct Traces {
    every: u64,
    machines: Vec<Trace>,
}

impl Traces {
    fn new(every: u64, kinds: &[Kind], scenario: &Scenario) -> Traces {
        let trace = |kind: &Kind| {
            let columns = columns(*kind, &scenario.machine.settings);
            Trace { kind: *kind, values: vec![Vec::new(); columns.len()], columns }
        };
        Traces { every, machines: kinds.iter().map(trace).collect() }
    }

    fn row(&mut self, moment: &Moment, samples: &[Option<&Sample>]) {
        if moment.cycle.is_multiple_of(self.every) {
            for (trace, sample) in self.machines.iter_mut().zip(samples) {
                sample.iter().for_each(|sample| trace.row(moment, sample));
            }
        }
    }

    /// Returns a dictionary of the machines' tables.
    fn tables(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let all = PyDict::new(py);
        for trace in self.machines {
            all.set_item(trace.kind.name(), trace.table(py)?)?;
        }
        Ok(all)
    }
}

/// Request to [`simulate`], in types that may leave the interpreter's lock.
struct Request<'a> {
    machine: &'a trueaxis_tables::Machine,
    program: &'a Program,
    /// Text of a scenario file.
    scenario: &'a str,
    /// Keys of the scenario with the values that replace its own, in this order.
    settings: Vec<(String, Value)>,
    faults: Vec<String>,
    events: Vec<String>,
    /// Machines whose tables an event may use, by name.
    exchanges: BTreeMap<String, trueaxis_tables::Machine>,
    model: Option<ErrorModel>,
    orientation: Option<bool>,
    learned: Option<PathBuf>,
    kinds: Option<Vec<String>>,
}

impl Request<'_> {
    /// Reads the scenario's text, with the replaced and the added keys.
    fn settings(&self) -> anyhow::Result<Settings> {
        let mut all = Settings::parse(self.scenario, "scenario")?;
        for (key, value) in &self.settings {
            all.set(key, &value.toml())?;
        }
        all.faults.items.extend(FaultScript::parse(&self.faults)?.items);
        all.events.items.extend(EventScript::parse(&self.events)?.items);
        if self.program.has_offsets {
            all.origin_mm.get_or_insert([0.0; 3]);
        }
        Ok(all)
    }

    /// A machine with the requested error model.
    fn with_model(&self, machine: &trueaxis_tables::Machine) -> anyhow::Result<trueaxis_tables::Machine> {
        let mut machine = machine.clone();
        choose_model(&mut machine, self.model, self.orientation)?;
        Ok(machine)
    }

    fn scenario(&self) -> anyhow::Result<Scenario> {
        let settings = self.settings()?;
        let exchanges = self.exchanges.iter().map(|(name, machine)| Ok((name.clone(), self.with_model(machine)?)));
        let exchanges = exchanges.collect::<anyhow::Result<_>>()?;
        let program = self.program.program.clone();
        let scenario = Scenario::new(self.with_model(self.machine)?, program, settings)?.with_exchanges(exchanges);
        let Some(file) = &self.learned else { return Ok(scenario) };
        let bytes = std::fs::read(file).with_context(|| format!("learned: cannot read {}", file.display()))?;
        let of_file = || format!("learned {}", file.display());
        let table = LearnedTable::read(bytes).with_context(of_file)?;
        scenario.with_learned(Arc::new(table)).with_context(of_file)
    }

    /// Reads everything and prepares the run.
    fn start(&self) -> anyhow::Result<(Arc<Scenario>, Vec<Kind>, Run)> {
        let scenario = Arc::new(self.scenario()?);
        let kinds = match &self.kinds {
            Some(names) => Kind::named(names)?,
            None => Kind::of(&scenario.machine.settings).to_vec(),
        };
        let run = Run::of(Arc::clone(&scenario), &kinds)?;
        Ok((scenario, kinds, run))
    }
}

/// Simulate a program on a machine.
///
/// Parameters
/// ----------
/// machine : Machine
///     The machine with the tables that are simulated.
/// program : Program
///     The part program.
/// seed : int, optional
///     Seed of the encoders' noise. Replaces the key of the scenario, after `settings`.
/// rate_hz : float, optional
///     Servo rate, Hz. Replaces the key of the scenario, after `settings`.
/// temperature_c : float, optional
///     Temperature of the machine, °C. Replaces the key of the scenario, after `settings`.
/// origin_mm : sequence of float, optional
///     Machine coordinates of the zero of the program's controller, mm. Replaces the key of the scenario, after `settings`.
/// scenario : str, optional
///     The text of a scenario file.
/// settings : Mapping[str, float or list[float] or list[str]], optional
///     Replaces keys of the scenario, like `--set`: {"drive.dead_time_s": 0.001}.
/// faults : sequence of str, optional
///     Faults to inject, such as "dropout:X@1.25s+3", besides those of the scenario.
/// events : sequence of str, optional
///     Events besides those of the scenario, such as "off:correction@2.5s"; `exchange:NAME@2s` uses the machine NAME of
///     `exchanges`.
/// exchanges : Mapping[str, Machine], optional
///     Machines whose tables an event may put into effect, by name.
/// on_trial : bool, default False
///     Friction, lag and acceleration are on trial from the start, like the event `on:trial@0s`: they act as
///     far as the contour error shows that they help. For drives whose figures are uncertain: 8 % instead of 22
///     % of simulated plants get more than 5 % worse than without dynamic correction, at the price of little
///     gain on tracks of one or two seconds.
/// model : {"nine", "volumetric"}, optional
///     Error model; by default, that of the machine.
/// orientation : bool, optional
///     Whether the rotary axes correct the tool's direction; by default, as the machine states.
/// learned : path-like, optional
///     A .tlearn file, the correction over path length that `learn` returns.
/// kinds : Sequence[{"uncompensated", "compensated", "servo_only", "full", "configured"}], optional
///     Machines to simulate side by side, from uncompensated, compensated, servo_only, full, configured; by
///     default, the command's.
/// trace_every : int, optional
///     Keeps every Nth cycle; `trace` of the document then contains, for every machine, the columns of
///     trace.csv (trace-full.csv) as arrays, not rounded.
///
/// Returns
/// -------
/// Run
///     The document of `firmware-sim run --json` without measured times.
///
/// Raises
/// ------
/// trueaxis.Error
///     If an argument or a record is refused: what was found, and what is needed.
///
/// Notes
/// -----
/// The events `off:adapt@2s` and `on:adapt@3s` freeze the friction that adapts and let it adapt again,
/// `reset:adapt@2s` returns it to the identified figures; `friction_factors` of the document has the factors in use
/// in the last cycle, and the trace has those of every cycle.
///
/// Equal arguments produce equal bits. The function releases the interpreter's lock, so several threads can
/// simulate at once.
#[pyfunction]
#[pyo3(signature = (machine, program, *, seed = None, rate_hz = None, temperature_c = None, origin_mm = None, scenario = None,
    settings = None, faults = Vec::new(), events = Vec::new(), exchanges = BTreeMap::new(), on_trial = false,
    model = None, orientation = None, learned = None, kinds = None, trace_every = None))]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    machine: Bound<'py, Machine>,
    program: Bound<'py, Program>,
    seed: Option<i64>,
    rate_hz: Option<f64>,
    temperature_c: Option<f64>,
    origin_mm: Option<[f64; 3]>,
    scenario: Option<&str>,
    settings: Option<Bound<'py, PyDict>>,
    faults: Vec<String>,
    mut events: Vec<String>,
    exchanges: BTreeMap<String, Py<Machine>>,
    on_trial: bool,
    model: Option<&str>,
    orientation: Option<bool>,
    learned: Option<PathBuf>,
    kinds: Option<Vec<String>>,
    trace_every: Option<u64>,
) -> PyResult<Bound<'py, PyAny>> {
    let mut replaced: Vec<(String, Value)> = match settings {
        Some(settings) => {
            settings.iter().map(|(key, value)| Ok((key.extract()?, value.extract()?))).collect::<PyResult<_>>()?
        }
        None => Vec::new(),
    };
    replaced.extend(rate_hz.map(|value| ("rate_hz".to_owned(), Value::Number(value))));
    replaced.extend(seed.map(|value| ("seed".to_owned(), Value::Whole(value))));
    replaced.extend(temperature_c.map(|value| ("temperature_c".to_owned(), Value::Number(value))));
    replaced.extend(origin_mm.map(|value| ("origin_mm".to_owned(), Value::Numbers(value.to_vec()))));
    if on_trial {
        events.insert(0, "on:trial@0s".to_owned());
    }
    let model = crate::machine::model_of(model)?;
    if trace_every == Some(0) {
        return Err(Error::new_err("trace_every: found 0, needed at least 1"));
    }
    let request = Request {
        machine: &machine.get().machine,
        program: program.get(),
        scenario: scenario.unwrap_or_default(),
        settings: replaced,
        faults,
        events,
        exchanges: exchanges.into_iter().map(|(name, machine)| (name, machine.get().machine.clone())).collect(),
        model,
        orientation,
        learned,
        kinds,
    };
    let (scenario, kinds, mut run) = to_python(py.detach(|| request.start()))?;
    let mut traces = trace_every.map(|every| Traces::new(every, &kinds, &scenario));
    let mut sink = |moment: &Moment, samples: &[Option<&Sample>]| {
        traces.iter_mut().for_each(|traces| traces.row(moment, samples));
    };
    while py.detach(|| run.advance(STRETCH, &mut sink)) {
        py.check_signals()?;
    }
    let machines: Vec<_> = kinds.into_iter().zip(run.tallies()).collect();
    let document = RunDocument::<()>::of(&scenario, run.cycles(), &machines);
    document.notes.iter().try_for_each(|note| warn(py, note))?;
    let found = json::dictionary(py, &document)?;
    if let Some(traces) = traces {
        found.set_item("trace", traces.tables(py)?)?;
    }
    let sizes = document.figures.contour_error_um.0.iter();
    let row =
        |(kind, size): &(Kind, Size)| vec![kind.words().into(), Cell::number(size.max, 4), Cell::number(size.rms, 4)];
    let table = Table::new("Contour error, µm", ["machine", "largest", "RMS"], sizes.map(row));
    let RunDocument { machine, program, simulated_s, .. } = &document;
    let text = format!("{program} on {machine}: {simulated_s:.3} s simulated\n\n");
    table_result("Run", found, "Simulated run", (text, table))
}
