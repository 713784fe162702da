//! `trueaxis friction`.

mod simulate;

use crate::machine_folder::{self, Writing};
use crate::output::{print, progress};
use crate::simulate::OrSimulate;
use crate::{csv_in, model, report};
use anyhow::Result;
use clap::Args;
use std::path::{Path, PathBuf};
use trueaxis::Axis;
use trueaxis::machine::DriveFigures;
use trueaxis_evaluation::friction::{self, Recording};
use trueaxis_evaluation::shown::Shown;
use trueaxis_tables::output::Outputs;

pub(crate) const EXAMPLE: &str = "\
Example:
  firmware-sim friction -o record.csv
  trueaxis friction record.csv --axes X,Y";

pub(crate) const HELP: &str = "\
RECORD.csv has the column t_s and for each axis the command sent to its drive and the reading of its encoder, \
x_cmd_mm,x_mm,y_cmd_mm,y_mm, sampled together at an even 500 Hz or more. It has circles of two radii or at two \
feeds, in both directions, whole turns. The record starts at rest and stops between the circles. Radii that are not \
multiples of the encoder's signal period work best.

The model:
  r = K_v (c − x) + k_ff c'
  v' = K_vp (r − v + 1/τ ∫(r − v) dt) − F − d v
  F = F_c (1 + s/(1 + (v/v_s)²)) f
  f' = (v − |v| f)/z
Its following error along the recorded commands is fitted to the recorded one: F_c/K_vp, s, v_s, z, d/K_vp, and K_v, \
K_vp, τ, k_ff if --machine does not state them. A share, velocity or viscous friction that the record does not \
determine stays at 0, 2 mm/s, 0.

The time in its cycle at which the encoder is read is found if the drive's figures are given. If they are found too, \
it acts like velocity feed-forward, and the uncertainties hold for every reading within half a cycle of its command. \
--read-after-us states it: an encoder read at the end of a cycle of 1 ms has 1000 if commands go evenly to the next, \
500 if they are held.

--find-resonance fits a second mass to the readings around reversals, starts and stops: the frequency of motor and load \
against each other (both free) and its damping, resonance_hz and resonance_damping of [axis.X.drive]. The closed loops \
ring at another frequency and with more damping. A record that shows no resonance does not exclude one.

-o friction.toml writes the sections [axis.X.friction] and, if they were found, [axis.X.drive] of a machine.toml, \
with uncertainties, to read. -o MACHINE_DIR writes the machine of --machine, in its own folder or another one with \
a copy of it. An axis' friction and the drive found with it belong together: all are written if one of them differs \
from its stated value by more than two combined standard uncertainties, or if no value or no uncertainty is stated; \
if all agree, their means with one weight are written; nothing is written if the spikes do not fit.

More examples:
  # A rehearsal, see its own help:
  trueaxis friction simulate --machine mymill --axes X,Y -o record.csv
  trueaxis friction record.csv --axes X,Y --report out -o friction.toml
  trueaxis friction record.csv --axes X,Y --machine mymill -o mymill";

/// A record to evaluate, or the rehearsal.
pub(crate) type Friction = OrSimulate<FrictionArgs, simulate::SimulateArgs>;

#[derive(Args)]
#[command(group(clap::ArgGroup::new("decided").args(["dry_run", "force"]).multiple(true).requires("machine")))]
pub(crate) struct FrictionArgs {
    /// Recorded circles.
    #[arg(value_name = "RECORD.csv")]
    record: PathBuf,
    /// The two axes of the circles' plane, in its sense: X,Y, Z,X or Y,Z, or a pair the other way round.
    #[arg(long, value_name = "X,Y", value_parser = friction::pair)]
    axes: [Axis; 2],
    /// Machine that states the figures of the drives.
    #[arg(long, value_name = "M")]
    machine: Option<PathBuf>,
    /// Find the drives' figures even if the machine states them.
    #[arg(long)]
    find_drive: bool,
    /// Find the resonance of motor and load of each axis too.
    #[arg(long)]
    find_resonance: bool,
    /// Time of the encoder's reading, µs after the command of its row takes effect (negative: before); used if the command
    /// also finds the drives' figures.
    #[arg(long, value_name = "US", allow_negative_numbers = true, value_parser = read_after)]
    read_after_us: Option<f64>,
    /// Print one JSON document instead of a table.
    #[arg(long)]
    json: bool,
    /// Write friction.html with the spikes before, predicted and after into a folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// A .toml file for the settings found, or the folder to write the machine into: its own, or a new one.
    #[arg(short, long, value_name = "TOML|MACHINE_DIR", help_heading = "Writing into a machine")]
    output: Option<PathBuf>,
    #[command(flatten)]
    writing: Writing,
}

