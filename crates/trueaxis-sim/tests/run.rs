//! Runs do not depend on how they are divided, and settings have their effect.

use crate::common::PROGRAM;
use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};
use trueaxis::tcomp::Tcomp;
use trueaxis_sim::program::Program;
use trueaxis_sim::run::{Given, Kind, Moment, Run, Sample, Sink, Tallies};
use trueaxis_sim::{Scenario, Settings, SimError};
use trueaxis_tables::Machine;

const TABLES: &[u8] = include_bytes!("../../trueaxis/mill-3axis.tcomp");

fn scenario(settings: Settings) -> Scenario {
    let machine = Machine::from_tcomp(&Tcomp::parse(TABLES).unwrap());
    Scenario::new(machine, Program::parse("loop", PROGRAM, "loop.ngc").unwrap(), settings).unwrap()
}

fn settings(changes: &[(&str, &str)]) -> Settings {
    let mut settings = Settings { rate_hz: 1000.0, ..Settings::default() };
    changes.iter().for_each(|(key, value)| settings.set(key, value).unwrap());
    settings
}

/// Digest of everything passed to a sink.
#[derive(Default)]
struct Digest {
    hasher: DefaultHasher,
    cycles: u64,
    steps: u64,
}

impl Sink for Digest {
    fn cycle(&mut self, moment: &Moment, machines: &[Option<&Sample>]) {
        assert_eq!(moment.cycle, self.cycles);
        self.cycles += 1;
        for sample in machines.iter().flatten() {
            sample.drive.map(f64::to_bits).hash(&mut self.hasher);
            sample.feedback.map(f64::to_bits).hash(&mut self.hasher);
            sample.deviation_um.map(f32::to_bits).hash(&mut self.hasher);
            (sample.lag_um.to_bits(), sample.encoder_um.to_bits(), sample.fault).hash(&mut self.hasher);
        }
    }

    fn before_step(&mut self, given: &Given<'_>) {
        given.command.iter().for_each(|q| q.to_bits().hash(&mut self.hasher));
    }

    fn after_step(&mut self) {
        self.steps += 1;
    }
}

fn finish(mut run: Run, mut digest: Digest, stretch: u64) -> (u64, u64, Vec<Tallies>) {
    while run.advance(stretch, &mut digest) {}
    assert_eq!((run.cycle(), digest.cycles), (run.cycles(), run.cycles()));
    assert!(digest.steps > 3 * digest.cycles, "settling is left out");
    (digest.hasher.finish(), digest.steps, run.tallies())
}

#[test]
fn a_run_may_be_left_and_moved_between_any_two_cycles() {
    let faults = [("faults", "[\"glitch:Y@0.6s+1=5mm\"]")];
    let run = || Run::new(scenario(settings(&faults))).unwrap();
    let whole = finish(run(), Digest::default(), u64::MAX);
    assert_eq!(whole.2[1].faults.len(), 1);
    // The order of calls within a block of cycles varies with its length; the cycles passed to a sink do not.
    let cycles_only = |stretch| {
        let (mut run, mut samples) = (run(), Digest::default());
        let mut sink = |moment: &Moment, machines: &[Option<&Sample>]| samples.cycle(moment, machines);
        while run.advance(stretch, &mut sink) {}
        (samples.hasher.finish(), run.tallies())
    };
    let expected = cycles_only(u64::MAX);
    assert_eq!(expected.1, whole.2);
    for stretch in [1, 7, 255, 256, 257, 10_000] {
        assert_eq!(cycles_only(stretch), expected, "{stretch}");
    }

    let (mut begun, mut digest) = (run(), Digest::default());
    assert!(begun.advance(512, &mut digest));
    let (moved, steps, tallies) = std::thread::spawn(move || finish(begun, digest, 256)).join().unwrap();
    assert_eq!((moved, steps, tallies), finish(run(), Digest::default(), 256));
}

#[test]
fn one_machine_alone_does_what_it_does_among_others() {
    let alone = |kind| {
        let mut run = Run::of(scenario(settings(&[])), &[kind]).unwrap();
        while run.advance(1000, &mut ()) {}
        run.tallies().remove(0)
    };
    let scenario = scenario(settings(&[]));
    let kinds = Kind::of(&scenario.machine.settings);
    let mut all = Run::new(scenario).unwrap();
    while all.advance(1000, &mut ()) {}
    assert_eq!(kinds.iter().map(|kind| alone(*kind)).collect::<Vec<_>>(), all.tallies());
}

/// Largest true contour error of the compensated machine, µm, and cycles.
fn worst(changes: &[(&str, &str)]) -> (f64, u64) {
    let mut run = Run::of(scenario(settings(changes)), &[Kind::Compensated]).unwrap();
    while run.advance(u64::MAX, &mut ()) {}
    (run.tallies()[0].error.max_um, run.cycles())
}

#[test]
fn settings_have_their_effect() {
    let (plain, cycles) = worst(&[]);
    let (slow, slow_cycles) = worst(&[("motion.feed_percent", "50")]);
    assert!(slow_cycles as f64 > 1.5 * cycles as f64 && slow < plain, "{slow_cycles} {cycles}, {slow} {plain}");
    assert!(worst(&[("motion.jerk_mm_per_s3", "1000")]).1 > cycles);
    for change in [
        ("drive.coulomb_mm_per_s2", "2000"),
        ("drive.position_gain_per_s", "30"),
        ("encoder.linear.noise_rms_mm", "0.01"),
        ("encoder.linear.resolution_mm", "0.01"),
        ("axis.X.lost_motion_mm", "0.02"),
        ("axis.Y.gain_factor", "0.5"),
    ] {
        let (error, same) = worst(&[change]);
        assert!(error > 1.2 * plain && same == cycles, "{change:?}: {error} instead of {plain}");
    }
    assert_ne!(worst(&[("seed", "2")]).0, plain);
    assert_ne!(worst(&[("drive.dead_time_s", "0.003")]).0, plain);
}

#[test]
fn a_program_that_leaves_the_travel_is_refused_with_its_line() {
    let machine = Machine::from_tcomp(&Tcomp::parse(TABLES).unwrap());
    let program = Program::parse("far", "G0 X1\nG0 X100000\n", "far.ngc").unwrap();
    let error = Scenario::new(machine, program, Settings::default()).unwrap_err();
    assert!(matches!(&error, SimError::Line { line: 2, .. }), "{error}");
}
