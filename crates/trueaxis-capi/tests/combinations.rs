//! Every measure with and without a gauge, through C and through Rust: the results are equal in every bit.

use crate::machines::gauge::{Gauges, probes, same_cycle, small_gauge, with_gauge};
use crate::machines::rust::*;
use crate::machines::*;
use std::ptr::{null, null_mut};
use trueaxis::contour::{self, PathBuilder, Segment, ToolPath, Turn};
use trueaxis::kinematics::{self, BranchTracker as CoreTracker};
use trueaxis::roundness::Gauge as CoreGauge;
use trueaxis::tcomp::Tcomp;
use trueaxis::{GaugeRide as CoreRide, OnToolPath, ServoLoop};
use trueaxis_capi::*;

const POINTS: usize = 512;
const KINDS: [u32; 4] = [MEASURE_NOTHING, MEASURE_PATH, MEASURE_COMMANDS, MEASURE_TOOL];
/// Axes at the start and the end of the motion, X Y Z A C.
const FROM: [f64; 5] = [10.0, 20.0, -100.0, 20.0, 5.0];
const TO: [f64; 5] = [50.0, 35.0, -90.0, 35.0, 25.0];
/// Number of cycles of the motion. The tool lags by `LAG` cycles.
const CYCLES: usize = if cfg!(miri) { 3 } else { 8000 };
const LAG: usize = if cfg!(miri) { 2 } else { 10 };
const STEP_DEG: f64 = 0.1;

fn between(a: &[f64], b: &[f64], u: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + (b - a) * u).collect()
}

/// One machine, with the C and the Rust side of every argument of a step.
struct Bench<const N: usize> {
    c: BuiltLoop,
    rust: ServoLoop<'static, R, P, N>,
    path: Programmed,
    spans: Vec<contour::Span<R, P>>,
    turns: Vec<Turn<R>>,
    kinematics: Box<Kinematics>,
    core_kinematics: kinematics::Kinematics<R>,
    window: Box<CommandWindow>,
    gauges: Gauges,
    core_gauge: Box<CoreGauge<R, POINTS>>,
    slots: Vec<usize>,
}

impl<const N: usize> Bench<N> {
    fn new(file: &[u8]) -> Self {
        let tables = Tcomp::parse(file).unwrap();
        let settings = tables.settings();
        let exact = kinematics::Kinematics::<f64>::new(settings).unwrap();
        let slots = if N == 3 { vec![0, 1, 2] } else { vec![0, 1, 2, 3, 5] };
        let tip = |axes: &[f64; 5]| <[f64; 3]>::from(exact.forward(&joints(&slots, &axes[..N])).tip);
        let (start, end) = (tip(&FROM), tip(&TO));
        // A, B, C; on a machine without rotary axes nothing turns.
        let [turn_from, turn_to] = [FROM, TO].map(|axes| if N == 3 { [0.0; 3] } else { [axes[3], 0.0, axes[4]] });
        let mut path = Programmed::of_tool(16, 3);
        let mut kinematics = zeroed::<Kinematics>();
        // SAFETY: all pointers and sizes match their types.
        unsafe {
            assert_eq!(trueaxis_path_axes(&mut *path.path, turn_from.as_ptr(), turn_to.as_ptr()), OK);
            let size = size_of::<Kinematics>();
            let (bytes, length) = (file.as_ptr(), file.len());
            assert_eq!(trueaxis_kinematics_build(&mut *kinematics, size, bytes, length, null_mut()), OK);
        }
        assert_eq!(path.line(start, end), OK);
        let (mut spans, mut turns) = (Vec::new(), Vec::new());
        let line = Segment::Line { start: start.into(), end: end.into() };
        PathBuilder::<P>::new()
            .append::<R>(&line, |span| {
                turns.push(Turn::axes(&span, [0.0, 1.0], turn_from, turn_to));
                spans.push(span);
                Ok(())
            })
            .unwrap();
        Bench {
            c: built(file),
            rust: rust_loop(file),
            path,
            spans,
            turns,
            kinematics,
            core_kinematics: kinematics::Kinematics::new(settings).unwrap(),
            window: zeroed(),
            gauges: Gauges::new(file, POINTS),
            core_gauge: Box::new(CoreGauge::build(settings.roundness.as_ref().unwrap(), PERIOD_NS).unwrap()),
            slots,
        }
    }

    fn tool(&self, u: f64) -> kinematics::Tool<R> {
        let tip = |axes: &[f64]| self.core_kinematics.forward(&joints(&self.slots, axes).map(|x| x as R)).tip;
        let (start, end) = (tip(&FROM[..N]), tip(&TO[..N]));
        let pose = joints(&self.slots, &between(&FROM[..N], &TO[..N], u)).map(|x| x as R);
        kinematics::Tool { tip: start + (end - start) * (u as R), axis: self.core_kinematics.direction(&pose) }
    }

