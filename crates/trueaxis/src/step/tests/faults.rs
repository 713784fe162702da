//! Faulty hosts, readings that are noisy or wrap, cycles delivered twice, exchanges at the wrong moment.

use super::*;
use crate::machine::ErrorModel;
use crate::sample::EncoderScale;
use crate::testing::noise::Noise;
use std::sync::atomic::{AtomicBool, Ordering};

const HELD: [f64; 3] = [60.0, 50.0, 40.0];

/// A bench whose output holds after a non-numeric command.
fn stopped() -> (Bench, Out) {
    let mut bench = Bench::new();
    bench.settle(HELD);
    let out = bench.cycle(&Input { feedback: HELD, ..input([f64::NAN, 50.0, 40.0]) });
    assert!(out.stop_requested());
    (bench, out)
}

/// The host continues its program as if no stop had been requested: commands, readings, resets far away.
#[test]
fn a_host_that_ignores_stop_requests_is_held_for_100_000_cycles() {
    let (mut bench, held) = stopped();
    for n in 0..100_000_u32 {
        let way = 0.02 * f64::from(n % 2000);
        let far = [HELD[0] - 1.0 - way, HELD[1], HELD[2]];
        let mut given = Input { feedback: HELD, ..input(far) };
        match n % 7 {
            0 => given.reset = true,
            1 => given.command[1] = f64::NAN,
            2 => given.elapsed_ns = 5 * PERIOD_NS,
            3 => given.encoder_alarm = 0b111,
            4 => given.feedback = far,
            5 => given.command = [1e6; 3],
            _ => {}
        }
        let out = bench.cycle(&given); // drive and correction to the bit
        assert!(out.stop_requested() && out.record.fault == Fault::CommandNotFinite, "cycle {n}");
        assert_eq!(out.drive.map(f64::to_bits), held.drive.map(f64::to_bits));
    }
    let near = Input { feedback: HELD, ..input(HELD) };
    bench.cycle(&near);
    assert!(!bench.cycle(&Input { reset: true, ..near }).stop_requested());
}

/// A reset in every other cycle, with a bad command after each accepted one: the output never moves by more than the
/// distance that a reset permits, and the correction keeps its limits (checked by the bench).
#[test]
fn a_host_that_resets_in_a_loop_gains_nothing() {
    let (mut bench, mut last) = stopped();
    let mut released = 0;
    for n in 0..20_000_u32 {
        let mut given = Input { feedback: HELD, reset: n % 2 == 1, ..input(HELD) };
        if n % 4 == 2 {
            given.command[2] = [f64::NAN, 1e9, -50.0, 45.0][(n / 4) as usize % 4];
        }
        let out = bench.cycle(&given);
        released += u32::from(last.stop_requested() && !out.stop_requested());
        for k in 0..3 {
            assert!((out.drive[k] - last.drive[k]).abs() <= 0.05 + 5e-4, "cycle {n}");
        }
        last = out;
    }
    assert!(released > 4000, "{released}");
    // A reset that stays on counts once.
    let (mut bench, _) = stopped();
    bench.cycle(&Input { feedback: HELD, reset: true, ..input([20.0, 50.0, 40.0]) });
    for _ in 0..1000 {
        assert!(bench.cycle(&Input { reset: true, ..input(HELD) }).stop_requested());
    }
}

/// Reading noise below the plausible jump is not a fault and does not reach the drives.
#[test]
fn noisy_readings_change_nothing_that_is_sent() {
    let mut noise = Noise::new(5);
    let [mut quiet, mut noisy] = [Bench::new(), Bench::new()];
    for n in 0..20_000_u32 {
        let x = 20.0 + 0.002 * f64::from(n);
        let given = input([x, 80.0 - x, 40.0]);
        let feedback = given.command.map(|c| c + 0.02 * noise.signed());
        let [expected, out] = [quiet.cycle(&given), noisy.cycle(&Input { feedback, ..given })];
        assert_eq!(out.record.fault, Fault::None);
        assert_eq!(out.drive.map(f64::to_bits), expected.drive.map(f64::to_bits));
    }
}

