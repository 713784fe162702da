//! When a command or a reading is trusted: each rule separately, at its limit.

use super::*;

/// Largest plausible step of the command in a cycle: twice 500 mm/s.
const STEP: f64 = 0.1;

fn at_rest(at: f64) -> Bench {
    let mut bench = Bench::new();
    bench.settle([at; 3]);
    bench
}

#[test]
fn a_late_cycle_excuses_as_large_a_step_as_it_took_periods_up_to_sixteen() {
    let cases = [
        (PERIOD_NS, 1.0),
        (PERIOD_NS + PERIOD_NS / 4, 1.0),
        (2 * PERIOD_NS, 2.0),
        (15 * PERIOD_NS + PERIOD_NS / 2, 15.5),
        (16 * PERIOD_NS, 16.0),
        (17 * PERIOD_NS, 16.0),
        (1 << 31, 16.0),
        ((1 << 31) + PERIOD_NS, 16.0),
        (u32::MAX, 16.0),
    ];
    for (elapsed_ns, periods) in cases {
        for (part, fits) in [(0.999, true), (1.001, false), (-0.999, true), (-1.001, false)] {
            let mut bench = at_rest(50.0);
            let way = part * periods * STEP;
            // The reading moves by less than its own limit.
            let out = bench.cycle(&Input { elapsed_ns, feedback: [50.01; 3], ..input([50.0, 50.0 + way, 50.0]) });
            let late = periods > 1.0;
            let expected = match (fits, late) {
                (true, true) => Fault::LateCycle,
                (true, false) => Fault::None,
                _ => Fault::CommandJump,
            };
            assert_eq!(out.record.fault, expected, "{elapsed_ns} ns, {way} mm");
            assert!(fits || out.record.fault_axis == 1);
        }
    }
}

#[test]
fn the_plausible_jump_of_a_reading_grows_with_every_one_that_is_missing() {
    // Largest step of the axis plus 0.02 mm.
    let limit = STEP + 0.02;
    for missing in [0, 1, 2, 7] {
        for sign in [1.0, -1.0] {
            for (part, accepted) in [(0.999, true), (1.001, false)] {
                let mut bench = at_rest(50.0);
                for _ in 0..missing {
                    let lost = Input { feedback: [50.0, 50.0, f64::NAN], ..input([50.0; 3]) };
                    assert_eq!(bench.cycle(&lost).record.fault, Fault::FeedbackNotFinite);
                }
                let z = 50.0 + sign * part * limit * f64::from(1 + missing);
                let back = Input { feedback: [50.0, 50.0, z], ..input([50.0; 3]) };
                let out = bench.cycle(&back);
                if accepted {
                    assert_eq!((out.record.fault, out.record.feedback[2]), (Fault::None, z));
                    // From here on the limit of one cycle applies again.
                    let next = Input { feedback: [50.0, 50.0, z + 1.001 * limit], ..input([50.0; 3]) };
                    assert_eq!(bench.cycle(&next).record.fault, Fault::FeedbackJump);
                } else {
                    let fault = (out.record.fault, out.record.fault_axis, out.record.feedback[2]);
                    assert_eq!(fault, (Fault::FeedbackJump, 2, 50.0));
                    // A rejected reading is missing too: the limit of the next cycle covers it.
                    assert_eq!(bench.cycle(&back).record.fault, Fault::None);
                }
            }
        }
    }
}

/// Moves the command by each of `steps` while the X encoder does not change; returns the fault of the last cycle.
fn stuck(bench: &mut Bench, from: f64, steps: &[f64]) -> Fault {
    let mut x = from;
    let mut fault = Fault::None;
    for step in steps {
        x += step;
        fault = bench.cycle(&Input { feedback: [from, 50.0, 50.0], ..input([x, 50.0, 50.0]) }).record.fault;
    }
    fault
}

