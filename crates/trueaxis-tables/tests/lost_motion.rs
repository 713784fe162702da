//! Lost motion: refusals and warnings.

use std::fs;
use std::path::Path;
use tempfile::TempDir;
use trueaxis_tables::{Machine, Warning, check, lost_motion};

/// `w b X C t`, X with the keys and the table given.
fn written(keys: &str, table: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let toml = format!(
        "name = \"m\"\nchain = \"w C' b X t\"\n[axis.X]\ntable = \"x.csv\"\n{keys}\n[axis.C]\ntable = \"c.csv\"\nbacklash_urad = 12\n"
    );
    fs::write(folder.path().join("machine.toml"), toml).unwrap();
    fs::write(folder.path().join("x.csv"), table).unwrap();
    fs::write(folder.path().join("c.csv"), "C_deg,ECC_urad\n0,0\n360,0\n").unwrap();
    folder
}

const PLAIN: &str = "X_mm,EXX_um\n0,0\n100,5\n";

fn refusal(keys: &str, table: &str) -> String {
    let folder = written(keys, table);
    let error = Machine::read(folder.path()).unwrap_err().to_string();
    let name = folder.path().join("machine.toml");
    error.replace(&name.display().to_string(), Path::new("machine.toml").to_str().unwrap())
}

#[test]
fn a_hysteresis_that_a_reversal_crosses_is_refused_with_the_figure() {
    let against = "needed more than its correction steps against the travel at a reversal: ";
    let message = refusal("backlash_um = -1.25\nhysteresis_um = 0.5", PLAIN);
    assert!(
        message.starts_with("machine.toml:6: key axis.X.hysteresis_um: found 0.5, ") && message.contains(against),
        "{message}"
    );
    // 1.25 µm, and what the slope of the table adds: thousandths, rounded up.
    let bound: f64 = message.rsplit(": ").next().unwrap().trim_end_matches(" um").parse().unwrap();
    assert!((1.25..1.252).contains(&bound), "{message}");
    let folder = written(&format!("backlash_um = -1.25\nhysteresis_um = {bound}"), PLAIN);
    assert!(Machine::read(folder.path()).is_ok());

    let message = refusal("", "X_mm,EXX_fwd_um,EXX_rev_um\n0,0,1\n50,2,1.5\n100,0,1\n");
    assert!(
        message.starts_with("machine.toml:3: key axis.X.hysteresis_um: found 0.3, the default, ")
            && message.contains(against),
        "{message}"
    );
}

#[test]
fn the_encoder_bounds_the_hysteresis_of_an_axis_with_lost_motion() {
    let message = refusal("backlash_um = 2\nencoder_resolution_um = 0.2", PLAIN);
    assert!(message.ends_with("needed at least three steps of the encoder: 0.6 um"), "{message}");
    for keys in [
        "backlash_um = 2\nencoder_resolution_um = 0.1",
        "backlash_um = 2\nencoder_resolution_um = 0.2\nhysteresis_um = 0.6",
        "encoder_resolution_um = 1",
    ] {
        let machine = Machine::read(written(keys, PLAIN).path()).unwrap();
        assert!(machine.settings.axes[0].encoder_resolution.is_some());
        let files = trueaxis_tables::formats::machine_files(&machine, "");
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            fs::write(folder.path().join(name), text).unwrap();
        }
        assert_eq!(Machine::read(folder.path()).unwrap(), machine);
    }
    let message = refusal("encoder_resolution_um = 0", PLAIN);
    assert!(
        message.starts_with("machine.toml:5: key axis.X.encoder_resolution_um: found 0, needed 0.00001 to 1000 um"),
        "{message}"
    );
}

#[test]
fn the_way_that_lost_motion_costs_is_told() {
    // EXX from 1 to 2.5 µm more in negative travel, 0.5 µm of backlash on top.
    let table = "X_mm,EXX_fwd_um,EXX_rev_um\n0,0,1\n50,2,4.5\n100,0,1\n";
    let machine = Machine::read(written("backlash_um = 0.5\nmax_feed_mm_per_min = 12000", table).path()).unwrap();
    let [x, c] = lost_motion(&machine)[..] else { panic!() };
    // Up at 5 m/s² and down at 4 m/s²: t = √(2 B (1/5000 + 1/4000)).
    let seconds = (2.0_f64 * 0.003 * (1.0 / 5000.0 + 1.0 / 4000.0)).sqrt();
    assert!(
        (x.play - 0.003).abs() < 1e-15
            && (x.lead_in_s - seconds).abs() < 1e-12
            && (x.way - 200.0 * seconds).abs() < 1e-9
    );
    assert_eq!(
        x.to_string(),
        "axis X: lost motion of up to 3.0 µm is corrected within 1.6 ms of a reversal, 0.33 mm at 200 mm/s"
    );
    assert!((c.play.to_radians() - 12e-6).abs() < 1e-15 && c.to_string().contains("12.0 µrad"), "{c}");
    let slow = |machine: &Machine| check(machine, 1e4).into_iter().find(|w| matches!(w, Warning::SlowLeadIn(_)));
    assert_eq!(slow(&machine), None);

    let keys = "backlash_um = 0.5\nlimits = { slope_mm_per_s = 1, acceleration_mm_per_s2 = 200 }";
    let slowed = Machine::read(written(keys, table).path()).unwrap();
    let warning = slow(&slowed).unwrap().to_string();
    assert!(warning.contains("within 8.2 ms of a reversal"), "{warning}");
}
