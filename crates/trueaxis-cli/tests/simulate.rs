//! Rehearsals as called: the true errors of a machine folder go through `… simulate` and come back from the evaluation within
//! its own standard errors.

use serde_json::Value;
use std::path::Path;
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
        .map(|(path, truth)| {
            (number(path) - truth) / number(&format!("/standard_errors{}", path.trim_start_matches("/axes")))
        })
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
    // A machine so wrong that the program misses its artefacts, or runs into them.
    let short = "tip_radius_mm = 3.0\napproach_mm = 0.4\novertravel_mm = 0.4\n";
    folder.write("task.toml", task("linuxcnc").replace("tip_radius_mm = 3.0\n", short));
    folder.write("true/x.csv", "X_mm,EXX_um\n0,1000\n500,1000\n");
    refused(&["--machine", "true"], &["task.toml: the program of this task", "line ", "found ", "needed "]);
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

/// Figures of drives and friction, with which the plant is integrated.
#[test]
fn circles_show_the_friction_and_the_drives_that_a_machine_states() {
    let folder = Folder::new(TRUEAXIS);
    let axis = |letter: char, travel: &str, gain: f64, coulomb: f64| {
        format!(
            "[axis.{letter}]\ntravel_mm = {travel}\n[axis.{letter}.drive]\nposition_gain_per_s = {gain}\n\
             velocity_gain_per_s = 800\nreset_time_s = 0.006\nvelocity_feed_forward = 0.9\n\
             [axis.{letter}.friction]\ncoulomb_mm_per_s = {coulomb}\npresliding_um = 6\n"
        )
    };
    let [x, y] = [axis('X', "[-100, 100]", 100.0, 0.5), axis('Y', "[-100, 100]", 120.0, 0.7)];
    folder.write("m/machine.toml", format!("{HEAD}{x}{y}[axis.Z]\ntravel_mm = [-100, 100]\n"));
    let size = ["--radius-mm", "10.0037", "--feeds", "1000,400", "--rate-hz", "2000"];
    let call = ["friction", "simulate", "--machine", "m", "--axes", "X,Y", "-o", "record.csv"];
    folder.both(&[&call[..], &size].concat());
    // The drives as stated; the friction stated beside them does not enter the fit.
    let found = folder.json(&["friction", "record.csv", "--axes", "X,Y", "--machine", "m", "--json"]);
    for (own, coulomb) in [0.5, 0.7].into_iter().enumerate() {
        let number = |path: &str| found["axes"][own].pointer(path).and_then(Value::as_f64).unwrap();
        for (path, truth, share) in [("coulomb_mm_per_s", coulomb, 0.1), ("presliding_um", 6.0, 0.15)] {
            let value = number(&format!("/friction/{path}"));
            assert!((value / truth - 1.0).abs() < share, "axis {own}, {path}: {value} for {truth}");
        }
        assert!(number("/explained") > 0.98, "{found}");
    }
    folder.write("bare/machine.toml", format!("{HEAD}{NOMINAL}"));
    let refused = |more: &[&str], parts: &[&str]| {
        folder.bad(&[&["friction", "simulate", "-o", "out.csv", "--axes", "X,Y"], more].concat(), parts);
    };
    refused(&["--machine", "bare"], &["bare", "no [axis.X.drive]"]);
    refused(&["--machine", "m", "--radius-mm", "0.5"], &["--radius-mm", "found 0.5", "needed 1 to 1000"]);
    refused(&["--machine", "m", "--feeds", "600"], &["--feeds", "1 feeds", "two"]);
    refused(&["--machine", "m", "--rate-hz", "50"], &["--rate-hz", "found 50", "needed 500 to 100000"]);
    folder.bad(&["friction", "missing.csv", "--axes", "X,Y"], &["missing.csv"]);
}

