//! `firmware-sim bench`: arguments and output.

use crate::console::put;
use crate::scenario_args::{ScenarioArgs, prepare};
use anyhow::{Result, bail};
use clap::Args;
use firmware_sim::bench;
use serde_json::json;
use trueaxis_evaluation::shown::{Cell, Shown, Table};
use trueaxis_tables::text::counted;

#[derive(Args)]
#[command(before_help = "Example:\n  firmware-sim bench --cycles 100000")]
pub(crate) struct BenchArgs {
    #[command(flatten)]
    scenario: ScenarioArgs,
    /// Steps to time.
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    cycles: u64,
    /// Print one JSON document and nothing else.
    #[arg(long)]
    json: bool,
}

pub(crate) fn time(args: &BenchArgs) -> Result<()> {
    if args.cycles == 0 {
        bail!("--cycles: found 0, needed at least 1");
    }
    let scenario = prepare(&args.scenario, &[])?;
    let budget_ns = args.scenario.budget_ns(&scenario);
    let axes = scenario.machine.settings.step_axes().count();
    let outcome = match axes {
        3 => bench::run::<3>(&scenario, budget_ns, args.cycles),
        _ => bench::run::<6>(&scenario, budget_ns, args.cycles),
    }?;
    let l = outcome.latency;
    if args.json {
        let document = json!({
            "cycles": args.cycles,
            "latency_ns": { "min": l.min_ns, "p50": l.p50_ns, "p99": l.p99_ns, "p99_99": l.p99_99_ns, "max": l.max_ns },
            "budget_ns": l.budget_ns,
            "missed_deadlines": l.missed_deadlines,
            "steps_per_s": outcome.steps_per_s,
            "steps_per_s_with_plant": outcome.steps_per_s_with_plant,
        });
        return put(&trueaxis_evaluation::json::pretty(&document)?);
    }
    let figures = [
        ("minimum, ns", Cell::count(l.min_ns as usize)),
        ("median, ns", Cell::count(l.p50_ns as usize)),
        ("99 %, ns", Cell::count(l.p99_ns as usize)),
        ("99.99 %, ns", Cell::count(l.p99_99_ns as usize)),
        ("maximum, ns", Cell::count(l.max_ns as usize)),
        ("millions of steps a second", Cell::fixed(1e-6 * outcome.steps_per_s, 2)),
        ("millions with the simulated machine", Cell::fixed(1e-6 * outcome.steps_per_s_with_plant, 2)),
    ];
    let mut notes = vec!["single steps include the clock's reading; steps a second have no clock between them".into()];
    if matches!(axes, 4 | 5) {
        notes.push(format!("the simulator's step has six slots; a controller's with {axes} costs less"));
    }
    let shown = Shown {
        title: "Cost of one step".into(),
        summary: vec![
            format!("{} of {}", counted(args.cycles as usize, "step"), scenario.program.name),
            scenario.machine.settings.name.to_string(),
            "wall time on one core of this host".into(),
        ],
        notes,
        tables: vec![Table::figures("Cost", figures)],
        ..Shown::default()
    };
    put(&shown.text())
}
