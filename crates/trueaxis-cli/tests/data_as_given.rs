//! Files as instruments and spreadsheets write them, closed pipes, and size limits.

use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::process::Stdio;
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

fn machine(directory: &Folder) {
    let axes = "[axis.X]\ntable = \"x.csv\"\n[axis.Y]\ntable = \"y.csv\"\n[axis.Z]\ntable = \"z.csv\"\n";
    directory.write("m/machine.toml", format!("name = \"m\"\nchain = \"w b X Y Z t\"\n{axes}"));
    for axis in ["x", "y", "z"] {
        let name = axis.to_uppercase();
        directory.write(format!("m/{axis}.csv"), format!("{name}_mm,E{name}{name}_um\n0,0\n100.5,20.5\n"));
    }
}

/// Every spelling of a file gives the same result, and its reading is reported once.
#[test]
fn separators_and_decimal_commas_are_recognised_everywhere() {
    let directory = Folder::new(TRUEAXIS);
    machine(&directory);
    let plain = "x_mm,y_mm,z_mm\n1.5,2.25,3\n10.125,20,30.5\n";
    directory.write("p.csv", plain);
    let [truth, silent] = directory.both(&["compensate", "m", "p.csv"]);
    assert!(!silent.contains("read as"), "{silent}");
    let comma = |separator: &str| plain.replace(',', separator).replace('.', ",");
    for (text, message) in [
        (comma(";"), "p.csv: read as semicolon separated with decimal commas"),
        (comma("\t"), "p.csv: read as tab separated with decimal commas"),
        (plain.replace(',', ";"), "p.csv: read as semicolon separated\n"),
        (plain.replace(',', "\t"), "p.csv: read as tab separated\n"),
        (
            "\u{feff}\"x_mm\",\"y_mm\",\"z_mm\"\r\n\"1,5\",\"2,25\",\"3\"\r\n\"10,125\",\"20\",\"30,5\"\r\n".to_owned(),
            "p.csv: read as comma separated with decimal commas in quotes",
        ),
    ] {
        directory.write("p.csv", &text);
        let [found, error] = directory.both(&["compensate", "m", "p.csv"]);
        assert_eq!(found, truth, "{text:?}");
        assert_eq!(error.matches(message).count(), 1, "{error}");
    }
    // The machine's own tables may use these separators, too.
    directory.write("m/x.csv", "X_mm;EXX_um\n0;0\n100,5;20,5\n");
    directory.write("p.csv", plain);
    let [found, error] = directory.both(&["compensate", "m", "p.csv"]);
    assert_eq!(found, truth);
    assert!(error.contains("x.csv: read as semicolon separated with decimal commas"), "{error}");
}

#[test]
fn ambiguous_files_are_refused() {
    let directory = Folder::new(TRUEAXIS);
    machine(&directory);
    for (text, parts) in [
        ("x_mm,y_mm,z_mm\n1,5,2,5,3,5\n", ["p.csv:2", "6 values", "decimal commas need"]),
        ("x_mm\ty_mm\tz_mm\n1,234\t2\t3\n", ["p.csv:2", "1,234", "thousands"]),
        ("x_mm;y_mm;z_mm\n1,5;2.5;3\n", ["p.csv:2: column y_mm", "2.5", "a decimal comma"]),
        ("x_mm,y_mm;z_mm\n1,2;3\n", ["p.csv:1", "commas and semicolons", "one of"]),
        ("x_mm,y_mm,z_mm\n\"1,2\n3\",4,5\n", ["p.csv:2", "open quote", "closed"]),
    ] {
        directory.write("p.csv", text);
        directory.bad(&["compensate", "m", "p.csv", "-o", "out.csv"], &parts);
        assert!(!directory.has("out.csv"));
    }
}

