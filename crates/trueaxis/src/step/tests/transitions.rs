//! Into and out of every state: hold, freeze, disable, joint range, exchange; and before the step has a position to
//! hold.

use super::*;

/// X tables of 90 µm, limits of 1 mm/s and 0.2 m/s², enabled for 40 ms, then one non-numeric command, held for 1,000
/// cycles.
#[test]
fn a_held_correction_is_held_and_continues_from_there() {
    let slow = |axis: &mut AxisSettings| {
        axis.limits = crate::machine::Limits { slope_per_s: 1.0, acceleration_per_s2: 200.0, ..axis.limits };
    };
    let mut bench = Bench::on(servo_loop_with(10.0, slow));
    let at = input([30.0, 40.0, 50.0]);
    for _ in 0..400 {
        bench.cycle(&at);
    }
    let before = bench.cycle(&at);
    assert!(before.record.limited != 0, "still on its way");
    for _ in 0..1000 {
        // The bench checks every bit.
        let out = bench.cycle(&Input { feedback: at.feedback, ..input([f64::NAN; 3]) });
        assert_eq!(out.record.correction, before.record.correction);
        assert_eq!(out.feedback, [0, 1, 2].map(|k| at.feedback[k] - before.record.correction[k]));
    }
    let out = bench.cycle(&Input { reset: true, ..at });
    assert!(!out.stop_requested());
    for k in 0..3 {
        let moved = (out.drive[k] - before.drive[k]).abs();
        assert!(moved <= 200.0 * T * T * (1.0 + 1e-6), "from rest, within the acceleration: {moved}");
    }
    let out = bench.settle(at.command);
    assert!((out.record.correction[0] - before.record.correction[0]).abs() > 0.01);
}

/// A machine whose joints end with the travel: near the end an outward correction has no room.
fn tight(scale: f64) -> &'static Loop {
    servo_loop_with(scale, |axis| axis.joint = axis.travel)
}

#[test]
fn a_drive_beyond_the_joint_is_not_sent_at_either_end() {
    // Outward corrections: positive errors pull the command down, negative ones push it up.
    for (scale, end, inward) in [(1.0, -10.0, 1.0), (-1.0, 110.0, -1.0)] {
        let mut bench = Bench::on(tight(scale));
        let far = |way: f64| [end + inward * way, 50.0, 50.0];
        let mut way = 0.5;
        bench.settle(far(way));
        let mut last = bench.cycle(&input(far(way)));
        assert!((last.record.correction[0] * inward) < -0.005);
        loop {
            way -= 0.001;
            let out = bench.cycle(&input(far(way)));
            if out.stop_requested() {
                assert_eq!((out.record.fault, out.record.fault_axis), (Fault::JointRange, 0));
                assert!(!out.record.status.has(Status::ACTIVE), "nothing is followed in this cycle");
                assert_eq!(out.record.limited, 0);
                assert_eq!((out.drive, out.record.command), (last.drive, last.record.command));
                assert_eq!(out.record.correction, last.record.correction);
                break;
            }
            assert!((out.drive[0] - end) * inward >= 0.0, "{} beyond {end}", out.drive[0]);
            last = out;
        }
        assert!((last.drive[0] - end).abs() < 0.0011, "held at {}", last.drive[0]);
        // Latched: the output holds even for a command that would fit, and a reset with the one that does not fit
        // latches again.
        let held = bench.cycle(&input(far(0.5)));
        assert!(held.stop_requested() && held.drive == last.drive && held.record.fault == Fault::JointRange);
        let again = bench.cycle(&Input { reset: true, ..input(far(way)) });
        assert_eq!((again.record.fault, again.drive), (Fault::JointRange, last.drive));
        // Near the held command, and within the joint: released.
        bench.cycle(&input(far(way + 0.02)));
        let out = bench.cycle(&Input { reset: true, ..input(far(way + 0.02)) });
        assert!(!out.stop_requested() && out.record.status.has(Status::ACTIVE));
        assert!((out.drive[0] - last.drive[0]).abs() < 0.03);
        // Farther from the end, the machine continues without a fault.
        let out = bench.cycle(&input(far(way + 0.1)));
        assert_eq!(out.record.fault, Fault::None);
    }
}

