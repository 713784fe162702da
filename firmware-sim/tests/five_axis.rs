//! Programs with rotary axes: words, feeds, tool centre point, and residual errors of compensation on five axes.

use firmware_sim::samples::sample_machine;
use glam::{DMat3, DVec3};
use serde_json::Value;
use trueaxis_sim::motion::{Motion, MotionSettings};
use trueaxis_sim::path::PlannedPath;
use trueaxis_sim::placement::Placement;
use trueaxis_sim::program::{Curve, Program, ProgramError};
use trueaxis_tables::Machine;
use trueaxis_testing::command::Folder;

const SIMULATOR: &str = env!("CARGO_BIN_EXE_firmware-sim");

fn parse(text: &str) -> Result<Program, ProgramError> {
    Program::parse("test", text, "part.ngc")
}

fn machine(name: &str) -> Machine {
    Machine::read(&sample_machine(name)).unwrap()
}

#[test]
fn rotary_words_are_degrees_modal_and_incremental_in_any_unit() {
    let program = parse("G20\nG0 A10 C-30\nG1 X1 A20 F2\nG91 C5 B1\nG90 G21 G3 X45.4 I10 C0\nG43.4").unwrap_err();
    assert_eq!((program.line, program.found.as_str()), (6, "G43.4 at A20"));
    let program = parse("G20\nG0 A10 C-30\nG1 X1 A20 F2\nG91 C5 B1\nG90 G21 G3 X45.4 I10 C0").unwrap();
    let turns: Vec<_> = program.moves.iter().map(|m| (m.turn.start, m.turn.change)).collect();
    let expected = [
        ([0.0, 0.0, 0.0], [10.0, 0.0, -30.0]),
        ([10.0, 0.0, -30.0], [10.0, 0.0, 0.0]),
        ([20.0, 0.0, -30.0], [0.0, 1.0, 5.0]),
        ([20.0, 1.0, -25.0], [0.0, 0.0, 25.0]),
    ];
    assert_eq!(turns, expected);
    assert_eq!(program.moves[1].curve, Curve::Line { start: [0.0; 3], end: [25.4, 0.0, 0.0] });
    assert_eq!(program.moves[3].rotary(0.5), [20.0, 1.0, -12.5]);
    assert!(program.is_five_axis() && !parse("G0 X1\nG49").unwrap().is_five_axis());
}

/// G94: along X Y Z if any of them moves, else in degrees per minute; G93: 1/F minutes for the move.
#[test]
fn feeds_count_lengths_or_degrees_or_minutes() {
    let feeds = |text: &str| parse(text).unwrap().moves.iter().map(|m| m.feed_per_min).collect::<Vec<_>>();
    assert_eq!(feeds("G1 X3 Y4 A90 F500\nA0\nG20\nG1 A30 C40 F10\nX1 A0"), [500.0, 500.0, 10.0, 254.0]);
    assert_eq!(feeds("G93\nG1 X3 Y4 A90 F2\nA60 F3\nG94\nG1 X0 F100"), [10.0, 90.0, 100.0]);
    // 5 mm in half a minute, and 30 degrees in a third, plus acceleration and braking; no machine limits apply.
    let program = parse("G93\nG1 X3 Y4 A9 F2\nG1 X3.0 A39 F3").unwrap();
    let duration = Motion::plan(&program, MotionSettings::default()).unwrap().duration();
    assert!((50.0..51.0).contains(&duration), "{duration}");
    for (text, line, found) in [
        ("G93\nG1 X1 F2\nX2", 3, "feed motion"),
        ("G1 X1 F2\nG93\nX2", 3, "feed motion"),
        ("G93\nG1 X1 F2\nG94 X2", 3, "feed motion"),
        ("G93 F1\nG5.2 X1 Y1 P1", 2, "G93"),
        ("F9\nG5.2 X1 Y1 P1 A3", 2, "rotary"),
        ("A3", 1, "A3"),
        ("H3", 1, "H3"),
    ] {
        let error = parse(text).unwrap_err();
        assert!(error.line == line && error.found.contains(found), "{text}: {error}");
    }
}

