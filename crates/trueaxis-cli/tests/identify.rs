//! `trueaxis identify` as called; exact rotations of the ball give the readings, independently of the code's equations.

use serde_json::Value;
use std::fmt::Write;
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

const SET_UPS: [(f64, f64); 3] = [(250.0, 60.0), (250.0, 160.0), (350.0, 60.0)];
const SET_UPS_A: [(f64, f64); 3] = [(250.0, 60.0), (250.0, 160.0), (350.0, 160.0)];

/// Turns a vector right-handed about an axis (0 X, 2 Z).
fn turned(v: [f64; 3], axis: usize, angle: f64) -> [f64; 3] {
    let (sin, cos) = angle.sin_cos();
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut out = v;
    out[i] = v[i] * cos - v[j] * sin;
    out[j] = v[i] * sin + v[j] * cos;
    out
}

/// Six errors at an angle, µm and µrad, with non-zero means.
fn truth(angle_deg: f64) -> [f64; 6] {
    std::array::from_fn(|i| {
        let k = i as f64;
        (3.0 + k) * ((angle_deg.to_radians() * (1.0 + k % 2.0) + k).sin() + 0.25)
    })
}

/// Displacement of the ball, µm: the small rotations about X, Y, Z in turn, then the shift.
fn deviation(axis: usize, angle_deg: f64, (l, h): (f64, f64)) -> [f64; 3] {
    let ideal = turned([0.0, h, -l], axis, angle_deg.to_radians());
    let [x, y, z, a, b, c] = truth(angle_deg);
    let actual = turned(turned(turned(ideal, 0, 1e-6 * a), 1, 1e-6 * b), 2, 1e-6 * c);
    let shift = [x, y, z];
    std::array::from_fn(|i| 1e3 * (actual[i] - ideal[i]) + shift[i])
}

fn measured(axis: usize, angles: &[f64], set_ups: &[(f64, f64)], offset: impl Fn(usize) -> f64) -> String {
    let mut text = String::from("# a ball\nl_mm,angle_deg,h_mm,dx_um,dz_um,dy_um\n");
    for &angle in angles {
        for (s, &(l, h)) in set_ups.iter().enumerate() {
            let [x, y, z] = deviation(axis, angle, (l, h)).map(|value| value + offset(s));
            writeln!(text, "{l},{angle},{h},{x},{z},{y}").unwrap();
        }
    }
    text
}

fn circle(step: usize) -> Vec<f64> {
    (0..360).step_by(step).map(|angle| angle as f64).collect()
}

const KEYS: [&str; 6] = ["exc_um", "eyc_um", "ezc_um", "eac_urad", "ebc_urad", "ecc_urad"];

#[test]
fn errors_of_c_come_back_and_become_a_table_that_loads() {
    let directory = Folder::new(TRUEAXIS);
    directory.write("m.csv", measured(2, &circle(15), &SET_UPS, |_| 0.0));
    let found = directory.json(&["identify", "m.csv", "--axis", "C", "--json", "-o", "c.csv", "--report", "out"]);
    assert_eq!((&found["axis"], &found["location"]), (&Value::from("C"), &Value::from("inside")));
    assert_eq!(found["degrees_of_freedom"], 24 * 3);
    let angles = found["angles"].as_array().unwrap();
    assert_eq!(angles.len(), 24);
    for angle in angles {
        for (key, truth) in KEYS.into_iter().zip(truth(angle["angle_deg"].as_f64().unwrap())) {
            let value = angle[key].as_f64().unwrap();
            assert!((value - truth).abs() < 1e-4, "{key} {value} for {truth}");
        }
        assert_eq!(angle["rank"], 6);
        assert!(angle["residual_um"].as_f64().unwrap() < 1e-4 && angle["condition"].as_f64().unwrap() < 30.0);
    }
    assert!(found["sigma_um"].as_f64().unwrap() < 1e-4 && found["standard_errors"]["exc_um"].is_number());

    let table = directory.read("c.csv");
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines[0], "C_deg,EXC_um,EYC_um,EZC_um,EAC_urad,EBC_urad,ECC_urad");
    assert_eq!(lines.len(), 26, "24 angles and the line that closes the circle");
    assert_eq!(lines[1].split_once(',').unwrap().1, lines[25].strip_prefix("360,").unwrap());

    let toml = "name = \"head\"\nchain = \"w b X Y Z C t\"\n[axis.C]\ntable = \"c.csv\"\n";
    directory.write("machine.toml", toml);
    directory.good(&["tables", "check", "machine.toml"]);

    let page = directory.read("out/identify.html");
    let page = page.strip_prefix("<!DOCTYPE html>\n").unwrap();
    let tree = roxmltree::Document::parse(page).unwrap();
    assert_eq!(tree.descendants().filter(|node| node.has_tag_name("figure")).count(), 3);
}

