//! Kinematics, tool paths and tool positions through the C interface.

use crate::machines::*;
use std::ptr::{null, null_mut};
use std::sync::OnceLock;
use trueaxis_capi::*;
use trueaxis_tables::compile;

const AT: [f64; 5] = [10.0, 20.0, -100.0, 20.0, 5.0];

fn five() -> &'static [u8] {
    static FILE: OnceLock<Vec<u8>> = OnceLock::new();
    FILE.get_or_init(|| compile(&small_five()).unwrap())
}

/// Its loop, built once for all tests: Miri takes seconds for that.
fn five_loop() -> &'static BuiltLoop {
    static BUILT: OnceLock<BuiltLoop> = OnceLock::new();
    BUILT.get_or_init(|| built(five()))
}

fn kinematics(file: &[u8]) -> Box<Kinematics> {
    let mut kinematics = zeroed::<Kinematics>();
    let (size, bytes, length) = (size_of::<Kinematics>(), file.as_ptr(), file.len());
    // SAFETY: all pointers and sizes match their types.
    assert_eq!(unsafe { trueaxis_kinematics_build(&mut *kinematics, size, bytes, length, null_mut()) }, OK);
    kinematics
}

fn forward(kinematics: &Kinematics, axes: &[f64]) -> Tool {
    let mut tool = Tool::default();
    // SAFETY: all pointers and sizes match their types.
    assert_eq!(unsafe { trueaxis_kinematics_forward(kinematics, axes.as_ptr(), &mut tool) }, OK);
    tool
}

fn tracker(kinematics: &Kinematics, axes: &[f64]) -> Box<BranchTracker> {
    let mut tracker = zeroed::<BranchTracker>();
    let (size, axes) = (size_of::<BranchTracker>(), axes.as_ptr());
    // SAFETY: all pointers and sizes match their types.
    assert_eq!(unsafe { trueaxis_branch_tracker_start(&mut *tracker, size, kinematics, axes, 1.0, null_mut()) }, OK);
    tracker
}

#[test]
fn the_tool_is_where_its_axes_put_it() {
    let mut kinematics = kinematics(five());
    let upright = forward(&kinematics, &[10.0, 20.0, -100.0, 0.0, 0.0]);
    assert_eq!((upright.tip, upright.axis), ([10.0, 20.0, -100.0], [0.0, 0.0, 1.0]));
    let tool = [0.0, 0.0, -50.0];
    // SAFETY: all pointers and sizes match their types.
    assert_eq!(unsafe { trueaxis_kinematics_set_tool(&mut *kinematics, tool.as_ptr()) }, OK);
    assert_eq!(forward(&kinematics, &[10.0, 20.0, -100.0, 0.0, 0.0]).tip, [10.0, 20.0, -150.0]);
    // Axes C and A turn the workpiece; the direction remains a unit vector.
    let [x, y, z] = forward(&kinematics, &AT).axis.map(|x| f64::from(x as f32));
    assert!((x * x + y * y + z * z - 1.0).abs() < 1e-6 && (z - 20f64.to_radians().cos()).abs() < 1e-6);
}

#[test]
fn a_tool_out_of_reach_is_refused_in_the_step() {
    let (servo, kinematics) = (five_loop(), kinematics(five()));
    let mut state = started(&servo.servo);
    let mut tracker = tracker(&kinematics, &AT);
    let mut out = output();
    let here = forward(&kinematics, &AT);
    let mut cycle = |tool: &Tool, reset| {
        let mut c = input([0.0; 6], [AT[0], AT[1], AT[2], AT[3], AT[4], 0.0]);
        c.reset = reset;
        // SAFETY: all pointers and sizes match their types.
        unsafe {
            assert_eq!(trueaxis_rtcp(&*servo.servo, &*state, tool, &mut *tracker, &*kinematics, &mut c), OK);
            assert_eq!(trueaxis_step(&*servo.servo, &mut *state, &c, null_mut(), null_mut(), &mut out), OK);
        }
        (c.refusal, out.record.fault, out.record.status & STATUS_STOP_REQUEST != 0, out.drive)
    };
    for (bad, expected) in [
        (Tool { tip: [Real::NAN, 0.0, 0.0], ..here }, FAULT_COMMAND_NOT_FINITE),
        (Tool { axis: [0.0; 3], ..here }, FAULT_TOOL_UNREACHABLE),
        (Tool { tip: [3000.0, 0.0, 0.0], ..here }, FAULT_COMMAND_OUT_OF_TRAVEL),
    ] {
        let (refusal, fault, stop, before) = cycle(&here, 0);
        assert_eq!((refusal, fault, stop), (0, FAULT_NONE, false));
        let (refusal, fault, stop, drive) = cycle(&bad, 0);
        assert_eq!((refusal, fault, stop, drive), (expected, expected, true, before));
        // The refusal is not kept; the stop is, until the reset.
        let (refusal, _, stop, drive) = cycle(&here, 0);
        assert_eq!((refusal, stop, drive), (0, true, before));
        let (_, fault, stop, _) = cycle(&here, 1);
        assert_eq!((fault, stop), (FAULT_NONE, false));
    }
}

