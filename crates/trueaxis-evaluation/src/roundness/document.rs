//! Evaluation of a separated measurement: zones, harmonics, error motion.

use super::trace::Resampling;
use anyhow::{Result, anyhow};
use serde::Serialize;
use trueaxis_metrology::circles::{ReferenceCircle, limacon};
use trueaxis_metrology::cores::*;
use trueaxis_metrology::separation::{Agreement, Arrangement, Harmonic, Separation, Separator};
use trueaxis_metrology::spindle::{ErrorMotion, error_motion};

/// The JSON document.
#[derive(Clone, Debug, Serialize)]
pub struct RoundnessDocument {
    /// Points per revolution N.
    pub n: usize,
    /// Number of whole revolutions.
    pub revolutions: usize,
    /// Cut-off of the filter applied before the zones.
    pub upr: Option<u16>,
    /// Resampling of readings that have their own angles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resampling: Option<Resampling>,
    /// Zones of the filtered mean profile.
    #[serde(flatten)]
    pub zones: Zones,
    /// Centres of the filtered mean profile.
    pub centres_um: Centres,
    /// Each revolution separately.
    pub per_revolution: Vec<Revolution>,
    /// Harmonics of the unfiltered mean profile.
    pub harmonics: Vec<HarmonicEntry>,
    /// Error motion of the spindle.
    pub spindle: Spindle,
    /// How far four to six probes disagree.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub agreement: Option<AgreementEntry>,
    /// Doubtful findings.
    pub warnings: Vec<String>,
}

/// Contradiction of four to six probes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AgreementEntry {
    /// Standard deviation of a reading's noise that would explain the contradiction.
    pub noise_um: f64,
    /// The probe, from 1, without which the others agree at least twice as well, if chance does not explain it.
    pub disagreeing: Option<usize>,
    /// Each probe.
    pub probes: Vec<ProbeEntry>,
}

/// A probe against the others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProbeEntry {
    /// Stated angle from probe 1, in the sense of θ.
    pub angle_deg: f64,
    /// Contradiction in its readings, root mean square.
    pub residual_um: f64,
    /// Noise that would explain the contradiction of the others; `None` with fewer than five probes.
    pub noise_without_um: Option<f64>,
    /// True angle less the stated one; `None` for probe 1, the reference.
    pub angle_error_deg: Option<f64>,
    /// Its standard error.
    pub angle_error_standard_error_deg: Option<f64>,
    /// Sensitivity relative to that of probe 1, less 1.
    pub sensitivity_error: Option<f64>,
    /// Its standard error.
    pub sensitivity_error_standard_error: Option<f64>,
}

impl AgreementEntry {
    pub(super) fn new(found: &Agreement, arrangement: &Arrangement) -> AgreementEntry {
        let mounting = std::iter::once(None).chain(found.mounting.iter().copied().map(Some));
        let probes = arrangement.degrees().into_iter().zip(&found.residual).zip(&found.noise_without).zip(mounting);
        let probes = probes.map(|(((angle_deg, residual_um), noise_without_um), mounting)| ProbeEntry {
            angle_deg,
            residual_um: *residual_um,
            noise_without_um: *noise_without_um,
            angle_error_deg: mounting.map(|of| of.angle[0].to_degrees()),
            angle_error_standard_error_deg: mounting.map(|of| of.angle[1].to_degrees()),
            sensitivity_error: mounting.map(|of| of.sensitivity[0]),
            sensitivity_error_standard_error: mounting.map(|of| of.sensitivity[1]),
        });
        AgreementEntry {
            noise_um: found.noise,
            disagreeing: found.disagreeing.map(|probe| probe + 1),
            probes: probes.collect(),
        }
    }
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
    /// Number of the revolution, from 1.
    pub revolution: usize,
    /// Zones of its filtered profile.
    #[serde(flatten)]
    pub zones: Zones,
    /// Largest distance in X of this revolution's error motion from the mean contour.
    pub x_from_mean_um: f64,
    /// Largest such distance in Y.
    pub y_from_mean_um: f64,
}

/// A harmonic, A cos(k θ + phase).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HarmonicEntry {
    /// Undulations per revolution.
    pub k: u16,
    /// Amplitude A; 0 if suppressed.
    pub amplitude_um: f64,
    /// Phase, −180 to 180.
    pub phase_deg: f64,
    /// Growth of the probes' noise.
    pub noise_gain: f64,
    /// Omitted because its noise gain exceeds the limit.
    pub suppressed: bool,
}

/// Error motion of the spindle after ISO 230-7.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spindle {
    /// Across the direction of probe 1.
    pub x: SpindleDirection,
    /// Along the direction of probe 1.
    pub y: SpindleDirection,
}

/// Error motion in one direction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpindleDirection {
    /// Peak to valley of the mean contour without the once-per-revolution part.
    pub synchronous_um: f64,
    /// Largest range over the revolutions at one angle; `None` for a single revolution.
    pub asynchronous_um: Option<f64>,
    /// Amplitude of the once-per-revolution part.
    pub once_per_revolution_um: f64,
    /// Phase of that part, −180 to 180.
    pub once_per_revolution_phase_deg: f64,
    /// Peak to valley of all revolutions without the once-per-revolution part.
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
    pub document: RoundnessDocument,
    /// Profile averaged over the revolutions, filtered.
    pub profile: Vec<f64>,
    /// Reference circles of `profile`.
    pub circles: Circles,
    /// Across the direction of probe 1.
    pub x: ErrorMotion,
    /// Along the direction of probe 1.
    pub y: ErrorMotion,
}

impl Circles {
    fn of(turn: &limacon::Turn, profile: &[f64]) -> Result<Circles> {
        let [lsc, mzc, mic, mcc] =
            turn.four_circles(profile).map_err(|error| anyhow!("circles of the profile: {error}"))?;
        Ok(Circles { lsc, mzc, mic, mcc })
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
        let points = separator.points();
        let filtered = |profile: &[f64]| match upr {
            Some(cut_off) => separator.filtered(profile, cut_off),
            None => Ok(profile.to_vec()),
        };
        let mean = mean(separations.iter().map(|parts| parts.profile.as_slice()), points, separations.len());
        let profile = filtered(&mean)?;
        let turn = limacon::Turn::new(points);
        let circles = Circles::of(&turn, &profile)?;
        let motion = |part: fn(&Separation) -> &[f64]| {
            let values: Vec<f64> = separations.iter().flat_map(|parts| part(parts).iter().copied()).collect();
            error_motion(&values, points)
        };
        let (x, y) = (motion(|parts| &parts.x)?, motion(|parts| &parts.y)?);
        let zones: Vec<Zones> = separations
            .par_iter()
            .map(|parts| Ok(Circles::of(&turn, &filtered(&parts.profile)?)?.zones()))
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
        let document = RoundnessDocument {
            n: points,
            revolutions: separations.len(),
            upr,
            resampling: None,
            zones: circles.zones(),
            centres_um: circles.centres(),
            per_revolution,
            harmonics: separator.harmonics(&mean)?.into_iter().map(HarmonicEntry::from).collect(),
            spindle: Spindle { x: SpindleDirection::from(&x), y: SpindleDirection::from(&y) },
            agreement: None,
            warnings: Vec::new(),
        };
        Ok(Evaluation { document, profile, circles, x, y })
    }
}

/// Mean of `count` profiles.
pub(super) fn mean<'a>(profiles: impl Iterator<Item = &'a [f64]>, points: usize, count: usize) -> Vec<f64> {
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
