//! Runs the same long simulation several times in parallel on a busy host; the results must agree bit for bit.
//!
//! Every run has a separate thread, plant, plugin and motion, and advances in strides of a different length, so that the
//! kernel schedules them differently. Each run makes twenty-four marks, at which the digests of all outputs so far must agree.

use anyhow::{Result, anyhow};
use serde::Serialize;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, mpsc};
use std::thread;
use std::time::Duration;
use trueaxis_sim::Scenario;
use trueaxis_sim::run::{ByKind, Kind, Run, Size};

/// Number of marks per run.
pub const MARKS: u64 = 24;

/// Cycles per stride: `STRIDE`, plus `STRIDE_MORE` times the number of the run.
const STRIDE: u64 = 4096;
const STRIDE_MORE: u64 = 997;

/// Interval between two updates of the progress.
const UPDATE_EVERY: Duration = Duration::from_millis(200);

/// State of a run at a mark.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mark {
    /// Cycles simulated.
    pub cycle: u64,
    /// Digest of all outputs of the step so far.
    pub digest: ByKind<String>,
}

/// A mark of a run that differs from the first run's.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Number of the run, from 1.
    pub run: usize,
    /// The run's mark.
    pub found: Mark,
    /// The first run's mark.
    pub needed: Mark,
}

/// Result of a soak.
#[derive(Debug, Serialize)]
pub struct Soak {
    /// Number of parallel runs.
    pub runs: usize,
    /// Cycles of each run.
    pub cycles: u64,
    /// Simulated time of each run, s.
    pub simulated_s: f64,
    /// The first run's marks.
    pub marks: Vec<Mark>,
    /// Every mark of another run that differs; empty if all agree.
    pub differences: Vec<Difference>,
    /// True contour error of the tool tip while cutting, µm, in the first run.
    pub contour_error_um: ByKind<Size>,
    /// Cycles with a fault, in the first run.
    pub fault_cycles: ByKind<u64>,
    /// Resident memory of the process at the first and at the last mark, kB; `None` if the system does not report it.
    pub resident_kb: Option<[u64; 2]>,
    /// Wall time, s.
    pub wall_s: f64,
}

/// Runs all `scenarios` to their ends in parallel. `progress` gets the fraction done, 0 to 1.
///
/// # Errors
/// As [`Run::of`]; or a run panics.
pub fn soak(scenarios: &[Arc<Scenario>], kinds: &[Kind], progress: &mut dyn FnMut(f64)) -> Result<Soak> {
    let runs =
        scenarios.iter().map(|scenario| Ok(Run::of(Arc::clone(scenario), kinds)?)).collect::<Result<Vec<_>>>()?;
    let first = runs.first().ok_or_else(|| anyhow!("found no run, needed at least one"))?;
    let (cycles, simulated_s) = (first.cycles(), scenarios[0].time_s(first.cycles()));
    let (done, all) = (AtomicU64::new(0), runs.iter().map(Run::cycles).sum::<u64>());
    let started = std::time::Instant::now();
    let (finished, resident_kb) = thread::scope(|scope| {
        let (sender, marks) = mpsc::channel();
        let threads: Vec<_> = runs
            .into_iter()
            .enumerate()
            .map(|(number, run)| {
                let (done, sender) = (&done, sender.clone());
                scope.spawn(move || one(run, kinds, STRIDE + number as u64 * STRIDE_MORE, done, &sender))
            })
            .collect();
        drop(sender);
        let resident = watch(&marks, || progress(done.load(Ordering::Relaxed) as f64 / all as f64));
        let finished = threads.into_iter().map(|t| t.join().map_err(|_| anyhow!("a run panicked")));
        (finished.collect::<Result<Vec<_>>>(), resident)
    });
    let mut finished = finished?.into_iter();
    let (run, marks) = finished.next().ok_or_else(|| anyhow!("found no run, needed at least one"))?;
    let differences = finished.enumerate().flat_map(|(number, (_, others))| {
        let pairs = others.into_iter().zip(&marks).filter(|(found, needed)| found != *needed);
        pairs.map(|(found, needed)| Difference { run: number + 2, found, needed: needed.clone() }).collect::<Vec<_>>()
    });
    let tallies = run.tallies();
    let by_kind = || kinds.iter().copied().zip(&tallies);
    Ok(Soak {
        runs: scenarios.len(),
        cycles,
        simulated_s,
        differences: differences.collect(),
        contour_error_um: ByKind(by_kind().map(|(kind, t)| (kind, t.error.into())).collect()),
        fault_cycles: ByKind(by_kind().map(|(kind, t)| (kind, t.fault_cycles())).collect()),
        marks,
        resident_kb,
        wall_s: started.elapsed().as_secs_f64(),
    })
}

