//! The common part of the lag gives way to a limit on all axes at once, along the path.

use super::dynamic::DRIVE;
use super::*;
use crate::dynamic::DynamicParts;
use crate::machine::{AxisServo, DriveFigures, DynamicSettings, Limits};

const TOP_SPEED: f64 = 400.0;

fn limits(magnitude: f64) -> Limits {
    Limits { magnitude, slope_per_s: 5.0, acceleration_per_s2: 5000.0 }
}

/// A machine with these drives on X, Y and Z, that compensates lag and acceleration.
fn machine_with(drives: [DriveFigures; 3], magnitude: f64) -> &'static Loop {
    machine_of(drives.map(Some), magnitude)
}

fn machine_of(drives: [Option<DriveFigures>; 3], magnitude: f64) -> &'static Loop {
    let mut machine = machine(|axis| {
        axis.max_feed_per_s = TOP_SPEED;
        axis.limits = Limits { magnitude: 2.0, slope_per_s: 100.0, acceleration_per_s2: 5e4 };
        axis.joint = [-50.0, 150.0];
    });
    for (axis, drive) in machine.axes.iter_mut().zip(drives) {
        let own = DynamicSettings::with_defaults(axis.axis);
        let dynamic =
            DynamicSettings { limits: limits(magnitude), lag: drive.is_some(), acceleration: drive.is_some(), ..own };
        axis.servo = AxisServo { drive, friction: None, dynamic: Some(dynamic) };
    }
    loop_of(0.0, machine)
}

/// Distance along a line of `length` from rest to rest: up to `speed`, with this acceleration.
fn distance(t: f64, length: f64, speed: f64, acceleration: f64) -> f64 {
    let ramp = speed / acceleration;
    let end = length / speed + ramp;
    let from_start = |t: f64| if t < ramp { 0.5 * acceleration * t * t } else { speed * (t - 0.5 * ramp) };
    match t {
        _ if t >= end => length,
        _ if t > end - ramp => length - from_start(end - t),
        _ => from_start(t),
    }
}

/// Runs a line along `direction` (of length 1) to rest and 300 ms beyond; the record of every cycle.
fn line(servo: &'static Loop, direction: [f64; 3], speed: f64, acceleration: f64) -> Vec<(DynamicParts<f64, 3>, u8)> {
    let (mut state, mut cycles) = (servo.start(), Vec::new());
    let end = 80.0 / speed + speed / acceleration + 0.3;
    for k in 0..(end / T) as u32 {
        let way = distance(T * f64::from(k), 80.0, speed, acceleration);
        let out = servo.step(&mut state, &input(direction.map(|share| share * way)), (), ());
        assert_eq!(out.record.fault, crate::error::Fault::None, "cycle {k}");
        cycles.push((out.record.dynamic.unwrap(), out.record.limited));
    }
    cycles
}

/// Part of a vector along a direction, and the length of the rest.
fn split(vector: [f64; 3], direction: [f64; 3]) -> (f64, f64) {
    let along: f64 = (0..3).map(|k| vector[k] * direction[k]).sum();
    let across = (0..3).map(|k| (vector[k] - along * direction[k]).powi(2)).sum::<f64>().sqrt();
    (along, across)
}

const SLOPING: [f64; 3] = [0.8, 0.48, 0.36];

fn figures(velocity_feed_forward: f64) -> DriveFigures {
    DriveFigures { velocity_feed_forward, ..DRIVE }
}

#[test]
fn on_a_line_with_equal_drives_a_bound_correction_stays_parallel_to_the_path() {
    // Shares that are fed forward; speeds at which lag asks for up to 34 times the limit.
    for share in [0.9, 0.5, 0.0] {
        for speed in [20.0, 100.0, 167.0] {
            let servo = machine_with([figures(share); 3], 0.05);
            let cycles = line(servo, SLOPING, speed, 1500.0);
            let (mut largest, mut off): (f64, f64) = (0.0, 0.0);
            for (parts, _) in &cycles {
                assert!(split(parts.feed_forward, SLOPING).1 < 1e-10, "{share} {speed}: {parts:?}");
                let (along, across) = split(parts.sent, SLOPING);
                (largest, off) = (largest.max(along.abs()), off.max(across));
                assert!(parts.sent.iter().all(|d| d.abs() <= 0.05 * (1.0 + 1e-9)), "{parts:?}");
            }
            // While an axis brakes or starts, its limiter rounds the corner of d by itself, for some milliseconds. Without
            // velocity feed-forward d jumps with the acceleration.
            let most = if share == 0.0 { 15e-3 } else { 4e-3 };
            assert!(off < most, "{share} {speed}: {off}");
            let lag = (1.0 - share) * speed * SLOPING[0] / DRIVE.position_gain_per_s;
            if lag > 0.06 {
                assert!((largest - 0.05 / SLOPING[0]).abs() < 5e-3, "{share} {speed}: {largest}");
                // In the middle of the line nothing is limited: the feedback acts.
                assert_eq!(cycles[(40.0 / speed / T) as usize].1, 0, "{share} {speed}");
            }
        }
    }
}

