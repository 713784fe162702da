//! Runs the attack: targets in sequence or in parallel, or a single input again.

use anyhow::{Context, Result, bail};
use clap::{Args, Parser, Subcommand};
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use trueaxis_fuzz::campaign::{Campaign, Tally, Until};
use trueaxis_fuzz::execution::execute;
use trueaxis_fuzz::finding::{self, Finding};
use trueaxis_fuzz::targets::{TARGETS, named};
use trueaxis_fuzz::{Target, corpus};

/// An execution that takes longer is considered endless.
const ENDLESS: Duration = Duration::from_secs(30);

/// Attacks the untrusted inputs of trueaxis with mutants from a seed.
#[derive(Parser)]
#[command(name = "trueaxis-fuzz", args_conflicts_with_subcommands = true)]
struct FuzzArgs {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    attack: Attack,
}

#[derive(Subcommand)]
enum Command {
    /// Runs inputs once: a finding, a file that `unpack` has written.
    Run {
        /// Target that reads them.
        target: String,
        /// The inputs.
        #[arg(required = true)]
        files: Vec<PathBuf>,
    },
    /// Lists the targets.
    List,
    /// Writes the starting data of another fuzzer: seeds into DIR/TARGET, words into DIR/TARGET.dict, and the largest
    /// length of an input into DIR/TARGET.longest.
    Seeds {
        /// Folder.
        dir: PathBuf,
        /// Targets [default: all].
        targets: Vec<String>,
    },
    /// Adds an input to the corpus of a target, under a name: a finding that was fixed.
    Add {
        /// Target that reads it.
        target: String,
        /// Its name in the corpus: finding-WHAT.
        name: String,
        /// The input.
        file: PathBuf,
    },
    /// Writes the corpus of each target into DIR/TARGET, one file per input.
    Unpack {
        /// Folder.
        dir: PathBuf,
        /// Targets [default: all].
        targets: Vec<String>,
    },
    /// Replaces the corpus of each target by the files of DIR/TARGET.
    Pack {
        /// Folder.
        dir: PathBuf,
        /// Targets [default: all].
        targets: Vec<String>,
    },
}

#[derive(Args)]
struct Attack {
    /// Targets [default: all].
    #[arg(value_name = "TARGET")]
    targets: Vec<String>,
    /// Time for each target, s.
    #[arg(long, value_name = "S", conflicts_with = "executions")]
    seconds: Option<u64>,
    /// Inputs for each target; repeats exactly.
    #[arg(long, value_name = "N", default_value_t = 100_000)]
    executions: u64,
    /// Seed of the mutants.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Number of targets run in parallel.
    #[arg(long, value_name = "J", default_value_t = 1)]
    jobs: usize,
    /// Print a line of JSON for each target instead of the table.
    #[arg(long)]
    json: bool,
}

fn main() -> Result<ExitCode> {
    let arguments = FuzzArgs::parse();
    match arguments.command {
        None => attack(&arguments.attack),
        Some(Command::Run { target, files }) => run(&target, &files),
        Some(Command::List) => {
            TARGETS.iter().for_each(|target| println!("{:<16} {}", target.name, target.about));
            Ok(ExitCode::SUCCESS)
        }
        Some(Command::Seeds { dir, targets }) => {
            chosen(&targets)?.into_iter().try_for_each(|target| write_seeds(&dir, target))?;
            Ok(ExitCode::SUCCESS)
        }
        Some(Command::Add { target, name, file }) => {
            let input = std::fs::read(&file).with_context(|| file.display().to_string())?;
            corpus::add(&corpus::archive(one(&target)?), &name, input)?;
            Ok(ExitCode::SUCCESS)
        }
        Some(Command::Unpack { dir, targets }) => {
            chosen(&targets)?.into_iter().try_for_each(|target| {
                corpus::spread(&corpus::read(&corpus::archive(target))?, &dir.join(target.name))
            })?;
            Ok(ExitCode::SUCCESS)
        }
        Some(Command::Pack { dir, targets }) => {
            pack(&dir, &chosen(&targets)?)?;
            Ok(ExitCode::SUCCESS)
        }
    }
}

