//! The commands as called, on files whose results can be worked out by hand.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

fn samples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables")
}

/// Rows of a CSV as numbers (true = 1), by column name.
fn column(csv: &str, name: &str) -> Vec<f64> {
    let mut lines = csv.lines();
    let place = lines.next().unwrap().split(',').position(|c| c == name).unwrap_or_else(|| panic!("no {name}"));
    lines
        .map(|line| match line.split(',').nth(place).unwrap() {
            "true" => 1.0,
            "false" => 0.0,
            number => number.parse().unwrap(),
        })
        .collect()
}

/// X: 10 µm at 0 to 30 µm at 100; Y: straightness; C: wraps. Squareness 20 µrad.
fn small_machine(directory: &Folder) {
    directory.write(
        "m/machine.toml",
        "name = \"small\"\nchain = \"w C' X' b Y Z t\"\n[axis.X]\ntable = \"x.csv\"\ntravel_mm = [-50, 150]\n\
         [axis.Y]\ntable = \"y.csv\"\n[axis.C]\ntable = \"c.csv\"\n[location]\nC0Y_urad = 20\n",
    );
    directory.write("m/x.csv", "X_mm,EXX_um,EZX_um\n0,10,-4\n100,30,4\n");
    directory.write("m/y.csv", "# straightness\nEXY_um,Y_mm\n0,-100\n8,0\n2,300\n");
    directory.write("m/c.csv", "C_deg,EXC_um,EYC_um\n0,0,1\n90,6,1\n180,0,1\n270,-6,1\n360,0,1\n");
}

#[test]
fn errors_and_corrected_commands_are_what_the_tables_say() {
    let directory = Folder::new(TRUEAXIS);
    small_machine(&directory);
    directory.write("p.csv", "x_mm,y_mm,z_mm,c_deg\n25,150,5,45\n25,150,5,1000045\n25,150,5,-675\n-40,-100,0,0\n");
    let csv = directory.good(&["compensate", "m", "p.csv"]);
    assert!(csv.starts_with("x_mm,y_mm,z_mm,c_deg,ex_um,ey_um,ez_um,cx_mm,cy_mm,cz_mm\n25,150,5,45,"));
    // EXX 15, EXY 5, squareness −20e-6 · 150 mm = −3 µm, EXC 3; 1000045 = 2777 · 360 + 325 degrees: EXC = −6 · 35/90.
    let ex = column(&csv, "ex_um");
    for (found, truth) in ex.iter().zip([20.0, 17.0 - 6.0 * 35.0 / 90.0, 20.0, 10.0 + 2.0]) {
        assert!((found - truth).abs() < 1e-9, "{ex:?}");
    }
    assert!(column(&csv, "ey_um").iter().all(|e| (e - 1.0).abs() < 1e-9));
    let ez = column(&csv, "ez_um");
    assert!((ez[0] + 2.0).abs() < 1e-9 && (ez[3] + 4.0).abs() < 1e-9, "{ez:?}");
    // The corrected command reaches the target: q' + E(q') = q. In the first row E is linear in x and y.
    let (cx, cy) = (column(&csv, "cx_mm")[0], column(&csv, "cy_mm")[0]);
    let error = |x: f64, y: f64| 1e-3 * (10.0 + 0.2 * x + 8.0 - 0.02 * y + 3.0) - 20e-6 * y;
    assert!((cx + error(cx, cy) - 25.0).abs() < 1e-6);
    // One look-up: minus the error at the uncorrected command.
    let once = directory.good(&["compensate", "m", "p.csv", "--inverse-passes", "1", "--model", "nine"]);
    assert!((column(&once, "cx_mm")[0] - (25.0 - 0.020)).abs() < 1e-12);
    let _ = directory.good(&["compensate", "m/machine.toml", "p.csv", "-o", "out.csv"]);
    assert_eq!(directory.read("out.csv"), csv);
}

#[test]
fn the_held_out_interpolation_is_the_tables_own() {
    let directory = Folder::new(TRUEAXIS);
    let mut table = String::from("X_mm,EXX_um\n");
    let value = |i: i32| f64::from((i * 7919) % 41) - 20.0;
    for i in 0..64 {
        table.push_str(&format!("{},{}\n", 5 * i, value(i)));
    }
    directory.write("m/machine.toml", "name = \"t\"\nchain = \"w b X Y Z t\"\n[axis.X]\ntable = \"x.csv\"\n");
    directory.write("m/x.csv", &table);
    let mut positions = String::from("x_mm,y_mm,z_mm\n");
    let places: Vec<f64> = (0..3000).map(|i| f64::from(i) * 0.105).collect();
    for x in &places {
        positions.push_str(&format!("{x},0,0\n"));
    }
    directory.write("p.csv", &positions);
    let csv = directory.good(&["compensate", "m", "p.csv"]);
    for (x, found) in places.iter().zip(column(&csv, "ex_um")) {
        let cell = ((x / 5.0) as i32).min(62);
        let t = x / 5.0 - f64::from(cell);
        assert!((found - (value(cell) + t * (value(cell + 1) - value(cell)))).abs() < 1e-9, "{x}");
    }
}