/// A moves from −2 to 2 degrees, under Miri next to the vertical only: nothing is refused, C stays, and the direction error
/// is reported.
#[test]
fn the_tool_goes_through_the_vertical() {
    let (servo, kinematics) = (five_loop(), kinematics(five()));
    let mut state = started(&servo.servo);
    let cycles: i32 = if cfg!(miri) { 2 } else { 200 };
    let from = [10.0, 20.0, -100.0, -0.01 * f64::from(cycles), 5.0];
    let mut tracker = tracker(&kinematics, &from);
    let (mut out, mut most) = (output(), 0.0_f64);
    let mut c = input([0.0; 6], [from[0], from[1], from[2], from[3], from[4], 0.0]);
    let tip = forward(&kinematics, &from).tip;
    for i in -cycles..=cycles {
        let mut tool = Tool { tip, ..forward(&kinematics, &[0.0, 0.0, 0.0, 0.01 * f64::from(i), 5.0]) };
        // Disturbs the sixth decimal, at right angles to the plane in which A turns the tool.
        tool.axis[0] += 1e-6 * [1.0, -1.0, 0.0][i.rem_euclid(3) as usize];
        let mut left = Real::NAN;
        // SAFETY: all pointers and sizes match their types.
        unsafe {
            assert_eq!(trueaxis_rtcp(&*servo.servo, &*state, &tool, &mut *tracker, &*kinematics, &mut c), OK);
            assert_eq!(trueaxis_branch_tracker_direction_error(&*tracker, &mut left), OK);
            assert_eq!(trueaxis_step(&*servo.servo, &mut *state, &c, null_mut(), null_mut(), &mut out), OK);
        }
        assert_eq!((c.refusal, out.record.fault), (0, FAULT_NONE), "{i}");
        let near = |k: usize, at: f64, most: f64| (c.command[k] - position(at)).abs() < position(most);
        assert!(near(4, 5.0, 0.1) && near(3, 0.01 * f64::from(i), 1e-3), "{i}: {:?}", c.command);
        c.feedback = c.command;
        most = most.max(f64::from(left as f32));
    }
    assert!(most > 1e-5 && most < 1e-4, "{most}");
}

