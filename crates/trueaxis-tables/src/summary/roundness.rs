//! The three-probe gauge of a compiled file.

use crate::text::short;
use serde::Serialize;
use std::fmt;
use trueaxis::roundness::{Band, GaugeSettings};

/// The three-probe gauge of a compiled file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RoundnessSummary {
    /// Points per revolution.
    pub points: u16,
    /// φ2 and φ3, degrees.
    pub angles_deg: [f64; 2],
    /// Lowest and highest harmonic.
    pub harmonics: [u16; 2],
    /// Worst noise gain among them.
    pub worst_noise_gain: f64,
    /// Crank throw, wheel radius, pin radius, mm.
    pub arm_mm: Option<[f64; 3]>,
    /// Cut-off of the Gaussian filter, UPR.
    pub filter_upr: Option<u16>,
    /// Axis of the infeed correction and its gain.
    pub infeed: Option<(char, f64)>,
}

/// Summary of the gauge; `None` if its angles are not valid.
pub(super) fn roundness(settings: &GaugeSettings) -> Option<RoundnessSummary> {
    let gain = settings.angles.resolve(usize::from(settings.points)).ok()?;
    let Band { first, last } = settings.band;
    Some(RoundnessSummary {
        points: settings.points,
        angles_deg: [gain.phi2(), gain.phi3()].map(f64::to_degrees),
        harmonics: [first, last],
        worst_noise_gain: 1.0 / gain.worst(settings.band),
        arm_mm: settings.arm.map(|arm| [arm.lengths.crank_mm, arm.lengths.wheel_mm, arm.lengths.pin_mm]),
        filter_upr: settings.filter,
        infeed: settings.infeed.map(|infeed| (infeed.axis.letter(), infeed.gain)),
    })
}

impl fmt::Display for RoundnessSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([phi2, phi3], [first, last]) = (self.angles_deg, self.harmonics);
        write!(f, "\n\nroundness   {} points, probes {phi2:.4}° and {phi3:.4}° on", self.points)?;
        write!(f, ", harmonics {first} to {last}, noise gain up to {:.2}", self.worst_noise_gain)?;
        if let Some([crank, wheel, pin]) = self.arm_mm.map(|arm| arm.map(short)) {
            write!(f, "\n  arm        crank throw {crank}, wheel {wheel}, pin {pin} mm")?;
        }
        if let Some(cut_off) = self.filter_upr {
            write!(f, "\n  filter     Gaussian, {cut_off} UPR")?;
        }
        if let Some((axis, gain)) = self.infeed {
            write!(f, "\n  correction infeed on {axis}, gain {gain}")?;
        }
        Ok(())
    }
}
