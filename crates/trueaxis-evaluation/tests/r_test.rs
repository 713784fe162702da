//! Recovery of location errors from R-tests of machines whose tip moves by exact transforms.

use std::fmt::Write;
use std::path::Path;
use trueaxis::Axis;
use trueaxis::machine::AXES;
use trueaxis_evaluation::r_test::{COLUMNS, Options, RTestDocument, RTestFit, Record, identify, name};
use trueaxis_evaluation::rows::Rows;
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;
use trueaxis_testing::machine::Machine as Settings;
use trueaxis_testing::noise::Noise;

/// A machine with errors of its rotary axes across their own directions, some micrometres and tens of microradians.
fn machine(chain: &str, seed: u64, of: &[Axis]) -> Machine {
    let mut noise = Noise::new(seed);
    let mut settings = Settings::new(chain).settings();
    for own in &mut settings.axes {
        // A trunnion 40 mm below the table's face, a head's pivot 150 mm above the tip.
        if own.axis == Axis::A {
            own.offset_mm = [0.0, 0.0, if chain.contains("A'") { -40.0 } else { 0.0 }];
        }
    }
    if chain.contains("A t") || chain.contains("B t") {
        settings.tool_mm = [0.0, 0.0, -200.0];
    }
    for axis in of {
        let own = &mut settings.location.rotary[axis.index() - 3];
        for component in 0..6 {
            if component % 3 != axis.index() - 3 {
                own[component] = if component < 3 { 0.03 } else { 80e-6 } * noise.signed();
            }
        }
    }
    let tables = settings.axes.iter().map(|_| None).collect();
    Machine { settings, tables, grids: Vec::new() }
}

/// The pose at which the control keeps the tool at a ball `ball` mm from the workpiece's zero, by the ideal machine's own
/// kinematics: Newton's method on the ideal pose (exact for linear axes) finds the linear axes that bring the ideal tip there.
fn rtcp(machine: &Machine, ball: [f64; 3], angles: [f64; 3]) -> [f64; AXES] {
    let geometry = Geometry::new(machine, 0.0).unwrap();
    let mut at = [0.0, 0.0, 0.0, angles[0], angles[1], angles[2]];
    let place = |at: &[f64; AXES]| {
        let mut slots = [0.0; AXES];
        for (slot, own) in machine.settings.axes.iter().enumerate() {
            slots[slot] = at[own.axis.index()];
        }
        geometry.ideal_pose(&slots).tip_mm
    };
    let zero = place(&at);
    let mut columns = [[0.0; 3]; 3];
    for k in 0..3 {
        let mut moved = at;
        moved[k] += 1.0;
        let there = place(&moved);
        columns[k] = [0, 1, 2].map(|c| there[c] - zero[c]);
    }
    // The columns form a rotation: its transpose inverts it.
    for k in 0..3 {
        at[k] = (0..3).map(|c| columns[k][c] * (ball[c] - zero[c])).sum();
    }
    at
}

fn record(machine: &Machine, poses: &[[f64; 3]], balls: &[[f64; 3]], noise_um: f64) -> String {
    let geometry = Geometry::new(machine, 0.0).unwrap();
    let mut noise = Noise::new(5);
    let mut text = String::from("ball,x_mm,y_mm,z_mm,a_deg,b_deg,c_deg,dx_um,dy_um,dz_um\n");
    for (number, ball) in balls.iter().enumerate() {
        for angles in poses {
            let at = rtcp(machine, *ball, *angles);
            let mut slots = [0.0; AXES];
            for (slot, own) in machine.settings.axes.iter().enumerate() {
                slots[slot] = at[own.axis.index()];
            }
            // The ball itself is 12, −7, 5 µm off its commanded place in the workpiece's frame.
            let off = [0.012, -0.007, 0.005];
            let error = geometry.tip_error(&slots, &[0.0; AXES]);
            let turned = turn(machine, &at, off);
            write!(text, "{}", number + 1).unwrap();
            at.iter().for_each(|value| write!(text, ",{value}").unwrap());
            for c in 0..3 {
                let gauss: f64 = (0..12).map(|_| noise.unit()).sum::<f64>() - 6.0;
                write!(text, ",{}", 1e3 * (error[c] - turned[c]) + noise_um * gauss).unwrap();
            }
            text.push('\n');
        }
    }
    text
}