#[test]
fn a_stuck_encoder_is_found_in_either_direction_and_by_the_way_not_the_distance() {
    // 0.2 mm in steps of a power of two, so that the sums are exact to the cycle.
    let step = 1.0 / 64.0;
    for sign in [1.0, -1.0] {
        let mut bench = at_rest(50.0);
        assert_eq!(stuck(&mut bench, 50.0, &[sign * step; 12]), Fault::None, "0.1875 mm");
        let mut bench = at_rest(50.0);
        assert_eq!(stuck(&mut bench, 50.0, &[sign * step; 13]), Fault::EncoderStuck, "0.203 mm");
    }
    // Back and forth.
    let mut bench = at_rest(50.0);
    let mut steps = [step; 13];
    steps[6..].fill(-step);
    assert_eq!(stuck(&mut bench, 50.0, &steps), Fault::EncoderStuck);
    // Without a command no encoder is stuck.
    let mut bench = at_rest(50.0);
    assert_eq!(stuck(&mut bench, 50.0, &[0.0; 5000]), Fault::None);
}

#[test]
fn a_reading_that_moves_or_a_switch_off_ends_the_suspicion() {
    let step = 1.0 / 64.0;
    // The smallest change of the reading.
    let mut bench = at_rest(50.0);
    assert_eq!(stuck(&mut bench, 50.0, &[-step; 12]), Fault::None);
    let x = 50.0 - 12.0 * step;
    bench.cycle(&Input { feedback: [50.0 - 1e-6, 50.0, 50.0], ..input([x, 50.0, 50.0]) });
    for n in 1..=12 {
        let at = x - f64::from(n) * step;
        let out = bench.cycle(&Input { feedback: [50.0 - 1e-6, 50.0, 50.0], ..input([at, 50.0, 50.0]) });
        assert_eq!(out.record.fault, Fault::None, "{n}");
    }
    let at = x - 13.0 * step;
    let out = bench.cycle(&Input { feedback: [50.0 - 1e-6, 50.0, 50.0], ..input([at, 50.0, 50.0]) });
    assert_eq!(out.record.fault, Fault::EncoderStuck);
    // Switched off for a cycle: the distance counts from zero again.
    let mut bench = at_rest(50.0);
    assert_eq!(stuck(&mut bench, 50.0, &[step; 12]), Fault::None);
    let x = 50.0 + 12.0 * step;
    let still = [50.0; 3];
    bench.cycle(&Input { enable: false, feedback: still, ..input([x, 50.0, 50.0]) });
    for n in 1..=12 {
        let at = Input { feedback: still, ..input([x + f64::from(n) * step, 50.0, 50.0]) };
        assert_eq!(bench.cycle(&at).record.fault, Fault::None, "{n}");
    }
}

#[test]
fn a_reset_ends_the_suspicion_too() {
    let step = 1.0 / 64.0;
    let mut bench = at_rest(50.0);
    assert_eq!(stuck(&mut bench, 50.0, &[step; 12]), Fault::None);
    let x = 50.0 + 12.0 * step;
    let at = |x: f64| Input { feedback: [50.0; 3], ..input([x, 50.0, 50.0]) };
    bench.cycle(&at(f64::NAN));
    assert!(!bench.cycle(&Input { reset: true, ..at(x) }).stop_requested());
    for n in 1..=12 {
        assert_eq!(bench.cycle(&at(x + f64::from(n) * step)).record.fault, Fault::None, "{n}");
    }
    assert_eq!(bench.cycle(&at(x + 13.0 * step)).record.fault, Fault::EncoderStuck);
}

#[test]
fn before_homing_positions_mean_nothing() {
    let mut bench = Bench::new();
    let raw = |command, feedback| Input { homed: false, feedback, ..input(command) };
    let sequence = [
        ([0.0; 3], [0.0; 3]),
        ([5000.0, -5000.0, 0.0], [0.0; 3]),
        ([0.0; 3], [-300.0, 300.0, 0.0]),
        ([1.0; 3], [-300.0, 300.0, 0.0]),
        ([111.0; 3], [1e8, 0.0, 0.0]),
    ];
    for (command, feedback) in sequence {
        let out = bench.cycle(&raw(command, feedback));
        assert_eq!((out.record.fault, out.drive, out.feedback), (Fault::None, command, feedback));
        assert!(!out.record.status.has(Status::ACTIVE));
    }
    // NaN is not a position either.
    let out = bench.cycle(&raw([f64::NAN, 0.0, 0.0], [0.0; 3]));
    assert_eq!(out.record.fault, Fault::CommandNotFinite);
}