#[test]
fn a_drive_beyond_the_joint_is_not_sent_while_frozen_either() {
    let mut bench = Bench::on(tight(1.0));
    bench.settle([50.0, 109.9, 50.0]);
    let mut last = bench.cycle(&input([50.0, 109.9, 50.0]));
    for n in 1..200 {
        let command = [50.0, 109.9 + 0.001 * f64::from(n), 50.0];
        let out = bench.cycle(&Input { encoder_alarm: 1, ..input(command) });
        if out.stop_requested() {
            assert_eq!((out.record.fault, out.record.fault_axis), (Fault::JointRange, 1));
            assert!(!out.record.status.has(Status::FROZEN));
            assert_eq!((out.drive, out.record.correction), (last.drive, last.record.correction));
            // The alarm may end or stay: the stop is latched.
            assert!(bench.cycle(&input([50.0, 109.9, 50.0])).stop_requested());
            return;
        }
        assert!(out.record.status.has(Status::FROZEN));
        assert!(out.drive[1] <= 110.0, "{}", out.drive[1]);
        last = out;
    }
    panic!("sent beyond the joint: {}", last.drive[1]);
}

#[test]
fn switched_off_the_joint_is_the_hosts() {
    let mut bench = Bench::on(tight(-1.0));
    let at = Input { enable: false, ..input([110.0, 50.0, 50.0]) };
    bench.cycle(&at);
    let out = bench.cycle(&Input { command: [111.0, 50.0, 50.0], ..at });
    assert_eq!((out.drive[0], out.record.fault), (111.0, Fault::None));
}

#[test]
fn a_way_that_was_not_sent_is_no_part_of_the_commanded_path() {
    let servo = tight(-1.0);
    let mut state = servo.start();
    let mut commanded = crate::contour::CommandWindow::<f64, f64, 64>::new([0.0, 0.0, 1.0], 0.005).unwrap();
    for n in 0..3000 {
        let x = 109.94 - 1e-4 * f64::from((100 - n).max(0));
        let out = servo.step(&mut state, &input([x, 50.0, 50.0]), &mut commanded, ());
        assert_eq!(out.record.fault, Fault::None);
    }
    let out = servo.step(&mut state, &input([110.0, 50.0, 50.0]), &mut commanded, ());
    assert_eq!((out.record.fault, out.record.command[0]), (Fault::JointRange, 109.94));
    // Switched off again: an axis on the rejected path is off the accepted one.
    let off_path = 109.97;
    let mut measured = 0;
    for n in 0..30 {
        let x = 109.94 - 1e-3 * f64::from(n);
        let feedback = [off_path + 1e-6 * f64::from(n), 50.0, 50.0];
        let back = Input { reset: n == 1, feedback, ..input([x, 50.0, 50.0]) };
        let out = servo.step(&mut state, &back, &mut commanded, ());
        let encoder = out.record.encoder;
        if encoder.is_measured() {
            measured += 1;
            assert!(encoder.error > 0.029, "{n}: {encoder:?}");
        }
    }
    assert!(measured > 10, "{measured}");
}

#[test]
fn a_bad_command_in_the_very_first_cycle_holds_the_machine_where_it_is() {
    let mut bench = Bench::new();
    let actual = [1.0, 2.0, 3.0];
    for _ in 0..3 {
        let out = bench.cycle(&Input { feedback: actual, ..input([f64::NAN; 3]) });
        assert!(out.stop_requested() && out.has_drive());
        assert_eq!((out.drive, out.record.command), (actual, actual));
    }
    // Far away a reset is not accepted; here it is, and starts with a first cycle.
    let away = Input { feedback: actual, reset: true, ..input([1.2, 2.0, 3.0]) };
    assert!(bench.cycle(&away).stop_requested());
    bench.cycle(&input(actual));
    let near = [1.04, 2.0, 3.0];
    let out = bench.cycle(&Input { reset: true, feedback: actual, ..input(near) });
    assert!(!out.stop_requested());
    assert_eq!((out.drive, out.record.correction), (near, [0.0; 3]));
    assert!(bench.settle(near).record.correction[0] < -0.005);
}

