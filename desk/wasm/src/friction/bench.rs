//! Shared state of the calls: a record, the friction identified in it, and the running simulation.

use crate::becomes::Becomes;
use crate::files::machine;
use anyhow::{Result, anyhow, ensure};
use serde::{Deserialize, Serialize};
use std::path::Path;
use trueaxis_evaluation::friction::{
    Recording, additions, circles, circles_again, columns, drives, fit, pair, sections, spikes, spikes_again,
};
use trueaxis_evaluation::rows::Rows;
use trueaxis_evaluation::shown::Shown;
use trueaxis_evaluation::simulated::friction::shown;
use trueaxis_metrology::friction::{Identified, Record};
use trueaxis_sim::Settings;
use trueaxis_sim::friction::{Circles, Outcome, Pass, Plane, Recorder, configured};
use trueaxis_sim::run::Kind;
use trueaxis_tables::Additions;
use trueaxis_tables::finding::record_number;

/// Name of a simulated record in error messages, as on the command line.
const SIMULATED: &str = "the recorded circles";

/// State that the module keeps between the calls.
#[derive(Default)]
pub(super) struct Bench {
    recording: Option<Recording>,
    /// Number of a dropped record.
    number: Option<String>,
    found: Option<[Identified; 2]>,
    simulation: Option<Simulation>,
    before: Option<(Pass, Circles, Settings)>,
    after: Option<Pass>,
    /// Whether the record is the one in `before`.
    is_simulated: bool,
}

struct Simulation {
    recorder: Recorder,
    circles: Circles,
    settings: Settings,
    pass: Which,
}

/// Purpose of a pass of the circles.
#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Which {
    /// A record for identifying friction.
    Record,
    /// A comparison, in addition to a dropped record.
    Before,
    /// With the identified friction.
    After,
}

/// A record that was read.
#[derive(Serialize)]
pub(super) struct Read {
    samples: usize,
    period_s: f64,
    notes: Vec<String>,
}

/// Result of the identification.
#[derive(Serialize)]
pub(super) struct Identification {
    shown: Shown,
    /// Largest spike of every axis, recorded and expected, µm.
    largest: Vec<(String, [f64; 2])>,
    /// The settings as TOML.
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
    /// Settings by key, as accepted by `--set`.
    set: Vec<(String, String)>,
}

impl Bench {
    pub(super) fn read(&mut self, name: &str, text: &str, axes: &str) -> Result<Read> {
        let axes = pair(axes).map_err(|error| anyhow!("--axes: {error}"))?;
        let mut notes = Vec::new();
        let rows = Rows::new(text.as_bytes(), Path::new(name), &columns(axes), |note| notes.push(note))?;
        let recording = Recording::read(rows, axes)?;
        let number = Some(record_number(text.as_bytes()));
        *self = Bench { recording: Some(recording), number, ..Bench::default() };
        let record = self.record()?;
        Ok(Read { samples: record.axes[0].command.len(), period_s: record.period_s, notes })
    }

    pub(super) fn recording(&self) -> Result<&Recording> {
        self.recording.as_ref().ok_or_else(|| anyhow!("found no record, needed one that is dropped or simulated"))
    }

    fn record(&self) -> Result<&Record> {
        Ok(&self.recording()?.record)
    }

    fn found(&self) -> Result<&[Identified; 2]> {
        self.found.as_ref().ok_or_else(|| anyhow!("found no fit, needed a record to which one was made"))
    }

    pub(super) fn fit(
        &mut self,
        files: &str,
        find_drive: bool,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Identification> {
        let recording = self.recording()?;
        let mut given = [None; 2];
        if !find_drive {
            let axes = [0, 1].map(|i| recording.record.axes[i].axis);
            given = drives(&machine(files, &mut Vec::new())?, "the machine", axes)?;
        }
        let (found, document) =
            fit(recording, given, &mut |axis, step| progress(&format!("axis {}, step {step}", axis.letter())))?;
        let polars = circles(&recording.record, &recording.file.to_string_lossy(), &found)?;
        let shown = Shown { plots: spikes(&found), polars, ..document.shown() };
        let settings = sections(&recording.file, &found);
        (self.found, self.after) = (Some(found), None);
        let largest = document.axes.iter().map(|own| {
            let size = &own.glitch_um;
            (own.axis.clone(), [size.before.max, size.after.max])
        });
        Ok(Identification { largest: largest.collect(), shown, settings })
    }

    pub(super) fn becomes(&self, files: &str) -> Result<Becomes> {
        Becomes::new(files, &Additions { record: self.number.clone(), ..additions(self.found()?) })
    }

    pub(super) fn start(&mut self, files: &str, request: &str) -> Result<()> {
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

    /// Advances the simulation; returns the fraction done. At 1 the pass is stored.
    pub(super) fn advance(&mut self, cycles: f64) -> Result<f64> {
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

    pub(super) fn simulated_record(&self) -> Result<Read> {
        let record = self.record()?;
        Ok(Read { samples: record.axes[0].command.len(), period_s: record.period_s, notes: Vec::new() })
    }

    pub(super) fn csv(&self) -> Result<String> {
        match &self.before {
            Some((pass, ..)) if self.is_simulated => Ok(pass.csv()),
            _ => Err(anyhow!("found no simulated record, needed one")),
        }
    }

    /// The circles without and with the identified friction; tables of them if the record is the simulation's.
    pub(super) fn closed(&self) -> Result<Shown> {
        let found = self.found()?;
        let (Some((before, own_circles, settings)), Some(after)) = (&self.before, &self.after) else {
            return Err(anyhow!("found no simulation with the figures, needed one without them and one with them"));
        };
        let mut all = Shown::default();
        if self.is_simulated {
            all = shown(&Outcome::new(own_circles, settings, [before, after], found)?, found);
        }
        let records = [before.path()?, after.path()?];
        // The plane's order of axes, which may differ from that of the dropped record.
        let [first, second] = [0, 1].map(|i| found.iter().find(|own| own.axis == records[0].axes[i].axis));
        let (Some(first), Some(second)) = (first, second) else { return Err(anyhow!("{SIMULATED}: other axes")) };
        let found = [first.clone(), second.clone()];
        for (i, own) in found.iter().enumerate() {
            let glitch = |record| own.spikes(record, i).map_err(|refused| anyhow!("{SIMULATED}: {refused}"));
            let [before, after] = records.each_ref().map(glitch);
            all.plots.extend(spikes_again(own.axis, &before?.spikes, &after?.spikes));
        }
        all.polars = circles_again(records.each_ref(), SIMULATED, &found)?;
        Ok(all)
    }
}
