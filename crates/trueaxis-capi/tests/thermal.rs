//! Thermal growth through the C interface: built, refused, updated, and applied by the step.

use crate::machines::*;
use std::ptr::null_mut;
use trueaxis::temperature::{MAGIC, VERSION};
use trueaxis_capi::*;

/// CRC-32/ISO-HDLC, bit by bit.
fn checksum(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
    })
}

/// One sensor without lag, 20 to 30 °C: 10 µm and 20 µm/m on X; −5 µm on Z.
fn file(machine: u32) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(machine.to_le_bytes());
    bytes.extend([1, 2, 0, 0]);
    bytes.extend(0_u32.to_le_bytes());
    for number in [0, -20_000, 90_000, 2_000, 1_000, 0, 0] {
        bytes.extend(i32::to_le_bytes(number));
    }
    bytes.push(2);
    bytes.extend(20_000_i32.to_le_bytes());
    bytes.extend(30_000_i32.to_le_bytes());
    for (axis, offset, slope) in [(0, 10_000, 20_000_000), (2, -5_000, 0)] {
        bytes.push(axis);
        bytes.extend(0_i64.to_le_bytes());
        for number in [0, 0, offset, slope] {
            bytes.extend(i32::to_le_bytes(number));
        }
    }
    bytes.extend(checksum(&bytes).to_le_bytes());
    bytes
}

fn read_in(file: &[u8], machine: u32) -> Result<Box<Thermal>, (ResultCode, u32, String)> {
    let (mut thermal, mut error, mut sensors) = (zeroed::<Thermal>(), error(), 99_u32);
    let size = size_of::<Thermal>();
    // SAFETY: all pointers and sizes match their types; the files of these tests outlive the objects that read them.
    let result = unsafe {
        trueaxis_thermal_build(&mut *thermal, size, file.as_ptr(), file.len(), machine, &mut sensors, &mut error)
    };
    if result == OK {
        assert_eq!(sensors, 1);
        return Ok(thermal);
    }
    assert_eq!((error.result, sensors), (result, 99));
    Err((result, error.code, text(&error.text)))
}

fn task() -> Box<ThermalTask> {
    let mut task = zeroed::<ThermalTask>();
    // SAFETY: all pointers and sizes match their types.
    assert_eq!(unsafe { trueaxis_thermal_start(&mut *task, size_of::<ThermalTask>()) }, OK);
    task
}

fn readings(dt_s: f64, temperature_c: f64) -> ThermalReadings {
    let mut temperatures_c = [f64::NAN; THERMAL_SENSORS_MAX];
    temperatures_c[0] = temperature_c;
    let size = size_of::<ThermalReadings>() as u32;
    ThermalReadings { size, count: 1, dt_s, temperatures_c, spindle_rpm: 0.0, tool_mm: 0.0 }
}

fn updated(thermal: &Thermal, task: &mut ThermalTask, readings: &ThermalReadings) -> Growth {
    let mut growth = *zeroed::<Growth>();
    growth.size = size_of::<Growth>() as u32;
    // SAFETY: all pointers and sizes match their types.
    assert_eq!(unsafe { trueaxis_thermal_update(thermal, task, readings, &mut growth) }, OK);
    growth
}

/// Growth after the start of a sensor that reads `temperature_c`.
fn begun(thermal: &Thermal, task: &mut ThermalTask, temperature_c: f64) -> Growth {
    for status in [SENSOR_STARTING; 2] {
        let growth = updated(thermal, task, &readings(1.0, temperature_c));
        assert_eq!((growth.sensors[0], growth.complete, growth.good, growth.offset), (status, 0, 0, [0.0; 6]));
    }
    updated(thermal, task, &readings(1.0, temperature_c))
}

#[test]
fn growth_follows_the_sensor_and_stays_constant_without_it() {
    let file = file(7);
    let thermal = read_in(&file, 7).unwrap();
    let mut task = task();
    let warm = begun(&thermal, &mut task, 25.0);
    assert_eq!((warm.axes, warm.good, warm.complete, warm.sensors[0]), (0b101, 1, 1, SENSOR_GOOD));
    assert!((warm.offset[0] - 0.005).abs() < 1e-12 && (warm.slope[0] - 1e-5).abs() < 1e-15);
    assert!((warm.offset[2] + 0.0025).abs() < 1e-12 && warm.offset[1] == 0.0);
    let lost = updated(&thermal, &mut task, &readings(60.0, f64::NAN));
    assert_eq!((lost.good, lost.sensors[0], lost.offset), (0, SENSOR_MISSING, warm.offset));
    let jumped = updated(&thermal, &mut task, &readings(60.0, 60.0));
    assert_eq!((jumped.sensors[0], jumped.offset), (SENSOR_JUMPED, warm.offset));
    // SAFETY: all pointers and sizes match their types.
    unsafe {
        assert_eq!(trueaxis_thermal_believe(&mut *task, 0), OK);
        assert_eq!(trueaxis_thermal_believe(&mut *task, 16), ERROR_ARGUMENT);
    }
    let accepted = updated(&thermal, &mut task, &readings(60.0, 60.0));
    assert_eq!((accepted.sensors[0], accepted.at_edge), (SENSOR_GOOD, 1));
}

