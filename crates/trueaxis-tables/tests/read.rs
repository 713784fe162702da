//! Reads machines from files: the samples, every key, and every refusal.

use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use trueaxis::machine::{Axis, AxisSettings, ErrorModel, Interpolation, Lookup};
use trueaxis::tcomp::Tcomp;
use trueaxis_tables::files::Memory;
use trueaxis_tables::formats::write_axis_csv;
use trueaxis_tables::output::{OutputError, Outputs};
use trueaxis_tables::{Machine, Table, Warning, check, compile, write_atomically};

fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables").join(name)
}

const SAMPLES: [&str; 2] = ["mill-3axis", "mill-5axis"];

#[test]
fn the_samples_compile_and_read_back_identical() {
    for name in SAMPLES {
        let machine = Machine::read(&sample(name)).unwrap();
        assert_eq!(Machine::read(&sample(name).join("machine.toml")).unwrap(), machine);
        let bytes = compile(&machine).unwrap();
        assert_eq!(compile(&machine).unwrap(), bytes, "the same machine, the same bytes");
        let file = Tcomp::parse(&bytes).unwrap();
        assert!(machine.settings.axes.iter().all(|axis| axis.encoder_resolution.is_some()));
        assert_eq!(*file.settings(), machine.settings);
        assert_eq!(file.axes().count(), machine.tables.len());
        for ((_, read), written) in file.axes().zip(&machine.tables) {
            let read = read.map(|table| Table {
                given: table.given(),
                bidirectional: table.bidirectional(),
                rows: table.rows().collect(),
            });
            assert_eq!(read, *written);
        }
        let mut warnings = check(&machine, 10_000.0);
        // The three-axis samples use the nine terms on purpose, and rapid motion need not be without lag.
        let meant =
            |warning: &Warning| matches!(warning, Warning::AnglesIgnored { .. } | Warning::LagAboveLimit { .. });
        warnings.retain(|warning| !meant(warning));
        assert!(warnings.is_empty(), "{name}: {}", warnings[0]);
    }
}

#[test]
fn tables_are_written_as_they_were_read() {
    for name in SAMPLES {
        let machine = Machine::read(&sample(name)).unwrap();
        for (settings, table) in machine.axes() {
            let file = sample(name).join(format!("{}.csv", settings.axis.letter().to_ascii_lowercase()));
            let text = fs::read_to_string(file).unwrap();
            let plain: String = text.lines().filter(|line| !line.starts_with('#')).map(|l| format!("{l}\n")).collect();
            assert_eq!(write_axis_csv(table.unwrap(), settings.axis), plain);
        }
    }
}

/// A folder with a machine of one or two files.
fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

const MACHINE: &str = "name = \"m\"\nchain = \"w X' b C t\"\n[axis.X]\ntable = \"x.csv\"\n";
const TABLE: &str = "X_mm,EXX_um\n0,1\n10,2\n20,3\n";

fn read(machine: &str, table: &str) -> Result<Machine, String> {
    let folder = folder(&[("machine.toml", machine), ("x.csv", table)]);
    Machine::read(folder.path()).map_err(|error| {
        let name = error.file.file_name().unwrap().to_string_lossy().into_owned();
        format!("{name}{}", error.to_string().strip_prefix(&error.file.display().to_string()).unwrap())
    })
}

/// Without a file system, as in a browser.
#[test]
fn a_machine_in_memory_is_the_one_in_its_folder() {
    for name in SAMPLES {
        let paths = fs::read_dir(sample(name)).unwrap().map(|entry| entry.unwrap().path());
        let files = paths
            .filter(|path| path.is_file())
            .map(|path| (PathBuf::from(path.file_name().unwrap()), fs::read(&path).unwrap()));
        let machine = Machine::read_from(&Memory::new(files), Path::new("machine.toml"), &mut |_| {}).unwrap();
        assert_eq!(machine, Machine::read(&sample(name)).unwrap());
    }
    let alone = Memory::new([("./machine.toml", MACHINE)]);
    let error = Machine::read_from(&alone, Path::new("machine.toml"), &mut |_| {}).unwrap_err().to_string();
    let found = "machine.toml:4: key axis.X.table: found \"x.csv\", but no file at x.csv, ";
    assert_eq!(error, format!("{found}needed the CSV of the axis, relative to this file"));
}

