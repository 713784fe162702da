//! The three models of `trueaxis compensate` against products of transforms worked out elsewhere
//! (tests/reference/volumetric.py).

use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

fn reference() -> Vec<Value> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/reference/volumetric.json");
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

fn call(directory: &TempDir, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_trueaxis")).args(arguments).current_dir(directory.path()).output().unwrap()
}

/// Header and numbers of the CSV that a call prints.
fn good(directory: &TempDir, arguments: &[&str]) -> (String, Vec<Vec<f64>>) {
    let output = call(directory, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let mut lines = text.lines();
    let header = lines.next().unwrap().to_owned();
    (header, lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect())
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

/// Writes a machine and its positions; returns the header of the positions.
fn put(directory: &TempDir, machine: &Value) -> String {
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
        fs::write(directory.path().join(format!("{letter}.csv")), csv).unwrap();
    }
    toml.push_str("[location]\n");
    for (key, value) in machine["location"].as_object().unwrap() {
        let _ = writeln!(toml, "{key} = {value}");
    }
    fs::write(directory.path().join("machine.toml"), toml).unwrap();
    header.join(",")
}

fn put_positions(directory: &TempDir, name: &str, header: &str, rows: &[Vec<f64>]) {
    let lines = rows.iter().map(|row| row.iter().map(f64::to_string).collect::<Vec<_>>().join(","));
    fs::write(directory.path().join(name), format!("{header}\n{}\n", lines.collect::<Vec<_>>().join("\n"))).unwrap();
}

#[test]
fn both_models_agree_with_homogeneous_transforms() {
    for machine in reference() {
        let directory = tempfile::tempdir().unwrap();
        let header = put(&directory, &machine);
        let axes = header.split(',').count();
        let positions = machine["positions"].as_array().unwrap();
        let rows: Vec<Vec<f64>> = positions.iter().map(|position| numbers(&position["at"])).collect();
        put_positions(&directory, "p.csv", &header, &rows);
        for (model, absolute, relative) in [("exact", 1e-9, 0.0), ("volumetric", 0.0, 5e-3)] {
            let (_, found) = good(&directory, &["compensate", ".", "p.csv", "--model", model, "--orientation"]);
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
        // A compiled file says the same, bit for bit.
        let plain = good(&directory, &["compensate", ".", "p.csv", "--model", "exact"]);
        assert!(call(&directory, &["tables", "compile", ".", "-o", "m.tcomp"]).status.success());
        assert_eq!(good(&directory, &["compensate", "m.tcomp", "p.csv", "--model", "exact"]), plain);
        assert_eq!(plain.0, format!("{header},ex_um,ey_um,ez_um,cx_mm,cy_mm,cz_mm"));
        // Sent to the corrected commands, the machine stands where it should: their error is what was taken away.
        let sent: Vec<Vec<f64>> =
            (plain.1.iter().zip(&rows)).map(|(row, at)| [&row[axes + 3..axes + 6], &at[3..]].concat()).collect();
        put_positions(&directory, "sent.csv", &header, &sent);
        let (_, left) = good(&directory, &["compensate", ".", "sent.csv", "--model", "exact"]);
        for ((at, sent), row) in rows.iter().zip(&sent).zip(&left) {
            for k in 0..3 {
                let off = (sent[k] - at[k]) * 1e3 + row[axes + k];
                assert!(off.abs() < 1e-8, "{}: {off} um", machine["name"]);
            }
        }
    }
}

#[test]
fn orientation_needs_a_model_that_has_one() {
    let directory = tempfile::tempdir().unwrap();
    let machine = &reference()[1];
    let header = put(&directory, machine);
    put_positions(&directory, "p.csv", &header, &[vec![1.0, 2.0, 3.0, -40.0, 5.0]]);
    let (columns, _) = good(&directory, &["compensate", ".", "p.csv", "--model", "volumetric", "--orientation"]);
    assert!(columns.ends_with("cz_mm,ea_urad,eb_urad,ec_urad,ca_deg,cc_deg"), "{columns}");
    let output = call(&directory, &["compensate", ".", "p.csv", "--orientation"]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("--model nine") && error.contains("--model exact"), "{error}");
    assert!(output.stdout.is_empty());
}
