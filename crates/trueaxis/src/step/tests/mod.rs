#![allow(clippy::indexing_slicing)]

mod adapt;
mod cells;
mod combinations;
mod common_lag;
mod dynamic;
mod faults;
mod finite;
mod harm;
mod pace;
mod periodic;
mod plausibility;
mod ratio;
mod rtcp;
mod tool;
mod transitions;
mod window;

use super::*;
use crate::compensation::Direction;
use crate::compensation::Query;
use crate::contour::{Method, Path, Reference};
use crate::error::Field;
use crate::exchange::Exchange;
use crate::machine::MachineSettings;
use crate::machine::{AxisSettings, Interpolation, Row};
use crate::sample::Refusal;
use crate::testing::machine::Machine;
use proptest::prelude::*;
use std::{boxed::Box, vec, vec::Vec};

pub(super) const PERIOD_NS: u32 = 100_000;
const T: f64 = 1e-4;
pub(super) type Loop = ServoLoop<'static, f64, f64, 3>;
type Out = Output<f64, f64, 3>;

/// Each axis gives 6 to 12 µm of error to all three components; travel −10 … 110.
pub(super) fn servo_loop(scale: f64) -> &'static Loop {
    servo_loop_with(scale, |_| ())
}

/// [`servo_loop`] in other scalars, with other settings of every axis.
pub(super) fn servo_loop_with<R: Real, P: Position>(
    scale: f64,
    change: impl Fn(&mut AxisSettings),
) -> &'static ServoLoop<'static, R, P, 3> {
    loop_of(scale, machine(change))
}

/// [`servo_loop`] for a whole machine.
pub(super) fn loop_of<R: Real, P: Position>(
    scale: f64,
    machine: MachineSettings,
) -> &'static ServoLoop<'static, R, P, 3> {
    let rows: Vec<Row> = (0..=10)
        .map(|i| {
            let e = scale * (0.006 + 0.0006 * f64::from(i));
            let forward = [e, -e, 0.5 * e, 0.0, 0.0, 0.0];
            Row { position: 10.0 * f64::from(i), forward, reverse: forward }
        })
        .collect();
    loop_on(rows.leak(), machine)
}

/// [`loop_of`] with one table of these rows for every axis.
pub(super) fn loop_on<R: Real, P: Position>(
    rows: &'static [Row],
    machine: MachineSettings,
) -> &'static ServoLoop<'static, R, P, 3> {
    let config = Config {
        machine: Box::leak(Box::new(machine)),
        grids: &[],
        machine_id: 7,
        tables_crc: 9,
        period_ns: PERIOD_NS,
        inverse_passes: 3,
        method: Method::Guarded,
    };
    let memory = vec![R::ZERO; config.requirement(|_| Some(rows))].leak();
    Box::leak(Box::new(config.build(|_| Some(rows), memory).unwrap()))
}

/// Settings of a machine with three linear axes, without its tables.
pub(super) fn machine(change: impl Fn(&mut AxisSettings)) -> MachineSettings {
    let machine = Machine::three_axis().travel([-10.0, 110.0], 0.1);
    machine.each(|axis| axis.interpolation = Interpolation::Cubic).each(change).settings()
}

pub(super) fn input(command: [f64; 3]) -> Input<f64, 3> {
    Input {
        command,
        feedback: command,
        encoder_alarm: 0,
        elapsed_ns: PERIOD_NS,
        homed: true,
        enable: true,
        reset: false,
        refusal: Refusal::NONE,
        ..Input::at_rest(PERIOD_NS)
    }
}

/// When corrections may move, by the rule of [`Input::elapsed_ns`].
#[derive(Default)]
struct Clock {
    time_ns: u64,
}

impl Clock {
    const PACE_NS: u64 = PERIOD_NS as u64 * 999 / 1000;

    fn due(&mut self, elapsed_ns: u32, first: bool) -> bool {
        let elapsed = if first { u64::MAX / 2 } else { elapsed_ns.into() };
        self.time_ns = (self.time_ns + elapsed).min(2 * Clock::PACE_NS - 1);
        let due = self.time_ns >= Clock::PACE_NS;
        self.time_ns -= if due { Clock::PACE_NS } else { 0 };
        due
    }
}

/// Runs cycles and checks each against the limits of the correction; a cycle that is not due must not move it.
///
/// While the output holds, drive and correction stay bit for bit, and the next motion starts from rest.
struct Bench {
    active: &'static Loop,
    state: State<f64, f64, 3>,
    correction: [f64; 3],
    velocity: [f64; 3],
    last: Option<Out>,
    clock: Clock,
    due: bool,
    started: bool,
}

