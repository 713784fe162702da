//! The feed of every line at which its bound is as wanted.

use super::bound::{Bounded, Plants};
use super::family::Family;
use std::collections::BTreeMap;
use std::sync::Arc;
use trueaxis_sim::Scenario;
use trueaxis_sim::error::Result;

/// Rounds of feeds.
const ROUNDS: usize = 6;
/// Least share of the programmed feed.
const LEAST: f64 = 0.02;
/// Where the feed aims, share of the wanted bound.
const AIM: f64 = 0.95;

/// Share of a line's programmed feed, and the bound with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slowed {
    pub(super) share: f64,
    pub(super) bound: f64,
}

/// Slows the lines whose bound exceeds `wanted` (µm) until it does not, or as far as it can; every round computes the bounds
/// anew, with all feeds of the round.
pub(super) fn feeds(
    scenario: &Arc<Scenario>,
    family: &Family,
    wanted: f64,
    bounds: &BTreeMap<u32, Bounded>,
) -> Result<BTreeMap<u32, Slowed>> {
    let own = |(line, of): (&u32, &Bounded)| (*line, Slowed { share: 1.0, bound: of.bound });
    let mut lines: BTreeMap<u32, Slowed> = bounds.iter().map(own).collect();
    for _ in 0..ROUNDS {
        let mut slower = false;
        for line in lines.values_mut().filter(|line| line.bound > wanted && line.share > LEAST) {
            // An error grows with the feed or its square; too large a step would be slower than needed.
            line.share = (line.share * (AIM * wanted / line.bound).max(0.25).powf(0.8)).max(LEAST);
            slower = true;
        }
        if !slower {
            break;
        }
        let mut slowed = Scenario::clone(scenario);
        for step in slowed.program.moves.iter_mut().filter(|step| !step.rapid) {
            step.feed_per_min *= lines.get(&step.line).map_or(1.0, |line| line.share);
        }
        let (found, _) = Plants::new(Arc::new(slowed), family).bounds()?;
        for (line, of) in &found {
            if let Some(line) = lines.get_mut(line) {
                line.bound = of.bound;
            }
        }
    }
    Ok(lines)
}
