//! Setpoints compared with the limits they were planned with, and with analytic motion.

use proptest::prelude::*;
use trueaxis_sim::motion::{DWELL_CYCLES, Motion, MotionError, MotionSettings, Setpoint};
use trueaxis_sim::program::{BUILTIN_NAMES, Curve, Move, Program};
use trueaxis_testing::share::share;

fn program(text: &str) -> Program {
    Program::parse("test", text, "part.ngc").unwrap()
}

fn difference(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]) * (a[i] - b[i])).sum::<f64>().sqrt()
}

fn ceiling(element: &Move, settings: &MotionSettings) -> f64 {
    (if element.rapid { settings.rapid_mm_per_min } else { element.feed_per_min }) / 60.0
}

/// Checks every limit in every cycle. Returns the largest normal acceleration seen.
fn check(program: &Program, settings: MotionSettings) -> f64 {
    let motion = Motion::plan(program, settings).unwrap();
    assert!((motion.length() - program.length()).abs() < 1e-7 * program.length().max(1.0));
    let period = settings.period_s;
    let mut count = 0_u64;
    let mut largest = 0.0_f64;
    let (mut before, mut twice): (Option<Setpoint>, Option<Setpoint>) = (None, None);
    for point in motion.setpoints(program) {
        count += 1;
        let element = &program.moves[point.move_index];
        let feed = ceiling(element, &settings);
        assert_eq!(point.position, element.curve.position(point.u), "on the curve");
        assert!((0.0..=feed * (1.0 + 1e-9) + 1e-9).contains(&point.feed), "{point:?} above {feed}");
        let speed = difference(point.velocity, [0.0; 3]);
        assert!((speed - point.feed).abs() < 1e-9 * feed, "{point:?}");
        let curvature = element.curve.curvature(point.u);
        if curvature.is_finite() {
            largest = largest.max(point.feed * point.feed * curvature);
        }
        if let Some(before) = before {
            assert!(point.length >= before.length - 1e-9 && point.move_index >= before.move_index);
            let change = point.feed - before.feed;
            assert!(
                change.abs() <= settings.acceleration_mm_per_s2 * period * (1.0 + 1e-6) + 1e-6,
                "{before:?} {point:?}"
            );
            let step = difference(point.position, before.position);
            let run = point.length - before.length;
            assert!(step <= run + 1e-7, "chord {step} longer than its arc {run}");
            if let Some(twice) = twice {
                let second = point.feed - 2.0 * before.feed + twice.feed;
                assert!(
                    second.abs() <= settings.jerk_mm_per_s3 * period * period * (1.0 + 1e-6) + 1e-5,
                    "{twice:?} {before:?} {point:?}"
                );
            }
        }
        twice = before;
        before = Some(point);
    }
    assert_eq!(count, motion.cycles());
    let last = before.unwrap();
    assert_eq!((last.feed, last.length), (0.0, motion.length()));
    let (first, end) = (&program.moves[0].curve, &program.moves.last().unwrap().curve);
    assert!(difference(last.position, end.position(end.domain().1)) < 1e-12);
    let dwell = usize::try_from(DWELL_CYCLES).unwrap();
    assert!(
        motion
            .setpoints(program)
            .take(dwell + 1)
            .all(|p| p.feed == 0.0 && p.position == first.position(first.domain().0))
    );
    assert!(motion.setpoints(program).skip(motion.cycles() as usize - dwell).all(|p| p == last));
    largest
}

#[test]
fn builtin_programs_keep_every_limit() {
    for name in BUILTIN_NAMES.into_iter().filter(|name| !["cone-5axis", "s-shape"].contains(name)) {
        let program = Program::builtin(name).unwrap().unwrap();
        let settings = MotionSettings::default();
        let largest = check(&program, settings);
        let motion = Motion::plan(&program, settings).unwrap();
        println!(
            "{name}: {:.3} mm in {:.3} s, {} cycles, normal {largest:.1} mm/s²",
            motion.length(),
            motion.duration(),
            motion.cycles()
        );
        assert!(largest <= settings.normal_acceleration_mm_per_s2 * 1.02, "{name}: {largest}");
    }
}

