//! The document of a bound.

use super::bound::Bounded;
use super::feeds::Slowed;
use super::{Family, Options};
use serde::Serialize;
use std::collections::BTreeMap;
use trueaxis_sim::Scenario;

/// Bound of the contour error along a program.
#[derive(Clone, Debug, Serialize)]
pub struct ServoBound {
    /// Name of the program.
    pub program: String,
    /// Name of the machine.
    pub machine: String,
    /// Servo rate.
    pub servo_rate_hz: f64,
    /// The family: shares of the figures that the machine states, and the resonance of its drives.
    pub family: Family,
    /// Largest error with the figures as stated.
    pub stated_um: f64,
    /// Bound over the family along the whole program.
    pub bound_um: f64,
    /// Plants simulated for the bound.
    pub simulated_plants: usize,
    /// Plants drawn beside the bound.
    pub drawn: Option<Drawn>,
    /// The bound that feeds are sought for.
    pub feed_for_um: Option<f64>,
    /// Every line that cuts.
    pub lines: Vec<LineBound>,
}

/// Plants drawn from the family.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Drawn {
    /// Number of plants.
    pub plants: usize,
    /// Their seed.
    pub seed: u64,
    /// Largest error of any of them.
    pub worst_um: f64,
    /// Smallest and largest bound of a line over the worst error on it.
    pub bound_over_worst: [f64; 2],
}

/// A line of the program.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LineBound {
    /// Number of the line in the file.
    pub line: u32,
    /// Programmed feed, mm/min (deg/min).
    pub feed_per_min: f64,
    /// Largest error with the figures as stated.
    pub stated_um: f64,
    /// Bound over the family.
    pub bound_um: f64,
    /// Largest error of the plants drawn.
    pub drawn_um: Option<f64>,
    /// Feed that keeps the wanted bound.
    pub feed_for: Option<FeedFor>,
}

/// A feed that keeps a wanted bound.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FeedFor {
    /// The feed, mm/min (deg/min); `None` if no feed tried keeps it.
    pub feed_per_min: Option<f64>,
    /// The bound with this feed, or with the lowest one tried.
    pub bound_um: f64,
}

impl ServoBound {
    pub(super) fn new(
        scenario: &Scenario,
        options: &Options,
        bounds: &BTreeMap<u32, Bounded>,
        simulated_plants: usize,
        drawn: Option<&BTreeMap<u32, f64>>,
        feeds: &BTreeMap<u32, Slowed>,
    ) -> ServoBound {
        let mut programmed: BTreeMap<u32, f64> = BTreeMap::new();
        for step in scenario.program.moves.iter().filter(|step| !step.rapid) {
            let feed = programmed.entry(step.line).or_default();
            *feed = feed.max(step.feed_per_min * scenario.settings.motion.feed_percent / 100.0);
        }
        let line = |(line, of): (&u32, &Bounded)| {
            let feed_per_min = programmed.get(line).copied().unwrap_or(0.0);
            let feed_for = feeds.get(line).zip(options.feed_for_um).map(|(slowed, wanted)| FeedFor {
                feed_per_min: (slowed.bound <= wanted).then_some(slowed.share * feed_per_min),
                bound_um: slowed.bound,
            });
            let drawn_um = drawn.and_then(|drawn| drawn.get(line).copied());
            LineBound { line: *line, feed_per_min, stated_um: of.stated, bound_um: of.bound, drawn_um, feed_for }
        };
        let lines: Vec<LineBound> = bounds.iter().map(line).collect();
        let most = |of: fn(&LineBound) -> f64| lines.iter().map(of).fold(0.0, f64::max);
        let ratios = || lines.iter().filter_map(|line| Some(line.bound_um / line.drawn_um?));
        ServoBound {
            program: scenario.program.name.clone(),
            machine: scenario.machine.settings.name.as_str().to_owned(),
            servo_rate_hz: scenario.rate_hz(),
            family: options.family,
            stated_um: most(|line| line.stated_um),
            bound_um: most(|line| line.bound_um),
            simulated_plants,
            drawn: drawn.map(|_| Drawn {
                plants: options.plants,
                seed: options.seed,
                worst_um: most(|line| line.drawn_um.unwrap_or(0.0)),
                bound_over_worst: [ratios().fold(f64::MAX, f64::min), ratios().fold(0.0, f64::max)],
            }),
            feed_for_um: options.feed_for_um,
            lines,
        }
    }
}
