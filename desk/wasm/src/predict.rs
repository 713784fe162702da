//! A part before it is cut, and moved about the machine; with the servo, and what to measure for it.

use crate::files::{DESCRIPTION, machine, memory};
use crate::{Refusal, json, progress, to_js};
use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::path::Path;
use trueaxis_evaluation::calibrate::Task;
use trueaxis_evaluation::predict::{
    GrowthModel, Live, Options, Part, PredictDocument, Shape, Start, TEMPERATURES, TemperatureRecord, advise,
    elsewhere, predict as evaluate, predict_with_servo,
};
use trueaxis_evaluation::rows::Rows;
use trueaxis_evaluation::shown::Shown;
use trueaxis_sim::program::{Program, ReadOptions};
use trueaxis_tables::Machine;
use trueaxis_tables::uncertainty::Uncertainties;
use wasm_bindgen::prelude::*;

thread_local! {
    /// The part that is moved.
    static LIVE: RefCell<Option<Live>> = const { RefCell::new(None) };
}

/// A part, its program and the draws.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Request {
    /// Name and text of the part's file.
    part: [String; 2],
    /// Name and text of the program.
    program: [String; 2],
    /// Programs of further set-ups, files of subprograms, and tasks of instruments.
    #[serde(default)]
    more: Vec<[String; 2]>,
    /// Name and text of the machine's thermal.toml.
    #[serde(default)]
    thermal: Option<[String; 2]>,
    /// Name and text of a record of temperatures.
    #[serde(default)]
    record: Option<[String; 2]>,
    /// Start of the program in the record: seconds after its first row, or `HH:MM`; 0 if empty.
    #[serde(default)]
    start: String,
    /// Place of the program's zero; that of the part's file if `null`.
    at_mm: Option<[f64; 3]>,
    /// Temperature of the machine, °C; that of the part's file if `null`.
    #[serde(default)]
    machine_c: Option<f64>,
    trials: u64,
    seed: u64,
}

/// A predicted part.
#[derive(Serialize)]
struct Predicted {
    #[serde(flatten)]
    there: There,
    /// Printed by `trueaxis predict`.
    shown: Shown,
    notes: Vec<String>,
}

/// Where a kept part can go.
#[derive(Serialize)]
struct Kept {
    /// Lowest and highest place along X, Y and Z.
    range_mm: [[f64; 2]; 3],
    /// Temperature of the machine; `null` if it does not grow.
    machine_c: Option<f64>,
}

/// The part at a place.
#[derive(Serialize)]
struct There {
    /// The document printed by `trueaxis predict --json`.
    document: PredictDocument,
    /// Share of each tolerance that is used.
    used: Vec<f64>,
    shapes: Vec<Shape>,
}

impl From<PredictDocument> for There {
    fn from(mut document: PredictDocument) -> There {
        let used = document.features.iter().map(trueaxis_evaluation::predict::Predicted::used).collect();
        There { used, shapes: std::mem::take(&mut document.shapes), document }
    }
}

/// Everything that a part is predicted from.
struct Read {
    machine: Machine,
    stated: Uncertainties,
    program: Program,
    part: Part,
    options: Options,
    /// What the machine's thermal.toml states.
    growth: Option<GrowthModel>,
    /// Further files by name.
    more: Vec<[String; 2]>,
    notes: Vec<String>,
}

/// The text of a file that a part names.
fn beside<'f>(more: &'f [[String; 2]], part: &str, file: &str, what: &str) -> Result<&'f [String; 2]> {
    let own = Path::new(file).file_name();
    more.iter()
        .find(|[name, _]| Path::new(name).file_name() == own)
        .with_context(|| format!("{part}: found no {what} {file}, needed it beside the part"))
}

fn start(text: &str) -> Result<Start> {
    let text = text.trim();
    let seconds = if text.is_empty() { Some(0.0) } else { text.parse().ok().filter(|found: &f64| found.is_finite()) };
    let found = seconds.map(Start::After).or_else(|| Start::clock(text).map(Start::At));
    found.with_context(|| format!("start: found {text}, needed seconds, or hours and minutes, 00:00 to 23:59"))
}