#[test]
fn bad_positions_are_refused_with_their_place() {
    let directory = Folder::new(TRUEAXIS);
    small_machine(&directory);
    let cases: [(&str, &[&str]); 9] = [
        ("x_mm,y_mm,z_mm\n1,2,nan\n", &["p.csv:2", "z_mm", "nan", "finite"]),
        ("x_mm,y_mm,z_mm\n1,2,3\n1,inf,3\n", &["p.csv:3", "y_mm"]),
        ("x_mm,y_mm\n1,2\n", &["p.csv:1", "z_mm"]),
        ("x_mm,y_mm,z_mm,q_mm\n1,2,3,4\n", &["p.csv:1", "q_mm"]),
        ("x_mm,y_mm,z_mm,x_mm\n1,2,3,4\n", &["p.csv:1", "x_mm"]),
        ("x_mm,y_mm,z_mm\n1,2\n", &["p.csv:2", "2 values", "3"]),
        ("x_mm,y_mm,z_mm\n", &["no rows"]),
        ("x_mm,y_mm,z_mm,a_deg\n1,2,3,4\n", &["a_deg"]),
        ("x_mm,y_mm,z_mm\n151,2,3\n", &["p.csv:2", "x_mm", "151", "-50 to 150"]),
    ];
    for (text, parts) in cases {
        directory.write("p.csv", text);
        directory.bad(&["compensate", "m", "p.csv", "-o", "out.csv"], parts);
        assert!(!directory.has("out.csv"));
    }
    directory.write("p.csv", "x_mm,y_mm,z_mm\n1,2,3\n");
    directory.bad(&["compensate", "m", "missing.csv"], &["missing.csv"]);
    directory.bad(&["compensate", "nowhere", "p.csv"], &["nowhere"]);
    directory.bad(&["compensate", "m", "p.csv", "--inverse-passes", "9"], &["9"]);
    directory.bad(&["compensate", "m", "p.csv", "--model", "guess"], &["nine"]);
}

#[test]
fn tables_check_compile_show_and_damage() {
    let directory = Folder::new(TRUEAXIS);
    small_machine(&directory);
    let text = directory.good(&["tables", "check", "m"]);
    assert!(text.contains("small") && text.contains("no errors"));
    let document: Value = serde_json::from_str(&directory.good(&["tables", "check", "m", "--json"])).unwrap();
    assert_eq!(document["ok"], true);
    assert_eq!(directory.good(&["tables", "compile", "m", "-o", "t.tcomp"]), "");
    let shown: Value = serde_json::from_str(&directory.good(&["tables", "show", "t.tcomp", "--json"])).unwrap();
    assert_eq!((shown["name"].as_str(), shown["chain"].as_str()), (Some("small"), Some("w C' X' b Y Z t")));
    assert!(directory.good(&["tables", "show", "t.tcomp"]).contains("small"));
    // The compiled file gives the same corrections as its source.
    directory.write("p.csv", "x_mm,y_mm,z_mm\n25,150,5\n");
    assert_eq!(directory.good(&["compensate", "m", "p.csv"]), directory.good(&["compensate", "t.tcomp", "p.csv"]));
    let bytes = fs::read(directory.join("t.tcomp")).unwrap();
    for damage in
        [&bytes[..bytes.len() - 1], &bytes[..20], &[], b"not tables at all, but long enough to look like some"]
    {
        directory.write("bad.tcomp", damage);
        directory.bad(&["tables", "show", "bad.tcomp"], &["bad.tcomp"]);
        directory.bad(&["compensate", "bad.tcomp", "p.csv"], &["bad.tcomp"]);
    }
    let mut flipped = bytes.clone();
    flipped[bytes.len() / 2] ^= 0x10;
    directory.write("bad.tcomp", flipped);
    directory.bad(&["tables", "show", "bad.tcomp"], &["bad.tcomp"]);
}

