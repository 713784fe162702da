//! `firmware-sim grind`: arguments and output.

use crate::console::{conclude, progress_bar};
use crate::machine_arg::{outputs_of, read_machine};
use anyhow::Result;
use clap::Args;
use firmware_sim::latency::timed;
use firmware_sim::report::grinding::page;
use serde::Serialize;
use std::path::PathBuf;
use trueaxis_evaluation::simulated::grinding::shown;
use trueaxis_sim::grinding::{self, Grinding, GrindingDocument, Process, Request};

const HELP: &str = "\
Both runs have the same seed; the true surface is measured after every revolution.

The pin circles with the crankshaft. Three probes on an arm that follows it see the surface and the motion of the \
pin's centre. That motion is imprinted on the pin: where the centre comes toward the wheel, too much is ground off. \
The gauge separates surface and motion while the servo loop runs, and corrects the infeed of the next revolutions. \
Only the part that repeats with every turn (the synchronous imprint) can be corrected; it should fall below a tenth.

The gauge works on one revolution while the next is sampled. When a revolution is shorter than the work, it skips \
whole revolutions: --skip chooses a speed at which that happens.

More examples:
  # At a speed at which three of four revolutions are skipped:
  firmware-sim grind --skip 3 --json
  # Another gain of the correction:
  firmware-sim grind --gain 0.3 --report out";

/// Arguments of `grind`.
#[derive(Args)]
#[command(before_help = "Example:\n  firmware-sim grind --report out", after_help = HELP)]
pub(crate) struct GrindArgs {
    /// Machine with a gauge: a machine.toml, its folder, or the name of a sample.
    #[arg(long, value_name = "M", default_value = "grinder")]
    machine: PathBuf,
    /// Turns of the spindle, 8 to 10000 [default: 40; with --skip N, 20 (N + 1) if that is more].
    #[arg(long, value_name = "N")]
    revolutions: Option<u32>,
    /// Servo rate, 100 to 100000.
    #[arg(long, value_name = "HZ", default_value_t = 10_000.0, allow_negative_numbers = true)]
    rate_hz: f64,
    /// Speed of the spindle.
    #[arg(long, value_name = "RPM", default_value_t = 30.0, conflicts_with = "skip", allow_negative_numbers = true)]
    speed_rpm: f64,
    /// Gain of the correction c <- c + g r, at most half the limit of stability [default: the machine's].
    #[arg(long, value_name = "G", allow_negative_numbers = true)]
    gain: Option<f64>,
    /// Turn so fast that the gauge has to skip N whole revolutions between two that it evaluates.
    #[arg(long, value_name = "N")]
    skip: Option<u32>,
    /// Feed that remains after roughing, µm of radius per revolution, 0 to 5.
    #[arg(long, value_name = "UM", default_value_t = Process::default().feed_um, allow_hyphen_values = true)]
    feed_um: f64,
    /// Seed of the rough surface and of every noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print one JSON document and nothing else.
    #[arg(long)]
    json: bool,
    /// Write grind.html into this folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

/// The document that `--json` prints.
#[derive(Serialize)]
struct Ground {
    #[serde(flatten)]
    figures: GrindingDocument,
    /// Time taken by both runs.
    wall_s: f64,
}

fn prepare(args: &GrindArgs) -> Result<Grinding> {
    let GrindArgs { revolutions, rate_hz, speed_rpm, gain, skip, feed_um, seed, .. } = *args;
    let request = Request { revolutions, rate_hz, speed_rpm, gain, skip, feed_um, seed };
    request.check()?;
    Ok(request.grinding(read_machine("--machine", &args.machine)?)?)
}

pub(crate) fn grind(args: &GrindArgs) -> Result<()> {
    let outputs = outputs_of([args.machine.as_path()], []);
    args.report.iter().try_for_each(|dir| outputs.refuse_input(&dir.join("grind.html")))?;
    let grinding = prepare(args)?;
    let bar = progress_bar("grinding");
    let mut progress = |fraction: f64| bar.set_position((1000.0 * fraction) as u64);
    let (outcome, nanoseconds) = timed(|| grinding::simulate(&grinding, &mut progress));
    let (outcome, wall_s) = (outcome?, 1e-9 * nanoseconds as f64);
    bar.finish_and_clear();
    let mut shown = shown(&grinding, &outcome)?;
    shown.notes.push(format!("two runs in {wall_s:.1} s"));
    let document = Ground { figures: GrindingDocument::new(&outcome, &grinding)?, wall_s };
    conclude(args.json, &document, &shown, (args.report.as_deref(), outputs), || {
        vec![("grind.html".into(), page(&grinding, &outcome, &shown))]
    })
}
