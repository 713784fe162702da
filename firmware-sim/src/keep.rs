//! `firmware-sim keep`: arguments and output.

use crate::console::{conclude, counting_bar};
use crate::given::{even, text_or, up_to};
use anyhow::Result;
use clap::{Args, ValueEnum};
use firmware_sim::report::keeping::{page, shown};
use std::path::PathBuf;
use trueaxis_evaluation::simulated::keeping::{FIVE_AXES, MILL, Shift};
use trueaxis_tables::output::Outputs;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Kind {
    /// Three axes, three balls.
    Mill,
    /// A trunnion with A and C, one ball at several angles.
    FiveAxes,
}

const HELP: &str = "\
Bodies warm as in `firmware-sim thermal`, and location errors wander; no thermal model compensates the growth. The \
probing program runs on the corrected machine with scatter. Errors are evaluated over the volume by exact \
transforms.

More examples:
  # Centre lines by one ball at several angles:
  firmware-sim keep --machine five-axes
  # From part 30 on a ball is displaced: every later update is refused:
  firmware-sim keep --hit 30";

/// Arguments of `keep`.
#[derive(Args)]
#[command(before_help = "Example:\n  firmware-sim keep --report out", after_help = HELP)]
pub(crate) struct KeepArgs {
    /// The machine; its tables are exact at the start of the shift.
    #[arg(long, value_enum, default_value_t = Kind::Mill)]
    machine: Kind,
    /// Parts of the shift.
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=2000))]
    parts: u32,
    /// Time for a part, an even number.
    #[arg(long, value_name = "S", default_value_t = 480, value_parser = clap::value_parser!(u32).range(2..=28_800))]
    part_s: u32,
    /// Standard deviation of a touch, 0 to 100.
    #[arg(long, value_name = "UM", default_value_t = 1.0, allow_negative_numbers = true)]
    noise_um: f64,
    /// Part at which the first ball is hit and moved by 80 µm.
    #[arg(long, value_name = "PART")]
    hit: Option<u32>,
    /// Another task of the same machine: balls, probe, bounds, parts between two re-probings.
    #[arg(long, value_name = "KEEP.toml")]
    task: Option<PathBuf>,
    /// Seed of machine, drift and noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print one JSON document and nothing else.
    #[arg(long)]
    json: bool,
    /// Write keep.html into this folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

pub(crate) fn keep(args: &KeepArgs) -> Result<()> {
    up_to(100.0, "--noise-um", args.noise_um)?;
    even("--part-s", args.part_s)?;
    let five_axes = args.machine == Kind::FiveAxes;
    let task = text_or(args.task.as_deref(), if five_axes { FIVE_AXES } else { MILL })?;
    let bar = counting_bar(u64::from(args.parts), "parts");
    let shift = Shift {
        seed: args.seed,
        five_axes,
        task,
        task_file: args.task.clone().unwrap_or_else(|| "keep.toml".into()),
        parts: args.parts,
        part_s: args.part_s,
        noise_um: args.noise_um,
        hit: args.hit,
    };
    let outcome = shift.run(&|| bar.inc(1));
    bar.finish_and_clear();
    let outcome = outcome?;
    let (shown, outputs) = (shown(&outcome), Outputs::of(args.task.iter()));
    conclude(args.json, &outcome, &shown, (args.report.as_deref(), outputs), || {
        vec![("keep.html".into(), page(&outcome, &shown))]
    })
}
