//! Artefacts that a shop owns: blocks touched, and dial indicators read, on machines of stated errors by exact transforms.

use std::path::Path;
use trueaxis_evaluation::calibrate::{CalibrationDocument, Kind, Plan, Task, directions, planned, solved};
use trueaxis_evaluation::simulated::rehearsal::{Conditions, Drift, FilledSheet, calibrate, dial};
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;
use trueaxis_tables::files::Memory;

const DIALS: &str = include_str!("../../records/probing/dial.toml");
const BLOCKS: &str = include_str!("../../records/probing/blocks.toml");
const THREE_LENGTHS: &str = include_str!("../../records/probing/1-2-3-block.toml");

const NOMINAL: &str = "name = \"mill\"\nchain = \"w X' Y' b Z t\"\n[axis.X]\ntravel_mm = [0.0, 500.0]\n[axis.Y]\n\
                       travel_mm = [0.0, 400.0]\n[axis.Z]\ntravel_mm = [-300.0, 0.0]\n";
const SQUARENESS: &str = "[location]\nC0Y_urad = 50.0\nB0Z_urad = -20.0\nA0Z_urad = 30.0\n";

fn read(text: &str, tables: &[(&str, String)]) -> Machine {
    let tables = tables.iter().map(|(name, rows)| (*name, rows.clone()));
    let files = std::iter::once(("machine.toml", text.to_owned())).chain(tables);
    let files = Memory::new(files);
    Machine::read_from(&files, Path::new("machine.toml"), &mut |_| {}).unwrap()
}

fn nominal() -> Machine {
    read(NOMINAL, &[])
}

/// EYX is 2e-4 (x − 250)² µm.
fn curved() -> Machine {
    let row = |x: f64| format!("{x},{}\n", 2e-4 * (x - 250.0).powi(2));
    let rows: String = (0..=20).map(|i| row(25.0 * f64::from(i))).collect();
    let text = NOMINAL.replace("500.0]\n", "500.0]\ntable = \"x.csv\"\n");
    read(&format!("{text}{SQUARENESS}"), &[("x.csv", format!("X_mm,EYX_um\n{rows}"))])
}

/// Scales and lost motions of X, Y and Z, and squarenesses.
const STRAIGHT: [(&str, f64); 9] = [
    ("scale of X", 40.0),
    ("scale of Y", -30.0),
    ("scale of Z", 20.0),
    ("backlash of X", 6.0),
    ("backlash of Y", 3.0),
    ("backlash of Z", 2.0),
    ("squareness C0Y", 50.0),
    ("squareness B0Z", -20.0),
    ("squareness A0Z", 30.0),
];

fn straight() -> Machine {
    let axis = |of: &str, backlash: f64| format!("table = \"{of}.csv\"\nbacklash_um = {backlash}\n");
    let text = NOMINAL
        .replace("500.0]\n", &format!("500.0]\n{}", axis("x", 6.0)))
        .replace("400.0]\n", &format!("400.0]\n{}", axis("y", 3.0)));
    let text = format!("{text}{}{SQUARENESS}", axis("z", 2.0));
    let tables = [
        ("x.csv", "X_mm,EXX_um\n0,0\n500,20\n"),
        ("y.csv", "Y_mm,EYY_um\n0,0\n400,-12\n"),
        ("z.csv", "Z_mm,EZZ_um\n-300,-6\n0,0\n"),
    ];
    read(&text, &tables.map(|(name, rows)| (name, rows.to_owned())))
}

fn task(text: &str) -> Task {
    Task::read(text, Path::new("task.toml")).unwrap()
}

fn conditions(noise_um: Option<f64>, seed: u64) -> Conditions {
    Conditions { noise_um, drift: Drift::Size(0.0), seed, set_up: seed }
}

fn solve(text: &str, log: &str) -> CalibrationDocument {
    let (task, machine) = (task(text), nominal());
    let (_, found) =
        solved(&task, &machine, log, Path::new("log"), |_| {}).unwrap_or_else(|refused| panic!("{refused}"));
    found.document(&task, &machine)
}

