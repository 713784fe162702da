use super::sample::{machine, set_table};
use super::*;
use std::f64::consts::TAU;
use trueaxis::machine::Twist;

const PERIOD: f64 = 1e-4;

/// A mill with errors in every component.
fn mill() -> Machine {
    let mut m = machine("w X' b Y Z t");
    for (i, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
        let rows: Vec<(f64, Twist)> = (0..81)
            .map(|k| {
                let q = -400.0 + 10.0 * f64::from(k);
                let errors = |n: usize| (q / (130.0 + 17.0 * n as f64) + (i + n) as f64).sin();
                (q, std::array::from_fn(|n| errors(n) * if n < 3 { 0.012 } else { 25e-6 }))
            })
            .collect();
        set_table(&mut m, axis, &rows);
        m.settings.axes[i].backlash = 3e-3;
    }
    m.settings.location.c0y = 18e-6;
    m
}

fn plant(machine: &Machine, perfect: bool, seed: u64) -> Plant {
    Plant::new(machine, PlantSettings::default(), perfect, seed, PERIOD).unwrap()
}

/// Command on a circle in XY about the origin, accelerated to its feed within half a second.
fn circle(radius: f64, feed: f64, t: f64) -> [f64; AXES] {
    let run_up = 0.5;
    let travel = if t < run_up { feed * t * t / (2.0 * run_up) } else { feed * (t - run_up / 2.0) };
    let angle = travel / radius + 0.7;
    [radius * angle.cos(), radius * angle.sin(), 0.0, 0.0, 0.0, 0.0]
}

/// Angle (rad) and radial deviation (µm) of the true tip over one turn after the run-up.
fn radial(plant: &mut Plant, radius: f64, feed: f64) -> Vec<(f64, f64)> {
    plant.rest_at(&circle(radius, feed, 0.0));
    let turn_s = TAU * radius / feed;
    let cycles = ((turn_s + 1.0) / PERIOD) as u64;
    let mut deviations = Vec::new();
    for k in 1..=cycles {
        let t = k as f64 * PERIOD;
        plant.cycle(&circle(radius, feed, t));
        if t > 1.0 {
            let [x, y, _] = plant.true_tip();
            deviations.push((y.atan2(x), 1e3 * (x.hypot(y) - radius)));
        }
    }
    deviations
}

#[test]
fn repeats_with_its_seed_and_servo_noise_does_not_depend_on_geometry() {
    let machine = mill();
    let run = |perfect, seed| {
        let mut plant = plant(&machine, perfect, seed);
        let mut readings = Vec::new();
        for k in 0..4000 {
            let command = circle(30.0, 25.0, f64::from(k) * PERIOD).map(|q| q - 20.0);
            readings.push(plant.cycle(&command));
        }
        (readings, plant.true_tip())
    };
    let (readings, tip) = run(false, 3);
    assert_eq!((readings.clone(), tip), run(false, 3));
    let (perfect, ideal_tip) = run(true, 3);
    assert_eq!(readings, perfect);
    assert!((0..3).any(|i| (tip[i] - ideal_tip[i]).abs() > 5e-3), "{tip:?} {ideal_tip:?}");
    assert_ne!(readings, run(false, 4).0);
}

#[test]
fn a_perfect_machine_stays_round_but_for_its_quadrants() {
    let mut plant = plant(&machine("w X' b Y Z t"), true, 1);
    let samples = radial(&mut plant, 50.0, 25.0);
    let mut glitches = [0f64; 4];
    let (mut smooth, mut count) = (0.0, 0.0);
    let mut worst: f64 = 0.0;
    for &(angle, deviation) in &samples {
        worst = worst.max(deviation.abs());
        // A reversal and its effect: 10° either side of each axis.
        let quarter = (angle / (TAU / 4.0)).round();
        if (angle - quarter * TAU / 4.0).abs() < 10f64.to_radians() {
            let glitch = &mut glitches[quarter.rem_euclid(4.0) as usize];
            *glitch = glitch.max(deviation.abs());
        } else {
            smooth += deviation * deviation;
            count += 1.0;
        }
    }
    let rms = (smooth / f64::max(count, 1.0)).sqrt();
    println!("circle R 50 mm, 1500 mm/min: worst {worst:.2} µm, glitches {glitches:.2?} µm, rms elsewhere {rms:.2} µm");
    assert!(glitches.iter().all(|glitch| (1.0..3.0).contains(glitch)), "{glitches:?}");
    assert!((0.05..1.0).contains(&rms), "{rms}");
    assert!(worst < 3.0, "{worst}");
}

