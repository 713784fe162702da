//! The step with dynamic correction or with periods: instructions over the recording, and a digest over adversarial cycles.

use crate::arena::Arena;
use crate::forms::{AXES, Loop, build, files};
use crate::middle::Middle;
use crate::recorded::recording;
use core::cell::RefCell;
use core::hint::black_box;
use cortex_m_semihosting::hprintln;
use trueaxis::contour::{Path, Reference};
use trueaxis::machine::{Axis, MachineSettings, PeriodicSettings};
use trueaxis::{Input, Output, Real, State};
use trueaxis_cortex_m::timer::{Tally, timed};
use trueaxis_recording::Integer;
use trueaxis_recording::adversary::{Adversary, COURSES, Course, DYNAMIC_CYCLES, Digest, ServoParts, vary};
use trueaxis_recording::outputs::Wire;

/// Changes the settings of a machine.
type Configure = fn(&mut MachineSettings);

/// Configurations and their names in the counts: friction on three axes, with feedback, with everything.
const CONFIGURED: [(Configure, &str); 3] = [
    (|machine| ServoParts::Friction.configure(machine), "step_friction"),
    (|machine| ServoParts::Feedback.configure(machine), "step_feedback"),
    (|machine| ServoParts::All.configure(machine), "step_dynamic"),
];

/// A screw of 5 mm with an error of 3 µm and its second harmonic on every linear axis.
fn screws(machine: &mut MachineSettings) {
    for axis in [Axis::X, Axis::Y, Axis::Z] {
        let harmonics = [[1.9e-3, -2.2e-3], [0.0, 0.8e-3]].into_iter().collect();
        // Six fit.
        let _ = machine.periodic.push(PeriodicSettings { axis, period: 5.0, harmonics, reverse: Default::default() });
    }
}

/// A cycle about to run.
struct DynamicCycle<'a, R: Real, P: Integer> {
    servo: &'a Loop<R, P>,
    memory: RefCell<(State<R, P, AXES>, Output<R, P, AXES>)>,
    path: Path<'a, R, P>,
    reference: Reference<R>,
    input: Input<P, AXES>,
}

#[inline(never)]
fn nothing<R: Real, P: Integer>(cycle: &DynamicCycle<'_, R, P>) -> u32 {
    let (_, output) = &mut *cycle.memory.borrow_mut();
    black_box((output, cycle.servo));
    0
}

#[inline(never)]
fn step<R: Real, P: Integer>(cycle: &DynamicCycle<'_, R, P>) -> u32 {
    let (state, output) = &mut *cycle.memory.borrow_mut();
    let on = cycle.path.on(cycle.reference);
    cycle.servo.step_into(state, &cycle.input, on, (), output);
    0
}

/// Builds the loops on the tables in force from the start and on those exchanged for them.
fn loops<R: Real, P: Integer>(configure: Configure, arena: &mut Arena) -> &'static [Loop<R, P>; 2] {
    let period_ns = recording().header().period_ns;
    let loops = files().map(|file| build(&file, configure, period_ns, arena));
    arena.keep(loops)
}

/// Counts the recording with dynamic parts.
pub fn recorded<R: Real, P: Integer>(scalar: &str, arena: &mut Arena) {
    record::<R, P>(scalar, &CONFIGURED, arena);
}

/// Counts the recording with a screw on each axis.
pub fn periodic<R: Real, P: Integer>(scalar: &str, arena: &mut Arena) {
    record::<R, P>(scalar, &[(screws, "step_periodic")], arena);
}

fn record<R: Real, P: Integer>(scalar: &str, configured: &[(Configure, &str)], arena: &mut Arena) {
    let recording = recording();
    let header = recording.header();
    let spans: &[_] = arena.collect(recording.path::<R, P>());
    for (configure, name) in configured {
        let loops = loops::<R, P>(*configure, arena);
        let (mut whole, mut middle) = (Tally::default(), Middle::new(arena));
        let mut cycle = DynamicCycle {
            servo: &loops[0],
            memory: RefCell::new((loops[0].start(), Output::none())),
            path: Path::new(spans, 0, false),
            reference: Reference { span: 0, t: R::ZERO },
            input: Input::at_rest(header.period_ns),
        };
        let frame = timed(nothing, &cycle).0;
        for number in 0..header.cycles {
            let Some(recorded) = recording.cycle(number) else { break };
            if header.exchange_at == Some(number) {
                cycle.servo = &loops[1];
            }
            (cycle.input, cycle.reference) = (recorded.input(), recorded.place());
            let taken = timed(step, &cycle).0 - frame;
            whole.add(taken);
            middle.add(taken, number);
        }
        hprintln!("{} {} typical {} {}", scalar, name, middle.value(), whole);
    }
}

/// Digest of adversarial cycles with every part, switched in motion.
pub fn adversarial<R: Wire<Place = P>, P: Integer>(scalar: &str, arena: &mut Arena) {
    let loops = loops::<R, P>(|machine| ServoParts::All.configure(machine), arena);
    let courses: &[_] = arena.collect((0..COURSES).map(Course::<R, P>::new));
    let mut adversary = Adversary::new(courses, recording().header().period_ns);
    let (mut state, mut digest) = (loops[0].start(), Digest::default());
    for number in 0..DYNAMIC_CYCLES {
        let mut moment = adversary.cycle(number);
        if moment.cold {
            state = loops[0].start();
        }
        if let Some((slot, line)) = moment.thermal {
            state.set_thermal(slot, line).expect("a slot of the step");
        }
        vary(&mut moment.input, number);
        let on = courses[moment.course].path().on(moment.reference);
        digest.add(&loops[usize::from(moment.exchanged)].step(&mut state, &moment.input, on, ()));
    }
    hprintln!("{} dynamic digest of {} cycles: {:08x}", scalar, DYNAMIC_CYCLES, digest.value());
}
