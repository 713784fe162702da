//! `firmware-sim soak`: arguments and output.

use crate::console::{progress_bar, put, report_line};
use crate::scenario_args::{ScenarioArgs, prepare_with};
use crate::settings_args::ActArgs;
use anyhow::{Result, bail};
use clap::Args;
use firmware_sim::soak::{self, Soak};
use std::sync::Arc;
use trueaxis_evaluation::shown::{Cell, Shown, Table};
use trueaxis_sim::Scenario;
use trueaxis_sim::motion::MOST_CYCLES;
use trueaxis_sim::run::Kind;
use trueaxis_tables::text::counted;

const HELP: &str = "\
Exit code 1: the runs differ.

More examples:
  # A day at LinuxCNC's usual rate, eight times side by side:
  firmware-sim soak --rate-hz 1000
  # An hour at 10 kHz with a fault and a switch:
  firmware-sim soak --hours 1 --runs 2 --fault dropout:X@100s+3 \\
      --event off:correction@200s";

/// Arguments of `soak`.
#[derive(Args)]
#[command(before_help = "Example:\n  firmware-sim soak --rate-hz 1000 --hours 1 --runs 2", after_help = HELP)]
pub(crate) struct SoakArgs {
    #[command(flatten)]
    scenario: ScenarioArgs,
    #[command(flatten)]
    acts: ActArgs,
    /// Simulated time of each run, h: the program is repeated until it is over.
    #[arg(long, value_name = "H", default_value_t = 24.0, allow_negative_numbers = true)]
    hours: f64,
    /// Runs side by side.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u16).range(1..=256))]
    runs: u16,
    /// Print one JSON document and nothing else.
    #[arg(long)]
    json: bool,
}

/// Runs the soak; returns whether all runs agree.
pub(crate) fn run(args: &SoakArgs) -> Result<bool> {
    if !(args.hours.is_finite() && args.hours > 0.0) {
        bail!("--hours: found {}, needed a positive number", args.hours);
    }
    let once = prepare_with(&args.scenario, &args.acts)?;
    let most = MOST_CYCLES / once.rate_hz() / 3600.0;
    if args.hours > most {
        bail!("--hours: found {}, needed at most {most:.1} at {} Hz", args.hours, once.rate_hz());
    }
    let (scenario, times) = repeated(once, 3600.0 * args.hours)?;
    let scenario = Arc::new(scenario);
    let kinds: Vec<Kind> =
        Kind::of(&scenario.machine.settings).iter().copied().filter(|k| k.enables_the_plugin()).collect();
    let bar = progress_bar("soaking");
    let mut show = |fraction: f64| bar.set_position((1000.0 * fraction) as u64);
    let soak = soak::soak(&vec![Arc::clone(&scenario); args.runs.into()], &kinds, &mut show)?;
    bar.finish_and_clear();
    for difference in soak.differences.iter().take(8) {
        report_line(format_args!(
            "run {} differs from run 1 at cycle {}: found {}, needed {}",
            difference.run,
            difference.found.cycle,
            digests(&difference.found),
            digests(&difference.needed)
        ));
    }
    if args.json {
        put(&trueaxis_evaluation::json::pretty(&soak)?)?;
    } else {
        put(&shown(&soak, &scenario, times).text())?;
    }
    Ok(soak.differences.is_empty())
}

/// The scenario with its program repeated until it takes `seconds`, and the number of repetitions.
fn repeated(once: Scenario, seconds: f64) -> Result<(Scenario, usize)> {
    let duration = |scenario: &Scenario| Ok::<_, anyhow::Error>(scenario.motion()?.duration());
    let of = |times: usize| -> Result<Scenario> {
        let program = once.program.repeated(times)?;
        let scenario = Scenario::new(once.machine.clone(), program, once.settings.clone())?;
        Ok(scenario.with_exchanges(once.exchanges.clone()))
    };
    let (one, two) = (duration(&of(1)?)?, duration(&of(2)?)?);
    let times = ((seconds - one) / (two - one)).ceil().max(0.0) as usize + 1;
    Ok((of(times)?, times))
}

fn digests(mark: &soak::Mark) -> String {
    mark.digest.0.iter().map(|(kind, digest)| format!("{} {digest}", kind.name())).collect::<Vec<_>>().join(", ")
}

fn shown(soak: &Soak, scenario: &Scenario, times: usize) -> Shown {
    let rows = soak.contour_error_um.0.iter().zip(&soak.fault_cycles.0).map(|((kind, size), (_, faults))| {
        let faults = Cell::count(*faults as usize);
        vec![kind.name().into(), Cell::fixed(size.max, 3), Cell::fixed(size.rms, 3), faults]
    });
    let head = ["machine", "contour error largest, µm", "RMS, µm", "cycles with a fault"];
    let marks = soak.marks.len();
    let result = if soak.differences.is_empty() {
        let end = soak.marks.last().map(digests).unwrap_or_default();
        format!("all runs the same at {marks} marks; digests at the end: {end}")
    } else {
        format!("marks that differ: {} of {}", soak.differences.len(), marks * (soak.runs - 1))
    };
    let resident = soak
        .resident_kb
        .map(|[first, last]| format!("resident memory {first} kB at the first mark, {last} kB at the last"));
    Shown {
        title: "Soak".into(),
        summary: vec![
            format!("{} {}", scenario.program.name, counted(times, "time")),
            format!("{:.2} h at {} Hz", soak.simulated_s / 3600.0, scenario.rate_hz()),
            format!("{} cycles", soak.cycles),
            format!("{} side by side in {:.0} s", counted(soak.runs, "run"), soak.wall_s),
        ],
        result,
        notes: resident.into_iter().collect(),
        tables: vec![Table::new("The first run", head, rows)],
        ..Shown::default()
    }
}
