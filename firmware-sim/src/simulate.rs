//! The run: every servo cycle goes through `step` against the simulated machine.

use crate::latency::{Latency, timed};
use crate::motion::{Motion, Setpoint};
use crate::pace::{self, Pace, PaceReport};
use crate::path::SlidingPath;
use crate::placement::Place;
use crate::plant::fault::FaultScript;
use crate::plant::{Plant, PlantSettings};
use crate::report::{AngleSize, ErrorSize};
use crate::scenario::Scenario;
use crate::truth;
use anyhow::{Context, Result, anyhow};
use glam::DVec3;
use std::ops::ControlFlow;
use trueaxis::compensation::ThermalLine;
use trueaxis::contour::{OrientationError, Path, Reference, ToolPath};
use trueaxis::kinematics::Kinematics;
use trueaxis::machine::AXES;
use trueaxis::machine::AxisOrder;
use trueaxis::sample::Refusal;
use trueaxis::tcomp::Tcomp;
use trueaxis::{Axis, Config, Fault, Input, OnToolPath, Output, Position, Real, ServoLoop, State};
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

/// Most stretches of faults that a run lists; those after them are counted.
pub const MOST_FAULT_SPANS: usize = 1000;

/// What is commanded in a cycle, the same in every run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moment {
    /// Counted from the start of the program.
    pub cycle: u64,
    /// The same as time, s.
    pub time_s: f64,
    /// Program line.
    pub line: u32,
    /// Cutting, not positioning at rapid.
    pub cutting: bool,
    /// Arc length along the program, mm.
    pub length_mm: f64,
    /// Programmed point in machine coordinates (with rotary axes: in workpiece coordinates), mm.
    pub nominal_mm: [f64; 3],
    /// A, B, C programmed, degrees.
    pub rotary_deg: [f64; 3],
}

/// What a cycle of one run gave. Axes in the order X, Y, Z, A, B, C; zero for those that the machine does not have.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sample {
    /// True tip from the nearest point of the path, µm.
    pub deviation_um: [f32; 3],
    /// Angle of the true tool direction from the programmed one, µrad.
    pub orientation_urad: f32,
    /// The same as the step reports it, µrad.
    pub estimated_orientation_urad: f32,
    /// Contour error that the plugin reports for the estimated tip, µm.
    pub estimated_um: f32,
    /// Contour error that it reports for the plain encoder position, µm.
    pub encoder_um: f64,
    /// Way from the tip's foot to the reference, µm.
    pub lag_um: f64,
    /// Command as the step took it, mm and degrees.
    pub command: [f64; AXES],
    /// Command sent to the drives, mm and degrees.
    pub drive: [f64; AXES],
    /// Reading as the step took it, mm and degrees.
    pub feedback: [f64; AXES],
    /// Correction sent, µm and µrad.
    pub correction: [f32; AXES],
    /// Fault code.
    pub fault: u8,
    /// State bits.
    pub status: u8,
    /// A bit for every axis of the step whose correction differs from the wanted one.
    pub limited: u8,
    /// A bit for every axis of the step whose table holds its edge value.
    pub at_edge: u8,
}

impl Sample {
    /// |deviation|, µm.
    pub fn error_um(&self) -> f32 {
        let [x, y, z] = self.deviation_um;
        (x * x + y * y + z * z).sqrt()
    }
}

/// Takes every cycle of the runs as it comes; the runs themselves keep none.
pub trait Sink {
    /// A cycle, in order; `runs` in the order in which they were asked for, none where one has ended.
    fn cycle(&mut self, moment: &Moment, runs: &[Option<&Sample>]);
}

/// The outcome of one run.
#[derive(Debug)]
pub struct Run {
    /// Contour error of the true tip while cutting.
    pub error: ErrorSize,
    /// Angle of the true tool direction from the programmed one while cutting; zero for a program of X, Y, Z alone.
    pub orientation: AngleSize,
    /// Contour error of the tip that the step itself reports, while cutting.
    pub estimated: ErrorSize,
    /// Orientation error that the step itself reports, while cutting.
    pub estimated_orientation: AngleSize,
    /// Faults reported, at most [`MOST_FAULT_SPANS`] stretches.
    pub faults: Vec<FaultSpan>,
    /// Cycles with a fault that are not in that list.
    pub more_faults: u64,
    /// Cost of every step.
    pub latency: Latency,
    /// Cycles in which an axis' correction was limited.
    pub limited_cycles: u64,
    /// Stopped by a stop request.
    pub stopped: bool,
}

/// Cycles of a stopped run that are still simulated, to show that the output holds.
const CYCLES_AFTER_STOP: u64 = 200;

/// Cycles that are commanded at a time, and then simulated run by run: enough that one run after the other has the
/// processor's caches for itself, little enough to stay in them.
const BLOCK: usize = 256;

