//! Many legs over all combinations and cores, and the report of the rules checked.

use super::combination::Combination;
use super::event::Event;
use super::leg::{Failure, Leg};
use super::rule::{Rule, Tally};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Growth of the resident memory that is ignored, kB: the allocator keeps some memory from legs of different sizes.
const FLAT_KB: u64 = 16 * 1024;
/// Number of first legs, in which the process allocates its memory.
const FIRST: u64 = 20;

/// Settings of a soak over all combinations.
#[derive(Clone, Copy, Debug)]
pub struct Soak {
    /// Seed of all random draws.
    pub seed: u64,
    /// Minimum number of cycles.
    pub cycles: u64,
    /// Cycles of a leg, excluding the way home.
    pub leg_cycles: u64,
    /// Threads.
    pub jobs: usize,
}

/// Results of a soak.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Day of the run, UTC.
    pub date: String,
    /// Commit of the sources.
    pub commit: String,
    /// Seed of everything that was drawn.
    pub seed: u64,
    /// Total number of cycles, including the ways home.
    pub cycles: u64,
    /// Total number of legs, each of which returned home with the bits of its start.
    pub legs: u64,
    /// Cycles of a leg, excluding the way home.
    pub leg_cycles: u64,
    /// Number of broken rules.
    pub broken: u64,
    /// Wall time, s.
    pub seconds: f64,
    /// Threads.
    pub jobs: usize,
    /// Resident memory after the first legs and at the end, kB.
    pub resident_kb: [u64; 2],
    /// Number of times each rule was checked.
    pub rules: BTreeMap<&'static str, u64>,
    /// Number of times each event began.
    pub events: BTreeMap<&'static str, u64>,
    /// Cycles of each combination.
    pub combinations: BTreeMap<String, u64>,
}

#[derive(Default)]
struct Sums {
    tally: Tally,
    events: [u64; Event::ALL.len()],
    combinations: BTreeMap<usize, u64>,
    cycles: u64,
    legs: u64,
    resident_kb: u64,
}

/// Reason why a soak failed.
#[derive(Debug)]
pub enum Spoilt {
    /// A rule was broken; reduced to the events needed.
    Broken(Box<Failure>),
    /// Rules that were never checked.
    Idle(Vec<&'static str>),
    /// The resident memory grew, kB.
    Grown([u64; 2]),
}

impl std::fmt::Display for Spoilt {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Spoilt::Broken(failure) => failure.fmt(f),
            Spoilt::Idle(rules) => write!(f, "never tried: {}", rules.join(", ")),
            Spoilt::Grown([start, end]) => write!(f, "memory grew from {start} kB to {end} kB"),
        }
    }
}

impl std::error::Error for Spoilt {}

impl Soak {
    /// Walks until the number of cycles is reached and every combination has run, or until `stop` is set; `progress` gets the
    /// cycles of every completed leg.
    ///
    /// # Errors
    /// A rule is broken or was never checked; or the memory grew.
    pub fn run(&self, stop: &AtomicBool, progress: impl Fn(u64) + Sync) -> Result<Report, Spoilt> {
        let begun = Instant::now();
        let combinations = Combination::all().len() as u64;
        let (next, done) = (AtomicU64::new(0), AtomicU64::new(0));
        let (sums, failed) = (Mutex::new(Sums::default()), Mutex::new(None));
        let work = || {
            while !stop.load(Ordering::Relaxed) {
                let number = next.fetch_add(1, Ordering::Relaxed);
                if number >= combinations && done.load(Ordering::Relaxed) >= self.cycles {
                    return;
                }
                match Leg::new(self.seed, number, self.leg_cycles).walk_twice_now_and_then() {
                    Ok(walked) => {
                        done.fetch_add(walked.cycles, Ordering::Relaxed);
                        progress(walked.cycles);
                        let mut sums = sums.lock().unwrap_or_else(PoisonError::into_inner);
                        sums.tally.add(&walked.tally);
                        sums.events.iter_mut().zip(walked.events).for_each(|(sum, count)| *sum += count);
                        *sums.combinations.entry(walked.combination).or_default() += walked.cycles;
                        sums.cycles += walked.cycles;
                        sums.legs += 1;
                        if sums.legs == FIRST * self.jobs as u64 {
                            sums.resident_kb = resident_kb();
                        }
                    }
                    Err(failure) => {
                        stop.store(true, Ordering::Relaxed);
                        failed.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(failure);
                    }
                }
            }
        };
        std::thread::scope(|scope| {
            for _ in 0..self.jobs {
                scope.spawn(work);
            }
        });
        if let Some(failure) = failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
            return Err(Spoilt::Broken(Box::new(Leg::shrink(&failure))));
        }
        let sums = sums.into_inner().unwrap_or_else(PoisonError::into_inner);
        self.report(&sums, begun.elapsed().as_secs_f64())
    }

    fn report(&self, sums: &Sums, seconds: f64) -> Result<Report, Spoilt> {
        let idle: Vec<_> = sums.tally.idle().map(Rule::name).collect();
        if !idle.is_empty() {
            return Err(Spoilt::Idle(idle));
        }
        let resident_kb = [sums.resident_kb, resident_kb()];
        if sums.resident_kb > 0 && resident_kb[1] > resident_kb[0] + FLAT_KB {
            return Err(Spoilt::Grown(resident_kb));
        }
        let all = Combination::all();
        Ok(Report {
            date: said("date", &["-u", "+%F"]),
            commit: said("git", &["describe", "--always", "--dirty", "--abbrev=12"]),
            seed: self.seed,
            cycles: sums.cycles,
            legs: sums.legs,
            leg_cycles: self.leg_cycles,
            broken: 0,
            seconds,
            jobs: self.jobs,
            resident_kb,
            rules: Rule::ALL.iter().map(|rule| (rule.name(), sums.tally.of(*rule))).collect(),
            events: Event::ALL.iter().map(|event| (event.text(), sums.events[*event as usize])).collect(),
            combinations: sums.combinations.iter().map(|(place, cycles)| (all[*place].to_string(), *cycles)).collect(),
        })
    }
}

/// Resident memory of this process, kB; 0 if the system does not report it.
fn resident_kb() -> u64 {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages: u64 = statm.split_whitespace().nth(1).and_then(|pages| pages.parse().ok()).unwrap_or(0);
    4 * pages
}

/// The first line of another program's output.
fn said(program: &str, arguments: &[&str]) -> String {
    let output = std::process::Command::new(program).args(arguments).output();
    output.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned()).unwrap_or_default()
}
