//! Errors that repeat within a period, compared with the sum of their harmonics and the fixed point of the inverse.

use super::{PERIOD_NS, T};
use crate::compensation::{Compensation, Direction, Query, ThermalLine, requirement};
use crate::contour::{Method, Path, Segment, convert};
use crate::machine::{Axis, ErrorModel, GridAxis, GridData, GridHeader, MachineSettings, PeriodicSettings, Row};
use crate::position::{Nanometres, Position};
use crate::real::Real;
use crate::sample::Input;
use crate::step::{Config, Output, ServoLoop};
use crate::testing::machine::{Machine, rows};
use core::f64::consts::TAU;
use std::{boxed::Box, vec, vec::Vec};

/// Slope of the table of X.
const SLOPE: f64 = 2e-4;
/// Period, harmonics in positive travel, harmonics in negative travel (none: the same), mm or degrees.
type Waves = (f64, &'static [[f64; 2]], &'static [[f64; 2]]);
const SCREW: Waves = (5.0, &[[1.9e-3, -2.2e-3], [0.0, 0.8e-3]], &[]);
const MOTOR: Waves = (0.625, &[[1e-4, 2e-4]], &[[-1e-4, 2e-4], [0.0, 5e-5]]);
const WORM: Waves = (4.0, &[[0.0, 1e-3]], &[]);

fn period(axis: Axis, (period, forward, reverse): Waves) -> PeriodicSettings {
    PeriodicSettings {
        axis,
        period,
        harmonics: forward.iter().copied().collect(),
        reverse: reverse.iter().copied().collect(),
    }
}

/// The sum over the harmonics, term by term.
fn sum((period, forward, reverse): Waves, q: f64, negative: bool) -> f64 {
    let pairs = if negative && !reverse.is_empty() { reverse } else { forward };
    let term = |(h, [a, b]): (usize, &[f64; 2])| {
        let angle = TAU * (h + 1) as f64 * q / period;
        a * angle.cos() + b * angle.sin()
    };
    pairs.iter().enumerate().map(term).sum()
}

/// Error of X at a drive position.
fn of_x(q: f64, negative: bool) -> f64 {
    SLOPE * q + sum(SCREW, q, negative) + sum(MOTOR, q, negative)
}

/// r with r + E(q + r) = 0, by bisection.
fn inverse(error: impl Fn(f64) -> f64, q: f64) -> f64 {
    let (mut low, mut high) = (-0.2, 0.2);
    for _ in 0..80 {
        let r = 0.5 * (low + high);
        if r + error(q + r) < 0.0 { low = r } else { high = r }
    }
    0.5 * (low + high)
}

fn machine(chain: &str, model: ErrorModel) -> MachineSettings {
    let machine = Machine::new(chain).travel([-200.0, 200.0], 0.2).hysteresis(0.0005);
    let machine = machine.with(|machine| {
        machine.compensation.model = model;
        for waves in [SCREW, MOTOR] {
            machine.periodic.push(period(Axis::X, waves)).unwrap();
        }
    });
    machine.settings()
}

fn loop_of<R: Real, P: Position, const N: usize>(
    machine: MachineSettings,
    grids: &'static [GridData<'static>],
) -> &'static ServoLoop<'static, R, P, N> {
    let table: &'static [Row] = rows([-210.0, 0.0, 210.0], |q| [SLOPE * q, 0.0, 0.0, 0.0, 0.0, 0.0]).leak();
    let rows = |axis| (axis == Axis::X).then_some(table);
    let config = Config {
        machine: Box::leak(Box::new(machine)),
        grids,
        machine_id: 7,
        tables_crc: 9,
        period_ns: PERIOD_NS,
        inverse_passes: 4,
        method: Method::Guarded,
    };
    let memory = vec![R::ZERO; config.requirement(rows)].leak();
    Box::leak(Box::new(config.build(rows, memory).unwrap()))
}