/// Who sees the runs go by.
pub struct Options<'o, 's> {
    /// Called from time to time with the number of cycles done.
    pub progress: &'o mut dyn FnMut(u64),
    /// Given every cycle.
    pub sinks: &'o mut [&'s mut dyn Sink],
    /// Called with what the step of the first run is given in every cycle, those at rest before the program included.
    pub watch: Watch<'o>,
}

/// Sees what the step is given.
pub type Watch<'o> = Option<&'o mut dyn FnMut(&Given<'_>)>;

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

/// Simulates runs of a scenario on a machine of `N` axes, side by side; in the same order they are given back.
///
/// Memory: a block of cycles and a stretch of the path, however long the program is.
///
/// # Errors
/// The machine's tables do not build, or a move is no path.
pub fn run<const N: usize>(
    scenario: &Scenario,
    motion: &Motion<'_>,
    kinds: &[Kind],
    options: &mut Options<'_, '_>,
) -> Result<Vec<Run>> {
    with_loop::<N, _>(&scenario.machine, scenario.period_ns(), |servo| {
        let mut planned = Planned::<N>::new(scenario, motion)?;
        let mut cells: Vec<Cell<'_, '_, N>> =
            kinds.iter().map(|kind| Cell::new(scenario, *kind, servo)).collect::<Result<_>>()?;
        if let Some(first) = planned.first()? {
            for (number, cell) in cells.iter_mut().enumerate() {
                let watch = if number == 0 { &mut options.watch } else { &mut None };
                cell.settle(&first, &planned.path, watch);
            }
        }
        let mut samples: Vec<Vec<Sample>> = kinds.iter().map(|_| Vec::with_capacity(BLOCK)).collect();
        let mut block = Vec::with_capacity(BLOCK);
        while planned.next_block(&mut block, BLOCK)? && !cells.iter().all(Cell::has_ended) {
            for (number, (cell, samples)) in cells.iter_mut().zip(&mut samples).enumerate() {
                samples.clear();
                let watch = if number == 0 { &mut options.watch } else { &mut None };
                for place in &block {
                    if cell.has_ended() {
                        break;
                    }
                    samples.push(cell.cycle(place, &planned.path, watch));
                }
            }
            let mut runs = vec![None; kinds.len()];
            for (i, place) in block.iter().enumerate() {
                for (run, samples) in runs.iter_mut().zip(&samples) {
                    *run = samples.get(i);
                }
                if runs.iter().any(Option::is_some) {
                    for sink in options.sinks.iter_mut() {
                        sink.cycle(&place.moment, &runs);
                    }
                }
            }
            (options.progress)(planned.cycle);
        }
        Ok(cells.into_iter().map(Cell::finish).collect())
    })
}

/// Runs the compensated run alone at the real rate, for what its steps cost there; the rest of its outcome is that of any
/// other run.
///
/// # Errors
/// As [`run`].
pub fn run_paced<const N: usize>(scenario: &Scenario, motion: &Motion<'_>) -> Result<(Latency, PaceReport)> {
    with_loop::<N, _>(&scenario.machine, scenario.period_ns(), |servo| {
        let mut planned = Planned::<N>::new(scenario, motion)?;
        let mut cell = Cell::new(scenario, Kind::Compensated, servo)?;
        if let Some(first) = planned.first()? {
            cell.settle(&first, &planned.path, &mut None);
        }
        let mut block = Vec::with_capacity(1);
        let mut failure = None;
        let report = pace::run(&Pace::new(scenario.period_ns().into()), |_| {
            match planned.next_block(&mut block, 1) {
                Ok(true) => {}
                Ok(false) => return ControlFlow::Break(()),
                Err(error) => {
                    failure = Some(error);
                    return ControlFlow::Break(());
                }
            }
            for place in &block {
                cell.step(place, &planned.path, &mut None);
            }
            if cell.has_ended() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        match failure {
            Some(error) => Err(error),
            None => Ok((cell.run.latency, report)),
        }
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
    let mut memory = vec![R::ZERO; config.requirement(rows)];
    let servo = config.build::<R, P, N, _>(rows, &mut memory).map_err(|e| anyhow!("{e}"))?;
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

/// A cycle as it is commanded.
struct CommandWindow<const N: usize> {
    moment: Moment,
    setpoint: Setpoint,
    command: [f64; N],
    reference: Reference<f64>,
}

/// What is commanded, a block at a time, and the stretch of the path that belongs to it.
struct Planned<'c, const N: usize> {
    scenario: &'c Scenario,
    motion: &'c Motion<'c>,
    setpoints: std::iter::Peekable<crate::motion::Setpoints<'c>>,
    path: SlidingPath<'c>,
    axes: [Axis; N],
    span: u32,
    cycle: u64,
}

impl<'c, const N: usize> Planned<'c, N> {
    fn new(scenario: &'c Scenario, motion: &'c Motion<'c>) -> Result<Self> {
        Ok(Planned {
            scenario,
            motion,
            setpoints: motion.setpoints().peekable(),
            path: SlidingPath::new(scenario),
            axes: AxisOrder::<N>::of(&scenario.machine.settings).map_err(|e| anyhow!("{e}"))?.axes(),
            span: 0,
            cycle: 0,
        })
    }

    /// Where the program begins.
    fn first(&mut self) -> Result<Option<CommandWindow<N>>> {
        let Some(setpoint) = self.motion.setpoints().next() else { return Ok(None) };
        self.path.cover([setpoint.move_index; 2])?;
        Ok(Some(self.commanded(setpoint)))
    }

    /// Puts the next cycles, at most `most`, in the place of those in `block`; false at the end.
    fn next_block(&mut self, block: &mut Vec<CommandWindow<N>>, most: usize) -> Result<bool> {
        block.clear();
        let Some(first) = self.setpoints.peek().map(|setpoint| setpoint.move_index) else { return Ok(false) };
        let mut last = first;
        while block.len() < most
            && let Some(setpoint) = self.setpoints.next()
        {
            last = last.max(setpoint.move_index);
            self.path.cover([first, last])?;
            let commanded = self.commanded(setpoint);
            block.push(commanded);
            self.cycle += 1;
        }
        Ok(true)
    }

    fn commanded(&mut self, setpoint: Setpoint) -> CommandWindow<N> {
        let scenario = self.scenario;
        let positions = scenario.axis_positions(&setpoint);
        let step = scenario.program.moves.get(setpoint.move_index);
        let nominal = match step {
            Some(step) if scenario.five_axis => scenario.placement.place(step, setpoint.u).tip,
            _ => DVec3::from(setpoint.position) + DVec3::from(scenario.origin_mm),
        };
        CommandWindow {
            moment: Moment {
                cycle: self.cycle,
                time_s: self.cycle as f64 * scenario.period_s(),
                line: step.map_or(0, |step| step.line),
                cutting: step.is_some_and(|step| !step.rapid),
                length_mm: setpoint.length,
                nominal_mm: nominal.to_array(),
                rotary_deg: setpoint.rotary,
            },
            command: self.axes.map(|axis| positions[axis.index()]),
            reference: self.path.reference(setpoint.move_index, setpoint.u, &mut self.span),
            setpoint,
        }
    }
}

/// Plugin and machine of one run.
struct Cell<'c, 'a, const N: usize> {
    scenario: &'c Scenario,
    servo: &'c ServoLoop<'a, f64, f64, N>,
    state: State<f64, f64, N>,
    plant: Plant,
    /// Place in the step of each of the machine's axes.
    order: Vec<Option<usize>>,
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
    run: Run,
}

impl<'c, 'a, const N: usize> Cell<'c, 'a, N> {
    fn new(scenario: &'c Scenario, kind: Kind, servo: &'c ServoLoop<'a, f64, f64, N>) -> Result<Self> {
        let mut state = servo.start();
        let axes = AxisOrder::<N>::of(&scenario.machine.settings).map_err(|e| anyhow!("{e}"))?.axes();
        for (place, axis) in axes.iter().enumerate() {
            if let Some(settings) = scenario.machine.settings.axis(*axis) {
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
            run: Run {
                error: ErrorSize::default(),
                orientation: AngleSize::default(),
                estimated: ErrorSize::default(),
                estimated_orientation: AngleSize::default(),
                faults: Vec::new(),
                more_faults: 0,
                latency: Latency::new(scenario.budget_ns, scenario.period_ns().into()),
                limited_cycles: 0,
                stopped: false,
            },
        })
    }

    fn has_ended(&self) -> bool {
        self.stopped_for > CYCLES_AFTER_STOP
    }

    /// At rest on the first point until the correction has been led in, as a machine is switched on before it cuts.
    fn settle(&mut self, first: &CommandWindow<N>, path: &SlidingPath<'_>, watch: &mut Watch<'_>) {
        self.feedback = first.command;
        self.plant.rest_at(&self.to_plant(&first.command));
        self.plant.hold_faults();
        let limits = self.scenario.machine.settings.axes.iter().map(|a| a.limits);
        let slowest =
            limits.map(|l| l.magnitude / l.slope_per_s + l.slope_per_s / l.acceleration_per_s2).fold(0.0, f64::max);
        for _ in 0..(1.2 * slowest.min(2.0) * self.scenario.rate_hz) as u64 {
            self.exchange(first, &path.view(), &path.tool_view(), watch);
        }
        self.plant.start_faults();
    }

    /// One servo period: plugin, then drives and encoders.
    fn exchange(
        &mut self,
        place: &CommandWindow<N>,
        path: &Path<'_, f64, f64>,
        tool_path: &ToolPath<'_, f64, f64>,
        watch: &mut Watch<'_>,
    ) -> Exchanged<N> {
        let mut command = place.command;
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
            refusal: Refusal::NONE,
        };
        let reference = place.reference;
        if let Some(watch) = watch {
            let Input { command, feedback, elapsed_ns, .. } = &input;
            watch(&Given { command, feedback, elapsed_ns: *elapsed_ns, reference });
        }
        let ((output, orientation), nanoseconds) = timed(|| match &self.kinematics {
            Some(kinematics) => {
                let mut on = OnToolPath::new(tool_path, reference, kinematics);
                let output = self.servo.step(&mut self.state, &input, &mut on, ());
                (output, *on.orientation())
            }
            None => (self.servo.step(&mut self.state, &input, path.on(reference), ()), OrientationError::none()),
        });
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

    /// A cycle, its cost and its stop; what it is worth is not measured.
    fn step(&mut self, place: &CommandWindow<N>, path: &SlidingPath<'_>, watch: &mut Watch<'_>) -> Exchanged<N> {
        let exchanged = self.exchange(place, &path.view(), &path.tool_view(), watch);
        self.run.latency.record(exchanged.nanoseconds);
        if exchanged.output.stop_requested() {
            self.run.stopped = true;
            self.stopped_for += 1;
        }
        exchanged
    }

    fn cycle(&mut self, place: &CommandWindow<N>, path: &SlidingPath<'_>, watch: &mut Watch<'_>) -> Sample {
        let running = self.stopped_for == 0;
        let Exchanged { output, orientation, .. } = self.step(place, path, watch);
        let measured = self.measure(&place.setpoint);
        let deviation = 1e3 * measured.tip;
        let orientation_urad = 1e6 * measured.angle;
        if place.moment.cutting && running {
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
        self.note_fault(&output, &place.moment);
        let record = &output.record;
        let mut sample = Sample {
            deviation_um: deviation.as_vec3().to_array(),
            orientation_urad: orientation_urad as f32,
            estimated_orientation_urad: (orientation.angle * 1e6) as f32,
            estimated_um: (record.tip.error * 1e3) as f32,
            encoder_um: record.encoder.error * 1e3,
            lag_um: record.tip.lag * 1e3,
            fault: record.fault as u8,
            status: record.status.0,
            limited: record.limited,
            at_edge: record.at_edge,
            ..Sample::default()
        };
        for (k, axis) in self.axes.iter().enumerate() {
            let i = axis.index();
            sample.command[i] = record.command[k];
            sample.drive[i] = output.drive[k];
            sample.feedback[i] = record.feedback[k];
            let correction = record.correction[k];
            sample.correction[i] =
                if axis.is_rotary() { correction.to_radians() * 1e6 } else { correction * 1e3 } as f32;
        }
        sample
    }

    /// The truth: three-axis programs in machine coordinates, the others in workpiece coordinates with the direction.
    fn measure(&self, setpoint: &Setpoint) -> Measured {
        let place = (setpoint.move_index, setpoint.u);
        let program = &self.scenario.program;
        if self.scenario.five_axis {
            let pose = self.plant.true_pose();
            let actual = Place { tip: DVec3::from(pose.tip_mm), direction: DVec3::from(pose.direction) };
            let found = truth::pose::deviation(program, &self.scenario.placement, place, &actual);
            return Measured { tip: found.tip, angle: found.angle };
        }
        let tip = DVec3::from(self.plant.true_tip());
        Measured { tip: truth::deviation(program, self.origin, place, tip), angle: 0.0 }
    }

    fn note_fault(&mut self, output: &Output<f64, f64, N>, moment: &Moment) {
        let fault = output.record.fault;
        if fault == Fault::None {
            return;
        }
        let cycle = moment.cycle;
        let axis = self.axes.get(usize::from(output.record.fault_axis)).copied().unwrap_or(Axis::X);
        let faults = &mut self.run.faults;
        if let Some(last) = faults.last_mut()
            && last.fault == fault
            && last.axis == axis
            && last.cycle + last.cycles == cycle
        {
            last.cycles += 1;
        } else if faults.len() < MOST_FAULT_SPANS {
            faults.push(FaultSpan { fault, axis, cycle, cycles: 1, line: moment.line });
        } else {
            self.run.more_faults += 1;
        }
    }

    fn finish(mut self) -> Run {
        let lengths = |tally: &Tally| ErrorSize { max_um: tally.max, rms_um: tally.rms() };
        let angles = |tally: &Tally| AngleSize { max_urad: tally.max, rms_urad: tally.rms() };
        self.run.error = lengths(&self.error);
        self.run.orientation = angles(&self.orientation);
        self.run.estimated = lengths(&self.estimated);
        self.run.estimated_orientation = angles(&self.estimated_orientation);
        self.run
    }
}
