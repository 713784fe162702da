//! `trueaxis periodic simulate`.

use super::axis;
use crate::numbers::numbers;
use crate::simulate::{OnMachine, Rehearsal};
use anyhow::{Result, bail};
use clap::Args;
use trueaxis::Axis;
use trueaxis_evaluation::simulated::rehearsal::Scan;

const EXAMPLE: &str = "\
Example:
  trueaxis periodic simulate --machine compensation-tables/mill-3axis --axis X \\
      --range-mm 100,300 -o scan.csv";

const HELP: &str = "\
A rehearsal: write a record, evaluate it, and see how well it finds errors that you state:

  trueaxis periodic simulate --machine true --axis X -o scan.csv
  trueaxis periodic scan.csv --axis X --period-mm 5

TRUE is a machine.toml: its [[axis.X.periodic]] state the true periods, its tables the slow error. An interferometer \
reads the true less the commanded displacement of the tip along the axis every --step-mm, in positive travel and \
back; the other axes are in the middle of their travels. The position is of exact transforms, which the evaluation \
does not use. A ballbar's record of such a machine: trueaxis ballbar simulate.";

#[derive(Args)]
pub(crate) struct SimulateArgs {
    #[command(flatten)]
    on: OnMachine,
    /// The axis, a linear one.
    #[arg(long, value_name = "X", value_parser = axis)]
    axis: Axis,
    /// First and last position [default: the travel].
    #[arg(long, value_name = "FROM,TO", value_parser = range, allow_hyphen_values = true)]
    range_mm: Option<[f64; 2]>,
    /// Distance of the readings, 0.0001 to 1000.
    #[arg(long, value_name = "MM", default_value_t = 0.2, allow_negative_numbers = true)]
    step_mm: f64,
    /// Feed, 1 to 100000.
    #[arg(long, value_name = "F", default_value_t = 500.0, allow_negative_numbers = true)]
    feed_mm_per_min: f64,
    /// Read in positive travel only.
    #[arg(long)]
    one_way: bool,
}

/// Two numbers: FROM,TO.
fn range(text: &str) -> Result<[f64; 2], String> {
    let values = numbers(text)?;
    values.try_into().map_err(|_| format!("found {text:?}, needed two numbers: FROM,TO"))
}

impl Rehearsal for SimulateArgs {
    const ABOUT: &'static str = "Write the scan that a machine of stated periods, tables, noise and drift would give";
    const EXAMPLE: &'static str = EXAMPLE;
    const HELP: &'static str = HELP;
}

pub(super) fn run(arguments: &SimulateArgs) -> Result<()> {
    let scan = Scan {
        axis: arguments.axis,
        range_mm: arguments.range_mm,
        step_mm: arguments.step_mm,
        feed_mm_per_min: arguments.feed_mm_per_min,
        is_one_way: arguments.one_way,
    };
    scan.check().map_err(|wrong| wrong.option())?;
    if arguments.axis.is_rotary() {
        bail!("--axis: found {}, needed a linear axis", arguments.axis.letter());
    }
    arguments.on.write(|instrument| scan.record(instrument))
}
