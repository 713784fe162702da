//! Friction of two axes: a record, dropped or simulated, what is found in it, and the circles run again with it.
//!
//! A record and what was found stay in the module between the calls; a simulation goes on in slices.

use crate::files::machine;
use crate::{json, told};
use anyhow::{Result, anyhow, ensure};
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::path::Path;
use trueaxis_evaluation::friction::{
    CircleCurves, Document, Recording, SpikeCurves, circles, columns, drives, fit, merged, pair, sections, spikes,
};
use trueaxis_evaluation::rows::Rows;
use trueaxis_metrology::friction::{Identified, Record};
use trueaxis_sim::Settings;
use trueaxis_sim::friction::{Circles, Outcome, Pass, Plane, Recorder, configured};
use trueaxis_sim::run::Kind;
use wasm_bindgen::prelude::*;

/// How the errors name a simulated record, as on the command line.
const SIMULATED: &str = "the recorded circles";

#[wasm_bindgen]
extern "C" {
    /// The worker's: told how far a call under way has come.
    #[wasm_bindgen(js_name = trueaxisProgress)]
    fn progress(what: &str);
}

/// What is kept between the calls.
#[derive(Default)]
struct Bench {
    recording: Option<Recording>,
    found: Option<[Identified; 2]>,
    simulation: Option<Simulation>,
    before: Option<(Pass, Circles, Settings)>,
    after: Option<Pass>,
    /// Whether the record is that of `before`.
    is_simulated: bool,
}

struct Simulation {
    recorder: Recorder,
    circles: Circles,
    settings: Settings,
    pass: Which,
}

/// What a pass of the circles is for.
#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Which {
    /// To find friction in.
    Record,
    /// To compare with, beside a record that was dropped.
    Before,
    /// With what was found.
    After,
}

thread_local! {
    static BENCH: RefCell<Bench> = RefCell::default();
}

fn with<T>(user: impl FnOnce(&mut Bench) -> Result<T>) -> Result<T, JsError> {
    told(BENCH.with_borrow_mut(user))
}

/// A record that was read.
#[derive(Serialize)]
struct Read {
    samples: usize,
    period_s: f64,
    notes: Vec<String>,
}

/// What was found.
#[derive(Serialize)]
struct Found {
    document: Document,
    spikes: Vec<SpikeCurves>,
    circles: Vec<CircleCurves>,
    /// As TOML.
    settings: String,
}

/// The circles to simulate.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Simulated {
    pass: Which,
    plane: String,
    radius_mm: f64,
    feeds_mm_per_min: Vec<f64>,
    turns: u32,
    /// Settings by key, as `--set` takes them.
    set: Vec<(String, String)>,
}

/// The circles without and with what was found.
#[derive(Serialize)]
struct Closed {
    /// Where the record is that of the simulation.
    outcome: Option<Outcome>,
    before: Curves,
    after: Curves,
}

#[derive(Serialize)]
struct Curves {
    spikes: Vec<SpikeCurves>,
    circles: Vec<CircleCurves>,
}

impl Bench {
    fn read(&mut self, name: &str, text: &str, axes: &str) -> Result<Read> {
        let axes = pair(axes).map_err(|error| anyhow!("--axes: {error}"))?;
        let mut notes = Vec::new();
        let rows = Rows::new(text.as_bytes(), Path::new(name), &columns(axes), |note| notes.push(note))?;
        let recording = Recording::read(rows, axes)?;
        *self = Bench { recording: Some(recording), ..Bench::default() };
        let record = self.record()?;
        Ok(Read { samples: record.axes[0].command.len(), period_s: record.period_s, notes })
    }

    fn recording(&self) -> Result<&Recording> {
        self.recording.as_ref().ok_or_else(|| anyhow!("found no record, needed one that is dropped or simulated"))
    }

    fn record(&self) -> Result<&Record> {
        Ok(&self.recording()?.record)
    }

    fn found(&self) -> Result<&[Identified; 2]> {
        self.found.as_ref().ok_or_else(|| anyhow!("found no fit, needed a record to which one was made"))
    }

    fn fit(&mut self, files: &str, find_drive: bool, tell: &mut dyn FnMut(&str)) -> Result<Found> {
        let recording = self.recording()?;
        let mut given = [None; 2];
        if !find_drive {
            let axes = [0, 1].map(|i| recording.record.axes[i].axis);
            given = drives(&machine(files, &mut Vec::new())?, "the machine", axes)?;
        }
        let (found, document) =
            fit(recording, given, &mut |axis, step| tell(&format!("axis {}, step {step}", axis.letter())))?;
        let spikes = found.iter().flat_map(|own| spikes(own, &own.glitch)).collect();
        let circles = circles(&recording.record, &recording.file.to_string_lossy(), &found)?;
        let settings = sections(&recording.file, &found);
        (self.found, self.after) = (Some(found), None);
        Ok(Found { document, spikes, circles, settings })
    }

    fn start(&mut self, files: &str, request: &str) -> Result<()> {
        let request: Simulated = serde_json::from_str(request)?;
        let plane = Plane::named(&request.plane)
            .ok_or_else(|| anyhow!("plane: found {}, needed XY, ZX or YZ", request.plane))?;
        let circles = Circles::new(plane, request.radius_mm, &request.feeds_mm_per_min, request.turns)?;
        let mut settings = Settings::default();
        for (key, value) in &request.set {
            settings.set(key, value).map_err(|error| anyhow!("--set {key}={value}: {error}"))?;
        }
        let mut machine = machine(files, &mut Vec::new())?;
        let mut kind = Kind::Compensated;
        if request.pass != Which::Record {
            let found = self.found()?;
            ensure!(
                circles.axes().iter().all(|axis| found.iter().any(|own| own.axis == *axis)),
                "plane: found {}, needed that of the record's axes {} and {}",
                request.plane,
                found[0].axis.letter(),
                found[1].axis.letter()
            );
        }
        if request.pass == Which::After {
            (machine, kind) = (configured(machine, self.found()?), Kind::Configured);
        }
        let recorder = Recorder::new(&circles, machine, settings.clone(), kind)?;
        self.simulation = Some(Simulation { recorder, circles, settings, pass: request.pass });
        Ok(())
    }

