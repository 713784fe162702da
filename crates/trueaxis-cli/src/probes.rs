//! Angles of three probes on the command line.

use anyhow::{Result, anyhow, bail};
use clap::Args;
use trueaxis::roundness::{Band, Gain, ProbeAngles};

/// Fewest points of a revolution.
const FEWEST: usize = 64;
/// Most points of a revolution.
const MOST: usize = 4096;
/// Last harmonic where none is asked for, if N allows it.
const LAST: u16 = 100;

#[derive(Args)]
pub(crate) struct ProbeArguments {
    /// Points of a revolution N, a power of two from 64 to 4096.
    #[arg(long, value_name = "N")]
    n: usize,
    /// Band of harmonics in undulations per revolution, 2 or more and below N/2 [default: 2..100, or up to N/2 − 1].
    #[arg(long, value_name = "FIRST..LAST", value_parser = band)]
    harmonics: Option<Band>,
    /// Slots from probe 1 to probe 2: φ2 = 360° p/N, from 1 to N − 1.
    #[arg(long, value_parser = slots, requires = "q", conflicts_with_all = ["phi2_deg", "phi3_deg"], allow_hyphen_values = true)]
    p: Option<i64>,
    /// Slots from probe 2 to probe 3: φ3 = 360° q/N, from 1 to N − 1.
    #[arg(long, value_parser = slots, requires = "p", conflicts_with_all = ["phi2_deg", "phi3_deg"], allow_hyphen_values = true)]
    q: Option<i64>,
    /// Angle from probe 1 to probe 2, in the sense of θ; any real number.
    #[arg(long, value_name = "DEG", requires = "phi3_deg", allow_hyphen_values = true)]
    phi2_deg: Option<f64>,
    /// Angle from probe 2 to probe 3.
    #[arg(long, value_name = "DEG", requires = "phi2_deg", allow_hyphen_values = true)]
    phi3_deg: Option<f64>,
}

fn slots(text: &str) -> Result<i64, String> {
    text.parse()
        .map_err(|_| "needed a whole number of slots; angles between slots go into --phi2-deg, --phi3-deg".into())
}

fn band(text: &str) -> Result<Band, String> {
    let needed = "needed two whole numbers as in 2..100";
    let (first, last) = text.split_once("..").ok_or(needed)?;
    match (first.trim().parse(), last.trim().parse()) {
        (Ok(first), Ok(last)) => Ok(Band { first, last }),
        _ => Err(needed.into()),
    }
}

impl ProbeArguments {
    /// N.
    pub(crate) fn points(&self) -> Result<usize> {
        if !self.n.is_power_of_two() || !(FEWEST..=MOST).contains(&self.n) {
            bail!("--n: found {}, needed a power of two from {FEWEST} to {MOST}", self.n);
        }
        Ok(self.n)
    }

    /// The band, checked.
    pub(crate) fn band(&self) -> Result<Band> {
        let points = self.points()?;
        let highest = u16::try_from(points / 2 - 1)?;
        let band = self.harmonics.unwrap_or(Band { first: 2, last: LAST.min(highest) });
        band.check(points).map_err(|error| {
            anyhow!("--harmonics: found {}..{}, needed {} (N/2 = {})", band.first, band.last, error.needed, points / 2)
        })?;
        Ok(band)
    }

    /// Whether a pair of angles was given.
    pub(crate) fn has_angles(&self) -> bool {
        self.p.is_some() || self.phi2_deg.is_some()
    }

    /// The slots as given.
    pub(crate) fn slots(&self) -> Option<[i64; 2]> {
        self.p.zip(self.q).map(|(p, q)| [p, q])
    }

    /// The arrangement asked for. Refused where it cannot see some harmonics of the band, all of them named.
    pub(crate) fn gain(&self) -> Result<Gain> {
        let (points, band) = (self.points()?, self.band()?);
        let (names, angles) = match (self.slots(), self.phi2_deg, self.phi3_deg) {
            (Some(slots), _, _) => {
                let mut found = [0; 2];
                for ((name, slot), found) in ["--p", "--q"].into_iter().zip(slots).zip(&mut found) {
                    *found = u16::try_from(slot)
                        .ok()
                        .filter(|slot| (1..points).contains(&usize::from(*slot)))
                        .ok_or_else(|| anyhow!("{name}: found {slot}, needed 1 to {} (N − 1)", points - 1))?;
                }
                (["--p", "--q"], ProbeAngles::Slots { p: found[0], q: found[1] })
            }
            (None, Some(phi2), Some(phi3)) => (["--phi2-deg", "--phi3-deg"], ProbeAngles::Degrees { phi2, phi3 }),
            _ => bail!("found no probe angles, needed --p and --q, or --phi2-deg and --phi3-deg"),
        };
        let gain = angles.resolve(points).map_err(|error| {
            let name = if error.index == Some(1) { names[1] } else { names[0] };
            anyhow!("{name}: found {}, needed {}", error.found, error.needed)
        })?;
        let blind: Vec<String> = gain.singular(band).map(|k| k.to_string()).collect();
        if !blind.is_empty() {
            bail!(
                "{}, {}: found angles that cannot see harmonics {}, needed others or --harmonics without these",
                names[0],
                names[1],
                blind.join(", ")
            );
        }
        Ok(gain)
    }
}
