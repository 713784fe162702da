//! A trial of the dynamic correction on a family of plants that it does not know: two masses with a resonance, friction on the
//! load, play and a cut, their drives sound without the plugin.

mod cut;
mod error;
mod plant;
mod run;
mod tally;

use serde::Serialize;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use trueaxis::Dynamics;
use trueaxis_testing::noise::Noise;

pub use cut::Cut;
pub use error::Size;
pub use plant::{Plant, Resonance};
pub use run::{Outcome, Shape};
pub use tally::{Bands, Improvement, Row, Tally};

/// The row in which the friction adapts: it has followed the track before, as often as [`run::BEFORE`], and is compared with
/// no part after as many passes: a second pass starts with the friction and the integrators of the first.
const ADAPTING: &str = "friction, adapting";

/// Combinations of parts that are compared with no part: name and parts.
pub const PARTS: [(&str, Dynamics); 7] = [
    ("everything", Dynamics::ALL),
    ("feed-forward", Dynamics(1 | 2 | 4)),
    ("friction", Dynamics::FRICTION),
    (ADAPTING, Dynamics::FRICTION),
    ("lag", Dynamics::LAG),
    ("acceleration", Dynamics::ACCELERATION),
    ("feedback", Dynamics::FEEDBACK),
];

/// A plant, its track and what came of it.
#[derive(Clone, Debug, Serialize)]
pub struct Case {
    /// Number of the plant, with which the seed draws it again.
    pub number: usize,
    /// The plant.
    pub plant: Plant,
    /// The track.
    pub shape: Shape,
    /// Feed, mm/s.
    pub feed_mm_per_s: f64,
    /// Side load and chatter.
    pub cut: Cut,
    /// Gains of the feedback, proportional and integral (1/s): 10 and the largest of a list up to 0.3 that is accepted.
    pub gains: Option<[f64; 2]>,
    /// Without any part.
    pub off: Outcome,
    /// Without any part, the track followed as often before as where the friction adapts.
    pub off_again: Outcome,
    /// With [`PARTS`].
    pub with: [Outcome; PARTS.len()],
}

impl Case {
    /// The reference for a combination of parts: no part, under the same conditions.
    pub fn without(&self, parts: usize) -> &Outcome {
        if PARTS.get(parts).is_some_and(|(name, _)| *name == ADAPTING) { &self.off_again } else { &self.off }
    }
}

/// What all plants of a trial have in common.
#[derive(Clone, Copy, Debug)]
pub struct Conditions {
    /// Whether the plugin knows the resonances.
    pub resonance: Resonance,
    /// Neither side load nor chatter.
    pub quiet: bool,
    /// [`Dynamics::ON_TRIAL`], or none.
    pub rule: Dynamics,
}

impl Case {
    /// Draws the plant of a number and runs it; adds to `refused` the unsound ones on the way.
    pub fn run(seed: u64, number: usize, conditions: Conditions, refused: &mut usize) -> Case {
        let mut random = Noise::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(number as u64));
        let plant = Plant::draw(&mut random, refused);
        let shape = [Shape::Circle, Shape::Line][number % 2];
        // 0.3 to 12 m/min.
        let feed_mm_per_s = 5.0 * 40.0_f64.powf(random.unit());
        // Drawn last: without it a number is the plant that it was before there was a cut.
        let cut = Cut::draw(&mut random);
        let cut = if conditions.quiet { cut.quiet() } else { cut };
        run::run(number, plant, shape, feed_mm_per_s, cut, conditions)
    }
}

/// Runs `plants` plants on `jobs` threads until `stop` is set; `progress` is called after each. Returns the cases in order of
/// their numbers, and how many drawn plants were not sound without the plugin.
pub fn trial(
    seed: u64,
    plants: usize,
    conditions: Conditions,
    jobs: usize,
    stop: &AtomicBool,
    progress: impl Fn() + Sync,
) -> (Vec<Case>, usize) {
    let next = AtomicUsize::new(0);
    let results = Mutex::new((Vec::new(), 0));
    let work = || {
        while !stop.load(Ordering::Relaxed) {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= plants {
                return;
            }
            let mut refused = 0;
            let case = Case::run(seed, number, conditions, &mut refused);
            let mut results = results.lock().unwrap_or_else(PoisonError::into_inner);
            results.0.push(case);
            results.1 += refused;
            progress();
        }
    };
    std::thread::scope(|scope| (0..jobs).for_each(|_| drop(scope.spawn(work))));
    let (mut cases, refused) = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    cases.sort_by_key(|case| case.number);
    (cases, refused)
}
