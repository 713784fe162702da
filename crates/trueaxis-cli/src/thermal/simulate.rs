//! `trueaxis thermal simulate`.

use crate::numbers::{Numbers, numbers};
use crate::simulate::{Disturbances, write};
use anyhow::{Result, bail};
use clap::Args;
use std::path::PathBuf;
use trueaxis_sim::warming::{POINTS, Recording, csv};
use trueaxis_tables::output::Outputs;

pub(super) const EXAMPLE: &str = "\
Example:
  trueaxis thermal simulate -o record.csv";

pub(super) const HELP: &str = "\
A rehearsal: write a record, fit it, and see what would remain:

  trueaxis thermal simulate --shifts 5 -o record.csv
  trueaxis thermal fit record.csv -o thermal.toml

The machine is a mill of bodies with two nodes each, skin and core, which spindle, feed, coolant and the air of the hall \
warm; its column bends, its spindle and screw grow. It has neither lags nor curves of the fitted model, and drifts \
by 50 to 100 µm a shift. Every five minutes of a shift of eight hours the drift is probed at every --at; shifts \
begin 24 h apart, and the seed draws their speeds and spells. Sensors T1 to T9 are on nose, head, column front and back, \
bed, screw, table, coolant and in the air; they read in steps of 1/16 K.";

#[derive(Args)]
pub(crate) struct ThermalSimulateArgs {
    /// Shifts, 3 to 20.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(3..=20))]
    shifts: u32,
    /// A measuring point: axis positions and the length from the spindle's nose to it, 1 to 1000 (may be given several
    /// times) [default: four points that separate slopes and tilts].
    #[arg(long, value_name = "X,Y,Z,L", value_parser = numbers, allow_hyphen_values = true)]
    at: Vec<Numbers>,
    /// Standard deviation of a reading of the drift, 0 to 1000.
    #[arg(long, value_name = "U", default_value_t = 0.5, allow_negative_numbers = true, help_heading = "Disturbances")]
    noise_um: f64,
    /// Seed; the same seed gives the same file.
    #[arg(long, value_name = "SEED", default_value_t = 1, help_heading = "Disturbances")]
    seed: u64,
    /// The record [default: standard output].
    #[arg(short, long, value_name = "RECORD.csv")]
    output: Option<PathBuf>,
}

pub(super) fn run(arguments: &ThermalSimulateArgs) -> Result<()> {
    let conditions = Disturbances::of(Some(arguments.noise_um), arguments.seed).conditions(None)?;
    let mut points = Vec::new();
    for at in &arguments.at {
        match at.as_slice() {
            &[x, y, z, length] if (1.0..=1000.0).contains(&length) => points.push([x, y, z, length]),
            other => bail!("--at: found {other:?}, needed X,Y,Z and a length of 1 to 1000 mm"),
        }
    }
    if points.is_empty() {
        points = POINTS.to_vec();
    }
    let recording = Recording { seed: conditions.seed, shifts: arguments.shifts, noise_um: arguments.noise_um, points };
    let none: [PathBuf; 0] = [];
    write(Outputs::of(none), arguments.output.as_deref(), &csv(&recording.record()), &[])
}