#[test]
fn circles_of_other_radii_and_feeds_stay_round_too() {
    for (radius, feed) in [(10.0, 16.0), (100.0, 50.0), (25.0, 80.0)] {
        let mut plant = plant(&machine("w X' b Y Z t"), true, 1);
        let worst = radial(&mut plant, radius, feed).iter().map(|s| s.1.abs()).fold(0.0, f64::max);
        println!("circle R {radius} mm, {feed} mm/s: worst {worst:.2} µm");
        assert!((0.5..4.0).contains(&worst), "{worst}");
    }
}

#[test]
fn every_axis_lags_as_designed() {
    let mut plant = plant(&machine("w X' b Y Z t"), true, 1);
    let velocity = [25.0, -25.0, 10.0];
    let mut command = [0.0; AXES];
    for k in 0..20_000 {
        (0..3).for_each(|i| command[i] = velocity[i] * f64::from(k + 1) * PERIOD);
        plant.cycle(&command);
    }
    for (i, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
        let drive = DriveSettings::of(axis);
        let designed = velocity[i] * (1.0 - drive.velocity_feed_forward) / drive.position_gain_per_s;
        let lag = command[i] - plant.axis_positions()[i];
        println!("{axis:?}: lag {:.2} µm at {} mm/s, designed {:.2} µm", 1e3 * lag, velocity[i], 1e3 * designed);
        // Subdivisional error and noise of the encoder remain.
        assert!((lag - designed).abs() < 1e-4, "{axis:?}: {lag}, designed {designed}");
    }
}

#[test]
fn negative_travel_stays_behind_by_the_backlash() {
    let mut m = machine("w X' b Y Z t");
    m.settings.axes[0].backlash = 8e-3;
    m.settings.axes[1].backlash = 5e-3;
    let mut plant = plant(&m, false, 1);
    let behind = |plant: &Plant, i: usize| plant.true_tip()[i] - plant.axis_positions()[i];
    let mut command = [0.0; AXES];
    let mut travel = |plant: &mut Plant, velocity: f64, cycles: u32| {
        let mut passed = Vec::new();
        for _ in 0..cycles {
            command[0] += velocity * PERIOD;
            command[1] -= velocity * PERIOD;
            plant.cycle(&command);
            passed.push((behind(plant, 0), plant.true_tip()[0]));
        }
        passed
    };
    travel(&mut plant, 5.0, 2000);
    assert!(behind(&plant, 0).abs() < 1e-12);
    assert!((behind(&plant, 1) - 5e-3).abs() < 1e-12);
    let reversal = travel(&mut plant, -5.0, 2000);
    assert!((behind(&plant, 0) - 8e-3).abs() < 1e-12);
    assert!(behind(&plant, 1).abs() < 1e-12);
    // Within the play the carriage is at rest: several cycles at one position, between both ends.
    let inside: Vec<f64> = reversal.iter().filter(|(b, _)| *b > 1e-9 && *b < 8e-3 - 1e-9).map(|s| s.1).collect();
    assert!(inside.len() > 10, "{}", inside.len());
    let spread = inside.iter().copied().fold(f64::MIN, f64::max) - inside.iter().copied().fold(f64::MAX, f64::min);
    assert!(spread < 1e-9, "{spread}");
    travel(&mut plant, 5.0, 2000);
    assert!(behind(&plant, 0).abs() < 1e-12);
}

#[test]
fn the_true_tip_at_rest_is_the_position_plus_the_exact_error() {
    let machine = mill();
    let mut plant = plant(&machine, false, 1);
    let at = [120.0, -40.0, 210.0, 0.0, 0.0, 0.0];
    plant.rest_at(&at);
    let error = Geometry::new(&machine, 0.0).unwrap().tip_error(&at, &[0.0; AXES]);
    let tip = plant.true_tip();
    assert!((0..3).all(|i| (tip[i] - at[i] - error[i]).abs() < 1e-12), "{tip:?} {error:?}");
    assert_eq!(plant.true_pose().tip_mm.map(|v| (v * 1e9).round()), tip.map(|v| (v * 1e9).round()));
}

#[test]
fn readings_stay_with_the_axis_within_what_the_encoder_adds() {
    let mut plant = plant(&mill(), false, 2);
    let mut worst: f64 = 0.0;
    for k in 0..20_000 {
        let readings = plant.cycle(&circle(20.0, 25.0, f64::from(k) * PERIOD).map(|q| q - 15.0));
        for (i, q) in plant.axis_positions().into_iter().enumerate().take(3) {
            worst = worst.max((readings.position[i] - q).abs());
            assert_eq!(readings.position[i], readings.counts[i] as f64 * plant.resolutions()[i]);
        }
    }
    // 39 nm of subdivisional error at most, 5 nm of rounding, five deviations of 5 nm noise.
    assert!((30e-6..70e-6).contains(&worst), "{worst}");
}

