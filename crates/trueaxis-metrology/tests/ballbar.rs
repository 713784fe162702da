//! Identification of the causes of a circle's deviation, on simulated machines that move as their errors dictate: the tests
//! generate positions, not radii.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use rand_distr::{Distribution, Normal};
use std::f64::consts::{E, PI, TAU};
use trueaxis_metrology::ballbar::{BallbarRefusal, Cause, Evaluation, Position, Reading, evaluate, readings};
use trueaxis_testing::scatter::Scatter;
use trueaxis_testing::share::share;

/// A machine's plane; lengths in mm, width of spikes in rad.
#[derive(Clone, Copy, Debug, Default)]
struct Plane {
    radius: f64,
    centre: [f64; 2],
    bar: f64,
    scale: [f64; 2],
    squareness: f64,
    lag: [f64; 2],
    backlash: [f64; 2],
    play: [f64; 2],
    bow: [f64; 2],
    spike: [f64; 2],
    width: f64,
    cyclic: [[f64; 2]; 2],
}

impl Plane {
    /// Reading of a bar about the pivot at a commanded angle.
    fn reading(&self, angle: f64, counterclockwise: bool) -> f64 {
        let tip = self.tip(angle, counterclockwise);
        (tip[0] + self.centre[0]).hypot(tip[1] + self.centre[1]) - self.radius + self.bar
    }

    /// Position of the tip at a commanded angle.
    fn tip(&self, angle: f64, counterclockwise: bool) -> [f64; 2] {
        let r = self.radius;
        let d = if counterclockwise { 1.0 } else { -1.0 };
        let at = [r * angle.cos(), r * angle.sin()];
        let along = [-d * angle.sin(), d * angle.cos()];
        let mut tip = at;
        for axis in [0, 1] {
            let way = along[axis].signum();
            let [amplitude, pitch] = self.cyclic[axis];
            let other = 1 - axis;
            let since = (d * (angle - axis as f64 * 0.5 * PI)).rem_euclid(PI) / self.width.max(1e-9);
            let spike = self.spike[axis] * since * E * (-since).exp();
            tip[axis] += self.scale[axis] * at[axis] - self.lag[axis] * along[axis] - 0.5 * self.backlash[axis] * way;
            tip[axis] += amplitude * (TAU * at[axis] / pitch.max(1e-9) + 0.4).sin();
            tip[other] += self.bow[axis] * (at[axis] / r).powi(2) - 0.5 * self.play[axis] * way;
            // Outwards along the bar.
            tip[0] += spike * angle.cos();
            tip[1] += spike * angle.sin();
        }
        tip[0] -= self.squareness * at[1];
        tip
    }

    fn record(&self, count: usize, directions: &[bool], mut noise: impl FnMut() -> f64) -> Vec<Reading> {
        let mut readings = Vec::new();
        for &counterclockwise in directions {
            for k in 0..count {
                let angle_rad = TAU * (k as f64 + 0.5) / count as f64;
                let deviation_mm = self.reading(angle_rad, counterclockwise) + noise();
                readings.push(Reading { angle_rad, deviation_mm, counterclockwise });
            }
        }
        readings
    }

    /// Causes and their true values, as defined.
    fn truth(&self) -> Vec<(Cause, f64)> {
        let mut truth = vec![
            (Cause::ScaleMismatch, self.scale[0] - self.scale[1]),
            (Cause::Squareness, self.squareness),
            (Cause::ServoMismatch, self.lag[0] - self.lag[1]),
        ];
        for axis in [0, 1] {
            truth.extend([
                (Cause::Centre(axis as u8), self.centre[axis]),
                (Cause::Backlash(axis as u8), self.backlash[axis]),
                (Cause::LateralPlay(axis as u8), self.play[axis]),
                (Cause::Straightness(axis as u8), self.bow[axis]),
                (Cause::Reversal(axis as u8), self.spike[axis]),
            ]);
            if self.cyclic[axis][0] > 0.0 {
                truth.push((Cause::Cyclic(axis as u8), self.cyclic[axis][0]));
            }
        }
        truth
    }
}

