//! Simulated calibrations by step gauge, square, ball plate and blocks, compared with the random machine's true errors.

use std::path::Path;
use trueaxis_evaluation::calibrate::{CalibrationDocument, Task};
use trueaxis_evaluation::simulated::calibration::{BALL_PLATE, Conditions, GAUGE_AND_SQUARE, MILL, run, three_axes};
use trueaxis_sim::calibration::{Class, random_machine};
use trueaxis_tables::Machine;

/// Errors that consist only of squareness, scale and backlash.
const STRAIGHT: Class = Class { bow_mm: 0.0, cubic_mm: 0.0, wave_mm: 0.0, ..Class::MILL };

const BLOCKS: &str = include_str!("../../records/probing/blocks.toml");
const THREE_LENGTHS: &str = include_str!("../../records/probing/1-2-3-block.toml");

/// A sample task with terms of the first degree and artefacts exactly as certified.
fn straight(task: &str) -> String {
    let changes = [
        ("positioning_degree = 3", "positioning_degree = 1"),
        ("straightness_degree = 3", "straightness_degree = 1"),
        ("uncertainty_um = 0.5", "uncertainty_um = 0.001"),
        ("uncertainty_um = 0.3", "uncertainty_um = 0.001"),
        ("uncertainty_um = 0.2", "uncertainty_um = 0.001"),
        ("uncertainty_um = 0.12", "uncertainty_um = 0.001"),
        ("uncertainty_um = 1.5", "uncertainty_um = 0.001"),
        ("difference_um = 1.0", "difference_um = 0.001"),
        ("uncertainty_ppm = 1.0", "uncertainty_ppm = 0.001"),
        ("uncertainty_ppm = 3.0", "uncertainty_ppm = 0.001"),
    ];
    changes.into_iter().fold(task.to_owned(), |task, (from, to)| task.replace(from, to))
}

fn calibrated(task: &str, truth: &Machine, seed: u64, conditions: &Conditions) -> CalibrationDocument {
    let done = run(task, truth, seed, conditions).unwrap();
    done.found.document(&Task::read(task, Path::new("task.toml")).unwrap(), truth)
}

/// Every identified term with its true value, µm, µrad or ppm.
fn with_truth(truth: &Machine, found: &CalibrationDocument) -> Vec<(String, f64, f64)> {
    let location = &truth.settings.location;
    let squareness = [("C0Y_urad", location.c0y), ("B0Z_urad", location.b0z), ("A0Z_urad", location.a0z)];
    let known = |(key, value): (&str, f64)| Some((key.to_owned(), *found.location.get(key)?, 1e6 * value));
    let mut all: Vec<(String, f64, f64)> = squareness.into_iter().filter_map(known).collect();
    for (own, table) in truth.settings.axes.iter().zip(&truth.tables) {
        let rows = &table.as_ref().unwrap().rows;
        let (first, last) = (rows.first().unwrap(), rows.last().unwrap());
        let rise = last.forward[own.axis.index()] - first.forward[own.axis.index()];
        let letter = own.axis.letter();
        let known = |key: &str| found.axes.get(&letter.to_string()).and_then(|axis| axis.get(key));
        let scale = 1e6 * rise / (last.position - first.position);
        all.extend(known("scale_ppm").map(|value| (format!("scale of {letter}"), *value, scale)));
        let backlash = 1e3 * own.backlash;
        all.extend(known("backlash_um").map(|value| (format!("backlash of {letter}"), *value, backlash)));
    }
    all
}

/// With an exact probe, exact artefacts that are not askew, and errors that the terms can represent, the terms equal the
/// machine's; the residual of a touch is the log's rounding and the nanometre of uncertainty of a size.
#[test]
fn terms_come_back() {
    let well_set_up = Conditions { askew_urad: 0.0, ..Conditions::EXACT };
    // One length at a time is no term of squareness, which the ball would show.
    let square = Class { squareness: 0.0, ..STRAIGHT };
    let tasks = [
        ("ring", MILL, STRAIGHT, 0.02),
        ("gauge", GAUGE_AND_SQUARE, STRAIGHT, 0.01),
        ("plate", BALL_PLATE, STRAIGHT, 0.01),
        ("gauge block", BLOCKS, square, 0.05),
        ("block", THREE_LENGTHS, STRAIGHT, 0.05),
    ];
    for (name, task, class, most) in tasks {
        // LinuxCNC's log, used for even seeds, has six decimals.
        for seed in [2, 4, 6, 8, 10] {
            let truth = random_machine(seed, &class);
            let found = calibrated(&straight(task), &truth, seed, &well_set_up);
            assert!(found.sigma_um < 1e-3, "{name}, machine {seed}: {} µm are left", found.sigma_um);
            for (term, value, there) in with_truth(&truth, &found) {
                assert!((value - there).abs() < most, "{name}, machine {seed}: {term} {value} for {there}");
            }
        }
    }
}

