#![allow(clippy::indexing_slicing)]

use super::tool::{
    HEADS, Machine, PERIOD_NS, TABLES, V, Z, add, along, joints, norm, reference, settings, slanted, sub, tool_at,
    turned,
};
use crate::contour::{Path, Reference, Span, ToolPath};
use crate::kinematics::{BranchTracker, Tool};
use crate::machine::Axis;
use crate::position::{Nanometres, Position};
use crate::real::Real;
use crate::testing::noise::Noise;
use crate::vector::V3;
use crate::{Fault, Input, OnToolPath, Output, State};
use proptest::prelude::*;

/// Largest step of a rotary axis in a cycle, degrees.
const STEP_DEG: f64 = 0.1;

fn tool<R: Real>(tip: V, direction: V) -> Tool<R> {
    Tool { tip: V3::<R>::of(tip).glam(), axis: V3::<R>::of(direction).glam() }
}

/// A machine under RTCP whose drives follow their commands immediately.
struct Bench<R: Real, P: Position> {
    machine: Machine<R, P>,
    state: State<R, P, 5>,
    tracker: BranchTracker<R>,
    feedback: [P; 5],
    drive: Option<[f64; 5]>,
    /// Largest move of an axis per cycle: top feed with its factor, or the distance to the held position at a release.
    bound: [f64; 5],
}

impl<R: Real, P: Position> Bench<R, P> {
    /// At rest with the tip and the rotary axes at this pose.
    fn at_rest(machine: Machine<R, P>, tip: V, a: f64, c: f64) -> Self {
        let at = joints(machine.chain, tip, a, c);
        let [x, y, z, a, c] = at.map(R::of);
        let near = [x, y, z, a, R::ZERO, c];
        let start = machine.kinematics.inverse(&machine.kinematics.forward(&near), &near).unwrap();
        let state = machine.start();
        let feedback = at.map(P::of);
        let tracker = BranchTracker::new(&start, R::of(STEP_DEG));
        Bench {
            machine,
            state,
            tracker,
            feedback,
            drive: None,
            bound: [0.1 + 1e-6, 0.1 + 1e-6, 0.1 + 1e-6, 0.12, 0.12],
        }
    }

    fn cycle(&mut self, tool: &Tool<R>, reset: bool) -> Output<R, P, 5> {
        let (spans, turns) = slanted();
        let path = ToolPath::new(Path::new(&spans, 0, false), &turns);
        let none = Reference { span: 0, t: R::ZERO };
        self.on(tool, reset, &path, none)
    }

    fn on(&mut self, tool: &Tool<R>, reset: bool, path: &ToolPath<'_, R, P>, at: Reference<R>) -> Output<R, P, 5> {
        let input = Input { feedback: self.feedback, homed: true, enable: true, reset, ..Input::at_rest(PERIOD_NS) };
        let (servo, kinematics) = (self.machine.servo, &self.machine.kinematics);
        let input = servo.rtcp(&self.state, tool, &mut self.tracker, kinematics, &input);
        let out = servo.step(&mut self.state, &input, &mut OnToolPath::new(path, at, kinematics), ());
        let drive = out.drive.map(P::to_f64);
        if let Some(last) = self.drive {
            for k in 0..5 {
                assert!((drive[k] - last[k]).abs() <= self.bound[k], "axis {k} jumps: {} {}", last[k], drive[k]);
            }
        }
        self.drive = Some(drive);
        self.feedback = out.drive;
        out
    }
}

/// Along a slanted line with the direction turning: the drives get the closed-form positions.
fn follows_a_line<R: Real, P: Position>(permitted_mm: f64, permitted_deg: f64) {
    for chain in [TABLES, HEADS] {
        let (spans, turns) = slanted();
        let path = ToolPath::new(Path::new(&spans, 0, false), &turns);
        let (tip, a, c) = along(0.01);
        let mut bench = Bench::<R, P>::at_rest(Machine::perfect(chain), tip, a, c);
        for i in 0..4000 {
            let u = 0.01 + f64::from(i) * 2e-4;
            let (tip, a, c) = along(u);
            let out = bench.on(&tool(tip, turned(Z, a, c)), false, &path, reference(&spans, u));
            assert_eq!(out.record.fault, Fault::None);
            let truth = joints(chain, tip, a, c);
            for k in 0..5 {
                let permitted = if k < 3 { permitted_mm } else { permitted_deg };
                let off = (out.drive[k].to_f64() - truth[k]).abs();
                assert!(off < permitted, "{chain} {u} axis {k}: {off:e}");
            }
            // The reading of this cycle is the last command: a hundredth of a millimetre behind, on the path.
            if i > 200 {
                assert!(out.record.tip.error.to_f64() < 0.2e-3, "{chain} {u}: {:?}", out.record.tip);
                assert!(out.record.orientation.to_f64() < 2e-6);
            }
        }
    }
}

