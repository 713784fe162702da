//! Every measure with and without a gauge.

use super::*;
use crate::contour::{CommandWindow, Flags, Segment, Span, ToolPath, Turn, convert};
use crate::kinematics::Kinematics;
use crate::roundness::Followed;
use glam::DVec3;

/// Distance of the readings from the line, mm.
const DEVIATION: f64 = 0.002;
/// Infeed of Y that the gauge requests, mm.
const INFEED: f64 = 0.005;
/// Cycles at rest, in which first the correction and then the infeed is reached; then 60 mm/s.
const AT_REST: i32 = 2000;
const CYCLES: i32 = 4000;
/// First cycle with infeed.
const FROM: i32 = 1000;
const LENGTH: f64 = 20.0;

/// A gauge that requests a given infeed.
struct Asking {
    infeed: f64,
    whole: usize,
}

impl Ride<f64> for &mut Asking {
    fn infeed_slot(&self) -> Option<usize> {
        Some(1)
    }
    fn update(&mut self, followed: Followed) -> f64 {
        self.whole += usize::from(followed == Followed::Whole);
        self.infeed
    }
}

/// Moves along a line in X, with the readings offset in Y; `step` receives the completed part of the line.
fn run(mut step: impl FnMut(&Loop, &mut State<f64, f64, 3>, &Input<f64, 3>, f64, &mut Asking) -> Out) -> Vec<Out> {
    let servo = servo_loop(1.0);
    let mut state = servo.start();
    let mut asking = Asking { infeed: 0.0, whole: 0 };
    let outputs = (0..CYCLES)
        .map(|i| {
            let way = 0.006 * f64::from((i - AT_REST).max(0));
            let mut cycle = input([10.0 + way, 10.0, 10.0]);
            cycle.feedback[1] += DEVIATION;
            asking.infeed = if i < FROM { 0.0 } else { INFEED };
            step(servo, &mut state, &cycle, way / LENGTH, &mut asking)
        })
        .collect();
    assert!(asking.whole == 0 || asking.whole > 3000);
    outputs
}

#[test]
fn a_gauge_adds_its_infeed_and_changes_nothing_else_whatever_is_measured() {
    let kinematics = Kinematics::new(&machine(|_| ())).unwrap();
    let (mut spans, mut turns): (Vec<Span<f64, f64>>, Vec<_>) = (Vec::new(), Vec::new());
    let line = Segment::Line { start: [10.0; 3].into(), end: DVec3::new(10.0 + LENGTH, 10.0, 10.0) };
    convert(&line, 0, [0.0, 0.0, 1.0], |span| {
        turns.push(Turn::axes(&span, [0.0, 1.0], [0.0; 3], [0.0; 3]));
        spans.push(span);
        Ok(())
    })
    .unwrap();
    let path = Path::new(&spans, 0, false);
    let tool_path = ToolPath::new(path, &turns);
    let window = || CommandWindow::<f64, f64, 64>::new([0.0, 0.0, 1.0], 0.005).unwrap();
    let on_tool_path = |u| OnToolPath::new(&tool_path, path.at(0, u).reference, &kinematics);

    let (mut with, mut without) = (window(), window());
    let cases = [
        (
            "nothing",
            run(|servo, state, input, _, _| servo.step(state, input, (), ())),
            run(|servo, state, input, _, gauge| servo.step(state, input, (), gauge)),
        ),
        (
            "path",
            run(|servo, state, input, u, _| servo.step(state, input, path.at(0, u), ())),
            run(|servo, state, input, u, gauge| servo.step(state, input, path.at(0, u), gauge)),
        ),
        (
            "command window",
            run(|servo, state, input, _, _| servo.step(state, input, &mut without, ())),
            run(|servo, state, input, _, gauge| servo.step(state, input, &mut with, gauge)),
        ),
        (
            "tool path",
            run(|servo, state, input, u, _| servo.step(state, input, &mut on_tool_path(u), ())),
            run(|servo, state, input, u, gauge| servo.step(state, input, &mut on_tool_path(u), gauge)),
        ),
    ];
    let drives = cases[0].1.iter().map(|out| out.drive).collect::<Vec<_>>();
    for (measure, plain, gauged) in &cases {
        for (i, (plain, gauged)) in plain.iter().zip(gauged).enumerate() {
            let (a, b) = (&plain.record, &gauged.record);
            assert_eq!(plain.drive, drives[i], "{measure}, {i}: what is measured moves a drive");
            assert_eq!((a.tip, a.encoder, a.orientation), (b.tip, b.encoder, b.orientation), "{measure}, {i}");
            assert_eq!((a.fault, b.fault, a.status), (Fault::None, Fault::None, b.status), "{measure}, {i}");
            let fed = [0, 1, 2].map(|k| gauged.drive[k] - plain.drive[k]);
            // The tables are read at the actual axis position, infeed included: they differ there by less than 1e-4 of
            // the infeed.
            assert!(fed[0].abs() <= 1e-4 * INFEED && fed[2].abs() <= 1e-4 * INFEED, "{measure}, {i}: {fed:?}");
            if (i as i32) < FROM {
                assert_eq!(fed[1], 0.0, "{measure}, {i}");
            } else if i as i32 >= AT_REST {
                assert_eq!((a.limited, b.limited), (0, 0), "{measure}, {i}");
                assert!((fed[1] - INFEED).abs() < 1e-4 * INFEED, "{measure}, {i}: {}", fed[1]);
                let measured = *measure != "nothing";
                assert_eq!((a.tip.is_measured(), a.encoder.is_measured()), (measured, measured), "{measure}, {i}");
                let truth = if measured { DEVIATION } else { 0.0 };
                assert!((a.encoder.normal - truth).abs() < 1e-9, "{measure}, {i}: {:?}", a.encoder);
                assert_eq!(a.orientation_flags.has(Flags::NOT_FOUND), *measure != "tool path", "{measure}, {i}");
            }
        }
    }
}