/// The fit, which knows nothing of the bodies, leaves a small part of the drift of a shift that it has not seen.
#[test]
fn a_warm_up_of_simulated_bodies_is_fitted() {
    let folder = Folder::new(TRUEAXIS);
    folder.both(&["thermal", "simulate", "--shifts", "3", "-o", "record.csv"]);
    let found = folder.json(&["thermal", "fit", "record.csv", "--json"]);
    let [drift, left] = [0, 1].map(|k| found["held_out_um"][k].as_f64().unwrap());
    assert!(drift > 10.0 && left < 0.3 * drift, "{left} of {drift} µm");
    folder.bad(&["thermal", "simulate", "--at", "1,2,3", "-o", "out.csv"], &["--at", "[1.0, 2.0, 3.0]", "length"]);
    folder.bad(&["thermal", "simulate", "--noise-um", "-1", "-o", "out.csv"], &["--noise-um", "found -1"]);
}

fn value(found: &Value, path: &str) -> [f64; 2] {
    ["value", "standard_error"].map(|key| {
        found.pointer(&format!("{path}/{key}")).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}: {found}"))
    })
}

/// Squarenesses of the true machine, from points throughout the travels and from body diagonals.
#[test]
fn points_and_diagonals_show_the_true_squarenesses() {
    let folder = folder();
    let on = ["--machine", "true", "--seed", "5", "-o", "record.csv"];
    let near = |found: &Value, path: &str, truth: f64| {
        let [value, error] = value(found, path);
        assert!((value - truth).abs() < 4.5 * error.max(0.05), "{path}: {value} ± {error} for {truth}");
    };
    folder.both(&[&["evaluate", "points", "simulate", "--points", "4,4,4"][..], &on].concat());
    let points = folder.json(&["evaluate", "points", "record.csv", "--machine", "mill", "--json"]);
    folder.bad(&["evaluate", "points", "record.csv"], &["--machine", "X, Y and Z"]);
    folder.both(&[&["evaluate", "step-diagonal", "simulate", "--runs", "2"][..], &on].concat());
    let diagonals = folder.json(&["evaluate", "step-diagonal", "record.csv", "--json"]);
    for (which, truth) in [("a0z_urad", 30.0), ("b0z_urad", -20.0), ("c0y_urad", 50.0)] {
        near(&points, &format!("/squareness/{which}"), truth);
        near(&diagonals, &format!("/{which}"), truth);
    }
    let refused = |what: &str, more: &[&str], parts: &[&str]| {
        let call = ["evaluate", what, "simulate", "--machine", "true", "-o", "out.csv"];
        folder.bad(&[&call[..], more].concat(), parts);
    };
    refused("points", &["--points", "1,4,4"], &["--points", "found 1", "needed 2 to 41"]);
    refused("points", &["--points", "4"], &["\"4\"", "three whole numbers"]);
    refused("step-diagonal", &["--margin-mm", "149"], &["--margin-mm", "found 149", "10 mm of Z"]);
    refused("step-diagonal", &["--targets", "1"], &["--targets", "found 1", "needed 2 to 100"]);
    refused("r-test", &["--ball-mm", "1,2,3", "--angles-deg", "0,0,9"], &["w X' Y' b Z t", "needed rotary axes"]);
}

/// A trunnion whose centre lines are off by micrometres and tens of microradians.
#[test]
fn an_r_test_shows_the_true_centre_lines() {
    let folder = Folder::new(TRUEAXIS);
    let machine =
        "name = \"trunnion\"\nchain = \"w C' A' Y' b X Z t\"\n[axis.X]\n[axis.Y]\n[axis.Z]\n[axis.A]\n[axis.C]\n";
    let terms = [("EX0C", 12.0), ("EY0C", -7.0), ("EA0C", 40.0), ("EB0C", -25.0), ("EY0A", 9.0), ("EZ0A", -4.0)];
    let errors = terms.map(|(name, value)| {
        format!("{name}_{} = {value}\n", if name.starts_with("EA") || name.starts_with("EB") { "urad" } else { "um" })
    });
    folder.write("nominal/machine.toml", machine);
    folder.write("true/machine.toml", format!("{machine}[location]\n{}", errors.concat()));
    let poses: Vec<String> = (0..24)
        .map(|k| format!("{},0,{}", [0, -40, 30][k % 3], 15 * k))
        .flat_map(|pose| ["--angles-deg".into(), pose])
        .collect();
    let call = ["evaluate", "r-test", "simulate", "--machine", "true", "--ball-mm", "60,20,-80", "-o", "r.csv"];
    let call: Vec<&str> = call.into_iter().chain(poses.iter().map(String::as_str)).collect();
    folder.both(&call);
    let found = folder.json(&["evaluate", "r-test", "r.csv", "--machine", "nominal", "--json"]);
    for (name, truth) in terms {
        let own = found["terms"].as_array().unwrap().iter().find(|own| own["name"] == name).unwrap();
        let [value, error] = value(own, "");
        assert!((value - truth).abs() < 4.5 * error.max(0.02), "{name}: {value} ± {error} for {truth}");
    }
}