fn write_seeds(dir: &Path, target: &Target) -> Result<()> {
    let folder = dir.join(target.name);
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    for (number, seed) in (target.seeds)().into_iter().enumerate() {
        std::fs::write(folder.join(format!("seed-{number}")), seed)?;
    }
    std::fs::write(folder.with_extension("dict"), target.dictionary)?;
    std::fs::write(folder.with_extension("longest"), target.longest().to_string())?;
    Ok(())
}

/// Reads all inputs before writing the first archive.
fn pack(dir: &Path, targets: &[&Target]) -> Result<()> {
    let folders = targets.iter().map(|target| corpus::gather(&dir.join(target.name))).collect::<Result<Vec<_>>>()?;
    targets.iter().zip(&folders).try_for_each(|(target, inputs)| corpus::write(&corpus::archive(target), inputs))
}

fn one(name: &str) -> Result<&'static Target> {
    Ok(chosen(&[name.to_owned()])?[0])
}

fn chosen(names: &[String]) -> Result<Vec<&'static Target>> {
    if names.is_empty() {
        return Ok(TARGETS.to_vec());
    }
    let known = || TARGETS.iter().map(|target| target.name).collect::<Vec<_>>().join(", ");
    names
        .iter()
        .map(|name| named(name).with_context(|| format!("no target {name}; the targets are {}", known())))
        .collect()
}

fn run(target: &str, files: &[PathBuf]) -> Result<ExitCode> {
    let target = one(target)?;
    let mut broken = false;
    for file in files {
        let input = std::fs::read(file).with_context(|| file.display().to_string())?;
        let start = Instant::now();
        match execute(target, &input) {
            Ok(outcome) => {
                let kind = if outcome.accepted { "accepted" } else { "refused" };
                println!("{}: {kind}, {:.1} us", file.display(), start.elapsed().as_secs_f64() * 1e6);
            }
            Err(what) => {
                broken = true;
                println!("{}: {what}", file.display());
            }
        }
    }
    Ok(ExitCode::from(u8::from(broken)))
}

/// The current execution of a worker, for the watchdog.
struct Desk {
    target: &'static Target,
    execution: u64,
    since: Instant,
    input: Vec<u8>,
}

