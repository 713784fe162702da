//! The search: placements by their gain per minute, then exchanges.

use super::candidate::Candidate;
use super::volume::Volume;
use trueaxis_metrology::calibration::Information;
use trueaxis_metrology::cores::*;

/// Most passes of exchanges.
const PASSES: usize = 4;
/// Most placements.
const MOST: usize = 24;
/// Least relative gain of a step.
const GAIN: f64 = 1e-3;

/// What is asked for.
pub(super) struct Asked<'a> {
    /// Placements that the task states.
    pub(super) fixed: &'a [Candidate],
    pub(super) candidates: &'a [Candidate],
    pub(super) prior: &'a Information,
    pub(super) volume: &'a Volume,
    /// Standard deviations of the terms before anything is measured.
    pub(super) ranges: &'a [f64],
    pub(super) minutes: f64,
}

impl Asked<'_> {
    fn information(&self, picked: &[usize]) -> Information {
        let mut sum = self.prior.clone();
        let chosen = picked.iter().map(|k| &self.candidates[*k]);
        self.fixed.iter().chain(chosen).for_each(|one| sum.add(&one.information));
        sum
    }

    fn left(&self, picked: &[usize]) -> f64 {
        self.information(picked).variance(&self.volume.gram) + self.without(picked)
    }

    /// Variance by the terms that no placement brings into the solution: touches of others may tell of them, but it does not
    /// have them.
    fn without(&self, picked: &[usize]) -> f64 {
        let all = || self.fixed.iter().chain(picked.iter().map(|k| &self.candidates[*k]));
        let lacks = |k: &usize| !all().any(|one| one.spans[*k]);
        (0..self.ranges.len()).filter(lacks).map(|k| self.volume.gram[k][k] * self.ranges[k] * self.ranges[k]).sum()
    }

    fn minutes(&self, picked: &[usize]) -> f64 {
        picked.iter().map(|k| self.candidates[*k].minutes).sum()
    }

    /// The variance that each candidate would leave beside these, none for those that do not fit the time.
    fn beside(&self, picked: &[usize], minutes: f64) -> Vec<Option<f64>> {
        let base = self.information(picked);
        let with = |k: usize| {
            let one = &self.candidates[k];
            if one.minutes > minutes || picked.contains(&k) {
                return None;
            }
            let mut sum = base.clone();
            sum.add(&one.information);
            let with: Vec<usize> = picked.iter().copied().chain([k]).collect();
            Some(sum.variance(&self.volume.gram) + self.without(&with))
        };
        (0..self.candidates.len()).into_par_iter().map(with).collect()
    }

    /// Place in the list of the placement without which the least is lost.
    pub(super) fn least_useful(&self, picked: &[usize]) -> usize {
        let without = |at: usize| {
            let mut rest = picked.to_vec();
            rest.remove(at);
            self.left(&rest)
        };
        let all = (0..picked.len()).map(|at| (at, without(at)));
        all.min_by(|one, other| one.1.total_cmp(&other.1)).map_or(0, |(at, _)| at)
    }
}

/// Indices of the chosen candidates. Equal gains are decided by the order of the candidates.
pub(super) fn choose(asked: &Asked<'_>, fixed_minutes: f64, progress: &mut dyn FnMut(f64)) -> Vec<usize> {
    let free = asked.minutes - fixed_minutes;
    let mut picked: Vec<usize> = Vec::new();
    let grow = |picked: &mut Vec<usize>| {
        while picked.len() < MOST {
            let now = asked.left(picked);
            let all = asked.beside(picked, free - asked.minutes(picked));
            let gain = |k: usize| all[k].map(|left| (k, (now - left) / asked.candidates[k].minutes, left));
            let best = (0..all.len()).filter_map(gain).fold(None, |best: Option<(usize, f64, f64)>, one| {
                if best.is_none_or(|best| one.1 > best.1) { Some(one) } else { best }
            });
            match best {
                Some((k, _, left)) if left < (1.0 - GAIN) * now => picked.push(k),
                _ => break,
            }
        }
    };
    grow(&mut picked);
    for pass in 0..PASSES {
        progress(pass as f64 / PASSES as f64);
        let before = asked.left(&picked);
        for at in 0..picked.len() {
            let mut rest = picked.clone();
            let own = rest.remove(at);
            let all = asked.beside(&rest, free - asked.minutes(&rest));
            let (mut best, mut least) = (own, (1.0 - GAIN) * all[own].unwrap_or(f64::INFINITY));
            for (k, left) in all.iter().enumerate() {
                if let Some(left) = left.filter(|left| *left < least) {
                    (best, least) = (k, left);
                }
            }
            picked[at] = best;
        }
        grow(&mut picked);
        if asked.left(&picked) > (1.0 - GAIN) * before {
            break;
        }
    }
    // In the order in which they are set up.
    picked.sort_unstable();
    picked
}
