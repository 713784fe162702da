//! `trueaxis correct`, compared with `compensate` and with exact transforms, and every invalid query.

use serde_json::Value;
use std::path::Path;
use trueaxis_testing::command::{Folder, numbers};

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

fn document(directory: &Folder, arguments: &[&str]) -> Value {
    directory.json(&[arguments, &["--json"]].concat())
}

/// Equal but for the last digit, which reading JSON may change.
#[track_caller]
fn same(found: &[f64], wanted: &[f64], at: &str) {
    assert_eq!(found.len(), wanted.len());
    for (found, wanted) in found.iter().zip(wanted) {
        assert!((found - wanted).abs() <= 1e-14 * wanted.abs().max(1.0), "{at}: {found} {wanted}");
    }
}

/// A folder with the sample machines.
fn folder() -> Folder {
    let directory = Folder::new(TRUEAXIS);
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables");
    for name in ["mill-3axis", "mill-5axis"] {
        directory.copy(&samples.join(name), name);
    }
    directory
}

/// The row that `compensate` writes for a position, without the position.
fn compensated(directory: &Folder, machine: &str, header: &str, at: &str, options: &[&str]) -> Vec<f64> {
    directory.write("p.csv", format!("{header}\n{at}\n"));
    let [text, _] = directory.both(&[&["compensate", machine, "p.csv"], options].concat());
    let row = text.lines().nth(1).unwrap();
    row.split(',').skip(header.split(',').count()).map(|cell| cell.parse().unwrap()).collect()
}

const THREE: &str = "x_mm,y_mm,z_mm";
const FIVE: &str = "x_mm,y_mm,z_mm,a_deg,c_deg";

#[test]
fn the_same_as_compensate() {
    let directory = folder();
    for (at, direction, options) in [
        ("120,-40,-200", "+x", &[][..]),
        ("-250.5,130.25,-12", "-x,-y,-z", &["--reverse"]),
        ("0,0,0", "+X,+Y,+Z", &["--temperature-c", "24.5"]),
    ] {
        let at_option = format!("--at={at}");
        let temperature = options.iter().copied().filter(|option| *option != "--reverse");
        let asked: Vec<&str> =
            ["correct", "mill-3axis", &at_option, "--direction", direction].into_iter().chain(temperature).collect();
        let found = document(&directory, &asked);
        let row = compensated(&directory, "mill-3axis", THREE, at, options);
        same(&[numbers(&found["error_um"]), numbers(&found["command_mm"])].concat(), &row, at);
        assert_eq!(found["clamped"].as_array().unwrap().len() + found["out_of_travel"].as_array().unwrap().len(), 0);
        assert_eq!(found.get("error_urad"), None);
        for ((at, correction), command) in
            numbers(&found["at_mm"]).iter().zip(numbers(&found["correction_mm"])).zip(numbers(&found["command_mm"]))
        {
            assert!((at + correction - command).abs() < 1e-12);
        }
        let shares = found["contributions"].as_array().unwrap();
        let sources: Vec<&str> = shares.iter().map(|share| share["source"].as_str().unwrap()).collect();
        assert_eq!(sources, ["X", "Y", "Z", "location errors"]);
        for (axis, error) in numbers(&found["error_um"]).into_iter().enumerate() {
            let sum: f64 = shares.iter().map(|share| share["error_um"][axis].as_f64().unwrap()).sum();
            assert!((sum - error).abs() < 1e-9, "{sum} {error}");
        }
    }
}

#[test]
fn five_axes_agree_with_compensate_and_with_exact_transforms() {
    let directory = folder();
    for at in ["50,-30,-50,-20,75", "0,0,150,0,0", "-80,60,240,-60,200"] {
        let found = document(&directory, &["correct", "mill-5axis", &format!("--at={at}")]);
        assert_eq!(found["model"], "volumetric");
        let own = compensated(&directory, "mill-5axis", FIVE, at, &[]);
        same(&numbers(&found["error_um"]), &own[..3], at);
        let exact = compensated(&directory, "mill-5axis", FIVE, at, &["--model", "exact", "--orientation"]);
        let together = [numbers(&found["error_um"]), numbers(&found["error_urad"])].concat();
        for (found, exact) in together.iter().zip(exact[..3].iter().chain(&exact[6..9])) {
            assert!((found - exact).abs() <= 0.02 + 5e-3 * exact.abs(), "{at}: {found} {exact}");
        }
        for letter in ["A", "C"] {
            let of = |key: &str| found[key][letter].as_f64().unwrap();
            assert!((of("at_deg") + of("correction_deg") - of("command_deg")).abs() < 1e-12);
        }
    }
}

#[test]
fn without_a_position_the_middle_of_the_travel() {
    let directory = folder();
    let [text, stderr] = directory.both(&["correct", "mill-3axis"]);
    assert!(text.contains("at X 0, Y 0, Z -200 mm (middle of the travel)") && stderr.is_empty(), "{text}{stderr}");
    let found = document(&directory, &["correct", "mill-3axis"]);
    assert_eq!(found, document(&directory, &["correct", "mill-3axis", "--at", "0,0,-200"]));
    // Omitted rotary axes are at zero.
    let five = document(&directory, &["correct", "mill-5axis", "--at", "0,0,-100"]);
    assert_eq!(five, document(&directory, &["correct", "mill-5axis", "--at", "0,0,-100,0,0"]));
}

#[test]
fn beyond_the_tables_the_edge_value_is_clamped() {
    let directory = folder();
    let output = directory.run(&["correct", "mill-3axis", "--at", "5000,0,-200", "--json"]);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && stderr.contains("axis X beyond the end of the table"), "{stderr}");
    assert!(stderr.contains("axis X outside the declared travel"), "{stderr}");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&found["clamped"], &found["out_of_travel"]), (&serde_json::json!(["X"]), &serde_json::json!(["X"])));
    let edge = document(&directory, &["correct", "mill-3axis", "--at", "300,0,-200"]);
    assert_eq!(found["contributions"][0], edge["contributions"][0]);
}

#[test]
fn wrong_questions_are_refused() {
    let directory = folder();
    for (arguments, parts) in [
        (&["mill-3axis", "--at", "1,2"][..], &["--at", "2 numbers", "X,Y,Z"][..]),
        (&["mill-3axis", "--at", "1,2,3,4"], &["--at", "4 numbers", "X,Y,Z"]),
        (&["mill-5axis", "--at", "1,2,3,4"], &["--at", "4 numbers", "5 with X,Y,Z,A,C"]),
        (&["mill-3axis", "--at", "1,x,3"], &["--at", "\"x\"", "a finite number"]),
        (&["mill-3axis", "--at", "1,nan,3"], &["--at", "\"nan\"", "a finite number"]),
        (&["mill-3axis", "--at", "1,2e9,3"], &["--at", "axis Y", "at most"]),
        (&["mill-3axis", "--direction", "x"], &["--direction", "\"x\"", "+ or -", "X, Y, Z"]),
        (&["mill-3axis", "--direction=-x,+x"], &["--direction", "axis X twice"]),
        (&["mill-3axis", "--direction=+c"], &["--direction", "\"+c\"", "X, Y, Z"]),
        (&["mill-3axis", "--temperature-c", "1e9"], &["--temperature-c", "K above"]),
        (&["nowhere"], &["nowhere", "needed a readable file"]),
    ] {
        let output = directory.run(&[&["correct"], arguments].concat());
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{arguments:?}: {error}");
        for part in parts {
            assert!(error.contains(part), "{arguments:?}: {error}");
        }
    }
}
