//! `firmware-sim rtcp`: arguments and output.

use crate::ball_test_text::json;
use crate::console::conclude;
use crate::given::up_to;
use crate::machine_arg::{outputs_of, read_machine};
use anyhow::Result;
use clap::Args;
use firmware_sim::report::ball_test::{page, shown};
use std::path::PathBuf;
use trueaxis_sim::ball_test::BallCycle;

const HELP: &str = "\
C turns a full circle, A a quarter, with three set-ups of the ball each. Linear axes are perfect.

More examples:
  # Another gauge, with the readings and tables beside the report:
  firmware-sim rtcp --gauge-noise-um 1 --report out
  # The same readings on the bench:
  trueaxis identify out/measured-c.csv --axis C";

/// Arguments of `rtcp`.
#[derive(Args)]
#[command(before_help = "Example:\n  firmware-sim rtcp", after_help = HELP)]
pub(crate) struct RtcpArgs {
    /// Machine whose head carries A in C: a machine.toml, its folder, or the name of a sample.
    #[arg(long, value_name = "M", default_value = "head-5axis")]
    machine: PathBuf,
    /// Standard deviation of a reading of the gauge, 0 to 100.
    #[arg(long, value_name = "UM", default_value_t = 0.2, allow_negative_numbers = true)]
    gauge_noise_um: f64,
    /// Seed of the gauge's noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print one JSON document and nothing else.
    #[arg(long)]
    json: bool,
    /// Write rtcp.html, the readings and the tables into this folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

pub(crate) fn rtcp(args: &RtcpArgs) -> Result<()> {
    up_to(100.0, "--gauge-noise-um", args.gauge_noise_um)?;
    let outputs = outputs_of([args.machine.as_path()], []);
    if let Some(dir) = &args.report {
        for name in ["rtcp.html", "measured-c.csv", "measured-a.csv", "c.csv", "a.csv"] {
            outputs.refuse_input(&dir.join(name))?;
        }
    }
    let test = BallCycle {
        machine: read_machine("--machine", &args.machine)?,
        gauge_noise_um: args.gauge_noise_um,
        seed: args.seed,
    };
    let outcome = test.run()?;
    let shown = shown(&test, &outcome);
    conclude(args.json, &json(&outcome, &test), &shown, (args.report.as_deref(), outputs), || {
        outcome.files().into_iter().chain([("rtcp.html".into(), page(&test, &outcome, &shown))]).collect()
    })
}
