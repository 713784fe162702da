//! Events of a run: from the command line, from a scenario file beside its machines, and refused.

use firmware_sim::samples::sample_machine;
use serde_json::Value;
use std::path::Path;
use trueaxis_testing::command::Folder;

const SIMULATOR: &str = env!("CARGO_BIN_EXE_firmware-sim");
const TOUR: [&str; 6] = ["run", "--program", "short-tour", "--rate-hz", "500", "--json"];

/// A folder with a scenario and, beside it, the sample machine with another squareness.
fn folder() -> Folder {
    let folder = Folder::new(SIMULATOR);
    let sample = sample_machine("mill-3axis");
    let sample = if sample.is_dir() { sample } else { sample.parent().unwrap_or(Path::new(".")).to_path_buf() };
    for entry in std::fs::read_dir(sample).unwrap() {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap().replace("C0Y_urad = 38.0", "C0Y_urad = 80.0");
        folder.write(Path::new("scene/warm").join(path.file_name().unwrap()), text);
    }
    let events = r#"events = ["off:correction@1s", "on:correction@2s", "off:lag@3s", "exchange:warm@4s"]"#;
    folder.write("scene/scene.toml", events);
    folder
}

#[test]
fn a_scenarios_events_are_those_of_the_command_line() {
    let folder = folder();
    let run = |arguments: &[&str]| -> Value { folder.json(&[&TOUR[..], arguments].concat()) };
    let of_file = run(&["--scenario", "scene/scene.toml"]);
    let events = ["off:correction@1s", "on:correction@2s", "off:lag@3s", "exchange:scene/warm@4s"];
    let of_flags = run(&events.map(|event| ["--event", event]).concat());
    assert_eq!(of_file["settings"]["events"], Value::from(events.to_vec()));
    for key in ["settings", "digest", "contour_error_um", "limited_cycles", "cycles"] {
        assert_eq!(of_file[key], of_flags[key], "{key}");
    }
    let plain = run(&[]);
    for (kind, changed) in [("uncompensated", false), ("compensated", true), ("servo_only", false), ("full", true)] {
        assert_eq!(plain["digest"][kind] != of_file["digest"][kind], changed, "{kind}");
    }
    // Exchanging a machine's tables for identical ones changes only the start value of the inverse, which is good to 1e-3 µm.
    let same = run(&["--event", "exchange:mill-3axis@4s"]);
    let largest = |of: &Value| of["contour_error_um"]["full"]["max"].as_f64().unwrap();
    assert!((largest(&same) - largest(&plain)).abs() < 1e-3, "{} {}", largest(&same), largest(&plain));
}

#[test]
fn events_are_printed_and_refused() {
    let folder = folder();
    let text = folder.good(&["scenario", "--event", "off:friction@0.5s"]);
    assert!(text.contains("events = [\"off:friction@0.5s\"]"), "{text}");
    folder.bad(&["run", "--event", "off:brakes@1s"], &["--event: event \"off:brakes@1s\": found \"brakes\""]);
    folder.bad(&["run", "--event", "exchange:nowhere@1s"], &["exchange: found no file or sample \"nowhere\""]);
    folder.bad(&["run", "--event", "exchange:mill-5axis@1s"], &["exchange:mill-5axis: found axes XYZAC, needed XYZ"]);
    let refused = "--scenario: found the event \"off:correction@1s\", needed none for this command";
    folder.bad(&["record", "--scenario", "scene/scene.toml", "-o", "a.rec"], &[refused]);
    folder.bad(&["bench", "--scenario", "scene/scene.toml"], &[refused]);
}
