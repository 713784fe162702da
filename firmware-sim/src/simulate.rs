//! The run: every servo cycle goes through `step` against the simulated machine.

use crate::latency::Latency;
use crate::motion::{Motion, Setpoint};
use crate::pace::{self, Pace, PaceReport};
use crate::path::PlannedPath;
use crate::placement::Place;
use crate::plant::fault::FaultScript;
use crate::plant::{Plant, PlantSettings};
use crate::report::{AngleSize, ErrorSize};
use crate::scenario::Scenario;
use crate::trace::Trace;
use crate::truth;
use anyhow::{Context, Result, anyhow};
use glam::DVec3;
use std::ops::ControlFlow;
use std::time::Instant;
use trueaxis::compensation::ThermalLine;
use trueaxis::contour::{OrientationError, Reference};
use trueaxis::kinematics::Kinematics;
use trueaxis::machine::AXES;
use trueaxis::machine::step_axes;
use trueaxis::tcomp::Tcomp;
use trueaxis::{Axis, Config, Fault, Input, Output, Position, Real, ServoLoop, State};
use trueaxis_tables::Machine;

/// Which of the three runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The machine as it is, the plugin disabled.
    Uncompensated,
    /// The plugin enabled.
    Compensated,
    /// A machine with perfect geometry and no lost motion: what the servo alone leaves.
    ServoOnly,
}

/// A fault that the plugin reported, over consecutive cycles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaultSpan {
    /// What.
    pub fault: Fault,
    /// On which axis.
    pub axis: Axis,
    /// First cycle, counted from the start of the program.
    pub cycle: u64,
    /// How many cycles.
    pub cycles: u64,
    /// Program line.
    pub line: u32,
}

/// What a cycle of a run leaves for the plots.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Arc length along the program, mm.
    pub length_mm: f64,
    /// Programmed point in machine coordinates (with rotary axes: in workpiece coordinates), mm.
    pub nominal_mm: [f64; 3],
    /// True tip from the nearest point of the path, µm.
    pub deviation_um: [f32; 3],
    /// Angle of the true tool direction from the programmed one, µrad.
    pub orientation_urad: f32,
    /// The same as the step reports it, µrad.
    pub estimated_orientation_urad: f32,
    /// A, B, C commanded, degrees.
    pub rotary_deg: [f32; 3],
    /// Correction sent to X, Y, Z, µm.
    pub correction_um: [f32; 3],
    /// Contour error that the plugin reports for the estimated tip, µm.
    pub estimated_um: f32,
    /// Cutting, not positioning at rapid.
    pub cutting: bool,
}

/// The outcome of one run.
#[derive(Debug)]
pub struct Run {
    /// Every cycle, in order.
    pub samples: Vec<Sample>,
    /// Contour error of the true tip while cutting.
    pub error: ErrorSize,
    /// Angle of the true tool direction from the programmed one while cutting; zero for a program of X, Y, Z alone.
    pub orientation: AngleSize,
    /// Contour error of the tip that the step itself reports, while cutting.
    pub estimated: ErrorSize,
    /// Orientation error that the step itself reports, while cutting.
    pub estimated_orientation: AngleSize,
    /// Faults reported.
    pub faults: Vec<FaultSpan>,
    /// Cost of every step.
    pub latency: Latency,
    /// Cycles in which an axis' correction was limited.
    pub limited_cycles: u64,
    /// Stopped by a stop request.
    pub stopped: bool,
    /// How pacing went, if it was asked for.
    pub pace: Option<PaceReport>,
}

/// Cycles of a stopped run that are still simulated, to show that the output holds.
const CYCLES_AFTER_STOP: u64 = 200;

/// How the runs are carried out.
pub struct Options<'o> {
    /// Run at the real rate.
    pub paced: bool,
    /// Called every thousand cycles with the number done.
    pub progress: &'o mut (dyn FnMut(u64) + Send),
    /// Where every cycle of the compensated run is written.
    pub trace: Option<&'o mut Trace>,
    /// Called with what the step is given in every cycle, those at rest before the program included.
    pub watch: Watch<'o>,
}

