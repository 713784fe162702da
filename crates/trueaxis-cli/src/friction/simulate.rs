//! `trueaxis friction simulate`.

use crate::model::{self, machine};
use crate::output::progress;
use crate::simulate::{Disturbances, Rehearsal, write};
use anyhow::{Context, Result};
use clap::Args;
use std::path::PathBuf;
use trueaxis::Axis;
use trueaxis_evaluation::friction::pair;
use trueaxis_evaluation::simulated::rehearsal::FrictionCircles;
use trueaxis_tables::output::Outputs;

const EXAMPLE: &str = "\
Example:
  trueaxis friction simulate --machine compensation-tables/mill-3axis \\
      --axes X,Y -o record.csv";

const HELP: &str = "\
A rehearsal: write a record, identify it, and see how well it finds figures that you state:

  trueaxis friction simulate --machine true --axes X,Y -o record.csv
  trueaxis friction record.csv --axes X,Y --machine true

TRUE states the true figures in [axis.X.drive] and [axis.X.friction] of its machine.toml, for both axes. The circles \
begin and end at rest, at two feeds, each in both directions, about the middle of the travels. Drives are integrated \
with a current loop, a limited force and the friction of the model; the encoders count 10 nm and have a signal period \
of 20 µm with 30 nm and 15 nm of subdivisional error. --noise-um is the noise of the encoders (0.005 unless given). \
Geometry has no effect.";

#[derive(Args)]
pub(crate) struct SimulateArgs {
    /// Machine that states the true figures of drives and friction.
    #[arg(long, value_name = "TRUE", help_heading = "True machine")]
    machine: PathBuf,
    /// The two axes of the circles' plane: X,Y, Z,X or Y,Z.
    #[arg(long, value_name = "X,Y", value_parser = pair)]
    axes: [Axis; 2],
    /// Radius of the circles, 1 to 1000; not a multiple of the encoders' signal period.
    #[arg(long, value_name = "MM", default_value_t = 25.0037, allow_negative_numbers = true)]
    radius_mm: f64,
    /// The two feeds, mm/min, 10 to 20000.
    #[arg(long, value_name = "F,F", value_delimiter = ',', num_args = 1, default_values_t = [1500.0, 600.0])]
    feeds: Vec<f64>,
    /// Whole turns of every circle, 1 to 20.
    #[arg(long, value_name = "N", default_value_t = 1)]
    turns: u32,
    /// Rate of the record, 500 to 100000.
    #[arg(long, value_name = "HZ", default_value_t = 4000.0, allow_negative_numbers = true)]
    rate_hz: f64,
    /// Standard deviation of an encoder's reading, 0 to 1000 [default: 0.005].
    #[arg(long, value_name = "U", allow_negative_numbers = true, help_heading = "Disturbances")]
    noise_um: Option<f64>,
    /// Seed; the same seed gives the same file.
    #[arg(long, value_name = "SEED", default_value_t = 1, help_heading = "Disturbances")]
    seed: u64,
    /// The record [default: standard output].
    #[arg(short, long, value_name = "RECORD.csv")]
    output: Option<PathBuf>,
}

impl Rehearsal for SimulateArgs {
    const ABOUT: &'static str = "Write the record that circles would give on drives of stated figures and friction";
    const EXAMPLE: &'static str = EXAMPLE;
    const HELP: &'static str = HELP;
}

pub(super) fn run(arguments: &SimulateArgs) -> Result<()> {
    let conditions = Disturbances::of(arguments.noise_um, arguments.seed).conditions(None)?;
    let circles = FrictionCircles {
        axes: arguments.axes,
        radius_mm: arguments.radius_mm,
        feeds_mm_per_min: arguments.feeds.clone(),
        turns: arguments.turns,
        rate_hz: arguments.rate_hz,
    };
    let bar = progress(1000, "recording");
    let truth = machine(&arguments.machine)?;
    let record = circles.record(&truth, &conditions, &|share| bar.set_position((1000.0 * share) as u64));
    bar.finish_and_clear();
    let record = record.with_context(|| arguments.machine.display().to_string())?;
    write(Outputs::of(model::files(&arguments.machine)), arguments.output.as_deref(), &record, &[])
}