fn value(found: &Evaluation, cause: Cause) -> f64 {
    found.term(cause).unwrap_or_else(|| panic!("no {cause:?}")).value
}

/// A circle with a single cause: the fit finds that cause and nothing else except second-order effects of a micrometre in 100
/// mm.
#[test]
fn every_cause_alone_is_found_and_nothing_else() {
    let none = Plane { radius: 100.0, width: 0.03, ..Plane::default() };
    let planes = [
        Plane { scale: [3e-5, -1e-5], ..none },
        Plane { squareness: 40e-6, ..none },
        Plane { lag: [0.004, 0.001], ..none },
        Plane { backlash: [0.006, 0.0], ..none },
        Plane { backlash: [0.0, -0.003], ..none },
        Plane { play: [0.002, 0.0], ..none },
        Plane { play: [0.0, 0.002], ..none },
        Plane { bow: [0.005, 0.0], ..none },
        Plane { bow: [0.0, -0.004], ..none },
        Plane { spike: [0.007, 0.0], ..none },
        Plane { spike: [0.0, 0.004], ..none },
        Plane { cyclic: [[0.002, 12.0], [0.0, 0.0]], ..none },
        Plane { cyclic: [[0.0, 0.0], [0.0015, 7.5]], ..none },
        Plane { centre: [0.2, -0.1], ..none },
    ];
    for plane in planes {
        let found = evaluate(plane.radius, &plane.record(720, &[true, false], || 0.0), [None; 2]).unwrap();
        for term in &found.terms {
            let truth =
                plane.truth().into_iter().find(|(cause, _)| *cause == term.cause).map_or(0.0, |(_, value)| value);
            let unit = match term.cause {
                Cause::Radius => continue,
                Cause::ScaleMismatch | Cause::Squareness => 1.0 / plane.radius,
                _ => 1.0,
            };
            let off = (term.value - truth).abs() / unit;
            assert!(off < 2e-5, "{:?}: {} for {truth}, {plane:?}", term.cause, term.value);
        }
    }
}

/// Random machines, 500 in the campaign, with all causes at once and a noise of 0.2 µm: each value is within a tenth of the
/// true one or 4.5 standard errors. Fifty already give some 750 values; more narrow down the share within two standard errors.
#[test]
fn causes_of_random_machines_are_separated() {
    let mut random = ChaCha8Rng::seed_from_u64(2304);
    let mut within = [0_usize; 2];
    for machine in 0..share(500).max(50) as u64 {
        let mut draw = |most: f64| most * (2.0 * (random.next_u32() as f64 / u32::MAX as f64) - 1.0);
        let mut two = |most: f64| [draw(most), draw(most)];
        let plane = Plane {
            radius: 100.0 + two(50.0)[0],
            centre: two(0.05),
            bar: two(0.01)[0],
            scale: two(5e-5),
            squareness: two(8e-5)[0],
            lag: two(0.005),
            backlash: two(0.008),
            play: two(0.003),
            bow: two(0.006),
            spike: two(0.008).map(f64::abs),
            width: 0.03 + two(0.015)[0],
            cyclic: two(0.002).map(|amplitude| [amplitude.abs(), 10.0]),
        };
        let normal = Normal::new(0.0, 2e-4).unwrap();
        let mut noise = ChaCha8Rng::seed_from_u64(machine);
        let record = plane.record(720, &[true, false], || normal.sample(&mut noise));
        let found = evaluate(plane.radius, &record, [Some(10.0); 2]).unwrap();
        for (cause, truth) in plane.truth() {
            let term = found.term(cause).unwrap();
            let off = (term.value - truth).abs();
            within[0] += 1;
            within[1] += usize::from(off <= 2.0 * term.standard_error);
            assert!(
                off <= (0.1 * truth.abs()).max(4.5 * term.standard_error),
                "machine {machine}, {cause:?}: {} ± {} for {truth}",
                term.value,
                term.standard_error
            );
        }
        assert!((found.sigma_mm / 2e-4 - 1.0).abs() < 0.1, "machine {machine}: {}", found.sigma_mm);
    }
    let share = within[1] as f64 / within[0] as f64;
    println!("{} values, {share:.4} within two standard errors", within[0]);
    assert!((0.93..0.97).contains(&share), "{share}");
}