#[test]
fn defaults_are_those_stated() {
    let machine = read(MACHINE, TABLE).unwrap();
    let axes = &machine.settings.axes;
    assert_eq!(axes[0], AxisSettings::with_defaults(Axis::X, true));
    assert_eq!(axes[1], AxisSettings::with_defaults(Axis::C, false));
    assert_eq!((axes[0].joint, axes[1].direction), ([-1e6 - 0.1, 1e6 + 0.1], 1));
    assert_eq!(machine.tables[1], None);
    assert_eq!(machine.tables[0].as_ref().unwrap().rows[1].forward, [0.002, 0.0, 0.0, 0.0, 0.0, 0.0]);
}

#[test]
fn every_key_arrives_in_its_unit() {
    let toml = r#"
name = "all keys"
chain = "wX'C'bt"
tool_mm = [1, 2.5, -150]
reference_temperature_c = 22
[axis.X]
table = "x.csv"
interpolation = "cubic"
lookup = "feedback"
cross_lookup = "feedback"
travel_mm = [0, 20]
joint_mm = [-1, 21]
measured_at_mm = [0, 1, 2]
offset_mm = [3, 4, 5]
max_feed_mm_per_min = 6000
backlash_um = 3
hysteresis_um = 4
limits = { magnitude_um = 50, slope_mm_per_s = 2, acceleration_mm_per_s2 = 100 }
thermal = { offset_um_per_k = 2, expansion_um_per_m_k = 11.5, datum_mm = 5 }
[axis.C]
direction = 1
travel_deg = [-400, 400]
max_feed_deg_per_min = 18_000
backlash_urad = 12
hysteresis_urad = 30
[axis.C.limits]
magnitude_urad = 1000
slope_deg_per_s = 3
acceleration_deg_per_s2 = 300
[axis.C.thermal]
offset_urad_per_k = 1
expansion_urad_per_rad_k = 2
datum_deg = 90
[location]
A0Z_urad = 1
B0Z_urad = 2
C0Y_urad = 3
EX0C_um = 4
EY0C_um = 5
EZ0C_um = 6
EA0C_urad = 7
EB0C_urad = 8
EC0C_urad = 9
[faults]
resume_mm = 0.1
resume_deg = 0.2
command_jump_factor = 3
feedback_jump_mm = 0.3
feedback_jump_deg = 0.4
stuck_mm = 0.5
stuck_deg = 0.6
[contour]
max_lag_mm = 2
[compensation]
model = "volumetric"
orientation = true
fade_deg = 3
[kinematics]
tool_axis = [0, 1, 0]
singular_cone_deg = 0.5
"#;
    let s = read(toml, TABLE).unwrap().settings;
    assert_eq!((s.tool_mm, s.reference_temperature_c), ([1.0, 2.5, -150.0], 22.0));
    let [x, c] = &s.axes[..] else { panic!() };
    assert_eq!((x.interpolation, x.lookup, x.cross_lookup), (Interpolation::Cubic, Lookup::Feedback, Lookup::Feedback));
    assert_eq!((x.travel, x.joint, x.measured_at_mm), ([0.0, 20.0], [-1.0, 21.0], [0.0, 1.0, 2.0]));
    assert_eq!(x.offset_mm, [3.0, 4.0, 5.0]);
    let compensation = (s.compensation.model, s.compensation.orientation, s.compensation.fade_deg);
    assert_eq!(compensation, (ErrorModel::Volumetric, true, 3.0));
    assert_eq!((s.kinematics.tool_axis, s.kinematics.singular_cone_deg), ([0.0, 1.0, 0.0], 0.5));
    assert_eq!((x.max_feed_per_s, x.backlash, x.hysteresis), (100.0, 0.003, 0.004));
    assert_eq!((x.limits.magnitude, x.limits.slope_per_s, x.limits.acceleration_per_s2), (0.05, 2.0, 100.0));
    assert_eq!((x.thermal.offset_per_k, x.thermal.expansion_per_k, x.thermal.datum), (0.002, 11.5e-6, 5.0));
    assert_eq!((c.direction, c.travel, c.max_feed_per_s), (1, [-400.0, 400.0], 300.0));
    let degree = std::f64::consts::PI / 180.0;
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");
    near(c.backlash, 12e-6 / degree);
    near(c.hysteresis, 30e-6 / degree);
    near(c.limits.magnitude, 1e-3 / degree);
    near(c.joint[1], 400.0 + 1e-3 / degree);
    near(c.thermal.offset_per_k, 1e-6 / degree);
    assert_eq!((c.limits.slope_per_s, c.limits.acceleration_per_s2), (3.0, 300.0));
    assert_eq!((c.thermal.expansion_per_k, c.thermal.datum), (2e-6, 90.0));
    assert_eq!((s.location.a0z, s.location.b0z, s.location.c0y), (1e-6, 2e-6, 3e-6));
    assert_eq!(s.location.rotary[2], [0.004, 0.005, 0.006, 7e-6, 8e-6, 9e-6]);
    assert_eq!((s.faults.resume, s.faults.command_jump_factor), ([0.1, 0.2], 3.0));
    assert_eq!((s.faults.feedback_jump, s.faults.stuck), ([0.3, 0.4], [0.5, 0.6]));
    assert_eq!(s.contour.max_lag_mm, 2.0);
}

