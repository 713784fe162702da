//! `trueaxis ballbar simulate`.

use crate::numbers::triple;
use crate::simulate::{OnMachine, Rehearsal};
use anyhow::Result;
use clap::Args;
use trueaxis::Axis;
use trueaxis_evaluation::friction::pair;
use trueaxis_evaluation::simulated::rehearsal::Circles;

const EXAMPLE: &str = "\
Example:
  trueaxis ballbar simulate --machine records/probing/true --radius-mm 100 \\
      -o record.csv";

const HELP: &str = "\
A rehearsal: write a record, evaluate it, and see how well it finds errors that you state:

  trueaxis ballbar simulate --machine true --radius-mm 100 -o record.csv
  trueaxis ballbar record.csv --radius-mm 100

TRUE is a machine.toml, whose tables, location errors and backlash are the true errors. The bar reads the distance of \
the true tip from a pivot some 20 µm beside the centre. Each circle begins half a turn before its readings; \
lost motion is taken up along the way. Rotary axes are at zero.

Drives are not simulated: servo mismatch and reversal spikes are zero. `trueaxis friction simulate` records circles \
with drives and friction, as positions, which `trueaxis ballbar` reads too.";

#[derive(Args)]
pub(crate) struct SimulateArgs {
    #[command(flatten)]
    on: OnMachine,
    /// Nominal radius of the circle, 1 to 10000.
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    radius_mm: f64,
    /// The two axes of the circles' plane, in its sense: X,Y, Z,X or Y,Z, or a pair the other way round.
    #[arg(long, value_name = "X,Y", value_parser = pair, default_value = "X,Y")]
    axes: [Axis; 2],
    /// Axis positions of the centre [default: the middle of the travels].
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    centre_mm: Option<[f64; 3]>,
    /// Readings per circle.
    #[arg(long, value_name = "N", default_value_t = 360, value_parser = clap::value_parser!(u32).range(16..=36_000))]
    readings: u32,
    /// Feed along the circle, 1 to 100000.
    #[arg(long, value_name = "F", default_value_t = 1000.0, allow_negative_numbers = true)]
    feed_mm_per_min: f64,
}

impl Rehearsal for SimulateArgs {
    const ABOUT: &'static str = "Write the record that a bar would give on a machine of stated errors, noise and drift";
    const EXAMPLE: &'static str = EXAMPLE;
    const HELP: &'static str = HELP;
}

pub(super) fn run(arguments: &SimulateArgs) -> Result<()> {
    let circles = Circles {
        radius_mm: arguments.radius_mm,
        axes: arguments.axes,
        centre_mm: arguments.centre_mm,
        readings: arguments.readings as usize,
        feed_mm_per_min: arguments.feed_mm_per_min,
    };
    circles.check().map_err(|wrong| wrong.option())?;
    arguments.on.write(|instrument| circles.record(instrument))
}
