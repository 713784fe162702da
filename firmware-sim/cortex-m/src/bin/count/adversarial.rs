//! The whole step over adversarial cycles: the most expensive of a hundred thousand, and a digest of all outputs.

use crate::arena::Arena;
use crate::climb;
use crate::forms::{FORMS, Machine, PreparedCycle, STAGES};
use crate::middle::Middle;
use crate::recorded;
use cortex_m_semihosting::{hprint, hprintln};
use trueaxis::contour::Flags;
use trueaxis::telemetry::Status;
use trueaxis_cortex_m::timer::Tally;
use trueaxis_recording::Integer;
use trueaxis_recording::adversary::{Adversary, COURSES, CYCLES, Course, Digest, Events, Moment, SCENE};
use trueaxis_recording::outputs::Wire;

/// Names of the forms of the step in the counts.
const NAMES: [&str; FORMS] = ["adversarial", "adversarial_gauge", "adversarial_volumetric"];
/// Kinds of courses.
const KINDS: [&str; 8] =
    ["corners", "hairpins", "short_spans", "racetrack", "rational", "helix_quintic", "cusps", "small_circle"];
/// Conditions that the cycles meet, counted so that the cycles do not become easier unnoticed.
const MET: [&str; 6] = ["active", "frozen", "stopped", "limited", "bracketed", "undisturbed"];
/// Number of most expensive cycles that are listed for the host to count.
const DEAREST: usize = 256;

/// The most expensive cycles of one form, unordered.
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

/// The courses and the adversary that drives on them.
pub struct Run<'a, R: Wire<Place = P>, P: Integer> {
    pub machine: &'a Machine<R, P>,
    courses: &'a [Course<R, P>],
    pub adversary: Adversary<'a, R, P>,
}

impl<'a, R: Wire<Place = P>, P: Integer> Run<'a, R, P> {
    /// An adversary before its first cycle.
    pub fn new(machine: &'a Machine<R, P>, arena: &mut Arena) -> Self {
        let courses: &[_] = arena.collect((0..COURSES).map(Course::new));
        Run { machine, courses, adversary: Adversary::new(courses, recorded::recording().header().period_ns) }
    }

    /// Draws cycle `number` and prepares the states for it.
    pub fn draw(&mut self, number: u32) -> (Moment<R, P>, PreparedCycle<'a, R, P>) {
        let moment = self.adversary.cycle(number);
        if moment.cold {
            self.machine.restart();
        }
        if let Some((slot, line)) = moment.thermal {
            self.machine.each_state(|state| state.set_thermal(slot, line).expect("a slot of the step"));
        }
        let mut cycle = self.machine.cycle(self.courses[moment.course].path(), moment.input.elapsed_ns);
        (cycle.input, cycle.reference, cycle.probes) = (moment.input, moment.reference, moment.probes);
        (cycle.exchanged, cycle.all_exchanged) = (moment.exchanged, moment.exchanged);
        (moment, cycle)
    }
}

/// Results over all cycles, by form, by kind of course, by stage.
struct Counts {
    forms: [Tally; FORMS],
    middle: [Middle; FORMS],
    dearest: [Dearest; FORMS],
    digests: [Digest; FORMS],
    kinds: [Tally; KINDS.len()],
    stages: [Tally; STAGES.len()],
    met: [u32; MET.len()],
}

impl Counts {
    fn new(arena: &mut Arena) -> Self {
        Counts {
            forms: Default::default(),
            middle: [(); FORMS].map(|()| Middle::new(arena)),
            dearest: [(); FORMS].map(|()| Dearest { kept: [(0, 0); DEAREST], least: 0 }),
            digests: Default::default(),
            kinds: Default::default(),
            stages: Default::default(),
            met: [0; MET.len()],
        }
    }

    /// Runs a cycle and adds its counts.
    fn add<R: Wire<Place = P>, P: Integer>(
        &mut self,
        number: u32,
        moment: &Moment<R, P>,
        cycle: &PreparedCycle<'_, R, P>,
    ) {
        let mut last = None;
        let (counts, _) = cycle.count(|form, output| {
            self.digests[form].add(output);
            last = Some(output.record);
        });
        self.kinds[moment.course % KINDS.len()].add(counts[0]);
        for (form, count) in counts.into_iter().enumerate() {
            self.forms[form].add(count);
            self.middle[form].add(count, number);
            self.dearest[form].add(count, number);
        }
        for (taken, stage) in cycle.stages().into_iter().zip(&mut self.stages) {
            stage.add(taken);
        }
        let Some(record) = last else { return };
        let met = [
            record.status.has(Status::ACTIVE),
            record.status.has(Status::FROZEN),
            record.status.has(Status::STOP_REQUEST),
            record.limited != 0,
            record.tip.flags.has(Flags::BRACKETED),
            moment.events == Events::default(),
        ];
        for (times, met) in self.met.iter_mut().zip(met) {
            *times += u32::from(met);
        }
    }

    fn print(&mut self, scalar: &str) {
        for (form, name) in NAMES.into_iter().enumerate() {
            let (typical, worst_at) = (self.middle[form].value(), self.dearest[form].worst());
            hprintln!("{} {} typical {} {} at {}", scalar, name, typical, self.forms[form], worst_at);
        }
        let stages = STAGES.iter().map(|(_, name)| *name).zip(&self.stages);
        for (name, tally) in stages.chain(KINDS.into_iter().zip(&self.kinds)) {
            hprintln!("{} adversarial_{} {}", scalar, name, tally);
        }
        let [bare, gauged, volumetric] = self.digests.map(Digest::value);
        hprintln!("{} digests of {} cycles: {:08x} {:08x} {:08x}", scalar, CYCLES, bare, gauged, volumetric);
        hprint!("{} met", scalar);
        for (name, times) in MET.iter().zip(self.met) {
            hprint!(" {} {}", name, times);
        }
        hprint!("\n{} dearest", scalar);
        let [dearest, ..] = &mut self.dearest;
        dearest.kept.sort_unstable_by_key(|(count, cycle)| (u32::MAX - count, *cycle));
        for (_, cycle) in dearest.kept {
            hprint!(" {}", cycle);
        }
        hprintln!();
    }
}

/// Counts all cycles.
pub fn all<R: Wire<Place = P>, P: Integer>(scalar: &str, machine: &Machine<R, P>, arena: &mut Arena) {
    let mut run = Run::new(machine, arena);
    let mut found = Counts::new(arena);
    for number in 0..CYCLES {
        let (moment, cycle) = run.draw(number);
        found.add(number, &moment, &cycle);
    }
    found.print(scalar);
    climb::dearest(scalar, &mut run);
    replay(scalar, machine, found.dearest[0].worst(), arena);
}

/// Runs a cycle's scene up to that cycle, and prints its inputs, its results and its stages.
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
