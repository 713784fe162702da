//! `firmware-sim soak`: long runs side by side.

use trueaxis_testing::command::Folder;

const SIMULATOR: &str = env!("CARGO_BIN_EXE_firmware-sim");
const SHORT: [&str; 9] = ["soak", "--program", "short-tour", "--rate-hz", "500", "--runs", "3", "--hours", "0.01"];

#[test]
fn side_by_side_is_the_same_with_a_fault_and_events_too() {
    let folder = Folder::new(SIMULATOR);
    let acts = ["--fault", "dropout:X@2s+3", "--event", "off:correction@3s", "--event", "on:correction@5s"];
    let soak = folder.json(&[&SHORT[..], &acts, &["--json"]].concat());
    assert_eq!((soak["runs"].as_u64(), soak["differences"].as_array().map(Vec::len)), (Some(3), Some(0)));
    let seconds = soak["simulated_s"].as_f64().unwrap();
    assert!((36.0..72.0).contains(&seconds), "36 s and at most a program more: {seconds}");
    assert_eq!(soak["cycles"].as_f64().unwrap(), (500.0 * seconds).round());
    let faults = &soak["fault_cycles"];
    assert!(["compensated", "full"].iter().all(|kind| faults[kind].as_u64().unwrap() >= 3), "{faults}");
    let plain = folder.json(&[&SHORT[..], &["--json"]].concat());
    assert_eq!(plain["fault_cycles"]["full"], 0);
    assert_ne!(plain["marks"][23]["digest"], soak["marks"][23]["digest"]);
    let text = folder.good(&SHORT);
    assert!(text.contains("3 runs side by side") && text.contains("all runs the same at 24 marks"), "{text}");
}

#[test]
fn unsuitable_soak_runs_are_refused() {
    let folder = Folder::new(SIMULATOR);
    folder.bad(&["soak", "--hours", "0"], &["--hours: found 0, needed a positive number"]);
    folder.bad(&["soak", "--hours", "nan"], &["--hours: found NaN, needed a positive number"]);
    folder.bad(&["soak", "--hours", "30"], &["--hours: found 30, needed at most 27.8 at 10000 Hz"]);
    folder.write("turned.ngc", "G21 G90 F600\nG43.4\nG1 X1 A1\n");
    let turned = ["soak", "--machine", "mill-5axis", "--program", "turned.ngc"];
    folder.bad(&turned, &["turned.ngc: found tool centre point control (G43.4) and turned axes in its last move"]);
}