#[test]
fn bad_machines_are_refused_and_nothing_is_written() {
    let directory = Folder::new(TRUEAXIS);
    let cases: [(&str, &str, &[&str]); 10] = [
        ("x.csv", "X_mm,EXX_um\n0,1\n0,2\n", &["x.csv:3", "X_mm"]),
        ("x.csv", "X_mm,EXX_um\n0,1\n10,nan\n", &["x.csv:3", "EXX_um", "nan"]),
        ("x.csv", "X_mm,EXX_um\n10,1\n0,2\n", &["x.csv:3"]),
        ("x.csv", "X_mm,EXX_um\n0,1\n", &["x.csv"]),
        ("x.csv", "X_mm,EXX\n0,1\n10,2\n", &["x.csv:1", "EXX"]),
        ("x.csv", "X_mm,EXX_um\n0,0\n1,1000\n", &["x.csv", "EXX"]),
        ("c.csv", "C_deg,EXC_um\n0,0\n360,5\n", &["c.csv", "EXC"]),
        (
            "machine.toml",
            "name = \"s\"\nchain = \"w X' X b Z t\"\n[axis.X]\ntable=\"x.csv\"\n",
            &["machine.toml", "chain"],
        ),
        (
            "machine.toml",
            "name = \"s\"\nchain = \"w X' b Z t\"\nspeed = 3\n[axis.X]\ntable=\"x.csv\"\n",
            &["machine.toml:3", "speed"],
        ),
        ("machine.toml", "name = \"s\"\nchain = \"w X' b Z t\"\n[axis.X]\ntable=\"none.csv\"\n", &["none.csv"]),
    ];
    for (file, text, parts) in cases {
        small_machine(&directory);
        directory.write(format!("m/{file}"), text);
        directory.bad(&["tables", "compile", "m", "-o", "t.tcomp"], parts);
        directory.bad(&["tables", "check", "m"], parts);
        assert!(!directory.has("t.tcomp"));
    }
}

const PATH: &str = r#"{"segments":[
  {"type":"line","start":[0,0,0],"end":[10,0,0]},
  {"type":"arc","start":[10,0,0],"end":[10,20,0],"center":[10,10,0],"normal":[0,0,1],"turns":0},
  {"type":"nurbs","degree":2,"knots":[0,0,0,2,2,2],"points":[[10,20,0],[5,20,0],[0,20,5]],"weights":[1,1,1]}]}"#;

#[test]
fn contour_errors_on_a_line_an_arc_and_a_spline() {
    let directory = Folder::new(TRUEAXIS);
    directory.write("path.json", PATH);
    let (s, c) = 0.3_f64.sin_cos();
    let inside = format!("{},{},0", 10.0 + 9.99 * s, 10.0 - 9.99 * c);
    // The spline is (10 − 5v, 20, 5/4 v²), v = u; at v = 1 its tangent is (−5, 0, 2.5), perpendicular to an offset of 3 µm
    // along y.
    directory.write("actual.csv",
        format!(
            "segment,u,x_mm,y_mm,z_mm\n0,0.503,5,0.004,-0.003\n1,0.1,{inside}\n2,1.01,5,20.003,1.25\n0,1,10.002,-0.003,0\n"
        ),
    );
    for method in ["guarded", "bisection"] {
        let csv = directory.good(&["contour", "path.json", "actual.csv", "--method", method]);
        assert!(csv.starts_with("segment,u,error_um,ex_um,ey_um,ez_um,evaluations,bracketed\n"));
        let error = column(&csv, "error_um");
        for (found, truth) in error.iter().zip([5.0, 10.0, 3.0]) {
            assert!((found - truth).abs() < 1e-5, "{method}: {csv}");
        }
        assert_eq!(column(&csv, "segment")[..3], [0.0, 1.0, 2.0]);
        let u = column(&csv, "u");
        assert!(
            (u[0] - 0.5).abs() < 1e-9 && (u[1] - 0.3 / std::f64::consts::PI).abs() < 1e-9 && (u[2] - 1.0).abs() < 1e-9
        );
        assert!((column(&csv, "ey_um")[0] - 4.0).abs() < 1e-6 && (column(&csv, "ez_um")[0] + 3.0).abs() < 1e-6);
        assert!(column(&csv, "bracketed").iter().all(|b| *b == 1.0));
        // Past the line's end the path continues with the arc: radius 10, centre (10, 10).
        assert!((error[3] - 1e3 * ((0.002_f64).hypot(10.003) - 10.0)).abs() < 1e-5);
    }
    let far = "segment,u,x_mm,y_mm,z_mm\n0,0.5,8,0,0\n";
    directory.write("far.csv", far);
    assert_eq!(column(&directory.good(&["contour", "path.json", "far.csv"]), "bracketed"), [0.0]);
    assert_eq!(column(&directory.good(&["contour", "path.json", "far.csv", "--max-lag-mm", "5"]), "bracketed"), [1.0]);
}