/// A term found: its name, value, standard error and true value.
type Found = (String, [f64; 3]);

fn compared(document: &CalibrationDocument, truths: &[(&str, f64)]) -> Vec<Found> {
    let truth = |name: &str| truths.iter().find(|(of, _)| *of == name).map(|(_, truth)| *truth);
    let found = document.terms.iter().map(|term| {
        let truth = truth(&term.name).unwrap_or_else(|| panic!("no truth of {}", term.name));
        (term.name.clone(), [term.value, term.standard_error, truth])
    });
    found.collect()
}

fn touched(text: &str, seed: u64) -> CalibrationDocument {
    let log = calibrate(&task(text), &nominal(), &straight(), &conditions(None, seed));
    let found = solve(text, &log.unwrap_or_else(|refused| panic!("{refused:#}")));
    // The edge has 20 degrees of freedom: ± 16 %.
    let scatter = found.sigma_um / found.repeatability_um;
    assert!((0.6..1.4).contains(&scatter), "seed {seed}: touches scatter by {scatter} of what is stated");
    found
}

/// Deviations over their standard errors.
fn scores(found: impl IntoIterator<Item = Found>) -> Vec<f64> {
    found.into_iter().map(|(_, [value, error, truth])| (value - truth) / error).collect()
}

/// The root mean square of deviations over their standard errors is 1 if these are right.
fn check(scores: &[f64]) {
    let rms = (scores.iter().map(|score| score * score).sum::<f64>() / scores.len() as f64).sqrt();
    let worst = scores.iter().fold(0.0_f64, |worst, score| worst.max(score.abs()));
    println!("{rms:.2} of {}, at most {worst:.1}", scores.len());
    assert!((0.75..1.3).contains(&rms) && worst < 4.0, "{rms} of {}, at most {worst}", scores.len());
}

#[test]
fn a_gauge_block_and_two_parallels_give_scales_within_their_standard_errors() {
    let all = (1..=20).flat_map(|seed| {
        let found = touched(BLOCKS, seed);
        assert_eq!(found.terms.len(), 6, "{:?}", found.terms);
        scores(compared(&found, &STRAIGHT))
    });
    check(&all.collect::<Vec<_>>());
}

#[test]
fn a_block_of_three_lengths_turned_over_gives_squareness_within_its_standard_errors() {
    let all = (1..=20).flat_map(|seed| {
        let found = touched(THREE_LENGTHS, seed);
        assert_eq!(found.terms.len(), 9, "{:?}", found.terms);
        scores(compared(&found, &STRAIGHT))
    });
    check(&all.collect::<Vec<_>>());
}

/// Least distance of the tip from the surface that a block stands on, mm, if it is off its place by half of the approach.
const ROOM_MM: f64 = 1.0;

/// At every position before, at the start of, at and at the end of a probing move.
#[test]
fn the_tip_stays_clear_of_the_base_and_comes_to_it_from_outside() {
    for text in [BLOCKS, THREE_LENGTHS] {
        let (task, machine) = (task(text), nominal());
        let plan = Plan::new(&task, &machine).unwrap();
        let (radius, approach) = (task.probe.tip_radius_mm, task.probe.approach_mm);
        let [mut sides, mut bases] = [0; 2];
        for (touch, at) in plan.touches.iter().zip(planned(&task, &plan)) {
            let Kind::Block(block) = &task.artefacts[touch.artefact].kind else { continue };
            let place = &task.artefacts[touch.artefact].places[touch.place];
            let (up, [axes, _]) = (place.normal.index() % 3, directions(place));
            let size = |axis: usize| block.size_mm[axes.iter().position(|of| *of as usize == axis).unwrap()];
            let above = |q: f64| q - radius - (place.at_mm[up] - radius - size(up));
            if touch.start[up] == touch.end[up] {
                sides += 1;
                for q in [touch.take_up[up], touch.start[up], at[up], touch.end[up]] {
                    assert!(above(q) > ROOM_MM + 0.5 * approach - 1e-3, "{} above the base: {touch:?}", above(q));
                }
                continue;
            }
            assert!(above(touch.take_up[up].min(touch.start[up])) > approach - 1e-3, "{touch:?}");
            if above(at[up]) < 0.5 * size(up) {
                bases += 1;
                for axis in (0..3).filter(|axis| *axis != up) {
                    let beside = |q: f64| (q - place.at_mm[axis]).abs() - 0.5 * size(axis) - radius;
                    assert!(beside(touch.start[axis]) > ROOM_MM + 0.5 * approach, "{touch:?}");
                    assert!(beside(touch.take_up[axis]) > beside(touch.start[axis]), "{touch:?}");
                }
            }
        }
        assert!(sides > 0 && bases > 0, "{sides} touches on sides, {bases} on bases");
    }
}

