//! The dynamic correction in the step: its laws compared with the continuous ones, its limits across every transition.

use super::transitions::{Do, any_doing};
use super::*;
use crate::Axis;
use crate::contour::{Segment, convert};
use crate::dynamic::Dynamics;
use crate::machine::{
    AxisServo, CrosstalkSettings, DriveFigures, DynamicSettings, FeedbackSettings, FrictionSettings, Limits,
};
use crate::telemetry::Status;

pub(super) const DRIVE: DriveFigures = DriveFigures {
    position_gain_per_s: 100.0,
    velocity_gain_per_s: 800.0,
    reset_time_s: 0.006,
    velocity_feed_forward: 0.9,
    current_loop_s: 2.5e-4,
    dead_time_s: 0.0,
    resonance_hz: 0.0,
    resonance_damping: 0.0,
    lowest_resonance_hz: 5000.0,
    gain_without_notch: 0.0,
};
const FRICTION: FrictionSettings = FrictionSettings {
    coulomb_per_s: 0.5,
    stribeck_share: 0.3,
    stribeck_velocity_per_s: 2.0,
    presliding: 0.006,
    viscous: 0.005,
    lead_s: 0.0,
    adapt: 0.0,
};
/// Wide enough never to bind here.
const WIDE: Limits = Limits { magnitude: 0.09, slope_per_s: 5.0, acceleration_per_s2: 5000.0 };

fn dynamic(lag: bool, acceleration: bool, take_up: bool) -> Option<DynamicSettings> {
    Some(DynamicSettings { limits: WIDE, lag, acceleration, take_up, lag_s: 0.0 })
}

/// Every part on, on every axis.
fn everything(axis: &mut AxisSettings) {
    axis.servo = AxisServo { drive: Some(DRIVE), friction: Some(FRICTION), dynamic: dynamic(true, true, true) };
}

fn with_feedback(change: impl Fn(&mut AxisSettings)) -> MachineSettings {
    let mut machine = machine(change);
    machine.contour.feedback = Some(FeedbackSettings::default());
    machine
}

/// A cycle without a path.
fn cycle(servo: &Loop, state: &mut State<f64, f64, 3>, input: &Input<f64, 3>) -> Out {
    servo.step(state, input, (), ())
}

#[test]
fn nothing_configured_says_nothing() {
    let servo = servo_loop(1.0);
    let mut state = servo.start();
    assert_eq!(cycle(servo, &mut state, &input([1.0; 3])).record.dynamic, None);
}

#[test]
fn the_lag_of_a_constant_speed_is_made_up_for_and_the_host_does_not_see_it() {
    let servo = loop_of(
        0.0,
        machine(|axis| {
            axis.servo = AxisServo { drive: Some(DRIVE), friction: None, dynamic: dynamic(true, false, false) };
        }),
    );
    let mut state = servo.start();
    let mut out = cycle(servo, &mut state, &input([0.0; 3]));
    for k in 1..5000 {
        out = cycle(servo, &mut state, &input([20.0 * T * f64::from(k), 0.0, 0.0]));
    }
    // (1 − k_ff) v / K_v
    let parts = out.record.dynamic.unwrap();
    assert!((parts.sent[0] - 0.1 * 20.0 / 100.0).abs() < 1e-9, "{parts:?}");
    assert_eq!((parts.sent[1], out.record.correction), (0.0, [0.0; 3]));
    assert!((out.drive[0] - out.record.command[0] - parts.sent[0]).abs() < 1e-12);
    assert!((out.record.feedback[0] - out.feedback[0] - parts.sent[0]).abs() < 1e-9);
    // At rest it returns to zero.
    let last = out.record.command;
    for _ in 0..5000 {
        out = cycle(servo, &mut state, &input(last));
    }
    assert!(out.record.dynamic.unwrap().sent[0].abs() < 1e-9);
}

