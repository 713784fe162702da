//! Searches for dearer cycles than the drawn ones, by hill climbing on the counts.
//!
//! A climb begins with a scene of the adversary. An attempt takes the way to the dearest cycle so far and continues with other
//! random numbers from one of the last cycles before it on; it is kept if a cycle then costs more.

use crate::adversarial::Run;
use crate::arena::Arena;
use crate::forms::{AXES, Machine};
use cortex_m_semihosting::hprintln;
use trueaxis::State;
use trueaxis_recording::Integer;
use trueaxis_recording::adversary::{Adversary, CYCLES, SCENE};
use trueaxis_recording::outputs::Wire;

/// Cycles of a climb.
const LENGTH: u32 = 20_000;
/// Cycles before the dearest one that an attempt may change, and those that it runs beyond it.
const BEFORE: u32 = 24;
const BEYOND: u32 = 8;
/// Most changes on a way.
const MOST: usize = 64;
/// The climb to the dearest cycle of 50, found by `count.sh --climb 50` for the present step.
const DEAREST: u32 = if cfg!(feature = "double") { 3 } else { 4 };

/// A cycle of a scene from which on the random numbers are others, and their seed.
#[derive(Clone, Copy, Default)]
struct Change {
    at: u32,
    seed: u32,
}

/// The way to a cycle of a scene.
#[derive(Clone)]
struct Way {
    scene: u32,
    changes: [Change; MOST],
    count: usize,
    /// The dearest cycle and its instructions.
    at: u32,
    worst: u32,
}

/// A scene before one of its cycles.
struct Checkpoint<'a, R: Wire<Place = P>, P: Integer> {
    adversary: Adversary<'a, R, P>,
    state: State<R, P, AXES>,
}

impl Way {
    fn change(&self, at: u32) -> Option<u32> {
        self.changes[..self.count].iter().rfind(|change| change.at == at).map(|change| change.seed)
    }

    /// The way that leaves this one at a cycle.
    fn leaving(&self, at: u32, seed: u32) -> Option<Way> {
        let count = self.changes[..self.count].iter().filter(|change| change.at < at).count();
        let mut way = self.clone();
        *way.changes.get_mut(count)? = Change { at, seed };
        way.count = count + 1;
        Some(way)
    }

    /// Runs a cycle of the scene; returns its instructions.
    fn count<R: Wire<Place = P>, P: Integer>(&self, run: &mut Run<'_, R, P>, at: u32) -> u32 {
        if let Some(seed) = self.change(at) {
            run.adversary.divert(seed);
        }
        let (_, cycle) = run.draw(self.scene * SCENE + at);
        cycle.count_bare()
    }
}

/// Climbs from a scene.
fn climb<R: Wire<Place = P>, P: Integer>(run: &mut Run<'_, R, P>, scene: u32) -> Way {
    let mut best = Way { scene, changes: [Change::default(); MOST], count: 0, at: 0, worst: 0 };
    let mut ran = 0;
    for at in 0..SCENE {
        let count = best.count(run, at);
        if count > best.worst {
            (best.worst, best.at) = (count, at);
        }
    }
    let mut seed = scene << 16;
    while ran < LENGTH {
        // The first cycle of a scene draws the scene.
        let first = best.at.saturating_sub(BEFORE).max(1);
        if best.at < first {
            return best;
        }
        for at in 0..first {
            best.count(run, at);
        }
        ran += first;
        let checkpoint = Checkpoint { adversary: run.adversary.clone(), state: run.machine.bare_state() };
        let mut found = false;
        while !found && ran < LENGTH {
            seed += 1;
            let Some(mut way) = best.leaving(first + seed % (best.at - first + 1), seed) else { return best };
            run.adversary = checkpoint.adversary.clone();
            run.machine.set_bare_state(&checkpoint.state);
            let end = (best.at + BEYOND).min(SCENE - 1);
            for at in first..=end {
                let count = way.count(run, at);
                if count > way.worst {
                    (way.worst, way.at, found) = (count, at, true);
                }
            }
            ran += end - first + 1;
            if found {
                best = way;
            }
        }
    }
    best
}

fn print(scalar: &str, way: &Way) {
    let Way { scene, count, at, worst, .. } = way;
    hprintln!("{} climb worst {} at {} changes {} scene {}", scalar, worst, at, count, scene);
}

/// Climbs from as many scenes and prints the dearest cycle.
pub fn all<R: Wire<Place = P>, P: Integer>(scalar: &str, machine: &Machine<R, P>, climbs: u32, arena: &mut Arena) {
    let mut run = Run::new(machine, arena);
    for scene in 0..climbs.min(CYCLES / SCENE) {
        print(scalar, &climb(&mut run, scene));
    }
}

/// Climbs to the dearest cycle of all.
pub fn dearest<R: Wire<Place = P>, P: Integer>(scalar: &str, run: &mut Run<'_, R, P>) {
    print(scalar, &climb(run, DEAREST));
}
