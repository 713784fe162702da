//! The gauge of three probes through the C interface, against the Rust one.

#![allow(unsafe_code)]

mod machines;

use machines::*;
use std::f64::consts::TAU;
use std::ptr::{null, null_mut};
use std::sync::OnceLock;
use trueaxis::roundness::{self, Roundness};
use trueaxis::tcomp::Tcomp;
use trueaxis::telemetry::{ROUNDNESS_FRAME_BYTES, RoundnessFrame};
use trueaxis::{Config, GaugeRide, Position as _, ServoLoop};
use trueaxis_capi::*;

#[cfg(not(feature = "single"))]
type P = f64;
#[cfg(feature = "single")]
type P = trueaxis::Nanometres;

/// Counts of the spindle per revolution.
const COUNTS: i32 = 1 << 20;

/// A three-axis machine with a gauge at its side, 512 points.
fn small_gauge() -> &'static [u8] {
    static FILE: OnceLock<Vec<u8>> = OnceLock::new();
    FILE.get_or_init(|| machine(512))
}

/// A three-axis machine with a gauge at its side: no files are read, so that Miri can make it too.
fn machine(points: u16) -> Vec<u8> {
    let mut machine = machines::small();
    let slots = roundness::ProbeAngles::Slots { p: points * 44 / 256, q: points * 57 / 256 };
    let mut settings = roundness::RoundnessSettings::with_defaults(points, slots, COUNTS as u32);
    settings.band = roundness::Band { first: 2, last: 30 };
    settings.revolutions = 1;
    settings.units_per_cycle = 2;
    settings.infeed = Some(roundness::InfeedSettings {
        axis: trueaxis::Axis::X,
        direction: 1,
        band: roundness::Band { first: 2, last: 10 },
        gain: 0.25,
        delay_revolutions: 2,
        contact_deg: 180.0,
        drive_delay_s: 0.0,
        limit_um: 20.0,
        noise_gain_limit: 10.0,
    });
    machine.settings.roundness = Some(settings);
    trueaxis_tables::compile(&machine).unwrap()
}

struct Gauges {
    gauge: Box<Gauge>,
    state: Box<GaugeState>,
}

fn gauges(file: &[u8], state_size: usize) -> Gauges {
    let (mut gauge, mut state) = (zeroed::<Gauge>(), zeroed::<GaugeState>());
    // SAFETY: everything is as the types say.
    unsafe {
        let (bytes, length) = (file.as_ptr(), file.len());
        let status = trueaxis_gauge_build(&mut *gauge, size_of::<Gauge>(), bytes, length, PERIOD_NS, null_mut());
        assert_eq!(status, OK);
        assert_eq!(trueaxis_gauge_restart(&*gauge, &mut *state, state_size), OK);
    }
    Gauges { gauge, state }
}

fn probes(cycle: i32, points: i32) -> Probes {
    let step = COUNTS / points / 2;
    let spindle = cycle * step;
    let index = spindle - spindle.rem_euclid(COUNTS);
    let angle = TAU * f64::from(spindle) / f64::from(COUNTS);
    let reading = |phase: f64| (2.0 * (3.0 * (angle + phase)).cos() + 0.7 * (5.0 * (angle + phase)).sin()) as Real;
    Probes {
        size: size_of::<Probes>() as u32,
        spindle,
        index,
        arm: 0,
        readings: [reading(0.0), reading(TAU * 44.0 / 256.0), reading(TAU * 101.0 / 256.0)],
        has_index: u8::from(cycle > 0 && spindle - index < step),
        new_part: 0,
        idle: 0,
        reserved: [0; 5],
    }
}

fn evaluation() -> Evaluation {
    // SAFETY: numbers only.
    Evaluation { size: size_of::<Evaluation>() as u32, ..unsafe { std::mem::zeroed() } }
}

fn cycle_of() -> GaugeCycle {
    GaugeCycle { size: size_of::<GaugeCycle>() as u32, flags: 0, finished: 0, reserved: 0, infeed: 0.0 }
}

