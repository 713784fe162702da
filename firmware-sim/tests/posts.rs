//! Programs emitted by post-processors run; offsets, tools and cycles give the positions in LinuxCNC's documentation; programs
//! that are too long or unsupported are refused with the line.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use trueaxis_sim::program::{Offsets, Program, ProgramError, ReadOptions, ToolTable};

fn posts() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/posts")
}

fn simulator(program: &Path, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_firmware-sim"));
    command.args(["run", "--program"]).arg(program);
    if !more.contains(&"--rate-hz") {
        command.args(["--rate-hz", "500"]);
    }
    command.args(more).output().unwrap()
}

fn refused(text: &str, more: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("part.ngc");
    std::fs::write(&file, text).unwrap();
    let output = simulator(&file, more);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(output.stdout.is_empty());
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn every_post_runs() {
    let mut ran = 0;
    for entry in std::fs::read_dir(posts()).unwrap() {
        let file = entry.unwrap().path();
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        if !matches!(file.extension().and_then(|e| e.to_str()), Some("ngc" | "nc" | "tap")) || name == "subprograms.ngc"
        {
            continue;
        }
        let machine = if name.starts_with("five-axis") { "mill-5axis" } else { "mill-3axis" };
        let output = simulator(&file, &["--json", "--machine", machine]);
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        let run: Value = serde_json::from_slice(&output.stdout).unwrap();
        let error = |which: &str| run["contour_error_um"][which]["rms"].as_f64().unwrap();
        assert!(error("compensated") < error("uncompensated"), "{name}");
        if name == "fusion-linuxcnc.ngc" {
            let noted = run["noted"].as_array().unwrap();
            let coolant = noted.iter().find(|note| note["word"] == "M8").unwrap();
            assert_eq!((coolant["count"].as_u64(), coolant["line"].as_u64()), (Some(2), Some(15)));
        }
        ran += 1;
    }
    assert_eq!(ran, 12);
    let output = simulator(&posts().join("mach3.tap"), &["--block-delete"]);
    let summary = String::from_utf8(output.stdout).unwrap();
    assert!(
        summary.contains("\nnoted, no effect: T (1), M6 (1), S (1), M3 (1), M8 (1), M9 (1), M5 (1)\n"),
        "{summary}"
    );
}

#[test]
fn too_long_a_run_is_refused_before_it_begins() {
    let error = refused("G0 X1\nG1 X10 F0.001\n", &["--rate-hz", "10000"]);
    assert!(error.contains("part.ngc:2: found a program of more than 150.0 hours"), "{error}");
    assert!(error.contains("at most 1e9 servo cycles, 27.8 hours at 10000 Hz"), "{error}");
    let error = refused("F1000 G2 I5 P9999\n", &[]);
    assert!(error.contains("part.ngc:1: found P9999") && error.contains("1 to 1000"), "{error}");
    let error = refused(&format!("F1000\n{}", "G2 I5 P1000\n".repeat(200)), &[]);
    assert!(error.contains("part.ngc:168: found a program of 2004000 pieces") && error.contains("2000000"), "{error}");
    let error = refused("F1000 G83 X1 Z-100 R0 Q0.00001\n", &[]);
    assert!(error.contains("part.ngc:1: found a line of 30000000 moves"), "{error}");
    let error = refused("F1000 G91 G81 X1 Z-1 R0 L9999999\n", &[]);
    assert!(error.contains("part.ngc:1: found `L9999999`"), "{error}");
}

#[test]
fn words_that_only_linuxcnc_reads_are_refused_with_the_option() {
    for text in ["G0 X1\nG33 K1 Z1\n", "G0 X1\nG41 D1\n", "G0 X1\nM66 P0 L0\n"] {
        let error = refused(text, &[]);
        assert!(error.contains("part.ngc:2: found `") && error.contains("--interpreter rs274"), "{error}");
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("part.ngc");
    std::fs::write(&file, "G0 X1\n").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_firmware-sim"));
    command.args(["run", "--interpreter", "rs274", "--program"]).arg(&file).env("PATH", folder.path());
    let output = command.output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(error.contains("no LinuxCNC interpreter") && error.contains("linuxcnc-uspace"), "{error}");
}

fn text_of(name: &str) -> String {
    std::fs::read_to_string(posts().join(name)).unwrap()
}

fn read(text: &str, options: &ReadOptions) -> Result<Program, ProgramError> {
    Program::read("test", text.as_bytes(), "part.ngc", options)
}

/// End positions of the moves.
fn ends(text: &str, options: &ReadOptions) -> Vec<[f64; 3]> {
    let program = read(text, options).unwrap();
    program.moves.iter().map(|m| m.curve.position(m.curve.domain().1)).collect()
}

fn assert_ends(text: &str, options: &ReadOptions, expected: &[[f64; 3]]) {
    let found = ends(text, options);
    assert_eq!(found.len(), expected.len(), "{text}: {found:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-9), "{text}: {found:?} instead of {expected:?}");
    }
}

#[test]
fn coordinates_count_from_where_the_words_say() {
    let none = ReadOptions::default();
    let cases: [(&str, &[[f64; 3]]); 12] = [
        ("G10 L2 P2 X10 Y20\nG55 G0 X1 Y1", &[[11.0, 21.0, 0.0]]),
        ("G10 L2 P1 X10 R90\nG0 X1 Y2", &[[8.0, 1.0, 0.0]]),
        ("G0 X5\nG10 L20 P1 X1 Z2\nX2 Z3", &[[5.0, 0.0, 0.0], [6.0, 0.0, 1.0]]),
        (
            "G0 X5\nG92 X0\nX1\nG92.2 X1\nG92.3 X1\nG92.1 X1",
            &[[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [1.0, 0.0, 0.0], [6.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
        ),
        ("G52 X3\nG0 X1\nG52 X0\nX1", &[[4.0, 0.0, 0.0], [1.0, 0.0, 0.0]]),
        ("G10 L2 P1 X10\nG0 X1\nG53 X1\nX1", &[[11.0, 0.0, 0.0], [1.0, 0.0, 0.0], [11.0, 0.0, 0.0]]),
        ("G43.1 Z10\nG0 Z1\nG49\nZ1", &[[0.0, 0.0, 11.0], [0.0, 0.0, 1.0]]),
        (
            "G0 X1 Z1\nG28.1\nX5 Z5\nG91 G28 Z2\nG90 G28",
            &[[1.0, 0.0, 1.0], [5.0, 0.0, 5.0], [5.0, 0.0, 7.0], [5.0, 0.0, 1.0], [1.0, 0.0, 1.0]],
        ),
        ("G20 G0 X1 Y- .5", &[[25.4, -12.7, 0.0]]),
        ("%\nO1\ng0x1\n%\nG0 X9", &[[1.0, 0.0, 0.0]]),
        ("G0 X1\n/G0 X2\n/3 G0 X3\nM30\n@ anything", &[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]]),
        ("G0 G80 X1\nG80 G0 G17 G40 G49 G90 X2", &[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]),
    ];
    for (text, expected) in cases {
        assert_ends(text, &none, expected);
    }
    let without = ReadOptions { block_delete: true, ..ReadOptions::default() };
    assert_ends("G0 X1\n /G0 X2\nN3 X4", &without, &[[1.0, 0.0, 0.0], [4.0, 0.0, 0.0]]);
}

#[test]
fn cycles_go_down_and_up() {
    let none = ReadOptions::default();
    let down = |x: f64, heights: &[f64]| heights.iter().map(|z| [x, 0.0, *z]).collect::<Vec<_>>();
    assert_ends(
        "F9 G0 Z9\nG98 G81 X1 Z-1 R2\nG99 X2",
        &none,
        &[down(0.0, &[9.0]), down(1.0, &[9.0, 2.0, -1.0, 9.0]), down(2.0, &[9.0, 2.0, -1.0, 2.0])].concat(),
    );
    assert_ends(
        "F9 G0 Z2\nG83 X1 Z-3 R2 Q2",
        &none,
        &[down(0.0, &[2.0]), down(1.0, &[2.0, 0.0, 2.0, 0.254, -2.0, 2.0, -1.746, -3.0, 2.0])].concat(),
    );
    assert_ends(
        "F9 G0 Z2\nG73 X1 Z-1 R2 Q2",
        &none,
        &[down(0.0, &[2.0]), down(1.0, &[2.0, 0.0, 0.254, -1.0, 2.0])].concat(),
    );
    let bored = read("F9 G0 Z5\nG98 G89 X1 Z-1 R2 P.1", &none).unwrap();
    let rapid: Vec<bool> = bored.moves.iter().map(|m| m.rapid).collect();
    assert_eq!(rapid, [true, true, true, false, false]);
    assert!(bored.moves[3].stop, "the dwell at the bottom");
}

#[test]
fn files_of_a_controller() {
    let var = Offsets::parse(&text_of("controller.var"), "controller.var").unwrap();
    assert_eq!(var, Offsets::parse(&text_of("controller.toml"), "controller.toml").unwrap());
    assert_eq!((var.systems[1].offset[0], var.systems[1].rotation_deg, var.home[1][2]), (-2.0, 30.0, 25.0));
    let tools = ToolTable::parse(&text_of("tool.tbl"), "tool.tbl").unwrap();
    let options = ReadOptions { tools: Some(tools), offsets: Some(var), ..ReadOptions::default() };
    // G54 is at 3, 4, −1.5, shifted by G92 0.5, −0.25; tool 1 is 12.5 long.
    assert_ends(
        "G0 X1 Y1\nG43 H1 Z1\nT2 M6 G43 Z1\nG28 Z5",
        &options,
        &[[4.5, 4.75, 0.0], [4.5, 4.75, 12.0], [4.5, 4.75, -3.5], [4.5, 4.75, 0.5], [4.5, 4.75, 30.0]],
    );
    let error = read("G0 X1\nG43 H7", &options).unwrap_err();
    assert_eq!((error.line, error.found.as_str()), (2, "tool 7"));
    assert_eq!(read("T9", &options).unwrap_err().found, "tool 9");

    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let cases = [
        (ToolTable::parse("T1 P1 Z5\nP2 Z3\n", "a.tbl").err(), 2, "`P2 Z3`"),
        (ToolTable::parse("T1 Z5\nT1 Z6\n", "b.tbl").err(), 2, "second time"),
        (ToolTable::parse("POC FMS LEN DIAM\n", "c.tbl").err(), 1, "`POC`"),
        (ToolTable::parse("T1 Z1e308\n", "d.tbl").err(), 1, "Z1e308"),
        (Offsets::parse("5221 1\n5222 x\n", "a.var").err(), 2, "5222 x"),
        (Offsets::parse("5221\tNaN\n", "b.var").err(), 1, "NaN"),
        (Offsets::parse("5220 12\n", "c.var").err(), 1, "5220 12"),
        (Offsets::parse("[G54]\nx_mm = 1\n[G77]\nx_mm = 1\n", "a.toml").err(), 3, "G77"),
        (Offsets::parse("[G54]\nx = 1\n", "b.toml").err(), 2, "unknown field"),
        (Offsets::parse("\nactive = \"G60\"\n", "c.toml").err(), 2, "G60"),
        (Offsets::parse("[G54]\nx_mm = inf\n", "d.toml").err(), 1, "inf"),
    ];
    for (error, line, found) in cases {
        let error = error.unwrap();
        assert!(error.line == line && error.found.contains(found), "{error}");
    }
    let output = simulator(&file("p.ngc", "G0 X1\n"), &["--tool-table", &file("e.tbl", "T1 P1 Q\n").to_string_lossy()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("e.tbl:1: found `Q`"));
}

#[test]
fn a_program_probes_the_surface_it_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    file(
        "map.csv",
        "RepRapFirmware height map file v2\nxmin,xmax,ymin,ymax,radius,spacing,xnum,ynum\n0,9,0,9,-1,9,2,2\n1,1\n1,1\n",
    );
    let surface = file("surface.toml", "[height_map]\nfile = \"map.csv\"\nz_mm = -3\n").display().to_string();
    let program = file("p.ngc", "G21 F600 G38.2 Z-9\nG1 X[#5070*3]\nM2\n");
    let digest = |program: &Path, more: &[&str]| {
        let output = simulator(program, &[&["--json"], more].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let run: Value = serde_json::from_slice(&output.stdout).unwrap();
        run["digest"].clone()
    };
    let lines = file("q.ngc", "G21 F600 G61.1 G1 Z-2\nG1 X3\nM2\n");
    assert_eq!(digest(&program, &["--surface", &surface]), digest(&lines, &[]));
    assert_ne!(digest(&program, &[]), digest(&lines, &[]));
    let with = |more: &[&str]| String::from_utf8(simulator(&program, more).stderr).unwrap();
    let error = with(&["--surface", &surface, "--interpreter", "rs274"]);
    assert!(error.contains("found --surface with --interpreter rs274"), "{error}");
    assert!(with(&["--surface", "none.toml"]).contains("none.toml:1: found a file that cannot be read"));
}