/// 180 readings per turn are 35 mrad apart: the fit finds spikes of 12 mrad or more and reports narrower ones. If it tried
/// only wider ones, an inward spike of 15 degrees would fit best, with twice the backlash.
#[test]
fn spikes_narrower_than_the_readings_lie_apart() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let noise = Normal::new(0.0, 0.3e-3).unwrap();
    let mut found = |spike: f64, width: f64, count: usize| {
        let plane = Plane { radius: 100.0, backlash: [0.005, 0.002], spike: [spike; 2], width, ..Plane::default() };
        let record = plane.record(count, &[true, false], || noise.sample(&mut random));
        evaluate(100.0, &record, [None; 2]).unwrap()
    };
    for width in [0.005, 0.007, 0.009, 0.014, 0.017, 0.02, 0.025, 0.03, 0.04, 0.06, 0.12] {
        let found = found(0.006, width, 180);
        assert_eq!(found.spikes_unresolved, width < 0.01, "{width}: {}", found.spike_width_rad);
        for (axis, truth) in [(0, 0.005), (1, 0.002)] {
            let backlash = found.term(Cause::Backlash(axis)).unwrap();
            let off = (backlash.value - truth).abs();
            assert!(off < 4.5 * backlash.standard_error && off < 0.001, "{width}: {backlash:?}");
        }
    }
    assert!(!found(0.006, 0.009, 1080).spikes_unresolved, "enough readings");
    assert!((0..20).all(|_| !found(0.0, 0.03, 180).spikes_unresolved), "no spikes");
}

/// The ring of a squareness error alone is an ellipse: G = R·C0Y; that of a backlash is its step.
#[test]
fn figures_of_simple_circles() {
    let plane = Plane { radius: 150.0, squareness: 60e-6, centre: [0.03, 0.02], ..Plane::default() };
    let found = evaluate(150.0, &plane.record(3600, &[true, false], || 0.0), [None; 2]).unwrap();
    let figures = found.figures;
    let near = |found: Option<f64>, truth: f64| assert!((found.unwrap() - truth).abs() < 2e-5, "{found:?} for {truth}");
    near(figures.g_b, 0.009);
    near(figures.g[0], 0.009);
    near(figures.f[0].map(|f| f[0]), 0.0045);
    near(figures.f[1].map(|f| f[1]), -0.0045);
    near(figures.h, 0.0);
    let plane = Plane { radius: 150.0, backlash: [0.010, 0.0], ..Plane::default() };
    let found = evaluate(150.0, &plane.record(3600, &[true, false], || 0.0), [None; 2]).unwrap();
    near(found.figures.h, 0.010);
    near(found.figures.g_b, 0.010);
}

#[test]
fn one_direction_leaves_out_causes_that_need_both() {
    let plane = Plane { radius: 100.0, squareness: 40e-6, backlash: [0.006, 0.002], ..Plane::default() };
    let found = evaluate(100.0, &plane.record(1440, &[false], || 0.0), [None; 2]).unwrap();
    assert!(!found.both_directions && found.figures.g_b.is_none() && found.figures.g[0].is_none());
    assert!(found.term(Cause::ServoMismatch).is_none() && found.term(Cause::LateralPlay(0)).is_none());
    assert!((value(&found, Cause::Squareness) - 40e-6).abs() < 1e-7);
    assert!((value(&found, Cause::Backlash(0)) - 0.006).abs() < 1e-5);
}

