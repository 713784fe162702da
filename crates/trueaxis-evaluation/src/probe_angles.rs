//! Angles of three probes: the best pairs and the noise gain of a given one.

use crate::probes::Probes;
use crate::shown::{Cell, Table};
use anyhow::{Result, bail};
use serde::{Deserialize, Serialize};
use trueaxis::roundness::{Band, Gain, ProbeAngles};
use trueaxis_metrology::cores::*;
use trueaxis_metrology::pair_search::{Arrangement, Bound, PairSearch};

/// Maximum number of pairs listed.
const MOST: usize = 10_000;
/// Number of pairs listed by default.
pub const USUAL_COUNT: usize = 20;

/// The search, and the pair to compare with its result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// Points and band; angles, if a pair is to be compared.
    pub probes: Probes,
    /// Pairs to list, 1 to 10000.
    #[serde(default = "usual_count")]
    pub count: usize,
}

fn usual_count() -> usize {
    USUAL_COUNT
}

/// The JSON document.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProbeAnglesDocument {
    /// Points per revolution N.
    pub n: usize,
    /// First and last harmonic.
    pub harmonics: [u16; 2],
    /// Best pairs first.
    pub best: Vec<Pair>,
    /// The requested pair.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pair: Option<GivenPair>,
}

impl ProbeAnglesDocument {
    /// The best pairs and, last, the requested one.
    pub fn table(&self) -> Table {
        let row = |name: String, pair: &Pair| {
            let slot = |slot: Option<i64>| Cell::fixed(slot.map(|slot| slot as f64), 0);
            vec![
                name.into(),
                slot(pair.p),
                slot(pair.q),
                Cell::fixed(pair.phi2_deg, 5),
                Cell::fixed(pair.phi3_deg, 5),
                Cell::fixed(pair.worst_gain, 4),
                Cell::fixed(pair.worst_noise_gain, 3),
                Cell::count(pair.worst_harmonic.into()),
            ]
        };
        let best = self.best.iter().enumerate().map(|(i, pair)| row((i + 1).to_string(), pair));
        let given = self.pair.iter().map(|given| {
            row(format!("given pair, {:.1} % of the best gain", 100.0 * given.share_of_best), &given.pair)
        });
        let [first, last] = self.harmonics;
        let header = ["pair", "p", "q", "φ2, °", "φ3, °", "worst gain", "worst noise gain", "at harmonic"];
        Table::new(format!("Best pairs, N = {}, harmonics {first} to {last}", self.n), header, best.chain(given))
    }
}

/// Angles of the probes and their worst harmonic.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pair {
    /// Slots from probe 1 to probe 2; `None` for a pair given in degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p: Option<i64>,
    /// Slots from probe 2 to probe 3.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub q: Option<i64>,
    /// Angle from probe 1 to probe 2.
    pub phi2_deg: f64,
    /// Angle from probe 2 to probe 3.
    pub phi3_deg: f64,
    /// Smallest gain in the band, 0 (blind) to √3.
    pub worst_gain: f64,
    /// Inverse of `worst_gain`: growth of the probes' noise in the worst harmonic.
    pub worst_noise_gain: f64,
    /// The worst harmonic.
    pub worst_harmonic: u16,
}

/// The requested pair, compared with the best.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GivenPair {
    /// Angles and worst harmonic of the pair.
    #[serde(flatten)]
    pub pair: Pair,
    /// Worst gain relative to the best pair's.
    pub share_of_best: f64,
    /// Noise gains over the band.
    pub noise_gains: Vec<NoiseGain>,
    /// Harmonics outside the band, up to N/2 − 1, that the pair cannot see.
    pub singular: Vec<u16>,
}

/// Noise gain of one harmonic.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NoiseGain {
    /// Undulations per revolution.
    pub k: u16,
    /// Growth of the probes' noise.
    pub noise_gain: f64,
}

impl Pair {
    fn new(gain: &Gain, slots: Option<[i64; 2]>, band: Band) -> Pair {
        let worst = band
            .iter()
            .map(|k| (k, gain.noise_gain(usize::from(k))))
            .fold((band.first, 0.0), |worst, next| if next.1 > worst.1 { next } else { worst });
        Pair {
            p: slots.map(|[p, _]| p),
            q: slots.map(|[_, q]| q),
            phi2_deg: gain.phi2().to_degrees(),
            phi3_deg: gain.phi3().to_degrees(),
            worst_gain: 1.0 / worst.1,
            worst_noise_gain: worst.1,
            worst_harmonic: worst.0,
        }
    }
}

/// A checked search: as a whole ([`Search::run`]), or step by step ([`Search::advance`], [`Search::finish`]).
#[derive(Debug)]
pub struct Search {
    points: usize,
    band: Band,
    given: Option<Gain>,
    slots: Option<[i64; 2]>,
    pairs: PairSearch,
    bound: Bound,
    found: Vec<Arrangement>,
    done: usize,
}

