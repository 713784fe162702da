//! `firmware-sim calibrate`: arguments and output.

use crate::console::{conclude, counting_bar};
use crate::given::{text_or, up_to};
use anyhow::{Result, bail};
use clap::Args;
use firmware_sim::report::calibration::{page, shown};
use std::path::PathBuf;
use trueaxis_evaluation::simulated::calibration::{Conditions, FIVE_AXES, MILL, Machines, TaskText, all, summary};
use trueaxis_sim::calibration::Class;
use trueaxis_tables::output::Outputs;

/// Maximum number of machines in a run.
const MOST: u64 = 100_000;

const HELP: &str = "\
Every machine gets the probing program of `trueaxis calibrate plan`. The probe with its scatter and pre-travel \
touches slightly misplaced artefacts, the machine drifts, and the log becomes tables. The remaining error is \
evaluated over the volume by exact transforms, in both directions of travel.

More examples:
  # 200 mills and a tenth as many five-axis machines, with a page:
  firmware-sim calibrate --machines 200 --report out
  # With angular errors, which the terms do not contain:
  firmware-sim calibrate --machines 50 --angle-urad 10
  # Step gauges and a square that is turned over:
  firmware-sim calibrate --machines 40 \\
      --task crates/trueaxis-evaluation/src/simulated/gauge-and-square.toml";

/// Arguments of `calibrate`.
#[derive(Args)]
#[command(before_help = "Example:\n  firmware-sim calibrate --machines 5", after_help = HELP)]
pub(crate) struct CalibrateArgs {
    /// Three-axis machines; a tenth as many with five axes.
    #[arg(long, value_name = "N", default_value_t = 20)]
    machines: u64,
    /// Seed of the first machine; the next have the next.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Standard deviation of a touch, 0 to 100.
    #[arg(long, value_name = "UM", default_value_t = 1.0, allow_negative_numbers = true)]
    noise_um: f64,
    /// Angular errors of every axis, a bow of that height over its travel, 0 to 200.
    #[arg(long, value_name = "URAD", default_value_t = 0.0, allow_negative_numbers = true)]
    angle_urad: f64,
    /// Another task for the three-axis machines, any artefacts in 500 × 400 × 300 mm (X and Y from 0, Z down from 0).
    #[arg(long, value_name = "TASK.toml")]
    task: Option<PathBuf>,
    /// Another task for the five-axis machines.
    #[arg(long, value_name = "TASK.toml")]
    five_axes_task: Option<PathBuf>,
    /// Print one JSON document and nothing else.
    #[arg(long)]
    json: bool,
    /// Write calibrate.html into this folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

pub(crate) fn calibrate(args: &CalibrateArgs) -> Result<()> {
    up_to(100.0, "--noise-um", args.noise_um)?;
    up_to(200.0, "--angle-urad", args.angle_urad)?;
    if !(1..=MOST).contains(&args.machines) {
        bail!("--machines: found {}, needed 1 to {MOST}", args.machines);
    }
    let class = Class { angle: 1e-6 * args.angle_urad, ..Class::MILL };
    let conditions = Conditions { noise_um: args.noise_um, ..Conditions::SHOP };
    let (mill, trunnion) = (args.task.as_deref(), args.five_axes_task.as_deref());
    let texts = [text_or(mill, MILL)?, text_or(trunnion, FIVE_AXES)?];
    let tasks = [TaskText::of(mill, &texts[0]), TaskText::of(trunnion, &texts[1])];
    let bar = counting_bar(args.machines + args.machines.div_ceil(10), "machines");
    let machines = all(args.machines, args.seed, tasks, &class, &conditions, &|| bar.inc(1))?;
    bar.finish_and_clear();
    let found = summary(&machines);
    let shown = shown(&machines, &found);
    let Machines { three_axes, five_axes, refused } = &machines;
    let document = serde_json::json!({
        "summary": found, "three_axes": three_axes, "five_axes": five_axes, "refused": refused,
    });
    conclude(args.json, &document, &shown, (args.report.as_deref(), Outputs::default()), || {
        vec![("calibrate.html".into(), page(&machines, &shown))]
    })
}