/// A counter that wraps at 32 bits makes the reading jump: the correction freezes as long as the jump lasts, the command
/// passes.
#[test]
fn a_counter_that_wraps_freezes_until_it_comes_back() {
    let scale = EncoderScale::new(60.0 - 0.1e-3 * f64::from(i32::MAX), 0.1e-3).unwrap();
    let mut bench = Bench::new();
    let before = bench.settle([60.0, 50.0, 40.0]);
    for n in 1..=2000 {
        let x = 60.0 + 1e-3 * f64::from(n);
        let counts = i32::MAX.wrapping_add(10 * n);
        assert!(counts < 0, "wrapped");
        let mut given = input([x, 50.0, 40.0]);
        given.feedback[0] = scale.position(counts);
        let out = bench.cycle(&given);
        assert_eq!((out.record.fault, out.record.fault_axis), (Fault::FeedbackJump, 0));
        assert_eq!(out.record.correction, before.record.correction);
        assert_eq!(out.drive[0].to_bits(), (x + before.record.correction[0]).to_bits());
        assert_eq!(out.record.feedback[0], 60.0, "the last good reading");
    }
    let mut given = input([62.0, 50.0, 40.0]);
    assert_eq!(bench.cycle(&given).record.fault, Fault::None, "the host counts on beyond 32 bits");
    given.command[0] += 0.001;
    assert_eq!(bench.cycle(&given).record.fault, Fault::None);
}

/// A cycle delivered twice, and a cycle lost with and without the host's knowledge.
#[test]
fn a_doubled_cycle_is_one_more_and_a_lost_one_is_late_or_unseen() {
    let mut bench = Bench::new();
    bench.settle([20.0; 3]);
    let mut x = 20.0;
    for n in 0..5000 {
        x += 0.02; // 200 mm/s
        if n % 10 == 5 {
            bench.cycle(&Input { elapsed_ns: 0, ..input([x, 20.0, 20.0]) });
        }
        let (late, unseen) = (n % 10 == 7, n % 10 == 9);
        let elapsed_ns = if late { 2 * PERIOD_NS } else { PERIOD_NS };
        x += if late || unseen { 0.02 } else { 0.0 };
        let out = bench.cycle(&Input { elapsed_ns, ..input([x, 20.0, 20.0]) });
        let expected = if late { Fault::LateCycle } else { Fault::None };
        assert_eq!((out.record.fault, out.stop_requested()), (expected, false), "cycle {n}");
        if x > 100.0 {
            (x, bench.state) = (20.0, bench.active.start());
            (bench.correction, bench.velocity, bench.last) = ([0.0; 3], [0.0; 3], None);
        }
    }
}

/// Exchanges tables while the correction is frozen, while the output holds, and twice before a cycle takes them.
#[test]
fn an_exchange_in_a_fault_in_a_hold_and_twice_waits_for_its_turn() {
    let other = servo_loop(-2.0);
    let mut bench = Bench::new();
    let before = bench.settle(HELD);
    bench.active = other;
    for _ in 0..500 {
        let out = bench.cycle(&Input { encoder_alarm: 1, ..input(HELD) });
        assert_eq!(out.record.correction.map(f64::to_bits), before.record.correction.map(f64::to_bits), "frozen");
    }
    let there = bench.settle(HELD).record.correction;
    assert!((there[0] - before.record.correction[0]).abs() > 0.02);

    let (mut bench, held) = stopped();
    bench.active = other;
    for _ in 0..500 {
        bench.cycle(&Input { feedback: HELD, ..input(HELD) }); // held to the bit
    }
    let out = bench.cycle(&Input { reset: true, ..input(HELD) });
    assert!((out.record.correction[0] - held.record.correction[0]).abs() <= 5e-5 * (1.0 + 1e-6), "from rest");
    assert_eq!(bench.settle(HELD).record.correction, there);

    let mailbox = Exchange::new();
    let third = servo_loop(0.5);
    assert!(mailbox.offer(other).is_ok());
    assert!(mailbox.offer(third).is_err_and(|back| std::ptr::eq(back, third)), "handed back");
    let mut active = bench.active;
    assert!(mailbox.take_into(&mut active).is_some() && mailbox.take_into(&mut active).is_none());
    assert!(std::ptr::eq(active, other) && mailbox.offer(third).is_ok());
}

/// A task on another thread offers tables as fast as it can while cycles run.
#[test]
fn tables_offered_from_another_thread_are_taken_between_two_cycles() {
    let tables = [servo_loop(1.0), servo_loop(-2.0), servo_loop(0.3)];
    let (mailbox, done) = (Exchange::new(), AtomicBool::new(false));
    std::thread::scope(|scope| {
        scope.spawn(|| {
            for n in (0..).take_while(|_| !done.load(Ordering::Relaxed)) {
                let _ = mailbox.offer(tables[n % 3]);
            }
        });
        let (mut bench, mut taken, mut n) = (Bench::new(), 0, 0_i32);
        // Runs until the other thread has had its turns, however busy the computer is.
        while taken < 200 || n < 30_000 {
            taken += u32::from(mailbox.take_into(&mut bench.active).is_some());
            let there_and_back = 0.002 * f64::from((n % 60_000 - 30_000).abs());
            let out = bench.cycle(&input([20.0 + there_and_back, 50.0, 40.0]));
            assert_eq!(out.record.fault, Fault::None);
            if n % 64 == 0 {
                std::thread::yield_now();
            }
            n = n.wrapping_add(1);
        }
        done.store(true, Ordering::Relaxed);
    });
}