fn attack(attack: &Attack) -> Result<ExitCode> {
    let targets = chosen(&attack.targets)?;
    if targets.is_empty() {
        bail!("no targets");
    }
    let until = attack.seconds.map_or(Until::Executions(attack.executions), |s| Until::Elapsed(Duration::from_secs(s)));
    let bars = MultiProgress::new();
    let (next, failed) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let results = Mutex::new(Vec::new());
    let desks: Arc<Vec<Mutex<Option<Desk>>>> = Arc::new((0..attack.jobs.max(1)).map(|_| Mutex::new(None)).collect());
    watch(Arc::clone(&desks), attack.seed);
    std::thread::scope(|scope| {
        for desk in desks.iter() {
            scope.spawn(|| {
                while let Some(target) = targets.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let ended = campaign(target, attack.seed, until, desk, &bars);
                    failed.fetch_add(usize::from(!matches!(ended, Ok((_, None)))), Ordering::Relaxed);
                    let mut results = results.lock().unwrap_or_else(PoisonError::into_inner);
                    results.push((target.name, ended));
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by_key(|(name, _)| targets.iter().position(|target| target.name == *name));
    for (name, ended) in results {
        let (tally, found) = ended.with_context(|| name.to_owned())?;
        print_result(name, attack.seed, &tally, found.as_deref(), attack.json);
    }
    Ok(ExitCode::from(u8::from(failed.into_inner() > 0)))
}

type Ended = Result<(Tally, Option<String>)>;

fn campaign(
    target: &'static Target,
    seed: u64,
    until: Until,
    desk: &Mutex<Option<Desk>>,
    bars: &MultiProgress,
) -> Ended {
    let bar = bars.add(match until {
        Until::Executions(most) => ProgressBar::new(most),
        Until::Elapsed(most) => ProgressBar::new(most.as_millis() as u64),
    });
    bar.set_style(ProgressStyle::with_template("{prefix:<16} {wide_bar} {msg} {eta}")?);
    bar.set_prefix(target.name);
    let mut campaign = Campaign::new(target, seed, corpus::inputs(target)?);
    let mut last = Tally::default();
    let ended = campaign.run(until, &mut |tally, input| {
        last = *tally;
        sit(desk, target, tally.executions, input);
        if tally.executions.is_multiple_of(1024) {
            bar.set_position(match until {
                Until::Executions(_) => tally.executions,
                Until::Elapsed(_) => (tally.seconds * 1e3) as u64,
            });
            bar.set_message(format!("{} · {:.0}/s · {} outcomes", tally.executions, tally.rate(), tally.outcomes));
        }
        ControlFlow::Continue(())
    });
    bar.finish_and_clear();
    *desk.lock().unwrap_or_else(PoisonError::into_inner) = None;
    match ended {
        Ok(tally) => Ok((tally, None)),
        Err(finding) => Ok((last, Some(written(target, &finding)?))),
    }
}

fn sit(desk: &Mutex<Option<Desk>>, target: &'static Target, execution: u64, input: &[u8]) {
    let since = Instant::now();
    let mut desk = desk.lock().unwrap_or_else(PoisonError::into_inner);
    match &mut *desk {
        Some(at) => {
            (at.execution, at.since) = (execution, since);
            at.input.clear();
            at.input.extend_from_slice(input);
        }
        none => *none = Some(Desk { target, execution, since, input: input.to_vec() }),
    }
}

fn written(target: &Target, finding: &Finding) -> Result<String> {
    let file = finding.write(&finding::folder(target))?;
    let shown = file.strip_prefix(corpus::home().parent().unwrap_or(corpus::home())).unwrap_or(&file);
    Ok(finding.report(shown))
}

/// Ends the program if an execution does not end.
fn watch(desks: Arc<Vec<Mutex<Option<Desk>>>>, seed: u64) {
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_millis(500));
            for desk in desks.iter() {
                let desk = desk.lock().unwrap_or_else(PoisonError::into_inner);
                let Some(Desk { target, execution, input, .. }) =
                    desk.as_ref().filter(|at| at.since.elapsed() > ENDLESS)
                else {
                    continue;
                };
                let what = format!("has not ended after {} s", ENDLESS.as_secs());
                let finding = Finding { target: target.name, seed, execution: *execution, what, input: input.clone() };
                match written(target, &finding) {
                    Ok(report) => eprintln!("{report}"),
                    Err(error) => eprintln!("{error:#}"),
                }
                std::process::exit(1);
            }
        }
    });
}

fn print_result(name: &str, seed: u64, tally: &Tally, found: Option<&str>, json: bool) {
    if json {
        let line = serde_json::json!({
            "target": name, "seed": seed, "executions": tally.executions, "seconds": tally.seconds,
            "per_second": tally.rate(), "accepted": tally.accepted, "outcomes": tally.outcomes, "inputs": tally.inputs,
            "finding": found,
        });
        println!("{line}");
        return;
    }
    let Tally { executions, accepted, outcomes, seconds, .. } = tally;
    println!(
        "{name:<16} {executions:>10} executions, {:>7.0}/s, {seconds:.0} s, {accepted} accepted, {outcomes} outcomes, {}",
        tally.rate(),
        if found.is_some() { "ONE FINDING" } else { "nothing found" }
    );
    if let Some(report) = found {
        println!("{report}");
    }
}
