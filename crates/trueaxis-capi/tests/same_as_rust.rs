//! Through the C interface a machine behaves as through the Rust one, bit for bit.

use crate::machines::rust::*;
use crate::machines::*;
use std::f64::consts::TAU;
use std::ptr::{null, null_mut};
use trueaxis::compensation::ThermalLine;
use trueaxis::contour::{self, Segment, convert};
use trueaxis::tcomp::Tcomp;
use trueaxis_capi::*;

/// Within the travel of the three-axis mill.
const MILL_CENTER: [f64; 3] = [60.0, -40.0, -200.0];
const RADIUS: f64 = 25.0;
/// Number of cycles per revolution: 196 mm/s.
const AROUND: usize = 8000;

/// Command on a circle about `center`; rotary axes move to and fro.
fn command(center: [f64; 3], cycle: usize) -> [f64; AXES_MAX] {
    let turn = TAU * cycle as f64 / AROUND as f64;
    let [x, y, z] = center;
    let rotary = [20.0 * turn.sin(), -10.0 * turn.sin(), 15.0 * (1.0 - turn.cos())];
    let [sin, cos] = [turn.sin(), turn.cos()];
    [x + RADIUS * cos, y + RADIUS * sin, z, rotary[0], rotary[1], rotary[2]]
}

/// Runs both sides along a circle, with a reading that jumps, an alarm, a change of temperature and an exchange of
/// tables.
fn around<const N: usize>(first: &[u8], second: &[u8], center: [f64; 3], cycles: usize) {
    let loops = [built(first), built(second)];
    let cores = [rust_loop::<N>(first), rust_loop::<N>(second)];
    let mut state = started(&loops[0].servo);
    let mut core_state = cores[0].start();

    let [x, y, z] = center;
    let start = [x + RADIUS, y, z];
    let normal = [0.0, 0.0, 1.0];
    let mut path = Programmed::new(64, 7);
    // SAFETY: all pointers and sizes match their types.
    unsafe {
        let [from, about, up] = [&start, &center, &normal].map(|v| v.as_ptr());
        assert_eq!(trueaxis_path_arc(&mut *path.path, from, from, about, up, 0, null_mut()), OK);
        assert_eq!(trueaxis_path_close(&mut *path.path), OK);
    }
    let mut spans = Vec::new();
    let [at, about, up] = [start, center, normal].map(Into::into);
    let arc = Segment::Arc { start: at, end: at, center: about, normal: up, turns: 0 };
    convert::<R, P>(&arc, 0, normal, |span| {
        spans.push(span);
        Ok(())
    })
    .unwrap();
    let core_path = contour::Path::new(&spans, 7, true);

    let settings = Tcomp::parse(first).unwrap().settings().clone();
    let (mut out, mut measured) = (output(), 0);
    for cycle in 0..cycles {
        let at = command(center, cycle.saturating_sub(20));
        let mut feedback = command(center, cycle.saturating_sub(40));
        feedback[0] += if cycle == cycles / 4 { 1.0 } else { 0.0 };
        let mut c = input(at, feedback);
        c.encoder_alarm = u8::from(cycle == cycles / 3) << 1;
        let exchanged = usize::from(cycle >= cycles / 2);
        if cycle == cycles / 5 {
            // SAFETY: all pointers and sizes match their types.
            assert_eq!(unsafe { trueaxis_set_thermal(&*loops[0].servo, &mut *state, 0, 4.0) }, OK);
            let growth = settings.axes.iter().find(|axis| axis.axis == trueaxis::Axis::X).unwrap().thermal;
            core_state.set_thermal(0, ThermalLine::for_axis(&growth, 4.0).unwrap()).unwrap();
        }
        let u = cycle.saturating_sub(20) as f64 / AROUND as f64;
        let reference = path.reference(0, u).unwrap();
        let mut against = Measure { path: &*path.path, reference, ..measure(MEASURE_PATH) };
        let servo = &*loops[exchanged].servo;
        // SAFETY: all pointers and sizes match their types.
        assert_eq!(unsafe { trueaxis_step(servo, &mut *state, &c, &mut against, null_mut(), &mut out) }, OK);
        let on = core_path.on(contour::Reference { span: reference.span, t: reference.t });
        let expected = cores[exchanged].step(&mut core_state, &core_input(&c), on, ());
        same(&out, &expected, cycle);
        measured += usize::from(out.record.status & STATUS_CONTOUR != 0);
    }
    // At the start and after every fault the search takes at most 15 cycles.
    assert!(measured + 80 > cycles, "{measured} of {cycles} cycles measured a contour error");
    assert!(measured > 0 || cfg!(miri));
    assert!(out.record.correction[..N].iter().any(|c| c.abs() > 1e-6), "nothing was corrected");
}

