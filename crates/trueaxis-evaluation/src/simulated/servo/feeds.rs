//! The feed of every line at which its bound is as wanted.

use super::bound::{Bounded, Plants};
use super::family::Family;
use std::collections::BTreeMap;
use std::sync::Arc;
use trueaxis_sim::Scenario;
use trueaxis_sim::error::Result;

/// Rounds of feeds.
const ROUNDS: usize = 8;
/// Least share of the programmed feed.
const LEAST: f64 = 0.02;
/// Where the feed aims, share of the wanted bound.
const AIM: f64 = 0.95;

/// A bound that falls to less than this share of the one before was helped by the slower feed.
const HELPED: f64 = 0.98;
/// Share to which a line is slowed at least whose slower feed did not help: friction hardly depends on a small change.
const UNHELPED: f64 = 0.7;

/// Share of a line's programmed feed, and the bound with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slowed {
    pub(super) share: f64,
    pub(super) bound: f64,
}

/// Slows the lines whose bound exceeds `wanted` (µm) until it does not, or as far as it can; every round computes the bounds
/// with all feeds found so far.
pub(super) fn feeds(
    scenario: &Arc<Scenario>,
    family: &Family,
    wanted: f64,
    bounds: &BTreeMap<u32, Bounded>,
) -> Result<BTreeMap<u32, Slowed>> {
    let own = |(line, of): (&u32, &Bounded)| (*line, Slowed { share: 1.0, bound: of.bound });
    let mut lines: BTreeMap<u32, Slowed> = bounds.iter().map(own).collect();
    let mut before: BTreeMap<u32, f64> = BTreeMap::new();
    for _ in 0..ROUNDS {
        let slower = slow(&mut lines, &mut before, wanted);
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

/// Slows every line whose bound exceeds `wanted`; where that did not help in the round before, by a larger step together with
/// the line that leads to it, since an error that begins in its last moments ends on the next. Returns whether any feed has
/// changed.
fn slow(lines: &mut BTreeMap<u32, Slowed>, before: &mut BTreeMap<u32, f64>, wanted: f64) -> bool {
    let numbers: Vec<u32> = lines.keys().copied().collect();
    let mut slower = false;
    for (at, number) in numbers.iter().enumerate() {
        let Some(Slowed { bound, .. }) = lines.get(number).copied().filter(|line| line.bound > wanted) else {
            continue;
        };
        let helped = before.insert(*number, bound).is_none_or(|before| bound < HELPED * before);
        // An error grows with the feed or its square; too large a step would be slower than needed.
        let step = (AIM * wanted / bound).max(0.25).powf(0.8);
        let step = if helped { step } else { step.min(UNHELPED) };
        let from = if helped { at } else { at.saturating_sub(1) };
        for slowed in numbers.iter().take(at + 1).skip(from) {
            if let Some(line) = lines.get_mut(slowed).filter(|line| line.share > LEAST) {
                line.share = (line.share * step).max(LEAST);
                slower = true;
            }
        }
    }
    slower
}
