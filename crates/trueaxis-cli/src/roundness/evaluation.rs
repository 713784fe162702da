//! Evaluation of a separated measurement: zones, harmonics, error motion.

use super::trace::Resampling;
use anyhow::{Result, anyhow};
use rayon::prelude::*;
use serde::Serialize;
use trueaxis_metrology::circles::{ReferenceCircle, limacon};
use trueaxis_metrology::separation::{Harmonic, Separation, Separator};
use trueaxis_metrology::spindle::{ErrorMotion, error_motion};

/// The JSON document.
#[derive(Serialize)]
pub(crate) struct Document {
    pub(crate) n: usize,
    pub(crate) revolutions: usize,
    /// Cut-off of the filter before the zones.
    pub(crate) upr: Option<u16>,
    /// Of readings with an angle of their own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) resampling: Option<Resampling>,
    #[serde(flatten)]
    pub(crate) zones: Zones,
    pub(crate) centres_um: Centres,
    pub(crate) per_revolution: Vec<Revolution>,
    pub(crate) harmonics: Vec<HarmonicEntry>,
    pub(crate) spindle: Spindle,
    pub(crate) warnings: Vec<String>,
}

/// Peak-to-valley about the four reference circles.
#[derive(Clone, Copy, Serialize)]
pub(crate) struct Zones {
    pub(crate) lsc_um: f64,
    pub(crate) mzc_um: f64,
    pub(crate) mic_um: f64,
    pub(crate) mcc_um: f64,
}

/// Centres of the four reference circles.
#[derive(Serialize)]
pub(crate) struct Centres {
    lsc: [f64; 2],
    mzc: [f64; 2],
    mic: [f64; 2],
    mcc: [f64; 2],
}

#[derive(Serialize)]
pub(crate) struct Revolution {
    /// Counted from 1.
    pub(crate) revolution: usize,
    #[serde(flatten)]
    pub(crate) zones: Zones,
    /// Largest distance of this revolution's error motion from the mean contour.
    pub(crate) x_from_mean_um: f64,
    pub(crate) y_from_mean_um: f64,
}

#[derive(Serialize)]
pub(crate) struct HarmonicEntry {
    pub(crate) k: u16,
    pub(crate) amplitude_um: f64,
    pub(crate) phase_deg: f64,
    pub(crate) noise_gain: f64,
    pub(crate) suppressed: bool,
}

#[derive(Serialize)]
pub(crate) struct Spindle {
    pub(crate) x: SpindleDirection,
    pub(crate) y: SpindleDirection,
}

#[derive(Serialize)]
pub(crate) struct SpindleDirection {
    pub(crate) synchronous_um: f64,
    pub(crate) asynchronous_um: Option<f64>,
    pub(crate) once_per_revolution_um: f64,
    pub(crate) once_per_revolution_phase_deg: f64,
    pub(crate) total_um: f64,
}

/// The four reference circles of a profile, limaçon approximation.
pub(crate) struct Circles {
    pub(crate) lsc: ReferenceCircle,
    pub(crate) mzc: ReferenceCircle,
    pub(crate) mic: ReferenceCircle,
    pub(crate) mcc: ReferenceCircle,
}

/// The document and the curves behind it.
pub(crate) struct Evaluation {
    pub(crate) document: Document,
    /// Averaged over the revolutions, behind the filter.
    pub(crate) profile: Vec<f64>,
    pub(crate) circles: Circles,
    pub(crate) x: ErrorMotion,
    pub(crate) y: ErrorMotion,
}

impl Circles {
    fn of(profile: &[f64]) -> Result<Circles> {
        let named = |name: &'static str| move |error| anyhow!("{name} of the profile: {error}");
        Ok(Circles {
            lsc: limacon::least_squares(profile).map_err(named("LSC"))?,
            mzc: limacon::minimum_zone(profile).map_err(named("MZC"))?,
            mic: limacon::maximum_inscribed(profile).map_err(named("MIC"))?,
            mcc: limacon::minimum_circumscribed(profile).map_err(named("MCC"))?,
        })
    }

    fn zones(&self) -> Zones {
        Zones { lsc_um: self.lsc.zone, mzc_um: self.mzc.zone, mic_um: self.mic.zone, mcc_um: self.mcc.zone }
    }

    fn centres(&self) -> Centres {
        Centres { lsc: self.lsc.centre, mzc: self.mzc.centre, mic: self.mic.centre, mcc: self.mcc.centre }
    }
}

impl Evaluation {
    pub(crate) fn new(separator: &Separator, separations: &[Separation], upr: Option<u16>) -> Result<Evaluation> {
        let points = separator.gain().points();
        let filtered = |profile: &[f64]| match upr {
            Some(cut_off) => separator.filtered(profile, cut_off),
            None => Ok(profile.to_vec()),
        };
        let mean = mean(separations.iter().map(|parts| &parts.profile), points, separations.len());
        let profile = filtered(&mean)?;
        let circles = Circles::of(&profile)?;
        let motion = |part: fn(&Separation) -> &[f64]| {
            let values: Vec<f64> = separations.iter().flat_map(|parts| part(parts).iter().copied()).collect();
            error_motion(&values, points)
        };
        let (x, y) = (motion(|parts| &parts.x)?, motion(|parts| &parts.y)?);
        let zones: Vec<Zones> = separations
            .par_iter()
            .map(|parts| Ok(Circles::of(&filtered(&parts.profile)?)?.zones()))
            .collect::<Result<_>>()?;
        let per_revolution = (1..)
            .zip(zones)
            .zip(x.departure.iter().zip(&y.departure))
            .map(|((revolution, zones), (x, y))| Revolution {
                revolution,
                zones,
                x_from_mean_um: *x,
                y_from_mean_um: *y,
            })
            .collect();
        let document = Document {
            n: points,
            revolutions: separations.len(),
            upr,
            resampling: None,
            zones: circles.zones(),
            centres_um: circles.centres(),
            per_revolution,
            harmonics: separator.harmonics(&mean)?.into_iter().map(HarmonicEntry::from).collect(),
            spindle: Spindle { x: SpindleDirection::from(&x), y: SpindleDirection::from(&y) },
            warnings: Vec::new(),
        };
        Ok(Evaluation { document, profile, circles, x, y })
    }
}

fn mean<'a>(profiles: impl Iterator<Item = &'a Vec<f64>>, points: usize, count: usize) -> Vec<f64> {
    let mut sum = vec![0.0; points];
    for profile in profiles {
        for (sum, value) in sum.iter_mut().zip(profile) {
            *sum += value;
        }
    }
    sum.iter().map(|sum| sum / count as f64).collect()
}

impl From<Harmonic> for HarmonicEntry {
    fn from(harmonic: Harmonic) -> Self {
        HarmonicEntry {
            k: harmonic.k,
            amplitude_um: harmonic.amplitude,
            phase_deg: harmonic.phase.to_degrees(),
            noise_gain: harmonic.noise_gain,
            suppressed: harmonic.suppressed,
        }
    }
}

impl From<&ErrorMotion> for SpindleDirection {
    fn from(motion: &ErrorMotion) -> Self {
        SpindleDirection {
            synchronous_um: motion.synchronous,
            asynchronous_um: motion.asynchronous,
            once_per_revolution_um: motion.once_per_revolution,
            once_per_revolution_phase_deg: motion.once_per_revolution_phase.to_degrees(),
            total_um: motion.total,
        }
    }
}
