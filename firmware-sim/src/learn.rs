//! `firmware-sim learn`: arguments and output.

use crate::console::{progress_bar, put};
use crate::machine_arg::outputs_of;
use crate::run::{MeasuredBy, with_learned};
use crate::scenario_args::{ScenarioArgs, prepare_with};
use crate::settings_args::ActArgs;
use anyhow::{Result, anyhow};
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;
use trueaxis_evaluation::shown::{Cell, Shown, Table};
use trueaxis_sim::learning::{self, DEFAULT_CUTOFF_MM, DEFAULT_FORGET, DEFAULT_GAIN, Law, Part};
use trueaxis_sim::run::ErrorSize;

const HELP: &str = "\
Between two parts, the correction over path length is learned from the contour error that the step itself estimates, \
or that a grid encoder measures, as `trueaxis learn` does from a record. Every part has different encoder noise.

More examples:
  firmware-sim learn --program butterfly -o butterfly.tlearn
  firmware-sim run --program butterfly --learned butterfly.tlearn
  # By hand, part by part:
  firmware-sim run --record 1.csv
  trueaxis learn 1.csv -o 1.tlearn
  firmware-sim run --learned 1.tlearn --record 2.csv --seed 2";

/// Arguments of `learn`.
#[derive(Args)]
#[command(before_help = "Example:\n  firmware-sim learn --program short-tour", after_help = HELP)]
pub(crate) struct LearnArgs {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// Number of parts, 1 to 100.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    parts: u32,
    /// Correction for the first part [default: none].
    #[arg(long, value_name = "FILE.tlearn")]
    learned: Option<PathBuf>,
    /// Source of the contour error to learn from.
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = MeasuredBy::Estimate)]
    measured_by: MeasuredBy,
    /// Gain of the law, above 0 and below 2.
    #[arg(long, value_name = "L", default_value_t = DEFAULT_GAIN, allow_negative_numbers = true)]
    gain: f64,
    /// Forgetting of the law, above 0 to 1.
    #[arg(long, value_name = "F", default_value_t = DEFAULT_FORGET, allow_negative_numbers = true)]
    forget: f64,
    /// Cut-off along the path: errors of longer wavelength are learned.
    #[arg(long, value_name = "MM", default_value_t = DEFAULT_CUTOFF_MM, allow_negative_numbers = true)]
    cutoff_mm: f64,
    /// Print one JSON document and nothing else.
    #[arg(long)]
    json: bool,
    /// Write the correction learned from all parts.
    #[arg(short, long, value_name = "FILE.tlearn")]
    output: Option<PathBuf>,
}

/// A part in the JSON document.
#[derive(Serialize)]
struct Made {
    part: usize,
    contour_error_um: Size,
    estimated_um: Size,
    stopped: bool,
}

#[derive(Serialize)]
struct Size {
    max: f64,
    rms: f64,
}

#[derive(Serialize)]
struct PartsDocument<'s> {
    machine: &'s str,
    program: &'s str,
    gain: f64,
    forget: f64,
    cutoff_mm: f64,
    parts: Vec<Made>,
}

pub(crate) fn learn(args: &LearnArgs) -> Result<()> {
    let LearnArgs { gain, forget, cutoff_mm, .. } = *args;
    let law = Law { gain, forget, cutoff_mm };
    law.check().map_err(|error| anyhow!("--{error}"))?;
    let inputs = args.scenario.files().chain(args.learned.as_deref());
    let mut outputs = outputs_of([args.scenario.machine.as_path()], inputs);
    if let Some(output) = &args.output {
        outputs.refuse_input(output)?;
    }
    let scenario = with_learned(prepare_with(&args.scenario, &ActArgs::default())?, args.learned.as_deref())?;
    let bar = progress_bar("learning");
    let parts = {
        let mut progress = |done: f64| bar.set_position((1000.0 * done) as u64);
        learning::parts(&scenario, &law, args.measured_by.into(), args.parts, &mut progress)?
    };
    bar.finish_and_clear();
    if let (Some(output), Some(last)) = (&args.output, parts.last()) {
        outputs.put(output, last.table.bytes())?;
        outputs.commit()?;
    }
    let (machine, program) = (scenario.machine.settings.name.as_str(), scenario.program.name.as_str());
    if args.json {
        let parts = (1..).zip(&parts).map(|(part, made)| Made::of(part, made)).collect();
        let document = PartsDocument { machine, program, gain, forget, cutoff_mm, parts };
        return put(&trueaxis_evaluation::json::pretty(&document)?);
    }
    let written = args.output.iter().map(|file| format!("written  {}\n", file.display()));
    put(&(shown(machine, program, &law, &parts).text() + &written.collect::<String>()))
}

impl Made {
    fn of(part: usize, made: &Part) -> Made {
        let size = |size: ErrorSize| Size { max: size.max_um, rms: size.rms_um };
        Made { part, contour_error_um: size(made.error), estimated_um: size(made.estimated), stopped: made.stopped }
    }
}

fn shown(machine: &str, program: &str, law: &Law, parts: &[Part]) -> Shown {
    let first = parts.first().map_or(1.0, |part| part.error.rms_um);
    let rows = (1..).zip(parts).map(|(number, part)| {
        let ErrorSize { max_um, rms_um } = part.error;
        let [max, rms] = [max_um, rms_um].map(|um| Cell::number(um, 3));
        let end = if part.stopped { "stopped" } else { "" };
        vec![Cell::count(number), max, rms, Cell::percent(rms_um / first), end.into()]
    });
    let head = ["part", "largest, µm", "RMS, µm", "of the first, %", ""];
    Shown {
        title: "Learning part by part".into(),
        summary: vec![
            format!("{program} on {machine}, full"),
            format!("gain {}", law.gain),
            format!("forgetting {}", law.forget),
            format!("cut-off {} mm", law.cutoff_mm),
        ],
        tables: vec![Table::new("Contour error of the tool tip", head, rows)],
        ..Shown::default()
    }
}