#[test]
fn follows_a_line_in_doubles() {
    follows_a_line::<f64, f64>(1e-9, 1e-9);
}

#[test]
fn follows_a_line_in_singles() {
    follows_a_line::<f32, Nanometres>(150e-6, 20e-6);
}

/// The tip stays on a path of one zero-length span while the direction turns by 50 degrees.
#[test]
fn the_tip_stays_while_the_tool_turns_about_it() {
    for chain in [TABLES, HEADS] {
        let tip = [12.0, 34.0, 5.0];
        let spans = [Span::turning(tip, 0, Z)];
        let turns = [crate::contour::Turn::axes(&spans[0], [0.0, 1.0], [5.0, 0.0, 0.0], [55.0, 0.0, 30.0])];
        let path = ToolPath::new(Path::new(&spans, 0, false), &turns);
        let mut bench = Bench::<f64, f64>::at_rest(Machine::perfect(chain), tip, 5.0, 0.0);
        for i in 0..10_000 {
            let s = f64::from(i) * 1e-4;
            let direction = turned(Z, 5.0 + 50.0 * s, 30.0 * s);
            let out = bench.on(&tool(tip, direction), false, &path, Reference { span: 0, t: s });
            assert_eq!(out.record.fault, Fault::None);
            let (reached, axis) = tool_at(chain, out.drive);
            assert!(norm(sub(reached, tip)) < 1e-10 && norm(sub(axis, direction)) < 1e-12);
            assert!(out.record.tip.error < 1e-9 && out.record.orientation < 2e-9, "{:?}", out.record);
        }
    }
}

/// Straight through the vertical with noise in the sixth decimal of every vector: A passes through, C and the tip do not
/// move.
fn goes_through_the_vertical<R: Real, P: Position>(permitted_mm: f64, permitted_deg: f64) {
    for chain in [TABLES, HEADS] {
        for (cone_deg, decimals) in [(0.1, 1e-6), (0.1, 0.0), (0.0, 0.0)] {
            let (mut noise, mut with) = (Noise::new(90), settings(chain));
            with.kinematics.singular_cone_deg = cone_deg;
            let (tip, c) = ([12.0, 34.0, 5.0], 20.0);
            let mut bench = Bench::<R, P>::at_rest(Machine::of(chain, with, |_| [0.0; 6]), tip, -2.0, c);
            for i in -200..=200 {
                let (a, by) = (0.01 * f64::from(i), noise.vector(decimals));
                let wanted = turned(Z, a, c);
                let asked: Tool<R> = tool(tip, add(wanted, by));
                let out = bench.cycle(&asked, false);
                assert_eq!(out.record.fault, Fault::None, "{chain} {cone_deg} {a}");
                let drive = out.drive.map(P::to_f64);
                // Outside the cone C follows the noise: 1e-6 over the sine of 0.05 degrees and more.
                assert!((drive[4] - c).abs() < 0.15 && (drive[3] - a).abs() < 3e-4, "{chain} {a}: {drive:?}");
                let (reached, axis) = tool_at(chain, drive);
                assert!(norm(sub(reached, tip)) < permitted_mm, "{chain} {a}: {reached:?}");
                let asked: V = asked.axis.into().map(R::to_f64);
                let off = norm(sub(axis, asked.map(|x| x / norm(asked)))).to_degrees();
                let left = bench.tracker.direction_error_deg().to_f64();
                assert!((off - left).abs() < permitted_deg && left < 1e-4, "{chain} {a}: {off} {left}");
            }
        }
    }
}

#[test]
fn the_tool_goes_through_the_vertical_in_doubles() {
    goes_through_the_vertical::<f64, f64>(1e-9, 1e-9);
}

#[test]
fn the_tool_goes_through_the_vertical_in_singles() {
    goes_through_the_vertical::<f32, Nanometres>(150e-6, 40e-6);
}

