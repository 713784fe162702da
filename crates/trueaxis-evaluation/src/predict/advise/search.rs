//! A short set of measurements that brings every characteristic to a verdict; up to a number of measurements the shortest.

use super::candidate::{Candidate, Shop, Way};
use super::design::{Block, Readings, of_sights, of_task, task_of};
use super::prior::{Prior, is_decided};
use anyhow::Result;
use std::cmp::Ordering;
use std::collections::BTreeMap;
use trueaxis_metrology::cores::*;
use trueaxis_metrology::uncertainty::Interval;

/// Most measurements of which every set is tried.
pub(super) const EXACT: usize = 12;
/// Most sets that are drawn, the most promising first.
const DRAWN: usize = 8;

/// A set of measurements as bits, and what it is expected to decide.
#[derive(Clone, Copy, Debug)]
struct Rated {
    set: u64,
    minutes: f64,
    decided: usize,
    /// Sum of the intervals' widths as shares of the tolerances, of features without a verdict.
    open: f64,
}

impl Rated {
    /// More verdicts first, then less time.
    fn order(&self, other: &Rated) -> Ordering {
        other.decided.cmp(&self.decided).then(self.minutes.total_cmp(&other.minutes)).then(self.set.cmp(&other.set))
    }
}

/// What was chosen.
#[derive(Default)]
pub(super) struct Choice {
    /// Whether every set was compared, and each that promised more failed when it was drawn.
    pub(super) exact: bool,
    /// Indices of the measurements.
    pub(super) chosen: Vec<usize>,
    pub(super) minutes: f64,
    /// Time of the probing program.
    pub(super) probing_minutes: f64,
    pub(super) readings: Readings,
    pub(super) intervals: Vec<Interval>,
    /// Intervals with every measurement that is possible.
    pub(super) with_all: Vec<Interval>,
}

/// The measurements with what each says.
pub(super) struct Search<'s> {
    prior: &'s Prior<'s>,
    shop: &'s Shop<'s>,
    candidates: &'s [Candidate],
    /// Of measurements that are no artefacts.
    alone: Vec<Option<Block>>,
    /// Of sets of artefacts; `None` if they cannot separate their terms.
    tasks: BTreeMap<u64, Option<Block>>,
    /// Why a measurement is impossible by itself, or `None`.
    pub(super) refused: Vec<Option<String>>,
}