#[test]
fn comments_blanks_order_and_line_ends_do_not_matter() {
    let text = "\u{feff}# first\r\n\r\nECX_urad , EXX_rev_um,X_mm,EXX_fwd_um\r\n# between\r\n 5, 2 ,0,1\r\n\r\n6,3e0,1e1,+2\r\n";
    let machine = read(MACHINE, text).unwrap();
    let table = machine.tables[0].as_ref().unwrap();
    assert_eq!(table.given, [true, false, false, false, false, true]);
    assert!(table.bidirectional);
    assert_eq!(table.rows[1].position, 10.0);
    assert_eq!(table.rows[1].forward, [0.002, 0.0, 0.0, 0.0, 0.0, 6e-6]);
    assert_eq!(table.rows[1].reverse, [0.003, 0.0, 0.0, 0.0, 0.0, 6e-6]);
}

/// Every invalid table: the case, the text, and the beginning and other parts of the error.
#[test]
fn bad_tables_are_refused_with_their_line() {
    let cases = [
        ("X_mm,EXX_um\n# c\n\n0,1\n10,nan\n", "x.csv:5: column EXX_um: found \"nan\", needed a finite number"),
        ("X_mm,EXX_um\n0,1\n-inf,2\n", "x.csv:3: column X_mm: found \"-inf\", needed a finite number"),
        ("X_mm,EXX_um\n0,1\n10,1e999\n", "x.csv:3: column EXX_um: found \"1e999\", needed a finite number"),
        ("X_mm,EXX_um\n0,1\n10,\n", "x.csv:3: column EXX_um: found nothing, needed a number"),
        ("X_mm,EXX_um\n0,1\n10,2um\n", "x.csv:3: column EXX_um: found \"2um\", needed a number"),
        ("X_mm,EXX_um\n0,1\n# c\n10,2\n5,3\n", "x.csv:5: column X_mm: found 5, needed a position above"),
        ("X_mm,EXX_um\n0,1\n10,2\n10,2\n", "x.csv:4: column X_mm: found 10, needed a position above"),
        ("X_mm,EXX_um\n0,1\n", "x.csv: found one line, needed 2 to 65535 lines"),
        ("X_mm,EXX_um\n", "x.csv: found 0 lines, needed 2 to 65535 lines"),
        ("# nothing\n", "x.csv: found nothing but comments, needed a header line, like X_mm,EXX_um"),
        ("", "x.csv: found nothing but comments"),
        ("X_mm,EXX\n0,1\n1,2\n", "x.csv:1: column EXX: found \"EXX\", needed EXX_um (the unit"),
        ("X,EXX_um\n0,1\n1,2\n", "x.csv:1: column X: found \"X\", needed X_mm (the unit"),
        ("X_mm,EXX_mm\n0,1\n1,2\n", "x.csv:1: column EXX_mm: found \"EXX_mm\", needed EXX_um"),
        ("X_mm,EXX_fwd,EXX_rev_um\n0,1,1\n1,2,1\n", "x.csv:1: column EXX_fwd: found \"EXX_fwd\", needed EXX_fwd_um"),
        ("X_mm,EYY_um\n0,1\n1,2\n", "x.csv:1: column EYY_um: found \"EYY_um\", needed one of X_mm EXX_um EYX_um"),
        ("#\nX_mm,EXX_um,EXX_um\n0,1,1\n", "x.csv:2: column EXX_um: found both EXX_um and EXX_um"),
        ("X_mm,X_mm,EXX_um\n0,0,1\n", "x.csv:1: column X_mm: found both X_mm and X_mm"),
        ("X_mm,EXX_um,EXX_fwd_um\n0,0,1\n", "x.csv:1: column EXX_fwd_um: found both EXX_um and EXX_fwd_um"),
        (
            "X_mm,EXX_fwd_um\n0,0\n1,1\n",
            "x.csv:1: column EXX_fwd_um: found one direction only, needed a column EXX_rev_um",
        ),
        (
            "X_mm,EXX_rev_um\n0,0\n1,1\n",
            "x.csv:1: column EXX_rev_um: found one direction only, needed a column EXX_fwd_um",
        ),
        ("EXX_um\n0\n1\n", "x.csv:1: found no column with the position, needed a column X_mm"),
        ("X_mm\n0\n1\n", "x.csv:1: found no column with an error"),
        ("X_mm,EXX_um\n0,1\n10,2,3\n", "x.csv:3: found 3 values, needed 2 as in the header; decimal commas"),
        ("X_mm,EXX_um\n0,1\n10\n", "x.csv:3: found 1 value, needed 2 as in the header"),
        ("X_mm;EXX_um\n0;1\n", "x.csv: found one line, needed 2 to 65535 lines"),
        ("X_mm;EXX_um\n0;1,5\n1;2.5\n", "x.csv:3: column EXX_um: found \"2.5\", needed a decimal comma"),
        (
            "X_mm,EXX_um\n0,0\n1,0\n2,-1000\n3,0\n",
            "x.csv:3: column EXX_um: found a slope of 1.0000 up to the next line, needed a slope of the own error below 1",
        ),
        ("X_mm,EXX_fwd_um,EXX_rev_um\n0,0,0\n0.25,0,500\n", "x.csv:2: column EXX_rev_um: found a slope of 2.0000"),
        ("X_mm,EXX_um\n0,-1e308\n1e-300,1e308\n", "x.csv:2: column EXX_um: found -1e308 um, needed -1000 to 1000 um"),
        (
            "X_mm,EYX_um\n0,0\n0.5,750\n",
            "machine.toml: found a norm of 1.5010 (all tables, thermal growth of 0.001 included), most of it EYX, needed a norm",
        ),
        (
            "X_mm,EYX_um\n0,0\n1,600\n",
            "machine.toml: found a norm of 0.6010 (all tables, thermal growth of 0.001 included), most of it EYX, needed a norm of the errors' Jacobian small enough",
        ),
    ];
    for (table, expected) in cases {
        let error = read(MACHINE, table).expect_err(table);
        assert!(error.starts_with(expected), "{table:?}\n{error}\n{expected}");
    }
}

