//! `trueaxis evaluate` as called.

use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;
use trueaxis_testing::command::Folder;

fn folder() -> Folder {
    let folder = Folder::new(env!("CARGO_BIN_EXE_trueaxis"));
    folder.copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/mill-3axis"), "mill");
    folder
}

/// A diagonal test of a machine out of square by C0Y = 50 µrad.
fn diagonals() -> String {
    let mut text = String::from("diagonal,direction,x_mm,y_mm,z_mm,deviation_um\n");
    for (k, [sx, sy, sz]) in
        [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0]].into_iter().enumerate()
    {
        for direction in [1, -1] {
            for step in 0..=5 {
                let t = f64::from(if direction > 0 { step } else { 5 - step }) / 5.0;
                let [x, y, z] = [300.0 * sx * t, 200.0 * sy * t, 100.0 * sz * t];
                let length = 14.0_f64.sqrt() * 100.0;
                let deviation = 1e3 * (-50e-6 * y) * 300.0 * sx / length;
                writeln!(text, "{},{direction},{x},{y},{z},{deviation}", k + 1).unwrap();
            }
        }
    }
    text
}

/// C0Y of a machine.toml, µrad.
fn c0y(text: &str) -> f64 {
    let line = text.lines().find_map(|line| line.strip_prefix("C0Y_urad = ")).expect("a C0Y");
    line.split_whitespace().next().unwrap().parse().unwrap()
}

#[test]
fn step_diagonal_prints_writes_and_refuses() {
    let folder = folder();
    folder.write("record.csv", diagonals());
    let found = folder.json(&["evaluate", "step-diagonal", "record.csv", "--json"]);
    assert!((found["c0y_urad"]["value"].as_f64().unwrap() - 50.0).abs() < 1e-6, "{found}");
    assert!(found["a0z_urad"]["value"].as_f64().unwrap().abs() < 1e-6);
    assert_eq!(found["steps"], Value::Null);
    let call = ["evaluate", "step-diagonal", "record.csv", "--machine", "mill", "-o", "squared", "--report", "out"];
    let text = folder.good(&call);
    assert!(
        text.lines().any(|line| line.split_whitespace().take(3).eq(["squareness", "C0Y", "50.00"]))
            && text.contains("ISO 230-6"),
        "{text}"
    );
    assert!((c0y(&folder.read("squared/machine.toml")) - 50.0).abs() < 1e-6, "{}", folder.read("squared/machine.toml"));
    assert_eq!(folder.read("squared/x.csv"), folder.read("mill/x.csv"));
    assert!(folder.read("out/step-diagonal.html").contains("<svg"), "out/step-diagonal.html");
    // Writing into the machine's own folder keeps its comments.
    folder.good(&["evaluate", "step-diagonal", "record.csv", "--machine", "mill", "-o", "mill"]);
    let own = folder.read("mill/machine.toml");
    assert!((c0y(&own) - 50.0).abs() < 1e-6 && own.contains("# Vertical machining centre"), "{own}");
    folder.bad(
        &["evaluate", "step-diagonal", "record.csv", "--machine", "mill", "-o", "squared"],
        &["found a machine in squared"],
    );
    folder.write(
        "three.csv",
        diagonals().lines().filter(|l| !l.starts_with("4,")).map(|l| format!("{l}\n")).collect::<String>(),
    );
    folder.bad(
        &["evaluate", "step-diagonal", "three.csv", "--report", "none"],
        &["three.csv: found no reading of diagonal 4"],
    );
}

/// A diagonal test of a machine out of square by these, µrad, whose diagonals bow by some µm: a bow has no slope, but makes
/// the slopes less certain.
fn bowed([a0z, b0z, c0y]: [f64; 3], bow_um: f64) -> String {
    let mut text = String::from("diagonal,direction,x_mm,y_mm,z_mm,deviation_um\n");
    let signs = [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0]];
    for (k, [sx, sy, sz]) in signs.into_iter().enumerate() {
        for step in 0..=5 {
            let t = f64::from(step) / 5.0;
            let [x, y, z] = [300.0 * sx * t, 200.0 * sy * t, 100.0 * sz * t];
            let length = 14.0_f64.sqrt() * 100.0;
            let [ux, uy, uz] = [300.0 * sx, 200.0 * sy, 100.0 * sz].map(|part| part / length);
            let slope = 1e-6 * (-ux * uy * c0y + ux * uz * b0z - uy * uz * a0z);
            let deviation = 1e3 * slope * length * t + bow_um * 4.0 * t * (1.0 - t);
            writeln!(text, "{},1,{x},{y},{z},{deviation}", k + 1).unwrap();
        }
    }
    text
}