fn read(files: &str, request: &str) -> Result<Read> {
    let request: Request = serde_json::from_str(request).context("the request of a part")?;
    let Request { part: [part_name, part], program: [name, program], more, at_mm, machine_c, trials, seed, .. } =
        request;
    let mut notes = Vec::new();
    let machine = machine(files, &mut notes)?;
    let stated = Uncertainties::read_from(&memory(files)?, Path::new(DESCRIPTION))?;
    let mut part = Part::read(&part, Path::new(&part_name))?;
    part.at_mm = at_mm.unwrap_or(part.at_mm);
    let stated_growth = |[name, text]: &[String; 2]| GrowthModel::of(&machine, Some((text, Path::new(name))));
    let growth = request.thermal.as_ref().map(stated_growth).transpose()?;
    let record = request.record.as_ref().map(|[name, text]| {
        TemperatureRecord::read(Rows::new(text.as_bytes(), Path::new(name), &TEMPERATURES, |note| notes.push(note))?)
    });
    let record = record.transpose()?;
    let start = start(&request.start)?;
    part.temperature.machine_c = machine_c.or(part.temperature.machine_c);
    let model = || growth.clone().map_or_else(|| GrowthModel::of(&machine, None), Ok);
    part = part.warmed(record.as_ref().map(|record| (record, start)), model)?;
    let texts = Some(more.iter().map(|[name, text]| (name.clone(), text.clone())).collect());
    let options = ReadOptions { texts, ..ReadOptions::default() };
    let parse = |name: &str, text: &str| {
        let stem = Path::new(name).file_stem().map_or(name.into(), |stem| stem.to_string_lossy());
        Program::read(&stem, text.as_bytes(), name, &options)
    };
    let program = parse(&name, &program)?;
    part.read_setups(|file| {
        let [name, text] = beside(&more, &part_name, file, "program")?;
        anyhow::Ok(parse(name, text)?)
    })?;
    Ok(Read { machine, stated, program, part, options: Options { trials, seed }, growth, more, notes })
}

fn predicted(files: &str, request: &str) -> Result<String> {
    let Read { machine, stated, program, part, options, notes, .. } = read(files, request)?;
    let document = evaluate(&machine, &stated, &program, &part, options)?;
    json(&Predicted { shown: document.shown(), there: document.into(), notes })
}

/// Predicts a part: `document`, `shown`, `used`, `shapes`, `notes`. `request`: `part` and `program` (name and text each),
/// `at_mm`, `trials`, `seed`.
#[wasm_bindgen]
pub fn predict(files: &str, request: &str) -> Result<String, Refusal> {
    to_js(predicted(files, request))
}

/// As [`predict`], with the servo at a rate, Hz, and drives exactly as stated: a page has no time for a run of each uncertain
/// figure. The share that is done is reported as the progress of the call.
#[wasm_bindgen]
pub fn predict_servo(files: &str, request: &str, rate_hz: f64) -> Result<String, Refusal> {
    let followed = || {
        let Read { machine, stated, program, part, options, notes, .. } = read(files, request)?;
        let known = (&machine, &stated.with_exact_drives());
        let tell = &mut |done: u64, all: u64| progress(&(done as f64 / all.max(1) as f64).to_string());
        let document = predict_with_servo(known, &program, &part, options, rate_hz, tell)?;
        json(&Predicted { shown: document.shown(), there: document.into(), notes })
    };
    to_js(followed())
}

/// What to measure for a part, where to put it and in which direction to cut: the result with tables and notes, and the text
/// of the task of `calibrate plan`, if one is needed.
#[derive(Serialize)]
struct Advised {
    shown: Shown,
    task: Option<String>,
}

fn advised(files: &str, request: &str, folder: &str) -> Result<String> {
    let Read { machine, stated, program, part, options, more, .. } = read(files, request)?;
    let mut document = evaluate(&machine, &stated, &program, &part, options)?;
    let own = document.shown();
    let name = part.file.display().to_string();
    let task = |file: &str| {
        let [_, text] = beside(&more, &name, file, "task")?;
        Ok(Task::read(text, Path::new(file))?)
    };
    let mut advice = advise(&machine, &stated, &program, &part, &document, &task)?;
    advice.elsewhere = Some(elsewhere(&machine, &stated, &program, &part, &document)?);
    let task = advice.task.as_ref().map(|task| task.text(folder));
    document.advice = Some(advice);
    let mut shown = document.shown();
    // What is said of the part itself is on the page.
    shown.result = shown.result.strip_prefix(&own.result).unwrap_or(&shown.result).trim().to_owned();
    shown.notes.drain(..own.notes.len());
    shown.tables.drain(..own.tables.len());
    json(&Advised { shown, task })
}

/// What to measure for a part with the instruments that its file states: `shown`, `task`. `folder`: that of the machine, as
/// the task names it.
#[wasm_bindgen]
pub fn predict_advise(files: &str, request: &str, folder: &str) -> Result<String, Refusal> {
    to_js(advised(files, request, folder))
}

