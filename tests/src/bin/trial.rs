//! The trial: how the dynamic correction does on plants with resonance, play, friction and a cut that it does not know.

use anyhow::{Context, Result, ensure};
use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use trueaxis::Dynamics;
use trueaxis_tests::trial::{Bands, Case, Conditions, Resonance, Tally, trial};

/// Runs plants of a family without and with the parts of the dynamic correction, and counts those that get worse by more
/// than 5 %.
#[derive(Parser)]
struct TrialArgs {
    /// Number of plants.
    #[arg(long, default_value_t = 10_000)]
    plants: usize,
    /// Seed of all random draws.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads [default: the number of cores].
    #[arg(long)]
    jobs: Option<usize>,
    /// Without side load and chatter.
    #[arg(long)]
    quiet: bool,
    /// Give the plugin the resonance of each drive, as if identified.
    #[arg(long)]
    stated: bool,
    /// The parts act only as far as the contour error shows that they help.
    #[arg(long)]
    on_trial: bool,
    /// Only the plant with this number, as JSON.
    #[arg(long)]
    plant: Option<usize>,
    /// The table, into a file.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

fn main() -> Result<()> {
    let arguments = TrialArgs::parse();
    let resonance = if arguments.stated { Resonance::Stated } else { Resonance::Unknown };
    let rule = if arguments.on_trial { Dynamics::ON_TRIAL } else { Dynamics::NONE };
    let conditions = Conditions { resonance, quiet: arguments.quiet, rule };
    if let Some(number) = arguments.plant {
        println!("{}", serde_json::to_string_pretty(&Case::run(arguments.seed, number, conditions, &mut 0))?);
        return Ok(());
    }
    let bar = ProgressBar::new(arguments.plants as u64);
    bar.set_style(ProgressStyle::with_template("{bar:40} {human_pos} of {human_len} plants, {eta} left")?);
    static STOP: AtomicBool = AtomicBool::new(false);
    ctrlc::set_handler(|| STOP.store(true, Ordering::Relaxed))?;
    let jobs = arguments.jobs.unwrap_or(std::thread::available_parallelism().map_or(1, usize::from)).max(1);
    let (cases, unsound) = trial(arguments.seed, arguments.plants, conditions, jobs, &STOP, || bar.inc(1));
    bar.finish_and_clear();
    let head = format!(
        "seed {}: {} plants; {unsound} more were drawn whose drives are not sound by themselves\n\
         worse: p99.9 or RMS of the contour error more than 5 % larger than without any part\n\
         unstable: vibration at the end of the run more than three times what it is without any part\n\
         chatter: motion at the frequency of the chatter more than 5 % larger than without any part\n\n",
        arguments.seed,
        cases.len()
    );
    let table: Vec<String> = Tally::of(&cases).iter().map(ToString::to_string).collect();
    let text = head + &table.join("\n") + &format!("\n{}", Bands::of(&cases));
    print!("{text}");
    if let Some(file) = arguments.output {
        std::fs::write(&file, text).with_context(|| file.display().to_string())?;
    }
    ensure!(cases.len() == arguments.plants, "stopped after {} of {} plants", cases.len(), arguments.plants);
    Ok(())
}