/// Neither a usable command nor a usable reading: nothing may go out, least of all zero.
#[test]
fn there_is_no_output_before_a_command_or_every_reading_is_known() {
    let mut bench = Bench::new();
    let blind = |feedback| Input { feedback, ..input([f64::NAN; 3]) };
    for feedback in [[f64::NAN; 3], [7.0, f64::INFINITY, 9.0], [7.0, f64::NAN, 2e9]] {
        let out = bench.cycle(&blind(feedback));
        assert!(!out.has_drive() && out.stop_requested());
        assert!(out.record.status.has(Status::NO_OUTPUT));
        assert!(out.record.feedback.iter().all(|x| x.is_finite()));
    }
    // An encoder that reports an alarm has not been read, and a reset is not accepted.
    let alarm = Input { encoder_alarm: 0b010, ..blind([7.5, 8.0, 9.0]) };
    assert!(!bench.cycle(&alarm).has_drive());
    let reset = Input { reset: true, encoder_alarm: 0b010, ..input([0.0; 3]) };
    assert!(!bench.cycle(&reset).has_drive());
    // Y is read last, while X is unreadable again: the last reading of each gives the machine's position.
    let out = bench.cycle(&blind([f64::NAN, 8.0, 0.0]));
    assert!(out.has_drive() && out.stop_requested());
    let held = [0.0, 8.0, 0.0];
    assert_eq!((out.drive, out.record.command), (held, held));
    for feedback in [[f64::NAN; 3], [50.0; 3]] {
        assert_eq!(bench.cycle(&blind(feedback)).drive, held);
    }
    let out = bench.cycle(&Input { reset: true, feedback: held, ..input(held) });
    assert!(!out.stop_requested() && out.has_drive());
    assert_eq!(out.drive, held);
}

#[test]
fn without_readings_a_usable_first_command_is_output() {
    let mut bench = Bench::new();
    let out = bench.cycle(&Input { feedback: [f64::NAN; 3], ..input([5.0; 3]) });
    assert!(out.has_drive() && !out.stop_requested());
    assert_eq!(out.drive, [5.0; 3]);
    assert_eq!(out.record.fault, Fault::FeedbackNotFinite);
    assert_eq!(out.record.feedback, [5.0; 3], "the command replaces the reading");
}

#[test]
fn integers_know_no_place_from_a_saturated_reading() {
    use crate::position::Nanometres;
    let servo = servo_loop_with::<f32, Nanometres>(1.0, |_| ());
    let mut state = servo.start();
    let none = Path::new(&[], 0, false);
    let saturated = Nanometres(i32::MAX);
    let mut cycle = |command, feedback| {
        let input = Input {
            command: [command; 3],
            feedback: [feedback; 3],
            homed: true,
            enable: true,
            ..Input::at_rest(PERIOD_NS)
        };
        servo.step(&mut state, &input, none.on(Reference { span: 0, t: 0.0 }), ())
    };
    let out = cycle(saturated, saturated);
    assert!(!out.has_drive() && out.record.fault == Fault::CommandNotFinite);
    let out = cycle(saturated, Nanometres(5_000_000));
    assert_eq!((out.has_drive(), out.drive), (true, [Nanometres(5_000_000); 3]));
}

#[test]
fn a_jump_of_the_whole_range_of_integers_is_a_jump() {
    use crate::position::Nanometres;
    let ends = [Nanometres(i32::MIN + 2), Nanometres(i32::MAX - 1)];
    let wide = |axis: &mut AxisSettings| {
        axis.travel = ends.map(Position::to_f64);
        axis.joint = axis.travel;
    };
    let servo = servo_loop_with::<f32, Nanometres>(1.0, wide);
    let none = Path::new(&[], 0, false);
    let given = |command: Nanometres, feedback: Nanometres| Input {
        command: [command; 3],
        feedback: [feedback; 3],
        homed: true,
        enable: true,
        ..Input::at_rest(PERIOD_NS)
    };
    let step = |state: &mut _, input: &_| servo.step(state, input, none.on(Reference { span: 0, t: 0.0 }), ());
    // The difference is 2^32 − 3 nm: wrapped, it is 3 nm.
    let [low, high] = ends;
    for (from, to) in [(low, high), (high, low)] {
        let mut state = servo.start();
        step(&mut state, &given(from, from));
        assert_eq!(step(&mut state, &given(to, from)).record.fault, Fault::CommandJump);
        let mut state = servo.start();
        step(&mut state, &given(from, from));
        assert_eq!(step(&mut state, &given(from, to)).record.fault, Fault::FeedbackJump);
        // Saturated, it is a dropout.
        let end = Nanometres(if to == high { i32::MAX } else { i32::MIN });
        assert_eq!(step(&mut state, &given(from, end)).record.fault, Fault::FeedbackNotFinite);
        // Nor is the other end near the held output.
        step(&mut state, &given(to, from));
        let reset = Input { reset: true, ..given(to, from) };
        assert!(step(&mut state, &reset).stop_requested());
    }
}

