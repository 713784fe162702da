//! Full search for the best slots of three probes, over all pairs of whole slots.
//!
//! With the arcs a = φ2, b = φ3, c = 2π − φ2 − φ3 between the probes, sin φ3 times the weighted sum has
//!
//! ```text
//! |G|²/(1 + k2² + k3²) = 1 + 2 (sin b sin c cos ka + sin c sin a cos kb + sin a sin b cos kc) / (sin² a + sin² b + sin² c)
//! ```
//!
//! Exchanging arcs or mirroring the circle does not change this value. Each arrangement thus represents up to twelve pairs (p,
//! q), and the search evaluates one of them, a <= b <= c with a + b + c = N: N²/12 arrangements. An evaluation ends at the
//! first harmonic that is worse than the best arrangements known so far.

use core::cmp::Ordering;
use core::f64::consts::TAU;
use core::sync::atomic::{AtomicU64, Ordering as Memory};
use std::sync::{Mutex, PoisonError};
use std::vec::Vec;
use trueaxis::error::ConfigError;
use trueaxis::roundness::Band;

/// Figures of merit whose relative difference is below this count as equal.
const TIE: f64 = 1e-12;
/// Least number of pairs per arrangement: three orders of its arcs, each mirrored.
const PAIRS_AT_LEAST: usize = 6;

/// A pair of slots and its figure of merit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlotPair {
    /// φ2 = 2π p/N.
    pub p: u16,
    /// φ3 = 2π q/N.
    pub q: u16,
    /// Smallest |G|/√(1 + k2² + k3²) in the band, 0 (blind) to √3; the inverse of the worst noise gain.
    pub worst_gain: f64,
}

/// An arrangement of three probes up to order and mirroring: arcs a <= b <= c of N slots in total.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrangement {
    arcs: [usize; 3],
    worst: f64,
}

/// Best figures of merit found so far by any worker.
#[derive(Debug)]
pub struct Bound {
    /// Figure that an arrangement must reach to be among the best, as bits of an `f64`.
    reach: AtomicU64,
    best: Mutex<Vec<f64>>,
}

/// A full search over the pairs for a number of slots.
#[derive(Debug)]
pub struct PairSearch {
    points: usize,
    band: Band,
    count: usize,
    cos: Vec<f64>,
    sin: Vec<f64>,
}

impl PairSearch {
    /// Prepares the search for the `count` best pairs of `points` slots.
    ///
    /// # Errors
    /// The band does not suit the number of points.
    pub fn new(points: usize, band: Band, count: usize) -> Result<PairSearch, ConfigError> {
        band.check(points)?;
        let turn = |i: usize| TAU * i as f64 / points as f64;
        Ok(PairSearch {
            points,
            band,
            count: count.max(1),
            cos: (0..points).map(|i| libm::cos(turn(i))).collect(),
            sin: (0..points).map(|i| libm::sin(turn(i))).collect(),
        })
    }

    /// Creates the bound that the workers share.
    pub fn bound(&self) -> Bound {
        let kept = self.count.div_ceil(PAIRS_AT_LEAST);
        Bound { reach: AtomicU64::new(0), best: Mutex::new(std::vec![0.0; kept]) }
    }

    /// Returns the smallest arcs for which to call [`PairSearch::best_for`], once each, in any order and in parallel.
    pub fn smallest_arcs(&self) -> core::ops::RangeInclusive<usize> {
        1..=self.points / 3
    }

    /// Evaluates all arrangements with a given smallest arc; raises the bound and returns those that reached it.
    pub fn best_for(&self, smallest: usize, bound: &Bound) -> Vec<Arrangement> {
        let mut found = Vec::new();
        let rest = self.points.saturating_sub(smallest);
        for middle in smallest..=rest / 2 {
            let arcs = [smallest, middle, rest - middle];
            if let Some(worst) = self.worst(arcs, bound.reach()) {
                bound.raise(worst);
                found.push(Arrangement { arcs, worst });
            }
        }
        found
    }

    /// Figure of merit; `None` if it does not reach `reach` or two probes are on one line through the centre.
    fn worst(&self, arcs: [usize; 3], reach: f64) -> Option<f64> {
        if arcs.iter().any(|arc| 2 * arc == self.points || *arc == 0) {
            return None;
        }
        let sine = |arc: usize| self.sin.get(arc).copied().unwrap_or_default();
        let [a, b, c] = arcs.map(sine);
        let scale = 2.0 / (a * a + b * b + c * c);
        let weights = [b * c * scale, c * a * scale, a * b * scale];
        let least = reach * reach;
        let mut slots = arcs.map(|arc| (arc * usize::from(self.band.first)) % self.points);
        let mut worst = f64::INFINITY;
        for _ in self.band.iter() {
            let mut square = 1.0;
            for ((slot, arc), weight) in slots.iter_mut().zip(arcs).zip(weights) {
                square += weight * self.cos.get(*slot).copied().unwrap_or_default();
                *slot += arc;
                if *slot >= self.points {
                    *slot -= self.points;
                }
            }
            if square < least {
                return None;
            }
            worst = worst.min(square);
        }
        // Rounding may leave a value slightly below zero if the arrangement is blind.
        Some(libm::sqrt(worst.max(0.0)))
    }