#[test]
fn a_single_line_takes_the_analytic_time() {
    // Acceleration limit reached, feed reached: T = L/v + v/a + a/j.
    let settings =
        MotionSettings { acceleration_mm_per_s2: 1000.0, jerk_mm_per_s3: 20_000.0, ..MotionSettings::default() };
    let long = program("F6000 G1 X100");
    let motion = Motion::plan(&long, settings).unwrap();
    assert!((motion.duration() - (1.0 + 0.1 + 0.05)).abs() < 1e-9);
    // Half the time is half the length; after a/j and v/a the acceleration ends at v (v/a + a/j) / 2 = 7.5 mm.
    let half = motion.setpoints(&long).find(|p| p.length >= 50.0).unwrap();
    assert!((half.length - 50.0).abs() < 0.02 && half.feed == 100.0);
    let at = motion.setpoints(&long).nth(usize::try_from(DWELL_CYCLES).unwrap() + 1500).unwrap();
    assert!((at.length - 7.5).abs() < 1e-9 && (at.feed - 100.0).abs() < 1e-9);
    assert_eq!(at.position[0], at.u * 100.0);
    // Too short for either: T = 4 ∛(L / (2 j)).
    let short = program("F6000 G1 X0.01");
    let duration = Motion::plan(&short, settings).unwrap().duration();
    assert!((duration - 4.0 * (0.01_f64 / 40_000.0).cbrt()).abs() < 1e-9, "{duration}");
}

#[test]
fn corners_step_no_more_than_permitted() {
    for (junction, expected) in [(1.0, 0.5_f64.sqrt()), (0.0, 0.0)] {
        let settings = MotionSettings { junction_mm_per_s: junction, ..MotionSettings::default() };
        let square = program("F1500 G1 X20\nY20\nX19 Y20\nX30");
        check(&square, settings);
        let motion = Motion::plan(&square, settings).unwrap();
        let points: Vec<Setpoint> = motion.setpoints(&square).collect();
        let slowest = |corner: f64| {
            points.iter().filter(|p| (p.length - corner).abs() < 0.02).map(|p| p.feed).fold(f64::INFINITY, f64::min)
        };
        // Two right angles, then a reversal.
        assert!((slowest(20.0) - expected).abs() < 0.1, "{}", slowest(20.0));
        assert!((slowest(40.0) - expected).abs() < 0.1);
        assert!(slowest(41.0) < 0.1);
        for pair in points.windows(2) {
            let slack = 2.0 * settings.acceleration_mm_per_s2 * settings.period_s;
            assert!(difference(pair[0].velocity, pair[1].velocity) <= junction + slack);
        }
    }
}

#[test]
fn tangent_moves_are_run_through() {
    let slot = program("F1500 G1 X20\nG3 X20 Y20 J10\nG1 X0\nX-5");
    let settings = MotionSettings::default();
    check(&slot, settings);
    let motion = Motion::plan(&slot, settings).unwrap();
    let inside = motion.setpoints(&slot).filter(|p| p.length > 2.0 && p.length < motion.length() - 2.0);
    assert!(inside.map(|p| p.feed).fold(f64::INFINITY, f64::min) > 25.0 - 1e-9);
}

#[test]
fn arcs_slow_down_to_the_normal_acceleration() {
    // 10 mm radius, 1000 mm/s²: 100 mm/s of the 150 mm/s programmed.
    let circle = program("F9000 G3 X0 Y0 I10 P4");
    let settings = MotionSettings { normal_acceleration_mm_per_s2: 1000.0, ..MotionSettings::default() };
    let motion = Motion::plan(&circle, settings).unwrap();
    let fastest = motion.setpoints(&circle).map(|p| p.feed).fold(0.0, f64::max);
    assert!((fastest - 100.0).abs() < 1e-9, "{fastest}");
}

