//! Angles of the three probes, and their gain for every harmonic.
//!
//! ```text
//! k2 = −sin(φ2 + φ3) / sin φ3      k3 = sin φ2 / sin φ3
//! G(k) = 1 + k2 e^{jkφ2} + k3 e^{jk(φ2 + φ3)}
//! noise gain(k) = √(1 + k2² + k3²) / |G(k)|
//! ```
//!
//! The weighted sum h1 + k2 h2 + k3 h3 no longer contains the motion of the centre; it contains harmonic k of the profile
//! multiplied by G(k). G(0) ≠ 0 in general, G(±1) = 0 always: a first harmonic of the profile is a displacement of its centre.

use crate::error::{ConfigError, Field};
use crate::range;
use core::f64::consts::{PI, TAU};

/// Noise gain from which a harmonic counts as invisible to an angle set.
const SINGULAR: f64 = 1e8;

/// A band of harmonics, undulations per revolution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Band {
    /// Lowest harmonic, at least 2.
    pub first: u16,
    /// Highest harmonic, below half the number of points.
    pub last: u16,
}

impl Band {
    /// All harmonics of the band, in ascending order.
    pub fn iter(self) -> impl Iterator<Item = u16> + Clone {
        self.first..=self.last
    }

    /// Whether a harmonic lies in the band.
    pub const fn contains(self, harmonic: u16) -> bool {
        self.first <= harmonic && harmonic <= self.last
    }

    /// Checks the band against the number of points of a revolution.
    ///
    /// # Errors
    /// The band begins below 2, is empty, or reaches half the number of points.
    pub fn check(self, points: usize) -> Result<(), ConfigError> {
        let refuse = |found: u16, needed| Err(ConfigError::new(Field::Harmonics, f64::from(found), needed));
        if self.first < 2 {
            return refuse(self.first, "2 or more: mean and first harmonic are the motion of the centre");
        }
        if self.last < self.first {
            return refuse(self.last, "a last harmonic that is not below the first");
        }
        if 2 * usize::from(self.last) >= points {
            return refuse(self.last, "harmonics below half the number of points");
        }
        Ok(())
    }
}

/// The angles between the probes: φ2 from probe 1 to probe 2, φ3 from probe 2 to probe 3, in the sense of θ.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ProbeAngles {
    /// In whole slots of 2π/N: `p` from probe 1 to 2, `q` from 2 to 3.
    Slots {
        /// φ2 = 2π p/N.
        p: u16,
        /// φ3 = 2π q/N.
        q: u16,
    },
    /// Any angles, as calibrated on the gauge, degrees.
    Degrees {
        /// φ2.
        phi2: f64,
        /// φ3.
        phi3: f64,
    },
}

impl ProbeAngles {
    /// The setting that contains the angles.
    pub(super) const fn field(self) -> Field {
        match self {
            ProbeAngles::Slots { .. } => Field::ProbeSlots,
            ProbeAngles::Degrees { .. } => Field::ProbeAngles,
        }
    }

    /// Checks the angles against the number of points and computes the weights.
    ///
    /// # Errors
    /// Slots outside 1..N, angles that are not finite or outside ±360°, or two probes on one line through the centre.
    pub fn resolve(self, points: usize) -> Result<Gain, ConfigError> {
        let [phi2, phi3] = match self {
            ProbeAngles::Slots { p, q } => {
                for (index, slots) in [(0, p), (1, q)] {
                    if slots == 0 || usize::from(slots) >= points {
                        let needed = "p and q from 1 to N − 1";
                        return Err(ConfigError::new(Field::ProbeSlots, f64::from(slots), needed).at(index));
                    }
                }
                [p, q].map(|slots| TAU * f64::from(slots) / points as f64)
            }
            ProbeAngles::Degrees { phi2, phi3 } => {
                for (index, angle) in [(0, phi2), (1, phi3)] {
                    range::ANGLE.check(angle, Field::ProbeAngles, None).map_err(|error| error.at(index))?;
                }
                [phi2.to_radians(), phi3.to_radians()]
            }
        };
        for (index, angle) in [(0, phi2), (1, phi3)] {
            if libm::fabs(libm::sin(angle)) < 1e-9 {
                let needed = "angles that are not multiples of 180°: two probes are on one line through the centre";
                return Err(ConfigError::new(self.field(), angle.to_degrees(), needed).at(index));
            }
        }
        if libm::fabs(libm::sin(0.5 * (phi2 + phi3))) < 1e-9 {
            let needed = "φ2 + φ3 not a multiple of 360°: probes 1 and 3 are at the same place";
            return Err(ConfigError::new(self.field(), (phi2 + phi3).to_degrees(), needed));
        }
        let slots = match self {
            ProbeAngles::Slots { p, q } => Some([usize::from(p), usize::from(q)]),
            ProbeAngles::Degrees { .. } => None,
        };
        Ok(Gain {
            phi2,
            phi3,
            k2: -libm::sin(phi2 + phi3) / libm::sin(phi3),
            k3: libm::sin(phi2) / libm::sin(phi3),
            slots,
            points,
        })
    }
}

/// Gain of an arrangement of probes for every harmonic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain {
    phi2: f64,
    phi3: f64,
    k2: f64,
    k3: f64,
    slots: Option<[usize; 2]>,
    points: usize,
}

impl Gain {
    /// φ2, rad.
    pub fn phi2(&self) -> f64 {
        self.phi2
    }

    /// φ3, rad.
    pub fn phi3(&self) -> f64 {
        self.phi3
    }

    /// Weight of the second probe.
    pub fn k2(&self) -> f64 {
        self.k2
    }

    /// Weight of the third probe.
    pub fn k3(&self) -> f64 {
        self.k3
    }

    /// Points of a revolution.
    pub fn points(&self) -> usize {
        self.points
    }