/// Three lobes of 1.5 µm are a form error of 3 µm; without them a perfect machine has none.
#[test]
fn a_ring_and_a_sphere_show_the_lobes_of_the_probe() {
    let folder = folder();
    for (feature, lobes) in [("ring", "0"), ("ring", "1.5"), ("sphere", "0")] {
        let call = ["--machine", "mill", "--noise-um", "0", "--lobes-um", lobes, "--feature", feature, "-o", "f.csv"];
        folder.both(&[&["evaluate", "probing", "simulate"][..], &call].concat());
        let call = ["evaluate", "probing", "f.csv", "--feature", feature, "--diameter-mm", "50", "--json"];
        let found = folder.json(&call);
        let [form, tip] = ["p_ftu_um", "effective_tip_diameter_mm"].map(|key| found[key].as_f64().unwrap());
        let truth = 2.0 * lobes.parse::<f64>().unwrap();
        assert!((form - truth).abs() < 0.05 && (tip - 6.0).abs() < 1e-4, "{feature} {lobes}: {form} {tip}");
    }
    let call = ["evaluate", "probing", "simulate", "--machine", "true", "--feature", "ring", "-o", "out.csv"];
    folder.bad(&[&call[..], &["--tip-mm", "40"]].concat(), &["--tip-mm", "found 40", "needed 0.1 to 25 mm"]);
    folder.bad(&[&call[..], &["--at-mm", "10,200,-150"]].concat(), &["at X 10", "0 to 500 mm"]);
}

#[test]
fn a_spindle_drifts_more_than_the_hall() {
    let folder = Folder::new(TRUEAXIS);
    let range = |test: &str| -> f64 {
        folder.both(&["evaluate", "thermal", "simulate", "--test", test, "-o", "t.csv"]);
        let call = ["evaluate", "thermal", "t.csv", "--test", test, "--distance-mm", "100", "--json"];
        let channels = folder.json(&call)["positions"][0]["channels"].clone();
        let z =
            channels.as_array().unwrap().iter().find(|own| own["name"] == "Z").unwrap_or_else(|| panic!("{channels}"));
        z["range"].as_f64().unwrap()
    };
    let [etve, spindle, axis] = ["etve", "spindle", "axis"].map(range);
    assert!(etve > 0.5 && spindle > 2.0 * etve && axis > 0.5, "{etve} {spindle} {axis}");
    folder
        .bad(&["evaluate", "thermal", "simulate", "--hours", "9", "-o", "t2.csv"], &["--hours", "found 9", "0.5 to 8"]);
}

/// The commands in records/README.md, which the desk's samples come from.
#[test]
fn sample_records_are_what_the_commands_write() {
    let records = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../records");
    let folder = Folder::new(TRUEAXIS);
    folder.copy(&records, "records");
    let committed = folder.tree();
    let shown = folder.read("records/README.md");
    let commands = shown.lines().filter_map(|line| line.strip_prefix("    trueaxis "));
    let mut written = 0;
    for command in commands {
        let words: Vec<&str> = command.split_whitespace().collect();
        let [.., "-o", record] = words.as_slice() else { panic!("{command}") };
        std::fs::remove_file(folder.join(record)).unwrap();
        folder.good(&words);
        assert_eq!(folder.read(record), String::from_utf8_lossy(&committed[&folder.join(record)]), "{command}");
        written += 1;
    }
    assert_eq!((written, folder.tree().len()), (8, committed.len()));
}
