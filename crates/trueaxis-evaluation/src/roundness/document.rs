//! Evaluation of a separated measurement: zones, harmonics, error motion.

use super::trace::Resampling;
use anyhow::{Result, anyhow};
use serde::Serialize;
use trueaxis_metrology::circles::{ReferenceCircle, limacon};
use trueaxis_metrology::cores::*;
use trueaxis_metrology::separation::{Harmonic, Separation, Separator};
use trueaxis_metrology::spindle::{ErrorMotion, error_motion};

/// The JSON document.
#[derive(Clone, Debug, Serialize)]
pub struct Document {
    /// Points of a revolution N.
    pub n: usize,
    /// Whole revolutions.
    pub revolutions: usize,
    /// Cut-off of the filter before the zones.
    pub upr: Option<u16>,
    /// Of readings with an angle of their own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resampling: Option<Resampling>,
    /// Of the mean profile behind the filter.
    #[serde(flatten)]
    pub zones: Zones,
    /// Of the mean profile behind the filter.
    pub centres_um: Centres,
    /// Every revolution for itself.
    pub per_revolution: Vec<Revolution>,
    /// Of the mean profile before the filter.
    pub harmonics: Vec<HarmonicEntry>,
    /// Error motion of the spindle.
    pub spindle: Spindle,
    /// What is doubtful.
    pub warnings: Vec<String>,
}

/// Peak-to-valley about the four reference circles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Zones {
    /// Least squares.
    pub lsc_um: f64,
    /// Minimum zone.
    pub mzc_um: f64,
    /// Maximum inscribed.
    pub mic_um: f64,
    /// Minimum circumscribed.
    pub mcc_um: f64,
}

/// Centres of the four reference circles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Centres {
    /// Least squares, x and y.
    pub lsc: [f64; 2],
    /// Minimum zone, x and y.
    pub mzc: [f64; 2],
    /// Maximum inscribed, x and y.
    pub mic: [f64; 2],
    /// Minimum circumscribed, x and y.
    pub mcc: [f64; 2],
}

/// One revolution.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Revolution {
    /// Counted from 1.
    pub revolution: usize,
    /// Of its profile behind the filter.
    #[serde(flatten)]
    pub zones: Zones,
    /// Largest distance of this revolution's error motion from the mean contour.
    pub x_from_mean_um: f64,
    /// The same in Y.
    pub y_from_mean_um: f64,
}

/// A harmonic, A cos(k θ + phase).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HarmonicEntry {
    /// Undulations per revolution.
    pub k: u16,
    /// A; 0 where suppressed.
    pub amplitude_um: f64,
    /// −180 to 180.
    pub phase_deg: f64,
    /// Growth of the probes' noise.
    pub noise_gain: f64,
    /// Left out: its noise gain is above the limit.
    pub suppressed: bool,
}

/// Error motion of the spindle after ISO 230-7.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spindle {
    /// Across the direction of probe 1.
    pub x: SpindleDirection,
    /// Along it.
    pub y: SpindleDirection,
}

/// Error motion in one direction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpindleDirection {
    /// Peak to valley of the mean contour, the once-per-revolution part taken out.
    pub synchronous_um: f64,
    /// Largest range over the revolutions at one angle; none of a single revolution.
    pub asynchronous_um: Option<f64>,
    /// Amplitude of the once-per-revolution part.
    pub once_per_revolution_um: f64,
    /// Its phase, −180 to 180.
    pub once_per_revolution_phase_deg: f64,
    /// Peak to valley of all revolutions, the once-per-revolution part taken out.
    pub total_um: f64,
}

/// The four reference circles of a profile, limaçon approximation.
#[derive(Clone, Debug)]
pub struct Circles {
    /// Least squares.
    pub lsc: ReferenceCircle,
    /// Minimum zone.
    pub mzc: ReferenceCircle,
    /// Maximum inscribed.
    pub mic: ReferenceCircle,
    /// Minimum circumscribed.
    pub mcc: ReferenceCircle,
}

/// The document and the curves behind it.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// The document.
    pub document: Document,
    /// Averaged over the revolutions, behind the filter.
    pub profile: Vec<f64>,
    /// Of that profile.
    pub circles: Circles,
    /// Across the direction of probe 1.
    pub x: ErrorMotion,
    /// Along it.
    pub y: ErrorMotion,
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
    pub(super) fn new(separator: &Separator, separations: &[Separation], upr: Option<u16>) -> Result<Evaluation> {
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