    /// φ2 and φ3 in whole slots, if the settings state them so.
    pub fn slots(&self) -> Option<[usize; 2]> {
        self.slots
    }

    /// G(k), `[re, im]`.
    pub fn of(&self, harmonic: usize) -> [f64; 2] {
        let [c2, s2] = self.phase2(harmonic);
        let [c3, s3] = self.phasor(harmonic, self.slots.map(|[p, q]| p + q), self.phi2 + self.phi3);
        [1.0 + self.k2 * c2 + self.k3 * c3, self.k2 * s2 + self.k3 * s3]
    }

    /// e^{jkφ2}: factor of harmonic k from r(θ) to r(θ + φ2).
    pub fn phase2(&self, harmonic: usize) -> [f64; 2] {
        self.phasor(harmonic, self.slots.map(|[p, _]| p), self.phi2)
    }

    /// Reduces whole slots as integers so that no rounding grows with the harmonic.
    fn phasor(&self, harmonic: usize, slots: Option<usize>, angle: f64) -> [f64; 2] {
        let angle = match slots {
            Some(slots) => TAU * (slots * harmonic).checked_rem(self.points).unwrap_or(0) as f64 / self.points as f64,
            None => libm::remainder(harmonic as f64 * angle, 2.0 * PI),
        };
        [libm::cos(angle), libm::sin(angle)]
    }

    /// √(1 + k2² + k3²): standard deviation of the weighted sum if that of every probe is 1.
    pub fn norm(&self) -> f64 {
        libm::sqrt(1.0 + self.k2 * self.k2 + self.k3 * self.k3)
    }

    /// Gain of the probes' noise in harmonic k of the profile; infinite where |G| is zero.
    pub fn noise_gain(&self, harmonic: usize) -> f64 {
        let [re, im] = self.of(harmonic);
        self.norm() / libm::hypot(re, im)
    }

    /// Whether the arrangement cannot see a harmonic at all.
    pub fn is_singular(&self, harmonic: usize) -> bool {
        let noise_gain = self.noise_gain(harmonic);
        noise_gain.is_nan() || noise_gain >= SINGULAR
    }

    /// All harmonics of a band that the arrangement cannot see.
    pub fn singular(&self, band: Band) -> impl Iterator<Item = u16> + '_ {
        band.iter().filter(|k| self.is_singular(usize::from(*k)))
    }

    /// Smallest |G|/√(1 + k2² + k3²) in a band: the figure by which arrangements are compared, 0 (blind) to √3.
    pub fn worst(&self, band: Band) -> f64 {
        band.iter().map(|k| 1.0 / self.noise_gain(usize::from(k))).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    const BAND: Band = Band { first: 2, last: 100 };

    fn degrees(phi2: f64, phi3: f64) -> Gain {
        ProbeAngles::Degrees { phi2, phi3 }.resolve(1024).unwrap()
    }

    /// Worst normalised gains of the arrangements in CN1927535, and of the best found by full search.
    #[test]
    fn known_arrangements() {
        assert_eq!((degrees(90.0, 181.05).worst(BAND) * 1e3).round(), 52.0);
        assert_eq!((degrees(60.82, 240.12).worst(BAND) * 1e3).round(), 53.0);
        for (p, q, points, gain) in [(169, 188, 1024, 319.0), (188, 667, 1024, 319.0), (155, 172, 512, 300.0)] {
            let found = ProbeAngles::Slots { p, q }.resolve(points).unwrap();
            assert_eq!((found.worst(BAND) * 1e3).round(), gain, "{p} {q}");
        }
    }

    #[test]
    fn singular_harmonics_are_all_named() {
        let singular = |phi2, phi3| degrees(phi2, phi3).singular(Band { first: 2, last: 10 }).collect::<Vec<_>>();
        assert_eq!(singular(90.0, 135.0), [7, 9]);
        // Three probes at equal angles see only multiples of three.
        assert_eq!(singular(120.0, 120.0), [2, 4, 5, 7, 8, 10]);
        assert!(degrees(66.093_75, 234.492_187_5).is_singular(1));
        let slots = ProbeAngles::Slots { p: 256, q: 384 }.resolve(1024).unwrap();
        assert_eq!(slots.singular(BAND).take(2).collect::<Vec<_>>(), [7, 9]);
    }

    #[test]
    fn slots_and_degrees_agree() {
        let slots = ProbeAngles::Slots { p: 188, q: 667 }.resolve(1024).unwrap();
        let angles = degrees(66.093_75, 234.492_187_5);
        for k in 2..512 {
            let ([a, b], [c, d]) = (slots.of(k), angles.of(k));
            assert!((a - c).abs() < 1e-11 && (b - d).abs() < 1e-11, "{k}");
        }
    }

    #[test]
    fn bad_angles_are_refused() {
        let slots = |p, q| ProbeAngles::Slots { p, q }.resolve(1024).unwrap_err();
        assert_eq!(slots(0, 3).index, Some(0));
        assert_eq!(slots(3, 1024).found, 1024.0);
        assert_eq!(slots(512, 3).found, 180.0);
        for (phi2, phi3) in
            [(f64::NAN, 1.0), (1.0, 400.0), (180.0, 30.0), (30.0, -180.0), (0.0, 30.0), (90.0, -90.0), (120.0, 240.0)]
        {
            assert!(ProbeAngles::Degrees { phi2, phi3 }.resolve(1024).is_err(), "{phi2} {phi3}");
        }
        assert!(Band { first: 1, last: 9 }.check(64).is_err());
        assert!(Band { first: 9, last: 8 }.check(64).is_err());
        assert!(Band { first: 2, last: 32 }.check(64).is_err());
        assert!(Band { first: 2, last: 31 }.check(64).is_ok());
    }
}