#[test]
fn length_and_parameter_agree_on_the_curve() {
    let program = Program::builtin("butterfly").unwrap().unwrap();
    let motion = Motion::plan(&program, MotionSettings::default()).unwrap();
    let index = program.moves.iter().position(|m| matches!(m.curve, Curve::Nurbs { .. })).unwrap();
    let before: f64 = program.moves[..index].iter().map(|m| m.curve.length()).sum();
    let curve = &program.moves[index].curve;
    let mut checked = 0;
    for point in motion.setpoints(&program).filter(|p| p.move_index == index).step_by(500) {
        let exact = curve.parameter_at(point.length - before);
        assert!((exact - point.u).abs() * curve.speed(point.u) < 1e-8, "{point:?}: {exact}");
        checked += 1;
    }
    assert!(checked > 100);
}

#[test]
fn motion_repeats_exactly() {
    let program = Program::builtin("pocket-3d").unwrap().unwrap();
    let settings = MotionSettings::default();
    let (first, second) = (Motion::plan(&program, settings).unwrap(), Motion::plan(&program, settings).unwrap());
    assert!(first.setpoints(&program).eq(second.setpoints(&program)));
    assert_eq!(first.setpoints(&program).len() as u64, first.cycles());
}

#[test]
fn settings_out_of_range_are_refused() {
    let program = program("F1 G1 X1");
    let good = MotionSettings::default();
    for (settings, field) in [
        (MotionSettings { period_s: 0.0, ..good }, "period_s"),
        (MotionSettings { acceleration_mm_per_s2: f64::NAN, ..good }, "acceleration_mm_per_s2"),
        (MotionSettings { jerk_mm_per_s3: -1.0, ..good }, "jerk_mm_per_s3"),
        (MotionSettings { rapid_mm_per_min: f64::INFINITY, ..good }, "rapid_mm_per_min"),
        (MotionSettings { normal_acceleration_mm_per_s2: 0.0, ..good }, "normal_acceleration_mm_per_s2"),
        (MotionSettings { junction_mm_per_s: -0.1, ..good }, "junction_mm_per_s"),
    ] {
        let error = Motion::plan(&program, settings).unwrap_err();
        assert!(matches!(error, MotionError::Setting { setting, .. } if setting == field), "{error}");
    }
    let empty = Program {
        name: String::new(),
        file: String::new(),
        moves: Vec::new(),
        notes: Vec::new(),
        first: Default::default(),
    };
    assert_eq!(Motion::plan(&empty, good).unwrap_err(), MotionError::Empty);
    // Seventeen hours in one move.
    let slow = self::program("F1 G1 X1000");
    assert!(
        (Motion::plan(&slow, MotionSettings { period_s: 0.01, ..good }).unwrap().duration() - 60_000.0).abs() < 1.0
    );
    let endless = self::program("F0.000001 G1 X1000000");
    assert!(matches!(Motion::plan(&endless, good), Err(MotionError::TooLong(_))));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: share(600) as u32, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_paths_keep_every_limit(
        moves in prop::collection::vec((0_usize..5, -3.0..3.0_f64, -3.0..3.0_f64, -4.0..0.5_f64), 1..25),
        feed in 100.0..9000.0_f64,
        acceleration in 200.0..10_000.0_f64,
        jerk in 5_000.0..1.0e6_f64,
        junction in 0.0..20.0_f64,
    ) {
        let mut text = format!("F{feed:.3}\nG91\n");
        for (kind, x, y, size) in moves {
            let size = 10_f64.powf(size);
            let (x, y) = (x * size, y * size);
            text += &match kind {
                0 => format!("G0 X{x:.6} Y{y:.6}\n"),
                1 => format!("G1 X{x:.6} Z{y:.6}\n"),
                2 => format!("G2 I{:.6} J{y:.6} Z{size:.6}\n", x.abs() + 0.01),
                3 => format!("G5.2 X{x:.6} Y{y:.6} P1 L4\nX{y:.6} Y{x:.6} P2\nX{size:.6} Y0.1 P1\nX{size:.6} Y0.5 P1\nG5.3\n"),
                _ => format!("G1 X{size:.6}\n"),
            };
        }
        let program = program(&text);
        prop_assume!(!program.moves.is_empty());
        let settings = MotionSettings { acceleration_mm_per_s2: acceleration, jerk_mm_per_s3: jerk, junction_mm_per_s: junction, period_s: 1.0e-3, ..MotionSettings::default() };
        check(&program, settings);
    }
}
