//! Contour feedback never excites an oscillation on a drive near its configured figures, and if the loop is unstable
//! nevertheless, the step's watch detects it.

mod campaign;
mod drive;
mod plugin;

use campaign::{CYCLES, Shape, Track, drive, effects, errors, near};
use plugin::{Plugin, WIDE, machine, servo};
use trueaxis::HostServo;
use trueaxis::machine::{DriveFigures, Limits, MachineSettings};
use trueaxis_testing::machine::Machine;
use trueaxis_testing::noise::Noise;
use trueaxis_testing::share::share;

/// Number of plants in the campaign; more of them find rarer unstable pairs of drive and gains.
const PLANTS: usize = 10_000;
/// Share by which every figure of a plant may be off.
const OFF: f64 = 0.4;
/// Effects below this count as zero, µm: less than 1 % of the push's initial effect.
const NOISE_UM: f64 = 0.02;
/// Servo period of the tracks, s.
const PERIOD_S: f64 = 0.5e-3;
/// Default level of the watch, mm.
const WATCH_MM: f64 = 0.01;

fn tracks() -> [Track; 2] {
    [Shape::Line, Shape::Circle].map(|shape| Track::new(shape, &Machine::three_axis().settings()))
}

/// A configuration that the plugin accepts, and its servo loop. Refused gains are reduced to the largest permitted ones, or to
/// as little as half of those, so most are near the margins.
fn permitted(random: &mut Noise, limits: Option<Limits>) -> (DriveFigures, MachineSettings, HostServo<'static, 3>) {
    let (configured, mut gains) = (drive(random), [1.5 * random.unit(), 150.0 * random.unit()]);
    for _ in 0..5 {
        let machine = machine(configured, gains, WATCH_MM, limits);
        match servo(&machine, PERIOD_S) {
            Ok(servo) => return (configured, machine, servo),
            Err(refused) => {
                let share = random.range(0.5, 1.0) * refused.bound.expect("the largest gain") / gains[0];
                gains = gains.map(|gain| share * gain);
            }
        }
    }
    panic!("{configured:?} {gains:?} is refused")
}

#[test]
fn no_plant_near_its_figures_is_made_to_oscillate() {
    let tracks = tracks();
    let mut random = Noise::new(15);
    for number in 0..share(PLANTS) {
        let (configured, machine, servo) = permitted(&mut random, Some(WIDE));
        let plants = [(); 2].map(|()| near(&configured, OFF, &mut random));
        let track = &tracks[number % 2];
        let case = || format!("plant {number}, {:?}: {:?} {plants:?}", track.shape, machine.contour.feedback);
        let [alone, pushed] = [0.0, 1.0].map(|push| {
            let mut plugin = Plugin::new(&servo, track);
            let errors = errors(track, &plants, (CYCLES, push), |command, tip| plugin.drive(command, tip));
            assert_eq!(plugin.out_since, None, "{}", case());
            errors
        });
        let [first, before, after] = effects(&pushed, &alone);
        // The integral creeps, with real poles; an oscillation that does not decay appears in both.
        let calm = after < (1.05 * before).max(NOISE_UM) && after < 0.5 * first;
        assert!(calm, "{first} {before} {after} {}", case());
    }
}

/// The machine with a watch that never triggers.
fn unwatched(machine: &MachineSettings) -> MachineSettings {
    let mut machine = machine.clone();
    machine.contour.feedback.iter_mut().for_each(|feedback| feedback.watch_mm = 10.0);
    machine
}

/// The readings are late, unknown to the configuration, for which the gains were permitted.
#[test]
fn an_unstable_loop_is_ramped_out() {
    /// Cycles until the oscillation is visible, and until the feedback must be out.
    const SEEN: usize = 4 * CYCLES;
    const LATER: usize = 6 * CYCLES;
    let tracks = tracks();
    let mut random = Noise::new(16);
    let (mut unstable, mut drawn) = (0, 0);
    while unstable < share(200).min(60) {
        drawn += 1;
        assert!(drawn < 1000, "{unstable} of {drawn}");
        let (configured, machine, watched) = permitted(&mut random, None);
        let late = DriveFigures { dead_time_s: random.range(0.02, 0.05), ..configured };
        let track = &tracks[drawn % 2];
        let run = |servo: &HostServo<'static, 3>, cycles: usize| {
            let mut plugin = Plugin::new(servo, track);
            let errors = errors(track, &[late; 2], (cycles, 1.0), |command, tip| plugin.drive(command, tip));
            (errors, plugin.out_since)
        };
        let without = errors(track, &[late; 2], (LATER, 1.0), |command, _| [command.at[0], command.at[1]]);
        // The result without the watch.
        let (blind, _) = run(&servo(&unwatched(&machine), PERIOD_S).unwrap(), SEEN);
        let [_, _, grown] = effects(&blind, &without[..SEEN]);
        if grown < 30.0 {
            continue;
        }
        unstable += 1;
        let (errors, out_since) = run(&watched, LATER);
        let case = || format!("{grown} {:?}: {:?} {late:?}", track.shape, machine.contour.feedback);
        assert!(out_since.is_some(), "{}", case());
        // Once the feedback is out, the axes behave as without it.
        let [.., left] = effects(&errors, &without);
        assert!(left < 0.1, "{out_since:?} {left} {}", case());
    }
}
