//! No usable command and no usable reading: the drive positions of the output are not written, and the result reports
//! it.

use crate::machines::*;
use std::ptr::{null, null_mut};
use trueaxis_capi::*;

/// A position that no machine can have: infinite, or at an end of the integers' range.
const NONE: f64 = f64::INFINITY;
const BEFORE: f64 = 123.0;

/// Runs the relevant cycles: nothing known, Z missing because of its alarm, everything read; then the reset.
fn without_a_position(mut step: impl FnMut(&Input, &mut Output) -> ResultCode, latched: bool) {
    let actual = [10.0, 20.0, -200.0, 0.0, 0.0, 0.0];
    let mut out = output();
    out.drive = [position(BEFORE); AXES_MAX];
    for (feedback, alarm) in [([NONE; 6], 0), (actual, 0b100)] {
        let blind = Input { encoder_alarm: alarm, ..input([NONE; 6], feedback) };
        assert_eq!(step(&blind, &mut out), ERROR_NO_OUTPUT);
        assert_eq!(out.drive, [position(BEFORE); AXES_MAX], "not written");
        // The other members are written.
        assert_eq!((out.axes, out.size as usize), (3, size_of::<Output>()));
        assert_eq!(out.record.status & STATUS_NO_OUTPUT, STATUS_NO_OUTPUT);
        assert_eq!(out.record.status & STATUS_STOP_REQUEST, STATUS_STOP_REQUEST);
        assert_ne!(out.record.fault, FAULT_NONE);
    }
    assert_eq!(out.record.sequence, 1, "the cycles were done");
    assert_eq!(step(&input([NONE; 6], actual), &mut out), OK);
    let held = actual.map(position);
    assert_eq!((out.drive[..3].to_vec(), out.record.status & STATUS_NO_OUTPUT), (held[..3].to_vec(), 0));
    assert_eq!(step(&input([NONE; 6], [1.0; 6]), &mut out), OK);
    assert_eq!(out.drive[..3], held[..3], "held");
    if latched {
        assert_eq!(step(&input(actual, actual), &mut out), OK);
        assert_eq!(out.record.status & STATUS_STOP_REQUEST, STATUS_STOP_REQUEST);
        assert_eq!(step(&Input { reset: 1, ..input(actual, actual) }, &mut out), OK);
    } else {
        assert_eq!(step(&input(actual, actual), &mut out), OK);
    }
    assert_eq!((out.record.status & STATUS_STOP_REQUEST, out.drive[2]), (0, held[2]));
}

#[test]
fn a_step_without_a_position_to_hold_writes_no_drives() {
    let built = built(mill());
    let mut state = started(&built.servo);
    without_a_position(|given, out| crate::machines::step(&built.servo, &mut state, given, out), true);
}

#[test]
fn a_step_against_its_commands_writes_none_either() {
    let built = built(mill());
    let mut state = started(&built.servo);
    let mut window = zeroed::<CommandWindow>();
    // SAFETY: all pointers and sizes match their types.
    unsafe {
        let size = size_of::<CommandWindow>();
        assert_eq!(trueaxis_command_window_start(&mut *window, size, null(), 0.005), OK);
        let mut against = Measure { window: &mut *window, ..measure(MEASURE_COMMANDS) };
        without_a_position(
            |given, out| trueaxis_step(&*built.servo, &mut *state, given, &mut against, null_mut(), out),
            true,
        );
    }
}

#[test]
fn nor_does_a_bypass() {
    let mut bypass = zeroed::<Loop>();
    // SAFETY: all pointers and sizes match their types.
    let result = unsafe { trueaxis_loop_bypass(&mut *bypass, size_of::<Loop>(), 3, FAULT_TABLES_REFUSED, PERIOD_NS) };
    assert_eq!(result, OK);
    let mut state = started(&bypass);
    without_a_position(|given, out| crate::machines::step(&bypass, &mut state, given, out), false);
}

#[test]
fn refused_pointers_are_still_refused_first() {
    let built = built(mill());
    let mut state = started(&built.servo);
    let blind = input([NONE; 6], [NONE; 6]);
    // SAFETY: invalid arguments are null.
    let result = unsafe { trueaxis_step(&*built.servo, &mut *state, &blind, null_mut(), null_mut(), null_mut()) };
    assert_eq!(result, ERROR_NULL);
}