#[test]
fn uninformative_records_are_refused() {
    let plane = Plane { radius: 100.0, squareness: 40e-6, ..Plane::default() };
    let good = plane.record(360, &[true, false], || 0.0);
    assert_eq!(evaluate(100.0, &good[..50], [None; 2]), Err(BallbarRefusal::TooFew { found: 50 }));
    let mut turns = plane.record(20, &[true], || 0.0);
    turns.retain(|reading| reading.angle_rad < 3.7);
    turns.resize(100, Reading { angle_rad: 0.0, ..good[0] });
    assert!(matches!(
        evaluate(100.0, &turns, [None; 2]),
        Err(BallbarRefusal::TooFew { .. } | BallbarRefusal::Gap { .. })
    ));
    let mut bad = good.clone();
    bad[100].deviation_mm = f64::NAN;
    assert_eq!(evaluate(100.0, &bad, [None; 2]), Err(BallbarRefusal::NotAReading { index: 100 }));
    let part: Vec<Reading> = good.iter().filter(|r| r.counterclockwise || r.angle_rad > 2.9).copied().collect();
    match evaluate(100.0, &part, [None; 2]) {
        Err(BallbarRefusal::Gap { counterclockwise: false, from_deg, width_deg }) => {
            assert!((from_deg - 359.5).abs() < 0.01 && width_deg > 160.0, "{from_deg} {width_deg}");
        }
        other => panic!("{other:?}"),
    }
    let torn = |r: &&Reading| !(0.5..1.0).contains(&r.angle_rad) && !(3.0..3.4).contains(&r.angle_rad);
    let part: Vec<Reading> = good.iter().filter(torn).copied().collect();
    assert!(matches!(evaluate(100.0, &part, [None; 2]), Err(BallbarRefusal::Gap { .. })), "two gaps");
}

/// From rest in the middle out to the circle, two turns in each direction with a stop between, and back; every tenth of a
/// degree.
fn positions(plane: &Plane, middle: [f64; 2]) -> Vec<Position> {
    let at = |[x, y]: [f64; 2]| [middle[0] + x, middle[1] + y];
    let out = |k: usize| plane.radius * k as f64 / 500.0;
    let way = |k: usize| Position { command: at([out(k), 0.0]), actual: at([out(k), 0.002]) };
    let turns = |counterclockwise: bool| {
        (1..=7200).map(move |k| {
            let angle = TAU * if counterclockwise { k as f64 } else { -(k as f64) } / 3600.0 + 1e-4;
            let command = [plane.radius * angle.cos(), plane.radius * angle.sin()];
            Position { command: at(command), actual: at(plane.tip(angle, counterclockwise)) }
        })
    };
    let mut all: Vec<Position> = (0..=500).map(way).collect();
    all.extend(turns(true));
    all.extend(std::iter::repeat_n(all[all.len() - 1], 300));
    all.extend(turns(false));
    all.extend((0..=500).rev().map(way));
    all
}

#[test]
fn positions_read_as_a_bar_would() {
    let plane = Plane {
        radius: 60.0,
        squareness: 70e-6,
        backlash: [0.004, 0.001],
        spike: [0.005, 0.0],
        width: 0.04,
        ..Plane::default()
    };
    let read = readings(60.0, &positions(&plane, [-130.0, 45.0])).unwrap();
    for counterclockwise in [true, false] {
        let count = read.iter().filter(|reading| reading.counterclockwise == counterclockwise).count();
        assert!((7190..=7210).contains(&count), "{count}: two turns in tenths of a degree, without the way there");
    }
    // At a reversal, a stretch of a tenth of a degree contains both sides of the step.
    let turns = |angle: f64| (angle.to_degrees() + 45.0).rem_euclid(90.0) - 45.0;
    for reading in read.iter().filter(|reading| turns(reading.angle_rad).abs() > 0.1) {
        let truth = plane.reading(reading.angle_rad, reading.counterclockwise);
        let off = (reading.deviation_mm - truth).abs();
        assert!(off < 2e-4, "{} for {truth} at {}°", reading.deviation_mm, reading.angle_rad.to_degrees());
    }
    let found = evaluate(60.0, &read, [None; 2]).unwrap();
    assert!((value(&found, Cause::Squareness) - 70e-6).abs() < 5e-7);
    assert!((value(&found, Cause::Backlash(0)) - 0.004).abs() < 3e-5);
    assert!((value(&found, Cause::Reversal(0)) - 0.005).abs() < 1e-4);
}