/// If all errors together are too steep, the error names the source whose removal leaves the smallest slope.
#[test]
fn the_steepest_source_is_the_one_that_is_named() {
    let head = "name = \"m\"\nchain = \"w b X Y Z t\"\n";
    let read = |keys: &str, name: &str, table: &str| {
        let toml = format!("{head}{keys}");
        Machine::read_from(
            &Memory::new([("machine.toml", toml.as_str()), (name, table)]),
            Path::new("machine.toml"),
            &mut |_| {},
        )
        .unwrap_err()
        .to_string()
    };
    let grid = "[location]\nC0Y_urad = 5\n[[grid]]\naxes = [\"X\", \"Y\"]\ntable = \"g.csv\"\n";
    let error = read(grid, "g.csv", "X_mm,Y_mm,EZ_um\n0,0,0\n0,5,0\n5,0,9000\n5,5,9000\n");
    assert!(error.contains("most of it the grid over X and Y, needed a norm"), "{error}");
    // 1 mrad per mm on a lever of 900 mm.
    let turned = "tool_mm = [0, 0, -900]\n[compensation]\nmodel = \"volumetric\"\n[axis.X]\ntable = \"x.csv\"\n";
    let error = read(turned, "x.csv", "X_mm,EXX_um,EBX_urad\n0,0,0\n1,1,1000\n2,0,0\n");
    assert!(error.contains("most of it EBX, needed a norm"), "{error}");
}