#[test]
#[cfg_attr(miri, ignore)]
fn three_axes() {
    around::<3>(MILL, &halved(MILL), MILL_CENTER, 8000);
}

#[test]
fn three_axes_in_short() {
    around::<3>(mill(), mill(), MILL_CENTER, if cfg!(miri) { 12 } else { 60 });
}

#[test]
#[cfg_attr(miri, ignore)]
fn five_axes_volumetric() {
    let mill = sample("mill-5axis");
    around::<5>(&mill, &halved(&mill), [60.0, -40.0, 100.0], 4000);
}

/// The machine without one of its rotary axes, or with another one.
fn with_rotary_axes(chain: &str, rotary: &[trueaxis::Axis]) -> Vec<u8> {
    let mut machine = read("mill-3axis");
    machine.settings.chain = chain.try_into().unwrap();
    let given = [false, false, false, true, true, true];
    for axis in rotary {
        let settings = trueaxis::machine::AxisSettings::with_defaults(*axis, true);
        machine.settings.axes.push(settings).unwrap();
        let rows = (0..5).map(|row| {
            let errors = [0.0, 0.0, 0.0, 20e-6, -15e-6, 5e-6].map(|error: f64| error * f64::from(row % 3));
            trueaxis::Row { position: f64::from(row - 2) * 100.0, forward: errors, reverse: errors }
        });
        machine.tables.push(Some(trueaxis_tables::Table { given, bidirectional: false, rows: rows.collect() }));
    }
    trueaxis_tables::compile(&machine).unwrap()
}

#[test]
#[cfg_attr(miri, ignore)]
fn four_axes_and_six() {
    use trueaxis::Axis::{A, B, C};
    let four = with_rotary_axes("w C' X' Y' b Z t", &[C]);
    around::<4>(&four, &halved(&four), MILL_CENTER, 3000);
    let six = with_rotary_axes("w C' B' A' X' Y' b Z t", &[A, B, C]);
    around::<6>(&six, &halved(&six), MILL_CENTER, 3000);
}

#[test]
fn against_the_commands() {
    let cycles: usize = if cfg!(miri) { 12 } else { 4000 };
    let (servo, core) = (mill_loop(), rust_loop::<3>(mill()));
    let (mut state, mut core_state) = (started(&servo.servo), core.start());
    let mut window = zeroed::<CommandWindow>();
    let plane = [0.0, 0.0, 1.0];
    let mut commanded = contour::CommandWindow::<R, P, COMMAND_WINDOW_SPANS>::new(plane, 0.005).unwrap();
    let window: *mut CommandWindow = &mut *window;
    // SAFETY: all pointers and sizes match their types.
    assert_eq!(unsafe { trueaxis_command_window_start(window, size_of::<CommandWindow>(), null(), 0.005) }, OK);
    let (mut out, mut against) = (output(), Measure { window, ..measure(MEASURE_COMMANDS) });
    for cycle in 0..cycles {
        let [at, feedback] = [cycle, cycle.saturating_sub(10)].map(|cycle| command(MILL_CENTER, cycle));
        let c = input(at, feedback);
        if cycle == cycles / 2 {
            // SAFETY: all pointers and sizes match their types.
            assert_eq!(unsafe { trueaxis_command_window_restart(window) }, OK);
            commanded.restart();
        }
        // SAFETY: all pointers and sizes match their types.
        let result = unsafe { trueaxis_step(&*servo.servo, &mut *state, &c, &mut against, null_mut(), &mut out) };
        assert_eq!(result, OK);
        same(&out, &core.step(&mut core_state, &core_input(&c), &mut commanded, ()), cycle);
    }
    assert!(out.record.tip.error > 0.0 && out.record.status & STATUS_CONTOUR != 0);
}