/// A travel declared beyond the integers' range: the joint ends where they do.
#[test]
fn integers_are_held_before_a_drive_saturates() {
    use crate::position::Nanometres;
    let wide = |axis: &mut AxisSettings| {
        (axis.travel, axis.joint) = ([-36_000.0, 36_000.0], [-36_001.0, 36_001.0]);
    };
    let servo = servo_loop_with::<f32, Nanometres>(-1.0, wide);
    let mut state = servo.start();
    let last = [Nanometres(i32::MAX - 1), Nanometres(0), Nanometres(0)];
    let input = servo.input(last, last);
    let outs: Vec<_> = (0..500).map(|_| servo.step(&mut state, &input, (), ())).collect();
    assert!(outs.iter().all(|out| out.drive.iter().all(|drive| drive.is_usable())));
    let out = outs.last().unwrap();
    assert_eq!((out.record.fault, out.record.fault_axis), (Fault::JointRange, 0));
}

/// Action of a cycle in the random sequence.
#[derive(Clone, Copy, Debug)]
pub(super) enum Do {
    /// Moves on at a speed, mm per cycle and axis.
    Go([f64; 3]),
    NoNumber,
    Jump,
    OutOfTravel,
    Dropout,
    Alarm,
    Takes(u32),
    Disable,
    Unhomed,
    Exchange,
    /// A reset, this far from the held command.
    Reset(f64),
}

pub(super) fn any_doing() -> impl Strategy<Value = (Do, u16)> {
    let speed = || -0.09..0.09f64;
    prop_oneof![
        6 => ([speed(), speed(), speed()].prop_map(Do::Go), 1..400u16),
        2 => (Just(Do::Go([0.0; 3])), 1..400u16),
        2 => (Just(Do::NoNumber), 1..60u16),
        1 => (Just(Do::Jump), 1..3u16),
        1 => (Just(Do::OutOfTravel), 1..3u16),
        2 => (Just(Do::Dropout), 1..200u16),
        1 => (Just(Do::Alarm), 1..200u16),
        1 => ((0..u32::MAX).prop_map(Do::Takes), 1..3u16),
        1 => ((0..3 * PERIOD_NS).prop_map(Do::Takes), 1..30u16),
        2 => (Just(Do::Disable), 1..300u16),
        1 => (Just(Do::Unhomed), 1..300u16),
        3 => (Just(Do::Exchange), 1..2u16),
        6 => ((-0.05..0.05f64).prop_map(Do::Reset), 1..3u16),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: crate::testing::share::share(2_000) as u32, ..ProptestConfig::default() })]

    /// `drive − command` keeps magnitude, slope and acceleration in every cycle of any sequence; while the output is
    /// held, nothing moves.
    #[test]
    fn the_limits_hold_in_every_cycle(
        sequence in prop::collection::vec(any_doing(), 1..40),
        start in (0.0..100.0f64, -9.9..109.9f64, prop_oneof![Just(-10.0), Just(110.0), 0.0..100.0f64]),
    ) {
        // Ten times the errors: corrections reach their magnitude limit, and at the ends the joint.
        let narrow = |axis: &mut AxisSettings| {
            axis.joint = axis.travel;
            axis.limits = crate::machine::Limits { magnitude: 0.06, slope_per_s: 0.5, ..axis.limits };
        };
        let tables = [tight(9.0), tight(-4.0), servo_loop_with(-9.0, narrow)];
        let mut bench = Bench::on(tables[0]);
        let (mut next, mut at) = (0, <[f64; 3]>::from(start));
        let (mut sent, mut before, mut last) = ([0.0; 3], [0.0; 3], None::<Out>);
        for (what, cycles) in sequence {
            for n in 0..cycles {
                let mut given = input(at);
                match what {
                    Do::Go(speed) => {
                        for k in 0..3 {
                            at[k] = (at[k] + speed[k]).clamp(-10.0, 110.0);
                        }
                        given = input(at);
                    }
                    Do::NoNumber => given.command[1] = f64::NAN,
                    Do::Jump => given.command[0] = 50.0,
                    Do::OutOfTravel => given.command[2] = 110.01,
                    Do::Dropout => given.feedback[0] = f64::INFINITY,
                    Do::Alarm => {
                        at[1] = (at[1] + 0.05).clamp(-10.0, 110.0);
                        given = Input { encoder_alarm: 0b110, ..input(at) };
                    }
                    Do::Takes(ns) => given.elapsed_ns = ns,
                    Do::Disable => given.enable = false,
                    Do::Unhomed => given.homed = false,
                    Do::Exchange => {
                        next += 1;
                        bench.active = tables[next % 3];
                    }
                    Do::Reset(off) => {
                        given.reset = n % 2 == 1;
                        if let Some(last) = last.filter(Out::stop_requested) {
                            at = last.record.command.map(|x| (x + off).clamp(-10.0, 110.0));
                            given = Input { reset: n % 2 == 1, ..input(at) };
                        }
                    }
                }
                let out = bench.cycle(&given); // against its own limits and rules
                // Checked again from outside: drive positions minus commands.
                for k in 0..3 {
                    let c = out.drive[k] - out.record.command[k];
                    let v = c - sent[k];
                    let held = out.stop_requested();
                    prop_assert!(c.abs() <= 0.1 + 1e-9);
                    prop_assert!(!held || last.is_none_or(|last| last.drive[k].to_bits() == out.drive[k].to_bits()));
                    prop_assert!(held || v.abs() <= 5e-4 + 1e-9, "slope {v} after {what:?}");
                    prop_assert!(held || bench.due || v.abs() <= 1e-13, "{v} in no time, {what:?}");
                    let second = if bench.due && !held { v - before[k] } else { 0.0 };
                    prop_assert!(second.abs() <= 5e-5 + 1e-9, "acceleration after {what:?}");
                    before[k] = if held { 0.0 } else if bench.due { v } else { before[k] };
                    sent[k] = c;
                }
                last = Some(out);
            }
        }
    }
}