#[test]
fn kinematics_are_checked() {
    let (three, five_axes) = (kinematics(mill()), kinematics(five()));
    let mut nothing = zeroed::<Kinematics>();
    let mut spare = vec![0_u64; 512];
    let odd = spare.as_mut_ptr().wrapping_byte_add(1);
    let (size, bytes, length) = (size_of::<Kinematics>(), five().as_ptr(), five().len());
    let (mut tool, mut tracker_) = (Tool::default(), zeroed::<BranchTracker>());
    let nothing: *mut Kinematics = &mut *nothing;
    let mut error = error();
    let far = [f64::NAN; 5];
    let tracker_: *mut BranchTracker = &mut *tracker_;
    let tracker_size = size_of::<BranchTracker>();
    // SAFETY: invalid arguments are null, misaligned, zeroed, or have a wrong size stated.
    unsafe {
        let build = |to, size, bytes, length| trueaxis_kinematics_build(to, size, bytes, length, null_mut());
        assert_eq!(build(null_mut(), size, bytes, length), ERROR_NULL);
        assert_eq!(build(odd.cast(), size, bytes, length), ERROR_ALIGNMENT);
        assert_eq!(build(nothing, size - 8, bytes, length), ERROR_SIZE);
        assert_eq!(build(nothing, size, null(), length), ERROR_NULL);
        assert_eq!(build(nothing, size, bytes, length - 1), ERROR_TABLES);
        assert_eq!(trueaxis_kinematics_set_tool(nothing, AT.as_ptr()), ERROR_UNBUILT);
        assert_eq!(trueaxis_kinematics_forward(nothing, AT.as_ptr(), &mut tool), ERROR_UNBUILT);
        assert_eq!(trueaxis_kinematics_forward(&*five_axes, null(), &mut tool), ERROR_NULL);
        assert_eq!(trueaxis_kinematics_forward(&*five_axes, odd.cast(), &mut tool), ERROR_ALIGNMENT);
        assert_eq!(trueaxis_kinematics_forward(&*five_axes, AT.as_ptr(), null_mut()), ERROR_NULL);
        assert_eq!(trueaxis_kinematics_forward(&*five_axes, far.as_ptr(), &mut tool), ERROR_ARGUMENT);
        assert_eq!((tool.tip, tool.axis), ([0.0; 3], [0.0; 3]));
        let start = |to, size, from: *const f64, step, error| {
            trueaxis_branch_tracker_start(to, size, &*five_axes, from, step, error)
        };
        assert_eq!(start(null_mut(), tracker_size, AT.as_ptr(), 1.0, null_mut()), ERROR_NULL);
        assert_eq!(start(tracker_, tracker_size + 8, AT.as_ptr(), 1.0, null_mut()), ERROR_SIZE);
        assert_eq!(start(tracker_, tracker_size, far.as_ptr(), 1.0, null_mut()), ERROR_ARGUMENT);
        assert_eq!(start(tracker_, tracker_size, AT.as_ptr(), 0.0, null_mut()), ERROR_ARGUMENT);
        let mut left = Real::NAN;
        assert_eq!(trueaxis_branch_tracker_direction_error(tracker_, &mut left), ERROR_UNBUILT);
        assert_eq!(trueaxis_branch_tracker_direction_error(tracker_, null_mut()), ERROR_NULL);
        assert!(left.is_nan());
        let beyond = [900.0, 0.0, 0.0, 20.0, 0.0];
        assert_eq!(start(tracker_, tracker_size, beyond.as_ptr(), 1.0, &mut error), ERROR_POSE);
        let said = text(&error.text);
        assert!(said.starts_with("pose: axis X: found ") && said.contains("needed the travel"), "{said}");
    }
    // Cycles of other machines, of another kind, and in a bypass.
    let servo = five_loop();
    let mut state = started(&servo.servo);
    let mut bypass = zeroed::<Loop>();
    let loop_size = size_of::<Loop>();
    let good = input([AT[0], AT[1], AT[2], AT[3], AT[4], 0.0], [AT[0], AT[1], AT[2], AT[3], AT[4], 0.0]);
    let mut c = good;
    let mut tracker = tracker(&five_axes, &AT);
    let tracker: *mut BranchTracker = &mut *tracker;
    let tool = forward(&five_axes, &AT);
    let path = Programmed::of_tool(4, 0);
    let mut out = output();
    // SAFETY: as above.
    unsafe {
        assert_eq!(trueaxis_loop_bypass(&mut *bypass, loop_size, 5, FAULT_TABLES_REFUSED, PERIOD_NS), OK);
        let passing = started(&bypass);
        let (loop_, on, its): (*const Loop, *const State, *const Kinematics) = (&*servo.servo, &*state, &*five_axes);
        let mut rtcp = |loop_, state, tool, tracker, kinematics| {
            let result = trueaxis_rtcp(loop_, state, tool, tracker, kinematics, &mut c);
            assert_eq!((c.refusal, c.command), (0, good.command));
            result
        };
        assert_eq!(rtcp(&*bypass, &*passing, &tool, tracker, its), ERROR_STATE);
        assert_eq!(rtcp(loop_, &*passing, &tool, tracker, its), ERROR_STATE);
        assert_eq!(rtcp(loop_, on, &tool, tracker, &*three), ERROR_MACHINE);
        assert_eq!(rtcp(loop_, on, &tool, tracker, nothing), ERROR_UNBUILT);
        assert_eq!(rtcp(loop_, on, &tool, tracker_, its), ERROR_UNBUILT);
        assert_eq!(rtcp(loop_, on, null(), tracker, its), ERROR_NULL);
        assert_eq!(rtcp(loop_, on, odd.cast(), tracker, its), ERROR_ALIGNMENT);
        assert_eq!(rtcp(null(), on, &tool, tracker, its), ERROR_NULL);
        let short = &mut Input { size: good.size - 8, ..good };
        assert_eq!(trueaxis_rtcp(loop_, on, &tool, tracker, its, short), ERROR_SIZE);
        for (expected, mut against) in [
            (ERROR_MACHINE, Measure { path: &*path.path, kinematics: &*three, ..measure(MEASURE_TOOL) }),
            (ERROR_UNBUILT, Measure { path: &*path.path, kinematics: nothing, ..measure(MEASURE_TOOL) }),
            (ERROR_UNBUILT, Measure { path: its.cast(), kinematics: its, ..measure(MEASURE_TOOL) }),
            (ERROR_NULL, Measure { path: &*path.path, ..measure(MEASURE_TOOL) }),
            (ERROR_NULL, Measure { kinematics: its, ..measure(MEASURE_TOOL) }),
            (ERROR_ALIGNMENT, Measure { kinematics: odd.cast(), path: &*path.path, ..measure(MEASURE_TOOL) }),
            (ERROR_NULL, measure(MEASURE_PATH)),
            (ERROR_ALIGNMENT, Measure { path: odd.cast(), ..measure(MEASURE_PATH) }),
            (ERROR_NULL, measure(MEASURE_COMMANDS)),
            (ERROR_UNBUILT, Measure { window: spare.as_mut_ptr().cast(), ..measure(MEASURE_COMMANDS) }),
            (ERROR_ALIGNMENT, Measure { window: odd.cast(), ..measure(MEASURE_COMMANDS) }),
            (ERROR_ARGUMENT, measure(4)),
            (ERROR_SIZE, Measure { size: 8, ..measure(MEASURE_NOTHING) }),
        ] {
            let result = trueaxis_step(loop_, &mut *state, &good, &mut against, null_mut(), &mut out);
            assert_eq!((result, against.direction_error, out.axes), (expected, [9.0; 3], 0), "{}", against.kind);
        }
    }
}

