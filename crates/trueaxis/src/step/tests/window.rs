#![allow(clippy::indexing_slicing)]

use crate::contour::{CommandWindow, Path, Segment, Span, convert};
use crate::error::Fault;
use crate::step::tests::{input, servo_loop};
use glam::DVec3;
use std::vec::Vec;

/// Feed of 60 mm/s at 10 kHz.
const WAY: f64 = 0.006;

#[test]
fn on_a_line_it_says_what_the_step_says_with_the_planners_own_path() {
    let servo = servo_loop(1.0);
    let (mut following, mut with_path) = (servo.start(), servo.start());
    let mut commanded = CommandWindow::<f64, f64, 64>::new([0.0, 0.0, 1.0], 0.005).unwrap();
    let mut spans: Vec<Span<f64, f64>> = Vec::new();
    let line = Segment::Line { start: [10.0; 3].into(), end: DVec3::new(30.0, 10.0, 10.0) };
    convert(&line, 0, [0.0, 0.0, 1.0], |span| {
        spans.push(span);
        Ok(())
    })
    .unwrap();
    let path = Path::new(&spans, 0, false);
    for i in 0..2500i32 {
        // A hundred cycles at rest, then moving.
        let s = WAY * f64::from((i - 100).max(0));
        let mut cycle = input([10.0 + s, 10.0, 10.0]);
        cycle.feedback = [10.0 + (s - 0.05).max(0.0), 10.002, 10.0];
        let a = servo.step(&mut following, &cycle, &mut commanded, ());
        let place = spans.iter().position(|span| span.t_of((s / 20.0).min(1.0)) < 1.0).unwrap();
        let reference = crate::contour::Reference { span: place as u32, t: spans[place].t_of(s / 20.0) };
        let b = servo.step(&mut with_path, &cycle, path.on(reference), ());
        assert_eq!((a.drive, a.feedback), (b.drive, b.feedback));
        if i > 110 {
            for (a, b) in [(a.record.tip, b.record.tip), (a.record.encoder, b.record.encoder)] {
                assert!((a.normal - b.normal).abs() < 1e-10, "{i}: {a:?} {b:?}");
                assert!((a.binormal - b.binormal).abs() < 1e-10, "{i}: {a:?} {b:?}");
                assert!((a.lag - b.lag).abs() < 1e-9, "{i}: {a:?} {b:?}");
            }
            assert!((a.record.encoder.normal - 0.002).abs() < 1e-9);
        }
    }
}

#[test]
fn a_refused_command_is_no_point_of_the_path() {
    let servo = servo_loop(1.0);
    let mut state = servo.start();
    let mut commanded = CommandWindow::<f64, f64, 64>::new([0.0, 0.0, 1.0], 0.005).unwrap();
    for i in 0..200 {
        servo.step(&mut state, &input([10.0 + WAY * f64::from(i), 10.0, 10.0]), &mut commanded, ());
    }
    let before = commanded.reference();
    for command in [[f64::NAN, 10.0, 10.0], [90.0, 10.0, 10.0]] {
        let out = servo.step(&mut state, &input(command), &mut commanded, ());
        assert!(out.stop_requested() && out.record.fault != Fault::None);
        assert!(!out.record.tip.is_measured());
        assert_eq!(commanded.reference(), before);
    }
}