/// The laws as differential equations, integrated by the classical Runge-Kutta method with fifty steps per period.
fn continuous(velocity: impl Fn(f64) -> f64, slope: impl Fn(f64) -> f64, end: f64) -> f64 {
    let force = |t: f64, f: f64| {
        let v = velocity(t);
        let sliding = FRICTION.coulomb_per_s * (1.0 + FRICTION.stribeck_share / (1.0 + (v / 2.0) * (v / 2.0)));
        sliding * f + FRICTION.viscous * v + slope(t) / DRIVE.velocity_gain_per_s
    };
    // f, s (what the integrator supplies: h = F − s), u
    let rate = |t: f64, [f, s, u]: [f64; 3]| {
        let v = velocity(t);
        let h = force(t, f) - s;
        let lag = (1.0 - DRIVE.velocity_feed_forward) * v;
        [
            (v - v.abs() * f) / FRICTION.presliding,
            h / DRIVE.reset_time_s,
            (h + lag - DRIVE.position_gain_per_s * u) / DRIVE.velocity_feed_forward,
        ]
    };
    let dt = T / 50.0;
    let mut y = [0.0; 3];
    let along = |y: [f64; 3], k: [f64; 3], d: f64| [y[0] + d * k[0], y[1] + d * k[1], y[2] + d * k[2]];
    for n in 0..(end / dt) as usize {
        let t = n as f64 * dt;
        let a = rate(t, y);
        let b = rate(t + 0.5 * dt, along(y, a, 0.5 * dt));
        let c = rate(t + 0.5 * dt, along(y, b, 0.5 * dt));
        let d = rate(t + dt, along(y, c, dt));
        for k in 0..3 {
            y[k] += dt / 6.0 * (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]);
        }
    }
    y[2]
}

#[test]
fn friction_and_acceleration_follow_the_continuous_law() {
    let servo = loop_of(0.0, machine(everything));
    // One axis of a circle: 25 mm/s on a radius of 50 mm.
    let (radius, omega) = (50.0, 0.5);
    let at = |t: f64| radius * (1.0 - (omega * t).cos());
    let mut state = servo.start();
    let mut out = cycle(servo, &mut state, &input([0.0; 3]));
    let mut k = 0;
    let mut largest: f64 = 0.0;
    // Shortly after the reversals at half a turn, where friction changes sides.
    for end in [1.0, 6.27, 6.30, 6.33, 6.5] {
        while f64::from(k) * T < end {
            k += 1;
            out = cycle(servo, &mut state, &input([at(f64::from(k) * T), 0.0, 0.0]));
            let sent = out.record.dynamic.unwrap().sent[0];
            largest = largest.max(sent.abs());
        }
        let wanted = continuous(
            |t| radius * omega * (omega * t).sin(),
            |t| radius * omega * omega * (omega * t).cos(),
            f64::from(k) * T,
        );
        let found = out.record.dynamic.unwrap().feed_forward[0];
        assert!((found - wanted).abs() < 0.01 * largest, "after {end} s: {found}, needed {wanted}");
    }
    assert!(largest > 0.02, "{largest}");
}

#[test]
fn cross_talk_from_another_axis_is_compensated() {
    let crosstalk = |points: &[[f64; 2]]| {
        let mut machine = machine(|axis| axis.servo.dynamic = dynamic(false, false, false));
        let points = points.iter().copied().collect();
        let entry = CrosstalkSettings { tip: Axis::X, from: Axis::Y, over: Axis::Z, points };
        machine.crosstalk.push(entry).unwrap();
        loop_of(0.0, machine)
    };
    let sent = |servo: &'static Loop, z: f64| {
        let mut state = servo.start();
        let mut out = cycle(servo, &mut state, &input([0.0, 0.0, z]));
        for k in 1..400 {
            // 200 mm/s²
            let t = T * f64::from(k);
            out = cycle(servo, &mut state, &input([0.0, 100.0 * t * t, z]));
        }
        out.record.dynamic.unwrap().sent
    };
    let constant = crosstalk(&[[0.0, 1e-5]]);
    let [x, y, z] = sent(constant, 7.0);
    assert!((x + 2e-3).abs() < 1e-9 && y == 0.0 && z == 0.0, "{x} {y} {z}");
    let over = crosstalk(&[[0.0, 1e-5], [50.0, 2e-5], [100.0, -1e-5]]);
    for (z, k) in [(-5.0, 1e-5), (0.0, 1e-5), (25.0, 1.5e-5), (50.0, 2e-5), (75.0, 0.5e-5), (100.0, -1e-5)] {
        let found = sent(over, z)[0];
        assert!((found + 200.0 * k).abs() < 1e-8, "at {z}: {found}");
    }
}

