#![allow(clippy::indexing_slicing)]

use super::*;
use crate::axis::Axis;
use crate::tcomp::checksum;
use std::vec::Vec;
use std::{format, vec};

/// A sensor with a lag, s, and knots, °C; 2 K at once and 1 K per minute are plausible; stuck after 600 s if the others
/// moved 3 K.
struct Sensor<'k>(f64, &'k [f64]);

const CURVE: &[f64] = &[10.0, 20.0, 40.0];

fn mk(values: &[f64], bytes: &mut Vec<u8>) {
    for value in values {
        bytes.extend(((value * 1e3).round() as i32).to_le_bytes());
    }
}

/// Offset and slope at every knot of every sensor, µm and µm/m; growth and tilt at the speeds, µm and µrad.
struct OfAxis<'k>(Axis, &'k [[f64; 2]], &'k [[f64; 2]]);

fn file(sensors: &[Sensor<'_>], spindle: (f64, &[u32]), axes: &[OfAxis<'_>]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(0x1234_u32.to_le_bytes());
    bytes.extend([sensors.len() as u8, axes.len() as u8, spindle.1.len() as u8, 0]);
    bytes.extend(((1e3 * spindle.0) as u32).to_le_bytes());
    spindle.1.iter().for_each(|speed| bytes.extend(speed.to_le_bytes()));
    for Sensor(lag, knots) in sensors {
        bytes.extend(((1e3 * lag) as u32).to_le_bytes());
        mk(&[-20.0, 90.0, 2.0, 1.0], &mut bytes);
        bytes.extend(600_000_u32.to_le_bytes());
        mk(&[3.0], &mut bytes);
        bytes.push(knots.len() as u8);
        mk(knots, &mut bytes);
    }
    for OfAxis(axis, curves, speeds) in axes {
        bytes.push(*axis as u8);
        bytes.extend(50_000_000_i64.to_le_bytes());
        for [offset, slope] in *curves {
            bytes.extend(((offset * 1e3).round() as i32).to_le_bytes());
            bytes.extend(((slope * 1e6).round() as i32).to_le_bytes());
        }
        for [growth, tilt] in *speeds {
            bytes.extend(((growth * 1e3).round() as i32).to_le_bytes());
            bytes.extend(((tilt * 1e3).round() as i32).to_le_bytes());
        }
    }
    bytes.extend(checksum(&bytes).to_le_bytes());
    bytes
}

/// Two sensors, a spindle, X and Z.
fn whole() -> Vec<u8> {
    let x = OfAxis(
        Axis::X,
        &[[-10.0, -100.0], [0.0, 0.0], [10.0, 400.0], [0.0, 0.0], [4.0, 0.0]],
        &[[0.0, 0.0], [0.0, 20.0], [0.0, 50.0]],
    );
    let z = OfAxis(Axis::Z, &[[0.0, 0.0]; 5], &[[0.0, 0.0], [5.0, 0.0], [20.0, 0.0]]);
    file(&[Sensor(0.0, CURVE), Sensor(1200.0, &[20.0, 30.0])], (900.0, &[0, 6000, 12_000]), &[x, z])
}

fn at<'r>(temperatures_c: &'r [Option<f64>], rpm: f64) -> Readings<'r> {
    Readings { temperatures_c, spindle_rpm: Some(rpm), tool_mm: 100.0 }
}

/// A task whose sensors are accepted from their first reading on.
fn started() -> ThermalState {
    let mut state = ThermalState::new();
    (0..SENSORS).for_each(|sensor| state.accept(sensor));
    state
}

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} for {expected}");
}