#[test]
fn positions_without_the_circle_are_refused() {
    let plane = Plane { radius: 60.0, ..Plane::default() };
    let all = positions(&plane, [0.0; 2]);
    match readings(50.0, &all) {
        Err(BallbarRefusal::NoCircle { radius_mm: 50.0, found_mm: Some(found) }) => {
            assert!((found - 60.0).abs() < 1e-6)
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(readings(60.0, &all[..400]), Err(BallbarRefusal::NoCircle { radius_mm: 60.0, found_mm: None }));
    assert_eq!(readings(60.0, &[]), Err(BallbarRefusal::NoCircle { radius_mm: 60.0, found_mm: None }));
    let mut broken = all.clone();
    broken[77].actual[1] = f64::INFINITY;
    assert_eq!(readings(60.0, &broken), Err(BallbarRefusal::NotAReading { index: 77 }));
    // Half a circle is missing in one direction: the fit refuses it by its angles.
    let part: Vec<Position> = all.iter().take(501 + 7200 + 300 + 1900).copied().collect();
    let read = readings(60.0, &part).unwrap();
    assert!(matches!(evaluate(60.0, &read, [None; 2]), Err(BallbarRefusal::Gap { counterclockwise: false, .. })));
}

/// Effect of friction on a reversal, as a function of the angle since it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Leaves {
    Nothing,
    /// A rise within a milliradian or three, then a decay: height in mm, width and rise in rad.
    Fast,
    /// A cascaded drive against Dahl friction, or LuGre friction with Stribeck effect, simulated in time.
    Dahl,
    LuGre,
}

/// A table over the angle since a reversal, 0 to π.
fn spike(leaves: Leaves, radius: f64, feed: f64, draw: &mut impl FnMut(f64, f64) -> f64) -> Vec<f64> {
    const STEPS: usize = 40_000;
    let at = |k: usize| PI * k as f64 / STEPS as f64;
    match leaves {
        Leaves::Nothing => vec![0.0; STEPS + 1],
        Leaves::Fast => {
            let way = if draw(0.0, 1.0) < 0.3 { -1.0 } else { 1.0 };
            let (height, width, rise) = (way * draw(2e-3, 8e-3), draw(0.01, 0.08), draw(5e-4, 4e-3));
            (0..=STEPS).map(|k| height * ((-at(k) / width).exp() - (-at(k) / rise).exp())).collect()
        }
        Leaves::Dahl | Leaves::LuGre => {
            let [kv, tau, kvp] = [draw(20.0, 110.0), draw(0.006, 0.03), draw(150.0, 800.0)];
            let (z, level, v_s) = (draw(0.002, 0.01), draw(0.2, 0.8), draw(0.5, 3.0));
            let stribeck = if leaves == Leaves::LuGre { draw(0.1, 0.5) } else { 0.0 };
            let turns_per_s = feed / radius;
            let h = PI / STEPS as f64 / turns_per_s / 4.0;
            let speed = |v: f64| level * kvp * (1.0 + stribeck / (1.0 + (v / v_s).powi(2)));
            // Lag behind the command, speed, integrator value; the state of friction.
            let (mut x, mut v, mut held, mut f) = (0.0, 0.0, -speed(0.0), -1.0);
            let mut table = Vec::with_capacity(STEPS + 1);
            for k in 0..=4 * STEPS {
                if k % 4 == 0 {
                    table.push(-x);
                }
                let command = feed * (turns_per_s * h * k as f64).sin();
                let way = command * h / z;
                f = (f + way) / (1.0 + way);
                held -= h * kvp / tau * (kv * x + v);
                v = (v + h * (held - kvp * kv * x - speed(command) * f)) / (1.0 + h * kvp);
                x += h * v;
            }
            table
        }
    }
}

/// Readings of a machine that takes up its play during travel (a play operator), and the true backlashes, scale mismatch and
/// squareness.
fn machine(leaves: Leaves, angles_deg: &[f64], seed: u64) -> (f64, Vec<Reading>, [(Cause, f64); 4]) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = |from: f64, to: f64| from + (to - from) * (f64::from(random.next_u32()) / f64::from(u32::MAX));
    let radius = [50.0, 100.0, 150.0][draw(0.0, 2.999) as usize];
    let feed = [16.0, 33.0, 50.0][draw(0.0, 2.999) as usize];
    let sigma = [5e-5, 1e-4, 3e-4][draw(0.0, 2.999) as usize];
    let backlash = [0; 2].map(|_| if draw(0.0, 1.0) < 0.3 { 0.0 } else { draw(0.0, 0.012) });
    let (scale, squareness, lag) = (draw(-5e-5, 5e-5), draw(-8e-5, 8e-5), draw(-3e-3, 3e-3));
    let (bow, centre) = ([0; 2].map(|_| draw(-4e-3, 4e-3)), [0; 2].map(|_| draw(-0.01, 0.01)));
    let spikes = [0; 2].map(|_| spike(leaves, radius, feed, &mut draw));
    let normal = Normal::new(0.0, sigma).unwrap();
    let mut noise = ChaCha8Rng::seed_from_u64(!seed);
    let mut readings = Vec::new();
    for counterclockwise in [true, false] {
        let d = if counterclockwise { 1.0 } else { -1.0 };
        for angle_deg in angles_deg {
            let angle = angle_deg.to_radians();
            let (sin, cos) = angle.sin_cos();
            let mut off = [scale * radius * cos - squareness * radius * sin + lag * d * sin, 0.0];
            off = [off[0] + bow[1] * sin * sin, off[1] + bow[0] * cos * cos];
            let mut outward = 0.0;
            for (axis, along) in [(0, cos), (1, sin)] {
                // Degrees since the reversal at the axis' maximum, exact for whole degrees.
                let since = (d * (angle_deg - 90.0 * axis as f64)).rem_euclid(360.0);
                let way = if since == 0.0 || since > 180.0 { 1.0 } else { -1.0 };
                let after = if since == 0.0 || since == 180.0 { PI } else { since.rem_euclid(180.0).to_radians() };
                let travelled = radius * (1.0 - after.cos());
                off[axis] -= way * (travelled.min(backlash[axis]) - 0.5 * backlash[axis]);
                outward += along.abs() * spikes[axis][(after / PI * 40_000.0) as usize];
            }
            let tip = [(radius + outward) * cos + off[0] + centre[0], (radius + outward) * sin + off[1] + centre[1]];
            let deviation_mm = tip[0].hypot(tip[1]) - radius + normal.sample(&mut noise);
            readings.push(Reading { angle_rad: angle, deviation_mm, counterclockwise });
        }
    }
    let truth = [
        (Cause::Backlash(0), backlash[0]),
        (Cause::Backlash(1), backlash[1]),
        (Cause::ScaleMismatch, scale),
        (Cause::Squareness, squareness),
    ];
    (radius, readings, truth)
}