    /// Runs all cycles of a combination. Returns how many measured a contour error, and whether the gauge fed anything
    /// in.
    fn run(&mut self, kind: u32, with_gauge: bool) -> (usize, bool) {
        let (mut state, mut core_state) = (started(&self.c.servo), self.rust.start());
        let mut tracker = zeroed::<BranchTracker>();
        let core_start = joints(&self.slots, &FROM[..N]).map(|x| x as R);
        let core_tool = self.core_kinematics.forward(&core_start);
        let solution = self.core_kinematics.inverse(&core_tool, &core_start).unwrap();
        let mut core_tracker = CoreTracker::new(&solution, STEP_DEG as R);
        self.gauges.restart();
        let mut core_gauge_state = Box::new(self.core_gauge.start());
        let mut core_window =
            Box::new(contour::CommandWindow::<R, P, COMMAND_WINDOW_SPANS>::new([0.0, 0.0, 1.0], 0.005).unwrap());
        let window: *mut CommandWindow = &mut *self.window;
        // SAFETY: all pointers and sizes match their types.
        unsafe {
            assert_eq!(trueaxis_command_window_start(window, size_of::<CommandWindow>(), null(), 0.005), OK);
            let (size, from) = (size_of::<BranchTracker>(), FROM.as_ptr());
            let result =
                trueaxis_branch_tracker_start(&mut *tracker, size, &*self.kinematics, from, STEP_DEG, null_mut());
            assert_eq!(result, OK);
        }
        let core_path = contour::Path::new(&self.spans, 3, false);
        let core_tool_path = ToolPath::new(core_path, &self.turns);
        let (mut out, mut measured, mut fed) = (output(), 0, false);
        let mut drives = vec![position_of(&FROM[..N]); LAG];
        for cycle in 0..CYCLES {
            let u = cycle as f64 / 8000.0;
            let command = between(&FROM[..N], &TO[..N], u);
            let mut c = input(padded(&command), [0.0; 6]);
            c.feedback = drives[cycle % LAG];
            let mut core = core_input::<N>(&c);
            if kind == MEASURE_TOOL {
                // RTCP computes the command from the tool.
                let tool = self.tool(u);
                let tool_c = Tool { tip: tool.tip.into(), axis: tool.axis.into() };
                core = self.rust.rtcp(&core_state, &tool, &mut core_tracker, &self.core_kinematics, &core);
                // SAFETY: all pointers and sizes match their types.
                let result = unsafe {
                    trueaxis_rtcp(&*self.c.servo, &*state, &tool_c, &mut *tracker, &*self.kinematics, &mut c)
                };
                assert_eq!(result, OK);
                assert_eq!(c.command[..N], position_bits(&core.command)[..], "cycle {cycle}");
            }
            let reference = self.path.reference(0, u).unwrap();
            let at = contour::Reference { span: reference.span, t: reference.t };
            let (path, kinematics) = (&raw const *self.path.path, &raw const *self.kinematics);
            let mut against = Measure { path, reference, window, kinematics, ..measure(kind) };
            let mut ride = self.gauges.ride(cycle as i32, POINTS as i32);
            // `MEASURE_NOTHING` and a null pointer have the same effect.
            let measure: *mut Measure = if kind == MEASURE_NOTHING && with_gauge { null_mut() } else { &mut against };
            let gauge: *mut GaugeRide = if with_gauge { &mut ride } else { null_mut() };
            // SAFETY: all pointers and sizes match their types.
            let result = unsafe { trueaxis_step(&*self.c.servo, &mut *state, &c, measure, gauge, &mut out) };
            assert_eq!(result, OK);
            drives[cycle % LAG] = out.drive;

            let given = probes(&ride);
            let mut core_ride = CoreRide::new(&self.core_gauge, &mut core_gauge_state, &given);
            let mut on_tool = OnToolPath::new(&core_tool_path, at, &self.core_kinematics);
            let (servo, state) = (&self.rust, &mut core_state);
            let expected = match (kind, with_gauge) {
                (MEASURE_NOTHING, false) => servo.step(state, &core, (), ()),
                (MEASURE_NOTHING, true) => servo.step(state, &core, (), &mut core_ride),
                (MEASURE_PATH, false) => servo.step(state, &core, core_path.on(at), ()),
                (MEASURE_PATH, true) => servo.step(state, &core, core_path.on(at), &mut core_ride),
                (MEASURE_COMMANDS, false) => servo.step(state, &core, &mut *core_window, ()),
                (MEASURE_COMMANDS, true) => servo.step(state, &core, &mut *core_window, &mut core_ride),
                (_, false) => servo.step(state, &core, &mut on_tool, ()),
                (_, true) => servo.step(state, &core, &mut on_tool, &mut core_ride),
            };
            same(&out, &expected, cycle);
            if with_gauge {
                same_cycle(&ride, &core_ride.cycle(), cycle);
                fed |= ride.infeed != 0.0;
            }
            if kind == MEASURE_TOOL {
                let vector: [R; 3] = on_tool.orientation().vector.into();
                assert_eq!(against.direction_error.map(R::to_bits), vector.map(R::to_bits), "cycle {cycle}");
            } else {
                assert_eq!(against.direction_error, [9.0; 3], "not written");
            }
            assert_eq!(out.record.fault, FAULT_NONE, "cycle {cycle}");
            measured += usize::from(out.record.status & STATUS_CONTOUR != 0);
        }
        (measured, fed)
    }