#[test]
fn damage_and_other_machines_are_refused_with_a_code() {
    let good = file(7);
    let (result, code, text) = read_in(&good, 8).unwrap_err();
    assert_eq!((result, code), (ERROR_MACHINE, 15));
    assert_eq!(text, "thermal growth: found on the machine 00000007, needed 00000008");
    read_in(&good, 0).expect("any machine");
    for k in 0..good.len() {
        let mut bad = good.clone();
        bad[k] ^= 0x10;
        let (result, code, _) = read_in(&bad, 7).unwrap_err();
        assert!(result == ERROR_THERMAL && (1..=14).contains(&code), "byte {k}");
    }
    let (mut growth, readings) = (*zeroed::<Growth>(), readings(1.0, 25.0));
    growth.size = size_of::<Growth>() as u32;
    let (unbuilt, mut empty) = (zeroed::<Thermal>(), zeroed::<ThermalTask>());
    let thermal = read_in(&good, 7).unwrap();
    // SAFETY: all pointers and sizes match their types.
    unsafe {
        assert_eq!(trueaxis_thermal_update(&*unbuilt, &mut *empty, &readings, &mut growth), ERROR_UNBUILT);
        assert_eq!(trueaxis_thermal_update(&*thermal, &mut *empty, &readings, &mut growth), ERROR_UNBUILT);
        assert_eq!(trueaxis_thermal_start(&mut *empty, 8), ERROR_SIZE);
        assert_eq!(trueaxis_thermal_start(null_mut(), 8), ERROR_NULL);
        let mut task = task();
        let many = ThermalReadings { count: 17, ..readings };
        assert_eq!(trueaxis_thermal_update(&*thermal, &mut *task, &many, &mut growth), ERROR_ARGUMENT);
        growth.size += 8;
        assert_eq!(trueaxis_thermal_update(&*thermal, &mut *task, &readings, &mut growth), ERROR_SIZE);
    }
}

#[test]
fn growth_is_ramped_in_by_the_limiter_of_the_step() {
    // One direction only: a correction that is being applied may end on the other side of a backlash.
    let machine = small();
    let tables = trueaxis_tables::compile(&machine).unwrap();
    let servo = built(&tables);
    let mut state = started(&servo.servo);
    let at = [100.0, 0.0, -200.0, 0.0, 0.0, 0.0];
    let mut out = output();
    // Returns the last correction of X, its largest change from cycle to cycle, and the largest change of that change.
    let mut cycles = |state: &mut State, count: usize| {
        let found: Vec<f64> = (0..count)
            .map(|_| {
                // SAFETY: all pointers and sizes match their types.
                let result = unsafe {
                    trueaxis_step(&*servo.servo, &mut *state, &input(at, at), null_mut(), null_mut(), &mut out)
                };
                assert_eq!(result, OK);
                let [x, ..] = out.record.correction.map(f64::from);
                x
            })
            .collect();
        let changes = |of: &[f64]| of.windows(2).map(|two| two[1] - two[0]).collect::<Vec<f64>>();
        let largest = |of: &[f64]| of.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
        let rates = changes(&found);
        (*found.last().unwrap(), [largest(&rates), largest(&changes(&rates))])
    };
    let many = if cfg!(miri) { 20 } else { 4000 };
    let (cold, _) = cycles(&mut state, many);
    let file = file(7);
    let thermal = read_in(&file, 0).unwrap();
    let growth = begun(&thermal, &mut task(), 30.0);
    // SAFETY: all pointers and sizes match their types.
    unsafe {
        assert_eq!(trueaxis_set_growth(&*servo.servo, &mut *state, &growth), OK);
        let steep = Growth { slope: [0.1; 6], ..growth };
        assert_eq!(trueaxis_set_growth(&*servo.servo, &mut *state, &steep), ERROR_ARGUMENT);
        assert_eq!(trueaxis_set_growth(&*servo.servo, &mut *state, &Growth { size: 8, ..growth }), ERROR_SIZE);
    }
    let (warm, largest) = cycles(&mut state, many);
    if !cfg!(miri) {
        let x = &machine.settings.axes[0];
        // 10 µm, and 20 µm/m from the machine's datum; the inverse evaluates the error at the corrected position.
        let growth = 0.01 + 2e-5 * (at[0] - x.thermal.datum);
        assert!((warm - cold + growth).abs() < 1e-5, "{cold} to {warm} for {growth}");
        let period_s = 1e-9 * f64::from(PERIOD_NS);
        let most = [x.limits.slope_per_s * period_s, x.limits.acceleration_per_s2 * period_s * period_s];
        // The tolerance covers the rounding of a difference in single precision.
        assert!(largest.iter().zip(most).all(|(found, most)| *found <= most + 1e-8), "{largest:?} of {most:?}");
    }
}