pub(crate) fn run(arguments: &Friction) -> Result<()> {
    match arguments {
        OrSimulate::Evaluate(arguments) => identify(arguments),
        OrSimulate::Simulate(arguments) => simulate::run(arguments),
    }
}

fn identify(arguments: &FrictionArgs) -> Result<()> {
    let output = arguments.writing.output(arguments.output.as_deref());
    let (file, into) = machine_folder::file_or_folder(output, "toml", arguments.machine.is_some());
    let _alone = into.map(machine_folder::alone).transpose()?;
    let given = match &arguments.machine {
        Some(machine) => drives(machine, arguments.axes)?,
        None => [None; 2],
    };
    let machine = arguments.machine.iter().flat_map(|machine| machine_folder::inputs(machine, into));
    let mut outputs = Outputs::of(machine.chain([arguments.record.clone()]));
    if let Some(file) = file {
        outputs.refuse_input(file)?;
    }
    let given = if arguments.find_drive { [None; 2] } else { given };
    let rows = csv_in::open(&arguments.record, &friction::columns(arguments.axes), "samples")?;
    let mut recording = Recording::read(rows, arguments.axes)?;
    recording.record.read_after_s = arguments.read_after_us;
    let bar = progress(0, "fitting").with_style(indicatif::ProgressStyle::default_spinner());
    let fitted = friction::fit(&recording, given, &mut |axis, step| {
        bar.set_message(format!("fitting axis {}, step {step}", axis.letter()));
        bar.tick();
    });
    let (mut found, mut document) = fitted.inspect_err(|_| bar.finish_and_clear())?;
    if arguments.find_resonance {
        let searched = friction::resonances(&recording, &mut found, &mut |axis, step| {
            bar.set_message(format!("resonance of axis {}, step {step}", axis.letter()));
            bar.tick();
        });
        document = searched.inspect_err(|_| bar.finish_and_clear())?;
    }
    bar.finish_and_clear();
    let mut done = machine_folder::Done::default();
    if arguments.writing.decides(into)?
        && let Some(machine) = &arguments.machine
    {
        let additions = (arguments.writing, friction::additions(&found));
        done = machine_folder::decide(&mut outputs, machine, into, &arguments.record, additions)?;
    }
    if arguments.writing.dry_run {
        return done.dry_run(&document, arguments.json);
    }
    if let Some(directory) = &arguments.report {
        let shown = Shown { plots: friction::spikes(&found), ..document.shown() };
        report::stage(&mut outputs, (directory, "friction.html"), &arguments.record, &shown, report::NO_FIGURES)?;
    }
    if let Some(file) = file {
        outputs.put(file, friction::sections(&arguments.record, &found).as_bytes())?;
    }
    outputs.commit()?;
    done.print_notes();
    if arguments.json { done.json(&document) } else { print(&document.shown().text()) }
}

fn read_after(text: &str) -> Result<f64, String> {
    text.parse().map_err(|wrong: std::num::ParseFloatError| wrong.to_string()).and_then(friction::read_after_s)
}

/// The drives' figures stated by a machine.
fn drives(path: &Path, axes: [Axis; 2]) -> Result<[Option<DriveFigures>; 2]> {
    friction::drives(&model::machine(path)?, &path.display().to_string(), axes)
}
