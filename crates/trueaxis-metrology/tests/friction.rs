//! Friction and drive figures from circles that an integration of its own has made.

use crate::plant::{Circle, Commands, commands, read_within, readings};
use std::f64::consts::TAU;
use std::sync::OnceLock;
use trueaxis::Axis;
use trueaxis::machine::{DriveFigures, FrictionSettings};
use trueaxis_metrology::friction::{Figure, Identified, Record, Recorded, Refused, circles, identify};

const DRIVE: DriveFigures = DriveFigures {
    position_gain_per_s: 110.0,
    velocity_gain_per_s: 800.0,
    reset_time_s: 0.006,
    velocity_feed_forward: 0.93,
    current_loop_s: 2.5e-4,
    dead_time_s: 0.0,
};
const FRICTION: FrictionSettings = FrictionSettings {
    coulomb_per_s: 0.525,
    stribeck_share: 0.3,
    stribeck_velocity_per_s: 2.0,
    presliding: 0.006,
    viscous: 0.005,
    lead_s: 0.0,
};

/// Two feeds, each in both directions, from rest to rest.
const CIRCLES: [Circle; 4] = [(20.003, 25.0, 1.5), (20.003, -25.0, 1.5), (20.003, 10.0, 1.5), (20.003, -10.0, 1.5)];

fn times(count: usize, period_s: f64) -> Vec<f64> {
    (0..count).map(|k| k as f64 * period_s).collect()
}

fn record(circles: &[Circle], period_s: f64, ramp_s: f64, drive: &DriveFigures, friction: &FrictionSettings) -> Record {
    let [x, y] = commands(circles, period_s, ramp_s);
    let read = [readings(&x, period_s, drive, friction, 1), readings(&y, period_s, drive, friction, 2)];
    let stamps = times(x.len(), period_s);
    let [read_x, read_y] = read;
    let axes = [
        Recorded { axis: Axis::X, command: x, reading: read_x },
        Recorded { axis: Axis::Y, command: y, reading: read_y },
    ];
    Record::new(&stamps, axes).unwrap()
}

/// X and Y of the standard circles, simulated once.
fn standard() -> &'static Record {
    static RECORD: OnceLock<Record> = OnceLock::new();
    RECORD.get_or_init(|| record(&CIRCLES, 1e-4, 0.05, &DRIVE, &FRICTION))
}

fn found(record: &Record, given: Option<DriveFigures>) -> Result<[Identified; 2], Refused> {
    identify(record, [given, given], &mut |_, _| ())
}

/// Within four standard errors, or within `tolerance` of the truth, what the subdivisional error bends all reversals by.
#[track_caller]
fn near(what: &str, figure: Figure, truth: f64, tolerance: f64) {
    let error = figure.standard_error.unwrap_or(0.0);
    let off = (figure.value - truth).abs();
    assert!(off <= 4.0 * error || off <= tolerance * truth, "{what}: {figure:?}, true {truth}");
    assert!(error < 0.1 * truth.max(0.1 * figure.value), "{what}: {figure:?}");
}

#[test]
fn drive_and_friction_come_back_from_circles_that_start_and_stop() {
    for found in found(standard(), None).unwrap() {
        near("F_c", found.coulomb_per_s, FRICTION.coulomb_per_s, 0.03);
        near("s", found.stribeck_share, FRICTION.stribeck_share, 0.03);
        near("v_s", found.stribeck_velocity_per_s, FRICTION.stribeck_velocity_per_s, 0.03);
        near("z", found.presliding, FRICTION.presliding, 0.03);
        let [gain, velocity_gain, reset, feed] = found.drive_errors.unwrap();
        let drive = &found.drive;
        let figure = |value, error| Figure { value, standard_error: Some(error) };
        near("K_v", figure(drive.position_gain_per_s, gain), DRIVE.position_gain_per_s, 0.0);
        near("K_vp", figure(drive.velocity_gain_per_s, velocity_gain), DRIVE.velocity_gain_per_s, 0.03);
        near("tau", figure(drive.reset_time_s, reset), DRIVE.reset_time_s, 0.02);
        near("k_ff", figure(drive.velocity_feed_forward, feed), DRIVE.velocity_feed_forward, 0.0);
        assert!(gain < 8.0, "{gain}");
        // The readings' own errors: 30 and 15 nm of subdivisional error, 5 nm of noise, 10 nm counts.
        assert!((2.2e-5..2.7e-5).contains(&found.residual_rms), "{}", found.residual_rms);
        let glitch = &found.glitch;
        assert!(glitch.explained > 0.99, "{}", glitch.explained);
        assert!(glitch.before.largest > 1.5e-3, "{:?}", glitch.before);
        assert!(glitch.after.largest < 0.1 * glitch.before.largest, "{:?}", glitch.after);
        assert!(glitch.after.rms < 0.06 * glitch.before.rms, "{:?}", glitch.after);
    }
}

