//! Rehearsals as called: the true errors of a machine folder go through `… simulate` and come back from the evaluation within
//! its own standard errors.

use serde_json::Value;
use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

const HEAD: &str = "name = \"mill\"\nchain = \"w X' Y' b Z t\"\n";
const NOMINAL: &str =
    "[axis.X]\ntravel_mm = [0.0, 500.0]\n[axis.Y]\ntravel_mm = [0.0, 400.0]\n[axis.Z]\ntravel_mm = [-300.0, 0.0]\n";
/// Scales 40, −30 and 20 ppm; backlash 6 and 3 µm; C0Y 50, B0Z −20, A0Z 30 µrad.
const TRUE: &str = "[axis.X]\ntravel_mm = [0.0, 500.0]\ntable = \"x.csv\"\nbacklash_um = 6.0\n\
                    [axis.Y]\ntravel_mm = [0.0, 400.0]\ntable = \"y.csv\"\nbacklash_um = 3.0\n\
                    [axis.Z]\ntravel_mm = [-300.0, 0.0]\ntable = \"z.csv\"\n\
                    [location]\nC0Y_urad = 50.0\nB0Z_urad = -20.0\nA0Z_urad = 30.0\n";
const TERMS: [(&str, f64); 8] = [
    ("/location/C0Y_urad", 50.0),
    ("/location/B0Z_urad", -20.0),
    ("/location/A0Z_urad", 30.0),
    ("/axes/X/scale_ppm", 40.0),
    ("/axes/Y/scale_ppm", -30.0),
    ("/axes/Z/scale_ppm", 20.0),
    ("/axes/X/backlash_um", 6.0),
    ("/axes/Y/backlash_um", 3.0),
];

const BALL: &str = "[[artefact]]\nname = \"ball\"\nkind = \"ball\"\ndiameter_mm = 25.0\nuncertainty_um = 0.2\n\
                    [[artefact.place]]\nat_mm = [40.0, 40.0, -250.0]\n";
const RING: &str = "[[artefact]]\nname = \"ring\"\nkind = \"ring\"\ndiameter_mm = 150.0\nuncertainty_um = 0.2\n\
                    points = 16\n[[artefact.place]]\nat_mm = [250.0, 200.0, -150.0]\n\
                    [[artefact.place]]\nat_mm = [250.0, 200.0, -150.0]\nnormal = \"Y\"\n\
                    [[artefact.place]]\nat_mm = [250.0, 200.0, -150.0]\nnormal = \"X\"\n";

fn task(dialect: &str) -> String {
    format!(
        "machine = \"mill\"\ndialect = \"{dialect}\"\n[probe]\ntip_radius_mm = 3.0\n[reference]\nartefact = \"ball\"\n\
         every = 40\n{BALL}{RING}"
    )
}

/// A folder with a task, its machine and the true one.
fn folder() -> Folder {
    let folder = Folder::new(TRUEAXIS);
    folder.write("task.toml", task("linuxcnc"));
    folder.write("mill/machine.toml", format!("{HEAD}{NOMINAL}"));
    folder.write("true/machine.toml", format!("{HEAD}{TRUE}"));
    folder.write("true/x.csv", "X_mm,EXX_um\n0,0\n500,20\n");
    folder.write("true/y.csv", "Y_mm,EYY_um\n0,0\n400,-12\n");
    folder.write("true/z.csv", "Z_mm,EZZ_um\n-300,-6\n0,0\n");
    folder
}

/// Deviations from the truth, in standard errors.
fn scores(found: &Value, terms: &[(&str, f64)]) -> Vec<f64> {
    let number = |path: &str| found.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}: {found}"));
    terms
        .iter()
        .map(|(path, truth)| (number(path) - truth) / number(&format!("/standard_errors{}", path.trim_start_matches("/axes"))))
        .collect()
}

fn rms(scores: &[f64]) -> f64 {
    (scores.iter().map(|score| score * score).sum::<f64>() / scores.len() as f64).sqrt()
}

