//! Places of three to six probes: the best found within mechanical limits, and the noise gain of given ones.

use crate::probe_angles::NoiseGain;
use crate::probes::{Probes, places};
use crate::shown::{Cell, Table};
use anyhow::{Result, anyhow, bail};
use serde::{Deserialize, Serialize};
use trueaxis::roundness::Band;
use trueaxis_metrology::cores::*;
use trueaxis_metrology::probe_places::{Limits, PROBES, PlaceSearch, Placed, ProbePlaces};

/// Maximum number of arrangements listed, and of starts.
const MOST: usize = 10_000;
/// Number of starts by default: four probes on 1024 points take some seconds of two cores.
pub const USUAL_STARTS: usize = 1000;

/// The search, and the places to compare with its result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// Points of a revolution N, a power of two from 64 to 4096.
    pub n: usize,
    /// First and last harmonic in undulations per revolution; by default 2 to 100 or to N/2 − 1.
    #[serde(default)]
    pub harmonics: Option<[u16; 2]>,
    /// Number of probes, 3 to 6.
    pub probes: usize,
    /// Smallest angle between two probes, degrees.
    #[serde(default)]
    pub apart_deg: Option<f64>,
    /// Sector in which all probes stand, degrees; the whole circle unless given.
    #[serde(default)]
    pub within_deg: Option<f64>,
    /// Places to compare with the best, degrees; as many as probes.
    #[serde(default)]
    pub angles_deg: Option<Vec<f64>>,
    /// Arrangements to list, 1 to 10000.
    pub count: usize,
    /// Starts of the search, 1 to 10000.
    pub starts: usize,
}

/// The JSON document.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProbePlacesDocument {
    /// Points per revolution N.
    pub n: usize,
    /// First and last harmonic.
    pub harmonics: [u16; 2],
    /// Number of probes.
    pub probes: usize,
    /// Best places found, best first; each stands for its turned and mirrored images.
    pub best: Vec<Places>,
    /// The requested places.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub given: Option<GivenPlaces>,
}

/// Places of the probes and their worst harmonic.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Places {
    /// In slots of 360°/N; `None` for places given in degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slots: Option<Vec<usize>>,
    /// In the sense of θ.
    pub angles_deg: Vec<f64>,
    /// Smallest gain in the band, 0 (blind) to the root of the number of probes.
    pub worst_gain: f64,
    /// Inverse of `worst_gain`: growth of one reading's noise in the worst harmonic.
    pub worst_noise_gain: f64,
    /// The worst harmonic.
    pub worst_harmonic: u16,
    /// Worst noise gain if any one probe is lost; `None` with three probes, or if the others are blind to a harmonic of the band.
    pub worst_without_one: Option<f64>,
}

/// The requested places, compared with the best.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GivenPlaces {
    /// Places and worst harmonic.
    #[serde(flatten)]
    pub places: Places,
    /// Worst gain relative to the best places'.
    pub share_of_best: f64,
    /// Noise gains over the band.
    pub noise_gains: Vec<NoiseGain>,
}

/// A checked search.
#[derive(Debug)]
pub struct Search {
    points: usize,
    band: Band,
    probes: usize,
    count: usize,
    starts: u64,
    given: Option<(ProbePlaces, Vec<f64>)>,
    places: PlaceSearch,
}

impl Request {
    /// Checks the request and prepares the search.
    ///
    /// # Errors
    /// An invalid option, under its command-line name; places that cannot see some harmonics of the band.
    pub fn search(&self) -> Result<Search> {
        let probes = Probes { n: self.n, harmonics: self.harmonics, ..Probes::default() };
        let (points, band) = (probes.points()?, probes.band()?);
        for (name, found) in [("--count", self.count), ("--starts", self.starts)] {
            if !(1..=MOST).contains(&found) {
                bail!("{name}: found {found}, needed 1 to {MOST}");
            }
        }
        if !PROBES.contains(&self.probes) {
            bail!("--probes: found {}, needed {} to {}", self.probes, PROBES.start(), PROBES.end());
        }
        // Given places are refused before the search, not after.
        let given = self.angles_deg.as_ref().map(|angles| self.given(angles, band)).transpose()?;
        let places = PlaceSearch::new(points, band, self.probes, self.limits(points)?).map_err(|_| self.no_room())?;
        Ok(Search { points, band, probes: self.probes, count: self.count, starts: self.starts as u64, given, places })
    }

