//! Three probes around a part as specified to a command: points of a revolution, band of harmonics, angles.

use anyhow::{Result, anyhow, bail};
use serde::{Deserialize, Serialize};
use trueaxis::roundness::{Band, Gain, ProbeAngles};
use trueaxis_metrology::probe_places::ProbePlaces;

/// Minimum number of points per revolution.
const FEWEST: usize = 64;
/// Maximum number of points per revolution.
const MOST: usize = 4096;
/// Last harmonic by default, if N allows it.
const LAST: u16 = 100;

/// Points, band and angles as requested, unchecked; angles as slots `p`, `q`, in degrees, or absent.
///
/// Errors name the options of the command line.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Probes {
    /// Points of a revolution N, a power of two from 64 to 4096.
    pub n: usize,
    /// First and last harmonic in undulations per revolution; by default 2 to 100 or to N/2 − 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub harmonics: Option<[u16; 2]>,
    /// Slots from probe 1 to probe 2, φ2 = 360° p/N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p: Option<i64>,
    /// Slots from probe 2 to probe 3, φ3 = 360° q/N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub q: Option<i64>,
    /// Angle from probe 1 to probe 2, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phi2_deg: Option<f64>,
    /// Angle from probe 2 to probe 3, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phi3_deg: Option<f64>,
    /// Angles of three to six probes from probe 1, degrees, instead of a pair.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angles_deg: Option<Vec<f64>>,
}

impl Probes {
    /// Points of a revolution N.
    ///
    /// # Errors
    /// If N is not a power of two from 64 to 4096.
    pub fn points(&self) -> Result<usize> {
        if !self.n.is_power_of_two() || !(FEWEST..=MOST).contains(&self.n) {
            bail!("--n: found {}, needed a power of two from {FEWEST} to {MOST}", self.n);
        }
        Ok(self.n)
    }

    /// The band of harmonics.
    ///
    /// # Errors
    /// A band that does not suit N, or as [`Probes::points`].
    pub fn band(&self) -> Result<Band> {
        let points = self.points()?;
        let highest = u16::try_from(points / 2 - 1)?;
        let [first, last] = self.harmonics.unwrap_or([2, LAST.min(highest)]);
        let band = Band { first, last };
        band.check(points).map_err(|error| {
            anyhow!("--harmonics: found {first}..{last}, needed {} (N/2 = {})", error.needed, points / 2)
        })?;
        Ok(band)
    }

    /// Whether the request states a pair of angles.
    pub fn has_angles(&self) -> bool {
        self.p.is_some() || self.phi2_deg.is_some()
    }

    /// The requested places of three to six probes, if they are not given as a pair of angles. Refused if they cannot see some
    /// harmonics of the band; the error names all of them.
    ///
    /// # Errors
    /// Places that [`ProbePlaces::new`] refuses, as [`Probes::band`], or blind places.
    pub fn places(&self) -> Result<Option<ProbePlaces>> {
        self.angles_deg.as_ref().map(|angles| places(angles, self.band()?)).transpose()
    }

    /// The slots as given.
    pub fn slots(&self) -> Option<[i64; 2]> {
        self.p.zip(self.q).map(|(p, q)| [p, q])
    }

    /// The requested arrangement, which may be blind to harmonics of the band.
    ///
    /// # Errors
    /// No angles, slots outside 1 to N − 1, probes on one line through the centre, or as [`Probes::points`].
    pub fn arrangement(&self) -> Result<Gain> {
        let points = self.points()?;
        let (names, angles) = (self.names(), self.angles(points)?);
        angles.resolve(points).map_err(|error| {
            let name = if error.index == Some(1) { names[1] } else { names[0] };
            anyhow!("{name}: found {}, needed {}", error.found, error.needed)
        })
    }

    /// The requested arrangement. Refused if it cannot see some harmonics of the band; the error names all of them.
    ///
    /// # Errors
    /// As [`Probes::arrangement`] and [`Probes::band`], or a blind arrangement.
    pub fn gain(&self) -> Result<Gain> {
        let (names, band) = (self.names(), self.band()?);
        let gain = self.arrangement()?;
        refuse_blind(&names.join(", "), gain.singular(band))?;
        Ok(gain)
    }

    fn names(&self) -> [&'static str; 2] {
        if self.slots().is_some() { ["--p", "--q"] } else { ["--phi2-deg", "--phi3-deg"] }
    }

    fn angles(&self, points: usize) -> Result<ProbeAngles> {
        match (self.slots(), self.phi2_deg, self.phi3_deg) {
            (Some(slots), _, _) => {
                let mut found = [0; 2];
                for ((name, slot), found) in ["--p", "--q"].into_iter().zip(slots).zip(&mut found) {
                    *found = u16::try_from(slot)
                        .ok()
                        .filter(|slot| (1..points).contains(&usize::from(*slot)))
                        .ok_or_else(|| anyhow!("{name}: found {slot}, needed 1 to {} (N − 1)", points - 1))?;
                }
                Ok(ProbeAngles::Slots { p: found[0], q: found[1] })
            }
            (None, Some(phi2), Some(phi3)) => Ok(ProbeAngles::Degrees { phi2, phi3 }),
            _ => bail!("found no probe angles, needed --p and --q, --phi2-deg and --phi3-deg, or --angles-deg"),
        }
    }
}

/// Probes at the angles of `--angles-deg`. Refused if they cannot see some harmonics of the band.
pub(crate) fn places(angles_deg: &[f64], band: Band) -> Result<ProbePlaces> {
    let places = ProbePlaces::new(angles_deg).map_err(|error| match error.index {
        Some(index) => anyhow!("--angles-deg, probe {}: found {}, needed {}", index + 1, error.found, error.needed),
        None => anyhow!("--angles-deg: found {}, needed {}", error.found, error.needed),
    })?;
    refuse_blind("--angles-deg", band.iter().filter(|k| places.noise_gain(usize::from(*k)).is_infinite()))?;
    Ok(places)
}

/// Refuses angles, given by `options`, that cannot see some harmonics of the band.
fn refuse_blind(options: &str, blind: impl Iterator<Item = u16>) -> Result<()> {
    let blind: Vec<String> = blind.map(|k| k.to_string()).collect();
    if !blind.is_empty() {
        bail!(
            "{options}: found angles that cannot see harmonics {}, needed others or --harmonics without these",
            blind.join(", ")
        );
    }
    Ok(())
}