/// Ten set-ups: 80 deviations, whose root mean square is 1 ± 0.08 if the standard errors are right.
#[test]
fn a_calibration_gives_the_true_errors_back_within_its_standard_errors() {
    let folder = folder();
    let simulate = ["calibrate", "simulate", "task.toml", "--machine", "true", "--drift-um-per-h", "6", "-o", "log"];
    let mut all = Vec::new();
    for seed in 1..=10 {
        folder.both(&[&simulate[..], &["--seed", &seed.to_string()]].concat());
        let found = folder.json(&["calibrate", "solve", "task.toml", "log", "--dry-run", "--json"]);
        // The task states 1 µm, which the simulation takes.
        let sigma = found["sigma_um"].as_f64().unwrap();
        assert!((0.8..1.2).contains(&sigma), "{sigma}");
        let scores = scores(&found, &TERMS);
        assert!(scores.iter().all(|score| score.abs() < 4.5), "seed {seed}: {scores:?}");
        all.extend(scores);
    }
    assert!((0.7..1.35).contains(&rms(&all)), "{} of {}", rms(&all), all.len());
}

#[test]
fn every_control_logs_the_same_touches_and_the_seed_decides_them() {
    let folder = folder();
    let log = |dialect: &str, seed: &str| {
        folder.write("task.toml", task(dialect));
        folder.good(&["calibrate", "simulate", "task.toml", "--machine", "true", "--seed", seed])
    };
    let solved = |dialect: &str| {
        folder.write("log", log(dialect, "3"));
        let found = folder.json(&["calibrate", "solve", "task.toml", "log", "--dry-run", "--json"]);
        TERMS.map(|(path, _)| found.pointer(path).and_then(Value::as_f64).unwrap())
    };
    let [first, klipper, grblhal] = ["linuxcnc", "klipper", "grblhal"].map(solved);
    assert_eq!(first, klipper);
    // grblHAL prints four digits.
    for (one, other) in first.iter().zip(grblhal) {
        assert!((one - other).abs() < 0.5, "{first:?} {grblhal:?}");
    }
    assert_eq!(log("linuxcnc", "3"), log("linuxcnc", "3"));
    assert_ne!(log("linuxcnc", "3"), log("linuxcnc", "4"));
}

/// The machine found states its uncertainties: from these the next rehearsal draws, and solves to the machine drawn.
#[test]
fn without_a_true_machine_errors_are_drawn_within_the_stated_uncertainties() {
    let folder = folder();
    let drawn = ["calibrate", "simulate", "task.toml", "-o", "log", "--save-true", "drawn"];
    folder.bad(&drawn, &["mill", "found no uncertainty", "needed [uncertainty.location]", "--machine TRUE"]);
    let stated = "[uncertainty.location]\nC0Y_urad = 30.0\n[axis.X.uncertainty]\nscale_ppm = 25.0\n";
    folder.write("mill/machine.toml", format!("{HEAD}{NOMINAL}{stated}"));
    let mut size = Vec::new();
    for seed in 1..=8 {
        let folder_of = format!("drawn{seed}");
        folder.both(&[&drawn[..6], &[&folder_of, "--seed", &seed.to_string()]].concat());
        let truth = folder.read(format!("{folder_of}/machine.toml"));
        let c0y: f64 = truth.lines().find_map(|line| line.strip_prefix("C0Y_urad = ")).unwrap().parse().unwrap();
        let table = folder.read(format!("{folder_of}/x.csv"));
        let last = table.lines().last().unwrap().split(',').nth(1).unwrap().parse::<f64>().unwrap();
        let found = folder.json(&["calibrate", "solve", "task.toml", "log", "--dry-run", "--json"]);
        let terms = [("/location/C0Y_urad", c0y), ("/axes/X/scale_ppm", last / 0.5), ("/axes/Y/scale_ppm", 0.0)];
        let scores = scores(&found, &terms);
        assert!(scores.iter().all(|score| score.abs() < 4.5), "seed {seed}: {scores:?}");
        size.extend([c0y / 30.0, last / 0.5 / 25.0]);
    }
    assert!((0.4..1.8).contains(&rms(&size)), "{size:?}");
}

