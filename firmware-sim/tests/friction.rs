//! Calls `firmware-sim friction`: record, identify, configure, record again.

use serde_json::Value;
use trueaxis_testing::command::Folder;

const SIMULATOR: &str = env!("CARGO_BIN_EXE_firmware-sim");
/// Small circles keep the record short.
const CALL: [&str; 6] = ["friction", "--json", "--radius-mm", "12.0037", "--feeds", "1200,500"];

fn figures(axis: &Value, key: &str) -> [f64; 3] {
    ["identified", "standard_errors", "true"].map(|of| axis[of][key].as_f64().unwrap_or(0.0))
}

#[test]
fn spikes_are_gone_with_the_friction_and_the_drive_that_were_found() {
    let folder = Folder::new(SIMULATOR);
    let found = folder.json(&[&CALL[..], &["-o", "record.csv"]].concat());
    for axis in found["axes"].as_array().unwrap() {
        assert_eq!(axis["drive_found"], true);
        // The simulated position loop is sampled at the servo period and uses readings with encoder errors: in addition to its
        // standard error, each figure may be off by the amount that these distort every reversal alike.
        for (key, tolerance) in [
            ("coulomb_mm_per_s", 0.06),
            ("presliding_um", 0.03),
            ("stribeck_share", 0.06),
            ("stribeck_velocity_mm_per_s", 0.15),
            ("position_gain_per_s", 0.05),
            ("velocity_gain_per_s", 0.08),
            ("reset_time_s", 0.08),
            ("velocity_feed_forward", 0.02),
        ] {
            let [value, error, truth] = figures(axis, key);
            let off = (value - truth).abs();
            assert!(off < 4.0 * error || off < tolerance * truth, "{key}: {axis}");
            assert!(off < 0.25 * truth, "{key}: {axis}");
        }
        spikes_fall(axis, 0.2);
    }
    let [before, after] = ["before", "after"].map(|of| found["contour_error_um"][of]["max"].as_f64().unwrap());
    assert!(after < 0.7 * before, "{before} µm before, {after} µm after");
    let record = folder.read("record.csv");
    assert!(record.starts_with("t_s,x_cmd_mm,x_mm,y_cmd_mm,y_mm\n0.000000,"));
    assert!(record.lines().count() > 50_000);
}

fn spikes_fall(axis: &Value, share: f64) {
    let size = |of: &str, what: &str| axis["glitch_um"][of][what].as_f64().unwrap();
    assert!(size("before", "max") > 1.0, "{axis}");
    assert!(size("after", "max") < share * size("before", "max"), "{axis}");
    assert!(size("after", "rms") < share * size("before", "rms"), "{axis}");
}

/// The sample states gains that are 5 % too high; the figures identified with them still remove the spikes.
#[test]
fn figures_of_a_drive_that_are_somewhat_wrong_do() {
    let found = Folder::new(SIMULATOR).json(&[&CALL[..], &["--given-drive"]].concat());
    for axis in found["axes"].as_array().unwrap() {
        assert_eq!(axis["drive_found"], false);
        assert!(axis["standard_errors"]["position_gain_per_s"].is_null());
        spikes_fall(axis, 0.25);
    }
}

#[test]
fn impossible_recordings_are_refused() {
    for (arguments, needed) in [
        (["--radius-mm", "0"], "--radius-mm: found 0, needed 1 to 1000"),
        (["--feeds", "1500"], "--feeds: found 1 feeds, needed two"),
        (["--feeds", "1500,5"], "--feeds: found 5, needed 10 to 20000"),
        (["--feeds", "1500,1500"], "needed accelerations that differ by 1.5 or more"),
        (["--turns", "0"], "--turns: found 0, needed 1 to 20"),
        (["--radius-mm", "400"], "within its travel"),
    ] {
        Folder::new(SIMULATOR).bad(&[&["friction"], &arguments[..]].concat(), &[needed]);
    }
}