#[test]
fn enabling_checks_travel_and_readings_but_no_jump_of_the_command() {
    let off = |at: [f64; 3]| Input { enable: false, ..input(at) };
    for homed in [true, false] {
        // Homing and switching on may change the command by any amount …
        let mut bench = Bench::new();
        bench.cycle(&Input { homed, ..off([20.0; 3]) });
        let on = Input { feedback: [20.0; 3], ..input([60.0; 3]) };
        let out = bench.cycle(&on);
        assert_eq!((out.record.fault, out.record.command), (Fault::None, [60.0; 3]));
        // … from then on jumps are checked,
        let out = bench.cycle(&Input { feedback: [20.0; 3], ..input([60.0, 60.0, 60.0 + 1.001 * STEP]) });
        assert_eq!((out.record.fault, out.record.fault_axis), (Fault::CommandJump, 2));
        // and the travel immediately.
        let mut bench = Bench::new();
        bench.cycle(&Input { homed, ..off([20.0; 3]) });
        let out = bench.cycle(&input([20.0, 110.001, 20.0]));
        assert_eq!((out.record.fault, out.record.fault_axis), (Fault::CommandOutOfTravel, 1));
    }
    // A reading is compared with the previous one already in that cycle, unless it is the very first.
    let mut bench = Bench::new();
    bench.cycle(&off([20.0; 3]));
    assert_eq!(
        bench.cycle(&Input { feedback: [20.0, 21.0, 20.0], ..input([20.0; 3]) }).record.fault,
        Fault::FeedbackJump
    );
    let mut bench = Bench::new();
    assert_eq!(bench.cycle(&Input { feedback: [90.0; 3], ..input([20.0; 3]) }).record.fault, Fault::None);
}

#[test]
fn readings_are_watched_while_the_output_holds() {
    let limit = STEP + 0.02;
    let mut bench = at_rest(50.0);
    let held = |feedback| Input { feedback, ..input([50.0, f64::NAN, 50.0]) };
    bench.cycle(&held([50.0; 3]));
    // A glitch is rejected, although the reported fault is still the stop's.
    let out = bench.cycle(&held([50.0 + 1.001 * limit, 50.0, 50.0]));
    assert_eq!((out.record.fault, out.record.feedback[0]), (Fault::CommandNotFinite, 50.0));
    // One reading missing: twice the limit.
    let out = bench.cycle(&held([50.0 + 1.999 * limit, 50.0, 50.0]));
    assert_eq!(out.record.feedback[0], 50.0 + 1.999 * limit);
    // An axis that coasts is followed throughout.
    let mut x = 50.0 + 1.999 * limit;
    for _ in 0..100 {
        x -= 0.999 * limit;
        assert_eq!(bench.cycle(&held([x, 50.0, 50.0])).record.feedback[0], x);
    }
    // After a stop before homing, positions may be redefined: any reading is trusted.
    let mut bench = Bench::new();
    bench.cycle(&Input { homed: false, ..input([50.0; 3]) });
    let unhomed = |x| Input { homed: false, ..held([x, 50.0, 50.0]) };
    bench.cycle(&unhomed(50.0));
    assert_eq!(bench.cycle(&unhomed(-400.0)).record.feedback[0], -400.0);
}

#[test]
fn a_reset_with_a_command_out_of_travel_is_ignored() {
    let mut bench = at_rest(109.99);
    let at = |x: f64| input([x, 109.99, 109.99]);
    let before = bench.cycle(&at(109.99));
    bench.cycle(&Input { feedback: [109.99; 3], ..at(f64::NAN) });
    // Within 0.05 mm of the held command, but beyond the travel.
    let out = bench.cycle(&Input { reset: true, ..at(110.001) });
    assert_eq!((out.record.fault, out.drive), (Fault::CommandNotFinite, before.drive));
    bench.cycle(&at(109.99));
    let out = bench.cycle(&Input { reset: true, ..at(110.0) });
    assert!(!out.stop_requested());
    // A non-numeric command is not accepted either, nor one too far away.
    bench.cycle(&Input { feedback: [109.99; 3], ..at(f64::NAN) });
    for bad in [f64::NAN, f64::INFINITY, 109.949, 1e300] {
        bench.cycle(&at(110.0));
        assert!(bench.cycle(&Input { reset: true, feedback: [109.99; 3], ..at(bad) }).stop_requested(), "{bad}");
    }
    bench.cycle(&at(110.0));
    assert!(!bench.cycle(&Input { reset: true, ..at(109.951) }).stop_requested());
}