impl Bench {
    fn new() -> Self {
        Bench::on(servo_loop(1.0))
    }

    fn on(active: &'static Loop) -> Self {
        let state = active.start();
        let (clock, due, started) = (Clock::default(), true, false);
        Bench { active, state, correction: [0.0; 3], velocity: [0.0; 3], last: None, clock, due, started }
    }

    fn cycle(&mut self, input: &Input<f64, 3>) -> Out {
        let none = Path::new(&[], 0, false);
        let out = self.active.step(&mut self.state, input, none.on(Reference { span: 0, t: 0.0 }), ());
        let held = out.stop_requested();
        let last = self.last.replace(out).filter(Out::has_drive);
        self.due = self.clock.due(input.elapsed_ns, !self.started);
        self.started |= !held;
        for k in 0..3 {
            let c = out.record.correction[k];
            assert!(out.drive[k].is_finite() && out.feedback[k].is_finite());
            assert!(c.abs() <= 0.1 * (1.0 + 1e-6), "magnitude {c}");
            // The record contains the correction actually sent.
            let command = out.record.command[k];
            let sent = if c == 0.0 { command } else { command + c };
            assert_eq!(out.drive[k].to_bits(), sent.to_bits(), "{command} + {c} is not {}", out.drive[k]);
            if held {
                assert_eq!(c.to_bits(), self.correction[k].to_bits(), "a held correction moves");
                if let Some(last) = last {
                    assert_eq!(out.drive[k].to_bits(), last.drive[k].to_bits(), "a held output moves");
                    assert_eq!(command.to_bits(), last.record.command[k].to_bits(), "a held command moves");
                }
                self.velocity[k] = 0.0;
                continue;
            }
            assert_eq!(command.to_bits(), input.command[k].to_bits());
            let v = c - self.correction[k];
            if !self.due {
                assert_eq!(c.to_bits(), self.correction[k].to_bits(), "a correction moves in no time");
                continue;
            }
            assert!(v.abs() <= 5.0 * T * (1.0 + 1e-6), "slope {v}");
            assert!(
                (v - self.velocity[k]).abs() <= 5000.0 * T * T * (1.0 + 1e-6),
                "acceleration {}",
                v - self.velocity[k]
            );
            self.correction[k] = c;
            self.velocity[k] = v;
        }
        out
    }

    fn settle(&mut self, command: [f64; 3]) -> Out {
        for _ in 0..2000 {
            self.cycle(&input(command));
        }
        self.cycle(&input(command))
    }
}

#[test]
fn the_first_cycle_returns_the_command_bit_for_bit() {
    for command in [[50.0, 60.0, 70.0], [-0.0, 0.0, 1e-300]] {
        let mut bench = Bench::new();
        let out = bench.cycle(&input(command));
        assert_eq!(out.drive.map(f64::to_bits), command.map(f64::to_bits));
        assert_eq!(out.record.sequence, 0);
    }
}

#[test]
fn the_machine_reaches_the_command_and_the_host_sees_no_following_error() {
    let mut bench = Bench::new();
    let command = [55.0, 35.0, 25.0];
    let out = bench.settle(command);
    assert_eq!(out.record.limited, 0);
    let compensation = bench.active.compensation();
    let at = compensation.coordinates(&out.drive);
    let error = compensation.errors(&Query::at(&at, &[Direction::POSITIVE; 3], &[ThermalLine::default(); 3]), &mut 0);
    for k in 0..3 {
        assert!((out.drive[k] + error[k] - command[k]).abs() < 1e-6);
        assert!((out.drive[k] - command[k]).abs() > 1e-3);
    }
    let mut fed_back = input(command);
    fed_back.feedback = out.drive;
    let out = bench.cycle(&fed_back);
    for k in 0..3 {
        assert!((out.feedback[k] - command[k]).abs() < 1e-12);
    }
}

#[test]
fn inactive_until_homed_and_enabled_and_bumpless_both_ways() {
    let mut bench = Bench::new();
    let command = [40.0, 40.0, 40.0];
    for _ in 0..100 {
        let out = bench.cycle(&Input { homed: false, ..input(command) });
        assert_eq!(out.drive, command);
        let out = bench.cycle(&Input { enable: false, ..input(command) });
        assert_eq!(out.drive, command);
        assert!(!out.record.status.has(Status::ACTIVE));
    }
    let out = bench.settle(command); // the limits are checked in every cycle
    assert!(out.record.correction[0].abs() > 0.02);
    for _ in 0..2000 {
        bench.cycle(&Input { enable: false, ..input(command) });
    }
    let out = bench.cycle(&Input { enable: false, ..input(command) });
    assert_eq!(out.drive, command);
}