/// The same circles with the feed-forward in the drive's command: the spikes are gone in the plant, not only in the model.
#[test]
fn the_feed_forward_of_what_was_found_takes_the_spikes_away() {
    let [found, _] = found(standard(), Some(DRIVE)).unwrap();
    near("F_c", found.coulomb_per_s, FRICTION.coulomb_per_s, 0.02);
    near("s", found.stribeck_share, FRICTION.stribeck_share, 0.05);
    near("v_s", found.stribeck_velocity_per_s, FRICTION.stribeck_velocity_per_s, 0.05);
    near("z", found.presliding, FRICTION.presliding, 0.03);
    assert_eq!((found.drive, found.drive_errors), (DRIVE, None));
    let path = &standard().axes[0].command;
    let offsets = found.feed_forward(path, 1e-4);
    let driven: Vec<f64> = path.iter().zip(&offsets).map(|(path, offset)| path + offset).collect();
    let corrected = readings(&driven, 1e-4, &DRIVE, &FRICTION, 1);
    let plain = readings(path, 1e-4, &DRIVE, &FRICTION, 1);
    let calm = readings(path, 1e-4, &DRIVE, &FrictionSettings { coulomb_per_s: 0.0, ..FRICTION }, 1);
    // After the first start, at which the feed-forward does not know in what state friction was left.
    let largest = |read: &[f64]| read.iter().zip(&calm).skip(5000).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let [before, after] = [largest(&plain), largest(&corrected)];
    assert!(before > 1.5e-3 && after < 0.12 * before, "{before} mm before, {after} mm after");
}

/// The radius of the readings less that of a drive without Coulomb friction, by the angle of the command.
#[test]
fn circles_show_what_friction_adds_to_the_radius() {
    let record = standard();
    let found = found(record, Some(DRIVE)).unwrap();
    let calm = FrictionSettings { coulomb_per_s: 0.0, viscous: 0.0, ..FRICTION };
    let radius = |k: usize, axes: [&[f64]; 2]| axes[0][k].hypot(axes[1][k]);
    let [x, y] = [0, 1].map(|i| readings(&record.axes[i].command, 1e-4, &DRIVE, &calm, 1 + i as u64));
    let truth: Vec<[f64; 2]> = (0..x.len())
        .map(|k| {
            let [cx, cy] = [0, 1].map(|i| record.axes[i].command[k]);
            let read = [&record.axes[0].reading[..], &record.axes[1].reading[..]];
            [cy.atan2(cx).rem_euclid(TAU), radius(k, read) - radius(k, [&x, &y])]
        })
        .collect();
    let circles = circles(record, &found).unwrap();
    assert_eq!(circles.len(), CIRCLES.len());
    let mut from = 0;
    for (circle, (radius, feed, turns)) in circles.iter().zip(CIRCLES) {
        let to = from + ((0.1 + TAU * radius * turns / feed.abs() + 0.05) * 1e4) as usize;
        assert!((circle.radius - radius).abs() < 1e-3 * radius, "{}", circle.radius);
        assert!((circle.feed_per_s - feed.abs()).abs() < 1e-2 * feed.abs(), "{}", circle.feed_per_s);
        assert_eq!(circle.counterclockwise, feed > 0.0);
        assert!((circle.turns - turns).abs() < 1e-2, "{}", circle.turns);
        // Away from the start, where the turns' ends differ.
        let inner = &truth[from + 3000..(to - 1000).min(truth.len())];
        let mut largest: f64 = 0.0;
        for (angle, before) in circle.angle.iter().zip(&circle.before) {
            let near = inner.iter().filter(|[other, _]| (other - angle).abs() < 2e-3).map(|[_, value]| *value);
            let (sum, count) = near.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
            let mean = sum / f64::from(count);
            assert!((before - mean).abs() < 2.5e-4, "{before} mm at {angle}, true {mean} mm");
            largest = largest.max(before.abs());
        }
        assert!(largest > 1e-3, "{largest}");
        let size = |curve: &[f64]| curve.iter().fold(0.0, |top: f64, value| top.max(value.abs()));
        assert!(size(&circle.after) < 0.25 * size(&circle.before), "{} mm after", size(&circle.after));
        from = to;
    }
}