#[test]
fn learned_corrections_are_added_and_non_numeric_ones_are_not() {
    let servo = loop_of(0.0, machine(|axis| axis.servo.dynamic = dynamic(false, false, false)));
    let mut state = servo.start();
    let mut sent = |learned| {
        let mut out = cycle(servo, &mut state, &Input { learned, ..input([1.0; 3]) });
        for _ in 0..500 {
            out = cycle(servo, &mut state, &Input { learned, ..input([1.0; 3]) });
        }
        out.record.dynamic.unwrap().sent
    };
    assert_eq!(sent([0.003, -0.002, 0.0]), [0.003, -0.002, 0.0]);
    assert_eq!(sent([f64::NAN, f64::INFINITY, 0.001]), [0.0, 0.0, 0.001]);
}

/// Number of cycles from the reversal of the command until the correction moves.
fn until_taken_up(take_up: bool) -> u32 {
    let servo = loop_of(
        0.0,
        machine(|axis| {
            axis.backlash = 0.002;
            axis.servo.dynamic = dynamic(false, false, take_up);
        }),
    );
    let mut state = servo.start();
    // 12.5 mm/s²: the acceleration of the circle above.
    let at = |k: i32| -6.25 * (T * f64::from(k)) * (T * f64::from(k));
    for k in -500..=0 {
        cycle(servo, &mut state, &input([10.0 + at(k), 0.0, 0.0]));
    }
    (1..500).find(|k| cycle(servo, &mut state, &input([10.0 + at(*k), 0.0, 0.0])).record.correction[0] != 0.0).unwrap()
        as u32
}

#[test]
fn lost_motion_is_taken_up_from_the_reversal_of_the_command() {
    assert!(until_taken_up(true) <= 4, "{}", until_taken_up(true));
    // 0.3 µm of hysteresis take √(2 · 0.3 µm / 12.5 mm/s²) = 6.9 ms.
    assert!((65..75).contains(&until_taken_up(false)), "{}", until_taken_up(false));
}

#[test]
fn a_command_that_dithers_turns_nothing() {
    let servo = loop_of(
        0.0,
        machine(|axis| {
            axis.backlash = 0.002;
            axis.servo.dynamic = dynamic(false, false, true);
        }),
    );
    let mut state = servo.start();
    for k in 0..3000 {
        let dither = [0.0, -1e-6, 1e-6, -2e-6, 0.0, -1e-6][k % 6];
        let out = cycle(servo, &mut state, &input([10.0 + dither, 0.0, 0.0]));
        assert_eq!(out.record.correction, [0.0; 3], "cycle {k}");
    }
}

#[test]
fn a_trial_that_begins_and_ends_in_motion_makes_nothing_jump() {
    let servo = loop_of(0.0, machine(everything));
    let mut state = servo.start();
    let on_trial = Dynamics(Dynamics::ALL.0 | Dynamics::ON_TRIAL.0);
    let (mut before, mut at) = ([0.0_f64; 2], 0.0);
    for (parts, wanted) in [(Dynamics::ALL, 0.02), (on_trial, 0.0), (Dynamics::ALL, 0.02)] {
        for _ in 0..5000 {
            at += 20.0 * T;
            let given = Input { dynamics: parts, ..input([at, 0.0, 0.0]) };
            let record = cycle(servo, &mut state, &given).record;
            let (now, [last, earlier]) = (record.dynamic.unwrap().sent[0], before);
            assert!((now - last).abs() <= WIDE.slope_per_s * T + 1e-12);
            assert!((now - 2.0 * last + earlier).abs() <= WIDE.acceleration_per_s2 * T * T + 1e-12);
            assert!(!record.status.has(Status::FRICTION_OUT) && !record.status.has(Status::LAG_OUT));
            before = [now, last];
        }
        // No contour error says that lag helps, so its share stays zero; in full it is (1 − k_ff) v/K_v.
        assert!((before[0] - wanted).abs() < 1e-6, "{parts:?}: {before:?}, needed {wanted}");
    }
}

