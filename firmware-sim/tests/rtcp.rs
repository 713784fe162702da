//! The ball cycle of a five-axis head, from the command line.

use serde_json::Value;
use trueaxis_testing::command::Folder;

const SIMULATOR: &str = env!("CARGO_BIN_EXE_firmware-sim");

fn number(value: &Value, pointer: &str) -> f64 {
    value.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("{pointer} in {value}"))
}

#[test]
fn a_tenth_of_the_tip_error_or_less_is_left() {
    let directory = Folder::new(SIMULATOR);
    let found = directory.json(&["rtcp", "--json", "--report", "."]);
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
        assert!(directory.has(name), "{name}");
    }
    let table = directory.read("c.csv");
    assert!(table.starts_with("C_deg,EXC_um,EYC_um,EZC_um,EAC_urad,EBC_urad,ECC_urad\n0,"));
    assert_eq!(table.lines().count(), 38);
    let page = directory.read("rtcp.html");
    let tree = roxmltree::Document::parse(page.strip_prefix("<!DOCTYPE html>\n").unwrap()).unwrap();
    assert_eq!(tree.descendants().filter(|node| node.has_tag_name("figure")).count(), 8);
}

#[test]
fn the_seed_repeats_and_noise_is_what_is_left() {
    let directory = Folder::new(SIMULATOR);
    let [first, again, other] = ["3", "3", "4"].map(|seed| directory.json(&["rtcp", "--json", "--seed", seed]));
    assert_eq!(first, again);
    assert_ne!(first["tip_error_um"]["after"], other["tip_error_um"]["after"]);
    // With a perfect gauge only the tables' interpolation and second-order errors remain.
    let clean = directory.json(&["rtcp", "--json", "--gauge-noise-um", "0"]);
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
        Folder::new(SIMULATOR).bad(&[&["rtcp"], &arguments[..]].concat(), &[needed]);
    }
}
