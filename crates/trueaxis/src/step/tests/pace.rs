//! Limits in seconds: cycles in a burst, after a stall, or permanently too fast move nothing further than their time
//! allows.

use super::dynamic::DRIVE;
use super::*;
use crate::dynamic::Dynamics;
use crate::machine::{AxisServo, DynamicSettings};

/// Largest change of a correction in a period, and of that change.
const SLOPE: f64 = 5.0 * T;
const ACCELERATION: f64 = 5000.0 * T * T;

/// Cycles of a motion along X, each with its own duration; passes on the number, the time so far and the output of each.
fn moving(cycles: u32, elapsed: impl Fn(u32) -> u32, mut seen: impl FnMut(u32, f64, &Out)) {
    let mut bench = Bench::new();
    let mut time = 0.0;
    for n in 0..cycles {
        let elapsed_ns = elapsed(n);
        time += f64::from(elapsed_ns);
        let out = bench.cycle(&Input { elapsed_ns, ..input([0.01 * f64::from(n), 20.0, 20.0]) });
        seen(n, time, &out);
    }
}

#[test]
fn a_cycle_more_than_a_quarter_early_freezes_as_a_late_one_does() {
    for (elapsed_ns, fault) in [
        (0, Fault::LateCycle),
        (PERIOD_NS / 10, Fault::LateCycle),
        (PERIOD_NS / 4 * 3 - 1, Fault::LateCycle),
        (PERIOD_NS / 4 * 3, Fault::None),
        (PERIOD_NS, Fault::None),
        (PERIOD_NS / 4 * 5, Fault::None),
        (PERIOD_NS / 4 * 5 + 1, Fault::LateCycle),
    ] {
        let off = |n: u32| matches!(n, 400 | 600 | 800);
        moving(
            1000,
            |n| if off(n) { elapsed_ns } else { PERIOD_NS },
            |n, _, out| {
                let expected = if off(n) { fault } else { Fault::None };
                assert_eq!((out.record.fault, out.stop_requested()), (expected, false), "cycle {n} of {elapsed_ns} ns");
                assert_eq!(out.record.status.has(Status::FROZEN), expected != Fault::None);
            },
        );
    }
}

#[test]
fn cycles_without_time_move_nothing_and_the_correction_continues_as_before() {
    // The burst arrives while the correction ramps in at full slope.
    let mut bench = Bench::on(servo_loop(10.0));
    let at = input([30.0, 40.0, 50.0]);
    let mut moved = 0.0;
    let mut before = bench.cycle(&at);
    for _ in 0..60 {
        let out = bench.cycle(&at);
        moved = out.record.correction[0] - before.record.correction[0];
        before = out;
    }
    assert!(moved.abs() > 0.9 * SLOPE, "{moved}");
    for _ in 0..1000 {
        let out = bench.cycle(&Input { elapsed_ns: 0, ..at });
        assert_eq!((out.record.fault, out.drive), (Fault::LateCycle, before.drive));
    }
    // The burst leaves at most one movement over; after that each period brings one.
    let out = bench.cycle(&at);
    assert_eq!(out.record.fault, Fault::None);
    let next = out.record.correction[0] - before.record.correction[0];
    assert!((next - moved).abs() <= ACCELERATION * (1.0 + 1e-6), "{next} after {moved}");
}

#[test]
fn cycles_that_come_too_fast_for_ever_move_by_the_time_that_passes() {
    for (share, faults) in [(1.0, 0..=0), (0.9991, 0..=0), (0.95, 490..=510), (0.8, 1980..=2010), (0.76, 2380..=2400)] {
        let mut count = 0;
        let elapsed_ns = (share * f64::from(PERIOD_NS)) as u32;
        moving(10_000, |_| elapsed_ns, |_, _, out| count += u32::from(out.record.fault == Fault::LateCycle));
        assert!(faults.contains(&count), "{share}: {count}");
    }
}

#[test]
fn jitter_about_a_schedule_is_no_fault() {
    let mut noise = crate::testing::noise::Noise::new(5);
    let off: Vec<f64> = (0..20_000).map(|_| 0.12 * noise.signed()).collect();
    let at = |n: usize| ((n as f64 + off[n] + 1.0) * f64::from(PERIOD_NS)) as u32;
    moving(
        9_000,
        |n| if n == 0 { PERIOD_NS } else { at(n as usize) - at(n as usize - 1) },
        |n, _, out| assert_eq!(out.record.fault, Fault::None, "cycle {n}"),
    );
}

/// How cycles arrive.
#[derive(Clone, Copy, Debug)]
enum Arrival {
    /// Each takes this share of a period.
    Share(f64),
    /// Between three quarters and five quarters of a period, from this seed.
    Jitter(u64),
    /// Once many periods, then no time.
    Stall(u32),
}

/// What happens during these cycles.
#[derive(Clone, Copy, Debug)]
enum Disturbance {
    Nothing,
    Off,
    Alarm,
    Exchange,
    BadCommand,
    Leap,
}