#[test]
fn the_table_on_the_screen_has_the_figures() {
    let directory = Folder::new(TRUEAXIS);
    let angles: Vec<f64> = (0..10).map(|i| 10.0 * f64::from(i)).collect();
    directory.write("m.csv", measured(0, &angles, &SET_UPS_A, |_| 0.0));
    let text = directory.good(&["identify", "m.csv", "--axis", "a", "--report", "page.html", "-o", "a.csv"]);
    let line = text.lines().find(|line| line.trim_start().starts_with("40.000")).unwrap();
    let cells: Vec<f64> = line.split_whitespace().map(|cell| cell.replace('−', "-").parse().unwrap()).collect();
    for (cell, truth) in cells[1..7].iter().zip(truth(40.0)) {
        assert!((cell - truth).abs() < 6e-4, "{line}");
    }
    for needed in ["EXA, µm", "ECA, µrad", "inside", "condition"] {
        assert!(text.contains(needed), "{needed}: {text}");
    }
    assert!(text.lines().any(|line| line.split_whitespace().eq("rank at every angle, of 6 6".split(' '))), "{text}");
    assert!(directory.join("page.html").is_file());
    // A partial circle is not closed.
    let table = directory.read("a.csv");
    assert_eq!(table.lines().count(), 11);
}

#[test]
fn free_offsets_do_not_reach_the_errors() {
    let directory = Folder::new(TRUEAXIS);
    let angles = circle(15);
    directory.write("m.csv", measured(2, &angles, &SET_UPS, |s| 40.0 * s as f64 - 7.0));
    let found = directory.json(&["identify", "m.csv", "--axis", "C", "--free-offsets", "--json"]);
    assert_eq!((&found["location"], &found["null_space"]), (&Value::from("removed"), &Value::from(3)));
    assert!(found["sigma_um"].as_f64().unwrap() < 1e-3);
    let mean: [f64; 3] =
        std::array::from_fn(|i| angles.iter().map(|&angle| truth(angle)[i]).sum::<f64>() / angles.len() as f64);
    for angle in found["angles"].as_array().unwrap() {
        for (i, (key, truth)) in KEYS.into_iter().zip(truth(angle["angle_deg"].as_f64().unwrap())).enumerate() {
            let expected = truth - mean.get(i).copied().unwrap_or(0.0);
            let value = angle[key].as_f64().unwrap();
            assert!((value - expected).abs() < 1e-3, "{key} {value} for {expected}");
        }
    }
    // Offsets differ by 40 µm between set-ups.
    let offset = |s: usize| found["set_ups"][s]["offset_um"][1].as_f64().unwrap();
    assert!((offset(1) - offset(0) - 40.0).abs() < 1e-2 && (offset(2) - offset(1) - 40.0).abs() < 1e-2);
}

#[test]
fn a_measured_closing_angle_is_taken_for_both_ends() {
    let directory = Folder::new(TRUEAXIS);
    let mut angles = circle(30);
    angles.push(360.0);
    let mut text = measured(2, &angles[..12], &SET_UPS, |_| 0.0);
    let closing = measured(2, &[360.0], &SET_UPS, |_| 2.0);
    text.extend(closing.lines().skip(2).map(|line| format!("{line}\n")));
    directory.write("m.csv", text);
    let found = directory.json(&["identify", "m.csv", "--axis", "C", "--json", "-o", "c.csv"]);
    assert_eq!(found["angles"].as_array().unwrap().len(), 13);
    assert!(found["warnings"][0].as_str().unwrap().contains("closes within 2.000 µm"), "{found}");
    let table = directory.read("c.csv");
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!((lines.len(), lines[1].split_once(',').unwrap().1), (14, lines[13].split_once(',').unwrap().1));
    let x: f64 = lines[1].split(',').nth(1).unwrap().parse().unwrap();
    assert!((x - truth(0.0)[0] - 1.0).abs() < 1e-3, "{x}");
}

