//! The three models of `trueaxis compensate` against independently computed products of transforms
//! (tests/reference/volumetric.py).

use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use trueaxis_testing::command::{Folder, numbers};

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

fn reference() -> Vec<Value> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/reference/volumetric.json");
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// Writes a machine and its positions; returns the header of the positions.
fn put(directory: &Folder, machine: &Value) -> String {
    let mut toml =
        format!("name = {}\nchain = {}\ntool_mm = {}\n", machine["name"], machine["chain"], machine["tool_mm"]);
    let mut header = Vec::new();
    for letter in ["X", "Y", "Z", "A", "B", "C"] {
        let Some(axis) = machine["axes"].get(letter) else { continue };
        let unit = if "XYZ".contains(letter) { "mm" } else { "deg" };
        header.push(format!("{}_{unit}", letter.to_lowercase()));
        let _ = writeln!(toml, "[axis.{letter}]\ntable = \"{letter}.csv\"");
        for key in ["offset_mm", "measured_at_mm", "direction"] {
            if let Some(value) = axis.get(key) {
                let _ = writeln!(toml, "{key} = {value}");
            }
        }
        let columns =
            "XYZABC".chars().map(|d| format!("E{d}{letter}_{}", if "XYZ".contains(d) { "um" } else { "urad" }));
        let mut csv = format!("{letter}_{unit},{}\n", columns.collect::<Vec<_>>().join(","));
        for row in axis["table"].as_array().unwrap() {
            let cells: Vec<String> = numbers(row).iter().map(f64::to_string).collect();
            let _ = writeln!(csv, "{}", cells.join(","));
        }
        directory.write(format!("{letter}.csv"), csv);
    }
    toml.push_str("[location]\n");
    for (key, value) in machine["location"].as_object().unwrap() {
        let _ = writeln!(toml, "{key} = {value}");
    }
    directory.write("machine.toml", toml);
    header.join(",")
}

fn put_positions(directory: &Folder, name: &str, header: &str, rows: &[Vec<f64>]) {
    let lines = rows.iter().map(|row| row.iter().map(f64::to_string).collect::<Vec<_>>().join(","));
    directory.write(name, format!("{header}\n{}\n", lines.collect::<Vec<_>>().join("\n")));
}

#[test]
fn both_models_agree_with_homogeneous_transforms() {
    for machine in reference() {
        let directory = Folder::new(TRUEAXIS);
        let header = put(&directory, &machine);
        let axes = header.split(',').count();
        let positions = machine["positions"].as_array().unwrap();
        let rows: Vec<Vec<f64>> = positions.iter().map(|position| numbers(&position["at"])).collect();
        put_positions(&directory, "p.csv", &header, &rows);
        for (model, absolute, relative) in [("exact", 1e-9, 0.0), ("volumetric", 0.0, 5e-3)] {
            let (_, found) = directory.csv(&["compensate", ".", "p.csv", "--model", model, "--orientation"]);
            let mut worst = 0.0_f64;
            for (row, position) in found.iter().zip(positions) {
                let (tip, turn) = (&row[axes..axes + 3], &row[axes + 6..axes + 9]);
                for (found, wanted) in [(tip, &position["tip_um"]), (turn, &position["orientation_urad"])] {
                    let wanted = numbers(wanted);
                    let size = wanted.iter().map(|value| value * value).sum::<f64>().sqrt();
                    for (found, wanted) in found.iter().zip(wanted) {
                        let off = (found - wanted).abs();
                        worst = worst.max(off / if relative > 0.0 { size } else { 1.0 });
                        assert!(off <= absolute + relative * size, "{}, {model}: {found} {wanted}", machine["name"]);
                    }
                }
            }
            println!("{}, {model}: {worst:.1e}", machine["name"]);
        }
        // A compiled file gives the same results, bit for bit.
        let plain = directory.csv(&["compensate", ".", "p.csv", "--model", "exact"]);
        assert!(directory.run(&["tables", "compile", ".", "-o", "m.tcomp"]).status.success());
        assert_eq!(directory.csv(&["compensate", "m.tcomp", "p.csv", "--model", "exact"]), plain);
        assert_eq!(plain.0, format!("{header},ex_um,ey_um,ez_um,cx_mm,cy_mm,cz_mm"));
        // At the corrected commands the machine reaches its targets: the error there equals the correction applied.
        let sent: Vec<Vec<f64>> =
            (plain.1.iter().zip(&rows)).map(|(row, at)| [&row[axes + 3..axes + 6], &at[3..]].concat()).collect();
        put_positions(&directory, "sent.csv", &header, &sent);
        let (_, left) = directory.csv(&["compensate", ".", "sent.csv", "--model", "exact"]);
        for ((at, sent), row) in rows.iter().zip(&sent).zip(&left) {
            for k in 0..3 {
                let off = (sent[k] - at[k]) * 1e3 + row[axes + k];
                assert!(off.abs() < 1e-8, "{}: {off} um", machine["name"]);
            }
        }
    }
}