/// An axis so slow that the distance to the held command is a jump: nearness excuses it.
#[test]
fn a_reset_is_accepted_where_the_way_back_is_more_than_a_cycles() {
    let servo = servo_loop_with(1.0, |axis| axis.max_feed_per_s = 100.0);
    let mut bench = Bench::on(servo);
    bench.settle([50.0; 3]);
    bench.cycle(&Input { feedback: [50.0; 3], ..input([50.03, 50.0, 50.0]) });
    let out = bench.cycle(&Input { reset: true, feedback: [50.0; 3], ..input([50.04, 50.0, 50.0]) });
    assert!(!out.stop_requested());
    assert_eq!(out.record.command[0], 50.04);
}

/// One axis may be farther from the held command than a cycle's travel; that does not excuse another one out of its
/// travel.
#[test]
fn a_reset_is_ignored_where_one_axis_jumps_and_another_is_out_of_travel() {
    let servo = servo_loop_with(1.0, |axis| axis.max_feed_per_s = 100.0);
    let mut bench = Bench::on(servo);
    let at = |x, y| input([x, y, 50.0]);
    bench.settle([50.0, 109.99, 50.0]);
    let before = bench.cycle(&at(50.0, 109.99));
    bench.cycle(&Input { feedback: [50.0, 109.99, 50.0], ..at(f64::NAN, 109.99) });
    let out = bench.cycle(&Input { reset: true, ..at(50.04, 110.001) });
    assert_eq!((out.record.fault, out.drive), (Fault::CommandNotFinite, before.drive));
    bench.cycle(&at(50.0, 109.99));
    assert!(!bench.cycle(&Input { reset: true, ..at(50.04, 110.0) }).stop_requested());
}

/// The farthest trusted readings: travel, 0.1 mm of correction in the joint, 1 mm.
const READABLE: [f64; 2] = [-11.1, 111.1];

/// A nanometre counter that wraps at 32 bits reads 4.295 m away on an axis of 120 mm: rejected even after ten seconds.
#[test]
fn a_reading_beyond_the_travel_is_rejected_however_long_it_lasts() {
    for off in [-4294.967296, 4294.967296, 112.0, -112.0] {
        let mut bench = at_rest(50.0);
        let before = bench.last.unwrap();
        let (mut x, mut good) = (50.0, 50.0);
        for n in 0..100_000_u32 {
            x += if n / 2000 % 2 == 0 { 0.02 } else { -0.02 };
            let out = bench.cycle(&Input { feedback: [x + off, 50.0, 50.0], ..input([x, 50.0, 50.0]) });
            let reported = (out.record.fault, out.record.fault_axis, out.record.feedback[0]);
            assert_eq!(reported, (Fault::FeedbackJump, 0, good), "{off} mm, cycle {n}");
            assert_eq!(out.record.correction, before.record.correction);
            assert!(!out.stop_requested());
        }
        // The fault ends as soon as the reading returns.
        good = x;
        let out = bench.cycle(&input([x, 50.0, 50.0]));
        assert_eq!((out.record.fault, out.record.feedback[0]), (Fault::None, good), "{off} mm");
    }
}