#[test]
fn at_one_kilohertz_too() {
    let record = record(&CIRCLES, 1e-3, 0.05, &DRIVE, &FRICTION);
    for found in found(&record, Some(DRIVE)).unwrap() {
        near("F_c", found.coulomb_per_s, FRICTION.coulomb_per_s, 0.05);
        near("z", found.presliding, FRICTION.presliding, 0.15);
        assert!(found.glitch.after.rms < 0.15 * found.glitch.before.rms, "{:?}", found.glitch.after);
    }
}

/// How the drive takes its commands and when in the cycle its encoder is read is no friction: none of it viscous, the rest as
/// it is.
#[test]
fn what_is_found_does_not_depend_on_when_the_encoder_is_read() {
    let friction = FrictionSettings { viscous: 0.0, ..FRICTION };
    {
        for (commands_taken, share) in [(Commands::Sampled, 0.0), (Commands::Held, 1.0), (Commands::Linear, 0.5)] {
            let [x, y] = commands(&CIRCLES, 1e-3, 0.05);
            let read =
                |command: &[f64], seed| read_within(command, 1e-3, (&DRIVE, &friction), seed, (commands_taken, share));
            let axis = |axis, command: &Vec<f64>, seed| Recorded {
                axis,
                command: command.clone(),
                reading: read(command, seed),
            };
            let record = Record::new(&times(x.len(), 1e-3), [axis(Axis::X, &x, 1), axis(Axis::Y, &y, 2)]).unwrap();
            let what = format!("{commands_taken:?}, read after {share} of the cycle");
            for found in found(&record, Some(DRIVE)).unwrap() {
                near(&what, found.coulomb_per_s, friction.coulomb_per_s, 0.03);
                near(&what, found.presliding, friction.presliding, 0.05);
                let viscous = found.viscous;
                let band = 3.0 * viscous.standard_error.unwrap_or(0.0);
                assert!(viscous.value <= band, "{what}: viscous {viscous:?}");
                // A held command acts half a cycle later than it came; a loop closed once a cycle stands on readings as old.
                let acts = if matches!(commands_taken, Commands::Held) { 0.5 } else { 0.0 };
                let lag = 1e-3 * (acts - share);
                assert!((found.reading_lag_s.value - lag).abs() < 1e-5, "{what}: {:?}", found.reading_lag_s);
            }
        }
    }
}

/// Beside a drive that is found the record hardly tells when the encoder is read: what is stated is used, what is not known is in
/// the uncertainties.
#[test]
fn the_drive_found_is_as_uncertain_as_the_time_at_which_the_encoder_is_read() {
    let period_s = 1e-4;
    let [x, y] = commands(&CIRCLES, period_s, 0.05);
    let late = (Commands::Linear, 1.0);
    let recorded = |axis, command: &Vec<f64>, seed| Recorded {
        axis,
        command: command.clone(),
        reading: read_within(command, period_s, (&DRIVE, &FRICTION), seed, late),
    };
    let axes = [recorded(Axis::X, &x, 1), recorded(Axis::Y, &y, 2)];
    let mut record = Record::new(&times(x.len(), period_s), axes).unwrap();
    let gain = |record: &Record| {
        let [found, _] = found(record, None).unwrap();
        (found.drive.position_gain_per_s - DRIVE.position_gain_per_s, found.drive_errors.unwrap()[0])
    };
    let [untimed, timed] = [None, Some(period_s)].map(|read_after_s| {
        record.read_after_s = read_after_s;
        gain(&record)
    });
    assert!(untimed.0.abs() > 5.0 && untimed.0.abs() < 3.0 * untimed.1, "{untimed:?}");
    assert!(timed.0.abs() < 5.0 && timed.0.abs() < 2.0 * timed.1, "{timed:?}");
    assert!(timed.1 < 0.5 * untimed.1, "{timed:?}, {untimed:?}");
}