#[test]
fn bad_machines_are_refused_with_their_line() {
    let axis = |lines: &str| format!("{MACHINE}{lines}\n");
    let chain = |code: &str| MACHINE.replace("w X' b C t", code);
    let cases = [
        (String::new(), "machine.toml: key name: found nothing, needed the name"),
        (String::from("name = \"m\"\n"), "machine.toml: key chain: found nothing"),
        (String::from("name = m\n"), "machine.toml:1: found"),
        (format!("{MACHINE}[axis.X]\n"), "machine.toml:5: found duplicate key"),
        (MACHINE.replace("\"m\"", "\"\""), "machine.toml:1: key name: found \"\", needed a name of 1 to 64 bytes"),
        (MACHINE.replace("\"m\"", &format!("\"{}\"", "n".repeat(65))), "machine.toml:1: key name: found"),
        (MACHINE.replace("\"m\"", "3"), "machine.toml:1: key name: found 3, needed a string"),
        (chain(""), "machine.toml:2: key chain: found \"\", needed w, the workpiece"),
        (chain("X' b C t"), "machine.toml:2: key chain: found \"X' b C t\", needed w, the workpiece"),
        (chain("w X b C t"), "machine.toml:2: key chain: found \"w X b C t\", needed a prime"),
        (chain("w X' b C' t"), "machine.toml:2: key chain: found \"w X' b C' t\", needed no prime"),
        (chain("w X' b X t"), "machine.toml:2: key chain: found \"w X' b X t\", needed each axis at most once"),
        (chain("w X' C t"), "machine.toml:2: key chain: found \"w X' C t\", needed a prime"),
        (chain("w X' t"), "machine.toml:2: key chain: found \"w X' t\", needed X' Y' Z'"),
        (chain("w X' b C"), "machine.toml:2: key chain: found \"w X' b C\", needed t, the tool"),
        (chain("w X' b C t t"), "machine.toml:2: key chain: found \"w X' b C t t\", needed nothing after t"),
        (chain("w X' b U t"), "machine.toml:2: key chain: found \"w X' b U t\", needed X Y Z A B C, or t"),
        (axis("[axis.Y]"), "machine.toml:5: key axis.Y: found Y, needed an axis of the chain (X C)"),
        (axis("[axis.U]"), "machine.toml:5: key axis.U: found U, needed an axis of the chain (X C)"),
        (axis("colour = 1"), "machine.toml:5: key axis.X.colour: found colour, needed one of table, interpolation"),
        (axis("direction = 1"), "machine.toml:5: key axis.X.direction"),
        (axis("travel_deg = [0, 1]"), "machine.toml:5: key axis.X.travel_deg"),
        (axis("[axis.X.limits]\nslope = 1"), "machine.toml:6: key axis.X.limits.slope"),
        (axis("[axis.X.thermal]\nk = 1"), "machine.toml:6: key axis.X.thermal.k"),
        (axis("[location]\nEXOC_um = 1"), "machine.toml:6: key location.EXOC_um"),
        (axis("[location]\nEX0A_um = 1"), "machine.toml:6: key location.EX0A_um"),
        (axis("[faults]\nresume = 1"), "machine.toml:6: key faults.resume"),
        (axis("[contour]\nlag = 1"), "machine.toml:6: key contour.lag"),
        (axis("[roundnes]"), "machine.toml:5: key roundnes"),
        (axis("travel_mm = [1, 0]"), "machine.toml:5: key axis.X.travel_mm: found [1, 0], needed a high end above"),
        (axis("travel_mm = [0, nan]"), "machine.toml:5: key axis.X.travel_mm: found nan, needed a finite number"),
        (axis("travel_mm = [0, 1, 2]"), "machine.toml:5: key axis.X.travel_mm: found [0, 1, 2], needed a list of 2"),
        (axis("travel_mm = [0, \"1\"]"), "machine.toml:5: key axis.X.travel_mm: found \"1\", needed a number"),
        (axis("backlash_um = inf"), "machine.toml:5: key axis.X.backlash_um: found inf, needed a finite number"),
        (axis("hysteresis_um = -1"), "machine.toml:5: key axis.X.hysteresis_um: found -1, needed 0 to 100 um"),
        (axis("max_feed_mm_per_min = 0"), "machine.toml:5: key axis.X.max_feed_mm_per_min: found 0, needed 0.001 to"),
        (
            axis("interpolation = \"spline\""),
            "machine.toml:5: key axis.X.interpolation: found \"spline\", needed \"linear\" or \"cubic\"",
        ),
        (axis("lookup = \"both\""), "machine.toml:5: key axis.X.lookup"),
        (
            axis("limits = { magnitude_um = -5 }"),
            "machine.toml:5: key axis.X.limits.magnitude_um: found -5, needed 0.001 to 10000 um",
        ),
        (axis("[axis.C]\ndirection = 2"), "machine.toml:6: key axis.C.direction: found 2, needed 1 or -1"),
        (
            axis("[faults]\nstuck_mm = 1\nstuck_deg = 0"),
            "machine.toml:7: key faults.stuck_deg: found 0, needed 1e-6 to 1000",
        ),
        (axis("[faults]\ncommand_jump_factor = 0.5"), "machine.toml:6: key faults.command_jump_factor: found 0.5"),
        (
            axis("[contour]\nmax_lag_mm = 0"),
            "machine.toml:6: key contour.max_lag_mm: found 0, needed a max_lag_mm of 0.001",
        ),
        (
            MACHINE.replace("name =", "reference_temperature_c = -300\nname ="),
            "machine.toml:1: key reference_temperature_c: found -300",
        ),
        (MACHINE.replace("x.csv", "gone.csv"), "machine.toml:4: key axis.X.table: found \"gone.csv\", but no file at"),
        (MACHINE.replace("x.csv", "."), "machine.toml:4: key axis.X.table: found \".\", but no file"),
        (
            axis("travel_mm = [0, 20]\njoint_mm = [-0.0005, 21]"),
            "machine.toml:6: key axis.X.joint_mm: found -0.001 mm as command + correction",
        ),
        (
            axis("travel_mm = [0, 20]\njoint_mm = [1, 21]"),
            "machine.toml:6: key axis.X.joint_mm: found [1, 21], needed a range that contains the travel",
        ),
    ];
    for (machine, expected) in cases {
        let error = read(&machine, TABLE).expect_err(&machine);
        assert!(error.starts_with(expected), "{machine}\n{error}\n{expected}");
    }
}

