//! The field of machines whose error is known in closed form, and of the sample machines.

use std::path::Path;
use std::time::Instant;
use trueaxis::machine::{Axis, Twist};
use trueaxis_evaluation::field::{Case, Figures, Left, Model, Points, Settings, figures, rows};
use trueaxis_tables::{Machine, Table};
use trueaxis_testing::machine::{Machine as Made, rows as lines, rows_both_ways};

/// Travel of every linear axis, mm.
const TRAVEL: [f64; 2] = [-300.0, 500.0];

/// A machine without tables, with X, Y, Z travels of 800 mm.
fn made(chain: &str) -> Machine {
    let settings = Made::new(chain).travel(TRAVEL, 10.0).settings();
    let tables = vec![None; settings.axes.len()];
    Machine { settings, tables, grids: Vec::new() }
}

/// Gives an axis a table of two lines with these errors at every position, mm and rad.
fn constant(machine: &mut Machine, axis: Axis, errors: Twist) {
    table(machine, axis, |_| errors);
}

fn table(machine: &mut Machine, axis: Axis, errors: impl FnMut(f64) -> Twist) {
    let slot = machine.settings.axes.iter().position(|own| own.axis == axis).unwrap();
    machine.tables[slot] = Some(Table { given: [true; 6], bidirectional: false, rows: lines(TRAVEL, errors) });
}

fn sample(name: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables").join(name)).unwrap()
}

fn every(count: usize) -> Settings {
    Settings { points: Points::Every(count), ..Settings::default() }
}

fn case(left: &Left) -> &Case {
    left.after.as_ref().unwrap()
}

#[track_caller]
fn near(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance, "{found}, not {wanted}");
}

#[test]
fn squareness_grows_to_the_corners_and_both_models_take_it() {
    let mut machine = made("w b X Y Z t");
    (machine.settings.location.c0y, machine.settings.location.a0z) = (60e-6, 80e-6);
    let found = figures(&machine, &every(5)).unwrap();
    // dx = −C0Y y, dy = −A0Z z.
    let size = |y: f64, z: f64| (60e-3 * y).hypot(80e-3 * z);
    near(found.before.largest_um, size(500.0, 500.0), 1e-9);
    assert_eq!(found.before.worst.at_mm[1..], [500.0, 500.0]);
    let along = [-300.0, -100.0, 100.0, 300.0, 500.0];
    let mut sizes: Vec<f64> = along.iter().flat_map(|y| along.map(|z| size(*y, z))).collect();
    near(found.before.rms_um, (sizes.iter().map(|s| s * s).sum::<f64>() / 25.0).sqrt(), 1e-9);
    sizes.sort_by(f64::total_cmp);
    // 95 % of 125 points is the 119th: five points along X for each of these.
    near(found.before.p95_um, sizes[118 / 5], 1e-9);
    for ([low, high], [wanted_low, wanted_high]) in
        found.before.range_um.iter().zip([[-30.0, 18.0], [-40.0, 24.0], [0.0, 0.0]])
    {
        near(*low, wanted_low, 1e-9);
        near(*high, wanted_high, 1e-9);
    }
    for (slice, z) in found.before.slices[2].iter().zip(along) {
        assert_eq!(slice.at_mm, z);
        near(slice.largest_um, size(500.0, z), 1e-9);
    }
    let causes: Vec<(&str, f64)> =
        found.before.worst.terms.iter().map(|cause| (cause.term.as_str(), cause.along_um)).collect();
    let [("A0Z", a0z), ("C0Y", c0y)] = causes[..] else { panic!("{causes:?}") };
    near(a0z, 40.0 * 0.8, 1e-9);
    near(c0y, 30.0 * 0.6, 1e-9);
    assert_eq!(found.before.worst.tables[0].source, "location errors");
    for left in [&found.nine, &found.volumetric] {
        assert!(case(left).largest_um < 1e-6, "{}", case(left).largest_um);
        near(case(left).worst.correction[0], case(left).worst.at_mm[1] * 60e-6, 1e-5);
    }
}

#[test]
fn an_error_of_position_alone_is_gone_under_both_models() {
    let mut machine = made("w X' b Y Z t");
    // 8 µm at −300, −24 µm at 500.
    table(&mut machine, Axis::X, |x| [-40e-6 * (x + 100.0), 0.0, 0.0, 0.0, 0.0, 0.0]);
    let found = figures(&machine, &every(9)).unwrap();
    near(found.before.largest_um, 24.0, 1e-9);
    assert_eq!(found.before.worst.at_mm[0], 500.0);
    assert_eq!(found.before.worst.terms.len(), 1);
    assert_eq!(found.before.worst.terms[0].term, "EXX");
    near(found.before.worst.terms[0].along_um, 24.0, 1e-9);
    for left in [&found.nine, &found.volumetric] {
        assert!(case(left).largest_um < 1e-3, "{}", case(left).largest_um);
    }
}