/// Closed solutions of x' = (u − x)/τ, with the host's exponential.
#[test]
fn a_lag_is_exact_for_steps_and_ramps_however_the_time_is_divided() {
    let lag = 840.0;
    for parts in [1_u32, 7, 600] {
        let dt = 600.0 / f64::from(parts);
        let decay = Decay::new(dt, lag);
        // Input 5 from the start, with an initial output of 2.
        let held = (0..parts).fold(2.0, |x, _| decay.respond(x, 5.0, 5.0));
        near(held, 5.0 - 3.0 * (-600.0 / lag).exp(), 1e-13);
        // u = 1 + r t, x(0) = 2: x = u − rτ + (1 + rτ) exp(−t/τ).
        let rate = 0.03;
        let ramp = (0..parts).fold(2.0, |x, k| {
            let u = |k: u32| 1.0 + rate * dt * f64::from(k);
            decay.respond(x, u(k), u(k + 1))
        });
        near(ramp, 1.0 + rate * 600.0 - rate * lag + (1.0 + rate * lag) * (-600.0 / lag).exp(), 1e-11);
    }
    // Without a lag, for zero time, and for the shortest and longest times.
    near(Decay::new(1.0, 0.0).respond(3.0, 4.0, 5.0), 5.0, 0.0);
    near(Decay::new(0.0, 10.0).respond(3.0, 4.0, 5.0), 3.0, 1e-15);
    near(Decay::new(1e-9, 1e6).respond(3.0, 4.0, 4.0), 3.0, 1e-13);
    near(Decay::new(1e9, 1e-3).respond(3.0, 4.0, 5.0), 5.0, 1e-9);
}

#[test]
fn places_on_a_curve_are_between_its_knots_and_at_its_ends() {
    let place = |value: f64| super::place(CURVE.iter().copied(), value);
    assert_eq!(place(15.0), (0, 0.5, false));
    assert_eq!(place(20.0), (1, 0.0, false));
    assert_eq!(place(25.0), (1, 0.25, false));
    assert_eq!(place(10.0), (0, 0.0, false));
    assert_eq!(place(40.0), (1, 1.0, false));
    assert_eq!(place(9.0), (0, 0.0, true));
    assert_eq!(place(41.0), (1, 1.0, true));
    assert_eq!(place(f64::NAN), (0, 0.0, true));
}

#[test]
fn growth_is_the_sum_of_the_curves_and_of_the_spindle() {
    let bytes = whole();
    let thermal = Thermal::parse(&bytes).unwrap();
    assert_eq!((thermal.sensors(), thermal.has_spindle(), thermal.machine_id()), (2, true, 0x1234));
    assert_eq!(thermal.axes().collect::<Vec<_>>(), [(Axis::X, 50.0), (Axis::Z, 50.0)]);
    let mut state = started();
    let start = thermal.update(&mut state, 1.0, &at(&[Some(20.0), Some(20.0)], 0.0));
    assert_eq!(start.lines[0], Some([0.0, 0.0]));
    assert!(start.is_good() && start.lines[1].is_none() && start.line::<f64>(Axis::Y).is_none());

    // 2.5 K on the first; the second, behind its lag, follows a ramp to 21 °C over 5 min and stays there for 20 min.
    let warm = [Some(22.5), Some(21.0)];
    thermal.update(&mut state, 300.0, &at(&warm, 0.0));
    let growth = thermal.update(&mut state, 1200.0, &at(&warm, 0.0));
    let (lag, ramp) = (1200.0_f64, 300.0_f64);
    let behind = 1.0 - (lag / ramp) * (1.0 - (-ramp / lag).exp());
    let second = 1.0 - (1.0 - behind) * (-1.0_f64).exp();
    let [offset, slope] = growth.lines[0].unwrap();
    near(offset, 1e-3 * (1.25 + 0.4 * second), 1e-12);
    near(slope, 1e-6 * 50.0, 1e-18);

    // 9,000 rpm suddenly, within 1 µs: halfway between the knots; after one time constant 63.2 % of it.
    thermal.update(&mut state, 1e-6, &at(&warm, -9000.0));
    let growth = thermal.update(&mut state, 900.0, &at(&warm, 9000.0));
    let response = 1.0 - (-1.0_f64).exp();
    near(growth.lines[2].unwrap()[0], 1e-3 * 12.5 * response, 1e-9);
    // 35 µrad on a tool of 100 mm give 3.5 µm.
    let second = 1.0 - (1.0 - second) * (-900.0 / lag).exp();
    near(growth.lines[0].unwrap()[0], 1e-3 * (1.25 + 0.4 * second + 3.5 * response), 1e-9);
}