#[test]
fn open_circles_are_refused_and_the_tolerance_is_taken() {
    let machine = "name = \"m\"\nchain = \"w b C t\"\n[axis.C]\ntable = \"x.csv\"\n";
    let good = "C_deg,EXC_um,ECC_urad\n-180,1,5\n0,0,0\n180,1.01,5.01\n";
    assert!(read(machine, good).is_ok());
    let error = read(machine, &good.replace("5.01", "5.02")).unwrap_err();
    assert!(error.starts_with("x.csv:4: column ECC_urad: found 5.02 urad, needed the value at the start"), "{error}");
    let error = read(machine, &good.replace("1.01", "0.98")).unwrap_err();
    assert!(error.starts_with("x.csv:4: column EXC_um: found 0.98 um"), "{error}");
    // A sector does not wrap around.
    assert!(read(machine, &good.replace("180,1.01,5.01", "179,7,8")).is_ok());
    // 2 degrees of error over one degree.
    let error = read(machine, "C_deg,ECC_urad\n0,0\n0.25,8726.65\n").unwrap_err();
    assert!(error.starts_with("x.csv:2: column ECC_urad: found a slope of 2.0000"), "{error}");
}

#[test]
fn bytes_that_are_no_text_and_missing_files() {
    let bad = folder(&[("machine.toml", MACHINE)]);
    fs::write(bad.path().join("x.csv"), b"X_mm,EXX_um\n0,1\n10,\xff\n").unwrap();
    let error = Machine::read(bad.path()).unwrap_err();
    assert_eq!((error.line, error.needed.as_str()), (Some(3), "text in UTF-8"));
    fs::write(bad.path().join("machine.toml"), b"\n\xc3").unwrap();
    assert_eq!(Machine::read(bad.path()).unwrap_err().line, Some(2));
    let missing = Machine::read(&bad.path().join("nowhere")).unwrap_err();
    assert_eq!((missing.line, missing.needed.as_str()), (None, "a readable file"));
}

