//! Compares with LinuxCNC's interpreter, if installed: positions, arcs, feeds and their order, as printed by `rs274 -g`.
//!
//! Reads the output independently of the crate's own reader. TRUEAXIS_LINUXCNC=1 makes a missing rs274 a failure.

mod interpreter;

use std::path::{Path, PathBuf};
use std::process::Command;

use firmware_sim::rs274::read as read_through_rs274;
use trueaxis_sim::program::{Curve, Move, Offsets, Program, ReadOptions, ToolTable};

const POSTS: [&str; 12] = [
    "drilling.ngc",
    "fanuc.nc",
    "five-axis-g93.ngc",
    "freecad-linuxcnc.ngc",
    "fusion-linuxcnc.ngc",
    "grbl.nc",
    "heekscnc.ngc",
    "helical-boring.ngc",
    "inch-latin1.nc",
    "mach3.tap",
    "offsets.ngc",
    "pycam.ngc",
];

/// The output has four decimals, in inches too; after rotation and summation they amount to this, mm.
const TOLERANCE: f64 = 3.0e-4;

fn posts() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/posts")
}

fn installed() -> bool {
    let found = Command::new("rs274").arg("-?").output().is_ok();
    if !found {
        assert!(std::env::var_os("TRUEAXIS_LINUXCNC").is_none(), "rs274 is missing");
        println!("skipped: LinuxCNC's rs274 is not installed");
    }
    found
}

/// A motion call of the canonical interface.
#[derive(Debug)]
struct Step {
    text: String,
    rapid: bool,
    feed: f64,
    end: [f64; 6],
    /// Centre in machine coordinates, signed turns.
    arc: Option<([f64; 3], f64)>,
}

/// Without an INI file LinuxCNC reads its files in inches: lengths of a tool table or a parameter file in mm are divided.
fn scaled_tools(text: &str) -> String {
    let word = |word: &str| match (word.chars().next(), word.get(1..).and_then(|n| n.parse::<f64>().ok())) {
        (Some(letter @ ('X' | 'Y' | 'Z')), Some(value)) => format!("{letter}{:.15}", value / 25.4),
        _ => word.to_owned(),
    };
    let line =
        |line: &str| line.split(';').next().unwrap_or("").split_whitespace().map(word).collect::<Vec<_>>().join(" ");
    text.lines().map(line).collect::<Vec<_>>().join("\n") + "\n"
}

fn scaled_parameters(text: &str) -> String {
    let line = |line: &str| {
        let (number, value) = line.split_once('\t').unwrap();
        let number: u32 = number.parse().unwrap();
        let length = matches!(number, 5161..=5163 | 5181..=5183 | 5211..=5213)
            || (5221..5400).contains(&number) && (number - 5221) % 20 < 3;
        let value: f64 = value.parse().unwrap();
        format!("{number}\t{:.15}", if length { value / 25.4 } else { value })
    };
    text.lines().map(line).collect::<Vec<_>>().join("\n") + "\n"
}

fn rs274(program: &Path, with: &ReadOptions) -> Vec<Step> {
    let folder = tempfile::tempdir().unwrap();
    let bytes = std::fs::read(program).unwrap();
    // rs274 does not accept a byte order mark; it ignores comments after the program's end.
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
    let place = |name: &str| folder.path().join(name);
    std::fs::write(place("part.ngc"), bytes).unwrap();
    let mut command = Command::new("rs274");
    // rs274 keeps its tools in a file below HOME, which two instances would share.
    command.current_dir(folder.path()).env("HOME", folder.path());
    if with.tools.is_some() {
        let text = std::fs::read_to_string(posts().join("tool.tbl")).unwrap();
        std::fs::write(place("tool.tbl"), scaled_tools(&text)).unwrap();
        command.args(["-t", "tool.tbl"]);
    }
    if with.offsets.is_some() {
        let text = std::fs::read_to_string(posts().join("controller.var")).unwrap();
        std::fs::write(place("controller.var"), scaled_parameters(&text)).unwrap();
        command.args(["-v", "controller.var"]);
    }
    if with.block_delete {
        command.arg("-b");
    }
    let output = command.args(["-g", "part.ngc"]).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(text.contains("PROGRAM_END"), "{}: {said}", program.display());
    steps(&text, TOLERANCE)
}