fn angles(count: usize, from_deg: f64) -> Vec<f64> {
    (0..count).map(|k| from_deg + 360.0 * k as f64 / count as f64).collect()
}

/// Share of the 95 % bands that contain the true value.
fn held(machines: impl Iterator<Item = (f64, Vec<Reading>, [(Cause, f64); 4])>) -> f64 {
    let mut count = [0.0; 2];
    for (number, (radius, readings, truth)) in machines.enumerate() {
        let found = evaluate(radius, &readings, [None; 2]).unwrap();
        for (cause, truth) in truth {
            let term = found.term(cause).unwrap();
            let off = (term.value - truth).abs();
            count[0] += 1.0;
            if off <= 1.96 * term.standard_error {
                count[1] += 1.0;
            } else {
                println!("{number}: {cause:?} {:.3e} ± {:.3e}, true {truth:.3e}", term.value, term.standard_error);
            }
        }
    }
    println!("{} of {} bands hold", count[1], count[0]);
    count[1] / count[0]
}

/// At 0, 90, 180 and 270° an axis is at its reversal, on the side from which it came: the sign of a rounding error is
/// irrelevant.
#[test]
fn readings_at_whole_degrees_hold_the_truth() {
    let plain = Plane { radius: 150.0, backlash: [0.012, 0.0], scale: [5e-5, 0.0], ..Plane::default() };
    let readings = [true, false].into_iter().flat_map(|counterclockwise| {
        angles(360, 0.0).into_iter().map(move |angle_deg| {
            let angle_rad = angle_deg.to_radians();
            // The reversal belongs to the travel before it.
            let before = if counterclockwise { -1e-12 } else { 1e-12 };
            let deviation_mm = plain.reading(angle_rad + before, counterclockwise);
            Reading { angle_rad, deviation_mm, counterclockwise }
        })
    });
    let found = evaluate(150.0, &readings.collect::<Vec<_>>(), [None; 2]).unwrap();
    assert!((value(&found, Cause::Backlash(0)) - 0.012).abs() < 1e-5, "{}", value(&found, Cause::Backlash(0)));
    assert!((value(&found, Cause::ScaleMismatch) - 5e-5).abs() < 1e-7, "{}", value(&found, Cause::ScaleMismatch));
    assert!(found.left_out >= 8, "{}", found.left_out);
    let share = held((0..36).map(|seed| {
        let leaves = if seed % 3 == 0 { Leaves::Dahl } else { Leaves::Nothing };
        machine(leaves, &angles(360, 0.0), seed)
    }));
    assert!((0.92..=0.98).contains(&share), "{share}");
}