fn rust_loop(tables: &Tcomp<'_>) -> ServoLoop<'static, Real, P, 3> {
    let config = Config::of(tables, PERIOD_NS);
    let memory = vec![0.0; config.requirement(|axis| tables.table(axis))].leak();
    config.build(|axis| tables.table(axis), memory).unwrap()
}

fn compare<const N: usize>(state_size: usize, cycles: i32) {
    let file = &if N == 512 { small_gauge().to_vec() } else { machine(N as u16) }[..];
    let servo = built(file);
    let mut state = started(&servo.servo);
    let Gauges { gauge, state: mut gauge_state } = gauges(file, state_size);
    let tables = Tcomp::parse(file).unwrap();
    let core = rust_loop(&tables);
    let mut core_state = core.start();
    let core_gauge =
        Box::new(Roundness::<Real, N>::build(tables.settings().roundness.as_ref().unwrap(), PERIOD_NS).unwrap());
    let mut core_gauge_state = Box::new(core_gauge.start());

    let at = [10.0, 20.0, -200.0, 0.0, 0.0, 0.0];
    let (mut out, mut its, mut finished, mut fed) = (output(), cycle_of(), 0, false);
    for cycle in 0..cycles {
        let readings = probes(cycle, N as i32);
        // SAFETY: everything is as the types say.
        let status = unsafe {
            trueaxis_step_with_gauge(
                &*servo.servo,
                &mut *state,
                &input(at, at),
                null(),
                null(),
                &*gauge,
                &mut *gauge_state,
                &readings,
                &mut out,
                &mut its,
            )
        };
        assert_eq!(status, OK);
        let position = |x: f64| P::of(x);
        let core_input = trueaxis::Input {
            command: [position(at[0]), position(at[1]), position(at[2])],
            feedback: [position(at[0]), position(at[1]), position(at[2])],
            homed: true,
            enable: true,
            ..trueaxis::Input::at_rest(PERIOD_NS)
        };
        let core_probes = roundness::Probes {
            readings: readings.readings,
            spindle: readings.spindle,
            index: (readings.has_index == 1).then_some(readings.index),
            ..roundness::Probes::default()
        };
        let mut ride = GaugeRide::new(&core_gauge, &mut core_gauge_state, &core_probes);
        let expected = core.step(&mut core_state, &core_input, (), &mut ride);
        let expected_cycle = ride.cycle();
        assert_eq!(its.infeed.to_bits(), expected_cycle.infeed.to_bits(), "cycle {cycle}");
        assert_eq!((its.flags, its.finished == 1), (expected_cycle.flags.0, expected_cycle.finished));
        for axis in 0..3 {
            let [a, b] = [out.record.correction[axis], expected.record.correction[axis]];
            assert_eq!(a.to_bits(), b.to_bits(), "cycle {cycle}");
        }
        finished += i32::from(its.finished);
        fed |= its.infeed != 0.0;
    }
    let mut found = evaluation();
    let mut amplitudes: [Real; 2] = [9.0; 2];
    let (mut frame, mut expected, mut written) = ([0; GAUGE_FRAME_BYTES], [0; ROUNDNESS_FRAME_BYTES], 0);
    // SAFETY: everything is as the types say.
    unsafe {
        let (gauge, state) = (&raw const *gauge, &raw mut *gauge_state);
        let status = trueaxis_gauge_latest(gauge, state, &mut found);
        if cycles < 5 * N as i32 {
            assert_eq!(status, ERROR_NOT_YET);
            assert_eq!(trueaxis_gauge_harmonic(gauge, state, 3, amplitudes.as_mut_ptr()), ERROR_NOT_YET);
            return;
        }
        assert_eq!(status, OK);
        assert_eq!(trueaxis_gauge_harmonic(gauge, state, 3, amplitudes.as_mut_ptr()), OK);
        assert_eq!(amplitudes, core_gauge_state.harmonic(3));
        assert!((f64::from(amplitudes[0] as f32) - 2.0).abs() < 1e-3, "{amplitudes:?}");
        assert_eq!(trueaxis_gauge_harmonic(gauge, state, 128, amplitudes.as_mut_ptr()), ERROR_ARGUMENT);
        assert_eq!(trueaxis_gauge_set_wheel(gauge, state, 300.0, null_mut()), ERROR_CONFIG);
        let mut encode = |size| trueaxis_gauge_frame_encode(gauge, state, 5, frame.as_mut_ptr(), size, &mut written);
        assert_eq!(encode(30), ERROR_BUFFER);
        assert_eq!(encode(GAUGE_FRAME_BYTES), OK);
    }
    let core_frame = RoundnessFrame::of(5, &core_gauge, &core_gauge_state).unwrap();
    assert_eq!(&frame[..written], &*core_frame.encode(&mut expected).unwrap());
    let latest = core_gauge_state.latest().unwrap();
    assert_eq!((found.revolution, found.flags), (latest.revolution, latest.flags.0));
    assert_eq!(found.peak_to_valley_um.to_bits(), latest.peak_to_valley_um.to_bits());
    assert_eq!(found.x.total_um.to_bits(), latest.x.total_um.to_bits());
    assert_eq!(found.evaluated as i32, finished);
    assert!(finished >= 2 && fed, "{finished} revolutions evaluated");
}

#[test]
#[cfg_attr(miri, ignore)]
fn a_thousand_points() {
    compare::<1024>(size_of::<GaugeState>(), 2048 * 8);
}

#[test]
#[cfg_attr(miri, ignore)]
fn half_as_many() {
    compare::<512>(size_of::<GaugeState512>(), 1024 * 8);
}

#[test]
fn half_as_many_in_short() {
    compare::<512>(size_of::<GaugeState512>(), 10);
}

#[test]
#[cfg_attr(miri, ignore)]
fn gauge_and_state_must_fit() {
    let file = small_gauge();
    let Gauges { gauge, mut state } = gauges(file, size_of::<GaugeState512>());
    let mut other = zeroed::<Gauge>();
    let mut never = zeroed::<GaugeState>();
    let mut found = evaluation();
    let size = size_of::<Gauge>();
    let (bytes, length) = (file.as_ptr(), file.len());
    // SAFETY: what is wrong is null, zeroed or said to be of another size.
    unsafe {
        let state: *mut GaugeState = &mut *state;
        let other: *mut Gauge = &mut *other;
        let build =
            |gauge, size, bytes, length, period| trueaxis_gauge_build(gauge, size, bytes, length, period, null_mut());
        assert_eq!(build(other, size, mill().as_ptr(), mill().len(), PERIOD_NS), ERROR_GAUGE);
        assert_eq!(build(other, size, bytes, length - 1, PERIOD_NS), ERROR_TABLES);
        assert_eq!(build(other, size, bytes, length, 0), ERROR_CONFIG);
        assert_eq!(build(other, size - 8, bytes, length, PERIOD_NS), ERROR_SIZE);
        assert_eq!(build(null_mut(), size, bytes, length, PERIOD_NS), ERROR_NULL);
        assert_eq!(trueaxis_gauge_restart(other, state, size_of::<GaugeState512>()), ERROR_UNBUILT);
        assert_eq!(trueaxis_gauge_restart(&*gauge, state, size_of::<GaugeState>()), ERROR_SIZE);
        assert_eq!(trueaxis_gauge_latest(other, state, &mut found), ERROR_UNBUILT);
        assert_eq!(trueaxis_gauge_latest(&*gauge, &mut *never, &mut found), ERROR_UNBUILT);
        assert_eq!(trueaxis_gauge_latest(&*gauge, state, &mut found), ERROR_NOT_YET);
        found.size = 4;
        assert_eq!(trueaxis_gauge_latest(&*gauge, state, &mut found), ERROR_SIZE);
    }
}

#[test]
#[cfg_attr(miri, ignore)]
fn a_bypass_measures_on() {
    let file = small_gauge();
    let Gauges { gauge, mut state } = gauges(file, size_of::<GaugeState512>());
    let mut bypass = zeroed::<Loop>();
    let (mut out, mut its) = (output(), cycle_of());
    let at = [10.0; 6];
    let cycles = 8000;
    // SAFETY: everything is as the types say.
    unsafe {
        let size = size_of::<Loop>();
        assert_eq!(trueaxis_loop_bypass(&mut *bypass, size, 3, FAULT_TABLES_REFUSED, PERIOD_NS), OK);
        let mut passing = started(&bypass);
        // Nothing known: the gauge's part is written, the drives' is not.
        let blind = input([f64::INFINITY; 6], [f64::INFINITY; 6]);
        out.drive = [position(123.0); 6];
        its.flags = u16::MAX;
        let status = trueaxis_step_with_gauge(
            &*bypass,
            &mut *passing,
            &blind,
            null(),
            null(),
            &*gauge,
            &mut *state,
            &probes(0, 512),
            &mut out,
            &mut its,
        );
        assert_eq!((status, out.drive), (ERROR_NO_OUTPUT, [position(123.0); 6]));
        assert_ne!(its.flags, u16::MAX);
        for cycle in 0..cycles {
            let status = trueaxis_step_with_gauge(
                &*bypass,
                &mut *passing,
                &input(at, at),
                null(),
                null(),
                &*gauge,
                &mut *state,
                &probes(cycle, 512),
                &mut out,
                &mut its,
            );
            assert_eq!(status, OK);
            assert_eq!((its.infeed, out.record.fault), (0.0, FAULT_TABLES_REFUSED));
            assert_eq!(out.drive[..3], [position(10.0); 3]);
        }
        let mut found = evaluation();
        assert_eq!(trueaxis_gauge_latest(&*gauge, &mut *state, &mut found), OK);
        assert!(found.evaluated > 0);
    }
}
