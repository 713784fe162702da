//! `firmware-sim thermal`: arguments and output.

use crate::console::{conclude, progress_bar};
use crate::given::{even, up_to};
use crate::machine_arg::{outputs_of, read_machine};
use crate::thermal_text::json;
use anyhow::Result;
use clap::Args;
use firmware_sim::report::thermal::{page, record, shown};
use std::path::PathBuf;
use trueaxis_sim::warming::{SENSORS, Warming};

const HELP: &str = "\
Spindle, feed, coolant and the air of the hall warm bodies of two nodes each. Drift is probed at four points every \
five minutes. The judged shift has other speeds, longer periods and other positions.

More examples:
  # With a page, and the record beside it:
  firmware-sim thermal --report out
  # A sensor fails half-way, and its share is frozen:
  firmware-sim thermal --fails nose
  # The same record on the bench:
  trueaxis thermal fit out/record.csv";

/// Arguments of `thermal`.
#[derive(Args)]
#[command(before_help = "Example:\n  firmware-sim thermal", after_help = HELP)]
pub(crate) struct ThermalArgs {
    /// Machine of three linear axes whose step corrects: a machine.toml, its folder, or the name of a sample.
    #[arg(long, value_name = "M", default_value = "mill-3axis")]
    machine: PathBuf,
    /// Shifts of the record, 3 to 20. The last one is excluded from the fit, to test it.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(3..=20))]
    shifts: u32,
    /// Standard deviation of a reading of the probe, 0 to 100.
    #[arg(long, value_name = "UM", default_value_t = 0.5, allow_negative_numbers = true)]
    noise_um: f64,
    /// Time between two updates of the task, an even number.
    #[arg(long, value_name = "S", default_value_t = 10, value_parser = clap::value_parser!(u32).range(2..=600))]
    update_s: u32,
    /// Sensor that fails half-way through the judged shift.
    #[arg(long, value_name = "SENSOR", value_parser = SENSORS)]
    fails: Option<String>,
    /// Seed of duty cycles and noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print one JSON document and nothing else.
    #[arg(long)]
    json: bool,
    /// Write thermal.html and the record into this folder.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

pub(crate) fn thermal(args: &ThermalArgs) -> Result<()> {
    up_to(100.0, "--noise-um", args.noise_um)?;
    even("--update-s", args.update_s)?;
    let outputs = outputs_of([args.machine.as_path()], []);
    if let Some(dir) = &args.report {
        for name in ["thermal.html", "record.csv"] {
            outputs.refuse_input(&dir.join(name))?;
        }
    }
    let warming = Warming {
        machine: read_machine("--machine", &args.machine)?,
        seed: args.seed,
        shifts: args.shifts,
        noise_um: args.noise_um,
        update_s: args.update_s,
        fails: args.fails.as_ref().and_then(|name| SENSORS.iter().position(|sensor| sensor == name)),
    };
    let bar = progress_bar("warming");
    let outcome = warming.run(&mut |what| {
        bar.set_message(what.to_owned());
        bar.tick();
    });
    bar.finish_and_clear();
    let outcome = outcome?;
    let shown = shown(&warming, &outcome);
    conclude(args.json, &json(&warming, &outcome), &shown, (args.report.as_deref(), outputs), || {
        vec![("record.csv".into(), record(&outcome)), ("thermal.html".into(), page(&outcome, &shown))]
    })
}
