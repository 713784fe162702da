//! The counted forms of the step: bare, with a gauge, with all terms, and stage by stage.

use crate::arena::Arena;
use core::cell::RefCell;
use core::hint::black_box;
use trueaxis::contour::{Path, Reference};
use trueaxis::machine::{ErrorModel, MachineSettings};
use trueaxis::roundness::{Gauge, GaugeState, Probes};
use trueaxis::tcomp::Tcomp;
use trueaxis::{Axis, Config, GaugeRide, Input, Output, Real, ServoLoop, Stage, State};
use trueaxis_cortex_m::regions;
use trueaxis_cortex_m::timer::{instructions, now, timed};
use trueaxis_recording::Integer;

/// Number of axes.
pub const AXES: usize = 3;
const POINTS: usize = 1024;
/// Stages and their names in the counts.
pub const STAGES: [(Stage, &str); 5] = [
    (Stage::Sample, "sample"),
    (Stage::Compensation, "compensation"),
    (Stage::Contour, "contour"),
    (Stage::Output, "output"),
    (Stage::Telemetry, "telemetry"),
];
/// Forms of the whole step.
pub const FORMS: usize = 3;

type Form<R, P> = fn(&PreparedCycle<'_, R, P>) -> u32;
/// A servo loop on tables in flash.
pub type Loop<R, P> = ServoLoop<'static, R, P, AXES>;

/// The immutable data of all cycles: the tables in force from the start and those exchanged for them.
pub struct Machine<R: Real, P: Integer> {
    nine: [Loop<R, P>; 2],
    all_terms: [Loop<R, P>; 2],
    gauge: &'static Gauge<R, POINTS>,
    memory: RefCell<Memory<R, P>>,
    /// Instructions of an empty call, and ticks between two consecutive readings of the timer.
    frame: u32,
    apart: u32,
}

/// Memory that a cycle modifies: a state for each form of the step, and the output.
struct Memory<R: Real, P: Integer> {
    bare: State<R, P, AXES>,
    gauged: State<R, P, AXES>,
    watched: State<R, P, AXES>,
    volumetric: State<R, P, AXES>,
    gauge: GaugeState<R, POINTS>,
    output: Output<R, P, AXES>,
}

/// A cycle about to run.
pub struct PreparedCycle<'a, R: Real, P: Integer> {
    machine: &'a Machine<R, P>,
    /// Whether the second tables are in force: for the nine terms, and for all terms.
    pub exchanged: bool,
    pub all_exchanged: bool,
    /// The path.
    pub path: Path<'a, R, P>,
    /// Reference on the path.
    pub reference: Reference<R>,
    /// Input of the step.
    pub input: Input<P, AXES>,
    /// Input of the gauge.
    pub probes: Probes<R>,
}

/// Builds a loop on the tables of a file after changing its settings.
pub fn build<R: Real, P: Integer>(
    file: &Tcomp<'static>,
    change: impl FnOnce(&mut MachineSettings),
    period_ns: u32,
    arena: &mut Arena,
) -> Loop<R, P> {
    let rows = |axis: Axis| file.table(axis);
    let mut settings = file.settings().clone();
    change(&mut settings);
    let config = Config { machine: &settings, ..Config::of(file, period_ns) };
    let memory = arena.slice(config.requirement(rows), R::ZERO);
    match config.build(rows, memory) {
        Ok(servo) => servo,
        Err(error) => panic!("{}", error),
    }
}

/// The table files in flash.
pub fn files() -> [Tcomp<'static>; 2] {
    [regions::tables_a(), regions::tables_b()].map(|bytes| match Tcomp::parse(bytes) {
        Ok(file) => file,
        Err(error) => panic!("tables: {}", error),
    })
}