/// Runs one simulation to its end; sends the number of each mark.
fn one(mut run: Run, kinds: &[Kind], stride: u64, done: &AtomicU64, word: &mpsc::Sender<u64>) -> (Run, Vec<Mark>) {
    let mut marks = Vec::new();
    for number in 1..=MARKS {
        let until = run.cycles() * number / MARKS;
        while run.cycle() < until {
            let before = run.cycle();
            let continues = run.advance(stride.min(until - before), &mut ());
            done.fetch_add(run.cycle() - before, Ordering::Relaxed);
            if !continues {
                break;
            }
        }
        let digests = kinds.iter().zip(run.tallies()).map(|(kind, t)| (*kind, format!("{:08x}", t.digest)));
        marks.push(Mark { cycle: run.cycle(), digest: ByKind(digests.collect()) });
        // The receiver is gone only if the whole soak has failed.
        let _ = word.send(number);
    }
    (run, marks)
}

/// Until every run has ended: reports progress, and returns the resident memory at the first and at the last mark.
fn watch(marks: &mpsc::Receiver<u64>, mut progress: impl FnMut()) -> Option<[u64; 2]> {
    let mut resident: Option<[u64; 2]> = None;
    loop {
        match marks.recv_timeout(UPDATE_EVERY) {
            Ok(_) => {
                if let Some(now) = resident_kb() {
                    resident.get_or_insert([now, now])[1] = now;
                }
            }
            Err(mpsc::RecvTimeoutError::Timeout) => {}
            Err(mpsc::RecvTimeoutError::Disconnected) => return resident,
        }
        progress();
    }
}

/// Resident memory of this process, kB.
fn resident_kb() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::sample_machine;
    use trueaxis_sim::Settings;
    use trueaxis_sim::program::Program;
    use trueaxis_tables::Machine;

    fn scenario(seed: u64) -> Arc<Scenario> {
        let machine = Machine::read(&sample_machine("mill-3axis")).unwrap();
        let program = Program::builtin("short-tour").unwrap().unwrap();
        Arc::new(Scenario::new(machine, program, Settings { rate_hz: 1000.0, seed, ..Settings::default() }).unwrap())
    }

    /// The digests of a single run in one piece.
    fn alone(kinds: &[Kind]) -> Vec<String> {
        let mut run = Run::of(scenario(1), kinds).unwrap();
        while run.advance(u64::MAX, &mut ()) {}
        run.tallies().iter().map(|t| format!("{:08x}", t.digest)).collect()
    }

    #[test]
    fn side_by_side_and_alone_are_the_same() {
        let mut fraction = 0.0;
        let soak = soak(&[1, 1, 1].map(scenario), &Kind::ALL, &mut |now| fraction = now).unwrap();
        assert_eq!(soak.differences, []);
        assert_eq!((soak.runs, soak.marks.len(), fraction), (3, MARKS as usize, 1.0));
        let last = soak.marks.last().unwrap();
        assert_eq!(last.cycle, soak.cycles);
        assert_eq!(last.digest.0.iter().map(|(_, digest)| digest.clone()).collect::<Vec<_>>(), alone(&Kind::ALL));
        assert_ne!(soak.marks[0].digest, last.digest);
    }

    #[test]
    fn a_run_that_differs_is_named() {
        let soak = soak(&[1, 1, 2].map(scenario), &[Kind::Compensated], &mut |_| {}).unwrap();
        assert_eq!(soak.differences.len(), MARKS as usize);
        assert!(soak.differences.iter().all(|d| d.run == 3 && d.found.cycle == d.needed.cycle && d.found != d.needed));
    }
}