#[test]
fn one_sensor_without_lag_and_a_straight_curve_is_the_growth_of_machine_toml() {
    let growth = crate::machine::ThermalGrowth { offset_per_k: 2e-3, expansion_per_k: 11e-6, datum: 50.0 };
    let curve = [[-40.0, -220.0], [80.0, 440.0]];
    let bytes = file(&[Sensor(0.0, &[0.0, 60.0])], (0.0, &[]), &[OfAxis(Axis::X, &curve, &[])]);
    let thermal = Thermal::parse(&bytes).unwrap();
    for temperature in [7.5, 20.0, 31.0] {
        let readings = Readings { temperatures_c: &[Some(temperature)], spindle_rpm: None, tool_mm: 0.0 };
        let found = thermal.update(&mut started(), 1.0, &readings).line::<f64>(Axis::X).unwrap();
        let line = crate::compensation::ThermalLine::<f64>::for_axis(&growth, temperature - 20.0).unwrap();
        for from_datum in [-300.0, 0.0, 450.0] {
            near(found.at(from_datum), line.at(from_datum), 1e-12);
        }
    }
}

/// Warm, then wrong: the status reported, and that only the share of the other sensor changes.
fn wrong(readings: &[Option<f64>], expected: SensorStatus) {
    let bytes = whole();
    let thermal = Thermal::parse(&bytes).unwrap();
    let mut state = started();
    let before = thermal.update(&mut state, 1.0, &at(&[Some(25.0), Some(22.0)], 0.0)).lines[0].unwrap();
    for (k, reading) in readings.iter().enumerate() {
        let growth = thermal.update(&mut state, 60.0, &at(&[*reading, Some(22.0)], 0.0));
        assert_eq!(growth.sensors[0], expected, "reading {k}: {reading:?}");
        assert!(!growth.is_good() && growth.sensors[1] == SensorStatus::Good);
        assert_eq!(growth.lines[0].unwrap(), before, "reading {k}");
    }
}

#[test]
fn a_missing_out_of_range_or_jumping_sensor_freezes_its_share_and_is_reported() {
    wrong(&[None, None, Some(f64::NAN), Some(f64::INFINITY)], SensorStatus::Missing);
    wrong(&[Some(-21.0), Some(90.5), Some(1e300)], SensorStatus::OutOfRange);
    // 2 K at once and 1 K for the minute.
    wrong(&[Some(28.1), Some(31.0), Some(21.9)], SensorStatus::Jumped);
    // A sensor that has come off reads the air for hours.
    wrong(&[Some(19.0); 300], SensorStatus::Jumped);
}

/// Status of the first sensor and offset of X after each reading, a minute apart, the second sensor at 20 °C, from a new
/// state.
fn from_nothing(first: impl IntoIterator<Item = f64>) -> Vec<(SensorStatus, f64)> {
    let bytes = whole();
    let thermal = Thermal::parse(&bytes).unwrap();
    let mut state = ThermalState::new();
    let update = |reading| {
        let growth = thermal.update(&mut state, 60.0, &at(&[Some(reading), Some(20.0)], 0.0));
        assert_eq!(growth.is_good(), growth.sensors.iter().all(|status| *status == SensorStatus::Good));
        (growth.sensors[0], 1e3 * growth.lines[0].unwrap()[0])
    };
    first.into_iter().map(update).collect()
}

/// Only the statuses.
fn statuses(found: &[(SensorStatus, f64)]) -> Vec<SensorStatus> {
    found.iter().map(|(status, _)| *status).collect()
}

