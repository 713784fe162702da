//! Compares the best nine tables with sums calculated by hand.

use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use trueaxis::Axis;
use trueaxis::machine::PeriodicSettings;
use trueaxis_tables::Machine;
use trueaxis_tables::collapse::{CollapseError, CollapseOptions, collapse};
use trueaxis_tables::formats::machine_files;

fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../compensation-tables").join(name)
}

/// Three axes on the tool side with the errors of X as given, travel 400 x 200 x 300.
fn machine(columns: &str, low: &str, high: &str) -> Machine {
    let directory = TempDir::new().unwrap();
    let toml = "name = \"m\"\nchain = \"w b X Y Z t\"\n[axis.X]\ntable = \"x.csv\"\ntravel_mm = [-200, 200]\n\
        [axis.Y]\ntravel_mm = [-100, 100]\n[axis.Z]\ntravel_mm = [0, 300]\n[location]\nB0Z_urad = 20\n";
    fs::write(directory.path().join("machine.toml"), toml).unwrap();
    fs::write(directory.path().join("x.csv"), format!("X_mm,{columns}\n-200,{low}\n200,{high}\n")).unwrap();
    Machine::read(directory.path()).unwrap()
}

/// A pitch of X, k x with k = 10 µrad / 100 mm, moves the tip by k x z: nine tables express all but k (x − x̄)(z − z̄), whose
/// RMS is k · 400/√12 · 300/√12 and whose maximum k · 200 · 150 is in the corners.
#[test]
fn a_pitch_leaves_the_product() {
    let collapsed = collapse(&machine("EBX_urad", "-20", "20"), &CollapseOptions::default()).unwrap();
    let (max, k) = (collapsed.after.max_mm, 1e-7);
    assert!((max - k * 200.0 * 150.0).abs() < 2e-6, "{max}");
    // Trapezoids on 43 points overestimate the sum of x² by the factor 1 + 2/42².
    let rms = k * 400.0 * 300.0 / 12.0 * (1.0 + 2.0 / (42.0 * 42.0));
    assert!((collapsed.after.rms_mm - rms).abs() < 2e-7, "{} {rms}", collapsed.after.rms_mm);
    assert_eq!(collapsed.causes.len(), 1);
    assert_eq!(collapsed.causes[0].axis, trueaxis::Axis::X);
}

#[test]
fn without_angular_errors_nothing_is_left() {
    let collapsed = collapse(&machine("EXX_um,EZX_um", "-7.3,4", "5.1,9"), &CollapseOptions::default()).unwrap();
    assert!(collapsed.before.max_mm > 9e-3);
    assert!(collapsed.after.max_mm < 1e-9, "{}", collapsed.after.max_mm);
    assert!(collapsed.causes.is_empty());
    assert_eq!(collapsed.machine.settings.location.b0z, 0.0);
    // The cross terms vanish in the middle of the volume.
    let middle = &collapsed.machine.tables[2].as_ref().unwrap().rows[5];
    assert!(middle.forward[0].abs() < 1e-10 && middle.forward[1].abs() < 1e-10, "{middle:?}");
}

#[test]
fn better_than_the_tables_as_they_are_and_read_back_the_same() {
    let source = Machine::read(&sample("mill-3axis")).unwrap();
    let collapsed = collapse(&source, &CollapseOptions::default()).unwrap();
    // The tables were measured in mid-volume, so new ones gain little.
    assert!(collapsed.after.rms_mm < collapsed.original.rms_mm);
    assert!(collapsed.after.rms_mm < 0.5 * collapsed.before.rms_mm);
    let directory = TempDir::new().unwrap();
    for (name, text) in machine_files(&collapsed.machine, "collapsed") {
        fs::write(directory.path().join(name), text).unwrap();
    }
    assert_eq!(Machine::read(directory.path()).unwrap(), collapsed.machine);
}

#[test]
fn bad_volumes_are_refused() {
    let machine = machine("EBX_urad", "-20", "20");
    for range in [[-201.0, 0.0], [5.0, 5.0], [10.0, -10.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
        let options = CollapseOptions { volume_mm: [Some(range), None, None], ..Default::default() };
        let refused = collapse(&machine, &options);
        assert!(matches!(refused, Err(CollapseError::Option { option: "volume", .. })), "{range:?}: {refused:?}");
    }
}

/// Periods stay a setting of their own: the tables are those without them, and as much is left.
#[test]
fn periods_stay_out_of_the_tables() {
    let plain = machine("EBX_urad,EXX_um", "-20,3", "20,-2");
    let mut periodic = plain.clone();
    for (axis, period, reverse) in [(Axis::X, 5.0, vec![]), (Axis::Z, 4.0, vec![[1e-4, 0.0]])] {
        let (harmonics, reverse) = ([[1.5e-4, 1e-4]].into_iter().collect(), reverse.into_iter().collect());
        periodic.settings.periodic.push(PeriodicSettings { axis, period, harmonics, reverse }).unwrap();
    }
    let [of_plain, of_periodic] =
        [&plain, &periodic].map(|machine| collapse(machine, &CollapseOptions::default()).unwrap());
    assert_eq!(of_periodic.machine.settings.periodic, periodic.settings.periodic);
    for (found, needed) in of_periodic.machine.tables.iter().zip(&of_plain.machine.tables) {
        for (found, needed) in found.iter().zip(needed).flat_map(|(found, needed)| found.rows.iter().zip(&needed.rows))
        {
            let away = found.forward.iter().zip(needed.forward).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(away < 1e-9, "{found:?}, needed {needed:?}");
        }
    }
    assert!((of_periodic.after.max_mm - of_plain.after.max_mm).abs() < 1e-6);
}
