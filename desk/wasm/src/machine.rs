//! A machine and its tables: reading, displaying, editing, compiling.

use crate::files::{DESCRIPTION, MachineFiles, Texts, from_given, given, machine, memory, texts};
use crate::shown::shown;
use crate::{Refusal, json, samples, to_js};
use anyhow::{Context, Result};
use serde::Serialize;
use std::path::Path;
use trueaxis::Axis;
use trueaxis_evaluation::check::compiled;
use trueaxis_evaluation::curve::{ErrorCurve, curve};
use trueaxis_tables::{Change, change};
use wasm_bindgen::prelude::*;

/// A machine that was read.
#[derive(Serialize)]
struct Opened {
    name: String,
    axes: Vec<String>,
    notes: Vec<String>,
}

fn opened(files: &str) -> Result<String> {
    let mut notes = Vec::new();
    let machine = machine(files, &mut notes)?;
    let axes = machine.settings.axes.iter().map(|own| own.axis.letter().to_string()).collect();
    json(&Opened { name: machine.settings.name.as_str().to_owned(), axes, notes })
}

/// Reads and checks a machine: name, axes, notes.
#[wasm_bindgen]
pub fn machine_open(files: &str) -> Result<String, Refusal> {
    to_js(opened(files))
}

/// The sample machines: `[{"name": "…", "description": "…"}, …]`.
#[wasm_bindgen]
pub fn machine_samples() -> Result<String, Refusal> {
    to_js(json(&samples::samples()))
}

/// Files of a sample machine.
#[wasm_bindgen]
pub fn machine_sample(name: &str) -> Result<String, Refusal> {
    to_js(samples::sample(name).and_then(|files| json(&files)))
}

fn from_files(current: &str, names: &str, bytes: &[u8]) -> Result<MachineFiles> {
    from_given(&texts(current)?, &given(names, bytes)?)
}

/// Reads a machine from dropped files, `{"name", "files", "notes"}`: a folder, a `.tcomp`, or files that replace or join the
/// current ones. `names` are paths and lengths, `[["mill/x.csv", 1234], …]`, of files whose bytes are concatenated.
#[wasm_bindgen]
pub fn machine_from_files(current: &str, names: &str, bytes: &[u8]) -> Result<String, Refusal> {
    to_js(from_files(current, names, bytes).and_then(|taken| json(&taken)))
}

fn to_tcomp(files: &str, rate_hz: f64) -> Result<Vec<u8>> {
    let machine = machine(files, &mut Vec::new())?;
    compiled(&machine, &memory(files)?, Path::new(DESCRIPTION), rate_hz)
}

/// The compiled file, as written by `trueaxis tables compile`.
#[wasm_bindgen]
pub fn machine_to_tcomp(files: &str, rate_hz: f64) -> Result<Vec<u8>, Refusal> {
    to_js(to_tcomp(files, rate_hz))
}

/// The full description of a machine at a servo rate, as JSON. `feed_per_min` is the feed of all axes, mm/min and degrees/min,
/// for slopes and accelerations of the correction; zero means the top feed of each.
#[wasm_bindgen]
pub fn machine_show(files: &str, rate_hz: f64, feed_per_min: f64) -> Result<String, Refusal> {
    to_js(shown(files, rate_hz, feed_per_min).and_then(|shown| json(&shown)))
}

fn changed(files: &str, change_: &str) -> Result<Texts> {
    let asked: Change = serde_json::from_str(change_).context("a change")?;
    let mut all = texts(files)?;
    for (name, text) in change(&memory(files)?, Path::new(DESCRIPTION), &asked)?.files {
        all.insert(name.to_string_lossy().into_owned(), text);
    }
    Ok(all)
}

/// The files after a change, one of
/// `{"change": "point", "axis": "X", "column": "EXX_um", "row": 3, "value": 1.5}`, with `"also": [["EXX_rev_um", 3.0]]` where
/// other columns of the row change with it,
/// `{"change": "insert", "axis": "X", "position": 12.5}`, `{"change": "remove", "axis": "X", "row": 3}`,
/// `{"change": "key", "key": "axis.X.backlash_um", "value": 2.0}`.
#[wasm_bindgen]
pub fn machine_change(files: &str, change: &str) -> Result<String, Refusal> {
    to_js(changed(files, change).and_then(|files| json(&files)))
}