#[test]
fn nine_terms_leave_the_lever_of_an_angle_and_twists_do_not() {
    let mut machine = made("w b X Y Z t");
    let b: f64 = 50e-6;
    constant(&mut machine, Axis::X, [0.0, 0.0, 0.0, 0.0, b, 0.0]);
    let found = figures(&machine, &every(5)).unwrap();
    // The carriage of X rotates the tip at (y, z) about Y: exactly (z sin b, 0, z (cos b − 1)).
    let worst = (500.0 * b.sin()).hypot(500.0 * (b.cos() - 1.0)) * 1e3;
    near(found.before.largest_um, worst, 1e-9);
    near(case(&found.nine).largest_um, worst, 1e-9);
    assert_eq!(case(&found.nine).worst.terms[0].term, "EBX");
    near(case(&found.nine).worst.terms[0].along_um, worst, 1e-9);
    near(found.before.orientation.largest_urad, 50.0, 1e-9);
    // The correction sets X back by 25 µm and leaves Z: second order is 500 b² / 2.
    assert!(case(&found.volumetric).largest_um < 1e-3, "{}", case(&found.volumetric).largest_um);
    near(case(&found.volumetric).orientation.largest_urad, 50.0, 1e-9);
}

#[test]
fn rows_go_by_x_first_and_follow_travel_temperature_and_tool() {
    let mut machine = made("w b X Y Z t");
    constant(&mut machine, Axis::Y, [0.0; 6]);
    machine.settings.axes[1].backlash = 7e-3;
    machine.settings.axes[2].thermal.expansion_per_k = 10e-6;
    let points = Points::Each([2, 3, 4]);
    let settings = Settings { points, kelvin: 2.0, negative: "y".into(), ..Settings::default() };
    let found = rows(&machine, &settings).unwrap();
    assert_eq!(found.len(), 9 * 24);
    let places: Vec<&[f32]> = found.chunks(9).map(|row| &row[..3]).collect();
    assert_eq!(places[..3], [[-300.0, -300.0, -300.0], [500.0, -300.0, -300.0], [-300.0, 100.0, -300.0]]);
    for row in found.chunks(9) {
        // Lost motion on Y, growth of Z from machine zero: 20 ppm; the step knows both.
        let wanted = [0.0, 7.0, 20e-3 * row[2]];
        for ((found, wanted), after) in row[3..6].iter().zip(wanted).zip(&row[6..]) {
            assert!((found - wanted).abs() < 1e-5 && after.abs() < 1e-3, "{row:?}");
        }
    }
    // A tool of 100 mm below the spindle is a lever for the head's angle.
    constant(&mut machine, Axis::Z, [0.0, 0.0, 0.0, 0.0, 30e-6, 0.0]);
    let longer = Settings { tool_mm: Some([0.0, 0.0, -100.0]), ..every(2) };
    let found = figures(&machine, &longer).unwrap();
    assert_eq!(found.tool_mm, [0.0, 0.0, -100.0]);
    near(found.before.worst.error_um[0], -3.0, 1e-6);
}