/// A number in a machine.toml by its section and key.
fn number(text: &str, section: &str, key: &str) -> Option<f64> {
    let own = text.split(&format!("[{section}]\n")).nth(1)?.split("\n[").next()?;
    let line = own.lines().find_map(|line| line.strip_prefix(key)?.trim_start().strip_prefix('='))?;
    line.split('#').next()?.trim().parse().ok()
}

/// A0Z is stated as 32 ± 3 and measured to ± 11: the written uncertainty is always that of the written value, with two digits.
#[test]
fn a_result_that_agrees_is_averaged_and_one_that_differs_replaces_the_value() {
    let folder = folder();
    let mill = folder.read("mill/machine.toml");
    let of = |text: &str| {
        [("location", "A0Z_urad"), ("uncertainty.location", "A0Z_urad"), ("location", "C0Y_urad")]
            .map(|(section, key)| number(text, section, key).unwrap_or_else(|| panic!("{section} {key} in {text}")))
    };
    assert_eq!(of(&mill)[..2], [32.0, 3.0]);
    let run = |a0z: f64, output: &str, more: &[&'static str]| {
        folder.write("record.csv", bowed([a0z, -36.0, 38.0], 2.0128));
        let found = folder.json(&["evaluate", "step-diagonal", "record.csv", "--json"]);
        let error = found["a0z_urad"]["standard_error"].as_f64().unwrap();
        assert!(
            (found["a0z_urad"]["value"].as_f64().unwrap() - a0z).abs() < 1e-6 && (10.5..11.5).contains(&error),
            "{found}"
        );
        let call = ["evaluate", "step-diagonal", "record.csv", "--machine", "mill", "-o", output];
        (folder.both(&[&call[..], more].concat()), error)
    };
    // Weights 1/9 and 1/121: 32 − 7·9/130 = 31.5, and (1/9 + 1/121)^(−1/2) = 2.89.
    let ([_, stderr], error) = run(25.0, "agrees", &[]);
    let [value, uncertainty, _] = of(&folder.read("agrees/machine.toml"));
    let mean = (32.0 / 9.0 + 25.0 / error.powi(2)) / (1.0 / 9.0 + 1.0 / error.powi(2));
    assert!(
        (value - mean).abs() <= 0.05 && (value * 10.0).fract().abs() < 1e-9 && uncertainty == 2.9,
        "{value} ± {uncertainty}"
    );
    let row = stderr.lines().find(|line| line.starts_with("location.A0Z_urad")).unwrap_or_else(|| panic!("{stderr}"));
    assert!(row.contains("32 (u 3)") && row.contains("25 (u 11)") && row.contains("31.5 (u 2.9)"), "{stderr}");
    // More than twice 11.4 away from the stated value: the machine has changed.
    let ([_, stderr], _) = run(0.2174671317786221, "differs", &[]);
    let text = folder.read("differs/machine.toml");
    assert_eq!(of(&text)[..2], [0.0, 11.0], "{stderr}");
    assert_eq!(
        number(&text, "uncertainty.location", "A0Z_degrees_of_freedom"),
        Some(16.0),
        "four slopes of six targets"
    );
    assert!(stderr.contains("differs by 2.8 combined standard uncertainties"), "{stderr}");
    // Repeating the same record is not a second measurement.
    folder.write("record.csv", bowed([25.0, -36.0, 38.0], 2.0128));
    let again = ["evaluate", "step-diagonal", "record.csv", "--machine", "agrees", "-o", "agrees"];
    let before = folder.read("agrees/machine.toml");
    assert!(folder.both(&again)[1].contains("this record is already included"));
    assert_eq!(folder.read("agrees/machine.toml"), before);
    // A dry run only reports.
    let ([said, _], _) = run(25.0, "mill", &["--dry-run"]);
    assert!(said.contains("31.5 (u 2.9)") && !said.contains("ISO 230-6"), "{said}");
    let ([said, _], _) = run(25.0, "mill", &["--dry-run", "--json"]);
    let said: Value = serde_json::from_str(&said).unwrap();
    let row = said["written"].as_array().unwrap().iter().find(|of| of["key"] == "location.A0Z_urad").unwrap();
    assert_eq!((&row["old"]["value"], &row["written"]["value"]), (&Value::from(32.0), &Value::from(31.5)), "{row}");
    assert!(said["a0z_urad"].is_object() && row["why"] == "agrees: weighted mean of both", "{said}");
    assert_eq!(folder.read("mill/machine.toml"), mill);
    folder.good(&["tables", "check", "agrees"]);
    // --force writes the measured value although the better known one agrees; without a machine it is refused.
    let ([_, stderr], error) = run(25.0, "forced", &["--force"]);
    assert_eq!(of(&folder.read("forced/machine.toml"))[..2], [25.0, 11.0], "{error}");
    assert!(stderr.contains("forced, the rule writes 31.5 (u 2.9): agrees: weighted mean of both"), "{stderr}");
    folder.bad(&["evaluate", "step-diagonal", "record.csv", "--force"], &["--machine"]);
}