#[test]
fn bad_paths_and_positions_are_refused_with_their_place() {
    let directory = Folder::new(TRUEAXIS);
    directory.write("actual.csv", "segment,u,x_mm,y_mm,z_mm\n0,0.5,5,0,0\n");
    let paths: [(&str, &[&str]); 8] = [
        ("{\"segments\":[]}", &["segments"]),
        ("{\"segments\":[\n{\"type\":\"line\",\"start\":[0,0,0]}]}", &["path.json:2", "end"]),
        ("{\"segments\":[{\"type\":\"wave\"}]}", &["path.json:1", "wave"]),
        ("{\"segments\":[{\"type\":\"line\",\"start\":[0,0,0],\"end\":[0,0,0]}]}", &["segments[0]", "end"]),
        ("{\"segments\":[{\"type\":\"line\",\"start\":[0,0,0],\"end\":[1,0,0],\"colour\":1}]}", &["colour"]),
        (
            "{\"segments\":[{\"type\":\"line\",\"start\":[0,0,0],\"end\":[1,0,0]},{\"type\":\"line\",\"start\":[2,0,0],\"end\":[3,0,0]}]}",
            &["segments[1]", "1 mm"],
        ),
        (
            "{\"segments\":[{\"type\":\"arc\",\"start\":[1,0,0],\"end\":[0,2,0],\"center\":[0,0,0]}]}",
            &["segments[0]", "radius"],
        ),
        (
            "{\"segments\":[{\"type\":\"nurbs\",\"degree\":2,\"knots\":[0,0,0,1,1],\"points\":[[0,0,0],[1,0,0],[2,0,0]]}]}",
            &["segments[0]", "knots", "5"],
        ),
    ];
    for (text, parts) in paths {
        directory.write("path.json", text);
        directory.bad(&["contour", "path.json", "actual.csv", "-o", "out.csv"], parts);
        assert!(!directory.has("out.csv"));
    }
    directory.write("path.json", PATH);
    for (row, parts) in [
        ("3,0.5,0,0,0", &["actual.csv:2", "segment", "3", "0 to 2"][..]),
        ("0.5,0.5,0,0,0", &["actual.csv:2", "segment"]),
        ("2,2.5,0,0,0", &["actual.csv:2", "column u", "2.5", "0 to 2"]),
        ("0,0.5,0,nan,0", &["actual.csv:2", "y_mm", "nan"]),
    ] {
        directory.write("actual.csv", format!("segment,u,x_mm,y_mm,z_mm\n{row}\n"));
        directory.bad(&["contour", "path.json", "actual.csv"], parts);
    }
    directory.write("actual.csv", "segment,u,x_mm,y_mm,z_mm\n0,0.5,5,0,0\n");
    directory.bad(&["contour", "path.json", "actual.csv", "--max-lag-mm", "0"], &["--max-lag-mm"]);
}

/// A square of 10 mm: on each side one axis rests. X freezes on the first side.
#[test]
fn a_coordinate_that_dies_on_the_path_is_refused_with_its_line_and_one_that_rests_is_not() {
    let directory = Folder::new(TRUEAXIS);
    let corners = [[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]];
    let sides: Vec<String> = corners
        .windows(2)
        .map(|side| {
            let [[ax, ay], [bx, by]] = [side[0], side[1]];
            format!("{{\"type\":\"line\",\"start\":[{ax},{ay},-20],\"end\":[{bx},{by},-20]}}")
        })
        .collect();
    directory.write("path.json", format!("{{\"segments\":[{}]}}", sides.join(",")));
    // Rows 0.1 mm apart, off by 2 µm in X, and fifty rows of a dwell at the first corner.
    let record = |dies: bool| {
        let mut text = String::from("segment,u,x_mm,y_mm,z_mm\n");
        for (segment, side) in corners.windows(2).enumerate() {
            for k in (0..=100).chain((segment == 0).then_some(100).into_iter().cycle().take(50)) {
                let u = f64::from(k) / 100.0;
                let [x, y] = [0, 1].map(|c| f64::from(side[0][c]) + u * f64::from(side[1][c] - side[0][c]));
                let x = if dies && (segment > 0 || k > 40) { 4.002 } else { x + 0.002 };
                text += &format!("{segment},{u},{x:.4},{y:.4},-20\n");
            }
        }
        text
    };
    directory.write("actual.csv", record(false));
    let error = column(&directory.good(&["contour", "path.json", "actual.csv"]), "error_um");
    assert!(error.len() == 454 && error.iter().all(|um| *um < 2.001));
    directory.write("dead.csv", record(true));
    directory.bad(
        &["contour", "path.json", "dead.csv", "-o", "out.csv"],
        &[
            "dead.csv:42: column x_mm: found 4.002 for ",
            "while the path advances by 10.000 mm",
            "a position that follows the path",
        ],
    );
    assert!(!directory.has("out.csv"));
}