/// Into the vertical, and out of it sideways: the remaining angle is at most the cone, and C turns no faster than
/// permitted; if the path requires more, the output holds and the fault names C.
#[test]
fn out_of_the_vertical_aside_within_the_cone_and_the_step_or_held() {
    for chain in [TABLES, HEADS] {
        for (speed, passes) in [(1.5e-3, true), (4e-3, false)] {
            let mut with = settings(chain);
            with.kinematics.singular_cone_deg = 1.0;
            let (tip, mut s) = ([12.0, 34.0, 5.0], -3.0_f64);
            let mut bench = Bench::<f64, f64>::at_rest(Machine::of(chain, with, |_| [0.0; 6]), tip, 3.0, 20.0);
            let (mut fault, mut off) = ((Fault::None, 0), 0.0_f64);
            while s < 6.0 && fault.0 == Fault::None {
                let wanted = turned(Z, s.abs(), if s < 0.0 { 20.0 } else { 110.0 });
                let out = bench.cycle(&tool(tip, wanted), false);
                fault = (out.record.fault, out.record.fault_axis);
                if fault.0 == Fault::None {
                    let (reached, axis) = tool_at(chain, out.drive);
                    let left = norm(sub(axis, wanted)).to_degrees();
                    assert!(norm(sub(reached, tip)) < 1e-9, "{chain} {s}");
                    assert!(
                        (left - bench.tracker.direction_error_deg()).abs() < 1e-3 && left < 1.0,
                        "{chain} {s} {left}"
                    );
                    off = off.max(left);
                }
                s += speed;
            }
            assert_eq!(fault, if passes { (Fault::None, 0) } else { (Fault::CommandJump, 4) }, "{chain}");
            assert!(!passes || (bench.tracker.direction_error_deg() == 0.0 && off > 0.5), "{chain} {off}");
        }
    }
}

/// Every refusal: its code, output held, no release from afar or without the edge, release nearby, never a jump.
#[test]
fn a_tool_that_cannot_be_reached_holds_until_a_reset_near_the_held_pose() {
    let (tip, a, c) = ([25.0, -10.0, 12.0], 19.0, -15.0);
    let here = turned(Z, a, c);
    let nan = f64::NAN;
    let cases: [(Fault, u8, V, V); 8] = [
        (Fault::CommandNotFinite, 0, [nan, -10.0, 12.0], here),
        (Fault::CommandNotFinite, 0, [25.0, f64::INFINITY, 12.0], here),
        (Fault::CommandNotFinite, 0, tip, [0.0, nan, 1.0]),
        (Fault::CommandNotFinite, 0, tip, [0.0, f64::INFINITY, 1.0]),
        (Fault::ToolUnreachable, 0, tip, [0.0; 3]),
        (Fault::CommandJump, 4, tip, turned(Z, a, c + 1.0)),
        (Fault::CommandJump, 0, add(tip, [1.0, 0.0, 0.0]), here),
        (Fault::CommandOutOfTravel, 0, [3000.0, 0.0, 0.0], here),
    ];
    for (fault, axis, bad_tip, bad_direction) in cases {
        holds(Bench::at_rest(Machine::perfect(HEADS), tip, a, c), (fault, axis), tip, (a, c), bad_tip, bad_direction);
    }
    for chain in [TABLES, HEADS] {
        let a_of = |travel| {
            let mut narrow = settings(chain);
            narrow.axes.iter_mut().find(|axis| axis.axis == Axis::A).unwrap().travel = travel;
            Machine::of(chain, narrow, |_| [0.0; 6])
        };
        // A reaches its end: only the other branch continues, with C turned by 180 degrees.
        let bench = Bench::at_rest(a_of([-180.0, 19.05]), tip, a, c);
        holds(bench, (Fault::BranchChange, 0), tip, (a, c), tip, turned(Z, a + 0.08, c));
        // A starts so far from the pole that the tool cannot be held within the cone.
        let bench = Bench::at_rest(a_of([0.05, 90.0]), tip, 0.06, c);
        holds(bench, (Fault::SingularPose, 0), tip, (0.06, c), tip, turned(Z, -0.06, c));
    }
}

/// A tool mounted 37 degrees off in the spindle cannot be set upright by A and C.
#[test]
fn a_direction_out_of_reach_holds() {
    let mut tilted = settings(HEADS);
    tilted.kinematics.tool_axis = [0.6, 0.0, 0.8];
    let machine = Machine::<f64, f64>::of(HEADS, tilted, |_| [0.0; 6]);
    let at = [10.0, 20.0, 30.0, 40.0, 0.0, -15.0];
    let good = machine.kinematics.forward(&at);
    let start = machine.kinematics.inverse(&good, &at).unwrap();
    let mut bench = Bench::at_rest(Machine::perfect(HEADS), [0.0; 3], 40.0, -15.0);
    let [x, y, z, a, _, c] = start.axes;
    (bench.machine, bench.tracker, bench.feedback) = (machine, BranchTracker::new(&start, STEP_DEG), [x, y, z, a, c]);
    let held = bench.cycle(&good, false);
    let out = bench.cycle(&Tool { axis: Z.into(), ..good }, false);
    assert_eq!(out.record.fault, Fault::ToolUnreachable);
    assert_eq!(out.drive, held.drive);
    let out = bench.cycle(&good, true);
    assert_eq!((out.record.fault, out.drive), (Fault::None, held.drive));
}