impl<R: Real, P: Integer> Machine<R, P> {
    /// Builds the machine from the table files in flash.
    pub fn flashed(period_ns: u32, arena: &mut Arena) -> &'static Self {
        let files = files();
        let mut both = |model| {
            [0, 1].map(|k| build::<R, P>(&files[k], |settings| settings.compensation.model = model, period_ns, arena))
        };
        let (nine, all_terms) = (both(ErrorModel::Nine), both(ErrorModel::Volumetric));
        let Some(settings) = files[0].settings().roundness else { panic!("tables without a gauge") };
        let gauge = match Gauge::build(&settings, period_ns) {
            Ok(gauge) => arena.keep(gauge),
            Err(error) => panic!("{}", error),
        };
        let (state, volumetric, gauge_state) = (nine[0].start(), all_terms[0].start(), GaugeState::new());
        let memory = Memory {
            bare: state,
            gauged: state,
            watched: state,
            volumetric,
            gauge: gauge_state,
            output: Output::none(),
        };
        let machine = arena.keep(Machine { nine, all_terms, gauge, memory: RefCell::new(memory), frame: 0, apart: 0 });
        machine.apart = {
            let first = now();
            first.wrapping_sub(now())
        };
        machine.frame = timed(nothing, &machine.cycle(Path::new(&[], 0, false), period_ns)).0;
        machine
    }

    /// A cycle at rest.
    pub fn cycle<'a>(&'a self, path: Path<'a, R, P>, period_ns: u32) -> PreparedCycle<'a, R, P> {
        PreparedCycle {
            machine: self,
            exchanged: false,
            all_exchanged: false,
            path,
            reference: Reference { span: 0, t: R::ZERO },
            input: Input::at_rest(period_ns),
            probes: Probes::default(),
        }
    }

    /// A fresh state of the nine-term form.
    pub fn start(&self) -> State<R, P, AXES> {
        self.nine[0].start()
    }

    /// Resets all states.
    pub fn restart(&self) {
        let memory = &mut *self.memory.borrow_mut();
        let state = self.start();
        (memory.bare, memory.gauged, memory.watched) = (state, state, state);
        memory.volumetric = self.all_terms[0].start();
        self.gauge.restart(&mut memory.gauge);
    }

    /// The state of the bare form.
    pub fn bare_state(&self) -> State<R, P, AXES> {
        self.memory.borrow().bare
    }

    /// Replaces it.
    pub fn set_bare_state(&self, state: &State<R, P, AXES>) {
        self.memory.borrow_mut().bare = *state;
    }

    /// Applies a change to the states of all forms.
    pub fn each_state(&self, mut change: impl FnMut(&mut State<R, P, AXES>)) {
        let memory = &mut *self.memory.borrow_mut();
        let states = [&mut memory.bare, &mut memory.gauged, &mut memory.watched, &mut memory.volumetric];
        states.into_iter().for_each(&mut change);
    }

    /// The output of the latest cycle.
    pub fn output(&self) -> Output<R, P, AXES> {
        self.memory.borrow().output
    }
}

impl<R: Real, P: Integer> PreparedCycle<'_, R, P> {
    /// Runs the forms of the step in turn; returns their instructions and the number of revolutions evaluated. `seen` gets the
    /// number of each form and its output.
    pub fn count(&self, mut seen: impl FnMut(usize, &Output<R, P, AXES>)) -> ([u32; FORMS], u32) {
        let mut revolutions = 0;
        let mut counts = [0; FORMS];
        let forms: [Form<R, P>; FORMS] = [bare, gauged, volumetric];
        for (number, (form, count)) in forms.into_iter().zip(&mut counts).enumerate() {
            let (taken, finished) = timed(form, self);
            revolutions += finished;
            seen(number, &self.machine.memory.borrow().output);
            *count = taken - self.machine.frame;
        }
        (counts, revolutions)
    }

    /// Runs only the bare form; returns its instructions.
    pub fn count_bare(&self) -> u32 {
        timed(bare, self).0 - self.machine.frame
    }

    /// Runs the step stage by stage; returns the instructions of each, without those of reading the timer.
    pub fn stages(&self) -> [u32; STAGES.len()] {
        stages(self).map(|ticks| instructions(ticks.saturating_sub(self.machine.apart)))
    }

    fn servo(&self) -> &Loop<R, P> {
        &self.machine.nine[usize::from(self.exchanged)]
    }
}

#[inline(never)]
fn nothing<R: Real, P: Integer>(cycle: &PreparedCycle<'_, R, P>) -> u32 {
    let memory = &mut *cycle.machine.memory.borrow_mut();
    black_box((&mut memory.output, cycle.servo()));
    0
}

#[inline(never)]
fn bare<R: Real, P: Integer>(cycle: &PreparedCycle<'_, R, P>) -> u32 {
    let memory = &mut *cycle.machine.memory.borrow_mut();
    let on = cycle.path.on(cycle.reference);
    cycle.servo().step_into(&mut memory.bare, &cycle.input, on, (), &mut memory.output);
    0
}

#[inline(never)]
fn volumetric<R: Real, P: Integer>(cycle: &PreparedCycle<'_, R, P>) -> u32 {
    let memory = &mut *cycle.machine.memory.borrow_mut();
    let servo = &cycle.machine.all_terms[usize::from(cycle.all_exchanged)];
    let on = cycle.path.on(cycle.reference);
    servo.step_into(&mut memory.volumetric, &cycle.input, on, (), &mut memory.output);
    0
}

#[inline(never)]
fn gauged<R: Real, P: Integer>(cycle: &PreparedCycle<'_, R, P>) -> u32 {
    let memory = &mut *cycle.machine.memory.borrow_mut();
    let mut ride = GaugeRide::new(cycle.machine.gauge, &mut memory.gauge, &cycle.probes);
    let on = cycle.path.on(cycle.reference);
    cycle.servo().step_into(&mut memory.gauged, &cycle.input, on, &mut ride, &mut memory.output);
    u32::from(ride.cycle().finished)
}

/// Ticks of each stage.
#[inline(never)]
fn stages<R: Real, P: Integer>(cycle: &PreparedCycle<'_, R, P>) -> [u32; STAGES.len()] {
    let memory = &mut *cycle.machine.memory.borrow_mut();
    let mut ticks = [0; STAGES.len()];
    let mut last = now();
    let on = cycle.path.on(cycle.reference);
    cycle.servo().step_watched(&mut memory.watched, &cycle.input, on, (), &mut memory.output, |stage| {
        let at = now();
        ticks[stage as usize] = last.wrapping_sub(at);
        last = now();
    });
    ticks
}