#[test]
fn axes_that_a_machine_does_not_have_are_refused_with_the_line() {
    let (three, five) = (machine("mill-3axis"), machine("mill-5axis"));
    for (text, good, line) in [("G0 X1\nG0 A5", false, 2), ("G0 X1 B1", false, 1), ("G0 Z1\n\nG43.4", false, 3)] {
        let error = parse(text).unwrap().check_axes(&three.settings).unwrap_err();
        assert_eq!((error.line, error.file.as_str(), good), (line, "part.ngc", false));
    }
    let on_five = |text| parse(text).unwrap().check_axes(&five.settings);
    assert!(on_five("G43.4\nG0 A5 C7").is_ok());
    assert!(on_five("G0 B1").unwrap_err().found.contains('B'));
}

/// On a trunnion that carries a table, both turning by the negative angle, the tip in workpiece coordinates is
/// R_z(C) R_x(A) (X, Y, Z).
#[test]
fn the_tool_centre_point_is_that_of_rotation_matrices() {
    let machine = machine("mill-5axis");
    let origin = [3.0, -4.0, 150.0];
    let placement = Placement::new(&machine, origin).unwrap();
    let program = parse("G43.4\nG0 X10 Y20 Z5 A-35 C200\nG1 X-30 Y-12 Z8 A-80 C-170 F900\nG1 A-10 F3000").unwrap();
    let path = PlannedPath::new(&program, origin, &placement).unwrap();
    let mut near = 0;
    for (index, step) in program.moves.iter().enumerate() {
        for i in 0..=20 {
            let u = f64::from(i) / 20.0;
            let [x, y, z, a, b, c] = placement.axes(step, u);
            assert_eq!([a, b, c], step.rotary(u));
            let turn = DMat3::from_rotation_z(c.to_radians()) * DMat3::from_rotation_x(a.to_radians());
            let wanted = DVec3::from(step.curve.position(u)) + DVec3::from(origin);
            assert!((turn * DVec3::new(x, y, z)).distance(wanted) < 1e-10);
            let place = placement.place(step, u);
            assert!(place.tip.distance(wanted) < 1e-12 && place.direction.distance(turn * DVec3::Z) < 1e-14);
            let at = path.reference(index, u, &mut near);
            let on_path = path.spans[at.span as usize].position(at.t);
            assert!(DVec3::from(on_path).distance(wanted) < 1e-9, "{index} {u}: {on_path:?} {wanted}");
        }
    }
}

/// A move in machine coordinates is curved in workpiece coordinates; the cubic spans follow it.
#[test]
fn the_path_of_a_turning_machine_move_is_within_a_nanometre_of_the_exact_one() {
    let machine = machine("mill-5axis");
    let origin = [0.0, 0.0, 100.0];
    let placement = Placement::new(&machine, origin).unwrap();
    let program = parse("F900\nG1 X80 Y-30 A-70 C400\nG1 C0\nG3 X40 Y10 I-40 A-20\nG1 X0").unwrap();
    let path = PlannedPath::new(&program, origin, &placement).unwrap();
    assert_eq!(path.spans.len(), path.turns.len());
    let mut near = 0;
    for (index, step) in program.moves.iter().enumerate() {
        for i in 0..=400 {
            let u = f64::from(i) / 400.0;
            let at = path.reference(index, u, &mut near);
            let found = DVec3::from(path.spans[at.span as usize].position(at.t));
            let off = found.distance(placement.place(step, u).tip);
            assert!(off < 1.2e-6, "move {index} at {u}: {off} mm");
        }
    }
}