fn holds(
    mut bench: Bench<f64, f64>,
    (fault, axis): (Fault, u8),
    tip: V,
    (a, c): (f64, f64),
    bad_tip: V,
    bad_direction: V,
) {
    let good = tool(tip, turned(Z, a, c));
    let mut before = bench.cycle(&good, false);
    for _ in 0..10 {
        before = bench.cycle(&good, false);
        assert_eq!(before.record.fault, Fault::None);
    }
    let pose = *bench.tracker.axes();
    let bad = tool(bad_tip, bad_direction);
    let out = bench.cycle(&bad, false);
    assert_eq!((out.record.fault, out.record.fault_axis), (fault, axis));
    assert!(out.stop_requested());
    assert_eq!(out.drive, before.drive);
    // A reset is not accepted while the tool is out of reach …
    assert!(bench.cycle(&bad, true).stop_requested());
    assert!(bench.cycle(&bad, false).stop_requested());
    // … nor is a good tool without a reset, or one far away; the tracker stays at the held pose.
    assert_eq!(bench.cycle(&good, false).drive, before.drive);
    let away = tool(add(tip, [0.2, 0.0, 0.0]), turned(Z, a, c));
    assert!(bench.cycle(&away, true).stop_requested());
    for k in 0..50 {
        let wandering = tool(add(tip, [0.01 * f64::from(k), 0.0, 0.0]), turned(Z, a + 0.05 * f64::from(k), c));
        let out = bench.cycle(&wandering, false);
        assert_eq!((out.record.fault, out.drive), (fault, before.drive));
        let mut tracker = bench.tracker;
        tracker.take_back();
        assert_eq!(*tracker.axes(), pose);
    }
    let near = tool(add(tip, [0.03, 0.0, 0.0]), turned(Z, a + 0.01, c));
    let out = bench.cycle(&near, true);
    assert_eq!(out.record.fault, Fault::None);
    assert!(!out.stop_requested());
    assert!((out.drive[3] - before.drive[3] - 0.01).abs() < 1e-9);
    let out = bench.cycle(&near, false);
    assert!(!out.stop_requested() && out.drive != before.drive);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: crate::testing::share::share(2000) as u32, ..ProptestConfig::default() })]

    /// Any tools: no panic, finite drives that never jump, held drives that never move.
    #[test]
    fn no_sequence_of_tools_makes_a_drive_jump(
        cycles in prop::collection::vec((any::<u64>(), prop::array::uniform3(-1.0..1.0f64), any::<u8>()), 60),
    ) {
        let (mut tip, mut a, mut c) = ([25.0, -10.0, 12.0], 19.0, -15.0);
        let mut bench = Bench::<f64, f64>::at_rest(Machine::perfect(TABLES), tip, a, c);
        let mut last: Option<Output<f64, f64, 5>> = None;
        for (any, [x, y, z], bits) in cycles {
            let mut wanted: Tool<f64> = tool(tip, turned(Z, a, c));
            match bits & 7 {
                0 => wanted.tip.x = f64::from_bits(any),
                1 => wanted.axis.y = f64::from_bits(any),
                2 => wanted = tool([900.0 * x, 900.0 * y, 900.0 * z], [x, y, z]),
                3 => wanted.axis *= 1.0 + x,
                _ => {
                    tip = add(tip, [0.02 * x, 0.02 * y, 0.02 * z]);
                    (a, c) = (a + 0.03 * x, c + 0.03 * y);
                    wanted = tool(tip, turned(Z, a, c));
                }
            }
            let out = bench.cycle(&wanted, bits & 64 != 0);
            prop_assert!(out.drive.iter().all(|x| x.is_finite()));
            prop_assert!(out.record.orientation.is_finite());
            if let Some(last) = last {
                prop_assert!(!out.stop_requested() || out.drive == last.drive);
            }
            if !out.stop_requested() {
                // The interpolator continues from the machine's pose.
                let at = bench.tracker.axes();
                let reached = bench.machine.kinematics.forward(at);
                (tip, a, c) = (reached.tip.to_array(), at[Axis::A.index()], at[Axis::C.index()]);
            }
            last = Some(out);
        }
    }
}