impl<'s> Search<'s> {
    pub(super) fn new(prior: &'s Prior<'s>, shop: &'s Shop<'s>, candidates: &'s [Candidate]) -> Search<'s> {
        let (mut alone, mut refused) = (Vec::new(), Vec::new());
        for of in candidates {
            let block = match &of.way {
                Way::Read(sights) => Some(of_sights(prior.model, &prior.unknowns, sights)),
                Way::Task(task) => Some(of_task(prior.model, &prior.unknowns, task)),
                Way::Artefact(_) => None,
            };
            refused.push(block.as_ref().and_then(|block| block.as_ref().err()).map(|why| format!("{why:#}")));
            alone.push(block.and_then(Result::ok));
        }
        Search { prior, shop, candidates, alone, tasks: BTreeMap::new(), refused }
    }

    fn artefacts(&self) -> u64 {
        let is_artefact = |of: &Candidate| matches!(of.way, Way::Artefact(_));
        bits(self.candidates.iter().enumerate().filter(|(_, of)| is_artefact(of)).map(|(k, _)| k))
    }

    /// What the artefacts of a set say in one task.
    fn plan(&mut self, set: u64) {
        let artefacts = set & self.artefacts();
        if artefacts == 0 || self.tasks.contains_key(&artefacts) {
            return;
        }
        let chosen = members(artefacts).map(|k| &self.candidates[k]);
        let task = task_of(self.shop, chosen);
        let block = task.and_then(|task| of_task(self.prior.model, &self.prior.unknowns, &task));
        if let (1, Err(why)) = (artefacts.count_ones(), &block) {
            self.refused[artefacts.trailing_zeros() as usize] = Some(format!("{why:#}"));
        }
        self.tasks.insert(artefacts, block.ok());
    }

    /// Readings and minutes of a set that has been planned; `None` if it is impossible.
    fn readings(&self, set: u64) -> Option<(Readings, [f64; 2])> {
        let artefacts = set & self.artefacts();
        let (mut readings, mut probing) = (Vec::new(), 0.0);
        if artefacts != 0 {
            let block = self.tasks.get(&artefacts)?.as_ref()?;
            readings.extend_from_slice(&block.readings);
            probing = block.minutes;
        }
        let mut minutes = probing;
        for k in members(set) {
            minutes += self.candidates[k].minutes;
            if artefacts & (1 << k) == 0 {
                let block = self.alone[k].as_ref()?;
                readings.extend_from_slice(&block.readings);
                minutes += block.minutes;
            }
        }
        Some((readings, [minutes, probing]))
    }

    /// Minutes of a measurement by itself.
    fn minutes(&self, k: usize) -> f64 {
        let probing = self.tasks.get(&(1 << k)).and_then(Option::as_ref).or(self.alone[k].as_ref());
        self.candidates[k].minutes + probing.map_or(0.0, |block| block.minutes)
    }

    fn expected(&self, readings: &Readings) -> Vec<Interval> {
        let update = self.prior.update(readings);
        let variances = update.as_ref().map(|update| update.variances()).unwrap_or_default();
        self.prior.features.iter().map(|of| self.prior.expected(update.as_ref(), &variances, of)).collect()
    }

    fn rate(&self, set: u64) -> Option<Rated> {
        let (readings, [minutes, _]) = self.readings(set)?;
        let (mut decided, mut open) = (0, 0.0);
        for (of, interval) in self.prior.features.iter().zip(self.expected(&readings)) {
            if is_decided(interval, of.limits) {
                decided += 1;
            } else {
                let [low, high] = of.limits;
                let width = if low.is_finite() { high - low } else { high };
                open += (interval.high - interval.low) / width;
            }
        }
        Some(Rated { set, minutes, decided, open })
    }

    /// The best set.
    pub(super) fn choose(mut self) -> Result<(Choice, Vec<Option<String>>)> {
        let count = self.candidates.len();
        for k in 0..count {
            self.plan(1 << k);
        }
        let is_every = count <= EXACT;
        let mut rated = if is_every { self.all_sets() } else { self.greedy() };
        rated.sort_by(Rated::order);
        let unmeasured = self.prior.features.iter().map(|of| of.interval).collect();
        let mut best = Choice { intervals: unmeasured, ..Choice::default() };
        let mut most = None;
        let mut is_confirmed = rated.len() <= DRAWN;
        for one in rated.iter().take(DRAWN) {
            let Some((readings, [minutes, probing_minutes])) = self.readings(one.set) else { continue };
            let intervals = self.prior.after(&readings)?;
            let features = self.prior.features.iter().zip(&intervals);
            let decided = features.filter(|(of, interval)| is_decided(**interval, of.limits)).count();
            if most.is_none_or(|most| decided > most || decided == most && minutes < best.minutes) {
                most = Some(decided);
                let chosen = members(one.set).collect();
                best = Choice { chosen, minutes, probing_minutes, readings, intervals, ..Choice::default() };
            }
            // The next ones promise no more.
            if most >= Some(one.decided) {
                is_confirmed = true;
                break;
            }
        }
        best.exact = is_every && is_confirmed;
        best.with_all = self.with_all();
        for (set, _) in self.tasks.iter().filter(|(_, block)| block.is_some()) {
            // Possible together with others.
            members(*set).for_each(|k| self.refused[k] = None);
        }
        Ok((best, self.refused))
    }

    /// The intervals with all that is possible: artefacts in one task, or those that separate their terms.
    fn with_all(&mut self) -> Vec<Interval> {
        let count = self.candidates.len();
        let possible = |k: &usize| self.alone[*k].is_some();
        let alone = bits((0..count).filter(possible));
        self.plan(self.artefacts());
        let tasks = self.tasks.iter().filter(|(_, block)| block.is_some()).map(|(set, _)| *set);
        let most = tasks.max_by_key(|set| set.count_ones()).unwrap_or(0);
        self.readings(alone | most).map(|(readings, _)| self.expected(&readings)).unwrap_or_default()
    }

    fn all_sets(&mut self) -> Vec<Rated> {
        let sets = 1_u64 << self.candidates.len();
        (0..sets).for_each(|set| self.plan(set));
        (0..sets).into_par_iter().filter_map(|set| self.rate(set)).collect()
    }

    /// Adds one or two measurements at a time, by gain per minute, then leaves out what is not needed.
    fn greedy(&mut self) -> Vec<Rated> {
        let count = self.candidates.len();
        let nothing = Rated { set: 0, minutes: 0.0, decided: 0, open: f64::MAX };
        let mut now = self.rate(0).unwrap_or(nothing);
        let mut found = vec![now];
        loop {
            let mut next: Option<(f64, Rated)> = None;
            for (i, j) in (0..count).flat_map(|i| (i..count).map(move |j| (i, j))) {
                let set = now.set | 1 << i | 1 << j;
                if set == now.set {
                    continue;
                }
                self.plan(set);
                let Some(rated) = self.rate(set) else { continue };
                let gain = (rated.decided as f64 - now.decided as f64) + (now.open - rated.open);
                let gain = gain / (rated.minutes - now.minutes).max(0.1);
                if gain > 1e-6 && next.as_ref().is_none_or(|(most, _)| gain > *most) {
                    next = Some((gain, rated));
                }
            }
            let Some((_, rated)) = next else { break };
            now = rated;
            found.push(now);
            if now.decided == self.prior.features.len() {
                break;
            }
        }
        // The longest first: leaving out one may make another indispensable.
        let mut longest: Vec<usize> = members(now.set).collect();
        longest.sort_by(|a, b| self.minutes(*b).total_cmp(&self.minutes(*a)));
        for k in longest {
            let fewer = now.set & !(1 << k);
            self.plan(fewer);
            if let Some(rated) = self.rate(fewer).filter(|rated| rated.decided >= now.decided) {
                now = rated;
                found.push(now);
            }
        }
        found
    }
}

fn bits(members: impl Iterator<Item = usize>) -> u64 {
    members.fold(0, |set, k| set | 1 << k)
}

fn members(set: u64) -> impl Iterator<Item = usize> {
    (0..64).filter(move |k| set & (1 << k) != 0)
}