/// Expects bad readings to be refused with a message that contains all of `needed`.
fn refused(text: &str, arguments: &[&str], needed: &[&str]) {
    let directory = Folder::new(TRUEAXIS);
    directory.write("m.csv", text);
    directory.bad(&[&["identify", "m.csv", "-o", "c.csv", "--report", "out"], arguments].concat(), needed);
}

#[test]
fn set_ups_that_cannot_separate_the_six_are_refused() {
    let line = [(200.0, 0.0), (250.0, 50.0), (300.0, 100.0)];
    let text = measured(2, &circle(30), &line, |_| 0.0);
    refused(&text, &["--axis", "C"], &["m.csv: found collinear set-ups", "141.4214 mm", "rank 5 of 6", "needed"]);
    refused(&text, &["--axis", "C", "--free-offsets"], &["collinear"]);
    let two = measured(2, &circle(30), &line[..2], |_| 0.0);
    refused(&two, &["--axis", "C"], &["m.csv", "l_mm", "found 2 set-ups", "l_mm 250, h_mm 50", "needed at least 3"]);
}

#[test]
fn rows_that_are_missing_twice_or_out_of_order_are_refused() {
    let text = measured(2, &circle(30), &SET_UPS, |_| 0.0);
    let without = |which: usize| {
        let lines = text.lines().enumerate().filter(|(i, _)| *i != which).map(|(_, line)| format!("{line}\n"));
        lines.collect::<String>()
    };
    // Line 6 of the file (0-based) is the second set-up at 30 degrees.
    refused(&without(6), &["--axis", "C"], &["m.csv", "angle_deg", "no row at angle 30", "l_mm 250, h_mm 160"]);
    let twice = format!("{text}{}\n", text.lines().nth(3).unwrap());
    refused(&twice, &["--axis", "C"], &["m.csv:39: column angle_deg", "a second row", "line 4", "needed one row"]);
    let backwards = measured(2, &[0.0, 60.0, 30.0], &SET_UPS, |_| 0.0);
    refused(&backwards, &["--axis", "C"], &["m.csv:9: column angle_deg", "30", "more than 60 of line 6"]);
    let radians: Vec<f64> = circle(30).iter().map(|angle| (angle.to_radians() * 1e4).round() / 1e4).collect();
    let radians = measured(2, &radians, &SET_UPS, |_| 0.0);
    refused(&radians, &["--axis", "C"], &["m.csv:36: column angle_deg: found 5.7596", "needed angles in degrees"]);
    let beyond = measured(2, &[0.0, 120.0, 240.0, 370.0], &SET_UPS, |_| 0.0);
    refused(&beyond, &["--axis", "C"], &["m.csv:12: column angle_deg", "370", "at most 360"]);
}

#[test]
fn columns_and_numbers_are_checked() {
    let text = measured(2, &circle(30), &SET_UPS, |_| 0.0);
    let renamed = text.replace("angle_deg", "C_deg");
    refused(&renamed, &["--axis", "C"], &["m.csv:2: column C_deg", "needed one of angle_deg"]);
    let mixed = text.replacen("h_mm", "a_deg", 1);
    refused(&mixed, &["--axis", "A"], &["m.csv:2", "a_deg"]);
    let missing = "angle_deg,l_mm,h_mm,dx_um,dy_um\n0,1,1,1,1\n";
    refused(missing, &["--axis", "C"], &["m.csv:1", "the column dz_um"]);
    let broken = text.replacen("\n250,30,", "\nnan,30,", 1);
    refused(&broken, &["--axis", "C"], &["m.csv:6: column l_mm", "nan", "finite"]);
    refused(&text, &["--axis", "X"], &["--axis", "'X'"]);
    refused("angle_deg,l_mm,h_mm,dx_um,dy_um,dz_um\n", &["--axis", "C"], &["m.csv", "no rows"]);
}