/// A machine whose largest errors are in grids: every model's corrected commands leave only the residual of its inverse.
#[test]
fn corrected_commands_of_every_model_take_the_grids_in() {
    let directory = Folder::new(TRUEAXIS);
    let router = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/router");
    let router = router.to_str().unwrap();
    let at = [[0.0, 0.0, -250.0], [310.0, -220.0, -180.0], [-385.0, 140.0, -30.0], [75.0, 260.0, -205.0]];
    put_positions(&directory, "p.csv", "x_mm,y_mm,z_mm", &at.map(Vec::from));
    // The nine terms and the first order differ from the exact transforms by at most 1 nm.
    for (model, left_um) in [("nine", 1e-3), ("volumetric", 1e-3), ("exact", 1e-8)] {
        let (_, rows) = directory.csv(&["compensate", router, "p.csv", "--model", model]);
        let sent: Vec<Vec<f64>> = rows.iter().map(|row| row[6..9].to_vec()).collect();
        put_positions(&directory, "sent.csv", "x_mm,y_mm,z_mm", &sent);
        let (_, there) = directory.csv(&["compensate", router, "sent.csv", "--model", "exact"]);
        for ((at, sent), there) in at.iter().zip(&sent).zip(&there) {
            for k in 0..3 {
                let left = (sent[k] - at[k]) * 1e3 + there[3 + k];
                assert!(left.abs() < left_um, "{model} {at:?}: {left} um");
            }
        }
    }
}

#[test]
fn orientation_needs_a_model_that_has_one() {
    let directory = Folder::new(TRUEAXIS);
    let machine = &reference()[1];
    let header = put(&directory, machine);
    put_positions(&directory, "p.csv", &header, &[vec![1.0, 2.0, 3.0, -40.0, 5.0]]);
    let (columns, _) = directory.csv(&["compensate", ".", "p.csv", "--model", "volumetric", "--orientation"]);
    assert!(columns.ends_with("cz_mm,ea_urad,eb_urad,ec_urad,ca_deg,cc_deg"), "{columns}");
    let output = directory.run(&["compensate", ".", "p.csv", "--orientation"]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("model nine of the machine") && error.contains("--model exact"), "{error}");
    assert!(output.stdout.is_empty());
}