#[test]
fn tables_are_exchanged_between_two_cycles_of_a_moving_machine() {
    let mut bench = Bench::new();
    let mailbox = Exchange::new();
    bench.settle([20.0, 30.0, 40.0]);
    let other = servo_loop(-2.0);
    let mut x = 20.0;
    for n in 0..8000 {
        if n == 1000 {
            mailbox.offer(other).unwrap();
        }
        mailbox.take_into(&mut bench.active);
        x += 0.01; // 100 mm/s
        let out = bench.cycle(&input([x, 30.0, 40.0]));
        assert_eq!(out.record.fault, Fault::None);
    }
    let out = bench.cycle(&input([x, 30.0, 40.0]));
    assert_eq!(out.record.limited, 0);
    assert!(out.record.correction[0] > 0.03);
}

#[test]
fn bad_feedback_freezes_the_correction_and_lets_the_command_pass() {
    let far = 60.0;
    type Spoil = fn(&mut Input<f64, 3>);
    let cases: [(Fault, Spoil); 5] = [
        (Fault::FeedbackNotFinite, |i| i.feedback[1] = f64::NAN),
        (Fault::FeedbackNotFinite, |i| i.feedback[0] = f64::INFINITY),
        (Fault::FeedbackJump, |i| i.feedback[2] += 0.5),
        (Fault::EncoderAlarm, |i| i.encoder_alarm = 0b100),
        (Fault::LateCycle, |i| i.elapsed_ns = 3 * PERIOD_NS),
    ];
    for (fault, spoil) in cases {
        let mut bench = Bench::new();
        let before = bench.settle([far; 3]);
        for n in 1..=3 {
            let mut bad = input([far + 0.01 * f64::from(n), far, far]);
            spoil(&mut bad);
            let out = bench.cycle(&bad);
            assert_eq!(out.record.fault, fault);
            assert!(out.record.status.has(Status::FROZEN) && !out.stop_requested());
            assert_eq!(out.record.correction, before.record.correction);
            assert_eq!(out.drive[0], bad.command[0] + before.record.correction[0]);
        }
        let out = bench.cycle(&input([far + 0.03, far, far]));
        assert_eq!(out.record.fault, Fault::None);
    }
}

#[test]
fn a_stuck_encoder_is_found_after_the_stated_way() {
    let mut bench = Bench::new();
    bench.settle([20.0; 3]);
    let mut found = None;
    for n in 1..200 {
        let way = 0.01 * f64::from(n);
        let mut stuck = input([20.0 + way, 20.0, 20.0]);
        stuck.feedback[0] = 20.0;
        if bench.cycle(&stuck).record.fault == Fault::EncoderStuck {
            found = found.or(Some(way));
        }
    }
    assert!(found.is_some_and(|way| (0.2..0.23).contains(&way)), "{found:?}");
}

#[test]
fn a_bad_command_holds_until_a_reset_near_the_held_position() {
    let cases: [(Fault, [f64; 3]); 5] = [
        (Fault::CommandNotFinite, [f64::NAN, 60.0, 60.0]),
        (Fault::CommandNotFinite, [60.0, f64::NEG_INFINITY, 60.0]),
        (Fault::CommandNotFinite, [60.0, 60.0, 1e300]),
        (Fault::CommandOutOfTravel, [60.0, 60.0, 110.5]),
        (Fault::CommandJump, [60.0, 59.0, 60.0]),
    ];
    for (fault, bad) in cases {
        let mut bench = Bench::new();
        let before = bench.settle([60.0; 3]);
        let out = bench.cycle(&Input { feedback: [60.0; 3], ..input(bad) });
        assert_eq!(out.record.fault, fault);
        assert!(out.stop_requested());
        assert_eq!(out.drive, before.drive);
        // Held, although the command is good again and a reset arrives too far away.
        let good = input([60.0; 3]);
        assert_eq!(bench.cycle(&good).drive, before.drive);
        let away = Input { reset: true, ..input([60.2, 60.0, 60.0]) };
        assert!(bench.cycle(&away).stop_requested());
        // Only the rising edge of the reset counts.
        assert!(bench.cycle(&Input { reset: true, ..good }).stop_requested());
        assert!(bench.cycle(&good).stop_requested());
        let out = bench.cycle(&Input { reset: true, ..input([60.04, 60.0, 60.0]) });
        assert!(!out.stop_requested() && out.record.fault == Fault::None);
        assert!((out.drive[0] - before.drive[0]).abs() <= 0.05 + 1e-9);
        assert!(!bench.cycle(&input([60.04, 60.0, 60.0])).stop_requested());
    }
}

