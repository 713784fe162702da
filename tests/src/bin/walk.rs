//! The long walk: the requested number of cycles, over all combinations, checked against the contract of the step.

use anyhow::{Context, Result, bail};
use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use trueaxis_tests::walk::{Leg, Soak};

/// Walks the step through random sequences and checks every cycle against its contract.
#[derive(Parser)]
struct WalkArgs {
    /// Total number of cycles.
    #[arg(long, default_value_t = 1_000_000)]
    cycles: u64,
    /// Seed of all random draws.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads [default: the number of cores].
    #[arg(long)]
    jobs: Option<usize>,
    /// Cycles of a leg.
    #[arg(long, default_value_t = 40_000)]
    leg_cycles: u64,
    /// Only the leg with this number, as named by a failure.
    #[arg(long)]
    leg: Option<u64>,
    /// The report as JSON on stdout.
    #[arg(long)]
    json: bool,
    /// The report as TOML, into a file.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

fn main() -> Result<()> {
    let arguments = WalkArgs::parse();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    if let Some(number) = arguments.leg {
        let leg = Leg::new(arguments.seed, number, arguments.leg_cycles);
        return match leg.walk() {
            Ok(walked) => {
                println!("leg {number}, {}: {} cycles, nothing broken", leg.combination, walked.cycles);
                Ok(())
            }
            Err(failure) => bail!("{}", Leg::shrink(&failure)),
        };
    }
    let bar = ProgressBar::new(arguments.cycles);
    bar.set_style(ProgressStyle::with_template("{bar:40} {human_pos} of {human_len} cycles, {per_sec}, {eta} left")?);
    let soak = Soak {
        seed: arguments.seed,
        cycles: arguments.cycles,
        leg_cycles: arguments.leg_cycles,
        jobs: arguments.jobs.unwrap_or(cores).max(1),
    };
    // When interrupted, it still reports its results so far.
    static STOP: AtomicBool = AtomicBool::new(false);
    ctrlc::set_handler(|| STOP.store(true, Ordering::Relaxed))?;
    let report = soak.run(&STOP, |cycles| bar.inc(cycles))?;
    bar.finish_and_clear();
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        let per_cycle = 1e9 * report.seconds * report.jobs as f64 / report.cycles as f64;
        println!(
            "{} cycles in {} legs, {} rules, none broken; {:.0} s, {per_cycle:.0} ns a cycle and core; {} to {} kB",
            report.cycles,
            report.legs,
            report.rules.len(),
            report.seconds,
            report.resident_kb[0],
            report.resident_kb[1]
        );
    }
    if let Some(file) = arguments.output {
        let text = toml::to_string(&report)?;
        std::fs::write(&file, text).with_context(|| file.display().to_string())?;
    }
    Ok(())
}