#[test]
fn writing_leaves_either_the_old_or_the_new_file() {
    let folder = folder(&[("t.tcomp", "old")]);
    let file = folder.path().join("t.tcomp");
    write_atomically(&file, b"new").unwrap();
    assert_eq!(fs::read(&file).unwrap(), b"new");
    // A file cannot replace a folder: the write is refused, and no temporary file remains beside it.
    fs::create_dir(folder.path().join("d")).unwrap();
    fs::write(folder.path().join("d/in"), "").unwrap();
    assert!(write_atomically(&folder.path().join("d"), b"new").is_err());
    assert!(write_atomically(&folder.path().join("no/where"), b"new").is_err());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

/// A link stays a link, and a target that is not a regular file is written to rather than replaced.
#[cfg(unix)]
#[test]
fn links_and_pipes_are_written_through() {
    use std::os::unix::fs::{FileTypeExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (folder.path().join("file"), folder.path().join("link"));
    fs::write(&file, "old").unwrap();
    symlink(&file, &link).unwrap();
    write_atomically(&link, b"new").unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read_to_string(&file).unwrap(), "new");
    // Files that do not exist yet, through a link to a link that is relative to its own folder.
    let inner = folder.path().join("inner");
    fs::create_dir(&inner).unwrap();
    symlink("inner/second", folder.path().join("first")).unwrap();
    symlink("../third", inner.join("second")).unwrap();
    let mut outputs = Outputs::default();
    outputs.put(&folder.path().join("first"), b"new").unwrap();
    assert!(matches!(outputs.put(&folder.path().join("third"), b"new"), Err(OutputError::Twice(_))));
    outputs.commit().unwrap();
    assert_eq!(fs::read_to_string(folder.path().join("third")).unwrap(), "new");
    assert!(folder.path().join("first").is_symlink() && inner.join("second").is_symlink());
    for (name, to) in [("round", "round"), ("astray", "nothing/file")] {
        let link = folder.path().join(name);
        symlink(to, &link).unwrap();
        write_atomically(&link, b"new").unwrap_err();
        assert!(link.is_symlink());
    }
    let pipe = folder.path().join("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let read = std::thread::spawn({
        let pipe = pipe.clone();
        move || fs::read_to_string(pipe).unwrap()
    });
    write_atomically(&pipe, b"through").unwrap();
    assert_eq!(read.join().unwrap(), "through");
    assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
}