    /// Returns the best pairs of all arrangements found: best first, ties by the smallest p, then q.
    pub fn ranked(&self, found: impl IntoIterator<Item = Arrangement>) -> Vec<SlotPair> {
        let mut pairs: Vec<SlotPair> = found.into_iter().flat_map(|found| self.pairs(found)).collect();
        pairs.sort_by(|one, other| other.worst_gain.total_cmp(&one.worst_gain));
        for tied in pairs.chunk_by_mut(|one, other| one.worst_gain - other.worst_gain <= TIE * one.worst_gain) {
            tied.sort_by_key(|pair| (pair.p, pair.q));
        }
        pairs.truncate(self.count);
        pairs
    }

    /// All pairs that an arrangement represents: every order of its arcs, and its mirror image.
    fn pairs(&self, Arrangement { arcs: [a, b, c], worst }: Arrangement) -> Vec<SlotPair> {
        let orders = [[a, b], [b, a], [a, c], [c, a], [b, c], [c, b]];
        let mirrored = orders.map(|order| order.map(|arc| self.points - arc));
        let mut pairs: Vec<SlotPair> = orders
            .into_iter()
            .chain(mirrored)
            .filter_map(|[p, q]| {
                Some(SlotPair { p: u16::try_from(p).ok()?, q: u16::try_from(q).ok()?, worst_gain: worst })
            })
            .collect();
        pairs.sort_by_key(|pair| (pair.p, pair.q));
        pairs.dedup();
        pairs
    }

    /// Runs the whole search in one thread.
    pub fn run(&self) -> Vec<SlotPair> {
        let bound = self.bound();
        self.ranked(self.smallest_arcs().flat_map(|smallest| self.best_for(smallest, &bound)))
    }
}

impl Bound {
    fn reach(&self) -> f64 {
        f64::from_bits(self.reach.load(Memory::Relaxed))
    }

    fn raise(&self, worst: f64) {
        let mut best = self.best.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(last) = best.last_mut().filter(|last| **last < worst) {
            *last = worst;
            best.sort_by(|one, other| other.partial_cmp(one).unwrap_or(Ordering::Equal));
            // Slightly lower, so that rounding drops no arrangement as good as the last.
            let reach = best.last().map_or(0.0, |last| last * (1.0 - 10.0 * TIE));
            self.reach.store(reach.to_bits(), Memory::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trueaxis::roundness::ProbeAngles;

    const BAND: Band = Band { first: 2, last: 100 };

    /// The best of 1024 and of 512 slots, known from a search over all pairs with the complex gain.
    #[test]
    fn known_best_pairs() {
        let best = PairSearch::new(1024, BAND, 13).unwrap().run();
        assert_eq!((best[0].p, best[0].q), (169, 188));
        assert_eq!((best[0].worst_gain * 1e3).round(), 319.0);
        let equals = best.iter().filter(|pair| pair.worst_gain > best[0].worst_gain * (1.0 - 1e-9)).count();
        assert_eq!(equals, 12);
        assert!(best[..12].windows(2).all(|two| (two[0].p, two[0].q) < (two[1].p, two[1].q)));
        assert!(best[..12].iter().any(|pair| (pair.p, pair.q) == (188, 667)));
        let best = PairSearch::new(512, BAND, 1).unwrap().run();
        assert_eq!((best[0].p, best[0].q, (best[0].worst_gain * 1e3).round()), (155, 172, 300.0));
        assert_eq!(best.len(), 1);
    }

    /// Compares with |G| of every single pair.
    #[test]
    fn every_pair_of_a_small_circle() {
        for (points, band) in [(64, Band { first: 2, last: 20 }), (128, Band { first: 5, last: 63 })] {
            let mut all = Vec::new();
            for p in 1..points as u16 {
                for q in 1..points as u16 {
                    if let Ok(gain) = (ProbeAngles::Slots { p, q }).resolve(points) {
                        all.push((gain.worst(band), p, q));
                    }
                }
            }
            all.sort_by(|a, b| b.0.total_cmp(&a.0));
            let best = PairSearch::new(points, band, 200).unwrap().run();
            assert_eq!(best.len(), 200);
            for (found, truth) in best.iter().zip(&all) {
                assert!((found.worst_gain - truth.0).abs() < 1e-7, "{found:?} {truth:?}");
                let own = ProbeAngles::Slots { p: found.p, q: found.q }.resolve(points).unwrap().worst(band);
                assert!((found.worst_gain - own).abs() < 1e-7, "{found:?} {own}");
            }
        }
    }

    #[test]
    fn a_wrong_band_is_refused() {
        assert!(PairSearch::new(128, Band { first: 2, last: 64 }, 1).is_err());
        assert!(PairSearch::new(128, Band { first: 1, last: 20 }, 1).is_err());
    }
}