#[test]
fn iso_230_2_before_and_after_compensation() {
    let directory = Folder::new(TRUEAXIS);
    let mill = samples().join("mill-3axis");
    let measured = mill.join("x-iso230-2.csv");
    let (mill, measured) = (mill.to_str().unwrap(), measured.to_str().unwrap());
    let document: Value =
        serde_json::from_str(&directory.good(&["tables", "accuracy", measured, "--machine", mill, "--json"])).unwrap();
    let (before, after) = (&document["measured"]["both"], &document["compensated"]["both"]);
    assert!(after["systematic"].as_f64().unwrap() < 0.1 * before["systematic"].as_f64().unwrap());
    assert!(after["reversal"].as_f64().unwrap() < 0.5 * before["reversal"].as_f64().unwrap());
    let table = directory.good(&["tables", "accuracy", measured]);
    assert!(table.contains("bidirectional accuracy") && !table.contains("corrected"));
    // A machine whose table is the measured mean: only the scatter remains.
    directory
        .write("m/machine.toml", "name = \"b\"\nchain = \"w b X t\"\n[axis.X]\ntable = \"x.csv\"\nbacklash_um = 3\n");
    directory.write("m/x.csv", "X_mm,EXX_um\n0,1\n100,21\n");
    directory.write("b.csv",
        "X_mm,run,direction,deviation_um\n0,1,+,1\n0,2,+,1\n0,1,-,4\n0,2,-,4\n50,1,+,11\n50,2,+,11\n50,1,-,14\n50,2,-,14\n",
    );
    let document: Value =
        serde_json::from_str(&directory.good(&["tables", "accuracy", "b.csv", "--machine", "m", "--json"])).unwrap();
    assert!((document["measured"]["both"]["reversal"].as_f64().unwrap() - 3.0).abs() < 1e-9);
    for what in ["accuracy", "systematic", "reversal"] {
        assert!(document["compensated"]["both"][what].as_f64().unwrap().abs() < 1e-9, "{document}");
    }
    // The table says that the standard requires more.
    let asked = "asks for five target positions a metre";
    assert!(!table.contains(asked), "{table}");
    directory.write("b.csv", "X_mm,+1,-1,+2,-2\n50,11,14,11,14\n");
    let table = directory.good(&["tables", "accuracy", "b.csv"]);
    assert!(table.contains(asked) && table.contains("1 target position,"), "{table}");
    directory.write("b.csv", "X_mm,run,direction,deviation_um\n0,1,+,x\n");
    directory.bad(&["tables", "accuracy", "b.csv"], &["b.csv:2", "deviation_um"]);
}

#[test]
fn tables_travel_to_other_controls_and_back() {
    let directory = Folder::new(TRUEAXIS);
    directory.write("m/machine.toml", "name = \"t\"\nchain = \"w b X t\"\n[axis.X]\ntable = \"x.csv\"\n");
    directory.write("m/x.csv", "X_mm,EXX_um\n0,1\n50,11\n100,21\n");
    directory.write("p.csv", "x_mm,y_mm,z_mm\n25,0,0\n77,0,0\n");
    let truth = column(&directory.good(&["compensate", "m", "p.csv"]), "ex_um");
    for (format, file) in [("linuxcnc", "t.comp"), ("linuxcnc-1", "t1.comp"), ("siemens", "t.mpf"), ("isg", "t.txt")] {
        directory.good(&["tables", "export", "--to", format, "m", "-o", file]);
        let mut import = vec!["tables", "import", "--from", format, file, "--axis", "X", "-o", "back"];
        if format != "isg" {
            directory.bad(&import, &[file, "lengths of axis X without a unit", "--unit mm or --unit inch"]);
            import.extend(["--unit", "mm"]);
        }
        directory.good(&import);
        let found = column(&directory.good(&["compensate", "back", "p.csv"]), "ex_um");
        for (found, truth) in found.iter().zip(&truth) {
            assert!((found - truth).abs() < 1e-6, "{format}: {found} {truth}");
        }
        fs::remove_dir_all(directory.join("back")).unwrap();
    }
    // A control in inches, and a format that states its unit.
    directory.write("inch.comp", "0 0.0001 0.0002\n1.1 1.1003 1.1004\n");
    let import = ["tables", "import", "--from", "linuxcnc", "inch.comp", "--axis", "X", "--unit", "inch", "-o", "back"];
    let [_, said] = directory.both(&import);
    assert!(said.contains("nominal + E, inches or degrees"), "{said}");
    assert!(directory.read("back/x.csv").ends_with("X_mm,EXX_fwd_um,EXX_rev_um\n0,2.54,5.08\n27.94,7.62,10.16\n"));
    fs::remove_dir_all(directory.join("back")).unwrap();
    let import = |unit| ["tables", "import", "--from", "isg", "t.txt", "--unit", unit, "-o", "back"];
    directory.bad(&import("mm"), &["--unit", "isg, whose files state their units"]);
    directory.bad(&import("ell"), &["--unit", "ell", "needed mm or inch"]);
    // Angles are always degrees.
    directory.write("cut.comp", "0 0.001 0.001\n90 90.002 90.002\n");
    directory.good(&["tables", "import", "--from", "linuxcnc", "cut.comp", "--axis", "C", "-o", "turn"]);
    directory.write("cut.comp", "0 0 0\n# LinuxCNC would stop reading here without a word\n50 50 50\n");
    directory.bad(
        &["tables", "import", "--from", "linuxcnc", "--unit", "mm", "cut.comp", "--axis", "X", "-o", "back"],
        &["cut.comp:2"],
    );
    assert!(!directory.has("back"));
    directory.bad(&["tables", "export", "--to", "fanuc", "m", "-o", "x"], &["--to", "fanuc", "siemens"]);
    directory.bad(
        &["tables", "import", "--from", "linuxcnc", "--unit", "mm", "t.comp", "--axis", "Q", "-o", "back"],
        &["--axis"],
    );
    let mill = samples().join("mill-3axis");
    let mill = mill.to_str().unwrap();
    directory.bad(&["tables", "export", "--to", "siemens", mill, "-o", "lost.mpf"], &["equidistant"]);
    assert!(!directory.has("lost.mpf"));
}