/// Spikes from Dahl and LuGre friction through a drive, and spikes that rise at once.
#[test]
fn spikes_of_other_shapes_widen_the_bands() {
    let all = [Leaves::Dahl, Leaves::LuGre, Leaves::Fast];
    let share = held((0..36).map(|seed| {
        let angles = [angles(360, 0.0), angles(720, 0.25), angles(1440, 0.125)];
        machine(all[seed as usize % 3], &angles[seed as usize / 3 % 3], 1000 + seed)
    }));
    assert!((0.92..=0.98).contains(&share), "{share}");
    let (radius, readings, _) = machine(Leaves::Fast, &angles(720, 0.25), 7);
    assert!(evaluate(radius, &readings, [None; 2]).unwrap().spikes_of_another_shape);
    assert!(held((0..12).map(|seed| machine(Leaves::Nothing, &angles(720, 0.25), seed))) > 0.9);
}

/// F is about the least-squares centre of its direction: a bow moves that centre, which is not the centre of the fit.
#[test]
fn radial_deviation_is_about_the_least_squares_centre() {
    let plane = Plane { radius: 100.0, bow: [0.004, 0.0], centre: [0.02, -0.01], ..Plane::default() };
    let found = evaluate(100.0, &plane.record(720, &[true, false], || 0.0), [None; 2]).unwrap();
    // q cos²θ sin θ = q/4 sin θ + q/4 sin 3θ; the first term moves the centre, so the residual is ± q/4.
    for [most, least] in found.figures.f.map(Option::unwrap) {
        assert!((most - 0.001).abs() < 1e-5 && (least + 0.001).abs() < 1e-5, "{most} {least}");
    }
}

/// 220° in a vertical plane: the causes of whole circles; only F is undefined.
#[test]
fn arcs_determine_the_causes_of_whole_circles() {
    let arc: Vec<f64> = (0..=440).map(|k| 0.5 * f64::from(k) - 20.0).collect();
    let share = held((0..24).map(|seed| {
        let leaves = [Leaves::Nothing, Leaves::Dahl][seed as usize % 2];
        machine(leaves, &arc, 300 + seed)
    }));
    assert!((0.90..=1.0).contains(&share), "{share}");
    let (radius, readings, truth) = machine(Leaves::Nothing, &arc, 300);
    let found = evaluate(radius, &readings, [None; 2]).unwrap();
    assert!(!found.whole_circles && found.figures.f == [None; 2] && found.figures.g_b.is_some());
    for (cause, truth) in truth {
        let off = (value(&found, cause) - truth).abs();
        assert!(off < if cause == Cause::ScaleMismatch { 2e-5 } else { 1e-3 }, "{cause:?} {off}");
    }
    assert!(found.figures.h.unwrap() < 0.03);
}