#[test]
fn clipped_corrections_remain_as_error() {
    let mut machine = made("w b X Y Z t");
    constant(&mut machine, Axis::X, [0.12, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let found = figures(&machine, &every(3)).unwrap();
    assert_eq!(found.nine.limited_points, 27);
    near(case(&found.nine).largest_um, 20.0, 1e-9);
    near(case(&found.nine).worst.correction[0], -0.1, 1e-12);
}

#[test]
fn a_pose_turns_the_levers_and_the_tool_is_turned_back_where_the_machine_does() {
    let mut machine = made("w C' b X Y Z t");
    machine.settings.axes[3].travel = [-180.0, 180.0];
    let slot = 3;
    // The table turns the workpiece by 100 µrad about Z too little: at (x, y) from its axis.
    let errors = [0.0, 0.0, 0.0, 0.0, 0.0, 100e-6];
    machine.tables[slot] =
        Some(Table { given: [true; 6], bidirectional: false, rows: lines([-180.0, 180.0], |_| errors) });
    for orientation in [false, true] {
        machine.settings.compensation.orientation = orientation;
        let settings = Settings { pose_deg: [('C', 90.0)].into(), ..every(3) };
        let found = figures(&machine, &settings).unwrap();
        near(found.before.largest_um, 500.0_f64.hypot(500.0) * 0.1, 1e-2);
        near(found.before.orientation.largest_urad, 100.0, 1e-6);
        assert_eq!(found.before.worst.terms[0].term, "ECC");
        let after = case(&found.volumetric);
        assert!(after.largest_um < 0.1, "{}", after.largest_um);
        // C turns about the tool: the correction affects only the tip, not the direction.
        near(after.orientation.largest_urad, 100.0, 1e-2);
        assert_eq!(found.pose_deg[&'C'], 90.0);
    }
    let sample = sample("mill-turn");
    let settings = Settings { pose_deg: [('A', 40.0), ('C', 70.0)].into(), ..every(5) };
    let found = figures(&sample, &settings).unwrap();
    assert!(found.corrects_orientation);
    let [before, after] = [&found.before, case(&found.volumetric)].map(|case| case.orientation.largest_urad);
    println!("mill-turn: rotation of the tool {before} to {after} µrad");
    assert!(after < before);
    assert!(case(&found.volumetric).largest_um < 0.1, "{}", case(&found.volumetric).largest_um);
}

#[test]
fn of_the_samples_the_volumetric_form_leaves_second_order_and_the_terms_add_up() {
    for (name, pose) in [("mill-3axis", vec![]), ("mill-5axis", vec![('A', -50.0), ('C', 30.0)]), ("grinder", vec![])] {
        let machine = sample(name);
        let found = figures(&machine, &Settings { pose_deg: pose.into_iter().collect(), ..every(6) }).unwrap();
        let [nine, volumetric] = [case(&found.nine), case(&found.volumetric)];
        println!("{name}: {:.3} µm, {:.3}, {:.4}", found.before.largest_um, nine.largest_um, volumetric.largest_um);
        if name == "grinder" {
            // The machine has no Y: errors in that direction remain.
            assert_eq!(found.points, [6, 1, 6]);
            assert_eq!(nine.worst.correction[1], 0.0);
        } else {
            assert!(volumetric.largest_um < 0.1 && nine.largest_um > 5.0 * volumetric.largest_um);
        }
        for case in [&found.before, nine, volumetric] {
            let sum: f64 = case.worst.terms.iter().map(|cause| cause.along_um).sum();
            let of_tables: f64 = case.worst.tables.iter().map(|table| table.along_um).sum();
            near(sum, of_tables, 1e-9);
            near(sum, case.worst.size_um, 0.05);
            assert!(case.worst.terms.is_sorted_by(|a, b| a.along_um >= b.along_um));
            assert_eq!(case.worst.size_um, case.largest_um);
        }
    }
}

#[test]
fn rows_and_figures_are_of_one_field() {
    let machine = sample("mill-3axis");
    for model in [Model::Nine, Model::Volumetric] {
        let settings = Settings { model: Some(model), kelvin: 3.0, negative: "XZ".into(), ..every(7) };
        let (rows, figures): (_, Figures) = (rows(&machine, &settings).unwrap(), figures(&machine, &settings).unwrap());
        let largest = |columns: std::ops::Range<usize>| {
            let size = |row: &[f32]| row[columns.clone()].iter().map(|v| v * v).sum::<f32>().sqrt();
            rows.chunks(9).map(size).fold(0.0, f32::max)
        };
        let left = if model == Model::Nine { &figures.nine } else { &figures.volumetric };
        near(f64::from(largest(3..6)), figures.before.largest_um, 1e-4);
        near(f64::from(largest(6..9)), case(left).largest_um, 1e-4);
    }
}

#[test]
fn reverse_columns_count_in_negative_travel_only() {
    let mut machine = made("w b X Y Z t");
    let errors = |_: f64, reverse: bool| [if reverse { 9e-3 } else { 4e-3 }, 0.0, 0.0, 0.0, 0.0, 0.0];
    machine.tables[0] = Some(Table { given: [true; 6], bidirectional: true, rows: rows_both_ways(TRAVEL, errors) });
    for (negative, wanted) in [("", 4.0), ("X", 9.0)] {
        let found = figures(&machine, &Settings { negative: negative.into(), ..every(2) }).unwrap();
        near(found.before.largest_um, wanted, 1e-9);
    }
}

#[test]
fn wrong_requests_are_refused() {
    let refused = |settings: Settings| rows(&sample("mill-5axis"), &settings).unwrap_err().to_string();
    assert_eq!(refused(every(1)), "points along X: found 1, needed 2 to 51");
    assert_eq!(refused(every(52)), "points along X: found 52, needed 2 to 51");
    assert_eq!(
        refused(Settings { negative: "XQ".into(), ..every(3) }),
        "direction of travel: found axis 'Q', needed axes of the machine (XYZAC)"
    );
    assert_eq!(
        refused(Settings { pose_deg: [('B', 0.0)].into(), ..every(3) }),
        "pose: found axis 'B', needed rotary axes of the machine (XYZAC)"
    );
    assert_eq!(
        refused(Settings { pose_deg: [('A', 31.0)].into(), ..every(3) }),
        "pose: found 31 degrees of A, needed the declared travel, -120 to 30"
    );
    for kelvin in [1e6, f64::NAN] {
        let why = rows(&sample("mill-3axis"), &Settings { kelvin, ..every(3) }).unwrap_err().to_string();
        assert!(why.starts_with(&format!("temperature: found {kelvin} K above")), "{why}");
    }
    assert!(refused(Settings { tool_mm: Some([f64::INFINITY, 0.0, 0.0]), ..every(3) }).contains("tool"));
    let mut machine = made("w b X Y Z t");
    machine.settings.axes[2] = trueaxis::machine::AxisSettings::with_defaults(Axis::Z, false);
    let why = rows(&machine, &every(3)).unwrap_err().to_string();
    assert_eq!(why, "axis Z: found neither a declared travel nor a table, needed one for the working volume");
}

#[test]
fn takes_as_long() {
    let machine = sample("mill-3axis");
    let start = Instant::now();
    rows(&machine, &every(21)).unwrap();
    let rows = start.elapsed();
    let start = Instant::now();
    figures(&machine, &every(21)).unwrap();
    println!("21³ points: rows {rows:?}, figures {:?}", start.elapsed());
}
