//! Recorded warm-ups for identifying thermal growth, and texts with the result: `trueaxis thermal`.

use crate::choice::one_in;
use crate::{Target, no_repair, outcome, refusal, small};
use std::fmt::Write;
use std::path::Path;
use std::time::Duration;
use trueaxis::temperature::Thermal;
use trueaxis_evaluation::rows::Rows;
use trueaxis_evaluation::thermal::{COLUMNS, FittedRecording, Recording, model, settings, written};

/// See [`Target`].
pub const TARGET: Target = Target {
    name: "thermal",
    about: "recorded warm-ups (CSV), growth found in some, and its texts (thermal.toml)",
    run,
    seeds,
    repair: no_repair,
    dictionary: include_str!("../../dictionaries/thermal.dict"),
    slowest: FITTED,
};

const RECORD: &str = "record.csv";
const TEXT: &str = "thermal.toml";
const FITTED: Duration = Duration::from_secs(10);
/// One in so many readable records is fitted.
const FIT_ONE_IN: u64 = 1024;
const MOST_ROWS: usize = 120;

fn run(bytes: &[u8]) {
    if bytes.starts_with(b"t_s") { record(bytes) } else { text(bytes) }
}

fn record(bytes: &[u8]) {
    if bytes.iter().filter(|byte| matches!(byte, b'\n' | b'\r')).count() > MOST_ROWS {
        return;
    }
    let read = Rows::new(bytes, Path::new(RECORD), &COLUMNS, outcome::refused);
    let recording = match read.and_then(|rows| Recording::read(rows, &[])) {
        Ok(recording) => recording,
        Err(error) => return refusal::of_file(&format!("{error:#}"), RECORD, bytes),
    };
    outcome::accepted();
    if !one_in(FIT_ONE_IN, bytes) {
        return;
    }
    let machine = small::machine("w b X Y Z t");
    match FittedRecording::of(recording, &settings(Some(&machine.settings), Vec::new()), &mut |_| {}) {
        Ok(found) => {
            let document = serde_json::to_string(&found.document()).expect("a document");
            assert!(!document.contains("NaN"), "{document}");
            let text = written(&found);
            let read = model(&text, Path::new(TEXT), &machine.settings);
            assert!(read.is_ok_and(|model| model.encode(1).is_ok()), "{text}");
            outcome::saw("fitted");
        }
        Err(error) => refusal::in_words(&format!("{error:#}")),
    }
}

fn text(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let machine = small::machine("w b X Y Z t");
    match model(text, Path::new(TEXT), &machine.settings) {
        Ok(model) => match model.encode(1) {
            Ok(bytes) => {
                assert!(Thermal::parse(&bytes).is_ok());
                outcome::accepted();
            }
            Err(error) => refusal::in_words(&error.to_string()),
        },
        Err(error) => refusal::in_words(&error.to_string()),
    }
}

fn seeds() -> Vec<Vec<u8>> {
    let mut record = String::from("t_s,cycle,spindle_rpm,x_mm,tool_mm,ex_um,ez_um,T1_c,T2_c\n");
    for cycle in 0..3_u32 {
        for row in 0..14_u32 {
            let t = 300 * (14 * cycle + row);
            let warm = f64::from((row * (cycle + 2)) % 9);
            let rpm = 1000 * ((row / 4 + cycle) % 3);
            let _ = writeln!(
                record,
                "{t},{cycle},{rpm},0,50,{},{},{},{}",
                0.1 * warm,
                2.0 * warm,
                20.0 + warm,
                21 + row % 3
            );
        }
    }
    let text = "reference_temperature_c = 20.0\n\n[[sensor]]\nname = \"T1\"\nlag_s = 600\nknots_c = [10, 20, 40.5]\n\n\
                [spindle]\nlag_s = 900\nknots_rpm = [0, 6000]\n\n[axis.Z]\ndatum_mm = 0.0\n\n[axis.Z.sensor.T1]\n\
                offset_um = [-10, 0, 20.5]\nslope_um_per_m = [-100, 0, 200]\n\n[axis.Z.spindle]\ngrowth_um = [0, 8]\n";
    vec![record.into_bytes(), text.into()]
}