#[test]
fn a_single_angle_makes_no_table_and_free_offsets_need_several() {
    let text = measured(2, &[45.0], &SET_UPS, |_| 0.0);
    refused(&text, &["--axis", "C"], &["m.csv", "found one angle, needed at least two"]);
    refused(&text, &["--axis", "C", "--free-offsets"], &["free offsets", "needed 3", "more angles"]);
}

#[test]
fn the_machine_must_have_the_axis() {
    let text = measured(2, &circle(30), &SET_UPS, |_| 0.0);
    let machine = concat!(env!("CARGO_MANIFEST_DIR"), "/../../compensation-tables/mill-3axis");
    refused(&text, &["--axis", "C", "--machine", machine], &["mill-3axis", "found no axis C"]);
    refused(&text, &["--axis", "C", "--machine", "nowhere"], &["nowhere"]);
}

/// A head on X: the ball of the first set-up hangs 250 mm below the head, and RTCP keeps every ball there.
const HEAD: &str = "name = \"head\"\nchain = \"w b X Y Z C A t\"\n[axis.X]\ntable = \"x.csv\"\n";

#[test]
fn the_linear_axes_own_errors_are_removed() {
    let directory = Folder::new(TRUEAXIS);
    directory.write("machine.toml", HEAD);
    // 0.2 µm and 0.1 µrad per mm of X.
    directory.write("x.csv", "X_mm,EXX_um,EBX_urad\n-500,-100,-50\n500,100,50\n");
    let start = 120.0;
    let mut text = String::from("angle_deg,l_mm,h_mm,dx_um,dy_um,dz_um\n");
    for angle in circle(20) {
        for (l, h) in SET_UPS {
            let arm = turned([0.0, h, -l], 2, angle.to_radians());
            let x = start - arm[0];
            let tilt = 0.1 * x;
            let [dx, dy, dz] = deviation(2, angle, (l, h));
            let (dx, dz) = (dx + 0.2 * x - 1e-3 * tilt * SET_UPS[0].0, dz - 1e-3 * tilt * arm[0]);
            writeln!(text, "{angle},{l},{h},{dx},{dy},{dz}").unwrap();
        }
    }
    directory.write("m.csv", text);
    let given = ["identify", "m.csv", "--axis", "C", "--json", "--machine", "machine.toml", "--start-mm", "120,0,0"];
    let found = directory.json(&given);
    for angle in found["angles"].as_array().unwrap() {
        for (key, truth) in KEYS.into_iter().zip(truth(angle["angle_deg"].as_f64().unwrap())) {
            let value = angle[key].as_f64().unwrap();
            assert!((value - truth).abs() < 1e-3, "{key} {value} for {truth} at {}", angle["angle_deg"]);
        }
    }
    assert!(found["warnings"][0].as_str().unwrap().contains("own errors are removed"), "{found}");
    // Without the machine, the errors of X enter those of C.
    let raw = directory.json(&["identify", "m.csv", "--axis", "C", "--json"]);
    let apart = raw["angles"][4]["exc_um"].as_f64().unwrap() - found["angles"][4]["exc_um"].as_f64().unwrap();
    assert!(apart.abs() > 5.0, "{apart}");
    // A start that moves X beyond its table is reported.
    let far = ["identify", "m.csv", "--axis", "C", "--json", "--machine", "machine.toml", "--start-mm", "450,0,0"];
    let far = directory.json(&far);
    assert!(far["warnings"][1].as_str().unwrap().contains("edge value"), "{far}");
}