/// A five-axis machine through the volumetric CSV and back: the same chain, and the same tip errors to 0.03 µm.
#[test]
fn five_axes_travel_to_another_control_and_back() {
    let directory = Folder::new(TRUEAXIS);
    let head = samples().join("head-5axis");
    let head = head.to_str().unwrap();
    directory.good(&["tables", "export", "--to", "isg", head, "-o", "head.csv"]);
    directory.good(&["tables", "import", "--from", "isg", "head.csv", "-o", "back"]);
    directory.good(&["tables", "check", "back"]);
    let found: serde_json::Value =
        serde_json::from_str(&directory.good(&["tables", "check", "back", "--json"])).unwrap();
    assert_eq!(found["summary"]["chain"], "w X' b Y Z C A t");
    directory.write("p.csv", "x_mm,y_mm,z_mm,a_deg,c_deg\n310,-220,150,33,77\n-500,100,-90,-61,200\n");
    let errors = |machine: &str| {
        let text = directory.good(&["compensate", machine, "p.csv", "--model", "exact"]);
        ["ex_um", "ey_um", "ez_um"].map(|name| column(&text, name)).concat()
    };
    let (truth, back) = (errors(head), errors("back"));
    assert!(truth.iter().any(|error| error.abs() > 5.0), "{truth:?}");
    for (back, truth) in back.iter().zip(&truth) {
        assert!((back - truth).abs() < 0.03, "{back} {truth}");
    }
    directory.bad(
        &["tables", "export", "--to", "linuxcnc", head, "-o", "lost.comp"],
        &["chain w X' b Y Z C A t", "tool_mm 0 0 -250", "location errors", "EA0C 22.000 urad"],
    );
    let text = directory.read("head.csv");
    directory.write("wrong.csv", text.replace("w X' b", "w X' X' b"));
    directory.bad(&["tables", "import", "--from", "isg", "wrong.csv", "-o", "none"], &["wrong.csv:1", "at most once"]);
    assert!(!directory.has("none"));
}

#[test]
fn help_teaches() {
    let directory = Folder::new(TRUEAXIS);
    for (arguments, part) in [
        (&["--help"][..], "actual − ideal"),
        (&["compensate", "--help"], "corrected command"),
        (&["contour", "--help"], "PATH.json"),
        (&["tables", "import", "--help"], "COMP_FILE"),
    ] {
        assert!(directory.good(arguments).contains(part), "{arguments:?}");
    }
}

/// Without arguments the program shows five commands that work in a checkout.
#[test]
fn the_commands_to_try_work() {
    let folder = Folder::new(TRUEAXIS);
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let output = folder.run(&[]);
    let text = String::from_utf8(output.stderr).unwrap();
    let lines: Vec<_> = text.lines().filter_map(|line| line.strip_prefix("  trueaxis ")).collect();
    assert_eq!((output.status.code(), lines.len()), (Some(2), 5), "{text}");
    for line in lines {
        let arguments: Vec<_> = line.split(' ').collect();
        let output = folder.command(&arguments).current_dir(&repository).output().unwrap();
        assert!(output.status.success() && !output.stdout.is_empty(), "{line}");
    }
}

/// `--licences` prints every licence, and takes no command.
#[test]
fn licences_are_printed() {
    let folder = Folder::new(TRUEAXIS);
    let text = folder.good(&["--licences"]);
    for part in ["The trueaxis developers", "glam ", "Permission is hereby granted", "TERMS AND CONDITIONS", "fflate "]
    {
        assert!(text.contains(part), "{part}");
    }
    folder.bad(&["--licences", "tables", "check"], &["cannot be used with"]);
}