#[test]
fn each_axis_keeps_the_difference_from_the_common_lag() {
    let drives = [100.0, 104.0, 98.0].map(|gain| DriveFigures { position_gain_per_s: gain, ..figures(0.5) });
    let servo = machine_with(drives, 0.1);
    let cycles = line(servo, SLOPING, 100.0, 1500.0);
    let sent = cycles[4000].0.sent;
    // Only a common time may be missing: d_i = L_i v_i − t v_i.
    let missing: Vec<f64> = (0..3).map(|k| drives[k].lag_s() - sent[k] / (100.0 * SLOPING[k])).collect();
    assert!(missing[0] > 1e-3, "{missing:?}");
    assert!(missing.iter().all(|time| (time - missing[0]).abs() < 1e-9), "{missing:?}");
    assert!((sent[0] - 0.1).abs() < 1e-9, "{sent:?}");
}

#[test]
fn without_a_limit_that_binds_every_bit_is_that_of_the_law() {
    let at = |magnitude| line(machine_with([figures(0.9); 3], magnitude), SLOPING, 40.0, 1000.0);
    let (narrow, wide) = (at(0.05), at(1.5));
    for (k, ((narrow, _), (wide, _))) in narrow.iter().zip(&wide).enumerate() {
        assert_eq!(narrow.feed_forward.map(f64::to_bits), wide.feed_forward.map(f64::to_bits), "cycle {k}");
    }
}

#[test]
fn an_axis_without_a_drive_after_an_exchange_keeps_nothing_of_the_lag_before() {
    let (before, after) = (machine_with([figures(0.5); 3], 0.05), machine_of([Some(figures(0.5)), None, None], 0.05));
    let mut state = before.start();
    for k in 0..700 {
        let way = distance(T * f64::from(k), 80.0, 100.0, 1500.0);
        let servo = if k < 400 { before } else { after };
        let out = servo.step(&mut state, &input(SLOPING.map(|share| share * way)), (), ());
        let parts = out.record.dynamic.unwrap();
        if (200..400).contains(&k) {
            assert!(parts.feed_forward[1] > 0.01 && parts.sent[0] > 0.049, "cycle {k}: {parts:?}");
        } else if k >= 400 {
            assert_eq!(parts.feed_forward[1..], [0.0; 2], "cycle {k}: {parts:?}");
            assert!(parts.sent[0] > 0.049, "cycle {k}: {parts:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: crate::testing::share::share(256) as u32, ..ProptestConfig::default() })]

    /// Whatever the drives and the motion, d keeps its limits in every cycle while λ sets in, changes and ends.
    #[test]
    fn nothing_jumps(
        shares in prop::array::uniform3(0.0..1.0_f64),
        gains in prop::array::uniform3(60.0..150.0_f64),
        speed in 5.0..200.0_f64,
        acceleration in 300.0..8000.0_f64,
        turned in 0.0..core::f64::consts::TAU,
    ) {
        let mut drives = [DRIVE; 3];
        for (k, drive) in drives.iter_mut().enumerate() {
            (drive.velocity_feed_forward, drive.position_gain_per_s) = (shares[k], gains[k]);
        }
        // Both ramps fit on the line.
        let speed = speed.min((30.0 * acceleration).sqrt());
        let servo = machine_with(drives, 0.05);
        let (mut state, mut before) = (servo.start(), [[0.0_f64; 3]; 2]);
        let end = 30.0 / speed + speed / acceleration + 0.02;
        // A corner without a stop where the line ends, and back.
        for k in 0..(2.0 * end / T) as u32 {
            let t = T * f64::from(k);
            let (out, back) = (distance(t, 30.0, speed, acceleration), distance(t - end, 30.0, speed, acceleration));
            let back = if t < end { 0.0 } else { back };
            let command = [out, back * turned.cos() + 50.0, back * turned.sin() + 50.0];
            let record = servo.step(&mut state, &input(command), (), ()).record;
            prop_assert_eq!(record.fault, crate::error::Fault::None);
            let sent = record.dynamic.unwrap().sent;
            for axis in 0..3 {
                let (now, [last, earlier]) = (sent[axis], [before[0][axis], before[1][axis]]);
                prop_assert!(now.abs() <= 0.05 * (1.0 + 1e-9));
                prop_assert!((now - last).abs() <= 5.0 * T * (1.0 + 1e-9));
                prop_assert!((now - 2.0 * last + earlier).abs() <= 5000.0 * T * T * (1.0 + 1e-6));
            }
            before = [sent, before[0]];
        }
    }
}