/// A straight path along X; axis Y follows its drive like a position loop, with a disturbance added.
fn along_x(
    feedback: bool,
    disturbance: impl Fn(f64) -> f64,
    cycles: u32,
) -> (Vec<Out>, State<f64, f64, 3>, &'static Loop) {
    beside_x(feedback, |_| 0.0, disturbance, cycles)
}

/// As [`along_x`], with commands of Y that leave the path.
fn beside_x(
    feedback: bool,
    across: impl Fn(f64) -> f64,
    disturbance: impl Fn(f64) -> f64,
    cycles: u32,
) -> (Vec<Out>, State<f64, f64, 3>, &'static Loop) {
    let mut machine = with_feedback(everything);
    if !feedback {
        machine.contour.feedback = None;
    }
    let servo: &'static Loop = loop_of(0.0, machine);
    let line = Segment::Line { start: [0.0, 0.0, 0.0].into(), end: [100.0, 0.0, 0.0].into() };
    let mut spans = Vec::new();
    convert(&line, 0, [0.0, 0.0, 1.0], |span| {
        spans.push(span);
        Ok(())
    })
    .unwrap();
    let path = Path::new(&spans, 0, false);
    let mut state = servo.start();
    let (mut y, mut outs) = (0.0, Vec::new());
    for k in 0..cycles {
        let t = f64::from(k) * T;
        let x = 20.0 * t;
        let given = Input { feedback: [x, y + disturbance(t), 0.0], ..input([x, across(t), 0.0]) };
        let out = servo.step(&mut state, &given, path.at(0, x / 100.0), ());
        y += T * DRIVE.position_gain_per_s * (out.drive[1] - y);
        outs.push(out);
    }
    (outs, state, servo)
}

#[test]
fn a_constant_error_is_removed_by_the_feedback() {
    for disturbance in [0.005, -0.005] {
        let last = |on| *along_x(on, |_| disturbance, 20_000).0.last().unwrap();
        assert!((last(false).record.tip.error - 0.005).abs() < 1e-9);
        let on = last(true);
        assert!(on.record.tip.error < 1e-5, "{}", on.record.tip.error);
        assert!((on.record.dynamic.unwrap().feedback[1] + disturbance).abs() < 1e-5);
    }
}

#[test]
fn the_integral_of_the_feedback_ends_where_the_axis_reverses_and_not_where_its_command_dithers() {
    // Y is 5 µm off; its command swings by this much in all, once a second.
    let least = |swing: f64| {
        let across = |t: f64| 0.5 * swing * (core::f64::consts::TAU * t).sin();
        let (outs, ..) = beside_x(true, across, |_| 0.005, 40_000);
        let corrected = outs[20_000..].iter().map(|out| -out.record.dynamic.unwrap().feedback[1]);
        corrected.fold(f64::MAX, f64::min)
    };
    for dither in [0.0, 2e-4, 1e-3, 1.9e-3] {
        assert!(least(dither) > 0.0045 - dither, "{dither} mm: {}", least(dither));
    }
    for reversal in [2.1e-3, 4e-3] {
        assert!(least(reversal) < 0.001, "{reversal} mm: {}", least(reversal));
    }
}