/// machine = R (program + G92) + work offset + tool, in the order of LinuxCNC's own canonical layer.
fn steps(text: &str, tolerance: f64) -> Vec<Step> {
    let (mut unit, mut feed, mut rotation) = (1.0, 0.0, 0.0_f64);
    let (mut g5x, mut g92, mut tool) = ([0.0; 6], [0.0; 6], [0.0; 6]);
    let mut plane = [0, 1, 2];
    let mut at = [0.0; 6];
    let mut steps = Vec::new();
    for line in text.lines() {
        let Some((head, arguments)) = line.split_once('(') else { continue };
        let name =
            head.split_whitespace().last().unwrap_or("").trim_start_matches(|c: char| c == 'N' || c.is_ascii_digit());
        let n: Vec<f64> =
            arguments.split([',', ' ', ')']).filter(|w| !w.is_empty()).filter_map(|w| w.parse().ok()).collect();
        let six = |first: usize| -> [f64; 6] { std::array::from_fn(|k| n[first + k] * if k < 3 { unit } else { 1.0 }) };
        let machine = |p: [f64; 6]| -> [f64; 6] {
            let (sine, cosine) = rotation.to_radians().sin_cos();
            let (x, y) = (p[0] + g92[0], p[1] + g92[1]);
            let turned = [
                cosine * x - sine * y,
                sine * x + cosine * y,
                p[2] + g92[2],
                p[3] + g92[3],
                p[4] + g92[4],
                p[5] + g92[5],
            ];
            std::array::from_fn(|k| turned[k] + g5x[k] + tool[k])
        };
        let (end, arc) = match name {
            "STRAIGHT_TRAVERSE" | "STRAIGHT_FEED" => (machine(six(0)), None),
            "ARC_FEED" => {
                let mut end = [0.0, 0.0, 0.0, n[6], n[7], n[8]];
                let mut center = [0.0; 6];
                for (k, axis) in plane.into_iter().enumerate() {
                    end[axis] = unit * [n[0], n[1], n[5]][k];
                    center[axis] = unit * [n[2], n[3], n[5]][k];
                }
                let center = machine(center);
                (machine(end), Some(([center[0], center[1], center[2]], n[4])))
            }
            _ => {
                match name {
                    "USE_LENGTH_UNITS" => {
                        let new = if arguments.contains("INCHES") { 25.4 } else { 1.0 };
                        feed *= unit / new;
                        unit = new;
                    }
                    "SELECT_PLANE" if arguments.contains("XY") => plane = [0, 1, 2],
                    "SELECT_PLANE" if arguments.contains("XZ") => plane = [2, 0, 1],
                    "SELECT_PLANE" => plane = [1, 2, 0],
                    "SET_G5X_OFFSET" => g5x = six(1),
                    "SET_G92_OFFSET" => g92 = six(0),
                    "SET_XY_ROTATION" => rotation = n[0],
                    "USE_TOOL_LENGTH_OFFSET" => tool = six(0),
                    "SET_FEED_RATE" => feed = n[0],
                    _ => {}
                }
                continue;
            }
        };
        let moved = (0..6).any(|k| (end[k] - at[k]).abs() > tolerance);
        at = end;
        if moved || arc.is_some() {
            let rapid = name == "STRAIGHT_TRAVERSE";
            steps.push(Step { text: line.to_owned(), rapid, feed: feed * unit, end, arc });
        }
    }
    steps
}

fn agree(name: &str, moves: &[Move], steps: &[Step]) {
    agree_within(name, moves, steps, TOLERANCE);
}

fn agree_within(name: &str, moves: &[Move], steps: &[Step], tolerance: f64) {
    for (element, step) in moves.iter().zip(steps) {
        let place = format!("{name}, line {}: {:?} against {}", element.line, element.curve, step.text);
        let at = element.curve.position(element.curve.domain().1);
        let rotary = element.turn.end();
        for k in 0..3 {
            assert!((at[k] - step.end[k]).abs() < tolerance, "{place}: {at:?} instead of {:?}", step.end);
            assert!((rotary[k] - step.end[3 + k]).abs() < tolerance, "{place}: {rotary:?}");
        }
        assert_eq!(element.rapid, step.rapid, "{place}");
        if !element.rapid {
            let moves_linear = element.curve.length() > 1.0e-9;
            let feed = if moves_linear { step.feed } else { element.feed_per_min };
            assert!((element.feed_per_min - feed).abs() < 1.0e-3 * feed, "{place}: {}", element.feed_per_min);
        }
        match (&element.curve, step.arc) {
            (Curve::Line { .. }, None) => {}
            (Curve::Arc { center, normal, turns, .. }, Some((expected, signed))) => {
                let along = normal.map(f64::abs);
                for k in 0..3 {
                    // Any point on the axis is valid.
                    let off = (center[k] - expected[k]) * (1.0 - along[k]);
                    assert!(off.abs() < tolerance, "{place}: centre {center:?} instead of {expected:?}");
                }
                assert_eq!(f64::from(*turns) + 1.0, signed.abs(), "{place}");
                let sense: f64 = normal.iter().sum();
                assert_eq!(sense > 0.0, signed > 0.0, "{place}");
            }
            _ => panic!("{place}"),
        }
    }
    assert_eq!(moves.len(), steps.len(), "{name}");
}

fn read(name: &str, options: &ReadOptions) -> Program {
    let path = posts().join(name);
    Program::read(name, &std::fs::read(&path).unwrap(), name, options).unwrap()
}

