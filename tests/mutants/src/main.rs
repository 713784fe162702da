//! Mutation testing of the core. cargo-mutants lists the mutants; one build holds them all, and each test run enables one.

mod campaign;
mod compile;
mod known;
mod list;
mod nodes;
mod process;
mod report;
mod results;
mod rewrite;
mod scratch;
mod trial;

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use clap::Parser;

use campaign::{Campaign, Switch};
use list::Mutant;
use results::{Results, Verdict};
use scratch::Scratch;

/// Mutates the core and lists the mutants that no test detects.
#[derive(Parser)]
struct Options {
    /// Only these rooms
    #[arg(long, value_parser = clap::builder::PossibleValuesParser::new(list::ROOMS))]
    room: Vec<String>,
    /// Only mutants whose file and change contain this text
    #[arg(long)]
    only: Option<String>,
    /// Only mutants on the lines of this diff
    #[arg(long)]
    in_diff: Option<PathBuf>,
    /// Write the survivors here
    #[arg(long)]
    survivors: Option<PathBuf>,
    /// Forget earlier verdicts; without it, survivors alone are tried again
    #[arg(long)]
    fresh: bool,
    /// Only mutants that an earlier run tried
    #[arg(long)]
    again: bool,
    /// Also try survivors that have a reason
    #[arg(long)]
    explained: bool,
    /// Try nothing, print the stored results
    #[arg(long)]
    report: bool,
    /// Stop so many seconds after the build
    #[arg(long)]
    seconds: Option<u64>,
    /// Packages whose tests have to detect the mutants
    #[arg(long, default_values_t = [String::from("trueaxis")])]
    package: Vec<String>,
    /// Arguments of `cargo test --no-run` that select tests of these packages
    #[arg(long, allow_hyphen_values = true)]
    tests: Vec<String>,
    /// Leave out tests that take longer, s
    #[arg(long, default_value_t = 2.0)]
    longest: f64,
    /// Processor time for the tests of one mutant, s
    #[arg(long, default_value_t = 60.0)]
    budget: f64,
    /// With `--seconds`: draw the order from this seed
    #[arg(long)]
    seed: Option<u64>,
    /// Exit with 1 if fewer mutants, in per cent of those tried, are killed or have a reason
    #[arg(long)]
    least: Option<f64>,
}

fn main() -> Result<()> {
    let options = Options::parse();
    let begun = Instant::now();
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = here.ancestors().nth(2).context("two folders up: the workspace")?;
    let scratch = Scratch::new(root, options.in_diff.is_some());
    std::fs::create_dir_all(scratch.file(""))?;
    let mutants = list::list(root, options.in_diff.as_deref())?;
    let known = known::explained(&here.join("equivalent.toml"))?;
    let verdicts = scratch.file("verdicts.tsv");
    if options.fresh {
        let _ = std::fs::remove_file(&verdicts);
    }
    let results = Mutex::new(Results::open(&verdicts)?);
    let chosen = |mutant: &Mutant| {
        (options.room.is_empty() || options.room.iter().any(|room| room == mutant.room()))
            && options.only.as_ref().is_none_or(|only| mutant.name.contains(only.as_str()))
    };
    let refusals = scratch.file(if options.in_diff.is_some() { "refused-diff.tsv" } else { "refused.tsv" });
    let mut refused = known::refused(&refusals, &mutants);
    if !options.report && !mutants.is_empty() {
        let files = compile::settle(&scratch, &mutants, &mut refused)?;
        known::keep(&refusals, &refused, &mutants)?;
        let switches = files.values().flat_map(|file| file.switches.iter().copied());
        let switches: Vec<Switch> = switches
            .filter(|&(number, ..)| {
                let (mutant, results) = (&mutants[number], results.lock().unwrap());
                // A survivor with a reason is not tried again; one without a reason is tried in every run.
                let open = match results.get(mutant) {
                    None => !options.again,
                    Some(Verdict::Survived | Verdict::Unreached) => {
                        options.explained || known::reason(&known, mutant).is_none()
                    }
                    Some(_) => false,
                };
                chosen(mutant) && open
            })
            .collect();
        hunt(&options, &scratch, &mutants, shuffled(switches, options.seed), &results, begun)?;
    }
    let unviable: HashSet<usize> = refused.mutants;
    let results = results.into_inner().unwrap();
    let (shown, unviable) = only_chosen(&mutants, &unviable, chosen);
    let fates = report::fates(&shown, &unviable, &results, &known);
    let survivors = report::survivors(&shown, &fates, &known);
    if options.in_diff.is_none() {
        for one in report::idle(&shown, &fates, &known) {
            eprintln!(
                "equivalent.toml: no survivor: {} {:?} {:?} {:?}",
                one.file, one.function, one.mutation, one.code
            );
        }
    }
    match &options.survivors {
        Some(path) => std::fs::write(path, &survivors).with_context(|| path.display().to_string())?,
        None if options.least.is_some() => println!("{survivors}"),
        None => {}
    }
    println!("{}", report::table(&shown, &fates));
    if let Some(least) = options.least {
        let share = report::explained(&fates);
        println!("detected or with a reason: {share:.1} %, needed at least {least} %");
        if share < least {
            std::process::exit(1);
        }
    }
    Ok(())
}

fn only_chosen(
    mutants: &[Mutant],
    unviable: &HashSet<usize>,
    chosen: impl Fn(&Mutant) -> bool,
) -> (Vec<Mutant>, HashSet<usize>) {
    let numbers: Vec<usize> = (0..mutants.len()).filter(|&n| chosen(&mutants[n])).collect();
    let shown = numbers.iter().map(|&n| mutants[n].clone()).collect();
    (shown, numbers.iter().enumerate().filter(|(_, n)| unviable.contains(n)).map(|(at, _)| at).collect())
}

fn hunt(
    options: &Options,
    scratch: &Scratch,
    mutants: &[Mutant],
    switches: Vec<Switch>,
    results: &Mutex<Results>,
    begun: Instant,
) -> Result<()> {
    if switches.is_empty() {
        return Ok(());
    }
    let programs = compile::programs(scratch, &options.package, &options.tests)?;
    eprintln!("built after {} s", begun.elapsed().as_secs());
    let folder = scratch.file(&format!("programs-{}", std::process::id()));
    let tests = trial::survey(&programs, &folder, Duration::from_secs_f64(options.longest))?;
    let all: Duration = tests.iter().map(|test| test.took).sum();
    eprintln!(
        "{} tests, {:.1} s; {} mutants to try, {} s",
        tests.len(),
        all.as_secs_f64(),
        switches.len(),
        begun.elapsed().as_secs()
    );
    let campaign = Campaign {
        mutants,
        programs: &programs,
        tests: &tests,
        budget: Duration::from_secs_f64(options.budget),
        // Counted from here, so that a long build does not use up the time.
        until: options.seconds.map(|seconds| Instant::now() + Duration::from_secs(seconds)),
        folder: &folder,
    };
    let tried = campaign.run(&switches, results)?;
    std::fs::remove_dir_all(&folder)?;
    println!("{tried} of {} mutants tried in {} s", switches.len(), begun.elapsed().as_secs());
    Ok(())
}

/// Orders the mutants randomly by the seed (xorshift, Marsaglia 2003), so that a bounded run is a sample of all.
fn shuffled(mut switches: Vec<Switch>, seed: Option<u64>) -> Vec<Switch> {
    let Some(seed) = seed else { return switches };
    let mut state = seed | 1;
    for at in (1..switches.len()).rev() {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        switches.swap(at, (state % (at as u64 + 1)) as usize);
    }
    switches
}