#[test]
fn readings_are_accepted_a_millimetre_beyond_the_joint() {
    let [low, high] = READABLE;
    for (end, reading, accepted) in
        [(-10.0, low + 1e-6, true), (-10.0, low - 1e-6, false), (110.0, high - 1e-6, true), (110.0, high + 1e-6, false)]
    {
        let mut bench = at_rest(end);
        // An axis coasts beyond its end, 0.1 mm per cycle, while the command stays at the end.
        let mut at = end;
        for _ in 0..11 {
            at += 0.1 * (reading - end).signum();
            let out = bench.cycle(&Input { feedback: [end, at, end], ..input([end; 3]) });
            assert_eq!((out.record.fault, out.record.feedback[1]), (Fault::None, at));
        }
        let out = bench.cycle(&Input { feedback: [end, reading, end], ..input([end; 3]) });
        let expected = if accepted { (Fault::None, 0, reading) } else { (Fault::FeedbackJump, 1, at) };
        assert_eq!((out.record.fault, out.record.fault_axis, out.record.feedback[1]), expected, "{reading}");
    }
}

/// Before homing and while switched off, any number is a reading; those left over are rejected when the step becomes
/// active.
#[test]
fn where_readings_may_be_counts_from_homed_and_enabled_on() {
    let far = [-4284.0, 50.0, 50.0];
    for [homed, enable] in [[false, true], [true, false], [false, false]] {
        let off = |feedback| Input { homed, enable, feedback, ..input([50.0; 3]) };
        let mut bench = Bench::new();
        for _ in 0..10 {
            let out = bench.cycle(&off(far));
            assert_eq!((out.record.fault, out.record.feedback), (Fault::None, far));
        }
        // The command replaces a missing reading, even in the very first cycle.
        for mut bench in [bench, Bench::new()] {
            for _ in 0..10 {
                let out = bench.cycle(&Input { feedback: far, ..input([50.0; 3]) });
                let reported = (out.record.fault, out.record.fault_axis, out.record.feedback[0]);
                assert_eq!(reported, (Fault::FeedbackJump, 0, 50.0));
                assert!(!out.record.status.has(Status::ACTIVE));
            }
            let out = bench.cycle(&input([50.0; 3]));
            assert_eq!((out.record.fault, out.record.feedback), (Fault::None, [50.0; 3]));
        }
    }
    // Nor is it a position to hold before the first command.
    let mut bench = Bench::new();
    let unusable = |feedback| Input { feedback, ..input([f64::NAN, 50.0, 50.0]) };
    assert!(!bench.cycle(&unusable(far)).has_drive());
    assert_eq!(bench.cycle(&unusable([60.0; 3])).drive, [60.0; 3]);
    // An undeclared travel ends at 1 km, and so do the readings.
    let servo = servo_loop_with(1.0, |axis| (axis.travel, axis.joint) = ([-1e6, 1e6], [-1e6 - 0.1, 1e6 + 0.1]));
    let mut bench = Bench::on(servo);
    for (x, accepted) in [(1_000_001.0, true), (1_000_001.2, false), (-1_000_001.2, false)] {
        bench.state = servo.start();
        bench.last = None;
        let out = bench.cycle(&Input { feedback: [x, 50.0, 50.0], ..input([50.0; 3]) });
        assert_eq!(out.record.fault == Fault::None, accepted, "{x}");
    }
}

/// Resolution of the encoder in the tests below, 1 µm.
const COUNT: f64 = 1e-3;

/// A bench at rest whose encoders have this resolution.
fn with_encoders(step: f64, backlash: f64) -> Bench {
    let mut bench = Bench::on(servo_loop_with(1.0, |axis| {
        (axis.encoder_resolution, axis.backlash, axis.hysteresis) = (Some(step), backlash, 3e-3);
    }));
    bench.settle([50.0; 3]);
    bench
}

/// Number of cycles until X counts as stuck, commanded by `command(n)` and read as `reading(n)`; `None` if not within
/// 20,000.
fn found(bench: &mut Bench, command: impl Fn(u32) -> f64, reading: impl Fn(u32) -> f64) -> Option<u32> {
    (1..=20_000).find(|n| {
        let given = Input { feedback: [reading(*n), 50.0, 50.0], ..input([command(*n), 50.0, 50.0]) };
        let fault = bench.cycle(&given).record.fault;
        assert!(matches!(fault, Fault::None | Fault::EncoderStuck), "{n}: {fault}");
        fault == Fault::EncoderStuck
    })
}