#[test]
fn readings_that_stood_during_a_stop_are_accepted_after_it() {
    let mut bench = Bench::new();
    bench.settle([60.0; 3]);
    bench.cycle(&Input { feedback: [60.0; 3], ..input([60.0, f64::NAN, 60.0]) });
    // For a second the host commands a point slightly off the held command: this adds no commanded distance.
    let off_command = Input { feedback: [60.0; 3], ..input([60.04; 3]) };
    for _ in 0..10_000 {
        assert!(bench.cycle(&off_command).stop_requested());
    }
    bench.cycle(&Input { reset: true, ..off_command });
    for _ in 0..100 {
        assert_eq!(bench.cycle(&off_command).record.fault, Fault::None);
    }
}

#[test]
fn another_period_is_refused() {
    let servo = servo_loop(1.0);
    assert_eq!(servo.check_period(1_000_000), Err(Fault::PeriodMismatch));
    assert_eq!(servo.check_period(PERIOD_NS + PERIOD_NS / 500), Err(Fault::PeriodMismatch));
    assert_eq!(servo.check_period(PERIOD_NS + 10), Ok(()));
}

#[test]
fn thermal_growth_is_taken_up_without_a_jump() {
    let mut bench = Bench::new();
    let cold = bench.settle([50.0; 3]);
    bench.state.set_thermal(0, ThermalLine::new(0.005, 2e-4).unwrap()).unwrap();
    let warm = bench.settle([50.0; 3]);
    assert!((warm.record.correction[0] - cold.record.correction[0] + 0.005 + 50.0 * 2e-4).abs() < 1e-5);
    assert!(ThermalLine::<f64>::new(f64::NAN, 0.0).is_none() && ThermalLine::<f64>::new(0.0, 0.1).is_none());
}

#[test]
fn growth_of_a_slot_that_the_step_lacks_is_refused() {
    let [mut bench, mut other] = [Bench::new(), Bench::new()];
    let line = ThermalLine::new(0.005, 2e-4).unwrap();
    for slot in [3, usize::MAX] {
        let error = bench.state.set_thermal(slot, line).unwrap_err();
        assert_eq!((error.field, error.found), (Field::Axes, slot as f64));
    }
    let [refused, untouched] = [&mut bench, &mut other].map(|bench| bench.settle([50.0; 3]).record.correction);
    assert_eq!(refused.map(f64::to_bits), untouched.map(f64::to_bits));
}

#[test]
fn edges_are_flagged_and_hold_their_value() {
    let mut bench = Bench::new();
    let out = bench.settle([50.0, 105.0, 50.0]);
    assert_eq!(out.record.at_edge, 0b010);
}

/// Any 64 bits as a float, ordinary values more often.
fn any_float() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -10.0..110.0f64,
        2 => -1e4..1e4f64,
        2 => any::<u64>().prop_map(f64::from_bits),
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN_POSITIVE, -0.0, 1e9, -1e9]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: crate::testing::share::share(50_000) as u32, ..ProptestConfig::default() })]

    /// Fifty arbitrary cycles: no panic, every output finite and within its limits, no jump while active.
    #[test]
    fn no_sequence_of_floats_makes_the_output_leave_its_limits(
        cycles in prop::collection::vec((any_float(), any_float(), any_float(), any::<u8>()), 50),
    ) {
        let mut bench = Bench::new();
        let mut base = 50.0;
        let mut last: Option<Out> = None;
        for (a, b, c, bits) in cycles {
            let near = |x: f64| if bits & 1 == 0 { base + 1e-4 * x.abs().min(500.0) } else { x };
            let command = [near(a), near(b), near(c)];
            let out = bench.cycle(&Input {
                command,
                feedback: if bits & 2 == 0 { command } else { [b, c, a] },
                encoder_alarm: if bits & 0xf0 == 0xf0 { bits } else { 0 },
                elapsed_ns: if bits & 4 == 0 { PERIOD_NS } else { u32::from(bits) << 24 },
                homed: bits & 24 != 24,
                enable: bits & 40 != 40,
                reset: bits & 64 != 0,
                refusal: Refusal::NONE,
                ..Input::at_rest(PERIOD_NS)
            });
            if let Some(last) = last {
                for k in 0..3 {
                    if out.record.status.has(Status::ACTIVE) && last.record.status.has(Status::ACTIVE) {
                        prop_assert!((-10.1..=110.1).contains(&out.drive[k]), "{:?}", out.drive);
                    }
                }
            }
            base = if out.drive[0].abs() < 100.0 { out.drive[0] } else { base };
            last = Some(out);
        }
    }
}