/// Two hosts on two threads share one loop, each with its own state: each gets the same results as alone. One state for
/// both does not compile.
#[test]
fn one_loop_serves_two_threads_with_a_state_each() {
    let servo = servo_loop(1.0);
    let run = |from: f64| {
        let mut bench = Bench::on(servo);
        (0..20_000_u32)
            .map(|n| bench.cycle(&input([from + 0.002 * f64::from(n), 50.0, 40.0])).drive)
            .collect::<Vec<_>>()
    };
    let alone = [20.0, 60.0].map(run);
    let together = std::thread::scope(|scope| {
        let hosts = [20.0, 60.0].map(|from| scope.spawn(move || run(from)));
        hosts.map(|host| host.join().unwrap())
    });
    assert_eq!(alone, together);
}

/// A tool that is 200 mm longer arrives in motion, as new tables: the limiter ramps in the correction for its lever.
#[test]
fn a_tool_change_in_motion_is_ramped_in() {
    let with = |tool: f64| {
        let mut machine = machine(|_| ());
        (machine.compensation.model, machine.tool_mm) = (ErrorModel::Volumetric, [0.0, 0.0, -tool]);
        let row = |position| {
            let errors = [0.01, 0.0, 0.0, 1e-4, -1e-4, 0.0];
            Row { position, forward: errors, reverse: errors }
        };
        let servo: &'static Loop = loop_on(std::vec![row(-10.0), row(110.0)].leak(), machine);
        servo
    };
    let (short, long) = (with(50.0), with(250.0));
    let mut bench = Bench::on(short);
    let before = bench.settle([20.0; 3]).record.correction;
    let mut x = 20.0;
    for n in 0..4000 {
        if n == 1000 {
            bench.active = long;
        }
        x += 0.01;
        bench.cycle(&input([x, 20.0, 20.0])); // the limits are looked at in every cycle
    }
    let after = bench.settle([x, 20.0, 20.0]).record.correction;
    let change = (0..3).map(|k| (after[k] - before[k]).abs()).fold(0.0, f64::max);
    assert!(change > 0.02, "{before:?} {after:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: crate::testing::share::share(2000) as u32, ..ProptestConfig::default() })]

    /// A host restarted at any point of its program, with any first input: the first usable command goes out unchanged,
    /// and the correction ramps in from zero within its limits (checked by the bench).
    #[test]
    fn a_cold_start_anywhere_with_any_first_input_is_ramped_in(
        at in prop::array::uniform3(-10.0..110.0f64),
        velocity in prop::array::uniform3(-0.01..0.01f64),
        first in prop::array::uniform3(any_float()),
        feedback in prop::array::uniform3(any_float()),
        bits in any::<u8>(),
    ) {
        let mut bench = Bench::new();
        let out = bench.cycle(&Input {
            feedback,
            encoder_alarm: if bits & 8 == 0 { 0 } else { bits },
            elapsed_ns: if bits & 1 == 0 { PERIOD_NS } else { u32::MAX },
            homed: bits & 2 == 0,
            enable: bits & 4 == 0,
            reset: bits & 16 != 0,
            ..input(first)
        });
        prop_assert_eq!(out.record.correction, [0.0; 3]);
        let usable = first.iter().all(|x| x.is_finite() && x.abs() <= 1e9);
        prop_assert!(!out.has_drive() || out.stop_requested() || out.drive.map(f64::to_bits) == first.map(f64::to_bits));
        prop_assert!(usable || out.stop_requested());
        // The host retries at the machine's position, and continues.
        let mut bench = Bench::new();
        let mut largest = 0.0_f64;
        for n in 0..400 {
            let command = [0, 1, 2].map(|k| (at[k] + velocity[k] * f64::from(n)).clamp(-10.0, 110.0));
            let out = bench.cycle(&input(command));
            prop_assert!(!out.stop_requested() && out.record.fault == Fault::None);
            if n == 0 {
                prop_assert_eq!(out.drive.map(f64::to_bits), command.map(f64::to_bits));
            }
            largest = largest.max(out.record.correction[0].abs());
        }
        prop_assert!(largest > 1e-3, "{largest}");
    }
}