#[test]
fn a_sensor_starts_with_three_readings_that_agree_over_two_seconds() {
    use SensorStatus::{Good, OutOfRange, Starting};
    // 0.5 µm per kelvin above 20 °C.
    let found = from_nothing([24.0, 24.1, 24.2, 24.4]);
    assert_eq!(statuses(&found), [Starting, Starting, Good, Good]);
    assert_eq!(found[1].1, 0.0);
    near(found[2].1, 2.1, 1e-12);
    // A first reading far off, even a plausible one, is rejected, and does not block the true ones.
    assert_eq!(statuses(&from_nothing([60.0, 24.0, 24.1, 24.2])), [Starting, Starting, Starting, Good]);
    for failure in [85.0, 0.0, -0.0, -127.0] {
        let found = from_nothing([failure, failure, failure, failure, 24.0, 24.0, 24.0]);
        assert_eq!(statuses(&found), [OutOfRange, OutOfRange, OutOfRange, OutOfRange, Starting, Starting, Good]);
        assert!(found.iter().take(6).all(|(_, um)| *um == 0.0) && found[6].1 == 2.0, "{failure}: {found:?}");
    }
    // A sensor that reads only the value of an unwritten input never starts; on a winter's morning it does.
    assert!(statuses(&from_nothing([0.0; 500])).iter().all(|status| *status == OutOfRange));
    assert_eq!(statuses(&from_nothing([-0.5, -0.2, -0.1, 0.0, 0.1])), [Starting, Starting, Good, Good, Good]);
    // Updates from a servo thread: no start in the first three milliseconds.
    let bytes = whole();
    let thermal = Thermal::parse(&bytes).unwrap();
    let mut state = ThermalState::new();
    let updates = |state: &mut ThermalState, seconds| {
        thermal.update(state, seconds, &at(&[Some(24.0), Some(20.0)], 0.0)).is_good()
    };
    assert!((0..2000).all(|_| !updates(&mut state, 1e-3)) && (0..1500).any(|_| updates(&mut state, 1e-3)));
    // Updates without elapsed time do not start a sensor.
    let mut state = ThermalState::new();
    assert!((0..100).all(|_| !updates(&mut state, 0.0)));
}

#[test]
fn a_step_that_stays_is_accepted_after_an_hour_if_it_lives() {
    use SensorStatus::{Good, Jumped, OutOfRange};
    let start = [25.0, 25.0, 25.0];
    let stays = |k: u32| 35.0 + 0.1 * f64::from(k % 2);
    let found = from_nothing(start.into_iter().chain((0..62).map(stays)));
    assert!(statuses(&found[3..63]).iter().all(|status| *status == Jumped));
    assert_eq!(statuses(&found[63..]), [Good, Good]);
    assert_eq!(found[62].1, 2.5);
    near(found[63].1, 7.5, 0.06);
    // One reading elsewhere, or none, restarts the hour.
    for other in [60.0, f64::NAN, 85.0] {
        let twice = |k: u32| if k == 40 { other } else { stays(k) };
        let found = from_nothing(start.into_iter().chain((0..110).map(twice)));
        let good = statuses(&found[3..]).iter().position(|status| *status == Good);
        assert_eq!(good, Some(101), "{other}");
    }
    // Bitwise equal readings: a dead input, rejected permanently. A failure value is not a step.
    let dead = from_nothing(start.into_iter().chain([35.0; 300]));
    assert!(statuses(&dead[3..]).iter().all(|status| *status == Jumped));
    let failed = from_nothing(start.into_iter().chain([85.0; 90]).chain([25.5]));
    assert!(statuses(&failed[3..93]).iter().all(|status| *status == OutOfRange) && failed[93].0 == Good);
}

#[test]
fn a_returning_sensor_is_trusted_again_and_a_missing_one_may_have_moved() {
    let bytes = whole();
    let thermal = Thermal::parse(&bytes).unwrap();
    let mut state = started();
    let mut first = |reading, seconds| {
        let growth = thermal.update(&mut state, seconds, &at(&[reading, Some(22.0)], 0.0));
        (growth.sensors[0], growth.lines[0].unwrap()[0])
    };
    let still = first(Some(25.0), 1.0).1;
    assert_eq!(first(Some(40.0), 60.0), (SensorStatus::Jumped, still));
    assert_eq!(first(Some(26.9), 60.0).0, SensorStatus::Good, "within 2 K of the last good one");
    assert_eq!(first(None, 600.0).0, SensorStatus::Missing);
    assert_eq!(first(Some(38.0), 1.0).0, SensorStatus::Good, "10 K in ten minutes, and 2");
    assert_eq!(first(Some(25.0), 1.0).0, SensorStatus::Jumped);
    assert_eq!(first(Some(25.0), 1e4).0, SensorStatus::Jumped, "time does not make a jump plausible");
    state.accept(0);
    let growth = thermal.update(&mut state, 1.0, &at(&[Some(25.0), Some(22.0)], 0.0));
    assert_eq!((growth.sensors[0], growth.lines[0].unwrap()[0]), (SensorStatus::Good, still));
}