/// `tables` shows margins and servo settings of the sample mill. It refuses gains that leave too little margin at a servo
/// rate, names the largest permitted ones, and writes nothing.
#[test]
fn margins_are_shown_and_gains_refused() {
    let directory = Folder::new(TRUEAXIS);
    for name in ["machine.toml", "x.csv", "y.csv", "z.csv"] {
        directory.write(format!("m/{name}"), std::fs::read(samples().join("mill-3axis").join(name)).unwrap());
    }
    let text = directory.good(&["tables", "check", "m"]);
    assert!(text.contains("contour feedback   K_p 0.3, K_i 10/s") && text.contains("  friction   0.45 mm/s"), "{text}");
    assert!(text.contains("axis Z: contour feedback has ") && text.contains("dB of gain margin at "), "{text}");
    let document: Value = serde_json::from_str(&directory.good(&["tables", "check", "m", "--json"])).unwrap();
    let margins = document["feedback_margins"].as_array().unwrap();
    assert_eq!(margins.len(), 3);
    for margin in margins {
        let figure = |key: &str| margin[key].as_f64().unwrap();
        assert!(figure("phase_margin_deg") > 60.0 && figure("gain_margin_db") > 12.0, "{margin}");
        assert!((figure("largest_integral_per_s") / figure("largest_proportional") - 10.0 / 0.3).abs() < 1e-9);
    }
    directory.good(&["tables", "compile", "m", "-o", "t.tcomp"]);
    let shown: Value = serde_json::from_str(&directory.good(&["tables", "show", "t.tcomp", "--json"])).unwrap();
    assert_eq!(shown["feedback"]["proportional"], 0.3);
    assert_eq!(shown["axes"][1]["servo"]["drive"]["position_gain_per_s"], 112.0);
    assert_eq!(shown["axes"][1]["servo"]["dynamic"]["take_up"], true);

    let machine = std::fs::read_to_string(samples().join("mill-3axis/machine.toml")).unwrap();
    let strong =
        machine.replace("proportional = 0.3\nintegral_per_s = 10.0", "proportional = 0.9\nintegral_per_s = 30.0");
    let strong = strong.replace("lowest_resonance_hz = 1200", "lowest_resonance_hz = 10000");
    directory.write("m/machine.toml", &strong);
    directory.good(&["tables", "check", "m"]);
    let line = 1 + strong.lines().position(|line| line == "proportional = 0.9").unwrap();
    let at =
        format!("machine.toml:{line}: key contour.feedback.proportional: found 0.9, needed 60 degrees of phase margin");
    let parts = [at.as_str(), "may be at most 0.", "because of axis", "(at 500 Hz)"];
    directory.bad(&["tables", "check", "m", "--rate-hz", "500"], &parts);
    directory.bad(&["tables", "compile", "m", "--rate-hz", "500", "-o", "slow.tcomp"], &parts);
    assert!(!directory.has("slow.tcomp"));
    // Gains without the figures of a drive.
    let head = machine.split("[axis.Z.drive]").next().unwrap();
    directory.write("m/machine.toml", format!("{head}[contour.feedback]\n"));
    directory.bad(&["tables", "check", "m"], &["key contour.feedback: found this section, needed", "[axis.Z.drive]"]);
}

#[test]
fn counts_and_numbers_read_as_people_write_them() {
    let directory = Folder::new(TRUEAXIS);
    let machine = |feed: u32| {
        format!(
            "name = \"m\"\nchain = \"w b X Z t\"\n[axis.Z]\ntravel_mm = [0.0, 9.0]\n[axis.X]\nmax_feed_mm_per_min = {feed}.0\n\
             travel_mm = [-100.0, 100.0]\ntable = \"x.csv\"\n"
        )
    };
    directory.write("m/machine.toml", machine(20_000));
    directory.write("m/x.csv", "X_mm,EXX_um\n-100,0\n100,1\n");
    let text = directory.good(&["tables", "check", "m"]);
    assert!(text.contains("up to 333.333333 mm/s"), "{text}");
    assert!(text.contains("m: no errors, 0 warnings\n"), "{text}");
    directory.write("m/x.csv", "X_mm,EXX_um\n-90,0\n100,1\n");
    let text = directory.good(&["tables", "check", "m"]);
    assert!(text.contains("m: no errors, 1 warning\n"), "{text}");
}

/// Every reader names the line of bytes that are not UTF-8, and no quoted input moves the cursor.
#[test]
fn odd_bytes_are_reported_with_their_line_and_escaped() {
    let directory = Folder::new(TRUEAXIS);
    for name in ["latin.csv", "latin.json", "latin.comp"] {
        directory.write(name, b"x_mm,y_mm\n1,2\n3,\xb5\n");
    }
    directory.write("xyz.csv", b"x_mm,y_mm,z_mm\n1,2,-3\n3,\xb5,-1\n");
    let mill = samples().join("mill-3axis").display().to_string();
    let cases: [&[&str]; 5] = [
        &["circle", "latin.csv"],
        &["compensate", &mill, "xyz.csv"],
        &["contour", "latin.json", "latin.csv"],
        &["tables", "accuracy", "latin.csv"],
        &["tables", "import", "--from", "linuxcnc", "--unit", "mm", "latin.comp", "--axis", "X", "-o", "out"],
    ];
    for arguments in cases {
        directory.bad(arguments, &[":3: found bytes that are not UTF-8"]);
    }
    // A single carriage return ends a line.
    directory.write("cr.csv", "x_mm,y_mm\n1,2\n3,4\r5\n6,7\n");
    directory.write("bell.csv", "x_mm,y_mm\n1,2\n3,\u{1b}[2J\n6,7\n");
    for (file, found) in [("cr.csv", "found 1 value"), ("bell.csv", "\\u{1b}[2J")] {
        directory.bad(&["circle", file], &[":3", found]);
        let error = directory.run(&["circle", file]).stderr;
        assert!(error.iter().all(|byte| *byte >= b' ' || *byte == b'\n'), "{}", String::from_utf8_lossy(&error));
    }
}

