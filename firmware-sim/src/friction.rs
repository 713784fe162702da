//! `firmware-sim friction`: record circles, identify, configure, record again.

use crate::console::{progress_bar, put};
use crate::machine_arg::{outputs_of, read_machine};
use crate::settings_args::{ActArgs, SettingsArgs};
use anyhow::{Context, Result, anyhow};
use clap::{Args, ValueEnum};
use indicatif::ProgressBar;
use std::path::PathBuf;
use trueaxis_evaluation::simulated::friction::shown;
use trueaxis_metrology::friction::identify;
use trueaxis_sim::SimError;
use trueaxis_sim::friction::{Circles, Outcome, Pass, Recorder, configured};
use trueaxis_sim::run::Kind;

/// Cycles between two updates of the progress bar.
const STRETCH: u64 = 4096;

const HELP: &str = "\
The circles have two feeds, each in both directions, and the encoders their subdivisional error, noise and counts. \
Geometry is corrected in both records; of the dynamic parts only friction is on in the second.

More examples:
  # Friction alone, with the drives' figures that the machine states:
  firmware-sim friction --given-drive --json
  # The record, on the bench:
  firmware-sim friction -o record.csv
  trueaxis friction record.csv --axes X,Y";

/// Arguments of `friction`.
#[derive(Args)]
#[command(before_help = "Example:\n  firmware-sim friction", after_help = HELP)]
pub(crate) struct FrictionArgs {
    /// Machine: a machine.toml, its folder, or the name of a sample (mill-3axis, mill-5axis, mill-turn).
    #[arg(long, value_name = "M", default_value = "mill-3axis")]
    machine: PathBuf,
    /// Radius of the circles, 1 to 1000; not a multiple of the encoders' signal period, so that their errors differ from
    /// reversal to reversal.
    #[arg(long, value_name = "MM", default_value_t = 25.0037, allow_negative_numbers = true)]
    radius_mm: f64,
    /// The two feeds, mm/min, 10 to 20000.
    #[arg(long, value_name = "F,F", value_delimiter = ',', default_values_t = [1500.0, 600.0], allow_negative_numbers = true)]
    feeds: Vec<f64>,
    /// Plane of the circles.
    #[arg(long, value_enum, ignore_case = true, default_value_t = Plane::Xy)]
    plane: Plane,
    /// Whole turns of every circle, 1 to 20.
    #[arg(long, value_name = "N", default_value_t = 1)]
    turns: u32,
    /// Use the drives' figures that the machine states, instead of finding them too.
    #[arg(long)]
    given_drive: bool,
    /// Write the first record, for `trueaxis friction`.
    #[arg(short, long, alias = "record", value_name = "RECORD.csv")]
    output: Option<PathBuf>,
    /// Print one JSON document and nothing else.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    settings: SettingsArgs,
}

#[derive(Clone, Copy, ValueEnum)]
enum Plane {
    #[value(name = "XY")]
    Xy,
    #[value(name = "ZX")]
    Zx,
    #[value(name = "YZ")]
    Yz,
}

pub(crate) fn friction(args: &FrictionArgs) -> Result<()> {
    let circles = circles(args)?;
    let settings = args.settings.settings(&ActArgs::default())?;
    let machine = read_machine("--machine", &args.machine)?;
    let mut outputs = outputs_of([args.machine.as_path()], args.settings.scenario.as_deref());
    if let Some(file) = &args.output {
        outputs.refuse_input(file)?;
    }
    let stated = circles.axes().map(|axis| machine.settings.axis(axis).and_then(|own| own.servo.drive));
    let given = if args.given_drive { stated } else { [None; 2] };

    let bar = progress_bar("recording");
    let before = recorded(Recorder::new(&circles, machine.clone(), settings.clone(), Kind::Compensated)?, &bar);
    if let Some(file) = &args.output {
        outputs.put(file, before.csv().as_bytes())?;
        outputs.commit()?;
    }
    let first = before.sent()?;
    let found = identify(&first, given, &mut |axis, step| {
        bar.set_message(format!("fitting axis {}, step {step}", axis.letter()));
        bar.tick();
    })
    .map_err(|refused| anyhow!("the recorded circles: {refused}"))?;
    bar.set_message("recording again");
    let again = Recorder::new(&circles, configured(machine, &found), settings.clone(), Kind::Configured);
    let after = recorded(again.context("with the friction found")?, &bar);
    bar.finish_and_clear();

    let outcome = Outcome::new(&circles, &settings, [&before, &after], &found)?;
    if args.json { put(&trueaxis_evaluation::json::pretty(&outcome)?) } else { put(&shown(&outcome, &found).text()) }
}

fn circles(args: &FrictionArgs) -> Result<Circles> {
    let plane = match args.plane {
        Plane::Xy => trueaxis_sim::friction::Plane::Xy,
        Plane::Zx => trueaxis_sim::friction::Plane::Zx,
        Plane::Yz => trueaxis_sim::friction::Plane::Yz,
    };
    Circles::new(plane, args.radius_mm, &args.feeds, args.turns).map_err(|error| match error {
        SimError::Unsuited { what, found, needed } => {
            anyhow!("--{}: found {found}, needed {needed}", what.replace('_', "-"))
        }
        error => error.into(),
    })
}

fn recorded(mut recorder: Recorder, bar: &ProgressBar) -> Pass {
    while recorder.advance(STRETCH) {
        bar.set_position((1000.0 * recorder.progress()) as u64);
    }
    recorder.finish()
}
