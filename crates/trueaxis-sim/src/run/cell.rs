//! Plugin and machine of one run.

use super::Driven;
use super::commanded::Commanded;
use super::kind::Kind;
use super::plugin::About;
use super::sample::{Given, Sample, Sink};
use super::tally::{Sums, Tallies};
use crate::error::Result;
use crate::event::Switch;
use crate::motion::Setpoint;
use crate::path::SlidingPath;
use crate::placement::Place;
use crate::plant::Plant;
use crate::plant::fault::{Fault as PlantFault, FaultScript};
use crate::scenario::Scenario;
use crate::servo::{Axes, Compiled, step};
use crate::truth::{self, Truth};
use glam::DVec3;
use trueaxis::compensation::ThermalLine;
use trueaxis::contour::OrientationError;
use trueaxis::kinematics::Kinematics;
use trueaxis::machine::{AXES, AxisOrder};
use trueaxis::sample::Refusal;
use trueaxis::{Axis, Conditions, Dynamics, Fault, Input, OnToolPath, Output, ServoLoop, State};

/// Cycles still simulated after a stop, to show that the output holds.
const CYCLES_AFTER_STOP: u64 = 200;

/// Data that the machines of a run share in a cycle.
pub(super) struct Shared<'r, const N: usize> {
    pub(super) scenario: &'r Scenario,
    pub(super) servo: &'r ServoLoop<'r, f64, f64, N>,
    pub(super) path: &'r SlidingPath,
}

/// Outputs of the step.
pub(super) struct Stepped<const N: usize> {
    pub(super) output: Output<f64, f64, N>,
    pub(super) orientation: OrientationError<f64>,
}

/// True error in a cycle.
pub(super) struct Measured<const N: usize> {
    pub(super) tip: DVec3,
    pub(super) angle: f64,
    /// Traversed share of the lost motion of each axis.
    pub(super) reverse: [f64; N],
}

/// State of one machine and of the plugin that drives it.
pub(super) struct Cell<const N: usize> {
    pub(super) state: State<f64, f64, N>,
    plant: Plant,
    /// Index in the step's order for each of the machine's axes.
    order: Vec<Option<usize>>,
    pub(super) axes: [Axis; N],
    /// Number of slots that are not spare.
    used: usize,
    kind: Kind,
    origin: DVec3,
    truth: Truth,
    /// For programs with rotary axes.
    pub(super) kinematics: Option<Kinematics<f64>>,
    /// Thermal growth passed to the plugin.
    thermal: [ThermalLine<f64>; N],
    /// Switches of the plugin; on an uncompensated machine it is off whatever they say.
    enabled: bool,
    dynamics: Dynamics,
    feedback: [f64; N],
    elapsed_periods: f64,
    stopped_for: u64,
    sums: Sums,
}