/// With the true tables in force and `compensated = true`, nothing is left.
#[test]
fn tables_in_force_correct_the_machine_while_it_is_probed() {
    let folder = folder();
    folder.write("task.toml", task("linuxcnc").replace("\"mill\"", "\"true\"\ncompensated = true"));
    folder.both(&["calibrate", "simulate", "task.toml", "--machine", "true", "-o", "log"]);
    let found = folder.json(&["calibrate", "solve", "task.toml", "log", "--dry-run", "--json"]);
    let none = TERMS.map(|(path, _)| (path, 0.0));
    let scores = scores(&found, &none);
    assert!(scores.iter().all(|score| score.abs() < 4.5), "{scores:?}");
}

#[test]
fn bad_calls_of_a_rehearsal_say_what_is_needed() {
    let folder = folder();
    let refused = |more: &[&str], parts: &[&str]| {
        folder.bad(&[&["calibrate", "simulate", "task.toml", "-o", "log"], more].concat(), parts);
    };
    refused(&["--machine", "nowhere"], &["nowhere"]);
    refused(&["--machine", "true", "--noise-um", "-1"], &["--noise-um", "found -1", "needed 0 to 1000 um"]);
    refused(&["--machine", "true", "--drift-um-per-h", "1,2"], &["2 numbers", "one or three: X,Y,Z"]);
    refused(&["--machine", "true", "--drift-um-per-h=-3"], &["--drift-um-per-h", "found -3", "needed 0 to 1000"]);
    refused(&["--machine", "true", "--save-true", "mill"], &["found a machine in mill", "needed a folder without one"]);
    folder.write("other/machine.toml", "name = \"mill\"\nchain = \"w b X Y Z t\"\n[axis.X]\ntravel_mm = [0, 500]\n");
    refused(&["--machine", "other"], &["--machine other", "\"w b X Y Z t\"", "needed \"w X' Y' b Z t\""]);
    folder.write("task.toml", task("linuxcnc").replace("points = 16", "pionts = 16"));
    refused(&["--machine", "true"], &["task.toml:20", "pionts"]);
    folder.write("task.toml", task("linuxcnc"));
    folder.bad(
        &["calibrate", "simulate", "task.toml", "--machine", "true", "-o", "true/x.csv"],
        &["true/x.csv", "input"],
    );
    // A machine so wrong that the program misses its artefacts.
    folder.write("true/x.csv", "X_mm,EXX_um\n0,0\n500,9000\n");
    refused(&["--machine", "true"], &["task.toml", "line", "needed"]);
}

/// Balls that a shift has moved relative to the tables in force.
#[test]
fn a_re_probing_finds_how_the_machine_has_moved() {
    let folder = folder();
    let terms = "[[term]]\nnames = [\"offset X\", \"offset Y\", \"offset Z\"]\nlargest_update_um = 15.0\n\
                 largest_total_um = 30.0\n";
    let probe = "[probe]\ntip_radius_mm = 3.0\ntip_uncertainty_um = 5.0\nrepeatability_um = 0.5\n";
    let head = "machine = \"mill\"\ndialect = \"linuxcnc\"\nevery_parts = 10\n";
    folder.write("keep.toml", format!("{head}{probe}{BALL}{terms}"));
    folder.write("moved/machine.toml", format!("{HEAD}{NOMINAL}").replace("500.0]\n", "500.0]\ntable = \"x.csv\"\n"));
    folder.write("moved/x.csv", "X_mm,EXX_um\n0,7\n500,7\n");
    folder.both(&["keep", "simulate", "keep.toml", "--machine", "mill", "-o", "begin.log"]);
    folder.both(&["keep", "begin", "keep.toml", "begin.log"]);
    for seed in ["2", "3", "4"] {
        folder.both(&["keep", "simulate", "keep.toml", "--machine", "moved", "--seed", seed, "-o", "look.log"]);
        let found = folder.json(&["keep", "check", "keep.toml", "look.log", "--json"]);
        for (term, truth) in [("offset X", 7.0), ("offset Y", 0.0), ("offset Z", 0.0)] {
            let own = found["terms"].as_array().unwrap().iter().find(|own| own["name"] == term);
            let own = own.unwrap_or_else(|| panic!("{found}"));
            let [value, error] = ["value", "standard_error"].map(|key| own[key].as_f64().unwrap_or_default());
            assert!((value - truth).abs() < 4.0 * error.max(0.15), "{term}: {own}");
        }
    }
    // Another set-up moves the balls: 0.6 mm are far out of bounds.
    folder.both(&["keep", "simulate", "keep.toml", "--machine", "mill", "--set-up", "9", "-o", "look.log"]);
    let output = folder.run(&["keep", "check", "keep.toml", "look.log"]);
    assert_eq!(output.status.code(), Some(3), "{}", String::from_utf8_lossy(&output.stderr));
}

