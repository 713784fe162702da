//! The ball cycle of a five-axis head, from the command line.

use serde_json::Value;
use std::fs;
use std::process::{Command, Output};

fn call(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_firmware-sim")).arg("rtcp").args(arguments).output().unwrap()
}

fn document(arguments: &[&str]) -> Value {
    let output = call(arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn number(value: &Value, pointer: &str) -> f64 {
    value.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("{pointer} in {value}"))
}

#[test]
fn a_tenth_of_the_tip_error_or_less_is_left() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().to_str().unwrap();
    let found = document(&["--json", "--report", out]);
    assert!(number(&found, "/tip_error_um/before/rms") > 10.0, "{}", found["tip_error_um"]);
    for figure in ["max", "rms"] {
        let ratio = number(&found, &format!("/tip_error_um/ratio/{figure}"));
        assert!(ratio < 0.1, "{figure}: {ratio}");
        for axis in 0..2 {
            let ratio = number(&found, &format!("/axes/{axis}/tip_error_um/ratio/{figure}"));
            assert!(ratio < 0.1, "axis {axis}, {figure}: {ratio}");
        }
    }
    for axis in 0..2 {
        let sigma = number(&found, &format!("/axes/{axis}/sigma_um"));
        assert!((sigma / 0.2 - 1.0).abs() < 0.25, "{sigma}");
    }
    assert_eq!(found["axes"][0]["over_angle"].as_array().unwrap().len(), 360);
    for name in ["measured-c.csv", "measured-a.csv", "c.csv", "a.csv"] {
        assert!(directory.path().join(name).is_file(), "{name}");
    }
    let table = fs::read_to_string(directory.path().join("c.csv")).unwrap();
    assert!(table.starts_with("C_deg,EXC_um,EYC_um,EZC_um,EAC_urad,EBC_urad,ECC_urad\n0,"));
    assert_eq!(table.lines().count(), 38);
    let page = fs::read_to_string(directory.path().join("rtcp.html")).unwrap();
    let tree = roxmltree::Document::parse(page.strip_prefix("<!DOCTYPE html>\n").unwrap()).unwrap();
    assert_eq!(tree.descendants().filter(|node| node.has_tag_name("figure")).count(), 8);
}

#[test]
fn the_seed_repeats_and_noise_is_what_is_left() {
    let [first, again, other] = ["3", "3", "4"].map(|seed| document(&["--json", "--seed", seed]));
    assert_eq!(first, again);
    assert_ne!(first["tip_error_um"]["after"], other["tip_error_um"]["after"]);
    // A perfect gauge leaves the tables' interpolation and second order only.
    let clean = document(&["--json", "--gauge-noise-um", "0"]);
    assert!(number(&clean, "/tip_error_um/ratio/rms") < 0.01, "{}", clean["tip_error_um"]);
    assert!(number(&clean, "/axes/0/sigma_um") < 0.01);
}

#[test]
fn other_machines_and_arguments_are_refused() {
    for (arguments, needed) in [
        (["--machine", "mill-5axis"], "ends in \"C A t\""),
        (["--machine", "mill-3axis"], "ends in \"C A t\""),
        (["--gauge-noise-um", "-1"], "needed 0 to 100"),
        (["--gauge-noise-um", "nan"], "needed 0 to 100"),
        (["--machine", "no-such"], "no-such"),
    ] {
        let output = call(&arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(output.stdout.is_empty() && message.contains(needed), "{message}");
    }
}
