//! Adversarial cycles on the host, with the tables of the bare-metal image.

use std::path::Path;
use trueaxis::machine::ErrorModel::{Nine, Volumetric};
use trueaxis::machine::MachineSettings;
use trueaxis::roundness::{Gauge, GaugeState};
use trueaxis::tcomp::Tcomp;
use trueaxis::{Config, GaugeRide, Output, Real, ServoLoop, State};
use trueaxis_recording::adversary::{AXES, Adversary, COURSES, Course, Digest, Moment, SCENE, ServoParts, vary};
use trueaxis_recording::outputs::Wire;
use trueaxis_tables::Machine;

/// Servo period, ns, equal to that of the image's recording.
pub const PERIOD_NS: u32 = 1_000_000;

/// Machines of `firmware-sim/cortex-m`: the one in force from the start, and the one exchanged for it.
const MACHINES: [&str; 2] = ["machine/machine.toml", "machine/warm.toml"];

type Loop<R> = ServoLoop<'static, R, <R as Wire>::Place, AXES>;

/// Points of the gauge's revolution.
const POINTS: usize = 1024;

/// Servo loops and courses.
pub struct Adversarial<R: Wire> {
    servos: [Loop<R>; 2],
    all_terms: [Loop<R>; 2],
    dynamic: [Loop<R>; 2],
    gauge: Box<Gauge<R, POINTS>>,
    courses: Vec<Course<R, R::Place>>,
}

/// A cycle about to run.
pub struct AdversarialCycle<'a, R: Wire> {
    /// Servo loop.
    pub servo: &'a Loop<R>,
    /// State of the loop.
    pub state: State<R, R::Place, AXES>,
    /// Course and inputs of the cycle.
    pub moment: Moment<R, R::Place>,
    course: &'a Course<R, R::Place>,
}

impl<R: Wire> AdversarialCycle<'_, R> {
    /// Runs the cycle.
    #[inline(always)]
    pub fn run(&mut self, output: &mut Output<R, R::Place, AXES>) {
        let on = self.course.path().on(self.moment.reference);
        self.servo.step_into(&mut self.state, &self.moment.input, on, (), output);
    }
}

/// A compiled machine of the image, kept in memory until the process ends.
fn tables(file: &str) -> Tcomp<'static> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware-sim/cortex-m");
    let machine = Machine::read(&folder.join(file)).expect("the image's machine");
    let bytes = trueaxis_tables::compile(&machine).expect("valid tables").leak();
    Tcomp::parse(bytes).expect("a compiled file")
}

fn servo<R: Wire>(tables: &Tcomp<'static>, change: impl FnOnce(&mut MachineSettings)) -> Loop<R> {
    let rows = |axis| tables.table(axis);
    let mut settings = tables.settings().clone();
    change(&mut settings);
    let config = Config { machine: &settings, ..Config::of(tables, PERIOD_NS) };
    let memory = vec![<R as Real>::ZERO; config.requirement(rows)].leak();
    config.build(rows, memory).expect("a valid configuration")
}

impl<R: Wire> Default for Adversarial<R> {
    fn default() -> Self {
        let [first, second] = MACHINES.map(tables);
        let settings = first.settings().roundness.expect("a machine with a gauge");
        Adversarial {
            servos: [&first, &second].map(|tables| servo(tables, |settings| settings.compensation.model = Nine)),
            all_terms: [&first, &second]
                .map(|tables| servo(tables, |settings| settings.compensation.model = Volumetric)),
            dynamic: [&first, &second].map(|tables| servo(tables, |settings| ServoParts::All.configure(settings))),
            gauge: Box::new(Gauge::build(&settings, PERIOD_NS).expect("a valid gauge")),
            courses: (0..COURSES).map(Course::new).collect(),
        }
    }
}

impl<R: Wire> Adversarial<R> {
    /// Draws the cycles `from` … `to` − 1; `from` must be the first of a scene.
    fn draw(&self, from: u32, to: u32) -> impl Iterator<Item = Moment<R, R::Place>> {
        let mut adversary = Adversary::new(&self.courses, PERIOD_NS);
        (from..to).map(move |number| adversary.cycle(number))
    }

    /// Cycle `number` on nine terms, with the state after the preceding cycles of its scene.
    pub fn cycle(&self, number: u32) -> AdversarialCycle<'_, R> {
        let [first, second] = &self.servos;
        let mut state = first.start();
        let mut moments = self.draw(number / SCENE * SCENE, number + 1).peekable();
        loop {
            let moment = moments.next().expect("the cycle of its scene");
            set_thermal(&mut state, &moment);
            let servo = if moment.exchanged { second } else { first };
            let mut cycle = AdversarialCycle { servo, state, moment, course: &self.courses[moment.course] };
            if moments.peek().is_none() {
                return cycle;
            }
            let on = cycle.course.path().on(moment.reference);
            servo.step(&mut cycle.state, &moment.input, on, ());
            state = cycle.state;
        }
    }

    /// Digests of the first `cycles` outputs: nine terms, nine terms with a gauge, volumetric.
    pub fn digests(&self, cycles: u32) -> [u32; 3] {
        let mut digests = [Digest::default(); 3];
        let [mut bare, mut gauged] = [self.servos[0].start(); 2];
        let mut volumetric = self.all_terms[0].start();
        let mut gauge_state = Box::new(GaugeState::new());
        for moment in self.draw(0, cycles) {
            if moment.cold {
                [bare, gauged] = [self.servos[0].start(); 2];
                volumetric = self.all_terms[0].start();
                self.gauge.restart(&mut gauge_state);
            }
            for state in [&mut bare, &mut gauged, &mut volumetric] {
                set_thermal(state, &moment);
            }
            let on = self.courses[moment.course].path().on(moment.reference);
            let (nine, all_terms) =
                (&self.servos[usize::from(moment.exchanged)], &self.all_terms[usize::from(moment.exchanged)]);
            let mut ride = GaugeRide::new(&self.gauge, &mut gauge_state, &moment.probes);
            let outputs = [
                nine.step(&mut bare, &moment.input, on, ()),
                nine.step(&mut gauged, &moment.input, on, &mut ride),
                all_terms.step(&mut volumetric, &moment.input, on, ()),
            ];
            digests.iter_mut().zip(&outputs).for_each(|(digest, output)| digest.add(output));
        }
        digests.map(Digest::value)
    }
}

impl<R: Wire> Adversarial<R> {
    /// Digest of the first `cycles` outputs with every part of the dynamic correction, switched in motion.
    pub fn dynamic_digest(&self, cycles: u32) -> u32 {
        let mut digest = Digest::default();
        let mut state = self.dynamic[0].start();
        for (number, mut moment) in (0..cycles).zip(self.draw(0, cycles)) {
            if moment.cold {
                state = self.dynamic[0].start();
            }
            set_thermal(&mut state, &moment);
            vary(&mut moment.input, number);
            let on = self.courses[moment.course].path().on(moment.reference);
            let servo = &self.dynamic[usize::from(moment.exchanged)];
            digest.add(&servo.step(&mut state, &moment.input, on, ()));
        }
        digest.value()
    }
}

fn set_thermal<R: Wire>(state: &mut State<R, R::Place, AXES>, moment: &Moment<R, R::Place>) {
    if let Some((slot, line)) = moment.thermal {
        state.set_thermal(slot, line).expect("a slot of the step");
    }
}