/// Files and commands in `--help` can be copied from a terminal of 80 columns.
#[test]
fn help_examples_can_be_copied_from_a_narrow_terminal() {
    let folder = Folder::new(TRUEAXIS);
    let shown = |command: &str| {
        let output = folder.command(&[command, "--help"]).env("COLUMNS", "80").output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let block = |first: &str| -> String {
            let lines = text.lines().skip_while(|line| !line.starts_with(first)).take_while(|line| !line.is_empty());
            lines.map(|line| format!("{line}\n")).collect()
        };
        let file = block("  machine = ");
        assert!(file.contains("[[artefact.place]]"), "{text}");
        (file, block("  # Once"))
    };
    let (file, commands) = shown("keep");
    let keep = trueaxis_evaluation::keep::KeepTask::read(&file, Path::new("keep.toml")).unwrap();
    assert_eq!((keep.every_parts, keep.terms.len()), (10, 2));
    let is_one = |line: &str| line.starts_with("  # ") || line.starts_with("  trueaxis keep ");
    assert!(commands.lines().count() == 7 && commands.lines().all(is_one), "{commands}");
    let (file, _) = shown("calibrate");
    trueaxis_tables::read_toml(&file, Path::new("task.toml"), |_| Ok(())).unwrap();
    let help = folder.good(&["calibrate", "--help"]);
    let plate = help.split("[[plate]]").nth(1).unwrap().split("\n\n").next().unwrap();
    let plate = format!("machine = \"mill\"\ndialect = \"linuxcnc\"\n[probe]\ntip_radius_mm = 2.0\n[[plate]]{plate}");
    let plate = trueaxis_evaluation::calibrate::Task::read(&plate, Path::new("plate.toml")).unwrap();
    assert_eq!(plate.artefacts[0].places.len(), 4);
    let dial = help.split("in place of touches:\n\n").nth(1).unwrap().split("\n\n").next().unwrap();
    let dial = trueaxis_evaluation::calibrate::Task::read(dial, Path::new("dial.toml")).unwrap();
    assert!(dial.is_read() && dial.artefacts[0].name == "cylinder");
}

/// The commands below "Commands:" in a help text.
#[cfg(unix)]
fn subcommands(help: &str) -> Vec<String> {
    let lines = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let names = lines.filter_map(|line| line.strip_prefix("  ").filter(|line| !line.starts_with(' ')));
    names.filter_map(|line| line.split(' ').next()).filter(|name| *name != "help").map(str::to_owned).collect()
}

/// The help of every command begins with a sentence and an example, which runs in an unchanged checkout.
#[cfg(unix)]
#[test]
fn the_examples_in_help_work() {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap();
    let program = Path::new(TRUEAXIS).parent().unwrap().display();
    let path = format!("{program}:{}", std::env::var("PATH").unwrap_or_default());
    let help = |names: &[String]| {
        let arguments: Vec<&str> = names.iter().map(String::as_str).chain(["--help"]).collect();
        let folder = Folder::new(TRUEAXIS);
        String::from_utf8(folder.command(&arguments).env("COLUMNS", "80").output().unwrap().stdout).unwrap()
    };
    let mut commands: Vec<Vec<String>> = subcommands(&help(&[])).into_iter().map(|name| vec![name]).collect();
    let (mut at, mut run) = (0, 0);
    while let Some(names) = commands.get(at).cloned() {
        at += 1;
        let text = help(&names);
        commands.extend(subcommands(&text).into_iter().map(|name| [&names[..], &[name]].concat()));
        let is_output = |line: &&str| line.starts_with("  -o") || line.starts_with("      --output");
        for line in text.lines().filter(is_output) {
            assert!(line.starts_with("  -o, --output "), "{names:?}: {line}");
        }
        // A sentence, which may be wrapped, an empty line, the example.
        let before: Vec<&str> = text.lines().take_while(|line| *line != "Example:").collect();
        assert!(before.len() < 5 && before.last() == Some(&""), "{names:?}: {text}");
        let example = text.lines().skip_while(|line| *line != "Example:").skip(1).take_while(|line| !line.is_empty());
        let script: String = example.map(|line| format!("{line}\n")).collect();
        assert!(script.lines().all(|line| line.starts_with("  ")) && script.contains(&names.join(" ")), "{script}");
        // The simulator is another crate's program, and the desk serves until it is interrupted.
        if script.contains("firmware-sim ") || names == ["desk"] {
            continue;
        }
        let folder = Folder::new(TRUEAXIS);
        for name in ["compensation-tables", "records", "tests", "crates", "firmware-sim"] {
            std::os::unix::fs::symlink(repository.join(name), folder.join(name)).unwrap();
        }
        let output = std::process::Command::new("sh")
            .args(["-ec", &script])
            .current_dir(folder.path())
            .env("PATH", &path)
            .output()
            .unwrap();
        assert!(output.status.success(), "{script}{}", String::from_utf8_lossy(&output.stderr));
        run += 1;
    }
    assert!(run > 25, "{run} examples");
}
