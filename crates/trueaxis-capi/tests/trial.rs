//! Parts on trial through the C interface, on drives that are simulated here.

// The conversions are useless only in double precision.
#![allow(clippy::useless_conversion)]

use crate::machines::rust::*;
use crate::machines::*;
use std::f64::consts::TAU;
use std::ptr::null_mut;
use trueaxis::Position as _;
use trueaxis::contour::{self, Segment, convert};
use trueaxis::machine::{DriveFigures, DynamicSettings, FeedbackSettings};
use trueaxis_capi::*;

const PERIOD_S: f64 = 1e-9 * PERIOD_NS as f64;
const CENTER: [f64; 3] = [60.0, -40.0, -200.0];
const RADIUS: f64 = 25.0;
/// Cycles of a turn: 24.5 mm/s.
const AROUND: f64 = 64_000.0;
/// Share of the velocity that the drive of X feeds forward, as the tables state it.
const FED: f64 = 0.9;

/// The mill with the lag of X compensated, and nothing else that is dynamic.
fn lagging_mill() -> Vec<u8> {
    let mut machine = read("mill-3axis");
    for (k, axis) in machine.settings.axes.iter_mut().enumerate() {
        let velocity_feed_forward = if k == 0 { FED } else { 1.0 };
        axis.servo.drive = Some(DriveFigures { velocity_feed_forward, ..drive() });
        axis.servo.friction = None;
        axis.servo.dynamic = Some(DynamicSettings { lag: true, ..DynamicSettings::with_defaults(axis.axis) });
    }
    machine.settings.contour.feedback = None::<FeedbackSettings>;
    machine.settings.crosstalk.clear();
    trueaxis_tables::compile(&machine).unwrap()
}

/// A position loop with velocity feed-forward.
struct Drive {
    at: f64,
    command: f64,
}

impl Drive {
    fn advance(&mut self, command: f64, fed: f64) {
        let gain = drive().position_gain_per_s;
        self.at += gain * PERIOD_S * (self.command - self.at) + fed * (command - self.command);
        self.command = command;
    }
}

/// A circle, on both interfaces; every output of C is the Rust one in every bit.
struct Circle {
    servo: BuiltLoop,
    state: Box<State>,
    core: trueaxis::ServoLoop<'static, R, P, 3>,
    core_state: trueaxis::State<R, P, 3>,
    path: Programmed,
    spans: Vec<contour::Span<R, P>>,
    drives: [Drive; 3],
    cycle: usize,
}

impl Circle {
    fn new(file: &[u8]) -> Circle {
        let (servo, core) = (built(file), rust_loop::<3>(file));
        let (state, core_state) = (started(&servo.servo), core.start());
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
        let drives = start.map(|at| Drive { at, command: at });
        Circle { servo, state, core, core_state, path, spans, drives, cycle: 0 }
    }

    /// A cycle with these bits of `dynamics_off`, on a drive of X that feeds this share of the velocity forward.
    fn step(&mut self, off: u8, fed: f64) -> Record {
        let turn = self.cycle as f64 / AROUND;
        let [sin, cos] = [f64::sin, f64::cos].map(|f| f(TAU * turn));
        let command = [CENTER[0] + RADIUS * cos, CENTER[1] + RADIUS * sin, CENTER[2], 0.0, 0.0, 0.0];
        let [x, y, z] = self.drives.each_ref().map(|drive| drive.at);
        let mut c = input(command, [x, y, z, 0.0, 0.0, 0.0]);
        c.dynamics_off = off;
        let reference = self.path.reference(0, turn.fract()).unwrap();
        let mut against = Measure { path: &*self.path.path, reference, ..measure(MEASURE_PATH) };
        let (servo, state, mut out) = (&*self.servo.servo, &mut *self.state, output());
        // SAFETY: all pointers and sizes match their types.
        assert_eq!(unsafe { trueaxis_step(servo, state, &c, &mut against, null_mut(), &mut out) }, OK);
        let path = contour::Path::new(&self.spans, 0, true);
        let on = path.on(contour::Reference { span: reference.span, t: reference.t });
        same(&out, &self.core.step(&mut self.core_state, &core_input(&c), on, ()), self.cycle);
        assert_eq!(out.record.fault, FAULT_NONE, "cycle {}", self.cycle);
        for (k, drive) in self.drives.iter_mut().enumerate() {
            drive.advance(from_c(out.drive[k]).to_f64(), if k == 0 { fed } else { 1.0 });
        }
        self.cycle += 1;
        out.record
    }
}

/// Largest feed-forward that X asks for and largest contour error over `cycles`, mm, and the bits of the status that were
/// ever set.
fn largest(circle: &mut Circle, cycles: usize, off: u8, fed: f64) -> (f64, f64, u8) {
    (0..cycles).map(|_| circle.step(off, fed)).fold((0.0, 0.0, 0), |(asked, error, status), record| {
        let now = f64::from(record.dynamic.feed_forward[0].abs());
        (f64::max(asked, now), f64::max(error, record.tip.error.into()), status | record.status)
    })
}

#[test]
#[cfg_attr(miri, ignore)]
fn on_trial_a_part_acts_once_it_has_shown_that_it_helps_and_one_that_harms_is_led_out_and_reported() {
    let file = lagging_mill();
    let mut circles = [Circle::new(&file), Circle::new(&file)];
    let [plain, trial] = [0, DYNAMICS_ON_TRIAL];
    // Before the trial has seen anything, the part does not act; as configured, it does.
    let asked = |circle: &mut Circle, off| largest(circle, 100, off, FED).0;
    let [full, none] = [asked(&mut circles[0], plain), asked(&mut circles[1], trial)];
    assert!(full > 1e-5 && none == 0.0, "{full} {none} mm");
    // The figures are right: the part comes to act as it does without the trial.
    let last = |circle: &mut Circle, off, fed| {
        let (_, _, status) = largest(circle, 15_900, off, fed);
        let (asked, error, _) = largest(circle, 8_000, off, fed);
        (asked, error, status)
    };
    let [(full, _, status), (shown, left, status_shown)] =
        [last(&mut circles[0], plain, FED), last(&mut circles[1], trial, FED)];
    assert!(shown > 0.75 * full && full > 0.015, "{shown} of {full} mm");
    assert_eq!((status | status_shown) & (STATUS_FRICTION_OUT | STATUS_LAG_OUT), 0);
    // The drive now feeds all of the velocity forward: the part harms.
    let [(full, harm, status), (shown, led_out, status_shown)] =
        [last(&mut circles[0], plain, 1.0), last(&mut circles[1], trial, 1.0)];
    assert!(full > 0.015 && harm > 0.01 && status & STATUS_LAG_OUT == 0, "{full} {harm} mm, {status}");
    assert!(shown < 0.1 * full && led_out < 0.1 * harm, "{shown} of {full}, {led_out} of {harm}, {left} mm");
    assert_eq!(status_shown & (STATUS_FRICTION_OUT | STATUS_LAG_OUT), STATUS_LAG_OUT);
    // Without the bit the part acts in full again, and nothing is reported.
    let (again, _, _) = largest(&mut circles[1], 8_000, plain, 1.0);
    assert!(again > 0.9 * full, "{again} of {full} mm");
    assert_eq!(circles[1].step(plain, 1.0).status & STATUS_LAG_OUT, 0);
}