/// A headless trunnion that states no errors, whose table's centre line is off by 10 µm; and the record of another machine.
#[test]
fn a_record_of_another_machine_writes_nothing() {
    let folder = folder();
    let chain = "w C' A' Y' b X Z t";
    let axes = "[axis.X]\n[axis.Y]\n[axis.Z]\n[axis.A]\n[axis.C]\n";
    folder.write("five/machine.toml", format!("name = \"five\"\nchain = \"{chain}\"\n{axes}"));
    let record = |other_um: f64| {
        let mut text = String::from("x_mm,y_mm,z_mm,a_deg,c_deg,dx_um,dy_um,dz_um\n");
        for k in 0..16 {
            let (sin, cos) = (-22.5 * f64::from(k)).to_radians().sin_cos();
            let (x, y) = (60.0 * cos, 60.0 * sin);
            // The nest reads to a tenth of a micrometre; the other machine's errors vary at three times the frequency.
            let other = other_um * (3.0 * 22.5 * f64::from(k)).to_radians().cos();
            let noise = [0.1, -0.1, 0.05, -0.05, 0.0][k as usize % 5];
            writeln!(
                text,
                "{x},{y},-80,0,{},{},{},{}",
                22.5 * f64::from(k),
                10.0 + other + noise,
                other - noise,
                other + noise
            )
            .unwrap();
        }
        text
    };
    let call = ["evaluate", "r-test", "bk.csv", "--machine", "five", "-o"];
    folder.write("bk.csv", record(0.0));
    let [_, stderr] = folder.both(&[&call[..], &["own"]].concat());
    let text = folder.read("own/machine.toml");
    assert!((number(&text, "location", "EX0C_um").unwrap().abs() - 10.0).abs() < 0.2, "{text} {stderr}");
    // A value that is not significant is not written, however many digits it has.
    assert!(
        number(&text, "location", "EY0C_um").is_none() && stderr.contains("within 2 standard uncertainties of zero"),
        "{stderr}"
    );
    folder.write("bk.csv", record(20.0));
    let [_, stderr] = folder.both(&[&call[..], &["other"]].concat());
    assert!(stderr.contains("misfit: ") && stderr.contains(" RMS remain"), "{stderr}");
    assert_eq!(folder.read("other/machine.toml"), folder.read("five/machine.toml"));
    // A misfit is written only if forced; a dry run shows it.
    let before = folder.tree();
    let said = folder.json(&[&call[..5], &["--force", "--dry-run", "--json"]].concat());
    assert_eq!(folder.tree(), before);
    let row = said["written"].as_array().unwrap().iter().find(|of| of["key"] == "location.EX0C_um").unwrap();
    assert!(row["why"].as_str().unwrap().starts_with("forced, the rule writes nothing: misfit: "), "{row}");
    folder.good(&[&call[..], &["forced", "--force"]].concat());
    let text = folder.read("forced/machine.toml");
    assert_eq!(number(&text, "location", "EX0C_um"), row["written"]["value"].as_f64(), "{text}");
    folder.bad(&[&call[..5], &["--force"]].concat(), &["--force: found no machine to write"]);
    // A misfit by the stated noise, although most is explained.
    folder.write("bk.csv", record(2.0));
    folder.good(&[&call[..], &["unstated"]].concat());
    let noise = "[uncertainty]\neve_um = 0.2\n";
    folder.write("five/machine.toml", format!("name = \"five\"\nchain = \"{chain}\"\n{axes}{noise}"));
    let [_, stderr] = folder.both(&[&call[..], &["stated"]].concat());
    assert!(stderr.contains("the noise is 0.20 µm"), "{stderr}");
    assert!(!folder.read("stated/machine.toml").contains("[location]"));
}

