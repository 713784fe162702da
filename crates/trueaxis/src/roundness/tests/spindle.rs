//! Error motion of the spindle, and the arm.

use super::*;

#[test]
fn the_arm_is_compared_with_the_linkage() {
    let mut settings = settings(512, BEST_512, true);
    settings.infeed = None;
    let truth = Truth::new(&settings, 50);
    let mut run = Run::<f64, 512>::new(&settings);
    run.turn(&truth, 2.95, |_| TAU / 6000.0);
    assert!(!run.state.latest().unwrap().flags.has(GaugeFlags::ARM));
    // A wheel dressed down by 30 mm: β is off by up to 0.8°.
    run.gauge.set_wheel(&mut run.state, 270.0).unwrap();
    run.turn(&truth, 2.0, |_| TAU / 6000.0);
    assert!(run.state.latest().unwrap().flags.has(GaugeFlags::ARM));
    run.gauge.set_wheel(&mut run.state, 300.0).unwrap();
    run.turn(&truth, 2.0, |_| TAU / 6000.0);
    assert!(!run.state.latest().unwrap().flags.has(GaugeFlags::ARM));
    assert!(run.gauge.set_wheel(&mut run.state, 17.0).is_err(), "R >= R_S + R_W");
    assert!(run.gauge.set_wheel(&mut run.state, f64::NAN).is_err());
    let still = Gauge::<f64, 64>::build(&small().0, 100_000).unwrap();
    assert!(still.set_wheel(&mut still.start(), 300.0).is_err(), "no arm");
}

#[test]
fn spindle_motion_is_separated_over_the_window() {
    let (mut settings, mut truth) = small();
    settings.revolutions = 4;
    // Synchronous 2 and 3, eccentricity, and a motion that repeats every four revolutions, with an amplitude of ±0.25 µm.
    truth.motion =
        [std::vec![(1.0, 20.0, 0.4), (2.0, 0.7, 1.0), (0.25, 0.25, 0.0)], std::vec![(1.0, 15.0, 1.4), (3.0, 0.4, 0.3)]];
    let mut run = Run::<f64, 64>::new(&settings);
    run.turn(&truth, 6.9, |_| TAU / 2000.0);
    let found = run.state.latest().unwrap();
    assert_eq!(found.revolutions, 4);
    assert!((found.x.synchronous_um - 1.4).abs() < 0.01, "{:?}", found.x);
    assert!((found.y.synchronous_um - 0.8).abs() < 0.01, "{:?}", found.y);
    let amplitude = |[a, b]: [f64; 2]| a.hypot(b);
    assert!((amplitude(found.x.once_per_revolution_um) - 20.0).abs() < 0.01);
    assert!((amplitude(found.y.once_per_revolution_um) - 15.0).abs() < 0.01);
    let [a, b] = found.y.once_per_revolution_um;
    assert!(((-b).atan2(a) - 1.4).abs() < 1e-3, "phase");
    // Four phases a quarter turn apart: the widest pair differs by 0.25·2 when one of them is at its crest.
    assert!((found.x.asynchronous_um - 0.5).abs() < 0.005, "{:?}", found.x);
    assert!(found.y.asynchronous_um < 1e-3);
    assert!((found.x.total_um - found.x.synchronous_um) > 0.3 && found.x.total_um < 1.9 + 0.01);
}

#[test]
fn a_wheel_set_while_the_linkage_is_worked_out_is_taken_next() {
    let settings = settings(512, BEST_512, true);
    let truth = Truth::new(&settings, 50);
    let mut run = Run::<f64, 512>::new(&settings);
    // Covers the beginning of a job and a few hundred of its slices.
    run.turn(&truth, 3.03, |_| TAU / 6000.0);
    run.gauge.set_wheel(&mut run.state, 200.0).unwrap();
    run.turn(&truth, 1.06, |_| TAU / 6000.0);
    run.gauge.set_wheel(&mut run.state, 300.0).unwrap();
    run.turn(&truth, 2.9, |_| TAU / 6000.0);
    assert!(run.state.latest().unwrap().flags.is_empty());
    assert!(run.motion_error(&truth) < 1e-3, "{:e}", run.motion_error(&truth));
}
