//! `… simulate`: what the rehearsals of all commands share.

use crate::model;
use crate::numbers::{Numbers, number, one_or_triple};
use crate::output::{data, report_line};
use crate::{machine_folder, model::machine as read_machine};
use anyhow::{Context, Result, bail};
use clap::{ArgMatches, Args, Command, FromArgMatches};
use std::path::{Path, PathBuf};
use trueaxis_evaluation::simulated::rehearsal::{Conditions, Drift, Instrument, drawn, is_stated, truth_of};
use trueaxis_tables::Machine;
use trueaxis_tables::formats::machine_files;
use trueaxis_tables::output::Outputs;
use trueaxis_tables::text::counted;
use trueaxis_tables::uncertainty::Uncertainties;

/// A command that evaluates a record, and has the subcommand `simulate` that writes one.
pub(crate) enum OrSimulate<E, S> {
    Evaluate(E),
    Simulate(S),
}

/// Arguments of a subcommand `simulate`, and its help.
pub(crate) trait Rehearsal: Args {
    /// One sentence.
    const ABOUT: &'static str;
    /// Before the options.
    const EXAMPLE: &'static str;
    /// After them.
    const HELP: &'static str;
}

/// Name of the subcommand.
const SIMULATE: &str = "simulate";

impl<E: Args, S: Rehearsal> FromArgMatches for OrSimulate<E, S> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        match matches.subcommand() {
            Some((SIMULATE, matches)) => S::from_arg_matches(matches).map(OrSimulate::Simulate),
            _ => E::from_arg_matches(matches).map(OrSimulate::Evaluate),
        }
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

// A derived `Option` of flattened arguments beside an `Option` of a subcommand is `None` for a plain record.
impl<E: Args, S: Rehearsal> Args for OrSimulate<E, S> {
    fn augment_args(command: Command) -> Command {
        let simulate = Command::new(SIMULATE).before_help(S::EXAMPLE).after_help(S::HELP);
        E::augment_args(command)
            .subcommand(S::augment_args(simulate).about(S::ABOUT))
            .args_conflicts_with_subcommands(true)
            .subcommand_negates_reqs(true)
            .disable_help_subcommand(true)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// The true machine.
#[derive(Args)]
pub(crate) struct Truth {
    /// Machine whose tables are the true errors [default: the task's machine, errors drawn within its uncertainties].
    #[arg(long, value_name = "TRUE", help_heading = "True machine")]
    machine: Option<PathBuf>,
    /// Also write the true machine into a folder without a machine.toml.
    #[arg(long, value_name = "DIR", help_heading = "True machine")]
    save_true: Option<PathBuf>,
}

impl Truth {
    /// The true machine of a task whose own machine is `known`, read from `path`.
    pub(crate) fn machine(&self, path: &Path, known: &Machine, conditions: &Conditions) -> Result<Machine> {
        if let Some(path) = &self.machine {
            let truth = read_machine(path)?;
            return truth_of(known, &truth).with_context(|| format!("--machine {}", path.display()));
        }
        let named = || path.display().to_string();
        let stated = Uncertainties::read(path)?;
        if !is_stated(&stated) {
            bail!(
                "{}: found no uncertainty to draw the true errors from, needed [uncertainty.location] or \
                 [axis.X.uncertainty] there, or --machine TRUE",
                named()
            );
        }
        drawn(known, &stated, conditions).with_context(named)
    }

    /// Files that are read: those of the task's machine at `path`, and of the true one.
    pub(crate) fn inputs(&self, path: &Path) -> Vec<PathBuf> {
        let truth = self.machine.iter().flat_map(|truth| model::files(truth));
        model::files(path).into_iter().chain(truth).collect()
    }

    /// Stages the true machine if asked; returns the notes to print once it is written.
    pub(crate) fn save(&self, outputs: &mut Outputs, truth: &Machine) -> Result<Vec<String>> {
        let Some(folder) = &self.save_true else { return Ok(Vec::new()) };
        outputs.folder(folder)?;
        let files = machine_files(truth, "The true machine of a rehearsal.");
        machine_folder::whole(outputs, folder, &files).map_err(|wrong| wrong.context("--save-true"))
    }
}

/// Noise and drift.
#[derive(Args)]
pub(crate) struct Disturbances {
    /// Standard deviation of a reading [default: the task's repeatability; of an instrument 0.1].
    #[arg(long, value_name = "U", value_parser = number, allow_hyphen_values = true, help_heading = "Disturbances")]
    noise_um: Option<f64>,
    /// Drift of the workpiece from the tool: X,Y,Z, or its size in a direction drawn from the seed [default: none].
    #[arg(
        long,
        value_name = "R|X,Y,Z",
        value_parser = one_or_triple,
        allow_hyphen_values = true,
        help_heading = "Disturbances"
    )]
    drift_um_per_h: Option<Numbers>,
    /// Seed; the same seed gives the same file.
    #[arg(long, value_name = "SEED", default_value_t = 1, help_heading = "Disturbances")]
    seed: u64,
}