/// Results larger than the memory buffer equal short ones, and are written completely or not at all.
#[test]
fn long_files_stream_and_leave_nothing_behind_when_they_end_badly() {
    let directory = Folder::new(TRUEAXIS);
    machine(&directory);
    let mut text = String::from("x_mm,y_mm,z_mm\n");
    for i in 0..150_000 {
        writeln!(text, "{},{},{}", f64::from(i % 1000) * 0.1, 7, 3.25).unwrap();
    }
    directory.write("p.csv", &text);
    let [out, _] = directory.both(&["compensate", "m", "p.csv"]);
    assert!(out.len() > 9 << 20 && out.lines().count() == 150_001, "{}", out.len());
    directory.both(&["compensate", "m", "p.csv", "-o", "out.csv"]);
    assert_eq!(directory.read("out.csv"), out);
    let before = fs::read_dir(directory.path()).unwrap().count();
    text.push_str("1,2,nan\n");
    directory.write("p.csv", &text);
    let output = directory.run(&["compensate", "m", "p.csv", "-o", "out.csv"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("p.csv:150002"));
    assert_eq!(directory.read("out.csv"), out);
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), before);
}

/// Memory does not grow with the number of rows.
#[test]
#[cfg(target_os = "linux")]
fn memory_is_flat_in_the_number_of_rows() {
    let directory = Folder::new(TRUEAXIS);
    machine(&directory);
    let peak = |rows: usize| {
        let mut text = String::from("x_mm,y_mm,z_mm\n");
        for i in 0..rows {
            writeln!(text, "{}.5,7,3.25", i % 100).unwrap();
        }
        directory.write("p.csv", &text);
        let mut child = directory.command(&["compensate", "m", "p.csv", "-o", "out.csv"]).spawn().unwrap();
        let mut peak = 0;
        while child.try_wait().unwrap().is_none() {
            let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
            let line = status.lines().find(|line| line.starts_with("VmHWM:")).unwrap_or("0");
            peak = peak.max(line.split_whitespace().nth(1).and_then(|kb| kb.parse::<u64>().ok()).unwrap_or(0));
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        peak
    };
    let long = peak(600_000);
    assert!(long < 60_000, "{long} kB");
}

#[test]
fn a_closed_pipe_is_no_panic() {
    let directory = Folder::new(TRUEAXIS);
    machine(&directory);
    let mut text = String::from("x_mm,y_mm,z_mm\n");
    (0..200_000).for_each(|i| writeln!(text, "{},1,2", i % 100).unwrap());
    directory.write("p.csv", &text);
    let calls: [&[&str]; 6] = [
        &["tables", "check", "m"],
        &["compensate", "m", "p.csv"],
        &["compensate", "m", "missing.csv"],
        &["--help"],
        &["helicoid", "--help"],
        &["no-such-command"],
    ];
    for arguments in calls {
        let code = directory.run(arguments).status.code();
        // Both streams that it could write to are closed before it starts.
        let closed = || {
            let (reader, writer) = std::io::pipe().unwrap();
            drop(reader);
            Stdio::from(writer)
        };
        let status = directory.command(arguments).stdout(closed()).stderr(closed()).status().unwrap();
        assert_eq!(status.code(), code, "{arguments:?}");
        let one = directory.command(arguments).stderr(closed()).output().unwrap();
        assert_eq!(one.status.code(), code, "{arguments:?}");
    }
}

/// Inputs that would take gigabytes are refused, with their line, before any allocation.
#[test]
fn paths_without_end_are_refused_immediately() {
    let directory = Folder::new(TRUEAXIS);
    directory.write("a.csv", "segment,u,x_mm,y_mm,z_mm\n0,0.5,5,0,0\n");
    let line = |from: f64, to: f64| format!("{{\"type\":\"line\",\"start\":[{from},0,0],\"end\":[{to},0,0]}}");
    let lines = [line(0.0, 1e7), line(1e7, 0.0), line(0.0, 1e7)].join(",\n");
    let spline = "{\"type\":\"nurbs\",\"degree\":3,\"knots\":[0,0,0,0,1,1,1,1],\"points\":[[0,0,0],[1,0,0],[9e8,0,0],[9e8,1,0]]}";
    let helix = "{\"type\":\"arc\",\"start\":[1e6,0,0],\"end\":[1e6,0,5],\"center\":[0,0,0],\"turns\":9999}";
    let peak = "{\"type\":\"nurbs\",\"degree\":2,\"knots\":[0,0,0,1,1,1],\"points\":[[0,0,0],[4e5,9e8,0],[1,0,0]]}";
    for (segments, parts) in [
        (lines.as_str(), ["path.json:3", "segments[1]", "needed at most 1000000"]),
        (spline, ["path.json:2", "segments[0]", "1000000 spans"]),
        (helix, ["path.json:2", "segments[0]", "1000000 spans"]),
        (peak, ["path.json:2", "segments[0]", "1000000 spans"]),
    ] {
        directory.write("path.json", format!("{{\"segments\":[\n{segments}]}}"));
        directory.bad(&["contour", "path.json", "a.csv"], &parts);
    }
}

const MATRIX: &str = "X_mm,+1,-1,+2,-2\n0,1,4,3,6\n50.5,11,14,13,16\n100,21,24,23,26\n";

#[test]
fn a_matrix_of_runs_is_the_list_of_its_approaches() {
    let directory = Folder::new(TRUEAXIS);
    let mut list = String::from("X_mm,run,direction,deviation_um\n");
    for row in MATRIX.lines().skip(1) {
        let cells: Vec<&str> = row.split(',').collect();
        for (place, (run, way)) in [(1, '+'), (1, '-'), (2, '+'), (2, '-')].iter().enumerate() {
            writeln!(list, "{},{run},{way},{}", cells[0], cells[place + 1]).unwrap();
        }
    }
    directory.write("list.csv", &list);
    let [truth, _] = directory.both(&["tables", "accuracy", "list.csv", "--json"]);
    for (text, message) in [
        (MATRIX.to_owned(), None),
        (MATRIX.replace("+1,-1,+2,-2", "fwd_1_um,rev_1_um,fwd_2_um,rev_2_um"), None),
        (MATRIX.replace(',', ";").replace('.', ","), Some("read as semicolon separated with decimal commas")),
    ] {
        directory.write("matrix.csv", &text);
        let [found, error] = directory.both(&["tables", "accuracy", "matrix.csv", "--json"]);
        assert_eq!(found, truth, "{text}");
        assert!(message.is_none_or(|message| error.contains(message)), "{error}");
    }
    for (text, parts) in [
        ("X_mm,+1,+1\n0,1,2\n", ["matrix.csv:1: column +1", "again"]),
        ("X_mm,+1,mean_um\n0,1,2\n", ["matrix.csv:1: column mean_um", "fwd_1_um"]),
        ("+1,-1\n1,2\n", ["matrix.csv:1", "a header without all of them, needed X_mm"]),
        ("C_deg,fwd_1_um\n0,1\n", ["matrix.csv:1: column fwd_1_um", "deg and urad"]),
        ("X_mm,+1,-1\n0,1,\n", ["matrix.csv:2: column -1", "a number"]),
        ("X_mm,+1,-1\n0,1,2\n0,1,2\n", ["matrix.csv:3", "again"]),
    ] {
        directory.write("matrix.csv", text);
        directory.bad(&["tables", "accuracy", "matrix.csv"], &parts);
    }
}

/// Errors of 20 µm over 400 mm, as positions and as trims: the numbers determine the type.
#[test]
fn the_type_of_a_linuxcnc_file_is_seen() {
    let directory = Folder::new(TRUEAXIS);
    directory.write("0.comp", "-200 -199.98 -199.97\n0 0.01 0.02\n200 200.02 200.03\n");
    directory.write("1.comp", "-200 -0.02 -0.03\n0 -0.01 -0.02\n200 -0.02 -0.03\n");
    directory.write("both.comp", "-0.02 0.01 0.01\n0.02 0.01 0.01\n");
    for (file, into, says) in [("0.comp", "a", "nominal + E"), ("1.comp", "b", "trims = −E")] {
        let [_, error] = directory
            .both(&["tables", "import", "--from", "linuxcnc", "--unit", "mm", file, "--axis", "X", "-o", into]);
        assert!(error.contains(says), "{error}");
    }
    let numbers = |name: &str| -> Vec<f64> {
        directory
            .read(name)
            .lines()
            .skip(1)
            .flat_map(|row| row.split(',').map(|c| c.parse().unwrap()).collect::<Vec<f64>>())
            .collect()
    };
    let (a, b) = (numbers("a/x.csv"), numbers("b/x.csv"));
    assert!(a.len() == 9 && a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-9), "{a:?} {b:?}");
    let import = |file: &str, option: &[&'static str], parts: &[&str]| {
        let mut arguments =
            vec!["tables", "import", "--from", "linuxcnc", "--unit", "mm", file, "--axis", "X", "-o", "c"];
        arguments.extend(option);
        directory.bad(&arguments, parts);
        assert!(!directory.has("c/x.csv"));
    };
    import("both.comp", &[], &["both.comp", "type 0", "type 1", "--comp-file-type"]);
    import("1.comp", &["--comp-file-type", "0"], &["1.comp", "200.03", "needed --comp-file-type 1"]);
    import("0.comp", &["--comp-file-type", "1"], &["0.comp", "needed --comp-file-type 0"]);
    directory.both(&[
        "tables",
        "import",
        "--from",
        "linuxcnc",
        "--unit",
        "mm",
        "both.comp",
        "--axis",
        "X",
        "--comp-file-type",
        "1",
        "-o",
        "d",
    ]);
}

