//! Runs the mutants one by one, with only the tests that reach them, fast ones first, until one fails.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

use anyhow::Result;

use crate::compile::Program;
use crate::list::Mutant;
use crate::results::{Results, Verdict};
use crate::trial::{self, On, Outcome, Test};

/// At most two processes, because the machine is shared.
const JOBS: usize = 2;

/// Runs `work` for every item, two at a time; returns the results in the order of the items.
pub fn parallel<T: Sync, R: Send>(items: &[T], work: impl Fn(usize, &T) -> Result<R> + Sync) -> Result<Vec<R>> {
    let (next, results) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
    let failure: Mutex<Option<anyhow::Error>> = Mutex::new(None);
    std::thread::scope(|scope| {
        for worker in 0..JOBS {
            let (next, results, failure, work) = (&next, &results, &failure, &work);
            scope.spawn(move || {
                loop {
                    let number = next.fetch_add(1, Relaxed);
                    let Some(item) = items.get(number) else { return };
                    match work(worker, item) {
                        Ok(result) => drop(results.lock().unwrap().insert(number, result)),
                        Err(error) => {
                            *failure.lock().unwrap() = Some(error);
                            return;
                        }
                    }
                }
            });
        }
    });
    match failure.into_inner().unwrap() {
        Some(error) => Err(error),
        None => Ok(results.into_inner().unwrap().into_values().collect()),
    }
}

/// One mutant to try: its number, site and variant.
pub type Switch = (usize, usize, u8);

/// Inputs of a campaign.
pub struct Campaign<'a> {
    pub mutants: &'a [Mutant],
    pub programs: &'a [Program],
    pub tests: &'a [Test],
    /// Processor time after which no further tests are run for a mutant.
    pub budget: Duration,
    /// Time after which no new mutant is begun.
    pub until: Option<Instant>,
    pub folder: &'a Path,
}

impl Campaign<'_> {
    /// Tries the mutants; every verdict is stored in `results` at once. Returns the number of mutants tried.
    pub fn run(&self, switches: &[Switch], results: &Mutex<Results>) -> Result<usize> {
        let killers: Mutex<HashMap<&str, VecDeque<usize>>> = Mutex::new(HashMap::new());
        let (begun, done) = (Instant::now(), AtomicUsize::new(0));
        parallel(switches, |worker, &(number, site, variant)| {
            if self.until.is_some_and(|until| Instant::now() > until) {
                return Ok(());
            }
            let mutant = &self.mutants[number];
            let recent: Vec<usize> = killers
                .lock()
                .unwrap()
                .get(mutant.file.as_str())
                .map(|k| k.iter().copied().collect())
                .unwrap_or_default();
            let out = self.folder.join(format!("out-{worker}"));
            let (verdict, killer) = self.try_one((site, variant), &recent, &out)?;
            if let Some(killer) = killer {
                let mut killers = killers.lock().unwrap();
                let list = killers.entry(&mutant.file).or_default();
                list.retain(|&k| k != killer);
                list.push_front(killer);
                list.truncate(4);
            }
            results.lock().unwrap().set(mutant, verdict)?;
            let count = done.fetch_add(1, Relaxed) + 1;
            if count.is_multiple_of(250) {
                eprintln!("{count} of {}, {} s", switches.len(), begun.elapsed().as_secs());
            }
            Ok(())
        })?;
        Ok(done.into_inner())
    }

    fn try_one(&self, mutant: (usize, u8), recent: &[usize], out: &Path) -> Result<(Verdict, Option<usize>)> {
        let reaches = |test: &Test| test.reaches.contains(&mutant.0);
        let first = recent.iter().copied().filter(|&t| reaches(&self.tests[t]));
        let rest = (0..self.tests.len()).filter(|&t| reaches(&self.tests[t]) && !recent.contains(&t));
        let order: Vec<usize> = first.chain(rest).collect();
        if order.is_empty() {
            let reached = self.tests.iter().any(reaches);
            return Ok((if reached { Verdict::Survived } else { Verdict::Unreached }, None));
        }
        let (mut at, mut spent) = (0, Duration::ZERO);
        let mut allowed = Duration::from_millis(40);
        while at < order.len() && spent < self.budget {
            let program = self.tests[order[at]].program;
            let mut took = Duration::ZERO;
            let mut batch = Vec::new();
            for &test in &order[at..] {
                let test = &self.tests[test];
                if test.program != program || (!batch.is_empty() && took + test.took > allowed) {
                    break;
                }
                took += test.took;
                batch.push(test.name.as_str());
            }
            let limit = (0.5 + 10.0 * took.as_secs_f64()).ceil() as u64;
            let named = |name: &str| order.iter().copied().find(|&t| self.tests[t].name == name);
            let (outcome, cost) =
                trial::run(&self.programs[program], &batch, On::Mutant(mutant.0, mutant.1), out, limit)?;
            spent += cost;
            match outcome {
                Outcome::Passed => {}
                Outcome::Failed(by) => return Ok((Verdict::Killed(by.clone()), named(&by))),
                Outcome::TimedOut(by) => return Ok((Verdict::TimedOut(by), None)),
            }
            at += batch.len();
            allowed = (2 * allowed).min(Duration::from_secs(2));
        }
        Ok((Verdict::Survived, None))
    }
}