/// A limit between two steps of the position: despite rounding, the output never exceeds it, nor a joint range that
/// ends between two steps.
#[test]
fn no_rounding_goes_beyond_a_limit_as_it_is_stated() {
    use crate::position::Nanometres;
    let mut noise = crate::testing::noise::Noise::new(18);
    for round in 0..60 {
        // 12.35 µm and a fraction of a nanometre; in the third of every four rounds a whole number of them.
        let part = [0.53, 0.97, 0.0, 0.49][round % 4];
        let limit = (12_345.0 + 1000.0 * (round / 4) as f64 + part) * 1e-6;
        let set = |axis: &mut AxisSettings| {
            axis.limits = crate::machine::Limits { magnitude: limit, ..axis.limits };
        };
        let servo = servo_loop_with::<f32, Nanometres>(9.0, set);
        let mut state = servo.start();
        let mut most = 0;
        for n in 0..2000 {
            let command = [0, 1, 2].map(|k| Nanometres(30_000_000 + 2000 * n + 1000 * k + (3.0 * noise.unit()) as i32));
            let out = servo.step(&mut state, &servo.input(command, command), (), ());
            for k in 0..3 {
                let sent = out.drive[k].0 - command[k].0;
                most = most.max(sent.abs());
                assert!(f64::from(sent.abs()) <= limit * 1e6 + 1e-6, "{sent} nm of {}", limit * 1e6);
                // In single precision a sum is rounded once.
                let reported = f64::from(out.record.correction[k]).abs();
                assert!(reported <= limit * (1.0 + 1e-7), "{reported} of {limit}");
            }
        }
        assert_eq!(most, (limit * 1e6 + 1e-6) as i32, "all that is permitted");
    }
    for (end, last) in [(100.000_000_6, 100_000_000), (99.999_999_6, 99_999_999), (100.0, 100_000_000)] {
        for sign in [1.0, -1.0] {
            let set = |axis: &mut AxisSettings| {
                (axis.travel, axis.joint) = ([-99.95, 99.95], [-110.0, 110.0]);
                axis.joint[usize::from(sign > 0.0)] = sign * end;
            };
            let servo = servo_loop_with::<f32, Nanometres>(-sign * 9.0, set);
            let mut state = servo.start();
            let mut most = 0;
            for n in 0..4000 {
                // The correction of 0.1 mm ramps in, then the command moves a nanometre per cycle.
                let x = sign as i32 * (99_899_000 + (n - 2000).max(0));
                let command = [x, 0, 0].map(Nanometres);
                let out = servo.step(&mut state, &servo.input(command, command), (), ());
                most = most.max(out.drive[0].0.abs());
            }
            assert_eq!(most, last, "of {end}, {sign}");
        }
    }
}
