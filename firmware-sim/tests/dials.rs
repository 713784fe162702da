//! Sheets of a dial indicator, filled on a machine of stated errors by exact transforms, and solved.

use std::path::Path;
use trueaxis_evaluation::calibrate::{Calibration, CalibrationDocument, Planning, Task, solved};
use trueaxis_evaluation::simulated::rehearsal::{Conditions, Drift, FilledSheet, dial};
use trueaxis_tables::Machine;
use trueaxis_tables::exact::Geometry;
use trueaxis_tables::files::Memory;

const TASK: &str = include_str!("../../../records/probing/dial.toml");
const NOMINAL: &str = "name = \"mill\"\nchain = \"w X' Y' b Z t\"\n[axis.X]\ntravel_mm = [0.0, 500.0]\n[axis.Y]\n\
                       travel_mm = [0.0, 400.0]\n[axis.Z]\ntravel_mm = [-300.0, 0.0]\n";

fn read(text: &str) -> Machine {
    let row = |x: f64| format!("{x},{}\n", 2e-4 * (x - 250.0).powi(2));
    let rows: String = (0..=20).map(|i| row(25.0 * f64::from(i))).collect();
    let files = [("machine.toml", text.to_owned()), ("x.csv", format!("X_mm,EYX_um\n{rows}"))];
    let files = Memory::new(files.map(|(name, text)| (name.into(), text)));
    Machine::read_from(&files, Path::new("machine.toml"), &mut |_| {}).unwrap()
}

/// EYX is 2e-4 (x − 250)² µm.
fn truth() -> Machine {
    let text = NOMINAL.replace("500.0]\n", "500.0]\ntable = \"x.csv\"\n");
    read(&format!("{text}[location]\nC0Y_urad = 50.0\nB0Z_urad = -20.0\nA0Z_urad = 30.0\n"))
}

fn task(text: &str) -> Task {
    Task::read(text, Path::new("dial.toml")).unwrap()
}

fn filled(text: &str, noise_um: Option<f64>, seed: u64) -> FilledSheet {
    let conditions = Conditions { noise_um, drift: Drift::Size(0.0), seed, set_up: seed };
    dial(&task(text), &read(NOMINAL), &truth(), &conditions).unwrap()
}

fn solve(text: &str, sheet: &str) -> (CalibrationDocument, Calibration) {
    let (task, machine) = (task(text), read(NOMINAL));
    let (_, found) = solved(&task, &machine, sheet, Path::new("sheet.csv"), |_| {}).unwrap();
    (found.document(&task, &machine), found)
}

/// True tilts of the spindle about X and Y relative to X and Y, µrad: of its carriage, and its own in the carriage.
fn spindle(of: &FilledSheet) -> [f64; 2] {
    let [dx, dy, _] = Geometry::new(&truth(), 0.0).unwrap().actual_pose(&[250.0, 200.0, -250.0], &[0.0; 3]).direction;
    [1e6 * (of.spindle[0] - dy), 1e6 * (of.spindle[1] + dx)]
}

/// Found, standard error, true.
fn scores(text: &str, noise_um: Option<f64>, seed: u64) -> Vec<(String, [f64; 3])> {
    let sheet = filled(text, noise_um, seed);
    let (document, _) = solve(text, &sheet.text);
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
    let of = |name: &str| document.terms.iter().find(|term| term.name == name);
    let found = truths.into_iter().filter_map(|(name, truth)| {
        let term = of(name)?;
        Some((name.to_owned(), [term.value, term.standard_error, truth]))
    });
    found.collect()
}

#[test]
fn terms_and_tilts_come_back() {
    // Taper is the only artefact error that no reversal removes.
    let exact = TASK.replace("uncertainty_urad = 5.0", "uncertainty_urad = 0.001");
    for seed in 1..=5 {
        let found = scores(&exact, Some(0.0), seed);
        assert_eq!(found.len(), 7, "{found:?}");
        for (name, [value, _, truth]) in found {
            assert!((value - truth).abs() < 0.05, "seed {seed}: {name} {value} for {truth}");
        }
    }
}