#[test]
fn the_model_defaults_to_the_machines_own() {
    let directory = Folder::new(TRUEAXIS);
    for machine in ["mill-3axis", "mill-5axis", "head-5axis"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables").join(machine);
        let folder = folder.to_str().unwrap();
        put_positions(&directory, "p.csv", "x_mm,y_mm,z_mm", &[vec![80.0, -90.0, -50.0], vec![-120.0, 30.0, -20.0]]);
        let toml = fs::read_to_string(Path::new(folder).join("machine.toml")).unwrap();
        let (own, other) =
            if toml.contains("model = \"volumetric\"") { ("volumetric", "nine") } else { ("nine", "volumetric") };
        let output = directory.run(&["compensate", folder, "p.csv"]);
        assert!(output.status.success() && output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
        let (_, rows) = directory.csv(&["compensate", folder, "p.csv"]);
        assert_eq!(directory.csv(&["compensate", folder, "p.csv", "--model", own]).1, rows, "{machine}");
        assert_ne!(directory.csv(&["compensate", folder, "p.csv", "--model", other]).1, rows, "{machine}");
        directory.run(&["tables", "compile", folder, "-o", "m.tcomp"]);
        assert_eq!(directory.csv(&["compensate", "m.tcomp", "p.csv"]).1, rows, "{machine}");
    }
}

/// X moves up and down by less and by more than the hysteresis; its straightness makes Y's drive reverse although Y is not
/// commanded to move: Y has 2 µm of lost motion, X none.
#[test]
fn in_order_the_direction_is_that_of_the_drives() {
    let directory = Folder::new(TRUEAXIS);
    let toml = "name = \"m\"\nchain = \"w b X Y Z t\"\n[axis.X]\ntable = \"x.csv\"\n[axis.Y]\ntable = \"y.csv\"\nbacklash_um = 2\n";
    directory.write("machine.toml", toml);
    // EYX rises by 0.1 µm per mm.
    directory.write("x.csv", "X_mm,EYX_um\n0,0\n100,10\n");
    directory.write("y.csv", "Y_mm,EYY_um\n-50,0\n50,0\n");
    let x = [10.0, 12.0, 14.0, 12.0, 30.0, 29.0, 25.0];
    put_positions(&directory, "p.csv", "x_mm,y_mm,z_mm", &x.map(|x| vec![x, 5.0, 0.0]));
    // Y's drive: −0.2 (within 0.3 µm), −0.4 (reversed), +0.2 (within), −1.6, +0.1 (within), +0.5 µm (reversed).
    let reverse = [0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0];
    for model in ["nine", "volumetric", "exact"] {
        let (_, rows) = directory.csv(&["compensate", ".", "p.csv", "--model", model, "--in-order"]);
        for ((row, x), reverse) in rows.iter().zip(x).zip(reverse) {
            let error = 0.1 * x + 2.0 * reverse;
            assert!(
                (row[4] - error).abs() < 1e-9 && (row[7] - (5.0 - 1e-3 * error)).abs() < 1e-9,
                "{model} {x}: {row:?}"
            );
        }
        // Without --in-order, every row is independent.
        let (_, rows) = directory.csv(&["compensate", ".", "p.csv", "--model", model]);
        assert!(rows.iter().zip(x).all(|(row, x)| (row[4] - 0.1 * x).abs() < 1e-9));
    }
    let output = directory.run(&["compensate", ".", "p.csv", "--in-order", "--reverse"]);
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn check_reports_the_cost_of_lost_motion() {
    let directory = Folder::new(TRUEAXIS);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables/mill-3axis");
    let folder = folder.to_str().unwrap();
    let output = directory.run(&["tables", "check", folder, "--json"]);
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    let lost = document["lost_motion"].as_array().unwrap();
    let y = lost.iter().find(|lost| lost["axis"] == "Y").unwrap();
    // 2.2 µm, accelerated at 5 m/s² and decelerated at 4 m/s²; 250 mm/s.
    let ms = 1e3 * (2.0 * 2.2e-3 * (1.0 / 5000.0 + 1.0 / 4000.0_f64)).sqrt();
    for (key, truth) in [("play_um", 2.2), ("lead_in_ms", ms), ("feed_mm_per_s", 250.0), ("way_mm", 0.25 * ms)] {
        assert!((y[key].as_f64().unwrap() - truth).abs() < 1e-9, "{y}");
    }
    let output = directory.run(&["tables", "check", folder]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("axis Y: lost motion of up to 2.2 µm is corrected within 1.4 ms of a reversal"), "{text}");
}