    /// Share that has been simulated; at 1 the pass is kept.
    fn advance(&mut self, cycles: f64) -> Result<f64> {
        let simulation = self.simulation.as_mut().ok_or_else(|| anyhow!("found no simulation, needed one begun"))?;
        if simulation.recorder.advance(cycles as u64) {
            return Ok(simulation.recorder.progress().min(1.0 - f64::EPSILON));
        }
        if let Some(Simulation { recorder, circles, settings, pass: which }) = self.simulation.take() {
            let pass = recorder.finish();
            match which {
                Which::Record => {
                    let recording = Recording { file: SIMULATED.into(), record: pass.sent()? };
                    *self = Bench {
                        recording: Some(recording),
                        before: Some((pass, circles, settings)),
                        is_simulated: true,
                        ..Bench::default()
                    };
                }
                Which::Before => self.before = Some((pass, circles, settings)),
                Which::After => self.after = Some(pass),
            }
        }
        Ok(1.0)
    }

    fn simulated_record(&self) -> Result<Read> {
        let record = self.record()?;
        Ok(Read { samples: record.axes[0].command.len(), period_s: record.period_s, notes: Vec::new() })
    }

    fn csv(&self) -> Result<String> {
        match &self.before {
            Some((pass, ..)) if self.is_simulated => Ok(pass.csv()),
            _ => Err(anyhow!("found no simulated record, needed one")),
        }
    }

    fn closed(&self) -> Result<Closed> {
        let found = self.found()?;
        let (Some((before, own_circles, settings)), Some(after)) = (&self.before, &self.after) else {
            return Err(anyhow!("found no simulation with the figures, needed one without them and one with them"));
        };
        let outcome = match self.is_simulated {
            true => Some(Outcome::new(own_circles, settings, [before, after], found)?),
            false => None,
        };
        let curves = |pass: &Pass| -> Result<Curves> {
            let record = pass.path()?;
            // The plane's order, which need not be that of the record that was dropped.
            let [first, second] = [0, 1].map(|i| found.iter().find(|own| own.axis == record.axes[i].axis));
            let (Some(first), Some(second)) = (first, second) else { return Err(anyhow!("{SIMULATED}: other axes")) };
            let found = [first.clone(), second.clone()];
            let mut all = Vec::new();
            for (i, own) in found.iter().enumerate() {
                let glitch = own.spikes(&record, i).map_err(|refused| anyhow!("{SIMULATED}: {refused}"))?;
                all.extend(spikes(own, &glitch));
            }
            Ok(Curves { spikes: all, circles: circles(&record, SIMULATED, &found)? })
        };
        Ok(Closed { outcome, before: curves(before)?, after: curves(after)? })
    }
}

/// Reads a record of `axes` (`X,Y`): samples, period, notes. Found before is forgotten.
#[wasm_bindgen]
pub fn friction_read(name: &str, text: &str, axes: &str) -> Result<String, JsError> {
    with(|bench| json(&bench.read(name, text, axes)?))
}

/// The simulator's settings unless others are given.
#[wasm_bindgen]
pub fn friction_settings() -> Result<String, JsError> {
    told(json(&Settings::default()))
}

/// Begins to simulate circles on a machine; its record or the comparison without or with what was found.
#[wasm_bindgen]
pub fn friction_start(files: &str, request: &str) -> Result<(), JsError> {
    with(|bench| bench.start(files, request))
}

/// Simulates some cycles further: the share that is done, 1 at the end.
#[wasm_bindgen]
pub fn friction_advance(cycles: f64) -> Result<f64, JsError> {
    with(|bench| bench.advance(cycles))
}

/// The record at hand: samples, period.
#[wasm_bindgen]
pub fn friction_record() -> Result<String, JsError> {
    with(|bench| json(&bench.simulated_record()?))
}

/// Following errors of the record for drawing.
#[wasm_bindgen]
pub fn friction_trace(points: usize) -> Result<String, JsError> {
    with(|bench| json(&bench.recording()?.trace(points)))
}

/// The simulated record as CSV.
#[wasm_bindgen]
pub fn friction_csv() -> Result<String, JsError> {
    with(|bench| bench.csv())
}

/// Finds friction, and the drives where the machine does not state them or `find_drive` asks for it: the command line's
/// document, spikes, circles, settings as TOML.
#[wasm_bindgen]
pub fn friction_fit(files: &str, find_drive: bool) -> Result<String, JsError> {
    with(|bench| json(&bench.fit(files, find_drive, &mut progress)?))
}

/// The simulated circles without and with what was found.
#[wasm_bindgen]
pub fn friction_closed() -> Result<String, JsError> {
    with(|bench| json(&bench.closed()?))
}

/// A `machine.toml` with settings in it.
#[wasm_bindgen]
pub fn friction_merged(machine_toml: &str, settings: &str) -> Result<String, JsError> {
    told(merged(machine_toml, Path::new("machine.toml"), settings))
}