#[test]
fn siemens_names_of_the_control_need_the_axis() {
    let directory = Folder::new(TRUEAXIS);
    let text = "CHANDATA(1)\n$AA_ENC_COMP[0,0,AX1]=0.0\n$AA_ENC_COMP[0,1,AX1]=0.003\n$AA_ENC_COMP_STEP[0,AX1]=100.0\n\
        $AA_ENC_COMP_MIN[0,AX1]=0.0\n$AA_ENC_COMP_MAX[0,AX1]=100.0\n$AA_ENC_COMP_IS_MODULO[0,AX1]=0\nM17\n";
    directory.write("x.ini", text);
    directory.both(&["tables", "import", "--from", "siemens", "--unit", "mm", "x.ini", "--axis", "X", "-o", "x"]);
    assert_eq!(directory.read("x/x.csv"), "X_mm,EXX_um\n0,0\n100,3\n");
    directory.bad(
        &["tables", "import", "--from", "siemens", "--unit", "mm", "x.ini", "-o", "y"],
        &["x.ini:2", "AX1", "--axis"],
    );
    directory.write("two.ini", format!("{text}$AA_ENC_COMP[0,0,AX2]=0.0\n"));
    let arguments = ["tables", "import", "--from", "siemens", "--unit", "mm", "two.ini", "--axis", "X", "-o", "y"];
    directory.bad(&arguments, &["two.ini:9", "AX2", "AX1"]);
}

