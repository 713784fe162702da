//! `trueaxis probe-angles`.

use crate::output::{json, print, progress};
use crate::probes::ProbeArguments;
use anyhow::{Result, bail};
use clap::Args;
use rayon::prelude::*;
use serde::Serialize;
use std::fmt::Write;
use trueaxis::roundness::{Band, Gain, ProbeAngles};
use trueaxis_metrology::pair_search::PairSearch;

pub(crate) const HELP: &str = "\
All pairs of slots are searched. Worst gain: smallest |G(k)|/√(1 + k2² + k3²) in the band, 0 (blind) to √3; its inverse, the
worst noise gain, says how much the probes' noise grows in the worst harmonic. Equal pairs: smallest p first, then q.
A given pair is compared with the best; one that cannot see some harmonics of the band is refused, all of them named.

N = 1024, harmonics 2..100           φ2, φ3                worst gain   worst noise gain
published (CN1927535)                90°, 181.05°               0.052               19.3
published (CN1927535)                60.82°, 240.12°            0.053               18.7
best: p 169, q 188, 11 equivalents   59.414°, 66.094°           0.319                3.1

Example: trueaxis probe-angles --n 1024 --harmonics 2..100 --p 188 --q 667 --json";

#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    probes: ProbeArguments,
    /// Best pairs to list.
    #[arg(long, value_name = "COUNT", default_value_t = 20)]
    count: usize,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Document {
    n: usize,
    harmonics: [u16; 2],
    best: Vec<Pair>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pair: Option<GivenPair>,
}

#[derive(Serialize)]
struct Pair {
    #[serde(skip_serializing_if = "Option::is_none")]
    p: Option<i64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    q: Option<i64>,
    phi2_deg: f64,
    phi3_deg: f64,
    worst_gain: f64,
    worst_noise_gain: f64,
    worst_harmonic: u16,
}

#[derive(Serialize)]
struct GivenPair {
    #[serde(flatten)]
    pair: Pair,
    /// Worst gain against that of the best pair of slots.
    share_of_best: f64,
    noise_gains: Vec<NoiseGain>,
    /// Harmonics outside the band, up to N/2 − 1, that the pair cannot see.
    singular: Vec<u16>,
}

#[derive(Serialize)]
struct NoiseGain {
    k: u16,
    noise_gain: f64,
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

/// Most pairs that are listed.
const MOST: usize = 10_000;

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let (points, band) = (arguments.probes.points()?, arguments.probes.band()?);
    if !(1..=MOST).contains(&arguments.count) {
        bail!("--count: found {}, needed 1 to {MOST}", arguments.count);
    }
    // A bad pair is refused before the search, not after.
    let given = arguments.probes.has_angles().then(|| arguments.probes.gain()).transpose()?;
    let best = search(points, band, arguments.count)?;
    let pair = given.map(|gain| {
        let pair = Pair::new(&gain, arguments.probes.slots(), band);
        let everything = Band { first: 2, last: (points / 2 - 1) as u16 };
        GivenPair {
            share_of_best: best.first().map_or(1.0, |best| pair.worst_gain / best.worst_gain),
            pair,
            noise_gains: band.iter().map(|k| NoiseGain { k, noise_gain: gain.noise_gain(usize::from(k)) }).collect(),
            singular: gain.singular(everything).collect(),
        }
    });
    let document = Document { n: points, harmonics: [band.first, band.last], best, pair };
    if arguments.json { json(&document) } else { print(&table(&document)?) }
}

fn search(points: usize, band: Band, count: usize) -> Result<Vec<Pair>> {
    let search = PairSearch::new(points, band, count)?;
    let bound = search.bound();
    let bar = progress(search.smallest_arcs().count() as u64, "arrangements of probes");
    let found: Vec<_> = search
        .smallest_arcs()
        .into_par_iter()
        .flat_map_iter(|smallest| {
            let found = search.best_for(smallest, &bound);
            bar.inc(1);
            found
        })
        .collect();
    bar.finish_and_clear();
    search
        .ranked(found)
        .into_iter()
        .map(|pair| {
            let gain = ProbeAngles::Slots { p: pair.p, q: pair.q }.resolve(points)?;
            Ok(Pair::new(&gain, Some([pair.p, pair.q].map(i64::from)), band))
        })
        .collect()
}

fn table(document: &Document) -> Result<String> {
    let [first, last] = document.harmonics;
    let mut text = format!("N = {}, harmonics {first} to {last}\n\n", document.n);
    writeln!(
        text,
        "{:>5} {:>5} {:>11} {:>11} {:>11} {:>17} {:>12}",
        "p", "q", "φ2 in °", "φ3 in °", "worst gain", "worst noise gain", "at harmonic"
    )?;
    let mut line = |pair: &Pair| {
        let slot = |slot: Option<i64>| slot.map_or_else(|| "–".to_owned(), |slot| slot.to_string());
        writeln!(
            text,
            "{:>5} {:>5} {:>11.5} {:>11.5} {:>11.4} {:>17.3} {:>12}",
            slot(pair.p),
            slot(pair.q),
            pair.phi2_deg,
            pair.phi3_deg,
            pair.worst_gain,
            pair.worst_noise_gain,
            pair.worst_harmonic
        )
    };
    document.best.iter().try_for_each(&mut line)?;
    if let Some(given) = &document.pair {
        line(&given.pair)?;
        let percent = 100.0 * given.share_of_best;
        writeln!(text, "\nThe last line is the pair asked for: {percent:.1} % of the best worst gain.")?;
    }
    Ok(text)
}
