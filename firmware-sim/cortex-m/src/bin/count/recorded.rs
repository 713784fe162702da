//! The whole step over a recording: bare, with a gauge, with all terms, and stage by stage.

use crate::arena::Arena;
use core::cell::RefCell;
use core::hint::black_box;
use cortex_m_semihosting::hprintln;
use trueaxis::contour::{Path, Reference};
use trueaxis::machine::ErrorModel;
use trueaxis::roundness::{Gauge, GaugeState, Probes};
use trueaxis::tcomp::Tcomp;
use trueaxis::{Axis, Config, GaugeRide, Input, Output, Real, ServoLoop, Stage, State};
use trueaxis_cortex_m::regions;
use trueaxis_cortex_m::timer::{Tally, instructions, now, timed};
use trueaxis_recording::{Integer, Recording};

const AXES: usize = 3;
const POINTS: usize = 1024;
const STAGES: [(Stage, &str); 5] = [
    (Stage::Sample, "sample"),
    (Stage::Compensation, "compensation"),
    (Stage::Contour, "contour"),
    (Stage::Output, "output"),
    (Stage::Telemetry, "telemetry"),
];

fn build<R: Real, P: Integer>(
    file: &Tcomp<'_>,
    model: ErrorModel,
    period_ns: u32,
    arena: &mut Arena,
) -> ServoLoop<'static, R, P, AXES> {
    let rows = |axis: Axis| file.table(axis);
    let mut settings = file.settings().clone();
    settings.compensation.model = model;
    let config = Config { machine: &settings, ..Config::of(file, period_ns) };
    let memory = arena.slice(config.requirement(rows), R::ZERO);
    match config.build(rows, memory) {
        Ok(servo) => servo,
        Err(error) => panic!("{}", error),
    }
}

/// A cycle about to run.
struct Cycle<'a, R: Real, P: Integer> {
    servo: &'a ServoLoop<'static, R, P, AXES>,
    all_terms: &'a ServoLoop<'static, R, P, AXES>,
    path: Path<'a, R, P>,
    reference: Reference<R>,
    input: Input<P, AXES>,
    probes: Probes<R>,
    gauge: &'a Gauge<R, POINTS>,
    memory: &'a RefCell<Memory<R, P>>,
}

/// Memory that a cycle changes: a state for each form of the step, and the output.
struct Memory<R: Real, P: Integer> {
    bare: State<R, P, AXES>,
    gauged: State<R, P, AXES>,
    watched: State<R, P, AXES>,
    volumetric: State<R, P, AXES>,
    gauge: GaugeState<R, POINTS>,
    output: Output<R, P, AXES>,
}

#[inline(never)]
fn nothing<R: Real, P: Integer>(cycle: &Cycle<'_, R, P>) -> u32 {
    let memory = &mut *cycle.memory.borrow_mut();
    black_box(&mut memory.output);
    0
}

#[inline(never)]
fn bare<R: Real, P: Integer>(cycle: &Cycle<'_, R, P>) -> u32 {
    let memory = &mut *cycle.memory.borrow_mut();
    let on = cycle.path.on(cycle.reference);
    cycle.servo.step_into(&mut memory.bare, &cycle.input, on, (), &mut memory.output);
    0
}

/// All terms of cubic tables.
#[inline(never)]
fn volumetric<R: Real, P: Integer>(cycle: &Cycle<'_, R, P>) -> u32 {
    let memory = &mut *cycle.memory.borrow_mut();
    let on = cycle.path.on(cycle.reference);
    cycle.all_terms.step_into(&mut memory.volumetric, &cycle.input, on, (), &mut memory.output);
    0
}

#[inline(never)]
fn gauged<R: Real, P: Integer>(cycle: &Cycle<'_, R, P>) -> u32 {
    let memory = &mut *cycle.memory.borrow_mut();
    let mut ride = GaugeRide::new(cycle.gauge, &mut memory.gauge, &cycle.probes);
    let on = cycle.path.on(cycle.reference);
    cycle.servo.step_into(&mut memory.gauged, &cycle.input, on, &mut ride, &mut memory.output);
    u32::from(ride.cycle().finished)
}

/// Ticks of each stage.
fn stages<R: Real, P: Integer>(cycle: &Cycle<'_, R, P>) -> [u32; STAGES.len()] {
    let memory = &mut *cycle.memory.borrow_mut();
    let mut ticks = [0; STAGES.len()];
    let mut last = now();
    let on = cycle.path.on(cycle.reference);
    cycle.servo.step_watched(&mut memory.watched, &cycle.input, on, (), &mut memory.output, |stage| {
        let at = now();
        ticks[stage as usize] = last.wrapping_sub(at);
        last = now();
    });
    ticks
}

