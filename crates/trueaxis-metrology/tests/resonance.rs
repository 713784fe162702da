//! Resonances from circles of a motor and a load that are integrated independently of the crate.

use crate::plant::{Circle, Mechanics, commands, elastic_readings};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use std::f64::consts::TAU;
use trueaxis::Axis;
use trueaxis::machine::{DriveFigures, FrictionSettings};
use trueaxis_metrology::friction::{FrictionRefusal, Identified, NoResonance, Record, Recorded, identify};

const FRICTION: FrictionSettings = FrictionSettings {
    coulomb_per_s: 0.525,
    stribeck_share: 0.3,
    stribeck_velocity_per_s: 2.0,
    presliding: 0.006,
    viscous: 0.005,
    lead_s: 0.0,
    adapt: 0.0,
};
const CIRCLES: [Circle; 4] = [(8.003, 25.0, 1.5), (8.003, -25.0, 1.5), (8.003, 10.0, 1.5), (8.003, -10.0, 1.5)];
/// A third as long.
const SHORT: [Circle; 4] = [(3.003, 25.0, 1.5), (3.003, -25.0, 1.5), (3.003, 10.0, 1.5), (3.003, -10.0, 1.5)];

struct Case {
    drive: DriveFigures,
    friction: FrictionSettings,
    mechanics: Mechanics,
    period_s: f64,
}

fn record(case: &Case, circles: &[Circle], seed: u64) -> Record {
    let [x, y] = commands(circles, case.period_s, 0.05);
    let stamps: Vec<f64> = (0..x.len()).map(|k| k as f64 * case.period_s).collect();
    let read = |command: &[f64], seed| {
        elastic_readings(command, case.period_s, (&case.drive, &case.friction, &case.mechanics), seed)
    };
    let [read_x, read_y] = [read(&x, 2 * seed), read(&y, 2 * seed + 1)];
    let axes = [
        Recorded { axis: Axis::X, command: x, reading: read_x },
        Recorded { axis: Axis::Y, command: y, reading: read_y },
    ];
    Record::new(&stamps, axes).unwrap()
}

/// Friction of the axes, and the resonance of the first.
fn found(record: &Record, given: Option<DriveFigures>) -> Result<Identified, FrictionRefusal> {
    let [mut x, _] = identify(record, [given, given], &mut |_, _| ())?;
    x.find_resonance(record, 0, &mut || ())?;
    Ok(x)
}

/// The drive `usual` of the simulator.
fn usual(mechanics: Mechanics) -> Case {
    let drive = DriveFigures { velocity_feed_forward: 0.9, ..DriveFigures::with_defaults(60.0, 350.0, 0.012) };
    let friction = FrictionSettings { coulomb_per_s: 1.2, ..FRICTION };
    Case { drive, friction, mechanics, period_s: 1e-3 }
}

const USUAL: Mechanics = Mechanics {
    resonance_hz: 120.0,
    damping: 0.03,
    share: 0.4,
    scale: true,
    play: 0.0,
    noise: 5e-5,
    count: 1e-5,
    second_hz: 0.0,
};

#[test]
fn the_resonance_of_the_mechanics_is_found_not_that_of_the_closed_loop() {
    let case = usual(USUAL);
    let own = found(&record(&case, &SHORT, 1), Some(case.drive)).unwrap();
    let resonance = own.mechanics.unwrap().resonance.unwrap();
    // tests/reference/two_masses.py: the closed loop rings at 113 Hz with 22 %.
    let off = (resonance.frequency_hz.value - 120.0).abs();
    let error = resonance.frequency_hz.standard_error.unwrap();
    assert!(off < 3.0 * error && error < 6.0, "{resonance:?}");
    let off = (resonance.damping.value - 0.03).abs();
    let error = resonance.damping.standard_error.unwrap();
    assert!(off < 3.0 * error && error < 0.05, "{resonance:?}");
}

