//! The request that opens a scope.

use crate::files::{Texts, machine_of};
use anyhow::{Context, Result, bail};
use serde::Deserialize;
use std::collections::BTreeMap;
use trueaxis::machine::ErrorModel;
use trueaxis_sim::program::{Program, ReadOptions};
use trueaxis_sim::run::Kind;
use trueaxis_sim::scenario::choose_model;
use trueaxis_sim::{Scenario, Settings};
use trueaxis_tables::Machine;
use trueaxis_tables::text::acts;

/// Folder of the machine among the files of a scenario, and the scenario's own file.
pub(super) const MACHINE_FOLDER: &str = "machine";
pub(super) const SCENARIO_FILE: &str = "scenario.toml";

/// The part program.
#[derive(Clone, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
pub(super) enum ProgramText {
    Builtin {
        builtin: String,
    },
    File {
        name: String,
        text: String,
        /// Texts of the subprograms' files, by name.
        #[serde(default)]
        files: Texts,
    },
}

/// Error model that replaces the machine file's.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Model {
    Nine,
    Volumetric,
}

/// A scenario as texts.
#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Request {
    pub(super) machine: Texts,
    pub(super) program: ProgramText,
    #[serde(default)]
    pub(super) settings: String,
    #[serde(default)]
    pub(super) model: Option<Model>,
    #[serde(default)]
    pub(super) orientation: Option<bool>,
    /// Machines whose tables an exchange can use, by the name in the event.
    #[serde(default)]
    pub(super) exchanges: BTreeMap<String, Texts>,
    /// Names as in [`Kind::name`]; those of [`Kind::of`] if omitted.
    #[serde(default)]
    kinds: Option<Vec<String>>,
}

impl ProgramText {
    /// Name of the file or of the shipped program, and its text.
    pub(super) fn parts(&self) -> Result<(&str, &str)> {
        match self {
            ProgramText::File { name, text, files } => {
                std::iter::once(name).chain(files.keys()).try_for_each(|name| plain("program", name))?;
                Ok((name, text))
            }
            ProgramText::Builtin { builtin } => {
                let text = Program::builtin_text(builtin);
                Ok((builtin, text.with_context(|| format!("program: found no shipped program \"{builtin}\""))?))
            }
        }
    }

    fn read(&self) -> Result<Program> {
        let (name, text) = self.parts()?;
        let (stem, texts) = match self {
            ProgramText::File { files, .. } => {
                let stem = name.rsplit_once('.').map_or(name, |(stem, _)| if stem.is_empty() { name } else { stem });
                (stem, Some(files.clone()))
            }
            ProgramText::Builtin { .. } => (name, None),
        };
        Ok(Program::read(stem, text.as_bytes(), name, &ReadOptions { texts, ..ReadOptions::default() })?)
    }
}

impl Request {
    pub(super) fn parse(text: &str) -> Result<Request> {
        let request: Request = serde_json::from_str(text).context("the scope's request")?;
        request.exchanges.keys().try_for_each(|name| exchange_name(name))?;
        Ok(request)
    }

    /// The scenario; `notes` receives details on how files were read.
    pub(super) fn scenario(&self, notes: &mut Vec<String>) -> Result<Scenario> {
        let settings = Settings::parse(&self.settings, SCENARIO_FILE)?;
        let own = self.machine(&self.machine, notes)?;
        let exchanges = self.exchanges.iter().map(|(name, files)| {
            let machine = self.machine(files, notes).with_context(|| format!("exchange:{name}"))?;
            Ok((name.clone(), machine))
        });
        let exchanges = exchanges.collect::<Result<_>>()?;
        let program = self.program.read()?;
        notes.extend(program.notes.iter().map(|note| format!("program: {note}")));
        Ok(Scenario::new(own, program, settings)?.with_exchanges(exchanges))
    }

    /// A machine with the requested error model.
    pub(super) fn machine(&self, files: &Texts, notes: &mut Vec<String>) -> Result<Machine> {
        let mut machine = machine_of(files, notes)?;
        let model = self.model.map(|model| match model {
            Model::Nine => ErrorModel::Nine,
            Model::Volumetric => ErrorModel::Volumetric,
        });
        choose_model(&mut machine, model, self.orientation)?;
        Ok(machine)
    }

    /// The machines to run, in the order of a report.
    pub(super) fn kinds(&self, machine: &Machine) -> Result<Vec<Kind>> {
        Ok(match &self.kinds {
            Some(names) => Kind::named(names)?,
            None => Kind::of(&machine.settings).to_vec(),
        })
    }
}

/// Checks a name that becomes a folder beside the scenario's other files.
pub(super) fn exchange_name(name: &str) -> Result<()> {
    plain("exchange", name)?;
    if name == MACHINE_FOLDER {
        bail!("exchange: found \"{name}\", which is the machine's own folder, needed another name");
    }
    Ok(())
}

fn plain(what: &str, name: &str) -> Result<()> {
    let bad = |c: char| acts(c) || matches!(c, '/' | '\\' | ':');
    if name.trim().is_empty() || name.starts_with(['.', '-']) || name.contains(bad) {
        bail!("{what}: found \"{}\", needed a plain file name", name.escape_debug());
    }
    Ok(())
}