#[test]
fn on_trial_the_feedback_acts_on_no_error_at_rest() {
    let servo: &'static Loop = loop_of(0.0, with_feedback(everything));
    let line = Segment::Line { start: [0.0, 0.0, 0.0].into(), end: [100.0, 0.0, 0.0].into() };
    let mut spans = Vec::new();
    convert(&line, 0, [0.0, 0.0, 1.0], |span| {
        spans.push(span);
        Ok(())
    })
    .unwrap();
    let path = Path::new(&spans, 0, false);
    let wanted = |rule: Dynamics, speed: f64| {
        let mut state = servo.start();
        let mut last = None;
        for k in 0..1000 {
            let x = 50.0 + speed * T * f64::from(k);
            let dynamics = Dynamics(Dynamics::ALL.0 | rule.0);
            let given = Input { dynamics, feedback: [x, 0.005, 0.0], ..input([x, 0.0, 0.0]) };
            last = Some(servo.step(&mut state, &given, path.at(0, x / 100.0), ()).record.dynamic.unwrap());
        }
        last.unwrap().feedback[1]
    };
    assert_eq!(wanted(Dynamics::ON_TRIAL, 0.0), 0.0);
    for (rule, speed) in [(Dynamics::NONE, 0.0), (Dynamics::NONE, 20.0), (Dynamics::ON_TRIAL, 20.0)] {
        let offset = wanted(rule, speed);
        assert!(offset < -0.001, "{rule:?}, {speed} mm/s: {offset}");
    }
}