#[test]
fn a_stuck_sensor_is_one_that_repeats_itself_while_the_others_move() {
    let bytes = whole();
    let thermal = Thermal::parse(&bytes).unwrap();
    let run = |other: fn(f64) -> f64| {
        let mut state = started();
        (0..40)
            .map(|k| thermal.update(&mut state, 60.0, &at(&[Some(25.0), Some(other(f64::from(k)))], 0.0)))
            .collect::<Vec<_>>()
    };
    // At rest for 40 minutes with two quantised sensors: no defect.
    assert!(run(|_| 22.0).iter().all(|growth| growth.sensors[0] == SensorStatus::Good));
    // A quarter kelvin per minute: 3 K after 12 minutes.
    let stuck = run(|minutes| 22.0 + 0.25 * minutes);
    let first = stuck.iter().position(|growth| growth.sensors[0] == SensorStatus::Stuck);
    assert_eq!(first, Some(13), "the others as they were at the update before");
    assert!(stuck.iter().all(|growth| growth.sensors[1] == SensorStatus::Good));
}

#[test]
fn a_missing_speed_holds_the_spindles_share_and_too_much_growth_the_line() {
    let bytes = whole();
    let thermal = Thermal::parse(&bytes).unwrap();
    let mut state = started();
    let temperatures = [Some(20.0), Some(20.0)];
    thermal.update(&mut state, 1.0, &at(&temperatures, 12_000.0));
    let warm = thermal.update(&mut state, 900.0, &at(&temperatures, 12_000.0)).lines[2];
    let blind = Readings { spindle_rpm: None, ..at(&temperatures, 0.0) };
    let growth = thermal.update(&mut state, 900.0, &blind);
    assert!(growth.spindle_missing && !growth.is_good() && growth.lines[2] == warm);

    let curve = [[0.0, 0.0], [2000.0, 999.0]];
    let steep = OfAxis(Axis::X, &[curve[0], curve[1], curve[0], curve[1]], &[]);
    let bytes = file(&[Sensor(0.0, &[20.0, 21.0]), Sensor(0.0, &[20.0, 21.0])], (0.0, &[]), &[steep]);
    let thermal = Thermal::parse(&bytes).unwrap();
    let mut state = started();
    let taken = thermal.update(&mut state, 1.0, &at(&[Some(20.5), Some(20.0)], 0.0));
    let beyond = thermal.update(&mut state, 60.0, &at(&[Some(21.0), Some(21.0)], 0.0));
    assert!(taken.is_good() && beyond.beyond == 1 && beyond.lines == taken.lines);
}

#[test]
fn nothing_grows_before_every_sensor_was_read() {
    let bytes = whole();
    let thermal = Thermal::parse(&bytes).unwrap();
    let mut state = started();
    let growth = thermal.update(&mut state, 1.0, &at(&[Some(30.0)], 0.0));
    assert!(!growth.complete && growth.lines[0] == Some([0.0; 2]) && growth.sensors[1] == SensorStatus::Missing);
    let growth = thermal.update(&mut state, 1.0, &at(&[Some(30.0), Some(24.0)], 0.0));
    near(growth.lines[0].unwrap()[0], 1e-3 * (5.0 + 1.6), 1e-12);
}

#[test]
fn beyond_its_curve_the_edge_holds_and_times_that_are_none_change_nothing() {
    let bytes = whole();
    let thermal = Thermal::parse(&bytes).unwrap();
    let mut state = started();
    let growth = thermal.update(&mut state, 1.0, &at(&[Some(60.0), Some(20.0)], 0.0));
    assert_eq!((growth.at_edge, growth.lines[0].unwrap()[0]), (1, 0.01));
    for time in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
        let again = thermal.update(&mut state, time, &at(&[Some(60.0), Some(21.0)], 12_000.0));
        near(again.lines[0].unwrap()[0], 0.01, 1e-15);
    }
    let restarted = thermal.update(&mut state, 2.0 * LONGEST_UPDATE_S, &at(&[Some(20.0), Some(30.0)], 0.0));
    assert!(!restarted.complete && restarted.lines[0] == Some([0.0; 2]), "all of it has to start again");
    let [_, restarted] = [0, 1].map(|_| thermal.update(&mut state, 60.0, &at(&[Some(20.0), Some(30.0)], 0.0)));
    near(restarted.lines[0].unwrap()[0], 0.004, 1e-15);
}