/// A vector of the workpiece's frame in machine directions, from the displacement of the ideal tip when the linear axes move.
fn turn(machine: &Machine, at: &[f64; AXES], vector: [f64; 3]) -> [f64; 3] {
    let geometry = Geometry::new(machine, 0.0).unwrap();
    let tip = |x: [f64; 3]| {
        let mut slots = [0.0; AXES];
        for (slot, own) in machine.settings.axes.iter().enumerate() {
            slots[slot] = at[own.axis.index()] + x.get(own.axis.index()).copied().unwrap_or(0.0);
        }
        geometry.ideal_pose(&slots).tip_mm
    };
    let zero = tip([0.0; 3]);
    // The linear axes of these machines are between bed and rotary axes: a step of each is a step in machine directions.
    [0, 1, 2].map(|k| {
        let mut step = [0.0; 3];
        step[k] = 1.0;
        let moved = tip(step);
        (0..3).map(|c| (moved[c] - zero[c]) * vector[c]).sum()
    })
}

fn read(text: &str) -> anyhow::Result<Record> {
    Record::read(&mut Rows::new(text.as_bytes(), Path::new("r.csv"), &COLUMNS, |_| {})?)
}

fn find(text: &str, machine: &Machine, options: &Options) -> anyhow::Result<(Record, RTestFit)> {
    let record = read(text)?;
    let found = identify(&record, "r.csv", machine, options)?;
    Ok((record, found))
}

/// All poses of a trunnion and of its table.
fn table_poses() -> Vec<[f64; 3]> {
    let mut poses = Vec::new();
    for a in [-90.0, -60.0, -30.0, 0.0, 20.0] {
        for c in [0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0] {
            poses.push([a, 0.0, c]);
        }
    }
    poses
}

fn check(found: &RTestFit, truth: &Machine, tolerance: [f64; 2]) {
    for &((axis, component), value, error) in &found.terms {
        let is = truth.settings.location.of(axis).unwrap()[component];
        let near = tolerance[usize::from(component >= 3)].max(4.0 * error);
        assert!((value - is).abs() < near, "{}: {value} ± {error} for {is}", name((axis, component)));
    }
}

/// A trunnion with a table: eight location errors and the ball's place from one ball; only the second order remains.
#[test]
fn a_trunnion_and_its_table() {
    for chain in ["w C' A' Y' b X Z t", "w C' A' X' b Y Z t"] {
        let truth = machine(chain, 11, &[Axis::A, Axis::C]);
        let text = record(&truth, &table_poses(), &[[60.0, 20.0, 80.0]], 0.0);
        let mut blank = truth.clone();
        blank.settings.location = Default::default();
        let (record, found) = find(&text, &blank, &Options::default()).unwrap();
        assert_eq!(found.terms.len(), 8);
        // 30 µm and 80 µrad over 100 mm: products of errors are some nanometres.
        check(&found, &truth, [3e-5, 3e-7]);
        let [x, y, z] = found.balls_mm[0];
        assert!(
            (x - 0.012).abs() < 3e-5 && (y + 0.007).abs() < 3e-5 && (z - 0.005).abs() < 3e-5,
            "{:?}",
            found.balls_mm
        );
        let document = RTestDocument::new(&record, &found, &blank);
        assert!(document.left_max_um < 0.05 && document.rms_um > 10.0, "{document:?}");
        assert_eq!(document.rank, 11);
    }
}

/// The machine's own errors are removed only if they are not fitted: either machine gives the same absolute errors.
#[test]
fn errors_are_absolute() {
    let truth = machine("w C' A' Y' b X Z t", 12, &[Axis::A, Axis::C]);
    let text = record(&truth, &table_poses(), &[[60.0, 20.0, 80.0]], 0.0);
    let (_, found) = find(&text, &truth, &Options::default()).unwrap();
    check(&found, &truth, [3e-5, 3e-7]);
    let options = Options { without: vec!["EX0C".into(), "eb0a".into()], ..Options::default() };
    let (_, found) = find(&text, &truth, &options).unwrap();
    assert_eq!(found.terms.len(), 6);
    check(&found, &truth, [3e-5, 3e-7]);
}

/// With noise the values are within their standard errors, and sigma equals the probes'.
#[test]
fn noise_comes_out_as_standard_errors() {
    let truth = machine("w C' A' Y' b X Z t", 13, &[Axis::A, Axis::C]);
    let text = record(&truth, &table_poses(), &[[60.0, 20.0, 80.0], [-30.0, 70.0, 20.0]], 1.0);
    let (_, found) = find(&text, &truth, &Options::default()).unwrap();
    assert!((1e3 * found.sigma_mm - 1.0).abs() < 0.15, "{}", found.sigma_mm);
    check(&found, &truth, [0.0; 2]);
    assert!(found.terms.iter().all(|(_, _, error)| *error > 0.0));
}

