//! The dynamic correction through the C interface: equal to the Rust one in every bit, each part switched in motion.

// The conversions are useless only in double precision.
#![allow(clippy::useless_conversion)]

use crate::machines::rust::*;
use crate::machines::*;
use std::f64::consts::TAU;
use std::ptr::null_mut;
use trueaxis::Axis;
use trueaxis::contour::{self, Segment, convert};
use trueaxis::machine::{CrosstalkSettings, DynamicSettings, FeedbackSettings, FrictionSettings};
use trueaxis_capi::*;

/// The mill with every part configured.
fn dynamic_mill() -> Vec<u8> {
    let mut machine = read("mill-3axis");
    for axis in &mut machine.settings.axes {
        axis.servo.drive = Some(drive());
        axis.servo.friction = Some(FrictionSettings::with_defaults(0.5, 0.02));
        let dynamic = DynamicSettings::with_defaults(axis.axis);
        axis.servo.dynamic = Some(DynamicSettings { lag: true, acceleration: true, take_up: true, ..dynamic });
    }
    machine.settings.contour.feedback =
        Some(FeedbackSettings { max_feed_per_s: 1000.0, ..FeedbackSettings::default() });
    let points = [[0.0, 1.2e-6]].into_iter().collect();
    let crosstalk = CrosstalkSettings { tip: Axis::X, from: Axis::Y, over: Axis::Y, points };
    machine.settings.crosstalk.push(crosstalk).unwrap();
    trueaxis_tables::compile(&machine).unwrap()
}

const CENTER: [f64; 3] = [60.0, -40.0, -200.0];
const RADIUS: f64 = 25.0;
/// 98 mm/s.
const AROUND: f64 = 16_000.0;
/// Number of cycles for each setting of the switches.
const EACH: usize = 2_000;

/// A point on the circle. Fractional cycles serve for readings that lag.
fn command(cycle: f64) -> [f64; AXES_MAX] {
    let [sin, cos] = [f64::sin, f64::cos].map(|f| f(TAU * cycle.max(0.0) / AROUND));
    [CENTER[0] + RADIUS * cos, CENTER[1] + RADIUS * sin, CENTER[2], 0.0, 0.0, 0.0]
}

/// Largest value of every part, in any axis, in the last quarter of one setting of the switches, mm.
#[derive(Default)]
struct Seen {
    feed_forward: f64,
    feedback: f64,
    crosstalk: f64,
    learned: f64,
    /// Largest change of the sent correction from cycle to cycle.
    step: f64,
    /// Sent in the last cycle.
    sent: f64,
}

#[allow(clippy::useless_conversion)] // not in single precision
fn largest(numbers: &[Real]) -> f64 {
    numbers.iter().map(|x| f64::from(x.abs())).fold(0.0, f64::max)
}