/// Points of the sample mill as its own model predicts them: the resulting machine compensates like the sample.
#[test]
fn points_make_a_machine_that_compensate_agrees_with() {
    let folder = folder();
    let mut positions = String::from("x_mm,y_mm,z_mm\n");
    for i in 0..9 {
        for j in 0..9 {
            for k in 0..9 {
                writeln!(positions, "{},{},{}", -280 + 70 * i, -180 + 45 * j, -380 + 45 * k).unwrap();
            }
        }
    }
    folder.write("positions.csv", &positions);
    let call = ["compensate", "mill", "positions.csv", "--model", "exact"];
    let (_, rows) = folder.csv(&call);
    let mut points = String::from("x_mm,y_mm,z_mm,actual_x_mm,actual_y_mm,actual_z_mm,u_um\n");
    // One direction of travel only: the mill's Y has backlash, and every row but the first of a line moves Z in positive
    // travel.
    for row in &rows {
        let [x, y, z] = [row[0], row[1], row[2]];
        writeln!(points, "{x},{y},{z},{},{},{},0.5", x + 1e-3 * row[3], y + 1e-3 * row[4], z + 1e-3 * row[5]).unwrap();
    }
    folder.write("points.csv", &points);
    let call = ["evaluate", "points", "points.csv", "--machine", "mill", "-o", "measured", "--json", "--report", "out"];
    let found = folder.json(&call);
    assert!(found["before"]["max_um"].as_f64().unwrap() > 10.0, "{found}");
    assert!(found["left"]["rms_um"].as_f64().unwrap() < 0.6, "{}", found["left"]);
    assert!(folder.read("out/points.html").contains("<svg"), "out/points.html");
    folder.good(&["tables", "check", "measured"]);
    // Compare with the command, after removing the fitted placement from the measurement.
    let (_, again) = folder.csv(&["compensate", "measured", "positions.csv", "--model", "volumetric"]);
    let shift: Vec<f64> = found["shift_mm"].as_array().unwrap().iter().map(|v| 1e3 * v.as_f64().unwrap()).collect();
    let turn: Vec<f64> = found["turn_urad"].as_array().unwrap().iter().map(|v| 1e-3 * v.as_f64().unwrap()).collect();
    let mut squares = 0.0;
    for (row, new) in rows.iter().zip(&again) {
        let [x, y, z] = [row[0], row[1], row[2]];
        let turned = [turn[1] * z - turn[2] * y, turn[2] * x - turn[0] * z, turn[0] * y - turn[1] * x];
        for c in 0..3 {
            squares += (row[3 + c] - shift[c] - turned[c] - new[3 + c]).powi(2);
        }
    }
    let rms = (squares / again.len() as f64).sqrt();
    assert!(rms < 0.6, "{rms} µm RMS between measured and compensated");
    folder.bad(
        &["evaluate", "points", "points.csv", "--machine", "mill", "-o", "measured"],
        &["found a machine in measured"],
    );
    folder.write("bad.csv", points.replacen(",0.5", ",0", 1));
    folder.bad(
        &["evaluate", "points", "bad.csv", "--machine", "mill", "-o", "none"],
        &["bad.csv:2: column u_um: found 0"],
    );
}