impl Disturbances {
    /// Noise alone.
    pub(crate) fn of(noise_um: Option<f64>, seed: u64) -> Disturbances {
        Disturbances { noise_um, drift_um_per_h: None, seed }
    }

    /// The conditions in a set-up; without its number, the seed's.
    pub(crate) fn conditions(&self, set_up: Option<u64>) -> Result<Conditions> {
        let drift = match self.drift_um_per_h.as_deref() {
            Some(&[x, y, z]) => Drift::Along([x, y, z]),
            Some(&[size]) => Drift::Size(size),
            _ => Drift::Size(0.0),
        };
        let set_up = set_up.unwrap_or(self.seed);
        let conditions = Conditions { noise_um: self.noise_um, drift, seed: self.seed, set_up };
        conditions.check().map_err(|wrong| wrong.option())?;
        Ok(conditions)
    }
}

/// A machine under an instrument, and the record to write.
#[derive(Args)]
pub(crate) struct OnMachine {
    /// Machine whose tables are the true errors.
    #[arg(long, value_name = "TRUE", help_heading = "True machine")]
    machine: PathBuf,
    /// Machine whose tables correct it during the test [default: it is not corrected].
    #[arg(long, value_name = "KNOWN", help_heading = "True machine")]
    corrected_by: Option<PathBuf>,
    #[command(flatten)]
    disturbances: Disturbances,
    /// The record [default: standard output].
    #[arg(short, long, value_name = "RECORD")]
    output: Option<PathBuf>,
}

impl OnMachine {
    /// Writes the record that `record` makes on the machine.
    pub(crate) fn write(&self, record: impl FnOnce(&Instrument<'_>) -> Result<String>) -> Result<()> {
        let conditions = self.disturbances.conditions(None)?;
        let truth = read_machine(&self.machine)?;
        let known = self.corrected_by.as_deref().map(read_machine).transpose()?;
        let on = || format!("--machine {}", self.machine.display());
        let instrument = Instrument::new(&truth, known.as_ref(), conditions).with_context(|| {
            format!("--corrected-by {}", self.corrected_by.as_deref().unwrap_or(Path::new("")).display())
        })?;
        let text = record(&instrument).with_context(on)?;
        let machines = [&self.machine].into_iter().chain(&self.corrected_by);
        let outputs = Outputs::of(machines.flat_map(|machine| model::files(machine)));
        write(outputs, self.output.as_deref(), &text, &[])
    }
}

/// Writes a record with everything staged beside it, and prints the notes.
pub(crate) fn write(mut outputs: Outputs, file: Option<&Path>, text: &str, notes: &[String]) -> Result<()> {
    if let Some(file) = file {
        outputs.put(file, text.as_bytes())?;
    }
    outputs.commit()?;
    match file {
        None => data(text)?,
        Some(file) => {
            report_line(format_args!("written {}: {}", file.display(), counted(text.lines().count(), "line")))
        }
    }
    machine_folder::print_notes(notes);
    Ok(())
}