/// C0Y, scales and backlash of the circle's plane; records of ten seeds.
#[test]
fn circles_of_a_bar_show_the_true_errors() {
    let folder = folder();
    let terms: [(&str, f64); 4] =
        [("/squareness_urad", 50.0), ("/scale_mismatch_ppm", 70.0), ("/backlash_um/x", 6.0), ("/backlash_um/y", 3.0)];
    let mut all = Vec::new();
    for seed in 1..=10 {
        let call = ["ballbar", "simulate", "--machine", "true", "--radius-mm", "100", "-o", "bar.csv"];
        folder.both(&[&call[..], &["--seed", &seed.to_string()]].concat());
        let found = folder.json(&["ballbar", "bar.csv", "--radius-mm", "100", "--json"]);
        let scores = scores(&found, &terms);
        // The circle is that of a machine with nine errors, not the sum of small terms: 0.02 µm remain.
        assert!(scores.iter().all(|score| score.abs() < 6.0), "seed {seed}: {scores:?} {found}");
        all.extend(scores);
    }
    assert!((0.6..1.7).contains(&rms(&all)), "{all:?}");
    // Corrected by the true tables, nothing is left.
    let call = ["--machine", "true", "--corrected-by", "true", "--radius-mm", "100", "-o", "bar.csv"];
    folder.both(&[&["ballbar", "simulate"][..], &call].concat());
    let found = folder.json(&["ballbar", "bar.csv", "--radius-mm", "100", "--json"]);
    let left = scores(&found, &terms.map(|(path, _)| (path, 0.0)));
    assert!(left.iter().all(|score| score.abs() < 6.0), "{left:?}");
}

#[test]
fn a_bar_whose_circle_does_not_fit_is_refused() {
    let folder = folder();
    let refused = |more: &[&str], parts: &[&str]| {
        folder.bad(&[&["ballbar", "simulate", "-o", "bar.csv"], more].concat(), parts);
    };
    refused(&["--radius-mm", "100"], &["--machine"]);
    refused(&["--machine", "true"], &["--radius-mm"]);
    refused(&["--machine", "true", "--radius-mm", "0"], &["--radius-mm", "found 0", "needed 1 to 10000 mm"]);
    refused(&["--machine", "true", "--radius-mm", "250"], &["found Y from -50 to 450 mm", "travel, 0 to 400 mm"]);
    folder.write("bare/machine.toml", format!("{HEAD}[axis.X]\n"));
    refused(&["--machine", "bare", "--radius-mm", "50"], &["axis.X.travel_mm", "--centre-mm X,Y,Z"]);
    // The record's own form of call is as it was: an argument, and its errors.
    folder.bad(&["ballbar"], &["RECORD", "--radius-mm"]);
    folder.bad(&["ballbar", "missing.csv", "--radius-mm", "50"], &["missing.csv"]);
}