#[test]
fn a_record_that_does_not_tell_the_drive_is_refused_unless_its_figures_are_given() {
    // Ramps of two seconds: hardly an acceleration along the path.
    let record = record(&CIRCLES, 1e-3, 2.0, &DRIVE, &FRICTION);
    let refused = found(&record, None).unwrap_err();
    assert!(!matches!(refused, Refused::NotExplained { .. } | Refused::NoFriction { .. }), "{refused}");
    assert!(refused.to_string().contains("--machine"), "{refused}");
    found(&record, Some(DRIVE)).unwrap();
}

#[test]
fn an_axis_without_friction_is_refused() {
    let record = record(&CIRCLES, 1e-3, 0.05, &DRIVE, &FrictionSettings { coulomb_per_s: 1e-9, ..FRICTION });
    let refused = found(&record, Some(DRIVE)).unwrap_err();
    assert!(
        matches!(refused, Refused::NoFriction { .. } | Refused::NotExplained { .. } | Refused::NotExcited { .. }),
        "{refused}"
    );
}

/// A record whose readings lag evenly: enough for what is refused without a fit.
fn lagging(circles: &[Circle], change: impl Fn(f64, f64) -> [f64; 2]) -> Result<Record, Refused> {
    let [x, y] = commands(circles, 1e-3, 0.05);
    let stamps = times(x.len(), 1e-3);
    let axis = |axis, command: &[f64]| {
        let pairs = command.iter().enumerate().map(|(k, &c)| change(c, command[k.saturating_sub(1)]));
        let (command, reading) = pairs.map(|[c, x]| (c, x)).unzip();
        Recorded { axis, command, reading }
    };
    Record::new(&stamps, [axis(Axis::X, &x), axis(Axis::Y, &y)])
}

fn why(record: Result<Record, Refused>) -> String {
    record.and_then(|record| found(&record, Some(DRIVE))).unwrap_err().to_string()
}

#[test]
fn records_of_other_motions_are_refused_with_their_figures() {
    let even = |c, x| [c, x];
    let cases = [
        (vec![(40.0, 20.0, 0.15), (40.0, -20.0, 0.15)], "axis X: found 0 reversals in motion, needed at least 4"),
        (vec![(20.0, 20.0, 2.0), (20.0, 10.0, 2.0)], "needed at least 2 of each: circles in both directions"),
        (vec![(20.0, 20.0, 2.0), (20.0, -20.0, 2.0)], "circles of two radii or at two feeds"),
        (vec![(1.0, 20.0, 1.0)], "samples, needed at least 2000"),
    ];
    for (circles, needed) in cases {
        let why = why(lagging(&circles, even));
        assert!(why.contains(needed), "{why}");
    }
}

#[test]
fn wrong_units_are_refused_with_their_figures() {
    /// A command and a reading as some other file has them.
    type Slip = fn(f64, f64) -> [f64; 2];
    let cases: [(Slip, &str); 5] = [
        (|c, x| [1e-3 * c, 1e-3 * x], "needed 0.5 to 20000 mm: positions in mm"),
        (|c, x| [c, 1e3 * x], "both in mm, of the same axis"),
        (|c, x| [1e3 * c, 1e3 * x], "0.5 to 20000 mm"),
        (|c, _| [c, c], "readings that equal the commands"),
        (|c, _| [c, -c], "at most a tenth of them"),
    ];
    for (change, needed) in cases {
        let why = why(lagging(&CIRCLES, change));
        assert!(why.contains(needed) && why.starts_with("axis X: found "), "{why}");
    }
}

#[test]
fn time_stamps_have_to_be_even_and_in_seconds() {
    let [x, y] = commands(&CIRCLES, 1e-3, 0.05);
    let axis = |axis, command: &Vec<f64>| Recorded { axis, command: command.clone(), reading: command.clone() };
    let refused = |stamps: &[f64]| Record::new(stamps, [axis(Axis::X, &x), axis(Axis::Y, &y)]).unwrap_err().to_string();
    let stamps = times(x.len(), 1e-3);
    let mut gap = stamps.clone();
    gap[5000..].iter_mut().for_each(|t| *t += 0.25);
    assert!(refused(&gap).starts_with("found 0.251000 s from sample 4999 to sample 5000, needed 0.001000 s"));
    let mut twice = stamps.clone();
    twice[100] = twice[99];
    assert!(refused(&twice).starts_with("found 0.000000 s from sample 99"), "{}", refused(&twice));
    let milliseconds: Vec<f64> = stamps.iter().map(|t| 1e3 * t).collect();
    assert!(refused(&milliseconds).contains("needed 0.00001 to 0.002 s: t_s in seconds"));
}