/// Decided and written by the rule of all commands: the errors in excess of table and location errors, all six together.
#[test]
fn errors_of_an_axis_go_into_a_machine_by_the_rule_of_all_commands() {
    let directory = Folder::new(TRUEAXIS);
    // Readings with a scatter of 0.2 µm that differs between runs.
    let scattered = |size: f64, seed: usize| {
        let text = measured(2, &circle(15), &SET_UPS, |_| 0.0);
        let mut rows = text.lines().map(str::to_owned);
        let head: Vec<String> = rows.by_ref().take(2).collect();
        let rows = rows.enumerate().map(|(i, row)| {
            let mut cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
            for (k, cell) in cells[3..].iter_mut().enumerate() {
                *cell += size * ((7 * i + 3 * k + 5 * seed) as f64 * 2.399).sin() * 1.414;
            }
            cells.iter().map(f64::to_string).collect::<Vec<_>>().join(",")
        });
        head.into_iter().chain(rows).collect::<Vec<_>>().join("\n") + "\n"
    };
    let toml =
        "name = \"head\"\nchain = \"w b X Y Z C t\"\n[axis.C]\ntable = \"c.csv\" # ours\n[location]\nEX0C_um = 2\n";
    directory.write("head/machine.toml", toml);
    directory.write("head/c.csv", "C_deg,EXC_um,ECC_urad\n-180,1,3\n0,-1,-3\n180,1,3\n");
    directory.write("m.csv", scattered(0.2, 1));
    let call = ["identify", "m.csv", "--axis", "C", "--machine", "head"];
    let before = directory.tree();
    let said = directory.json(&[&call[..], &["--dry-run", "--json"]].concat());
    assert_eq!(directory.tree(), before);
    let written = said["written"].as_array().unwrap();
    assert_eq!((written.len(), &written[0]["key"]), (6, &Value::from("axis.C.EXC_um")), "{said}");
    assert!(written.iter().all(|of| of["written"].is_object()) && said["angles"].is_array(), "{said}");
    directory.good(&[&call[..], &["-o", "head"]].concat());
    // Table and location errors add up to the result.
    let table = directory.read("head/c.csv");
    let [first, last] = [1, table.lines().count() - 1].map(|line| table.lines().nth(line).unwrap());
    assert!(first.starts_with("-180,") && last.starts_with("180,"), "{table}");
    let found = directory.json(&["identify", "m.csv", "--axis", "C", "--json"]);
    for line in table.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let angles = found["angles"].as_array().unwrap();
        let own = angles.iter().find(|angle| angle["angle_deg"] == cells[0].rem_euclid(360.0)).unwrap();
        for (k, key) in KEYS.into_iter().enumerate() {
            let stated = cells[1 + k] + if k == 0 { 2.0 } else { 0.0 };
            let value = own[key].as_f64().unwrap();
            assert!((stated - value).abs() < 1e-3, "{key} {stated} for {value} at {}", cells[0]);
        }
    }
    let text = directory.read("head/machine.toml");
    assert!(text.contains("table = \"c.csv\" # ours") && text.contains("EX0C_um = 2\n"), "{text}");
    assert!(text.contains("[axis.C.uncertainty]") && text.contains("ECC_degrees_of_freedom = 72"), "{text}");
    directory.good(&["tables", "check", "head"]);
    // The same record changes nothing; another one that agrees is averaged, with one weight for all six.
    let [_, stderr] = directory.both(&[&call[..], &["-o", "head"]].concat());
    assert!(stderr.contains("this record is already included") && directory.read("head/c.csv") == table, "{stderr}");
    directory.write("m.csv", scattered(0.2, 2));
    let said = directory.json(&[&call[..], &["-o", "head", "--json"]].concat());
    let shares = said["written"].as_array().unwrap().iter().map(|of| {
        assert_eq!(of["why"], "agrees: weighted mean of both", "{said}");
        of["written"]["value"].as_f64().unwrap() / of["found"]["value"].as_f64().unwrap()
    });
    assert!(shares.clone().all(|share| (share - 0.5).abs() < 0.12), "{:?}", shares.collect::<Vec<_>>());
    // Readings that six errors do not explain write nothing.
    directory.write("m.csv", scattered(40.0, 3));
    let before = directory.read("head/c.csv");
    let [_, stderr] = directory.both(&[&call[..], &["-o", "head"]].concat());
    assert!(stderr.contains("misfit: ") && directory.read("head/c.csv") == before, "{stderr}");
    let [_, stderr] = directory.both(&[&call[..], &["-o", "forced", "--force"]].concat());
    assert!(stderr.contains("forced, the rule writes nothing: misfit: "), "{stderr}");
    assert!(directory.read("forced/c.csv") != before && directory.read("head/c.csv") == before);
    directory.bad(&[&call[..], &["-o", "own.csv", "--force"]].concat(), &["--force: found no machine to write"]);
    // A .csv gets the table, to read, also with a machine.
    directory.good(&["identify", "m.csv", "--axis", "C", "--machine", "head", "-o", "own.csv"]);
    assert!(directory.read("own.csv").starts_with("C_deg,EXC_um"));
}