/// Traces of three probes with an angle column, uneven and from any start, give the same part as equidistant readings.
#[test]
fn traces_with_angles_are_resampled_and_the_error_is_stated() {
    let directory = Folder::new(TRUEAXIS);
    let arguments = ["--n", "256", "--phi2-deg", "66.09375", "--phi3-deg", "234.4921875", "--harmonics", "2..40"];
    let profile = |theta: f64| 3.0 * (2.0 * theta).cos() + 1.5 * (7.0 * theta + 0.4).sin() + 0.2 * (31.0 * theta).cos();
    let readings = |theta: f64| {
        [0.0, 66.09375_f64, 66.09375 + 234.4921875].map(|phi| {
            let (sin, cos) = phi.to_radians().sin_cos();
            profile(theta + phi.to_radians()) + 0.8 * (2.0 * theta).sin() * cos + 5.0 * theta.cos() * sin
        })
    };
    let mut even = String::from("h1_um,h2_um,h3_um\n");
    for i in 0..256 {
        let [a, b, c] = readings(TAU * f64::from(i) / 256.0);
        writeln!(even, "{a},{b},{c}").unwrap();
    }
    directory.write("even.csv", &even);
    let run = |file: &str| {
        let mut all = vec!["roundness", file, "--json"];
        all.extend(arguments);
        let [out, error] = directory.both(&all);
        (serde_json::from_str::<Value>(&out).unwrap(), error)
    };
    let (truth, _) = run("even.csv");
    assert!(truth.get("resampling").is_none());
    // 1,003 uneven rows per revolution from 73.2 degrees on; in the first case the angle restarts every revolution.
    for (rows, again) in [(1003, true), (2 * 1003 + 117, false)] {
        let mut trace = String::from("theta_deg;h1_um;h2_um;h3_um\n");
        for i in 0..rows {
            let angle = 73.2 + 360.0 * (f64::from(i) + 0.3 * f64::from(i * 7919 % 11) / 11.0) / 1003.0;
            let [a, b, c] = readings(angle.to_radians());
            let shown = if again { angle % 360.0 } else { angle };
            writeln!(trace, "{}", format!("{shown};{a};{b};{c}").replace('.', ",")).unwrap();
        }
        directory.write("trace.csv", &trace);
        let (found, error) = run("trace.csv");
        assert!(error.contains("read as semicolon separated with decimal commas"), "{error}");
        assert!(error.contains("interpolation error at most"), "{error}");
        assert_eq!(found["revolutions"], if again { 1 } else { 2 });
        assert_eq!(found["resampling"]["rows"], rows);
        let stated = found["resampling"]["interpolation_error_um"]["max"].as_f64().unwrap();
        assert!(stated > 0.0 && stated < 2e-3, "{stated}");
        for (a, b) in truth["harmonics"].as_array().unwrap().iter().zip(found["harmonics"].as_array().unwrap()) {
            let off = (a["amplitude_um"].as_f64().unwrap() - b["amplitude_um"].as_f64().unwrap()).abs();
            assert!(off <= 4.0 * stated, "{a} {b} {stated}");
        }
        let phase = |document: &Value| document["harmonics"][0]["phase_deg"].as_f64().unwrap();
        assert!((phase(&truth) - phase(&found)).abs() < 0.1);
    }
    let refuse = |text: &str, parts: &[&str]| {
        directory.write("trace.csv", text);
        let mut all = vec!["roundness", "trace.csv"];
        all.extend(arguments);
        directory.bad(&all, parts);
    };
    let head = "theta_deg,h1_um,h2_um,h3_um\n";
    refuse(&format!("{head}0,1,1,1\n1,1,1,1\n0.5,1,1,1\n"), &["trace.csv:4: column theta_deg", "0.5", "more than 1"]);
    refuse(&format!("{head}0,1,1,1\n90,1,1,1\n"), &["trace.csv:3: column theta_deg", "gap of 90", "harmonic 40"]);
    refuse(&format!("{head}0,1,1,1\n1e-300,1,1,1\n"), &["trace.csv:3: column theta_deg", "more than 0", "by 1e-9"]);
    let short: String = (0..200).map(|i| format!("{i},1,1,1\n")).collect();
    refuse(&format!("{head}{short}"), &["trace.csv", "199.0000 degrees", "a whole revolution"]);
}

#[test]
fn a_circle_with_an_outlier_is_found() {
    let directory = Folder::new(TRUEAXIS);
    let mut text = String::from("x_mm;y_mm\n");
    for i in 0..4000 {
        let (sin, cos) = (TAU * f64::from(i) / 4000.0).sin_cos();
        let r = 10.0 + 1e-3 * f64::from(i * 7919 % 101) / 101.0;
        writeln!(text, "{}", format!("{};{}", r * cos, r * sin).replace('.', ",")).unwrap();
    }
    text.push_str("10000000;0\n");
    directory.write("c.csv", &text);
    let [out, _] = directory.both(&["circle", "c.csv", "--json"]);
    let found: Value = serde_json::from_str(&out).unwrap();
    assert!((found["mcc"]["radius_mm"].as_f64().unwrap() - 5_000_005.0).abs() < 1.0);
    assert!((found["mzc"]["zone_mm"].as_f64().unwrap() - 20.0).abs() < 0.01);
}