    fn limits(&self, points: usize) -> Result<Limits> {
        for (name, angle) in [("--apart-deg", self.apart_deg), ("--within-deg", self.within_deg)] {
            if let Some(found) = angle.filter(|angle| !(*angle > 0.0 && *angle <= 360.0)) {
                bail!("{name}: found {found}, needed above 0 to 360");
            }
        }
        let slots = |degrees: f64| degrees * points as f64 / 360.0;
        let apart = slots(self.apart_deg.unwrap_or_default()).ceil() as usize;
        let within = self.within_deg.map_or(points, |within| slots(within).floor() as usize);
        Ok(Limits { apart, within })
    }

    fn no_room(&self) -> anyhow::Error {
        let apart = self.apart_deg.unwrap_or(360.0 / self.n as f64);
        let (name, room) = match self.within_deg.filter(|within| *within < 360.0) {
            Some(within) => ("the sector of --within-deg", within / (self.probes - 1) as f64),
            None => ("the circle", 360.0 / self.probes as f64),
        };
        anyhow!(
            "--apart-deg: found {apart}, needed at most {room:.4}: {name} has no more room for {} probes",
            self.probes
        )
    }

    fn given(&self, angles: &[f64], band: Band) -> Result<(ProbePlaces, Vec<f64>)> {
        if angles.len() != self.probes {
            bail!("--angles-deg: found {} angles, needed {}, one for each of --probes", angles.len(), self.probes);
        }
        Ok((places(angles, band)?, angles.to_vec()))
    }
}

impl Search {
    /// Number of starts.
    pub fn steps(&self) -> u64 {
        self.starts
    }

    /// Runs the search on all cores; calls `done` after each start.
    ///
    /// # Errors
    /// A found arrangement that does not resolve.
    pub fn run(self, done: impl Fn() + Sync) -> Result<ProbePlacesDocument> {
        let found: Vec<Placed> = (0..self.starts)
            .into_par_iter()
            .filter_map(|start| {
                let found = self.places.from_start(start);
                done();
                found
            })
            .collect();
        let best: Vec<Places> = self
            .places
            .ranked(found, self.count)
            .into_iter()
            .map(|placed| {
                let degrees: Vec<f64> =
                    placed.slots.iter().map(|slot| 360.0 * *slot as f64 / self.points as f64).collect();
                Ok(Places::new(&ProbePlaces::new(&degrees)?, degrees, Some(placed.slots), self.band))
            })
            .collect::<Result<_>>()?;
        let given = self.given.map(|(places, degrees)| {
            let noise_gain = |k: u16| NoiseGain { k, noise_gain: places.noise_gain(usize::from(k)) };
            let noise_gains = self.band.iter().map(noise_gain).collect();
            let places = Places::new(&places, degrees, None, self.band);
            GivenPlaces {
                share_of_best: best.first().map_or(1.0, |best| places.worst_gain / best.worst_gain),
                places,
                noise_gains,
            }
        });
        Ok(ProbePlacesDocument {
            n: self.points,
            harmonics: [self.band.first, self.band.last],
            probes: self.probes,
            best,
            given,
        })
    }
}

impl Places {
    fn new(places: &ProbePlaces, angles_deg: Vec<f64>, slots: Option<Vec<usize>>, band: Band) -> Places {
        let (worst_harmonic, worst_noise_gain) = places.worst(band);
        Places {
            slots,
            angles_deg,
            worst_gain: 1.0 / worst_noise_gain,
            worst_noise_gain,
            worst_harmonic,
            worst_without_one: places.worst_without_one(band).filter(|gain| gain.is_finite()),
        }
    }
}

impl ProbePlacesDocument {
    /// The best places and, last, the requested ones.
    pub fn table(&self) -> Table {
        let row = |name: String, places: &Places| {
            let angles: Vec<String> = places.angles_deg.iter().map(|angle| format!("{angle:.3}")).collect();
            vec![
                name.into(),
                angles.join(", ").into(),
                Cell::fixed(places.worst_noise_gain, 3),
                Cell::count(places.worst_harmonic.into()),
                Cell::fixed(places.worst_without_one, 3),
            ]
        };
        let best = self.best.iter().enumerate().map(|(i, places)| row((i + 1).to_string(), places));
        let given = self
            .given
            .iter()
            .map(|given| row(format!("given, {:.1} % of the best gain", 100.0 * given.share_of_best), &given.places));
        let ([first, last], probes) = (self.harmonics, self.probes);
        let header = ["places", "angles, °", "worst noise gain", "at harmonic", "without any one probe"];
        Table::new(
            format!("Best places of {probes} probes, N = {}, harmonics {first} to {last}", self.n),
            header,
            best.chain(given),
        )
    }
}
