//! The whole step over adversarial cycles: the dearest of a hundred thousand, and a digest of all outputs.

use crate::arena::Arena;
use crate::forms::{Cycle, FORMS, Machine, STAGES};
use crate::middle::Middle;
use crate::recorded;
use cortex_m_semihosting::{hprint, hprintln};
use trueaxis_cortex_m::timer::Tally;
use trueaxis_recording::Integer;
use trueaxis_recording::adversary::{Adversary, COURSES, CYCLES, Course, Digest, Moment, SCENE};
use trueaxis_recording::outputs::Wire;

/// Names of the forms of the step in the counts.
const NAMES: [&str; FORMS] = ["adversarial", "adversarial_gauge", "adversarial_volumetric"];
/// Kinds of courses.
const KINDS: [&str; 8] =
    ["corners", "hairpins", "short_spans", "racetrack", "rational", "helix_quintic", "cusps", "small_circle"];
/// Dearest cycles that are listed, for the host to count.
const DEAREST: usize = 256;

/// The dearest cycles of one form, unordered.
struct Dearest {
    kept: [(u32, u32); DEAREST],
    least: usize,
}

impl Dearest {
    fn add(&mut self, count: u32, cycle: u32) {
        if count <= self.kept[self.least].0 {
            return;
        }
        self.kept[self.least] = (count, cycle);
        let smallest = self.kept.iter().enumerate().min_by_key(|(_, kept)| **kept);
        self.least = smallest.map_or(0, |(place, _)| place);
    }

    fn worst(&self) -> u32 {
        self.kept.iter().max_by_key(|(count, cycle)| (*count, u32::MAX - cycle)).map_or(0, |(_, cycle)| *cycle)
    }
}

/// The courses, and a cycle on them.
struct Run<'a, R: Wire<Place = P>, P: Integer> {
    machine: &'a Machine<R, P>,
    courses: &'a [Course<R, P>],
    adversary: Adversary<'a, R, P>,
}

impl<'a, R: Wire<Place = P>, P: Integer> Run<'a, R, P> {
    fn new(machine: &'a Machine<R, P>, arena: &mut Arena) -> Self {
        let courses: &[_] = arena.collect((0..COURSES).map(Course::new));
        Run { machine, courses, adversary: Adversary::new(courses, recorded::recording().header().period_ns) }
    }

    /// Draws cycle `number` and prepares the states for it.
    fn draw(&mut self, number: u32) -> (Moment<R, P>, Cycle<'a, R, P>) {
        let moment = self.adversary.cycle(number);
        if moment.cold {
            self.machine.restart();
        }
        if let Some((slot, line)) = moment.thermal {
            self.machine.each_state(|state| state.set_thermal(slot, line));
        }
        let mut cycle = self.machine.cycle(self.courses[moment.course].path(), moment.input.elapsed_ns);
        (cycle.input, cycle.reference, cycle.probes) = (moment.input, moment.reference, moment.probes);
        (cycle.exchanged, cycle.all_exchanged) = (moment.exchanged, moment.exchanged);
        (moment, cycle)
    }
}

/// Counts all of them.
pub fn all<R: Wire<Place = P>, P: Integer>(scalar: &str, machine: &Machine<R, P>, arena: &mut Arena) {
    let mut run = Run::new(machine, arena);
    let mut tallies = [(); FORMS].map(|()| Tally::default());
    let mut middle = [(); FORMS].map(|()| Middle::new(arena));
    let mut dearest = [(); FORMS].map(|()| Dearest { kept: [(0, 0); DEAREST], least: 0 });
    let mut kinds = KINDS.map(|_| Tally::default());
    let mut digests = [(); FORMS].map(|()| Digest::default());
    for number in 0..CYCLES {
        let (moment, cycle) = run.draw(number);
        let (counts, _) = cycle.count(|form, output| digests[form].add(output));
        kinds[moment.course % KINDS.len()].add(counts[0]);
        for (form, count) in counts.into_iter().enumerate() {
            tallies[form].add(count);
            middle[form].add(count, number);
            dearest[form].add(count, number);
        }
    }
    for (form, name) in NAMES.into_iter().enumerate() {
        let typical = middle[form].value();
        hprintln!("{} {} typical {} {} at {}", scalar, name, typical, tallies[form], dearest[form].worst());
    }
    for (name, tally) in KINDS.iter().zip(&kinds) {
        hprintln!("{} adversarial_{} {}", scalar, name, tally);
    }
    let [bare, gauged, volumetric] = digests.map(Digest::value);
    hprintln!("{} digests of {} cycles: {:08x} {:08x} {:08x}", scalar, CYCLES, bare, gauged, volumetric);
    hprint!("{} dearest", scalar);
    dearest[0].kept.sort_unstable_by_key(|(count, cycle)| (u32::MAX - count, *cycle));
    for (_, cycle) in dearest[0].kept {
        hprint!(" {}", cycle);
    }
    hprintln!();
    let worst = dearest[0].worst();
    replay(scalar, machine, worst, arena);
}

/// Runs the scene of a cycle up to it, and prints its inputs, what it found and its stages.
pub fn replay<R: Wire<Place = P>, P: Integer>(scalar: &str, machine: &Machine<R, P>, number: u32, arena: &mut Arena) {
    let mut run = Run::new(machine, arena);
    let mut last = None;
    for at in number / SCENE * SCENE..=number {
        let (moment, cycle) = run.draw(at);
        let stages = cycle.stages();
        last = Some((moment, stages, cycle.count_bare()));
    }
    let Some((moment, stages, taken)) = last else { return };
    let record = machine.output().record;
    hprintln!("{} replay cycle {} instructions {} events: {}", scalar, number, taken, moment.events);
    hprint!("{} replay stages", scalar);
    for ((_, name), taken) in STAGES.iter().zip(stages) {
        hprint!(" {} {}", name, taken);
    }
    hprintln!();
    let evaluations = (record.tip.evaluations, record.encoder.evaluations);
    hprintln!(
        "{} replay found: fault {:?}, evaluations {:?}, limited {}",
        scalar,
        record.fault,
        evaluations,
        record.limited
    );
    hprintln!("{} replay inputs: {:?}", scalar, moment);
}
