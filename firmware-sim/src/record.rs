//! `firmware-sim record`: arguments and output.

use crate::console::{progress_bar, put, report_line};
use crate::machine_arg::outputs_of;
use crate::scenario_args::{ScenarioArgs, prepare};
use anyhow::{Result, bail};
use clap::Args;
use firmware_sim::compare::image;
use firmware_sim::recorded::{self, Settings};
use std::path::PathBuf;
use std::sync::Arc;
use trueaxis_sim::Scenario;

const HELP: &str = "\
Positions are rounded to 1e-6 mm. A machine file with [roundness] adds a workpiece that turns at three probes.

More examples:
  # With faults, stops and an exchange of tables:
  firmware-sim record --program short-tour --rate-hz 1000 --drill \\
      --exchange-at 12000 -o tour.rec";

/// Arguments of `record`.
#[derive(Args)]
#[command(before_help = "Example:\n  firmware-sim record --rate-hz 1000 -o run.rec", after_help = HELP)]
pub(crate) struct RecordArgs {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// Inject a fault as in `run` (may be given several times).
    #[arg(long, value_name = "FAULT", help_heading = "Faults and events")]
    fault: Vec<String>,
    #[command(flatten)]
    pub(crate) how: How,
    /// The recording.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

/// Arguments of a recording.
#[derive(Args, Clone, Copy)]
pub(crate) struct How {
    /// Stop after this many cycles.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    cycles: Option<u32>,
    /// Overlay the run with the situations of a controller: not homed first, a jump and a command out of travel with their
    /// resets while the machine is at rest, alarms, glitches and late cycles in motion.
    #[arg(long)]
    drill: bool,
    /// Request other tables in this cycle.
    #[arg(long, value_name = "CYCLE")]
    pub(crate) exchange_at: Option<u32>,
    /// Speed of the workpiece at a gauge.
    #[arg(long, value_name = "RPM", default_value_t = 12.0)]
    speed_rpm: f64,
}

/// Records a scenario, with a progress bar on standard error.
pub(crate) fn bytes(scenario: &Arc<Scenario>, how: &How) -> Result<Vec<u8>> {
    if !(0.01..=10_000.0).contains(&how.speed_rpm) {
        bail!("--speed-rpm: found {}, needed 0.01 to 10000", how.speed_rpm);
    }
    let settings =
        Settings { cycles: how.cycles, drill: how.drill, exchange_at: how.exchange_at, speed_rpm: how.speed_rpm };
    let bar = progress_bar("recording");
    let mut progress = |fraction: f64| bar.set_position((1000.0 * fraction) as u64);
    let bytes = recorded::record(scenario, &settings, &mut progress)?;
    bar.finish_and_clear();
    Ok(bytes)
}

pub(crate) fn record(args: &RecordArgs) -> Result<()> {
    let mut outputs = outputs_of([args.scenario.machine.as_path()], args.scenario.files());
    outputs.refuse_input(&args.output)?;
    let scenario = Arc::new(prepare(&args.scenario, &args.fault)?);
    let bytes = bytes(&scenario, &args.how)?;
    outputs.put(&args.output, &bytes)?;
    outputs.commit()?;
    if bytes.len() as u64 > image::RECORDING.1 {
        report_line(format_args!(
            "note: the bare-metal image has room for {} bytes (fewer cycles: --cycles, --rate-hz)",
            image::RECORDING.1
        ));
    }
    put(&format!("written  {}  {} bytes\n", args.output.display(), bytes.len()))
}