fn any_arrival() -> impl Strategy<Value = (Arrival, Disturbance, u32)> {
    let share = prop_oneof![
        Just(0.0),
        Just(0.1),
        Just(0.5),
        Just(0.74),
        Just(0.75),
        Just(0.8),
        Just(0.9995),
        Just(1.0),
        Just(1.2),
        Just(1.3),
        0.0..2.0f64
    ];
    let arrival = prop_oneof![
        4 => share.prop_map(Arrival::Share),
        2 => any::<u64>().prop_map(Arrival::Jitter),
        1 => (2..50u32).prop_map(Arrival::Stall),
    ];
    let disturbance = prop_oneof![
        4 => Just(Disturbance::Nothing),
        1 => Just(Disturbance::Off),
        1 => Just(Disturbance::Alarm),
        1 => Just(Disturbance::Exchange),
        1 => Just(Disturbance::BadCommand),
        1 => Just(Disturbance::Leap),
    ];
    (arrival, disturbance, 1..200u32)
}

/// Lag and a learned correction, so that the dynamic part moves as well.
fn dynamic_loop(scale: f64) -> &'static Loop {
    loop_of(
        scale,
        machine(|axis| {
            let own = DynamicSettings::with_defaults(axis.axis);
            let dynamic = DynamicSettings { limits: axis.limits, lag: true, acceleration: true, ..own };
            axis.servo = AxisServo { drive: Some(DRIVE), friction: None, dynamic: Some(dynamic) };
        }),
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: crate::testing::share::share(500) as u32, ..ProptestConfig::default() })]

    /// Between any two cycles, the sum of corrections changes by no more than the slope allows in the time between them,
    /// plus one period's worth; and from one movement to the next by no more than the acceleration.
    #[test]
    fn over_any_time_a_correction_moves_by_its_slope_and_a_cycle_at_most(
        sequence in prop::collection::vec(any_arrival(), 1..30),
        parts in any::<bool>(),
    ) {
        let loops = if parts { [dynamic_loop(9.0), dynamic_loop(-4.0)] } else { [servo_loop(9.0), servo_loop(-4.0)] };
        let mut state = loops[0].start();
        let (mut which, mut at, mut time) = (0, 30.0, 0.0);
        let (mut clock, mut first) = (Clock::default(), true);
        let (mut sent, mut rate) = ([0.0; 3], [0.0; 3]);
        // The least c − s t and the greatest c + s t so far, s the slope.
        let (mut least, mut greatest) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let slope = SLOPE / 0.999;
        for (arrival, disturbance, cycles) in sequence {
            let mut noise = crate::testing::noise::Noise::new(if let Arrival::Jitter(seed) = arrival { seed } else { 0 });
            which ^= usize::from(matches!(disturbance, Disturbance::Exchange));
            for n in 0..cycles {
                let share = match arrival {
                    Arrival::Share(share) => share,
                    Arrival::Jitter(_) => 1.0 + 0.25 * noise.signed(),
                    Arrival::Stall(periods) if n == 0 => f64::from(periods),
                    Arrival::Stall(_) => 0.01,
                };
                let elapsed_ns = (share * f64::from(PERIOD_NS)) as u32;
                at = if at > 90.0 { at } else { at + 0.01 };
                let command = [at, 40.0, 50.0];
                let learned = if matches!(disturbance, Disturbance::Leap) { [0.04, -0.04, 0.0] } else { [0.0; 3] };
                let given = Input {
                    command: if matches!(disturbance, Disturbance::BadCommand) && n == 5 { [f64::NAN; 3] } else { command },
                    feedback: command,
                    elapsed_ns,
                    enable: !matches!(disturbance, Disturbance::Off),
                    encoder_alarm: u8::from(matches!(disturbance, Disturbance::Alarm)),
                    reset: n % 2 == 1,
                    dynamics: Dynamics::ALL,
                    learned,
                    ..input(command)
                };
                let out = loops[which].step(&mut state, &given, (), ());
                let held = out.stop_requested();
                let due = clock.due(elapsed_ns, first);
                first &= held;
                time += f64::from(elapsed_ns) / f64::from(PERIOD_NS);
                for k in 0..3 {
                    let c = out.drive[k] - out.record.command[k];
                    let v = c - sent[k];
                    sent[k] = c;
                    least[k] = least[k].min(c - slope * time);
                    greatest[k] = greatest[k].max(c + slope * time);
                    prop_assert!(c - slope * time <= least[k] + SLOPE * (1.0 + 1e-6) + 1e-9, "{time}: {c}, {arrival:?}");
                    prop_assert!(c + slope * time >= greatest[k] - SLOPE * (1.0 + 1e-6) - 1e-9, "{time}: {c}, {arrival:?}");
                    prop_assert!(due && !held || v.abs() < 1e-12, "{v} in no time, {arrival:?}, {disturbance:?}");
                    if held {
                        rate[k] = 0.0;
                    } else if due {
                        let second = v - rate[k];
                        prop_assert!(second.abs() <= ACCELERATION + 1e-9, "{second}, {arrival:?}, {disturbance:?}");
                        rate[k] = v;
                    }
                }
            }
        }
    }
}