/// A thin parallel touched from both sides along X and Y, by a tip that is known: its width shows the lost motion. The scales
/// alone widen its 5 mm by 0.2 µm.
#[test]
fn an_edge_from_both_sides_gives_lost_motion() {
    let place = "[[artefact.place]]\nat_mm = [250.0, 200.0, -150.0]\n";
    let text = format!(
        "machine = \"mill\"\ndialect = \"linuxcnc\"\n[probe]\ntip_radius_mm = 2.0\ntip_uncertainty_um = 0.5\n\
         [solve]\nscale = false\n[[artefact]]\nname = \"edge\"\nkind = \"gauge block\"\nlength_mm = 5.0\n\
         section_mm = [100.0, 20.0]\nuncertainty_um = 0.3\n{place}{place}along = \"Y\"\n"
    );
    let all = (1..=20).flat_map(|seed| {
        let found = touched(&text, seed);
        assert_eq!(found.terms.len(), 2, "{:?}", found.terms);
        scores(compared(&found, &STRAIGHT))
    });
    check(&all.collect::<Vec<_>>());
}

fn filled(text: &str, noise_um: Option<f64>, seed: u64) -> FilledSheet {
    dial(&task(text), &nominal(), &curved(), &conditions(noise_um, seed)).unwrap()
}

/// True tilts of the spindle about X and Y relative to X and Y, µrad: of its carriage, and its own in the carriage.
fn spindle(of: &FilledSheet) -> [f64; 2] {
    let at = [250.0, 200.0, -250.0, 0.0, 0.0, 0.0];
    let [dx, dy, _] = Geometry::new(&curved(), 0.0).unwrap().actual_pose(&at, &[0.0; 6]).direction;
    [1e6 * (of.spindle[0] - dy), 1e6 * (of.spindle[1] + dx)]
}

fn readings(text: &str, noise_um: Option<f64>, seed: u64) -> Vec<Found> {
    let sheet = filled(text, noise_um, seed);
    let [about_x, about_y] = spindle(&sheet);
    let truths = [
        ("squareness C0Y", 50.0),
        ("squareness B0Z", -20.0),
        ("squareness A0Z", 30.0),
        // 2e-4 (x − 250)² µm over 50 to 450 mm: 8 t² = 16/3 P₂ + 8/3.
        ("EYX of degree 2", 16.0 / 3.0),
        ("EYX of degree 3", 0.0),
        ("tilt of the spindle about X", about_x),
        ("tilt of the spindle about Y", about_y),
    ];
    compared(&solve(text, &sheet.text), &truths)
}

/// Zero of every dial, alignment of every face, form, angle and run-out are drawn: in exact readings they cancel. The sheet
/// rounds to 0.01 µm.
#[test]
fn exact_readings_give_exact_terms() {
    // Taper is the only artefact error that no reversal removes.
    let exact = DIALS.replace("uncertainty_urad = 5.0", "uncertainty_urad = 0.001");
    for seed in 1..=5 {
        let found = readings(&exact, Some(0.0), seed);
        assert_eq!(found.len(), 7, "{found:?}");
        for (name, [value, _, truth]) in found {
            assert!((value - truth).abs() < 0.1, "seed {seed}: {name} {value} for {truth}");
        }
    }
}

#[test]
fn readings_give_terms_within_their_standard_errors() {
    check(&(1..=20).flat_map(|seed| scores(readings(DIALS, None, seed))).collect::<Vec<_>>());
}