/// A plate measured on the sample mill at one height, as its own nine terms predict it: the machine that comes out gives it back,
/// and what the plate does not show stays. Terms that do not help another plate are not written.
#[test]
fn a_plate_changes_the_errors_in_its_plane_and_no_other() {
    let folder = folder();
    let mut positions = String::from("x_mm,y_mm,z_mm\n");
    for k in 0..13 * 9 {
        writeln!(positions, "{},{},-200", -300 + 50 * (k % 13), -200 + 50 * (k / 13)).unwrap();
    }
    folder.write("positions.csv", &positions);
    let compensate = |machine: &str| folder.csv(&["compensate", machine, "positions.csv", "--model", "nine"]).1;
    let rows = compensate("mill");
    let plate = |factor: f64, z: f64| {
        let mut text = String::from("x_mm,y_mm,z_mm,actual_x_mm,actual_y_mm,actual_z_mm\n");
        for row in &rows {
            let [x, y] = [row[0], row[1]];
            let um = [factor * row[3] - 0.05 * y + 30.0, factor * row[4] + 0.05 * x - 10.0];
            writeln!(text, "{x},{y},{z},{},{},{z}", x + 1e-3 * um[0], y + 1e-3 * um[1]).unwrap();
        }
        text
    };
    folder.write("plate.csv", plate(1.0, -200.0));
    folder.write("turned.csv", plate(-1.0, -200.0));
    let call = ["evaluate", "points", "plate.csv", "--machine", "mill", "-o", "measured", "--against", "plate.csv"];
    let found = folder.json(&[&call[..], &["--json", "--report", "out"]].concat());
    assert_eq!((&found["plane"], &found["transfer"]["transfers"]), (&json!(["X", "Y"]), &json!(true)), "{found}");
    assert!(found["before"]["rms_um"].as_f64().unwrap() > 2.0, "{}", found["before"]);
    assert!(found["left"]["rms_um"].as_f64().unwrap() < 0.1, "{}", found["left"]);
    assert!(found["models"].as_array().unwrap().iter().any(|of| of["model"] == found["model"]), "{found}");
    assert!(folder.read("out/points.html").contains("<svg"), "out/points.html");
    folder.good(&["tables", "compile", "measured", "-o", "measured.tcomp"]);
    let [shift_x, shift_y] = [0, 1].map(|k| 1e3 * found["shift_mm"][k].as_f64().unwrap());
    let turn = 1e-3 * found["turn_urad"].as_f64().unwrap();
    let mut squares = 0.0;
    for (row, new) in rows.iter().zip(compensate("measured")) {
        let [x, y] = [row[0], row[1]];
        squares += (row[3] - 0.05 * y + 30.0 - shift_x + turn * y - new[3]).powi(2);
        squares += (row[4] + 0.05 * x - 10.0 - shift_y - turn * x - new[4]).powi(2);
        assert!((row[5] - new[5]).abs() < 0.02, "Z: {} and {}", row[5], new[5]);
    }
    let rms = (squares / rows.len() as f64).sqrt();
    assert!(rms < 0.1, "{rms} µm RMS between measured and compensated");

    let call = ["evaluate", "points", "plate.csv", "--machine", "mill", "-o", "refused", "--against", "turned.csv"];
    let text = folder.good(&call);
    assert!(text.contains("the terms do not transfer to turned.csv") && text.contains("nothing is written"), "{text}");
    assert!(!folder.has("refused"), "written all the same");
    let text = folder.good(&["evaluate", "points", "plate.csv"]);
    assert!(text.contains("Models, by their errors at held-out points") && text.contains("chosen"), "{text}");
    folder.bad(&["evaluate", "points", "plate.csv", "-o", "none"], &["--output: found no --machine"]);
    let few: String = plate(1.0, -200.0).lines().take(5).map(|line| format!("{line}\n")).collect();
    folder.write("few.csv", few);
    folder.bad(
        &["evaluate", "points", "few.csv"],
        &["few.csv: lines 2 to 5: found 4 points in a plane, needed at least 10"],
    );
    let above: String = plate(1.0, -100.0).lines().skip(1).map(|line| format!("{line}\n")).collect();
    folder.write("box.csv", plate(1.0, -200.0) + &above);
    folder.bad(&["evaluate", "points", "box.csv"], &["--machine: found none"]);
}