#[test]
fn every_damaged_byte_and_every_length_is_refused() {
    let bytes = whole();
    for k in 0..bytes.len() {
        for bit in 0..8 {
            let mut damaged = bytes.clone();
            damaged[k] ^= 1 << bit;
            assert!(Thermal::parse(&damaged).is_err(), "byte {k}, bit {bit}");
        }
        assert!(Thermal::parse(&bytes[..k]).is_err(), "{k} bytes");
    }
}

/// The file with `put` written over its bytes from `k` on, and a matching checksum.
fn altered(k: usize, put: &[u8]) -> ThermalError {
    let mut bytes = whole();
    bytes.truncate(bytes.len() - 4);
    bytes[k..k + put.len()].copy_from_slice(put);
    bytes.extend(checksum(&bytes).to_le_bytes());
    Thermal::parse(&bytes).unwrap_err()
}

#[test]
fn nonsense_with_a_good_sum_is_refused_with_its_figure() {
    assert_eq!(altered(0, b"X"), ThermalError::Magic);
    assert_eq!(altered(8, &[2]), ThermalError::Version);
    assert_eq!(altered(14, &[17]), ThermalError::Sensors(17));
    assert_eq!(altered(15, &[0]), ThermalError::Axes(0));
    assert_eq!(altered(16, &[1]), ThermalError::Knots(1));
    assert_eq!(altered(17, &[3]), ThermalError::NotZero(3));
    assert_eq!(altered(18, &[0, 0, 0, 255]), ThermalError::Time(0xff00_0000));
    assert_eq!(altered(22, &[1]), ThermalError::KnotOrder(1), "not from rest");
    assert_eq!(altered(26, &[0; 4]), ThermalError::KnotOrder(0));
    // The first sensor, from 34 on.
    assert_eq!(altered(38, &100_000_i32.to_le_bytes()), ThermalError::Plausible(1));
    assert_eq!(altered(46, &[0; 4]), ThermalError::Plausible(1));
    assert_eq!(altered(62, &[9]), ThermalError::Knots(9));
    assert_eq!(altered(67, &10_000_i32.to_le_bytes()), ThermalError::KnotOrder(10_000));
    // The axes after the second, 75 to 111.
    assert_eq!(altered(112, &[6]), ThermalError::Axis(6));
    assert_eq!(altered(112, &[2]), ThermalError::Axis(2), "doubled");
    assert_eq!(altered(125, &i32::MIN.to_le_bytes()), ThermalError::Slope(i32::MIN));
    assert_eq!(altered(161, &[7, 0, 0, 0]), ThermalError::NotZero(7), "growth at rest");
    let mut long = whole();
    long.truncate(long.len() - 4);
    long.push(0);
    long.extend(checksum(&long).to_le_bytes());
    assert_eq!(Thermal::parse(&long).unwrap_err(), ThermalError::TooLong);
    let bytes = whole();
    let thermal = Thermal::parse(&bytes).unwrap();
    assert_eq!(thermal.expect_machine(0x1234), Ok(()));
    let other = thermal.expect_machine(1).unwrap_err();
    assert_eq!(format!("{other}"), "found on the machine 00001234, needed 00000001");
}

#[test]
fn every_refusal_has_a_code_and_words_of_its_own() {
    let all = vec![
        ThermalError::TooShort,
        ThermalError::TooLong,
        ThermalError::Magic,
        ThermalError::Version,
        ThermalError::Checksum,
        ThermalError::Sensors(17),
        ThermalError::Axes(0),
        ThermalError::Knots(1),
        ThermalError::KnotOrder(1),
        ThermalError::Time(u32::MAX),
        ThermalError::Plausible(1),
        ThermalError::Axis(6),
        ThermalError::NotZero(1),
        ThermalError::Slope(1),
        ThermalError::WrongMachine { found: 1, needed: 2 },
    ];
    for (k, error) in all.iter().enumerate() {
        assert_eq!(usize::from(error.code()), k + 1);
        assert!(all.iter().take(k).all(|other| format!("{other}") != format!("{error}")), "{error}");
    }
}