impl Request {
    /// Checks the request and prepares the search.
    ///
    /// # Errors
    /// An invalid option, under its command-line name; a pair that cannot see some harmonics of the band.
    pub fn search(&self) -> Result<Search> {
        let (points, band) = (self.probes.points()?, self.probes.band()?);
        if !(1..=MOST).contains(&self.count) {
            bail!("--count: found {}, needed 1 to {MOST}", self.count);
        }
        // A bad pair is refused before the search, not after.
        let given = self.probes.has_angles().then(|| self.probes.gain()).transpose()?;
        let pairs = PairSearch::new(points, band, self.count)?;
        let (bound, slots) = (pairs.bound(), self.probes.slots());
        Ok(Search { points, band, given, slots, pairs, bound, found: Vec::new(), done: 0 })
    }
}

impl Search {
    /// Number of steps of the whole search.
    pub fn steps(&self) -> usize {
        self.pairs.smallest_arcs().count()
    }

    /// Runs the whole search on all cores; calls `done` after each step.
    ///
    /// # Errors
    /// As [`Search::finish`].
    pub fn run(mut self, done: impl Fn() + Sync) -> Result<ProbeAnglesDocument> {
        let (pairs, bound) = (&self.pairs, &self.bound);
        self.found = pairs
            .smallest_arcs()
            .into_par_iter()
            .flat_map_iter(|smallest| {
                let found = pairs.best_for(smallest, bound);
                done();
                found
            })
            .collect();
        self.finish()
    }

    /// Runs at most `steps` further steps in this thread; returns the share done, 1 at the end.
    pub fn advance(&mut self, steps: usize) -> f64 {
        for smallest in self.pairs.smallest_arcs().skip(self.done).take(steps) {
            self.found.extend(self.pairs.best_for(smallest, &self.bound));
            self.done += 1;
        }
        self.done as f64 / self.steps().max(1) as f64
    }

    /// The document of the pairs found.
    ///
    /// # Errors
    /// A found pair that does not resolve.
    pub fn finish(self) -> Result<ProbeAnglesDocument> {
        let (points, band) = (self.points, self.band);
        let pair = |pair: trueaxis_metrology::pair_search::SlotPair| {
            let gain = ProbeAngles::Slots { p: pair.p, q: pair.q }.resolve(points)?;
            Ok(Pair::new(&gain, Some([pair.p, pair.q].map(i64::from)), band))
        };
        let best: Vec<Pair> = self.pairs.ranked(self.found).into_iter().map(pair).collect::<Result<_>>()?;
        let pair = self.given.map(|gain| {
            let pair = Pair::new(&gain, self.slots, band);
            GivenPair {
                share_of_best: best.first().map_or(1.0, |best| pair.worst_gain / best.worst_gain),
                pair,
                noise_gains: noise_gains(&gain, band),
                singular: singular(&gain),
            }
        });
        Ok(ProbeAnglesDocument { n: points, harmonics: [band.first, band.last], best, pair })
    }
}

fn noise_gains(gain: &Gain, band: Band) -> Vec<NoiseGain> {
    band.iter().map(|k| NoiseGain { k, noise_gain: gain.noise_gain(usize::from(k)) }).collect()
}

/// All harmonics up to N/2 − 1 that an arrangement cannot see.
fn singular(gain: &Gain) -> Vec<u16> {
    gain.singular(Band { first: 2, last: (gain.points() / 2 - 1) as u16 }).collect()
}

/// A probe arrangement, including those that the commands refuse.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curve {
    /// Points per revolution N.
    pub n: usize,
    /// First and last harmonic.
    pub harmonics: [u16; 2],
    /// Angle from probe 1 to probe 2.
    pub phi2_deg: f64,
    /// Angle from probe 2 to probe 3.
    pub phi3_deg: f64,
    /// The pair with its worst harmonic; `None` if it is blind to some harmonic of the band.
    pub worst: Option<Pair>,
    /// Noise gains over the band, except at harmonics that the pair cannot see.
    pub noise_gains: Vec<NoiseGain>,
    /// Harmonics up to N/2 − 1 that the pair cannot see.
    pub singular: Vec<u16>,
    /// Harmonics in the band that the pair cannot see.
    pub blind: Vec<u16>,
}

/// Noise gain of an arrangement over the band, without a search.
///
/// # Errors
/// An invalid option, under its command-line name.
pub fn curve(probes: &Probes) -> Result<Curve> {
    let (points, band, gain) = (probes.points()?, probes.band()?, probes.arrangement()?);
    let blind: Vec<u16> = gain.singular(band).collect();
    let mut noise_gains = noise_gains(&gain, band);
    noise_gains.retain(|of| !blind.contains(&of.k));
    Ok(Curve {
        n: points,
        harmonics: [band.first, band.last],
        phi2_deg: gain.phi2().to_degrees(),
        phi3_deg: gain.phi3().to_degrees(),
        worst: blind.is_empty().then(|| Pair::new(&gain, probes.slots(), band)),
        noise_gains,
        singular: singular(&gain),
        blind,
    })
}
