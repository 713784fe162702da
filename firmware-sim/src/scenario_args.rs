//! Arguments of every command that simulates a program, and the scenario built from them.

use crate::machine_arg::read_machine;
use crate::program_args::ProgramArgs;
use crate::settings_args::{ActArgs, SettingsArgs};
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};
use trueaxis::machine::ErrorModel;
use trueaxis_sim::scenario::choose_model;
use trueaxis_sim::{Scenario, SimError};
use trueaxis_tables::Machine;

#[derive(Args)]
pub(crate) struct ScenarioArgs {
    /// Machine: a machine.toml, its folder, or the name of a sample (mill-3axis, mill-5axis, mill-turn).
    #[arg(long, value_name = "M", default_value = "mill-3axis", help_heading = "Machine and program")]
    pub(crate) machine: PathBuf,
    #[command(flatten)]
    pub(crate) program: ProgramArgs,
    /// Error model that the step corrects by [default: the machine file's].
    #[arg(long, value_name = "MODEL", value_enum, help_heading = "Machine and program")]
    model: Option<Model>,
    /// Whether the tool's direction is corrected too, through the rotary axes; only with the volumetric model [default: the
    /// machine file's].
    #[arg(
        long,
        value_name = "on|off",
        value_enum,
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "on",
        help_heading = "Machine and program"
    )]
    orientation: Option<Switch>,
    /// Time a step may take [default: a tenth of the period].
    #[arg(long, value_name = "NS", help_heading = "Machine and program")]
    budget_ns: Option<u64>,
    #[command(flatten)]
    pub(crate) settings: SettingsArgs,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Model {
    /// Nine one-dimensional tables; angular errors have no lever.
    Nine,
    /// All errors of every axis, carried to the tool tip.
    Volumetric,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Switch {
    On,
    Off,
}

impl ScenarioArgs {
    /// All input files other than the machine's.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        self.program.files().chain(self.settings.scenario.as_deref())
    }

    fn choose_model(&self, machine: &mut Machine) -> Result<(), SimError> {
        let model = self.model.map(|model| match model {
            Model::Nine => ErrorModel::Nine,
            Model::Volumetric => ErrorModel::Volumetric,
        });
        choose_model(machine, model, self.orientation.map(|switch| switch == Switch::On))
    }

    /// Time a step may take, ns.
    pub(crate) fn budget_ns(&self, scenario: &Scenario) -> u64 {
        self.budget_ns.unwrap_or((1e8 / scenario.rate_hz()) as u64)
    }
}

/// The scenario of a command that allows no events (switching or exchanging).
pub(crate) fn prepare(args: &ScenarioArgs, faults: &[String]) -> Result<Scenario> {
    let scenario = prepare_with(args, &ActArgs::faults(faults))?;
    match scenario.settings.events.items.first() {
        Some(event) => bail!("--scenario: found the event \"{event}\", needed none for this command"),
        None => Ok(scenario),
    }
}

pub(crate) fn prepare_with(args: &ScenarioArgs, acts: &ActArgs) -> Result<Scenario> {
    let mut settings = args.settings.settings(acts)?;
    let mut machine = read_machine("--machine", &args.machine)?;
    args.choose_model(&mut machine)?;
    let program = args.program.read()?;
    if args.program.offsets.is_some() {
        settings.origin_mm.get_or_insert([0.0; 3]);
    }
    let exchanges = settings.events.exchanges().map(|name| {
        let mut machine = read_machine("exchange", Path::new(name))?;
        args.choose_model(&mut machine)?;
        Ok((name.to_owned(), machine))
    });
    let exchanges = exchanges.collect::<Result<_>>()?;
    Ok(Scenario::new(machine, program, settings)?.with_exchanges(exchanges))
}