/// Over repeats with noise the causes scatter with their covariance: with spikes that are high, with small ones, whose width is
/// uncertain, and with spikes within the noise.
#[test]
fn causes_scatter_with_their_covariance() {
    let plane = Plane {
        radius: 100.0,
        scale: [3e-5, 0.0],
        squareness: 40e-6,
        lag: [0.002, 0.0],
        backlash: [0.004, 0.003],
        play: [0.001, 0.0],
        bow: [0.002, 0.0],
        width: 0.06,
        ..Plane::default()
    };
    let normal = Normal::new(0.0, 3e-4).unwrap();
    for (seed, height) in [(1, 6e-3), (2, 6e-4), (3, 2e-4)] {
        let mut causes = vec![
            Cause::Radius,
            Cause::Centre(0),
            Cause::ScaleMismatch,
            Cause::Squareness,
            Cause::ServoMismatch,
            Cause::Backlash(0),
            Cause::Backlash(1),
            Cause::LateralPlay(0),
            Cause::Straightness(0),
        ];
        if height > 1e-3 {
            causes.extend([Cause::Reversal(0), Cause::Reversal(1)]);
        }
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (mut scatter, mut used) = (Scatter::default(), 0);
        for _ in 0..200 {
            let own = Plane { spike: [height; 2], ..plane };
            let found =
                evaluate(100.0, &own.record(90, &[true, false], || normal.sample(&mut random)), [None; 2]).unwrap();
            let places: Vec<usize> =
                causes.iter().map(|cause| found.terms.iter().position(|term| term.cause == *cause).unwrap()).collect();
            // By chance the spikes seem to have another shape, whose height has no covariance.
            if places.iter().any(|i| found.covariance[*i][*i] == 0.0) {
                continue;
            }
            for &i in &places {
                assert!((found.covariance[i][i].sqrt() / found.terms[i].standard_error - 1.0).abs() < 1e-9);
            }
            let values: Vec<f64> = places.iter().map(|i| found.terms[*i].value).collect();
            let covariance: Vec<Vec<f64>> =
                places.iter().map(|i| places.iter().map(|j| found.covariance[*i][*j]).collect()).collect();
            scatter.add(&values, &covariance);
            used += 1;
        }
        assert!(used > 150, "{used}");
        let names: Vec<String> = causes.iter().map(|cause| format!("spikes of {height}: {cause:?}")).collect();
        let largest = scatter.check(&names, 0.1);
        assert!(largest > 0.5, "nothing to compare: {largest}");
    }
}

/// The amplitude of a periodic error is found from two parts: its standard error is that of both, by first order.
#[test]
fn the_amplitude_of_a_periodic_error_scatters_with_its_standard_error() {
    let plane = Plane { radius: 100.0, cyclic: [[0.002, 10.0], [0.0, 10.0]], width: 0.06, ..Plane::default() };
    let normal = Normal::new(0.0, 3e-4).unwrap();
    let (mut random, mut scatter) = (ChaCha8Rng::seed_from_u64(3), Scatter::default());
    for _ in 0..200 {
        let readings = plane.record(180, &[true, false], || normal.sample(&mut random));
        let found = evaluate(100.0, &readings, [Some(10.0), None]).unwrap();
        let place = found.terms.iter().position(|term| term.cause == Cause::Cyclic(0)).unwrap();
        let term = &found.terms[place];
        assert!((found.covariance[place][place].sqrt() / term.standard_error - 1.0).abs() < 1e-9);
        scatter.add(&[term.value], &[vec![found.covariance[place][place]]]);
    }
    scatter.check(&["amplitude".into()], 0.0);
}