#[test]
fn no_axis_is_faster_than_it_can_and_three_axes_are_planned_as_before() {
    let machine = machine("mill-5axis");
    let placement = Placement::new(&machine, [0.0, 0.0, 150.0]).unwrap();
    let settings = MotionSettings { period_s: 1e-3, ..MotionSettings::default() };
    // The tip is 150 mm above the axis while the table turns: X and Y would need 1.5 m/s.
    let text = "G43.4\nG0 X60 A-90 C700\nG1 X61 C-300 F9000\nG0 X-40 A-5 C0\nG1 A-80 F90000\nG0 A0\nG49\nG0 A-90 C90";
    let program = parse(text).unwrap();
    let motion = Motion::plan_on(&program, settings, &placement).unwrap();
    let highest = [400.0, 400.0, 400.0, 150.0, f64::INFINITY, 300.0];
    let mut fastest = [0.0_f64; 6];
    let mut last: Option<[f64; 6]> = None;
    for point in motion.setpoints(&program) {
        let now = placement.axes(&program.moves[point.move_index], point.u);
        assert_eq!(point.rotary, [now[3], now[4], now[5]]);
        if let Some(last) = last {
            for k in 0..6 {
                fastest[k] = fastest[k].max((now[k] - last[k]).abs() / settings.period_s);
            }
        }
        last = Some(now);
    }
    for k in 0..6 {
        assert!(fastest[k] <= 1.01 * highest[k], "axis {k}: {fastest:?}");
    }
    assert!(fastest[3] > 0.5 * highest[3] && fastest[5] > 0.5 * 10_000.0 / 60.0, "{fastest:?}");
    for name in ["circle-diamond-square", "butterfly"] {
        let program = Program::builtin(name).unwrap().unwrap();
        let settings = MotionSettings { period_s: 2e-3, ..settings };
        let plain = Motion::plan(&program, settings).unwrap();
        let placed = Motion::plan_on(&program, settings, &placement).unwrap();
        assert!(plain.setpoints(&program).eq(placed.setpoints(&program)), "{name}");
    }
}

/// A program of `trueaxis helicoid` (module 3, 24 teeth, 20°, helix 15°, vertical, pivot 150): on this machine the tip lies on
/// the involute helicoid, r² = r_b² (1 + u²), polar angle = u − atan u + z/p, and the tool along its normal.
#[test]
fn the_tip_of_a_helicoid_program_lies_on_the_helicoid() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/helicoid.ngc")).unwrap();
    let program = parse(&text).unwrap();
    let machine = machine("mill-turn");
    program.check_axes(&machine.settings).unwrap();
    let placement = Placement::new(&machine, [0.0; 3]).unwrap();
    // m_t = m_n / cos β, tan α_t = tan α_n / cos β, r_b = r cos α_t, p = r / tan β.
    let beta = 15_f64.to_radians();
    let radius = 36.0 / beta.cos();
    let base = radius * (20_f64.to_radians().tan() / beta.cos()).atan().cos();
    let lead = radius / beta.tan();
    let mut on_surface = 0;
    for step in &program.moves {
        let place = placement.place(step, 1.0);
        let (x, y, z) = (place.tip.x, place.tip.y, place.tip.z);
        let square = (x * x + y * y) / (base * base) - 1.0;
        if step.rapid || square < 0.03 || z.abs() > 14.0 {
            continue;
        }
        let u = square.sqrt();
        let phi = u + z / lead;
        let away = (DMat3::from_rotation_z(phi - u.atan()).transpose() * place.tip).y;
        let normal = DVec3::new(lead * phi.sin(), -lead * phi.cos(), base).normalize();
        if away.abs() > 1.0 {
            continue;
        }
        assert!(away.abs() < 1e-7, "line {}: {away} mm off the flank", step.line);
        assert!(place.direction.distance(normal) < 1e-8, "line {}", step.line);
        on_surface += 1;
    }
    assert_eq!(on_surface, 55);
}

fn json(arguments: &[&str]) -> Value {
    Folder::new(SIMULATOR).json(arguments)
}

const CONE: [&str; 7] = ["run", "--json", "--machine", "mill-5axis", "--program", "cone-5axis", "--rate-hz=1000"];