/// Dead encoders that still change slightly: a count to either side, a last digit that drifts.
#[test]
fn a_dead_encoder_that_is_not_quite_still_is_found_by_its_resolution() {
    let noise = |n: u32| [0.0, COUNT, -COUNT, COUNT, 0.0, -COUNT][n as usize % 6];
    let drift = |n: u32| 1e-6 * f64::from(n);
    let to_and_fro = |n: u32| 50.0 + 0.005 * f64::from((n % 20).abs_diff(10)) - 0.05;
    let on = |n: u32| 50.0 + 0.01 * f64::from(n % 5000);
    for dead in [noise, drift] {
        for sign in [1.0, -1.0] {
            let going = |n: u32| 50.0 + sign * (on(n) - 50.0);
            let mut bench = with_encoders(COUNT, 0.0);
            let cycle = found(&mut bench, going, |n| 50.0 + dead(n));
            // 0.2 mm at 0.01 mm per cycle, plus the size of a first move.
            assert!(cycle.is_some_and(|n| (20..=24).contains(&n)), "{cycle:?}");
            // The fault lasts as long as the encoder is dead, and the last reading before it is used.
            for n in 25..4000 {
                let given = Input { feedback: [50.0 + noise(n), 50.0, 50.0], ..input([going(n), 50.0, 50.0]) };
                let out = bench.cycle(&given);
                assert_eq!(out.record.fault, Fault::EncoderStuck, "{n}");
                assert!((out.record.feedback[0] - 50.0).abs() <= COUNT);
            }
            // The encoder works again.
            let back = Input { feedback: [going(3999), 50.0, 50.0], ..input([going(3999), 50.0, 50.0]) };
            assert_eq!(bench.cycle(&back).record.fault, Fault::None);
        }
    }
    let mut bench = with_encoders(COUNT, 0.0);
    let cycle = found(&mut bench, to_and_fro, |n| 50.0 + noise(n));
    assert!(cycle.is_some_and(|n| n < 80), "{cycle:?}");
    // Without a stated resolution any change counts.
    let mut bench = at_rest(50.0);
    assert_eq!(found(&mut bench, |n| 50.0 + 0.002 * f64::from(n), |n| 50.0 + noise(n)), None);
}

/// Healthy encoders that show little motion: none counts as dead.
#[test]
fn motion_below_the_resolution_is_no_dead_encoder() {
    let noise = |n: u32| [0.0, COUNT, -COUNT, COUNT, 0.0, -COUNT][n as usize % 6];
    let read = |x: f64, step: f64| (x / step).round() * step;
    // At rest, and at a feed of a hundredth of a count per cycle.
    let mut bench = with_encoders(COUNT, 0.0);
    assert_eq!(found(&mut bench, |_| 50.0, |n| 50.0 + noise(n)), None);
    let slow = |n: u32| 50.0 + 0.01 * COUNT * f64::from(n);
    let mut bench = with_encoders(COUNT, 0.0);
    assert_eq!(found(&mut bench, slow, |n| read(slow(n), COUNT) + noise(n)), None);
    // A command that trembles by less than three counts, 60 mm in total.
    let tremble = |n: u32| 50.0 + 1.5 * COUNT * if n.is_multiple_of(2) { 1.0 } else { -1.0 };
    let mut bench = with_encoders(COUNT, 0.0);
    assert_eq!(found(&mut bench, tremble, |n| 50.0 + noise(n)), None);
    // Back and forth within the backlash of a rack, with the encoder behind it.
    let within = |n: u32| 50.0 + 0.0025 * f64::from((n % 40).abs_diff(20)) - 0.05;
    let mut bench = with_encoders(COUNT, 0.05);
    assert_eq!(found(&mut bench, within, |n| 50.0 + noise(n)), None);
    // An encoder so coarse that three of its steps exceed the stated distance.
    let fast = |n: u32| 50.0 + 0.002 * f64::from((n % 8000).abs_diff(4000)) - 8.0;
    let mut bench = with_encoders(0.1, 0.0);
    let start = |n: u32| if n <= 4000 { 50.0 } else { fast(n - 4000 + 8000) };
    assert_eq!(found(&mut bench, start, |n| read(start(n), 0.1)), None);
}