fn run(file: &[u8], settings: &[u8]) -> Vec<Seen> {
    let (servo, core) = (built(file), rust_loop::<3>(file));
    let (mut state, mut core_state) = (started(&servo.servo), core.start());
    let start: [f64; 3] = [CENTER[0] + RADIUS, CENTER[1], CENTER[2]];
    let normal = [0.0, 0.0, 1.0];
    let mut path = Programmed::new(64, 0);
    // SAFETY: all pointers and sizes match their types.
    unsafe {
        let [from, about, up] = [&start, &CENTER, &normal].map(|v| v.as_ptr());
        assert_eq!(trueaxis_path_arc(&mut *path.path, from, from, about, up, 0, null_mut()), OK);
        assert_eq!(trueaxis_path_close(&mut *path.path), OK);
    }
    let mut spans = Vec::new();
    let [at, about, up] = [start, CENTER, normal].map(Into::into);
    convert::<R, P>(&Segment::Arc { start: at, end: at, center: about, normal: up, turns: 0 }, 0, normal, |span| {
        spans.push(span);
        Ok(())
    })
    .unwrap();
    let core_path = contour::Path::new(&spans, 0, true);
    let (mut out, mut seen, mut before) = (output(), Vec::new(), [0.0; AXES_MAX]);
    for cycle in 0..EACH * settings.len() {
        if cycle % EACH == 0 {
            seen.push(Seen::default());
        }
        let mut c = input(command(cycle as f64), command(cycle as f64 - 12.5));
        c.feedback[1] = position(command(cycle as f64 - 12.5)[1] + 1e-3);
        c.dynamics_off = settings[cycle / EACH];
        c.learned = [0.002, -0.001, 0.0005].map(position);
        let reference = path.reference(0, (cycle as f64 / AROUND).fract()).unwrap();
        let mut against = Measure { path: &*path.path, reference, ..measure(MEASURE_PATH) };
        // SAFETY: all pointers and sizes match their types.
        assert_eq!(unsafe { trueaxis_step(&*servo.servo, &mut *state, &c, &mut against, null_mut(), &mut out) }, OK);
        let on = core_path.on(contour::Reference { span: reference.span, t: reference.t });
        same(&out, &core.step(&mut core_state, &core_input(&c), on, ()), cycle);

        let (seen, parts) = (seen.last_mut().unwrap(), &out.record.dynamic);
        // A part that is switched off fades out over several reset times and position-loop time constants.
        if cycle % EACH >= EACH * 3 / 4 {
            seen.feed_forward = seen.feed_forward.max(largest(&parts.feed_forward));
            seen.feedback = seen.feedback.max(largest(&parts.feedback));
            seen.crosstalk = seen.crosstalk.max(largest(&parts.crosstalk));
            seen.learned = seen.learned.max(largest(&parts.learned));
        }
        let step = parts.sent.iter().zip(before).map(|(now, before)| (f64::from(*now) - before).abs());
        seen.step = seen.step.max(step.fold(0.0, f64::max));
        before = parts.sent.map(f64::from);
        seen.sent = largest(&parts.sent);
    }
    seen
}

#[test]
#[cfg_attr(miri, ignore)]
fn every_part_is_switched_in_motion_without_a_jump() {
    let file = dynamic_mill();
    let [friction, lag, acceleration] = [DYNAMICS_FRICTION, DYNAMICS_LAG, DYNAMICS_ACCELERATION];
    let feed_forward = friction | lag | acceleration;
    let settings = [0, feed_forward, DYNAMICS_FEEDBACK, DYNAMICS_CROSSTALK, DYNAMICS_LEARNED, DYNAMICS_ALL, 0];
    let seen = run(&file, &settings);
    for (off, seen) in settings.into_iter().zip(&seen) {
        let parts = [
            (feed_forward, seen.feed_forward),
            (DYNAMICS_FEEDBACK, seen.feedback),
            (DYNAMICS_CROSSTALK, seen.crosstalk),
            (DYNAMICS_LEARNED, seen.learned),
        ];
        for (part, largest) in parts {
            let is_off = off & part != 0;
            assert!(
                if is_off { largest < 1e-8 } else { largest > 1e-6 },
                "off {off:07b}, part {part:07b}: {largest} mm"
            );
        }
        // 5 mm/s, in cycles of 100 µs; positions in single precision are whole nanometres.
        assert!(seen.step <= 0.5e-3 + 2e-6, "off {off:07b}: {} mm in a cycle", seen.step);
        assert_eq!(seen.sent < 1e-8, off == DYNAMICS_ALL, "off {off:07b}: {} mm", seen.sent);
    }
}

#[test]
#[cfg_attr(miri, ignore)]
fn a_machine_without_dynamic_parts_has_none() {
    // `same` checks every cycle.
    let mut machine = read("mill-3axis");
    machine.settings.axes.iter_mut().for_each(|axis| axis.servo = Default::default());
    machine.settings.contour.feedback = None;
    machine.settings.crosstalk.clear();
    let file = trueaxis_tables::compile(&machine).unwrap();
    assert!(run(&file, &[0]).iter().all(|seen| seen.sent == 0.0 && seen.learned == 0.0));
}