/// A plate keeps its length in any orientation; a row of faces or a ring that is askew by θ is longer by ½ θ²: 0.13 ppm at 0.5
/// mrad. The angle of a square is in its own plane.
#[test]
fn misaligned_artefacts_give_the_same_result() {
    for (name, task, askew_urad, most) in [("gauge", GAUGE_AND_SQUARE, 500.0, 1.0), ("plate", BALL_PLATE, 3000.0, 0.05)]
    {
        let truth = random_machine(6, &STRAIGHT);
        let found = calibrated(&straight(task), &truth, 6, &Conditions { askew_urad, ..Conditions::EXACT });
        for (term, value, there) in with_truth(&truth, &found) {
            assert!((value - there).abs() < most, "{name}: {term} {value} for {there}");
        }
    }
}

/// Turning over a square of unknown angle eliminates its angular error.
#[test]
fn turned_over_a_square_gives_its_own_error_away() {
    let well_set_up = Conditions { askew_urad: 0.0, ..Conditions::EXACT };
    let task = straight(GAUGE_AND_SQUARE);
    // Random angular errors, µrad: obtuse, and acute.
    for (seed, drawn) in [(2, 32.645), (4, -37.309)] {
        let truth = random_machine(seed, &STRAIGHT);
        let location = truth.settings.location;
        let found = calibrated(&task, &truth, seed, &well_set_up);
        let out = 1e6 * (found.artefacts.last().unwrap().found - 90.0).to_radians();
        assert!((out - drawn).abs() < 0.01, "{out} for {drawn}");
        assert!((found.location["C0Y_urad"] - 1e6 * location.c0y).abs() < 0.005, "{found:?}");
    }
}

/// A gauge along X and a ball, with a probe that is exact compared with the gauge: the scale error equals the gauge's.
const GAUGE: &str = "machine = \"mill\"\ndialect = \"linuxcnc\"\n[probe]\ntip_radius_mm = 3.0\ntip_uncertainty_um = 20.0\n\
                     repeatability_um = 0.05\n[solve]\nbacklash = false\nsquareness = false\n\
                     [[artefact]]\nname = \"gauge\"\nkind = \"step gauge\"\nuncertainty_um = UM\nPPM\n\
                     steps_mm = [0.0, 40.0, 80.0, 120.0, 160.0, 200.0, 240.0, 280.0, 320.0, 360.0, 400.0]\n\
                     [[artefact.place]]\nat_mm = [40.0, 200.0, -150.0]\n";

/// Stated standard error of the scale, and root mean square of its true error over 100 machines, ppm.
fn scale_of_a_gauge(um: &str, ppm: &str) -> [f64; 2] {
    let task = GAUGE.replace("UM", um).replace("PPM", ppm);
    let conditions = Conditions { noise_um: 0.05, askew_urad: 0.0, ..Conditions::EXACT };
    let (mut squares, mut stated) = (0.0, 0.0);
    for seed in 0..100 {
        let truth = random_machine(2 * seed, &STRAIGHT);
        let found = calibrated(&task, &truth, 2 * seed, &conditions);
        let (_, value, there) = with_truth(&truth, &found).into_iter().find(|(term, ..)| term == "scale of X").unwrap();
        squares += (value - there).powi(2) / 100.0;
        stated = found.standard_errors["X"]["scale_ppm"];
    }
    [stated, squares.sqrt()]
}

#[test]
fn a_gauge_is_in_the_scale_as_its_certificate_says() {
    // Eleven faces with 1 µm each: 1 µm / (40 mm √(11 · 120 / 12)) by hand, 2.4 ppm.
    let [stated, out] = scale_of_a_gauge("1.0", "");
    assert!((stated - 2.38).abs() < 0.03, "{stated}");
    // With 100 machines the standard error of a root mean square is 7 %.
    assert!((out / stated - 1.0).abs() < 0.2, "{out} for {stated}");
    // 5 ppm of the whole length: more faces do not reduce it.
    let [stated, out] = scale_of_a_gauge("1.0", "uncertainty_ppm = 5.0");
    assert!((stated - 5.54).abs() < 0.05, "{stated}");
    assert!((out / stated - 1.0).abs() < 0.2, "{out} for {stated}");
}

/// Faces uncertain by 0.3 mm fit any touch; the limit on the deviation from the certificate still applies.
#[test]
fn another_gauge_is_refused() {
    let truth = random_machine(2, &STRAIGHT);
    let task = GAUGE.replace("UM", "300.0").replace("PPM", "");
    let refused = run(task.as_str(), &truth, 2, &Conditions::EXACT).unwrap_err().to_string();
    assert!(refused.contains("of gauge") && refused.contains("from the size that the task states"), "{refused}");
    assert!(refused.contains("at most 150 µm"), "{refused}");
    let dials = include_str!("../../records/probing/dial.toml");
    let refused = run(dials, &truth, 2, &Conditions::EXACT).unwrap_err().to_string();
    assert!(refused.contains("a task with dials, needed touches"), "{refused}");
}

#[test]
fn every_set_up_takes_most_of_the_error_away() {
    for (task, least) in [(GAUGE_AND_SQUARE, 0.6), (BALL_PLATE, 0.6)] {
        for seed in [1, 2] {
            let outcome = three_axes(seed, task, &Class::MILL, &Conditions::SHOP).unwrap();
            assert!(outcome.removed > least && outcome.after_um.max < outcome.before_um.max, "{outcome:?}");
        }
    }
}