#[test]
fn scripted_faults_reach_the_readings_and_not_the_drives() {
    let machine = mill();
    let specs = ["dropout:X@0.01s+3", "glitch:Y@0.02s+1=5mm", "stuck:Z@0.03s+50", "late@0.2s+1=2.5"];
    let settings = PlantSettings { faults: FaultScript::parse(specs).unwrap(), ..PlantSettings::default() };
    let mut faulty = Plant::new(&machine, settings, false, 9, PERIOD).unwrap();
    let mut sound = plant(&machine, false, 9);
    let mut held = 0;
    for k in 0..2000_u32 {
        let command = [25.0, 20.0, 15.0, 0.0, 0.0, 0.0].map(|v| v * f64::from(k + 1) * PERIOD);
        let (bad, good) = (faulty.cycle(&command), sound.cycle(&command));
        assert_eq!(faulty.true_tip(), sound.true_tip());
        let missing = (100..103).contains(&k);
        assert_eq!(bad.valid, [!missing, true, true, true, true, true]);
        assert_eq!(bad.position[0].is_nan(), missing);
        let glitch = if k == 200 { 500_000 } else { 0 };
        assert_eq!(bad.counts[1], good.counts[1] + glitch);
        if !(300..350).contains(&k) {
            held = good.counts[2];
        }
        assert_eq!(bad.counts[2], held, "cycle {k}");
        assert_eq!(bad.elapsed_periods, 1.0);
    }
    // The late cycle: the drives have 150 µs more to approach the same command.
    let command = [25.0, 20.0, 15.0, 0.0, 0.0, 0.0].map(|v| v * 2001.0 * PERIOD);
    assert_eq!(faulty.cycle(&command).elapsed_periods, 2.5);
    sound.cycle(&command);
    let ahead = faulty.axis_positions()[0] - sound.axis_positions()[0];
    assert!(ahead > 1e-3 && ahead < 25.0 * 1.5 * PERIOD * 1.1, "{ahead}");
}

#[test]
fn a_wrong_scale_counts_from_the_last_right_reading() {
    let faults = FaultScript::parse([format!("scale:X@{}s+20=-0.5", 30.0 * PERIOD)]).unwrap();
    let settings = PlantSettings { faults, ..PlantSettings::default() };
    let mut faulty = Plant::new(&mill(), settings, false, 9, PERIOD).unwrap();
    let mut sound = Plant::new(&mill(), PlantSettings::default(), false, 9, PERIOD).unwrap();
    let mut last = 0;
    for cycle in 0..60 {
        let command = [0.01 * f64::from(cycle); AXES];
        let [right, wrong] = [&mut sound, &mut faulty].map(|plant| plant.cycle(&command).counts);
        assert_eq!(right[1..], wrong[1..]);
        if (30..50).contains(&cycle) {
            assert_eq!(wrong[0], last + (-0.5 * (right[0] - last) as f64).round() as i64, "{cycle}");
        } else {
            assert_eq!(wrong[0], right[0], "{cycle}");
            last = right[0];
        }
    }
    assert!(last > 1000);
}

#[test]
fn scripted_commands_are_disturbed_once() {
    let faults = FaultScript::parse(["nan-command:X@0s+1", "jump-command:Z@0.0001s+1=3mm"]).unwrap();
    let settings = PlantSettings { faults, ..PlantSettings::default() };
    let mut plant = Plant::new(&mill(), settings, false, 9, PERIOD).unwrap();
    let commands = [0, 1, 2].map(|_| {
        let mut command = [1.0; AXES];
        plant.disturb_command(&mut command);
        plant.cycle(&[0.0; AXES]);
        command
    });
    assert!(commands[0][0].is_nan() && commands[0][1..] == [1.0; 5]);
    assert_eq!(commands[1], [1.0, 1.0, 4.0, 1.0, 1.0, 1.0]);
    assert_eq!(commands[2], [1.0; AXES]);
}

#[test]
fn an_unusable_plant_is_refused() {
    for period_s in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9, 1.0] {
        let refused = Plant::new(&mill(), PlantSettings::default(), false, 1, period_s);
        assert!(matches!(refused, Err(PlantError::Period { .. })), "{period_s}");
    }
    let faults = FaultScript::parse(["stuck:C@1s+1"]).unwrap();
    let settings = PlantSettings { faults, ..PlantSettings::default() };
    let refused = Plant::new(&mill(), settings, false, 1, PERIOD).unwrap_err();
    assert_eq!(refused, PlantError::FaultAxis { axis: 'C' });
}