#[test]
fn r_test_thermal_and_probing_print_write_and_refuse() {
    let folder = folder();
    folder.copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/mill-5axis"), "five");
    // Readings of up to 2 µm on a trunnion, unrelated to the sample's errors.
    let mut record = String::from("x_mm,y_mm,z_mm,a_deg,c_deg,dx_um,dy_um,dz_um\n");
    for a in [-90, -60, -30, 0, 20] {
        for c in 0..8 {
            let (sin_a, cos_a) = f64::from(a).to_radians().sin_cos();
            let (sin_c, cos_c) = (45.0 * f64::from(c)).to_radians().sin_cos();
            // Both turn by the negative angle: p = R_x(−A) R_z(−C) (60, 20, 80).
            let [x, y, z] = [60.0 * cos_c + 20.0 * sin_c, 20.0 * cos_c - 60.0 * sin_c, 80.0];
            let [y, z] = [y * cos_a + z * sin_a, z * cos_a - y * sin_a];
            writeln!(record, "{x},{y},{z},{a},{},{},0.5,0", 45 * c, c % 3).unwrap();
        }
    }
    folder.write("bk.csv", &record);
    let call = ["evaluate", "r-test", "bk.csv", "--machine", "five", "-o", "found", "--json", "--report", "out"];
    let found = folder.json(&call);
    assert_eq!(found["terms"].as_array().unwrap().len(), 8, "{found}");
    let ex0c = found["terms"].as_array().unwrap().iter().find(|term| term["name"] == "EX0C").unwrap();
    assert_eq!(ex0c["before"].as_f64().unwrap(), 13.0);
    // No machine with these tables moves like this.
    assert_eq!(folder.read("found/machine.toml"), folder.read("five/machine.toml"));
    assert_eq!(folder.read("found/c.csv"), folder.read("five/c.csv"));
    folder.good(&["tables", "check", "found"]);
    assert!(folder.read("out/r-test.html").contains("<svg"), "out/r-test.html");
    folder.bad(
        &["evaluate", "r-test", "bk.csv", "--machine", "five", "--without", "EXX", "-o", "none"],
        &["bk.csv: --without EXX"],
    );
    folder.bad(&["evaluate", "r-test", "bk.csv", "--machine", "mill"], &["bk.csv:2: column a_deg: found an angle"]);

    let mut drift = String::from("t_s,x1_um,z_um,x2_um,ambient_c\n");
    for minute in 0..=120 {
        let t = f64::from(minute);
        writeln!(drift, "{},{},{},{},{}", 60 * minute, 0.05 * t, 0.2 * t, 0.07 * t, 20.0 + 0.01 * t).unwrap();
    }
    folder.write("drift.csv", &drift);
    let text = folder.good(&["evaluate", "thermal", "drift.csv", "--distance-mm", "100", "--report", "out"]);
    assert!(
        text.contains("ISO 230-3")
            && text.lines().any(|line| line.split_whitespace().take(4).eq(["Z", "24.00", "12.00", "12.00"])),
        "{text}"
    );
    assert!(folder.read("out/thermal.html").contains("<svg"), "out/thermal.html");
    folder.bad(&["evaluate", "thermal", "drift.csv", "--period-min", "0"], &["--period-min: found 0"]);

    let mut ring = String::from("x_mm,y_mm\n");
    for k in 0..36 {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 36.0).sin_cos();
        writeln!(ring, "{},{}", 22.0 * cos, 22.0 * sin).unwrap();
    }
    folder.write("ring.csv", &ring);
    let text = folder.good(&[
        "evaluate",
        "probing",
        "ring.csv",
        "--feature",
        "ring",
        "--diameter-mm",
        "50",
        "--report",
        "out",
    ]);
    assert!(
        text.contains("P_FTU,2D") && text.contains("effective diameter of the tip") && text.contains("6.0000"),
        "{text}"
    );
    assert!(folder.read("out/probing.html").contains("<svg"), "out/probing.html");
    let call = ["evaluate", "probing", "ring.csv", "--feature", "ring", "--diameter-mm", "25", "--report", "none"];
    folder.bad(&call, &["ring.csv: run 0: found a diameter of 44.000 mm"]);
}