#[test]
fn directions_go_with_tool_paths_only() {
    let (mut plain, mut of_tool) = (Programmed::new(8, 0), Programmed::of_tool(8, 0));
    let (zero, turned, up, down) = ([0.0; 3], [10.0, 0.0, 20.0], [0.0, 0.0, 2.0], [0.0, 0.0, -1.0]);
    let nan = [f64::NAN, 0.0, 0.0];
    let mut error = error();
    // SAFETY: invalid arguments are null or a wrong number.
    unsafe {
        let (plain, path) = (&raw mut *plain.path, &raw mut *of_tool.path);
        let [zero, turned, up, down, nan] = [&zero, &turned, &up, &down, &nan].map(|v| v.as_ptr());
        assert_eq!(trueaxis_path_axes(plain, zero, turned), ERROR_ARGUMENT);
        assert_eq!(trueaxis_path_directions(plain, up, up), ERROR_ARGUMENT);
        assert_eq!(trueaxis_path_turning(plain, zero, &mut error), ERROR_ARGUMENT);
        assert_eq!(trueaxis_path_axes(path, zero, nan), ERROR_ARGUMENT);
        assert_eq!(trueaxis_path_axes(path, null(), zero), ERROR_NULL);
        assert_eq!(trueaxis_path_directions(path, up, down), ERROR_ARGUMENT);
        assert_eq!(trueaxis_path_directions(path, zero, up), ERROR_ARGUMENT);
        assert_eq!(trueaxis_path_directions(path, up, null()), ERROR_NULL);
        assert_eq!(trueaxis_path_turning(path, nan, &mut error), ERROR_PATH);
        assert_eq!(trueaxis_path_axes(path, zero, turned), OK);
        assert_eq!(trueaxis_path_turning(path, zero, null_mut()), OK);
        let far = [1.0, 1.0, 0.0];
        assert_eq!(trueaxis_path_turning(path, far.as_ptr(), &mut error), ERROR_PATH, "it stands elsewhere");
    }
    assert_eq!(of_tool.line([0.0; 3], [100.0, 0.0, 0.0]), OK);
    assert_eq!(of_tool.count(), (2, 8));
    assert_eq!(of_tool.line([100.0, 0.0, 0.0], [110.0, 0.0, 0.0]), ERROR_MEMORY);
    assert_eq!(of_tool.reference(1, 1.0).unwrap().span, 7);
}
