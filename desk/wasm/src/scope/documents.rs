//! A scope's description of its run.

use super::request::{MACHINE_FOLDER, Model, ProgramText, SCENARIO_FILE};
use super::session::Session;
use anyhow::Result;
use serde::Serialize;
use std::collections::BTreeMap;
use trueaxis::machine::{AxisSettings, DynamicSettings};
use trueaxis_sim::program::{BUILTIN_NAMES, Program};
use trueaxis_sim::run::{CorrectionLimits, Kind};

/// A shipped program.
#[derive(Serialize)]
pub(super) struct Shipped {
    name: &'static str,
    description: &'static str,
    text: &'static str,
}

/// The shipped programs, the default one first.
pub(super) fn programs() -> Vec<Shipped> {
    let shipped = |name| {
        let (description, text) = (Program::builtin_description(name)?, Program::builtin_text(name)?);
        Some(Shipped { name, description, text })
    };
    BUILTIN_NAMES.into_iter().filter_map(shipped).collect()
}

/// An axis of the machine.
#[derive(Serialize)]
struct Axis {
    axis: char,
    rotary: bool,
    /// Units of position, of the correction and of its derivatives.
    position_unit: &'static str,
    unit: &'static str,
    slope_unit: &'static str,
    acceleration_unit: &'static str,
    travel: [f64; 2],
    /// Limits of the correction by the tables now in force.
    limits: CorrectionLimits,
    /// Limits of the dynamic correction, on a machine that has one.
    dynamic_limits: Option<CorrectionLimits>,
}

/// Description of a scenario.
#[derive(Serialize)]
pub(super) struct Description {
    machine: String,
    chain: String,
    program: String,
    cycles: u64,
    period_s: f64,
    five_axis: bool,
    kinds: Vec<&'static str>,
    axes: Vec<Axis>,
    /// The program's lines; the first is number 1.
    lines: Vec<String>,
    /// Settings that differ from the default: key, value, default.
    settings: Vec<(String, String, String)>,
    notes: Vec<String>,
}

impl Session {
    pub(super) fn describe(&self) -> Result<Description> {
        let scenario = &self.scenario;
        let machine = &scenario.machine.settings;
        let exchanged = self.exchanged.as_ref().and_then(|name| scenario.exchanges.get(name));
        let in_force = exchanged.map_or(machine, |machine| &machine.settings);
        let axis = |own: &AxisSettings| {
            let rotary = own.axis.is_rotary();
            let unit = |linear, angular| if rotary { angular } else { linear };
            let now = in_force.axis(own.axis).unwrap_or(own);
            let dynamic = now.servo.dynamic.unwrap_or_else(|| DynamicSettings::with_defaults(own.axis)).limits;
            let dynamic = AxisSettings { limits: dynamic, ..*now };
            Axis {
                axis: own.axis.letter(),
                rotary,
                position_unit: unit("mm", "°"),
                unit: unit("µm", "µrad"),
                slope_unit: unit("mm/s", "mrad/s"),
                acceleration_unit: unit("m/s²", "rad/s²"),
                travel: own.travel,
                limits: CorrectionLimits::of(now),
                dynamic_limits: self.kinds.contains(&Kind::Full).then(|| CorrectionLimits::of(&dynamic)),
            }
        };
        let mut axes: Vec<Axis> = machine.axes.iter().map(axis).collect();
        axes.sort_by_key(|axis| (axis.rotary, axis.axis));
        let (_, text) = self.request.program.parts()?;
        Ok(Description {
            machine: machine.name.as_str().into(),
            chain: machine.chain.as_str().into(),
            program: scenario.program.name.clone(),
            cycles: self.cycles(),
            period_s: scenario.period_s(),
            five_axis: scenario.five_axis,
            kinds: self.kinds.iter().map(|kind| kind.name()).collect(),
            axes,
            lines: text.lines().map(String::from).collect(),
            settings: self.settings.changes(),
            notes: self.notes.clone(),
        })
    }

    /// The scenario with all acts, for repeating the run elsewhere.
    pub(super) fn reproduction(&self) -> Result<Reproduction> {
        let request = &self.request;
        let mut files = BTreeMap::new();
        let folders = request.exchanges.iter().map(|(name, texts)| (name.as_str(), texts));
        for (folder, texts) in folders.chain([(MACHINE_FOLDER, &request.machine)]) {
            files.extend(texts.iter().map(|(name, text)| (format!("{folder}/{name}"), text.clone())));
        }
        let (program, text) = request.program.parts()?;
        if let ProgramText::File { files: beside, .. } = &request.program {
            files.extend(beside.clone());
            files.insert(program.to_owned(), text.to_owned());
        }
        let toml = self.settings.to_toml();
        files.insert(SCENARIO_FILE.to_owned(), toml.clone());
        let mut command = format!(
            "firmware-sim run --machine {MACHINE_FOLDER} --program {} --scenario {SCENARIO_FILE}",
            quoted(program)
        );
        match request.model {
            Some(Model::Nine) => command += " --model nine",
            Some(Model::Volumetric) => command += " --model volumetric",
            None => {}
        }
        if let Some(orientation) = request.orientation {
            command += if orientation { " --orientation=on" } else { " --orientation=off" };
        }
        Ok(Reproduction { toml, command, files })
    }
}

/// A scenario as files, and the command that runs them.
#[derive(Serialize)]
pub(super) struct Reproduction {
    toml: String,
    command: String,
    /// Texts by the paths that the command names.
    files: BTreeMap<String, String>,
}

/// A word quoted for a shell.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '-');
    if word.chars().all(plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}