/// Middle value of many counts.
struct Middle(&'static mut [u32]);

impl Middle {
    fn add(&mut self, count: u32) {
        let last = self.0.len() - 1;
        self.0[(count as usize).min(last)] += 1;
    }

    fn value(&self) -> usize {
        let half = self.0.iter().sum::<u32>() / 2;
        let mut below = 0;
        self.0
            .iter()
            .position(|count| {
                below += count;
                below > half
            })
            .unwrap_or(0)
    }
}

/// Counts the recording, the second tables in force from the cycle that asks for them.
pub fn all<R: Real, P: Integer>(scalar: &str, arena: &mut Arena) {
    let recording = match Recording::<AXES>::parse(regions::recording()) {
        Ok(recording) => recording,
        Err(error) => panic!("recording: {}", error),
    };
    let header = recording.header();
    let spans: &[_] = arena.collect(recording.path::<R, P>());
    let file = |bytes| match Tcomp::parse(bytes) {
        Ok(file) => file,
        Err(error) => panic!("tables: {}", error),
    };
    let (first, second) = (file(regions::tables_a()), file(regions::tables_b()));
    let Some(settings) = first.settings().roundness else { panic!("tables without a gauge") };
    let servo = build::<R, P>(&first, ErrorModel::Nine, header.period_ns, arena);
    let exchanged = build::<R, P>(&second, ErrorModel::Nine, header.period_ns, arena);
    let all_terms = build::<R, P>(&second, ErrorModel::Volumetric, header.period_ns, arena);
    let gauge = match Gauge::build(&settings, header.period_ns) {
        Ok(gauge) => arena.keep(gauge),
        Err(error) => panic!("{}", error),
    };
    let state = servo.start();
    let memory = arena.keep(RefCell::new(Memory {
        bare: state,
        gauged: state,
        watched: state,
        volumetric: state,
        gauge: GaugeState::new(),
        output: Output::none(),
    }));
    let mut whole = [(); 3].map(|()| Tally::default());
    let mut middle = [(); 3].map(|()| Middle(arena.slice(1 << 14, 0)));
    let mut parts = STAGES.map(|_| Tally::default());
    let mut worst_at = (0, 0);
    let mut evaluated = 0;
    let mut cycle = Cycle {
        servo: &servo,
        all_terms: &all_terms,
        path: Path::new(spans, 0, false),
        reference: Reference { span: 0, t: R::ZERO },
        input: Input::at_rest(header.period_ns),
        probes: Probes::default(),
        gauge,
        memory,
    };
    let frame = timed(nothing, &cycle).0;
    // Count between two readings in a row.
    let apart = {
        let first = now();
        first.wrapping_sub(now())
    };
    for number in 0..header.cycles {
        let Some(recorded) = recording.cycle(number) else { break };
        if header.exchange_at == Some(number) {
            cycle.servo = &exchanged;
        }
        (cycle.input, cycle.reference, cycle.probes) = (recorded.input(), recorded.place(), recorded.probes());
        let taken = [timed(bare, &cycle), timed(gauged, &cycle), timed(volumetric, &cycle)];
        evaluated += taken[1].1;
        for ((taken, _), (tally, middle)) in taken.into_iter().zip(whole.iter_mut().zip(&mut middle)) {
            tally.add(taken - frame);
            middle.add(taken - frame);
        }
        worst_at = worst_at.max((taken[0].0 - frame, number));
        for (ticks, part) in stages(&cycle).into_iter().zip(&mut parts) {
            part.add(instructions(ticks.saturating_sub(apart)));
        }
    }
    hprintln!("{} step typical {} {}", scalar, middle[0].value(), whole[0]);
    hprintln!("{} step_gauge typical {} {}", scalar, middle[1].value(), whole[1]);
    hprintln!("{} step_volumetric typical {} {}", scalar, middle[2].value(), whole[2]);
    for ((_, name), part) in STAGES.iter().zip(&parts) {
        hprintln!("{} stage_{} {}", scalar, name, part);
    }
    hprintln!("{} recording cycles {} worst_at {} revolutions {}", scalar, header.cycles, worst_at.1, evaluated);
    hprintln!("{} state bytes {}", scalar, size_of::<State<R, P, AXES>>());
}