fn input<P: Position, const N: usize>(command: [f64; N]) -> Input<P, N> {
    let command = command.map(P::of);
    Input { command, feedback: command, homed: true, enable: true, ..Input::at_rest(PERIOD_NS) }
}

/// Largest difference of a slot's correction from the fixed point, over motion at 100 mm/s in both directions, mm (deg).
fn deviation<R: Real, P: Position, const N: usize>(
    servo: &ServoLoop<'_, R, P, N>,
    slot: usize,
    error: impl Fn(f64, bool) -> f64,
) -> f64 {
    deviation_from(servo, slot, -97.0, error)
}

/// [`deviation`] from a start.
fn deviation_from<R: Real, P: Position, const N: usize>(
    servo: &ServoLoop<'_, R, P, N>,
    slot: usize,
    start: f64,
    error: impl Fn(f64, bool) -> f64,
) -> f64 {
    let mut state = servo.start();
    let mut at = [-97.0; N];
    at[slot] = start;
    let mut worst = 0.0_f64;
    for (speed, cycles) in [(100.0, 5_000), (-100.0, 5_000), (-1.0, 2_000)] {
        for cycle in 0..cycles {
            at[slot] += speed * T;
            let out: Output<R, P, N> = servo.step(&mut state, &input(at), (), ());
            // The correction first has to be led in, and lost motion to be crossed.
            if cycle > 1000 {
                let needed = inverse(|q| error(q, speed < 0.0), at[slot]);
                worst = worst.max((out.record.correction[slot].to_f64() - needed).abs());
            }
        }
    }
    worst
}

#[test]
fn the_correction_is_the_fixed_point_of_table_and_periods() {
    let nine = machine("w b X Y Z t", ErrorModel::Nine);
    assert!(deviation(loop_of::<f64, f64, 3>(nine.clone(), &[]), 0, of_x) < 1e-6);
    // In single precision the correction has steps of a nanometre.
    assert!(deviation(loop_of::<f32, Nanometres, 3>(nine, &[]), 0, of_x) < 2e-6);
    let volumetric = machine("w b X Y Z t", ErrorModel::Volumetric);
    assert!(deviation(loop_of::<f64, f64, 3>(volumetric, &[]), 0, of_x) < 1e-6);
    let five = machine("w C' A' b X Y Z t", ErrorModel::Nine);
    assert!(deviation(loop_of::<f64, f64, 5>(five, &[]), 0, of_x) < 1e-6);
}

#[test]
fn grids_and_periods_add() {
    let axis = |nodes| GridAxis { nodes, ends: [-100.0, 100.0], free: false };
    let header = GridHeader {
        axes: [axis(3), axis(2), GridAxis::default()],
        given: 1,
        scales: [1e-6, 0.0, 0.0, 0.0, 0.0, 0.0],
        fade: None,
        measured_at_mm: [0.0; 3],
    };
    let nodes: Vec<u8> = [0_i16, 0, 3000, 3000, -1000, -1000].iter().flat_map(|node| node.to_le_bytes()).collect();
    let (grid, _) = GridData::new(header, nodes.leak()).expect("a grid of six nodes");
    let height = |q: f64| if q < 0.0 { 3e-3 * (q + 100.0) / 100.0 } else { 3e-3 - 4e-3 * q / 100.0 };
    let nine = loop_of::<f64, f64, 3>(machine("w b X Y Z t", ErrorModel::Nine), vec![grid].leak());
    // Their boxes extend a little beyond the nodes, as far as a tenth of a nanometre allows.
    assert!(deviation(nine, 0, |q, negative| of_x(q, negative) + height(q)) < 1.1e-6);
}

