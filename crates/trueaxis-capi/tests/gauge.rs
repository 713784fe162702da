//! The gauge of three probes through the C interface, compared with the Rust one.

use crate::machines::gauge::{Gauges, small_gauge, with_gauge};
use crate::machines::*;
use std::ptr::null_mut;
use trueaxis::tcomp::Tcomp;
use trueaxis::telemetry::{ROUNDNESS_FRAME_BYTES, RoundnessFrame};
use trueaxis_capi::*;

fn evaluation() -> Evaluation {
    // SAFETY: numbers only.
    Evaluation { size: size_of::<Evaluation>() as u32, ..unsafe { std::mem::zeroed() } }
}

fn compare<const N: usize>(cycles: i32) {
    let file = &if N == 512 { small_gauge().to_vec() } else { with_gauge(small(), N as u16) }[..];
    let servo = built(file);
    let mut state = started(&servo.servo);
    let mut gauges = Gauges::new(file, N);
    let tables = Tcomp::parse(file).unwrap();
    let core = rust::rust_loop::<3>(file);
    let mut core_state = core.start();
    let core_gauge = Box::new(
        trueaxis::roundness::Gauge::<Real, N>::build(tables.settings().roundness.as_ref().unwrap(), PERIOD_NS).unwrap(),
    );
    let mut core_gauge_state = Box::new(core_gauge.start());

    let at = [10.0, 20.0, -200.0, 0.0, 0.0, 0.0];
    let (mut out, mut finished, mut fed) = (output(), 0, false);
    for cycle in 0..cycles {
        let mut ride = gauges.ride(cycle, N as i32);
        let given = input(at, at);
        // SAFETY: all pointers and sizes match their types.
        let result = unsafe { trueaxis_step(&*servo.servo, &mut *state, &given, null_mut(), &mut ride, &mut out) };
        assert_eq!(result, OK);
        let probes = gauge::probes(&ride);
        let mut core_ride = trueaxis::GaugeRide::new(&core_gauge, &mut core_gauge_state, &probes);
        let expected = core.step(&mut core_state, &rust::core_input(&given), (), &mut core_ride);
        gauge::same_cycle(&ride, &core_ride.cycle(), cycle as usize);
        rust::same(&out, &expected, cycle as usize);
        finished += i32::from(ride.finished);
        fed |= ride.infeed != 0.0;
    }
    let Gauges { gauge, state: mut gauge_state, .. } = gauges;
    let mut found = evaluation();
    let mut amplitudes: [Real; 2] = [9.0; 2];
    let (mut frame, mut expected, mut written) = ([0; GAUGE_FRAME_BYTES], [0; ROUNDNESS_FRAME_BYTES], 0);
    // SAFETY: all pointers and sizes match their types.
    unsafe {
        let (gauge, state) = (&raw const *gauge, &raw mut *gauge_state);
        let result = trueaxis_gauge_latest(gauge, state, &mut found);
        if cycles < 5 * N as i32 {
            assert_eq!(result, ERROR_NOT_YET);
            assert_eq!(trueaxis_gauge_harmonic(gauge, state, 3, amplitudes.as_mut_ptr()), ERROR_NOT_YET);
            return;
        }
        assert_eq!(result, OK);
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
    compare::<1024>(2048 * 8);
}

#[test]
#[cfg_attr(miri, ignore)]
fn half_as_many() {
    compare::<512>(1024 * 8);
}

#[test]
fn half_as_many_in_short() {
    compare::<512>(4);
}

#[test]
#[cfg_attr(miri, ignore)]
fn gauge_and_state_must_fit() {
    let file = small_gauge();
    let Gauges { gauge, mut state, .. } = Gauges::new(file, 512);
    let mut other = zeroed::<Gauge>();
    let mut never = zeroed::<GaugeState>();
    let mut found = evaluation();
    let size = size_of::<Gauge>();
    let (bytes, length) = (file.as_ptr(), file.len());
    // SAFETY: invalid arguments are null, zeroed or have a wrong size stated.
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
    let mut gauges = Gauges::new(small_gauge(), 512);
    let mut bypass = zeroed::<Loop>();
    let mut out = output();
    let at = [10.0; 6];
    // SAFETY: all pointers and sizes match their types.
    unsafe {
        let size = size_of::<Loop>();
        assert_eq!(trueaxis_loop_bypass(&mut *bypass, size, 3, FAULT_TABLES_REFUSED, PERIOD_NS), OK);
        let mut passing = started(&bypass);
        // No position is known: the gauge's results are written, the drive positions are not.
        let blind = input([f64::INFINITY; 6], [f64::INFINITY; 6]);
        out.drive = [position(123.0); 6];
        let mut ride = gauges.ride(0, 512);
        let result = trueaxis_step(&*bypass, &mut *passing, &blind, null_mut(), &mut ride, &mut out);
        assert_eq!((result, out.drive), (ERROR_NO_OUTPUT, [position(123.0); 6]));
        assert_ne!(ride.flags, u16::MAX);
        for cycle in 0..8000 {
            let mut ride = gauges.ride(cycle, 512);
            let result = trueaxis_step(&*bypass, &mut *passing, &input(at, at), null_mut(), &mut ride, &mut out);
            assert_eq!(result, OK);
            assert_eq!((ride.infeed, out.record.fault), (0.0, FAULT_TABLES_REFUSED));
            assert_eq!(out.drive[..3], [position(10.0); 3]);
        }
        let mut found = evaluation();
        assert_eq!(trueaxis_gauge_latest(&*gauges.gauge, &mut *gauges.state, &mut found), OK);
        assert!(found.evaluated > 0);
    }
}

/// A ride that is refused leaves everything unchanged: the states, the output, and its own results.
#[test]
fn rides_are_checked() {
    let mut gauges = Gauges::new(small_gauge(), 512);
    let servo = built(small_gauge());
    let mut state = started(&servo.servo);
    let at = input([10.0, 20.0, -200.0, 0.0, 0.0, 0.0], [10.0, 20.0, -200.0, 0.0, 0.0, 0.0]);
    let (nothing, mut never) = (zeroed::<Gauge>(), zeroed::<GaugeState>());
    let good = gauges.ride(0, 512);
    let odd = |pointer: usize| std::ptr::without_provenance_mut::<u64>(pointer | 1);
    let mut out = Output { axes: 77, ..output() };
    for (expected, mut ride) in [
        (ERROR_SIZE, GaugeRide { size: good.size - 4, ..good }),
        (ERROR_NULL, GaugeRide { gauge: std::ptr::null(), ..good }),
        (ERROR_NULL, GaugeRide { state: null_mut(), ..good }),
        (ERROR_UNBUILT, GaugeRide { gauge: &*nothing, ..good }),
        (ERROR_UNBUILT, GaugeRide { state: &mut *never, ..good }),
        (ERROR_UNBUILT, GaugeRide { gauge: (&raw const *servo.servo).cast(), ..good }),
        (ERROR_ALIGNMENT, GaugeRide { gauge: odd(64).cast(), ..good }),
        (ERROR_ALIGNMENT, GaugeRide { state: odd(64).cast(), ..good }),
    ] {
        // SAFETY: invalid arguments are null, misaligned, zeroed, of another kind or have a wrong size stated.
        let result = unsafe { trueaxis_step(&*servo.servo, &mut *state, &at, null_mut(), &mut ride, &mut out) };
        assert_eq!(result, expected);
        assert_eq!((ride.finished, ride.flags, ride.infeed, out.axes), (9, u16::MAX, 9.0, 77));
    }
    let mut ride = good;
    // SAFETY: all pointers and sizes match their types.
    assert_eq!(unsafe { trueaxis_step(&*servo.servo, &mut *state, &at, null_mut(), &mut ride, &mut out) }, OK);
    assert_eq!((ride.finished, out.record.sequence), (0, 0), "refused cycles do not count");
}