#[test]
fn a_rigid_axis_gets_no_resonance() {
    let case = usual(Mechanics { resonance_hz: 0.0, ..USUAL });
    let own = found(&record(&case, &SHORT, 1), Some(case.drive)).unwrap();
    let mechanics = own.mechanics.unwrap();
    assert!(matches!(mechanics.resonance, Err(NoResonance::NotSeen { .. })), "{mechanics:?}");
    assert!(mechanics.none_below_hz.is_some_and(|hz| hz > 20.0), "{mechanics:?}");
}

/// A draw from the family: loops tuned to the resonance.
fn drawn(seed: u64, rigid: bool, play: bool) -> Case {
    let mut random = ChaCha8Rng::seed_from_u64(1000 + seed);
    let mut even = |low: f64, high: f64| low + (high - low) * f64::from(random.next_u32()) / 4_294_967_296.0;
    let hz = 25.0 * 12_f64.powf(even(0.0, 1.0));
    let damping = even(0.01, 0.1);
    let share = even(0.2, 0.8);
    let scale = even(0.0, 1.0) < 0.5;
    let noise = 1e-5 * 100_f64.powf(even(0.0, 1.0));
    let kvp = 0.47 * TAU * hz * even(0.75, 1.25);
    let kv = kvp / even(6.0, 8.0);
    let reset = 4.0 / kvp * even(0.8, 1.2);
    let ahead = if even(0.0, 1.0) < 0.3 { 0.0 } else { even(0.6, 0.98) };
    let drive = DriveFigures { velocity_feed_forward: ahead, ..DriveFigures::with_defaults(kv, kvp, reset) };
    let friction = FrictionSettings { coulomb_per_s: 420.0 * even(0.7, 1.5) / kvp, viscous: 4.0 / kvp, ..FRICTION };
    let period_s = [1e-3, 1e-3, 5e-4, 2.5e-4, 1e-4][(even(0.0, 5.0) as usize).min(4)];
    let play = if play { even(0.0, 0.01) } else { 0.0 };
    let resonance_hz = if rigid { 0.0 } else { hz };
    let mechanics = Mechanics { resonance_hz, damping, share, scale, play, noise, count: 1e-5, second_hz: 0.0 };
    Case { drive, friction, mechanics, period_s }
}

/// Plants of the family, one line each: `RESONANCE=0..60 cargo test -p trueaxis-metrology resonance -- --ignored --nocapture`;
/// with a second word `rigid` or `play` those.
#[test]
#[ignore = "minutes"]
fn intervals_contain_the_resonances_of_a_family() {
    let asked = std::env::var("RESONANCE").unwrap_or_else(|_| "0..20".into());
    let (range, kind) = asked.split_once(' ').unwrap_or((&asked, ""));
    let (from, to) = range.split_once("..").unwrap();
    let (mut count, mut inside, mut all) = (0, [0; 2], 0);
    for seed in from.parse().unwrap()..to.parse().unwrap() {
        let case = drawn(seed, kind == "rigid", kind == "play");
        let m = &case.mechanics;
        let record = record(&case, &CIRCLES, seed);
        if record.axes[0].reading.iter().any(|x| !x.is_finite() || x.abs() > 9.0) {
            continue;
        }
        let own = found(&record, None).or_else(|_| found(&record, Some(case.drive)));
        let Some(mechanics) = own.ok().and_then(|own| own.mechanics) else { continue };
        all += 1;
        println!("{seed}: {m:?}, {} Hz: {mechanics:?}", 1.0 / case.period_s);
        if let Ok(resonance) = mechanics.resonance {
            count += 1;
            let figures = [(resonance.frequency_hz, m.resonance_hz), (resonance.damping, m.damping)];
            for (inside, (figure, truth)) in inside.iter_mut().zip(figures) {
                *inside += i32::from((figure.value - truth).abs() < 2.0 * figure.standard_error.unwrap());
            }
        }
    }
    println!("{count} of {all} found; inside twice their standard errors: {inside:?}");
    if kind == "rigid" {
        assert!(100 * count <= all, "{count} of {all} rigid axes got a resonance");
    } else if kind.is_empty() {
        assert!(inside.iter().all(|inside| 10 * inside >= 9 * count), "{inside:?} of {count}");
    }
}