    fn all(&mut self) {
        for kind in KINDS {
            for with_gauge in [false, true] {
                let (measured, fed) = self.run(kind, with_gauge);
                // Five axes are far from the tool's path, and the foot is lost again and again.
                let least = if N == 5 && kind == MEASURE_PATH { CYCLES / 4 } else { CYCLES.saturating_sub(60) };
                assert!(kind == MEASURE_NOTHING || measured >= least, "{kind}: {measured} of {CYCLES}");
                assert!(kind != MEASURE_NOTHING || measured == 0);
                assert_eq!(fed, with_gauge && !cfg!(miri), "{kind}");
            }
        }
    }
}

/// Positions of the step's axes in the order X Y Z A B C.
fn joints(slots: &[usize], axes: &[f64]) -> [f64; 6] {
    let mut joints = [0.0; 6];
    for (slot, x) in slots.iter().zip(axes) {
        joints[*slot] = *x;
    }
    joints
}

fn padded(axes: &[f64]) -> [f64; AXES_MAX] {
    let mut all = [0.0; AXES_MAX];
    all[..axes.len()].copy_from_slice(axes);
    all
}

fn position_of(axes: &[f64]) -> [Position; AXES_MAX] {
    padded(axes).map(position)
}

fn position_bits<const N: usize>(core: &[P; N]) -> [Position; N] {
    #[cfg(not(feature = "single"))]
    return *core;
    #[cfg(feature = "single")]
    return core.map(|x| x.0);
}

#[test]
fn three_axes() {
    let mut bench = Bench::<3>::new(small_gauge());
    bench.all();
    a_bypass_takes_every_measure(&mut bench);
}

#[test]
#[cfg_attr(miri, ignore)]
fn five_axes() {
    Bench::<5>::new(&with_gauge(small_five(), POINTS as u16)).all();
}

#[test]
fn five_axes_in_short() {
    let mut bench = Bench::<5>::new(&with_gauge(small_five(), POINTS as u16));
    bench.run(MEASURE_TOOL, true);
}

/// A bypass measures nothing, whatever measure is passed.
fn a_bypass_takes_every_measure(bench: &mut Bench<3>) {
    let mut bypass = zeroed::<Loop>();
    let size = size_of::<Loop>();
    // SAFETY: all pointers and sizes match their types.
    assert_eq!(unsafe { trueaxis_loop_bypass(&mut *bypass, size, 3, FAULT_TABLES_REFUSED, PERIOD_NS) }, OK);
    let mut state = started(&bypass);
    let window: *mut CommandWindow = &mut *bench.window;
    // SAFETY: all pointers and sizes match their types.
    assert_eq!(unsafe { trueaxis_command_window_start(window, size_of::<CommandWindow>(), null(), 0.005) }, OK);
    let (path, kinematics) = (&raw const *bench.path.path, &raw const *bench.kinematics);
    let mut out = output();
    for kind in KINDS {
        let at = input(padded(&FROM[..3]), padded(&FROM[..3]));
        let mut against =
            Measure { path, reference: Reference { span: 3, t: 0.0 }, window, kinematics, ..measure(kind) };
        let mut ride = bench.gauges.ride(0, POINTS as i32);
        // SAFETY: all pointers and sizes match their types.
        let result = unsafe { trueaxis_step(&*bypass, &mut *state, &at, &mut against, &mut ride, &mut out) };
        assert_eq!((result, out.record.status & STATUS_CONTOUR, ride.infeed), (OK, 0, 0.0), "{kind}");
        assert_eq!(out.drive[..3], at.command[..3]);
    }
}