#[test]
fn the_watch_ramps_an_oscillation_out_and_says_so() {
    let swing = |t: f64| 0.03 * (core::f64::consts::TAU * 20.0 * t).sin();
    let (outs, mut state, servo) = along_x(true, swing, 10_000);
    let out = outs.iter().position(|out| out.record.status.has(Status::FEEDBACK_OUT)).unwrap();
    assert!((1500..=3500).contains(&out), "{out}");
    assert!(outs[out + 1000..].iter().all(|out| out.record.dynamic.unwrap().feedback == [0.0; 3]));
    assert!(outs[out..].iter().all(|out| out.record.status.has(Status::FEEDBACK_OUT)));
    // Switched off and on again, and reset.
    let mut flagged = |input| cycle(servo, &mut state, &input).record.status.has(Status::FEEDBACK_OUT);
    let at = outs.last().unwrap().record.command;
    assert!(flagged(input(at)));
    assert!(!flagged(Input { reset: true, ..input(at) }));
    let (_, mut state, servo) = along_x(true, swing, 10_000);
    let mut flagged = |input| cycle(servo, &mut state, &input).record.status.has(Status::FEEDBACK_OUT);
    let at = along_x(true, swing, 10_000).0.last().unwrap().record.command;
    assert!(flagged(input(at)));
    assert!(!flagged(Input { dynamics: Dynamics::ALL.without(Dynamics::FEEDBACK), ..input(at) }));
    assert!(!flagged(input(at)));
    // Exchanged for a loop without feedback.
    let (_, mut state, servo) = along_x(true, swing, 10_000);
    assert!(cycle(servo, &mut state, &input(at)).record.status.has(Status::FEEDBACK_OUT));
    let (_, _, without) = along_x(false, swing, 1);
    for servo in [without, servo] {
        assert!(!cycle(servo, &mut state, &input(at)).record.status.has(Status::FEEDBACK_OUT));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: crate::testing::share::share(300) as u32, ..ProptestConfig::default() })]

    /// Both corrections keep their limits and every value is finite in any sequence of faults, holds, parts switched at
    /// random, and exchanges between loops with and without dynamic correction.
    #[test]
    fn both_corrections_keep_their_limits(
        sequence in prop::collection::vec((any_doing(), any::<u8>(), -0.2..0.2f64), 1..40),
        start in (0.0..100.0f64, -9.9..109.9f64, 0.0..100.0f64),
    ) {
        let tables: [&'static Loop; 3] = [
            loop_of(3.0, with_feedback(everything)),
            servo_loop(-2.0),
            loop_of(-4.0, machine(|axis| { everything(axis); axis.backlash = 0.004; })),
        ];
        let (mut active, mut at) = (0, <[f64; 3]>::from(start));
        let mut state = tables[0].start();
        let (mut last, mut rates) = (None::<Out>, [[0.0; 3]; 2]);
        let (mut clock, mut started) = (Clock::default(), false);
        for ((what, cycles), bits, learned) in sequence {
            for n in 0..cycles {
                let mut given = input(at);
                match what {
                    Do::Go(speed) => {
                        at = [0, 1, 2].map(|k| (at[k] + speed[k]).clamp(-10.0, 110.0));
                        given = input(at);
                        // The readings lag behind, to give the feedback an error.
                        given.feedback = [0, 1, 2].map(|k| at[k] - 0.1 * speed[(k + 1) % 3]);
                    }
                    Do::NoNumber => given.command[1] = f64::NAN,
                    Do::Jump => given.command[0] = 50.0,
                    Do::OutOfTravel => given.command[2] = 110.01,
                    Do::Dropout => given.feedback[0] = f64::INFINITY,
                    Do::Alarm => given.encoder_alarm = 0b110,
                    Do::Takes(ns) => given.elapsed_ns = ns,
                    Do::Disable => given.enable = false,
                    Do::Unhomed => given.homed = false,
                    Do::Exchange => active = (active + 1) % 3,
                    Do::Reset(off) => {
                        if let Some(last) = last.filter(Out::stop_requested) {
                            at = last.record.command.map(|x| (x + off).clamp(-10.0, 110.0));
                            given = input(at);
                        }
                        given.reset = n % 2 == 1;
                    }
                }
                given.dynamics = Dynamics(bits);
                given.learned = [learned, -learned, 0.01 * learned];
                let path = Segment::Line { start: at.map(|x| x - 1.0).into(), end: at.map(|x| x + 1.0).into() };
                let mut spans = Vec::new();
                convert(&path, 0, [0.0, 0.0, 1.0], |span| { spans.push(span); Ok(()) }).unwrap();
                let out = tables[active].step(&mut state, &given, Path::new(&spans, 0, false).at(0, 0.5), ());
                let held = out.stop_requested();
                let due = clock.due(given.elapsed_ns, !started);
                started |= !held;
                let parts = out.record.dynamic;
                for k in 0..3 {
                    let sum = out.drive[k] - out.record.command[k];
                    let d = parts.map_or(0.0, |parts| parts.sent[k]);
                    prop_assert!((sum - out.record.correction[k] - d).abs() < 1e-9);
                    prop_assert!(sum.abs() <= 0.1 + 1e-9 && d.abs() <= WIDE.magnitude + 1e-9);
                    let finite = parts.is_none_or(|p| {
                        [p.feed_forward[k], p.feedback[k], p.crosstalk[k], p.learned[k]].iter().all(|x| x.is_finite())
                    });
                    prop_assert!(finite);
                    let Some(before) = last else { continue };
                    let was = before.drive[k] - before.record.command[k];
                    let sent = before.record.dynamic.map_or(0.0, |parts| parts.sent[k]);
                    if held {
                        prop_assert_eq!(before.drive[k].to_bits(), out.drive[k].to_bits());
                        rates = rates.map(|mut rate| { rate[k] = 0.0; rate });
                        continue;
                    }
                    // Without a dynamic part the limiter takes over the sum; in the next loop with one it starts at zero.
                    let whole = parts.is_some();
                    for (which, (now, then)) in [(sum, was), (d, sent)].into_iter().enumerate() {
                        let v = now - then;
                        if !due {
                            // At an exchange, the share that counts as dynamic may change.
                            let renamed = which == 1 && before.record.dynamic.is_some() != whole;
                            prop_assert!(renamed || v.abs() <= 1e-13, "{which} moves by {v} in no time, {what:?}");
                            continue;
                        }
                        if which == 0 || whole {
                            prop_assert!(v.abs() <= 5e-4 + 1e-9, "slope {which} {v} after {what:?}");
                            prop_assert!((v - rates[which][k]).abs() <= 5e-5 + 1e-9, "acceleration {which} after {what:?}");
                        }
                        rates[which][k] = if which == 0 || whole { v } else { 0.0 };
                    }
                }
                last = Some(out).filter(Out::has_drive);
            }
        }
    }
}