#[test]
fn a_worm_of_a_rotary_axis_is_corrected_in_the_sense_of_its_table() {
    for (chain, sense) in [("w C' A' b X Y Z t", 1.0), ("w b X Y Z A C t", 1.0)] {
        let mut five = machine(chain, ErrorModel::Nine);
        five.periodic.push(period(Axis::C, WORM)).unwrap();
        // An axis that carries the workpiece turns the other way by default, and so does its error.
        let error = |q, negative| sense * sum(WORM, q, negative);
        assert!(deviation(loop_of::<f64, f64, 5>(five.clone(), &[]), 4, error) < 1e-6, "{chain}");
        // The same many turns later, in single precision too.
        let far = 3.6e6 - 97.0;
        five.axes[4].travel = [-1e9, 1e9];
        five.axes[4].joint = [-1e9 - 1.0, 1e9 + 1.0];
        assert!(deviation_from(loop_of::<f64, f64, 5>(five.clone(), &[]), 4, far, error) < 1e-6, "{chain}");
        assert!(deviation_from(loop_of::<f32, f64, 5>(five, &[]), 4, far, error) < 1e-6, "{chain}");
    }
}

#[test]
fn the_tip_includes_the_periods_at_the_feedback() {
    for model in [ErrorModel::Nine, ErrorModel::Volumetric] {
        let servo = loop_of::<f64, f64, 3>(machine("w b X Y Z t", model), &[]);
        for x in [-31.3, 0.2, 17.77] {
            let line = Segment::Line { start: [x, 0.0, 0.0].into(), end: [x, 100.0, 0.0].into() };
            let mut spans = Vec::new();
            convert(&line, 0, [0.0, 0.0, 1.0], |span| {
                spans.push(span);
                Ok(())
            })
            .unwrap();
            let path = Path::new(&spans, 0, false);
            let mut state = servo.start();
            let mut error = f64::NAN;
            for cycle in 0..100 {
                let y = 10.0 + 0.01 * f64::from(cycle);
                let given = Input { enable: false, ..input([x, y, 0.0]) };

                error = servo.step(&mut state, &given, path.at(0, y / 100.0), ()).record.tip.error;
            }
            assert!((error - of_x(x, false).abs()).abs() < 1e-7, "{model:?} at {x}: {error}");
        }
    }
}

#[test]
fn without_table_a_period_alone_is_corrected() {
    let mut machine = Machine::three_axis().travel([-200.0, 200.0], 0.2).settings();
    machine.periodic.push(period(Axis::Y, SCREW)).unwrap();
    assert!(deviation(loop_of::<f64, f64, 3>(machine, &[]), 1, |q, negative| sum(SCREW, q, negative)) < 1e-6);
}

#[test]
fn the_stateless_pose_is_that_of_the_errors() {
    for model in [ErrorModel::Nine, ErrorModel::Volumetric] {
        let machine = machine("w b X Y Z t", model);
        let table: &'static [Row] = rows([-210.0, 0.0, 210.0], |q| [SLOPE * q, 0.0, 0.0, 0.0, 0.0, 0.0]).leak();
        let tables = |axis| (axis == Axis::X).then_some(table);
        let memory = vec![0.0; requirement(&machine, tables)].leak();
        let built = Compensation::<f64, f64, 3>::build(&machine, tables, &[], 4, memory).unwrap();
        for (x, negative) in [(-31.3, false), (17.77, true)] {
            let at = built.coordinates(&[x, 1.0, 2.0]);
            let (directions, thermal) = ([Direction::of(negative); 3], [ThermalLine::default(); 3]);
            let query = Query::at(&at, &directions, &thermal);
            let (errors, pose) = (built.errors(&query, &mut 0), built.pose_error(&query, &mut 0));
            assert!((errors[0] - pose.tip.x).abs() < 1e-15 && pose.tip.y == 0.0, "{model:?}: {errors:?}, {pose:?}");
            assert!((errors[0] - of_x(x, negative)).abs() < 1e-7, "{model:?}: {errors:?}");
            let correction = built.correction(&query, &mut 0)[0];
            assert!((correction - inverse(|q| of_x(q, negative), x)).abs() < 1e-6, "{model:?}: {correction}");
        }
    }
}