fn curve_of(files: &str, axis: &str, component: usize, temperature_c: f64, points: usize) -> Result<ErrorCurve> {
    let letter = axis.chars().next().and_then(Axis::from_letter);
    let axis = letter.with_context(|| format!("found the axis {axis:?}, needed one of X Y Z A B C"))?;
    curve(&machine(files, &mut Vec::new())?, axis, component, temperature_c, points)
}

/// One error of an axis between its points: positions, then the same number of values in positive travel, in negative travel,
/// and of the growth at a temperature, °C. `component`: 0 to 5 for EX to EC.
#[wasm_bindgen]
pub fn machine_curve(
    files: &str,
    axis: &str,
    component: usize,
    temperature_c: f64,
    points: usize,
) -> Result<Vec<f64>, Refusal> {
    let ErrorCurve { positions, forward, reverse, growth } =
        to_js(curve_of(files, axis, component, temperature_c, points))?;
    Ok([positions, forward, reverse, growth].concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn sample(name: &str) -> String {
        serde_json::to_string(&samples::sample(name).unwrap()).unwrap()
    }

    fn dropped(current: &str, files: &[(&str, &[u8])]) -> Result<MachineFiles> {
        let names: Vec<(&str, usize)> = files.iter().map(|(name, bytes)| (*name, bytes.len())).collect();
        let bytes: Vec<u8> = files.iter().flat_map(|(_, bytes)| bytes.iter().copied()).collect();
        from_files(current, &serde_json::to_string(&names).unwrap(), &bytes)
    }

    #[test]
    fn a_folder_is_taken_with_what_belongs_to_it() {
        let files = samples::sample("mill-3axis").unwrap();
        let mut given: Vec<(String, &[u8])> =
            files.iter().map(|(name, text)| (format!("mine/{name}"), text.as_bytes())).collect();
        given.push(("mine/photo.png".into(), &[0xff, 0xd8]));
        let given: Vec<(&str, &[u8])> = given.iter().map(|(name, bytes)| (name.as_str(), *bytes)).collect();
        let taken = dropped("{}", &given).unwrap();
        assert_eq!((taken.name.as_str(), &taken.files), ("mine", &files));
        assert_eq!(taken.notes, ["1 file left out that no machine needs"]);
        let twice = [("a/machine.toml", "".as_bytes()), ("b/machine.toml", b"")];
        let refused = dropped("{}", &twice).unwrap_err().to_string();
        assert_eq!(refused, "found several machines, a/machine.toml and b/machine.toml, needed one");
    }

    #[test]
    fn tables_outside_the_folder_keep_their_place() {
        let text = "name = \"m\"\nchain = \"w X' b t\"\n[axis.X]\ntable = \"../shared/x.dat\"\n";
        let table = "X_mm;EXX_um\n# f\u{fc}r alle\n0;1,5\n10;2\n";
        let latin: Vec<u8> = table.chars().map(|letter| letter as u8).collect();
        let taken = dropped("{}", &[("all/m/machine.toml", text.as_bytes()), ("all/shared/x.dat", &latin)]).unwrap();
        assert_eq!(taken.files.keys().collect::<Vec<_>>(), ["../shared/x.dat", "machine.toml"]);
        assert_eq!(taken.notes, ["../shared/x.dat: read as semicolon separated with decimal commas"]);
    }

    #[test]
    fn errors_name_file_line_and_column() {
        let mill = sample("mill-3axis");
        let refused = |files: &[(&str, &[u8])]| dropped(&mill, files).unwrap_err().to_string();
        let error = refused(&[("x.csv", b"X_mm,EXX_um\n0,1\n10,two\n")]);
        assert_eq!(error, "x.csv:3: column EXX_um: found \"two\", needed a number");
        let error = refused(&[("x.csv", b"X_mm,EXX_um\n0,1\n10,\xff\n")]);
        assert_eq!(error, "x.csv:3: found bytes that are not UTF-8, needed text in UTF-8");
        assert!(refused(&[("old.tcomp", b"TAXT")]).starts_with("old.tcomp: "));
        assert!(
            refused(&[("notes.txt", b"hello")]).starts_with("notes.txt: found a file that is none of the machine's")
        );
        let taken = dropped(&mill, &[("more/y.csv", b"Y_mm,EYY_um\n-200,0\n200,1\n")]).unwrap();
        assert_eq!(taken.files["y.csv"], "Y_mm,EYY_um\n-200,0\n200,1\n");
    }

    #[test]
    fn compiled_files_open_again_as_the_same_machine() {
        for name in ["mill-3axis", "mill-5axis", "head-5axis", "mill-turn", "grinder"] {
            let bytes = to_tcomp(&sample(name), 10_000.0).unwrap();
            let taken = dropped("{}", &[("dir/m.tcomp", &bytes)]).unwrap();
            let files = serde_json::to_string(&taken.files).unwrap();
            let again = machine(&files, &mut Vec::new()).unwrap();
            let before = machine(&sample(name), &mut Vec::new()).unwrap();
            assert_eq!(again.tables, before.tables, "{name}");
            assert_eq!(taken.name, name);
            // Angular limits are stored in degrees and written in µrad, so the last place may differ for a rotary machine.
            if !["mill-5axis", "head-5axis", "mill-turn"].contains(&name) {
                assert!(to_tcomp(&files, 10_000.0).unwrap() == bytes, "{name}");
            }
        }
    }

    #[test]
    fn changes_keep_the_other_files_and_refusals_name_the_place() {
        let mill = sample("mill-3axis");
        let after = |change: Value| changed(&mill, &change.to_string());
        let files = after(json!({"change": "key", "key": "location.C0Y_urad", "value": 12.5})).unwrap();
        let before = samples::sample("mill-3axis").unwrap();
        assert_eq!(files["machine.toml"], before["machine.toml"].replace("C0Y_urad = 38.0", "C0Y_urad = 12.5"));
        assert_eq!(files.len(), before.len());
        assert_eq!(files["x.csv"], before["x.csv"]);
        let refused = after(json!({"change": "key", "key": "location.C0Y_urad", "value": 1e9})).unwrap_err();
        assert!(
            refused.to_string().starts_with("machine.toml:49: key location.C0Y_urad: found 1000000000.0"),
            "{refused}"
        );
    }

    #[test]
    fn the_document_is_the_command_lines_and_more() {
        let shown = serde_json::to_value(shown(&sample("mill-3axis"), 10_000.0, 0.0).unwrap()).unwrap();
        assert_eq!(shown["check"]["ok"], true);
        assert_eq!(shown["axes"][0]["table"]["columns"][1]["name"], "EXX_fwd_um");
        assert_eq!(shown["axes"][0]["table"]["rows"][0][1], 14.551);
        assert_eq!(shown["axes"][1]["backlash"], 2.2);
        assert_eq!(shown["measurements"][0]["file"], "x-iso230-2.csv");
        let rows = &shown["measurements"][0]["figures"]["tables"][0]["rows"];
        let of = |row: usize| rows[row][1]["value"].as_f64().unwrap();
        assert!(rows[0][0].as_str().unwrap().starts_with("A,") && rows[3][0].as_str().unwrap().starts_with("E,"));
        assert!(of(0) > of(3), "accuracy includes the systematic error");
        // At a tenth of the feed: a tenth of the rate, a hundredth of the acceleration.
        let slow = serde_json::to_value(super::shown(&sample("mill-3axis"), 10_000.0, 1200.0).unwrap()).unwrap();
        let fast = serde_json::to_value(super::shown(&sample("mill-3axis"), 10_000.0, 12_000.0).unwrap()).unwrap();
        for (key, factor) in [("rate", 10.0), ("acceleration", 100.0)] {
            let of = |document: &Value| document["axes"][0]["correction"][key].as_f64().unwrap();
            assert!((of(&fast) / of(&slow) / factor - 1.0).abs() < 1e-12, "{key}");
        }
        let refused = super::shown(&sample("mill-3axis"), 5.0, 0.0).unwrap_err().to_string();
        assert_eq!(refused, "--rate-hz: found 5, needed 10 to 1000000");
    }
}