/// Sees what the step is given.
pub type Watch<'o> = Option<&'o mut (dyn FnMut(&Given<'_>) + Send)>;

/// What the step is given in a cycle.
#[derive(Clone, Copy, Debug)]
pub struct Given<'i> {
    /// Commanded positions in the step's order.
    pub command: &'i [f64],
    /// Readings.
    pub feedback: &'i [f64],
    /// Time since the last cycle.
    pub elapsed_ns: u32,
    /// Place on the path.
    pub reference: Reference<f64>,
}

/// Simulates one run of a scenario on a machine of `N` axes.
///
/// # Errors
/// The machine's tables do not build.
pub fn run<const N: usize>(
    scenario: &Scenario,
    motion: &Motion<'_>,
    path: &PlannedPath,
    kind: Kind,
    options: &mut Options<'_>,
) -> Result<Run> {
    with_loop::<N, _>(&scenario.machine, scenario.period_ns(), |servo| {
        let mut cell = Cell::<N>::new(scenario, motion, path, kind, servo)?;
        cell.settle(&mut options.watch);
        let mut setpoints = motion.setpoints();
        let mut cycle = 0u64;
        let mut advance = |options: &mut Options<'_>| -> ControlFlow<()> {
            let Some(setpoint) = setpoints.next() else { return ControlFlow::Break(()) };
            cell.cycle(&setpoint, cycle, options.trace.as_deref_mut(), &mut options.watch);
            cycle += 1;
            if cycle.is_multiple_of(1000) {
                (options.progress)(cycle);
            }
            if cell.stopped_for > CYCLES_AFTER_STOP { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let mut pace = None;
        if options.paced && kind == Kind::Compensated {
            // The real-time thread writes no file and draws no bar.
            let mut silent = |_| {};
            let mut quiet = Options { paced: true, progress: &mut silent, trace: None, watch: None };
            pace = Some(pace::run(&Pace::new(scenario.period_ns().into()), |_| advance(&mut quiet)));
        } else {
            while advance(options).is_continue() {}
        }
        Ok(cell.finish(pace))
    })
}

/// Builds the servo loop of a machine from its compiled tables, as a controller would, and lends it out.
///
/// # Errors
/// The tables do not compile or build.
pub fn with_loop<const N: usize, T>(
    machine: &Machine,
    period_ns: u32,
    user: impl FnOnce(&ServoLoop<'_, f64, f64, N>) -> Result<T>,
) -> Result<T> {
    let bytes = trueaxis_tables::compile(machine).map_err(|e| anyhow!("{e}"))?;
    let tcomp = Tcomp::parse(&bytes).map_err(|e| anyhow!("compiled tables: {e}"))?;
    with_tables(&tcomp, period_ns, user)
}

/// Builds the servo loop of compiled tables, in any scalar, and lends it out.
///
/// # Errors
/// The tables do not build.
pub fn with_tables<R: Real, P: Position, const N: usize, T>(
    tcomp: &Tcomp<'_>,
    period_ns: u32,
    user: impl FnOnce(&ServoLoop<'_, R, P, N>) -> Result<T>,
) -> Result<T> {
    let rows = |axis: Axis| tcomp.table(axis);
    let config = Config::of(tcomp, period_ns);
    let mut memory = config.requirement::<R, P, N, _>(rows).memory();
    let servo = config.build::<R, P, N, _>(rows, memory.lend()).map_err(|e| anyhow!("{e}"))?;
    user(&servo)
}

/// What came out of the step, and how long it took.
struct Exchanged<const N: usize> {
    output: Output<f64, f64, N>,
    orientation: OrientationError<f64>,
    nanoseconds: u64,
}

/// The true error of a cycle.
struct Measured {
    tip: DVec3,
    angle: f64,
    nominal: DVec3,
}

/// Largest and root mean square of what was added.
#[derive(Default)]
struct Tally {
    max: f64,
    squares: f64,
    count: u64,
}

impl Tally {
    fn add(&mut self, value: f64) {
        self.max = self.max.max(value);
        self.squares += value * value;
        self.count += 1;
    }

    fn rms(&self) -> f64 {
        if self.count > 0 { (self.squares / self.count as f64).sqrt() } else { 0.0 }
    }
}

/// Interpolator, plugin and machine of one run.
struct Cell<'c, 'a, const N: usize> {
    scenario: &'c Scenario,
    servo: &'c ServoLoop<'a, f64, f64, N>,
    state: State<f64, f64, N>,
    plant: Plant,
    /// Place in the step of each of the machine's axes.
    order: Vec<Option<usize>>,
    path: &'c PlannedPath,
    motion: &'c Motion<'c>,
    axes: [Axis; N],
    kind: Kind,
    origin: DVec3,
    /// For programs with rotary axes.
    kinematics: Option<Kinematics<f64>>,
    feedback: [f64; N],
    elapsed_periods: f64,
    stopped_for: u64,
    error: Tally,
    orientation: Tally,
    estimated: Tally,
    estimated_orientation: Tally,
    span: u32,
    run: Run,
}

impl<'c, 'a, const N: usize> Cell<'c, 'a, N> {
    fn new(
        scenario: &'c Scenario,
        motion: &'c Motion<'c>,
        path: &'c PlannedPath,
        kind: Kind,
        servo: &'c ServoLoop<'a, f64, f64, N>,
    ) -> Result<Self> {
        let mut state =
            servo.start(scenario.period_ns()).map_err(|fault| anyhow!("the step refused to start: {fault:?}"))?;
        let axes = step_axes::<N>(&scenario.machine.settings).map_err(|e| anyhow!("{e}"))?;
        for (place, axis) in axes.iter().enumerate() {
            if let Some(settings) = scenario.machine.settings.axes.iter().find(|a| a.axis == *axis) {
                let line = ThermalLine::for_axis(&settings.thermal, scenario.kelvin)
                    .with_context(|| format!("thermal growth of axis {} at {} K", axis.letter(), scenario.kelvin))?;
                state.set_thermal(place, line);
            }
        }
        let perfect = kind == Kind::ServoOnly;
        let faults = if perfect { FaultScript::default() } else { scenario.faults.clone() };
        let settings = PlantSettings { temperature_rise_k: scenario.kelvin, faults, ..PlantSettings::default() };
        let plant = Plant::new(&scenario.machine, settings, perfect, scenario.seed, scenario.period_s())?;
        let order = scenario.machine.settings.axes.iter().map(|a| axes.iter().position(|b| *b == a.axis)).collect();
        Ok(Cell {
            scenario,
            servo,
            state,
            plant,
            order,
            path,
            motion,
            axes,
            kind,
            origin: DVec3::from(scenario.origin_mm),
            kinematics: scenario.kinematics()?,
            feedback: [0.0; N],
            elapsed_periods: 1.0,
            stopped_for: 0,
            error: Tally::default(),
            orientation: Tally::default(),
            estimated: Tally::default(),
            estimated_orientation: Tally::default(),
            span: 0,
            run: Run {
                samples: Vec::with_capacity(motion.cycles() as usize),
                error: ErrorSize::default(),
                orientation: AngleSize::default(),
                estimated: ErrorSize::default(),
                estimated_orientation: AngleSize::default(),
                faults: Vec::new(),
                latency: Latency::new(scenario.budget_ns, scenario.period_ns().into()),
                limited_cycles: 0,
                stopped: false,
                pace: None,
            },
        })
    }

    /// At rest on the first point until the correction has been led in, as a machine is switched on before it cuts.
    fn settle(&mut self, watch: &mut Watch<'_>) {
        let Some(first) = self.motion.setpoints().next() else { return };
        let position = self.command(&first);
        self.feedback = position;
        self.plant.rest_at(&self.to_plant(&position));
        self.plant.hold_faults();
        let limits = self.scenario.machine.settings.axes.iter().map(|a| a.limits);
        let slowest =
            limits.map(|l| l.magnitude / l.slope_per_s + l.slope_per_s / l.acceleration_per_s2).fold(0.0, f64::max);
        for _ in 0..(1.2 * slowest.min(2.0) * self.scenario.rate_hz) as u64 {
            self.exchange(&first, position, watch);
        }
        self.plant.start_faults();
    }

    fn command(&self, setpoint: &Setpoint) -> [f64; N] {
        let positions = self.scenario.axis_positions(setpoint);
        self.axes.map(|axis| positions[axis.index()])
    }

    /// One servo period: plugin, then drives and encoders.
    fn exchange(&mut self, setpoint: &Setpoint, mut command: [f64; N], watch: &mut Watch<'_>) -> Exchanged<N> {
        let mut disturbed = self.to_plant(&command);
        self.plant.disturb_command(&mut disturbed);
        self.take_from_plant(&disturbed, &mut command);
        let input = Input {
            command,
            feedback: self.feedback,
            encoder_alarm: 0,
            elapsed_ns: (self.elapsed_periods * f64::from(self.scenario.period_ns())) as u32,
            homed: true,
            enable: self.kind == Kind::Compensated,
            reset: false,
        };
        let reference = self.path.reference(setpoint.move_index, setpoint.u, &mut self.span);
        if let Some(watch) = watch {
            let Input { command, feedback, elapsed_ns, .. } = &input;
            watch(&Given { command, feedback, elapsed_ns: *elapsed_ns, reference });
        }
        let (path, tool_path) = (self.path.view(), self.path.tool_view());
        let start = Instant::now();
        let (output, orientation) = match &self.kinematics {
            Some(kinematics) => self.servo.step_with_tool(&mut self.state, &input, &tool_path, reference, kinematics),
            None => (self.servo.step(&mut self.state, &input, path.on(reference), ()), OrientationError::none()),
        };
        let nanoseconds = start.elapsed().as_nanos() as u64;
        let readings = self.plant.cycle(&self.to_plant(&output.drive));
        let mut feedback = self.feedback;
        self.take_from_plant(&readings.position, &mut feedback);
        self.feedback = feedback;
        self.elapsed_periods = readings.elapsed_periods;
        Exchanged { output, orientation, nanoseconds }
    }

    /// Positions in the step's order as the plant counts them: by the machine's list of axes.
    fn to_plant(&self, positions: &[f64; N]) -> [f64; AXES] {
        let mut plant = [0.0; AXES];
        for (to, place) in plant.iter_mut().zip(&self.order) {
            *to = place.and_then(|p| positions.get(p)).copied().unwrap_or(0.0);
        }
        plant
    }

    fn take_from_plant(&self, plant: &[f64; AXES], positions: &mut [f64; N]) {
        for (from, place) in plant.iter().zip(&self.order) {
            if let Some(to) = place.and_then(|p| positions.get_mut(p)) {
                *to = *from;
            }
        }
    }

    fn cycle(&mut self, setpoint: &Setpoint, cycle: u64, trace: Option<&mut Trace>, watch: &mut Watch<'_>) {
        let command = self.command(setpoint);
        let Exchanged { output, orientation, nanoseconds } = self.exchange(setpoint, command, watch);
        self.run.latency.record(nanoseconds);
        let measured = self.measure(setpoint);
        let deviation = 1e3 * measured.tip;
        let orientation_urad = 1e6 * measured.angle;
        let step = &self.scenario.program.moves[setpoint.move_index];
        let cutting = !step.rapid;
        if cutting && self.stopped_for == 0 {
            self.error.add(deviation.length());
            self.orientation.add(orientation_urad);
            if output.record.tip.is_measured() {
                self.estimated.add(1e3 * output.record.tip.error);
            }
            if orientation.is_measured() {
                self.estimated_orientation.add(1e6 * orientation.angle);
            }
        }
        if output.record.limited != 0 {
            self.run.limited_cycles += 1;
        }
        self.note_fault(&output, cycle, step.line);
        if output.stop_requested() {
            self.run.stopped = true;
            self.stopped_for += 1;
        }
        let correction = &output.record.correction;
        let sample = Sample {
            length_mm: setpoint.length,
            nominal_mm: measured.nominal.to_array(),
            deviation_um: deviation.as_vec3().to_array(),
            orientation_urad: orientation_urad as f32,
            estimated_orientation_urad: (orientation.angle * 1e6) as f32,
            rotary_deg: setpoint.rotary.map(|q| q as f32),
            correction_um: [correction[0], correction[1], correction[2]].map(|c| (c * 1e3) as f32),
            estimated_um: (output.record.tip.error * 1e3) as f32,
            cutting,
        };
        if let Some(trace) = trace {
            trace.row(cycle as f64 * self.scenario.period_s(), step.line, &sample, &output);
        }
        self.run.samples.push(sample);
    }

    /// The truth: three-axis programs in machine coordinates, the others in workpiece coordinates with the direction.
    fn measure(&self, setpoint: &Setpoint) -> Measured {
        let place = (setpoint.move_index, setpoint.u);
        let program = &self.scenario.program;
        let step = program.moves.get(setpoint.move_index);
        if let (true, Some(step)) = (self.scenario.five_axis, step) {
            let pose = self.plant.true_pose();
            let actual = Place { tip: DVec3::from(pose.tip_mm), direction: DVec3::from(pose.direction) };
            let placement = &self.scenario.placement;
            let found = truth::pose::deviation(program, placement, place, &actual);
            return Measured { tip: found.tip, angle: found.angle, nominal: placement.place(step, setpoint.u).tip };
        }
        let tip = DVec3::from(self.plant.true_tip());
        Measured {
            tip: truth::deviation(program, self.origin, place, tip),
            angle: 0.0,
            nominal: DVec3::from(setpoint.position) + self.origin,
        }
    }

    fn note_fault(&mut self, output: &Output<f64, f64, N>, cycle: u64, line: u32) {
        let fault = output.record.fault;
        if fault == Fault::None {
            return;
        }
        let axis = self.axes.get(usize::from(output.record.fault_axis)).copied().unwrap_or(Axis::X);
        match self.run.faults.last_mut() {
            Some(last) if last.fault == fault && last.axis == axis && last.cycle + last.cycles == cycle => {
                last.cycles += 1
            }
            _ => self.run.faults.push(FaultSpan { fault, axis, cycle, cycles: 1, line }),
        }
    }

    fn finish(mut self, pace: Option<PaceReport>) -> Run {
        let lengths = |tally: &Tally| ErrorSize { max_um: tally.max, rms_um: tally.rms() };
        let angles = |tally: &Tally| AngleSize { max_urad: tally.max, rms_urad: tally.rms() };
        self.run.error = lengths(&self.error);
        self.run.orientation = angles(&self.orientation);
        self.run.estimated = lengths(&self.estimated);
        self.run.estimated_orientation = angles(&self.estimated_orientation);
        self.run.pace = pace;
        self.run
    }
}
