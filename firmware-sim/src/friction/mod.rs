//! `firmware-sim friction`: record circles, identify, configure, record again.

mod circles;
mod outcome;

use crate::console::{progress_bar, put};
use crate::machine_arg::{outputs_of, read_machine};
use crate::settings_args::SettingsArgs;
use anyhow::{Context, Result, anyhow, bail};
use circles::{Circles, Pass, record};
use clap::Args;
use outcome::Outcome;
use std::path::PathBuf;
use trueaxis::Axis;
use trueaxis::machine::DynamicSettings;
use trueaxis_metrology::friction::{Identified, identify};
use trueaxis_sim::run::Kind;
use trueaxis_tables::Machine;

/// The axes of the circles' plane.
const AXES: [Axis; 2] = [Axis::X, Axis::Y];

/// Arguments of `friction`.
#[derive(Args)]
#[command(after_help = "Examples:
  firmware-sim friction                             the sample mill: friction and the drives' figures
  firmware-sim friction --given-drive --json        friction alone, with the figures that the machine states
  firmware-sim friction --record record.csv         the record too; then: trueaxis friction record.csv --axes X,Y")]
pub(crate) struct FrictionArgs {
    /// Machine: a machine.toml, its folder, or the name of a sample (mill-3axis, mill-5axis, mill-turn).
    #[arg(long, value_name = "M", default_value = "mill-3axis")]
    machine: PathBuf,
    /// Radius of the circles, 1 to 1000; no multiple of the encoders' signal period, so that their errors differ from
    /// reversal to reversal.
    #[arg(long, value_name = "MM", default_value_t = 25.0037, allow_negative_numbers = true)]
    radius_mm: f64,
    /// The two feeds, mm/min, 10 to 20000.
    #[arg(long, value_name = "F,F", value_delimiter = ',', default_values_t = [1500.0, 600.0], allow_negative_numbers = true)]
    feeds: Vec<f64>,
    /// Whole turns of every circle, 1 to 20.
    #[arg(long, value_name = "N", default_value_t = 1)]
    turns: u32,
    /// Take the drives' figures that the machine states, instead of finding them too.
    #[arg(long)]
    given_drive: bool,
    /// Write the first record, for `trueaxis friction`.
    #[arg(long, value_name = "RECORD.csv")]
    record: Option<PathBuf>,
    /// Print one JSON document and nothing else.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    settings: SettingsArgs,
}

pub(crate) fn friction(args: &FrictionArgs) -> Result<()> {
    let circles = circles(args)?;
    let settings = args.settings.settings(&[])?;
    let machine = read_machine("--machine", &args.machine)?;
    let mut outputs = outputs_of([args.machine.as_path()], args.settings.scenario.as_deref());
    if let Some(file) = &args.record {
        outputs.refuse_input(file)?;
    }
    let stated = AXES.map(|axis| machine.settings.axis(axis).and_then(|own| own.servo.drive));
    let given = if args.given_drive { stated } else { [None; 2] };

    let bar = progress_bar("recording");
    let mut told = |fraction: f64| bar.set_position((1000.0 * fraction) as u64);
    let before = record(&circles, machine.clone(), settings.clone(), Kind::Compensated, &mut told)?;
    if let Some(file) = &args.record {
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
    let configured = configured(machine, &found);
    let after = record(&circles, configured, settings.clone(), Kind::Configured, &mut told)
        .context("with the friction that was found")?;
    bar.finish_and_clear();

    let outcome = Outcome::new(&circles, &settings, [&before, &after], &found)?;
    if args.json { put(&format!("{}\n", serde_json::to_string_pretty(&outcome)?)) } else { put(&outcome.to_string()) }
}

fn circles(args: &FrictionArgs) -> Result<Circles> {
    if !(1.0..=1000.0).contains(&args.radius_mm) {
        bail!("--radius-mm: found {}, needed 1 to 1000", args.radius_mm);
    }
    let Ok(feeds) = <[f64; 2]>::try_from(args.feeds.as_slice()) else {
        bail!("--feeds: found {} feeds, needed two", args.feeds.len());
    };
    if let Some(feed) = feeds.into_iter().find(|feed| !(10.0..=20_000.0).contains(feed)) {
        bail!("--feeds: found {feed}, needed 10 to 20000 mm/min");
    }
    if !(1..=20).contains(&args.turns) {
        bail!("--turns: found {}, needed 1 to 20", args.turns);
    }
    Ok(Circles { radius_mm: args.radius_mm, feeds_mm_per_min: feeds, turns: args.turns })
}

/// The machine with what was found, and nothing else that acts on the servo.
fn configured(mut machine: Machine, found: &[Identified; 2]) -> Machine {
    for own in &mut machine.settings.axes {
        let identified = found.iter().find(|found| found.axis == own.axis);
        own.servo.friction = identified.map(|found| found.friction);
        if let Some(found) = identified {
            own.servo.drive = Some(found.drive);
        }
        let limits = own.servo.dynamic.unwrap_or(DynamicSettings::with_defaults(own.axis)).limits;
        own.servo.dynamic =
            identified.map(|_| DynamicSettings { limits, lag: false, acceleration: false, take_up: false });
    }
    machine.settings.contour.feedback = None;
    machine.settings.crosstalk.clear();
    machine
}

/// Two passes of the same circles.
type Passes<'p> = [&'p Pass; 2];