fn text_of(name: &str) -> String {
    std::fs::read_to_string(posts().join(name)).unwrap()
}

/// Options without and with a controller's files.
fn all_options() -> [ReadOptions; 3] {
    let tools = ToolTable::parse(&text_of("tool.tbl"), "tool.tbl").unwrap();
    let offsets = Offsets::parse(&text_of("controller.var"), "controller.var").unwrap();
    [
        ReadOptions::default(),
        ReadOptions { tools: Some(tools.clone()), block_delete: true, ..ReadOptions::default() },
        ReadOptions { tools: Some(tools), offsets: Some(offsets), ..ReadOptions::default() },
    ]
}

#[test]
fn posts_go_where_linuxcnc_goes() {
    if !installed() {
        return;
    }
    for name in POSTS {
        for (number, mut options) in all_options().into_iter().enumerate() {
            // Without a tool table rs274 refuses T1.
            options.tools = options.tools.or_else(|| ToolTable::parse(&text_of("tool.tbl"), "tool.tbl").ok());
            let steps = rs274(&posts().join(name), &options);
            assert!(steps.len() > 3, "{name}");
            agree(&format!("{name} ({number})"), &read(name, &options).moves, &steps);
        }
    }
}

#[test]
fn the_canonical_output_makes_the_same_moves() {
    if !installed() {
        return;
    }
    let [.., options] = all_options();
    for name in POSTS {
        let own = read(name, &options);
        let through = read_through_rs274(name, &std::fs::read(posts().join(name)).unwrap(), name, &options).unwrap();
        let steps: Vec<Step> = rs274(&posts().join(name), &options);
        agree(&format!("{name} through rs274"), &through.moves, &steps);
        let lines = |program: &Program| program.moves.iter().map(|m| m.line).collect::<Vec<_>>();
        assert_eq!(lines(&own), lines(&through), "{name}");
        let stops = |program: &Program| program.moves.iter().map(|m| m.stop).collect::<Vec<_>>();
        if !matches!(name, "drilling.ngc" | "mach3.tap") {
            assert_eq!(stops(&own), stops(&through), "{name}");
        }
    }
}

#[test]
fn cutter_compensation_comes_through_rs274() {
    if !installed() {
        return;
    }
    let [.., mut options] = all_options();
    options.offsets = None;
    let path = posts().join("subprograms.ngc");
    let bytes = std::fs::read(&path).unwrap();
    let own = Program::read("part", &bytes, "subprograms.ngc", &options).unwrap_err();
    assert_eq!((own.line, own.found.as_str()), (20, "`G41.1`"));
    assert!(own.needed.contains("--interpreter rs274"), "{own}");

    let program = read_through_rs274("part", &bytes, "subprograms.ngc", &options).unwrap();
    agree("subprograms.ngc", &program.moves, &rs274(&path, &options));
    assert_eq!(program.moves.iter().filter(|m| matches!(m.curve, Curve::Arc { .. }) && m.line == 5).count(), 2);

    let refuse = |text: &str| read_through_rs274("part", text.as_bytes(), "part.ngc", &options).unwrap_err();
    let error = refuse("G0 X1\n\n#1 = [1 / 0]\nG0 X#1\nM2\n");
    assert_eq!(error.line, 3, "{error}");
    let error = refuse("G0 X1\nF10 G5.2 X1 Y1 P1\nX2 Y2 P1\nX3 Y1 P1\nG5.3\nM2\n");
    assert!(error.found.contains("NURBS") && error.line == 5, "{error}");
    // Without a tool table tools have no length; a probing move goes to its end.
    let plain = ReadOptions::default();
    let text = "G21 F100 T1 M6\nG43 H7 G0 X1\nG38.2 Z-5\nG1 X[2*3]\nM2\n";
    let probing = read_through_rs274("part", text.as_bytes(), "part.ngc", &plain).unwrap();
    let ends: Vec<_> = probing.moves.iter().map(|m| m.curve.position(1.0)).collect();
    assert_eq!(ends[..2], [[1.0, 0.0, 0.0], [1.0, 0.0, -5.0]]);
    assert!((ends[2][0] - 6.0).abs() < TOLERANCE && probing.moves[1].probe && probing.moves[1].stop, "{ends:?}");
    // Notes name the words of the program.
    let noted: Vec<&str> = probing.notes.iter().map(|note| note.word.as_str()).collect();
    assert_eq!(noted, ["T", "M6", "G38", "--interpreter rs274"]);
    // rs274 does not write a file that a comment requests.
    let log = tempfile::tempdir().unwrap().path().join("log");
    let text = format!("(LOGOPEN,{})\n(LOG,x)\nG0 X1\nM2\n", log.display());
    read_through_rs274("part", text.as_bytes(), "part.ngc", &options).unwrap();
    assert!(!log.exists());
}
