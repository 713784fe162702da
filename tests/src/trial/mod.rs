//! A trial of the dynamic correction on a family of plants that it does not know: two masses with a resonance, friction on the
//! load and play, their drives sound by themselves.

mod plant;
mod run;
mod tally;

use serde::Serialize;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use trueaxis::Dynamics;
use trueaxis_testing::noise::Noise;

pub use plant::Plant;
pub use run::{Outcome, Shape, Size};
pub use tally::{Row, Tally};

/// Combinations of parts that are compared with no part: name and parts.
pub const PARTS: [(&str, Dynamics); 6] = [
    ("everything", Dynamics::ALL),
    ("feed-forward", Dynamics(1 | 2 | 4)),
    ("friction", Dynamics::FRICTION),
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
    /// Gains of the feedback, proportional and integral (1/s): the largest up to 0.3 and 10 that are accepted.
    pub gains: Option<[f64; 2]>,
    /// Without any part.
    pub off: Outcome,
    /// With [`PARTS`].
    pub with: [Outcome; PARTS.len()],
}

impl Case {
    /// Draws the plant of a number and runs it; adds to `refused` the unsound ones on the way. `rule`: [`Dynamics::ON_TRIAL`]
    /// or none.
    pub fn run(seed: u64, number: usize, rule: Dynamics, refused: &mut usize) -> Case {
        let mut random = Noise::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(number as u64));
        let plant = Plant::draw(&mut random, refused);
        let shape = [Shape::Circle, Shape::Line][number % 2];
        // 0.3 to 12 m/min.
        let feed_mm_per_s = 5.0 * 40.0_f64.powf(random.unit());
        run::run(number, plant, shape, feed_mm_per_s, rule)
    }
}

/// Runs `plants` plants on `jobs` threads, by a `rule` as [`Case::run`], until `stop` is set; `progress` is called after each. Returns the cases in order of
/// their numbers, and how many drawn plants were not sound by themselves.
pub fn trial(
    seed: u64,
    plants: usize,
    jobs: usize,
    rule: Dynamics,
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
            let case = Case::run(seed, number, rule, &mut refused);
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