/// Keeps the part of a request for [`predict_at`]: `range_mm`, the lowest and highest place along X, Y and Z, and `machine_c`.
#[wasm_bindgen]
pub fn predict_keep(files: &str, request: &str) -> Result<String, Refusal> {
    let kept = || {
        let Read { machine, stated, program, part, options, growth, .. } = read(files, request)?;
        let mut live = Live::new(&machine, &stated, &program, &part, options.seed)?;
        if let Some(model) = growth {
            live = live.growing_by(model);
        }
        let kept = Kept { range_mm: live.range_mm()?, machine_c: live.machine_c() };
        LIVE.set(Some(live));
        json(&kept)
    };
    to_js(kept())
}

/// The kept part with its program's zero at another place and the machine at another temperature: `document` without budgets,
/// `used`, `shapes`.
#[wasm_bindgen]
pub fn predict_at(x_mm: f64, y_mm: f64, z_mm: f64, machine_c: Option<f64>) -> Result<String, Refusal> {
    to_js(LIVE.with_borrow(|live| {
        let moved =
            live.as_ref().context("found no part, needed one that was kept")?.at([x_mm, y_mm, z_mm], machine_c)?;
        json(&There::from(moved))
    }))
}

/// The files that a part's file names: its program, or "", then those of its further set-ups, and tasks of instruments.
#[wasm_bindgen]
pub fn predict_files(name: &str, part: &str) -> Result<Vec<String>, Refusal> {
    let named = |part: Part| {
        let setups = part.setups.into_iter().map(|setup| setup.file);
        let tasks = part.instruments.into_iter().filter_map(|of| of.file);
        std::iter::once(part.program.unwrap_or_default()).chain(setups).chain(tasks).collect()
    };
    to_js(Part::read(part, Path::new(name)).map(named).map_err(Into::into))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::sample;
    use serde_json::{Value, json};

    fn request(part: &str, at_mm: Option<[f64; 3]>) -> String {
        let program = include_str!("../../../records/plate/plate.ngc");
        json!({"part": ["part.toml", part], "program": ["plate.ngc", program], "at_mm": at_mm, "trials": 200, "seed": 1})
            .to_string()
    }

    #[test]
    fn a_part_moves_to_where_it_is_predicted_again() {
        let part = include_str!("../../../records/plate/part.toml");
        let files = serde_json::to_string(&sample("mill-3axis").unwrap()).unwrap();
        assert!(predict_at(0.0, 0.0, 0.0, None).is_err());
        let range = predict_keep(&files, &request(part, None)).unwrap();
        let there = [40.0, -90.0, -260.0];
        let moved: Value = serde_json::from_str(&predict_at(there[0], there[1], there[2], None).unwrap()).unwrap();
        let again: Value = serde_json::from_str(&predict(&files, &request(part, Some(there))).unwrap()).unwrap();
        let of = |whole: &Value, key: &str| -> Vec<f64> {
            whole["document"]["features"].as_array().unwrap().iter().map(|of| of[key].as_f64().unwrap()).collect()
        };
        assert_eq!(of(&moved, "corrected_um"), of(&again, "corrected_um"));
        assert_eq!(moved["shapes"][3]["corrected_um"], again["shapes"][3]["corrected_um"]);
        let kept: Value = serde_json::from_str(&range).unwrap();
        let [low, high] = [0, 1].map(|end| kept["range_mm"][0][end].as_f64().unwrap());
        for (x, is_within) in [(low, true), (high, true), (low - 0.1, false), (high + 0.1, false)] {
            assert_eq!(predict_at(x, there[1], there[2], None).is_ok(), is_within, "{x}");
        }
        // 11.5 µm/(m K) over 3 K lengthen 90 mm along X by 3.1 µm: hole 2 from hole 1, which the correction removes again.
        assert_eq!(kept["machine_c"], 20.0);
        let warm: Value = serde_json::from_str(&predict_at(there[0], there[1], there[2], Some(23.0)).unwrap()).unwrap();
        let grown = |key: &str| of(&warm, key)[7] - of(&moved, key)[7];
        assert!((grown("uncorrected_um") - 3.105).abs() < 0.01 && grown("corrected_um").abs() < 0.01);
    }

    #[test]
    fn a_refused_part_names_its_file_and_line() {
        let files = serde_json::to_string(&sample("mill-3axis").unwrap()).unwrap();
        let part = include_str!("../../../records/plate/part.toml").replace("lines = [29, 29]", "lines = [31, 31]");
        let error = predict(&files, &request(&part, None)).unwrap_err().to_string();
        assert!(error.starts_with("part.toml:22: found") && error.contains("needed lines that cut bore"), "{error}");
    }
}
