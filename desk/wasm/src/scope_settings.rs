//! Settings of a run as the page's controls store them, and machines to exchange.

use crate::files::machine;
use crate::{Refusal, json, to_js};
use serde::Serialize;
use std::collections::BTreeMap;
use trueaxis_sim::Settings;
use trueaxis_sim::plant::agreed;
use trueaxis_sim::plant::drive::DriveSettings;
use trueaxis_tables::formats::machine_files;
use wasm_bindgen::prelude::*;

/// Settings that were read.
#[derive(Serialize)]
struct Read {
    settings: Settings,
    changes: Vec<Change>,
}

/// A setting that differs from the default, with values in TOML notation.
#[derive(Serialize)]
struct Change {
    key: String,
    value: String,
    default: String,
}

fn settings(text: &str, file: &str) -> anyhow::Result<String> {
    let settings = Settings::parse(text, file)?;
    let changes = settings.changes().into_iter();
    let changes = changes.map(|(key, value, default)| Change { key, value, default }).collect();
    json(&Read { settings, changes })
}

/// Settings of the simulated drives that agree with the machine's stated figures.
#[derive(Serialize)]
struct Agreed {
    stated: bool,
    friction: bool,
    reference_temperature_c: f64,
    drive: DriveSettings,
}

fn agreed_drive(files: &str) -> anyhow::Result<String> {
    let settings = machine(files, &mut Vec::new())?.settings;
    let stated = settings.axes.iter().find(|own| own.servo.drive.is_some());
    let friction = stated.is_some_and(|own| own.servo.friction.is_some());
    let reference_temperature_c = settings.reference_temperature_c;
    json(&Agreed { stated: stated.is_some(), friction, reference_temperature_c, drive: agreed(&settings) })
}

fn scaled(files: &str, share: f64) -> anyhow::Result<String> {
    let machine = machine(files, &mut Vec::new())?.with_tables_scaled(share);
    let comment = format!("Every error table times {share}");
    json(&machine_files(&machine, &comment).into_iter().collect::<BTreeMap<_, _>>())
}

/// Reads settings in TOML; errors name `file`: `{settings: {…}, changes: [{key, value, default}]}`.
#[wasm_bindgen]
pub fn scope_settings(text: &str, file: &str) -> Result<String, Refusal> {
    to_js(settings(text, file))
}

/// The simulated drive that agrees with the plugin's figures: `{stated, friction, reference_temperature_c, drive:
/// {position_gain_per_s, …}}`; the defaults if the machine states none.
#[wasm_bindgen]
pub fn scope_agreed(files: &str) -> Result<String, Refusal> {
    to_js(agreed_drive(files))
}

/// The machine's files with every entry of its error tables multiplied by `share`.
#[wasm_bindgen]
pub fn scope_scaled(files: &str, share: f64) -> Result<String, Refusal> {
    to_js(scaled(files, share))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    fn sample() -> String {
        serde_json::to_string(&crate::samples::sample("mill-3axis").unwrap()).unwrap()
    }

    /// docs/commands.md states the settings that agree with the samples' figures.
    #[test]
    fn the_drive_of_the_sample_is_the_documented_one() {
        let found: Value = serde_json::from_str(&agreed_drive(&sample()).unwrap()).unwrap();
        let near = |key: &str, wanted: f64| {
            let value = found["drive"][key].as_f64().unwrap();
            assert!((value / wanted - 1.0).abs() < 2e-3, "{key}: found {value}, needed {wanted}");
        };
        near("coulomb_mm_per_s2", 378.0);
        near("position_gain_per_s", 115.5);
        near("velocity_gain_per_s", 840.0);
        near("presliding_mm", 0.0072);
        near("viscous_per_s", 3.6);
    }

    #[test]
    fn a_wrong_setting_is_refused_with_its_line() {
        let error = settings("rate_hz = 4000\ndrive.gain = 3\n", "mine.toml").unwrap_err().to_string();
        assert!(error.starts_with("mine.toml:2: drive.gain: found no such setting, needed one of"), "{error}");
    }

    #[test]
    fn half_the_tables_are_half_and_nothing_else_changes() {
        let half = scaled(&sample(), 0.5).unwrap();
        let mut notes = Vec::new();
        let (whole, half) = (machine(&sample(), &mut notes).unwrap(), machine(&half, &mut notes).unwrap());
        assert_eq!(half.settings.location, whole.settings.location);
        let rows =
            |of: &trueaxis_tables::Machine| of.tables.iter().flatten().flat_map(|t| t.rows.clone()).collect::<Vec<_>>();
        for (whole, half) in rows(&whole).iter().zip(rows(&half)) {
            assert_eq!(whole.position, half.position);
            for (whole, half) in whole.forward.iter().zip(half.forward) {
                assert!((0.5 * whole - half).abs() < 1e-12, "{whole} {half}");
            }
        }
    }
}