/// On a head the first axis' offsets, and the second's along the first, cannot be separated from the ball's place and are
/// named; with them excluded, the others are recovered.
#[test]
fn a_head_cannot_separate_its_first_axis_from_the_ball() {
    let truth = machine("w X' b Y Z C A t", 14, &[Axis::A]);
    let mut poses = Vec::new();
    for a in [-60.0, -30.0, 0.0, 30.0, 60.0] {
        for c in [0.0, 60.0, 120.0, 180.0, 240.0, 300.0] {
            poses.push([a, 0.0, c]);
        }
    }
    let text = record(&truth, &poses, &[[50.0, -40.0, 10.0]], 0.0);
    let error = format!("{:#}", find(&text, &truth, &Options::default()).unwrap_err());
    for part in ["r.csv: found poses that cannot separate", "EX0C", "EY0C", "EZ0A", "the place of ball 1", "--without"]
    {
        assert!(error.contains(part), "{error} without {part}");
    }
    let options = Options { without: ["EX0C", "EY0C", "EZ0A"].map(String::from).into(), ..Options::default() };
    let (_, found) = find(&text, &truth, &options).unwrap();
    check(&found, &truth, [3e-5, 3e-7]);
}

/// A pose read again at the end to check drift: both readings are used, and their distance is reported.
#[test]
fn a_repeated_pose_shows_the_drift() {
    let truth = machine("w C' A' Y' b X Z t", 16, &[Axis::A, Axis::C]);
    let text = record(&truth, &table_poses(), &[[60.0, 20.0, 80.0]], 0.0);
    let lines: Vec<&str> = text.lines().collect();
    let mut cells: Vec<String> = lines[2].split(',').map(String::from).collect();
    for (cell, um) in cells.iter_mut().rev().take(3).zip([2.0, 0.0, 1.5]) {
        *cell = (cell.parse::<f64>().unwrap() + um).to_string();
    }
    let (once, before) = find(&text, &truth, &Options::default()).unwrap();
    assert_eq!(once.repeated(), None);
    let (again, found) = find(&format!("{text}{}\n", cells.join(",")), &truth, &Options::default()).unwrap();
    let (apart, lines) = again.repeated().unwrap();
    assert!((apart - 2.5e-3).abs() < 1e-9 && lines == [3, 42], "{apart} {lines:?}");
    assert_eq!(found.degrees_of_freedom, before.degrees_of_freedom + 3);
    let document = RTestDocument::new(&again, &found, &truth);
    let expected = "a pose that was read again differs by 2.50 µm at most, lines 3 and 42";
    assert!(document.notes.iter().any(|note| note == expected), "{:?}", document.notes);
}

#[test]
fn bad_records_are_refused_with_their_line() {
    let truth = machine("w C' A' Y' b X Z t", 15, &[Axis::A, Axis::C]);
    let good = record(&truth, &table_poses(), &[[60.0, 20.0, 80.0]], 0.3);
    let refused = |text: &str, message: &str| {
        let error = format!("{:#}", find(text, &truth, &Options::default()).unwrap_err());
        assert!(error.contains(message), "{error} without {message}");
    };
    let lines: Vec<&str> = good.lines().collect();
    refused(
        &format!("{good}{}\n", lines[2]),
        "r.csv:42: column dx_um: found the angles, ball and readings of line 3 again, needed a row for every reading",
    );
    let (head, tail) = lines[7].rsplit_once(',').unwrap();
    refused(&good.replace(&format!("{head},{tail}"), &format!("{head},5000")), "r.csv:8: column dz_um: found 5000");
    let short: String = lines[..4].iter().map(|line| format!("{line}\n")).collect();
    refused(&short, "needed at least 3 more coordinates than unknowns");
    let still: String = lines
        .iter()
        .enumerate()
        .map(|(i, line)| match line.rsplit_once(',') {
            Some((rest, _)) if i > 15 => format!("{rest},4.25\n"),
            _ => format!("{line}\n"),
        })
        .collect();
    refused(&still, "r.csv:17: column dz_um: found 4.25 for 25 readings in a row");
}