impl<const N: usize> Cell<N>
where
    Axes: Compiled<N>,
{
    pub(super) fn new(
        scenario: &Scenario,
        (kind, drives): Driven,
        servo: &ServoLoop<'_, f64, f64, N>,
        about: &About<N>,
    ) -> Result<Self> {
        let slots = AxisOrder::<N>::with_spare_slots(&scenario.machine.settings)?;
        let axes = slots.axes();
        let perfect = kind == Kind::ServoOnly;
        let mut settings = scenario.settings.plant(scenario.kelvin);
        settings.drives = drives.unwrap_or(settings.drives);
        if perfect {
            settings.faults = FaultScript::default();
        }
        let plant = Plant::new(&scenario.machine, settings, perfect, scenario.settings.seed, scenario.period_s())?;
        let order = scenario.machine.settings.axes.iter().map(|own| slots.slot(own.axis)).collect();
        let mut cell = Cell {
            state: servo.start(),
            plant,
            order,
            axes,
            used: scenario.machine.settings.step_axes().count(),
            kind,
            origin: DVec3::from(scenario.origin_mm),
            truth: Truth::default(),
            kinematics: None,
            thermal: about.thermal,
            enabled: kind.enables_the_plugin(),
            dynamics: Dynamics::ALL,
            feedback: [0.0; N],
            elapsed_periods: 1.0,
            stopped_for: 0,
            sums: Sums::default(),
        };
        cell.take_over(about);
        Ok(cell)
    }

    /// Takes over the data of a new servo loop, but keeps the state, so that the limiter ramps to the new correction.
    pub(super) fn take_over(&mut self, about: &About<N>) {
        for (slot, line) in about.thermal.iter().enumerate() {
            self.state.set_thermal(slot, *line).expect("a slot of the step");
        }
        self.kinematics = about.kinematics;
        self.thermal = about.thermal;
    }

    /// Switches the plugin or a part of it, on a machine that is driven with it.
    pub(super) fn switch(&mut self, what: Switch, on: bool) {
        match what {
            Switch::Correction => self.enabled = on && self.kind.enables_the_plugin(),
            Switch::Part(part) if on => self.dynamics = Dynamics(self.dynamics.0 | part.0),
            Switch::Part(part) => self.dynamics = self.dynamics.without(part),
            Switch::Adaptation => self.state.freeze_friction(!on),
        }
    }

    /// Returns the friction that adapts to the identified figures.
    pub(super) fn reset_adaptation(&mut self) {
        self.state.reset_friction();
    }

    /// Injects a fault from now on, on a machine that has faults.
    ///
    /// # Errors
    /// The fault names an axis that the machine does not have.
    pub(super) fn inject(&mut self, fault: PlantFault) -> Result<()> {
        match self.kind {
            Kind::ServoOnly => Ok(()),
            _ => Ok(self.plant.inject(fault)?),
        }
    }

    pub(super) fn kind(&self) -> Kind {
        self.kind
    }

    pub(super) fn has_ended(&self) -> bool {
        self.stopped_for > CYCLES_AFTER_STOP
    }

    /// Rests on the first point until the correction has ramped in, as a machine that is switched on before it cuts.
    pub(super) fn settle(&mut self, number: usize, first: &Commanded, shared: &Shared<'_, N>, sink: &mut dyn Sink) {
        self.feedback = self.to_step(first);
        self.plant.rest_at(&self.to_plant(&self.feedback));
        self.plant.hold_faults();
        let limits = shared.scenario.machine.settings.axes.iter().map(|a| a.limits);
        let slowest =
            limits.map(|l| l.magnitude / l.slope_per_s + l.slope_per_s / l.acceleration_per_s2).fold(0.0, f64::max);
        for _ in 0..(1.2 * slowest.min(2.0) * shared.scenario.rate_hz()) as u64 {
            self.exchange((number, true), first, shared, sink);
        }
        self.plant.start_faults();
    }

    /// One servo period: plugin, then drives and encoders.
    fn exchange(
        &mut self,
        (machine, settling): (usize, bool),
        commanded: &Commanded,
        shared: &Shared<'_, N>,
        sink: &mut dyn Sink,
    ) -> Stepped<N> {
        let mut command = self.to_step(commanded);
        let mut disturbed = self.to_plant(&command);
        self.plant.disturb_command(&mut disturbed);
        self.take_from_plant(&disturbed, &mut command);
        let elapsed_ns = (self.elapsed_periods * f64::from(shared.scenario.period_ns())) as u32;
        let input = Input {
            command,
            feedback: self.feedback,
            encoder_alarm: 0,
            elapsed_ns,
            homed: true,
            enable: self.enabled,
            reset: false,
            refusal: Refusal::NONE,
            dynamics: self.dynamics,
            learned: self.learned(commanded, shared.scenario),
        };
        let (path, tool_path) = (shared.path.view(), shared.path.tool_view());
        let reference = commanded.reference;
        let Input { command, feedback, .. } = &input;
        sink.before_step(&Given { machine, settling, command, feedback, elapsed_ns, reference });
        let stepped = match &self.kinematics {
            Some(kinematics) => {
                let mut on = OnToolPath::new(&tool_path, reference, kinematics);
                let output = step(shared.servo, &mut self.state, &input, &mut &mut on, &mut ());
                Stepped { output, orientation: *on.orientation() }
            }
            None => {
                let output = step(shared.servo, &mut self.state, &input, &mut path.on(reference), &mut ());
                Stepped { output, orientation: OrientationError::none() }
            }
        };
        sink.after_step();
        let readings = self.plant.cycle(&self.to_plant(&stepped.output.drive));
        let mut feedback = self.feedback;
        self.take_from_plant(&readings.position, &mut feedback);
        self.feedback = feedback;
        self.elapsed_periods = readings.elapsed_periods;
        stepped
    }

    /// Input from the host: the learned correction at the path length of the reference.
    fn learned(&self, commanded: &Commanded, scenario: &Scenario) -> [f64; 3] {
        let table = scenario.learned.as_ref().filter(|_| self.kind.takes_what_was_learned());
        table.map_or([0.0; 3], |table| table.table().at(commanded.moment.length_mm))
    }

    /// The command in the step's order.
    fn to_step(&self, commanded: &Commanded) -> [f64; N] {
        self.axes.map(|axis| commanded.positions[axis.index()])
    }

    /// Converts positions from the step's order to the plant's, which is the machine's list of axes.
    fn to_plant(&self, positions: &[f64; N]) -> [f64; AXES] {
        let mut plant = [0.0; AXES];
        for (to, slot) in plant.iter_mut().zip(&self.order) {
            *to = slot.and_then(|s| positions.get(s)).copied().unwrap_or(0.0);
        }
        plant
    }

    fn take_from_plant(&self, plant: &[f64; AXES], positions: &mut [f64; N]) {
        for (from, slot) in plant.iter().zip(&self.order) {
            if let Some(to) = slot.and_then(|s| positions.get_mut(s)) {
                *to = *from;
            }
        }
    }

    pub(super) fn cycle(
        &mut self,
        number: usize,
        commanded: &Commanded,
        shared: &Shared<'_, N>,
        sink: &mut dyn Sink,
    ) -> Sample {
        let running = self.stopped_for == 0;
        let stepped = self.exchange((number, false), commanded, shared, sink);
        self.sums.digest.add_axes(&stepped.output, self.used);
        let record = &stepped.output.record;
        if stepped.output.stop_requested() {
            self.sums.stopped = true;
            self.stopped_for += 1;
        }
        let measured = self.measure(shared.scenario, &commanded.setpoint);
        if commanded.moment.cutting && running {
            self.add(&measured, &stepped);
        }
        if record.limited != 0 {
            self.sums.limited_cycles += 1;
            self.clip(&record.correction, commanded, shared);
        }
        if record.fault != Fault::None {
            let axis = self.axes.get(usize::from(record.fault_axis)).copied().unwrap_or(Axis::X);
            self.sums.fault(record.fault, axis, &commanded.moment);
        }
        self.sums.withdrawals.add(record.status, &commanded.moment);
        let sample = self.sample(&measured, &stepped, shared.servo);
        self.sums.friction = sample.friction;
        sample
    }

    /// Adds up how much the magnitude limits cut off, once a correction reaches one.
    fn clip(&mut self, sent: &[f64; N], commanded: &Commanded, shared: &Shared<'_, N>) {
        let settings = &shared.scenario.machine.settings;
        let limit = |axis: Axis| settings.axis(axis).map_or(f64::INFINITY, |own| own.limits.magnitude);
        if self.axes.iter().zip(sent).all(|(axis, sent)| sent.abs() < 0.999 * limit(*axis)) {
            return;
        }
        let conditions = Conditions { thermal: self.thermal, ..Conditions::default() };
        if let Ok(wanted) = shared.servo.correction_at(&self.to_step(commanded), &conditions) {
            let mut all = [0.0; AXES];
            for (axis, wanted) in self.axes.iter().zip(wanted) {
                all[axis.index()] = wanted;
            }
            self.sums.clipped.add(settings, &commanded.positions, &all);
        }
    }

    fn add(&mut self, measured: &Measured<N>, stepped: &Stepped<N>) {
        let Stepped { output, orientation } = stepped;
        self.sums.error.add((1e3 * measured.tip).length());
        self.sums.orientation.add(1e6 * measured.angle);
        if output.record.tip.is_measured() {
            self.sums.estimated.add(1e3 * output.record.tip.error);
        }
        if orientation.is_measured() {
            self.sums.estimated_orientation.add(1e6 * orientation.angle);
        }
    }

    /// The true error: in machine coordinates for three-axis programs, otherwise in workpiece coordinates and with the
    /// direction.
    fn measure(&mut self, scenario: &Scenario, setpoint: &Setpoint) -> Measured<N> {
        let mut reverse = [0.0; N];
        self.take_from_plant(&self.plant.reversal(), &mut reverse);
        let reference = (setpoint.move_index, setpoint.u);
        let program = &scenario.program;
        if scenario.five_axis {
            let pose = self.plant.true_pose();
            let actual = Place { tip: DVec3::from(pose.tip_mm), direction: DVec3::from(pose.direction) };
            let found = truth::pose::deviation(program, &scenario.placement, reference, &actual);
            return Measured { tip: found.tip, angle: found.angle, reverse };
        }
        let tip = DVec3::from(self.plant.true_tip());
        let here = DVec3::from(setpoint.position);
        Measured { tip: self.truth.deviation(program, self.origin, reference, here, tip), angle: 0.0, reverse }
    }

    pub(super) fn tallies(&self) -> Tallies {
        self.sums.tallies()
    }
}