#[test]
fn a_cone_on_five_axes_is_left_with_what_the_servo_leaves() {
    let rms = |run: &Value, what: &str, which: &str| run[what][which]["rms"].as_f64().unwrap();
    let full = json(&[&CONE[..], &["--model", "volumetric", "--orientation"]].concat());
    for (what, slack) in [("contour_error_um", 0.1), ("orientation_error_urad", 1.0)] {
        let [before, after, servo] =
            ["uncompensated", "compensated", "servo_only"].map(|which| rms(&full, what, which));
        assert!(after < 0.15 * before, "{what}: {before} to {after}");
        assert!(after < 1.2 * servo + slack, "{what}: {after}, servo {servo}");
    }
    assert_eq!(full["faults"], Value::Array(vec![]));
    for (estimated, actual) in [
        ("estimated_contour_error_um", "contour_error_um"),
        ("estimated_orientation_error_urad", "orientation_error_urad"),
    ] {
        for which in ["uncompensated", "compensated"] {
            let (estimated, actual) = (rms(&full, estimated, which), rms(&full, actual, which));
            assert!((estimated - actual).abs() < 0.05 * actual + 0.05, "{which}: {estimated} for {actual}");
        }
    }
    // The nine-term model has no levers, and without --orientation the tilts of the tool remain.
    let tip = json(&[&CONE[..], &["--model", "volumetric", "--orientation=off"]].concat());
    let nine = json(&[&CONE[..], &["--model", "nine"]].concat());
    assert!(
        rms(&tip, "orientation_error_urad", "compensated") > 2.0 * rms(&full, "orientation_error_urad", "compensated")
    );
    assert!(rms(&nine, "contour_error_um", "compensated") > 2.0 * rms(&tip, "contour_error_um", "compensated"));
}

/// The flank of the S overturns: A reverses, C sweeps 220 degrees. The compensated machine's residual is close to the servo's.
#[test]
fn an_s_shape_on_five_axes_is_left_with_what_the_servo_leaves() {
    let run =
        json(&["run", "--json", "--machine", "mill-5axis", "--program", "s-shape", "--rate-hz=1000", "--orientation"]);
    let rms = |what: &str, which: &str| run[what][which]["rms"].as_f64().unwrap();
    for (what, slack) in [("contour_error_um", 0.1), ("orientation_error_urad", 1.0)] {
        let [before, after, servo] = ["uncompensated", "compensated", "servo_only"].map(|which| rms(what, which));
        assert!(after < 0.3 * before, "{what}: {before} to {after}");
        assert!(after < 1.2 * servo + slack, "{what}: {after}, servo {servo}");
    }
    assert_eq!(run["faults"], Value::Array(vec![]));
}

#[test]
fn faults_of_rotary_axes_are_reported_and_what_cannot_run_is_refused() {
    let run = json(&[&CONE[..], &["--fault", "dropout:C@3s+2", "--fault", "nan-command:A@6s+1"]].concat());
    let faults: Vec<_> =
        run["faults"].as_array().unwrap().iter().map(|f| (f["fault"].as_str(), f["axis"].as_str())).collect();
    assert_eq!(faults[..2], [(Some("FeedbackNotFinite"), Some("C")), (Some("CommandNotFinite"), Some("A"))]);
    assert_eq!(run["stopped"], true);
    let directory = Folder::new(SIMULATOR);
    for (text, machine, message) in [
        ("G0 X1\nG0 A5\n", "mill-3axis", "own.ngc:2: found a word of axis A"),
        ("G43.4\n", "mill-3axis", "own.ngc:1: found G43.4"),
        ("G0 A35\n", "mill-5axis", "line 1: axis A goes to"),
        ("G43.4\nG1 X150 Z120 C180 A-90 F900\n", "mill-5axis", "line 2: axis Y goes to"),
    ] {
        directory.write("own.ngc", text);
        directory.bad(&["run", "--machine", machine, "--program", "own.ngc"], &[message]);
    }
    directory.bad(&["run", "--model", "nine", "--orientation"], &[]);
    assert!(json(&["run", "--json", "--rate-hz", "1000"]).get("orientation_error_urad").is_none());
}
