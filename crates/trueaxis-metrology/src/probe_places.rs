//! Three to six probes around a part: how well they see each harmonic, and a search for the best places.
//!
//! Probe i of m stands at φ_i and reads h_i(θ) = r(θ + φ_i) + R_X sin φ_i + R_Y cos φ_i. Least squares over all readings sees
//! harmonic k of the profile as well as the part of e_i = e^{jkφ_i} that no motion of the centre explains:
//!
//! ```text
//! C = [cos φ_i, sin φ_i]        gain(k)² = eᴴ (I − C (CᵀC)⁻¹ Cᵀ) e        noise gain(k) = 1/gain(k)
//! ```
//!
//! With three probes this is |G(k)|/√(1 + k2² + k3²). Turning the ring of probes, mirroring it and numbering the probes in
//! another order change nothing.

use core::f64::consts::TAU;
use std::vec::Vec;
use trueaxis::error::{ConfigError, Field};
use trueaxis::roundness::Band;

/// Fewest and most probes.
pub const PROBES: core::ops::RangeInclusive<usize> = 3..=6;
/// Figures of merit whose relative difference is below this count as equal.
const TIE: f64 = 1e-12;
/// Gain from which a harmonic counts as invisible: rounding leaves some 1e-8.
const BLIND: f64 = 1e-6;
/// Least determinant of CᵀC: the probes stand on one line through the centre.
const FLAT: f64 = 1e-9;
/// Draws of a start that keeps the limits, before it is given up.
const DRAWS: usize = 1000;

/// Probes at given angles.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbePlaces {
    angles: Vec<f64>,
    /// (CᵀC)⁻¹: the elements cos cos, cos sin, sin sin.
    inverse: [f64; 3],
}

impl ProbePlaces {
    /// Probes at `degrees`, in the sense of θ.
    ///
    /// # Errors
    /// Fewer than three or more than six angles, one that is not finite or outside ±360°, two at one place, or all on one line
    /// through the centre.
    pub fn new(degrees: &[f64]) -> Result<ProbePlaces, ConfigError> {
        let refuse = |found: f64, needed| ConfigError::new(Field::ProbeAngles, found, needed);
        if !PROBES.contains(&degrees.len()) {
            return Err(refuse(degrees.len() as f64, "the angles of three to six probes"));
        }
        for (index, angle) in degrees.iter().enumerate() {
            if !(-360.0..=360.0).contains(angle) {
                return Err(refuse(*angle, "angles from −360 to 360°").at(index));
            }
            let shared = degrees.iter().take(index).any(|other| {
                let apart = libm::fabs(angle - other) % 360.0;
                apart.min(360.0 - apart) < 1e-6
            });
            if shared {
                return Err(refuse(*angle, "a place of its own for every probe").at(index));
            }
        }
        let angles: Vec<f64> = degrees.iter().map(|angle| angle.to_radians()).collect();
        let units = angles.iter().map(|angle| [libm::cos(*angle), libm::sin(*angle)]);
        let inverse = inverse(units).ok_or_else(|| {
            refuse(
                degrees.first().copied().unwrap_or_default(),
                "probes that are not all on one line through the centre",
            )
        })?;
        Ok(ProbePlaces { angles, inverse })
    }

    /// Angles of the probes, rad.
    pub fn angles(&self) -> &[f64] {
        &self.angles
    }

    /// Angles of the probes, degrees.
    pub fn degrees(&self) -> Vec<f64> {
        self.angles.iter().map(|angle| angle.to_degrees()).collect()
    }

    /// (CᵀC)⁻¹: the elements cos cos, cos sin, sin sin.
    #[cfg(feature = "separation")]
    pub(crate) fn inverse(&self) -> [f64; 3] {
        self.inverse
    }

    /// Gain of harmonic `k`, 0 (blind) to the root of the number of probes.
    pub fn gain(&self, k: usize) -> f64 {
        let units = self.angles.iter().map(|angle| {
            let turned = k as f64 * angle;
            ([libm::cos(*angle), libm::sin(*angle)], [libm::cos(turned), libm::sin(turned)])
        });
        // Rounding may leave a value slightly below zero if the probes are blind.
        libm::sqrt(square(self.inverse, units).max(0.0))
    }

    /// Noise of one reading that appears in harmonic `k` of the profile, as a factor; infinite if the probes do not see it.
    pub fn noise_gain(&self, k: usize) -> f64 {
        let gain = self.gain(k);
        if gain < BLIND { f64::INFINITY } else { 1.0 / gain }
    }

    /// The harmonic of the band that is seen worst, and its noise gain.
    pub fn worst(&self, band: Band) -> (u16, f64) {
        let gains = band.iter().map(|k| (k, self.noise_gain(usize::from(k))));
        gains.fold((band.first, 0.0), |worst, next| if next.1 > worst.1 { next } else { worst })
    }

    /// Worst noise gain if any one of the probes is lost; `None` with three probes. Infinite if the others are blind to a
    /// harmonic of the band.
    pub fn worst_without_one(&self, band: Band) -> Option<f64> {
        let degrees = self.degrees();
        let without =
            |lost| degrees.iter().enumerate().filter(move |(i, _)| *i != lost).map(|(_, angle)| *angle).collect();
        let gains = (0..degrees.len()).map(|lost| {
            let rest: Vec<f64> = without(lost);
            ProbePlaces::new(&rest).map_or(f64::INFINITY, |rest| rest.worst(band).1)
        });
        (degrees.len() > *PROBES.start()).then(|| gains.fold(0.0, f64::max))
    }
}

/// Where probes may stand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Smallest angle between two probes, slots; at least 1.
    pub apart: usize,
    /// Width of the sector in which all probes stand, slots; the whole circle if it is the number of points or more.
    pub within: usize,
}

impl Limits {
    /// Largest angle between neighbours for which there is room, slots.
    fn room(self, points: usize, probes: usize) -> usize {
        if self.within == points { points / probes } else { self.within / (probes - 1) }
    }
}

/// Slots of the probes, ascending from 0, and the worst gain of the band.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// Places in slots of 2π/N.
    pub slots: Vec<usize>,
    /// Smallest gain of the band.
    pub worst_gain: f64,
}

/// A search over the slots of three to six probes.
///
/// From each of many starts it moves one probe after the other to the slot at which the worst harmonic is seen best, until no
/// move of a single probe helps. Starts are drawn by their numbers, so the result is the same on any number of cores. Every
/// result is a local best; that none is better is not proved.
#[derive(Clone, Debug)]
pub struct PlaceSearch {
    points: usize,
    band: Band,
    probes: usize,
    limits: Limits,
    /// cos and sin of 2π i/N.
    circle: Vec<[f64; 2]>,
}

impl PlaceSearch {
    /// A search for `probes` probes on `points` slots.
    ///
    /// # Errors
    /// The band does not suit the number of points; fewer than three or more than six probes; limits that leave no room.
    pub fn new(points: usize, band: Band, probes: usize, limits: Limits) -> Result<PlaceSearch, ConfigError> {
        band.check(points)?;
        if !PROBES.contains(&probes) {
            return Err(ConfigError::new(Field::ProbeAngles, probes as f64, "three to six probes"));
        }
        let limits = Limits { apart: limits.apart.max(1), within: limits.within.min(points) };
        if limits.apart > limits.room(points, probes) {
            let found = 360.0 * limits.apart as f64 / points as f64;
            return Err(ConfigError::new(
                Field::ProbeAngles,
                found,
                "an angle between probes for which the sector has room",
            ));
        }
        let turn = |i: usize| TAU * i as f64 / points as f64;
        let circle = (0..points).map(|i| [libm::cos(turn(i)), libm::sin(turn(i))]).collect();
        Ok(PlaceSearch { points, band, probes, limits, circle })
    }

    /// The best places that start number `start` leads to; `None` if no start within the limits was drawn.
    pub fn from_start(&self, start: u64) -> Option<Placed> {
        let mut slots = self.drawn(start)?;
        let mut worst = self.worst(&slots, -1.0);
        loop {
            let before = worst;
            for probe in 1..slots.len() {
                let mut moved = slots.clone();
                for slot in 0..self.points {
                    *moved.get_mut(probe)? = slot;
                    if self.fits(&moved) {
                        let found = self.worst(&moved, worst);
                        if found > worst * (1.0 + TIE) {
                            worst = found;
                            slots.clone_from(&moved);
                        }
                    }
                }
            }
            if worst <= before {
                return Some(Placed { slots: self.canonical(&slots), worst_gain: libm::sqrt(worst.max(0.0)) });
            }
        }
    }

    /// The `count` best results, each once, best first; equal ones by their slots.
    pub fn ranked(&self, found: impl IntoIterator<Item = Placed>, count: usize) -> Vec<Placed> {
        let mut found: Vec<Placed> = found.into_iter().collect();
        found.sort_by(|one, other| {
            other.worst_gain.total_cmp(&one.worst_gain).then_with(|| one.slots.cmp(&other.slots))
        });
        found.dedup_by(|one, other| one.slots == other.slots);
        found.truncate(count);
        found
    }

    /// Random places within the limits, the first at slot 0.
    fn drawn(&self, start: u64) -> Option<Vec<usize>> {
        let mut state = start;
        for _ in 0..DRAWS {
            let mut slots = std::vec![0];
            for _ in 1..self.probes {
                // SplitMix64 (Steele, Lea, Flood 2014).
                state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
                let mut bits = (state ^ (state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
                bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
                slots.push(((bits ^ (bits >> 31)) % self.limits.within.max(1) as u64) as usize);
            }
            if self.fits(&slots) {
                return Some(slots);
            }
        }
        // Evenly spread, which always fits.
        let step = self.limits.room(self.points, self.probes);
        let slots: Vec<usize> = (0..self.probes).map(|i| i * step).collect();
        self.fits(&slots).then_some(slots)
    }

    /// Whether places keep the limits.
    fn fits(&self, slots: &[usize]) -> bool {
        let gaps = self.gaps(slots);
        gaps.iter().all(|gap| *gap >= self.limits.apart)
            && (self.limits.within == self.points || gaps.iter().any(|gap| self.points - gap <= self.limits.within))
    }

    /// Arcs from each probe to the next.
    fn gaps(&self, slots: &[usize]) -> Vec<usize> {
        let mut sorted = slots.to_vec();
        sorted.sort_unstable();
        let first = sorted.first().copied().unwrap_or_default() + self.points;
        sorted.iter().zip(sorted.iter().skip(1).chain([&first])).map(|(from, to)| to - from).collect()
    }

    /// One of all turned and mirrored images: the arcs that come first in order.
    fn canonical(&self, slots: &[usize]) -> Vec<usize> {
        let gaps = self.gaps(slots);
        let mirrored: Vec<usize> = gaps.iter().rev().copied().collect();
        let images = [gaps, mirrored].into_iter().flat_map(|arcs| {
            (0..arcs.len()).map(move |turn| {
                let mut arcs = arcs.clone();
                arcs.rotate_left(turn);
                arcs
            })
        });
        let arcs = images.min().unwrap_or_default();
        let sums = arcs.iter().scan(0, |at, arc| {
            *at += arc;
            Some(*at - arc)
        });
        sums.collect()
    }

    /// Square of the smallest gain of the band; less precise below `reach`.
    fn worst(&self, slots: &[usize], reach: f64) -> f64 {
        let at = |slot: usize| self.circle.get(slot).copied().unwrap_or_default();
        let Some(inverse) = inverse(slots.iter().map(|slot| at(*slot))) else { return 0.0 };
        let mut worst = f64::INFINITY;
        for k in self.band.iter() {
            let units = slots.iter().map(|slot| (at(*slot), at((slot * usize::from(k)) % self.points)));
            worst = worst.min(square(inverse, units));
            if worst <= reach {
                break;
            }
        }
        worst
    }
}

/// (CᵀC)⁻¹ of unit vectors; `None` if all are on one line.
fn inverse(units: impl Iterator<Item = [f64; 2]>) -> Option<[f64; 3]> {
    let [cc, cs, ss] = units.fold([0.0; 3], |[cc, cs, ss], [c, s]| [cc + c * c, cs + c * s, ss + s * s]);
    let determinant = cc * ss - cs * cs;
    (determinant > FLAT).then(|| [ss / determinant, -cs / determinant, cc / determinant])
}

/// eᴴ (I − C (CᵀC)⁻¹ Cᵀ) e, from each probe's unit vector and e^{jkφ}.
fn square([cc, cs, ss]: [f64; 3], units: impl Iterator<Item = ([f64; 2], [f64; 2])>) -> f64 {
    let (mut count, mut along, mut across) = (0.0, [0.0; 2], [0.0; 2]);
    for ([c, s], [re, im]) in units {
        count += 1.0;
        along = [along[0] + c * re, along[1] + c * im];
        across = [across[0] + s * re, across[1] + s * im];
    }
    let dot = |one: [f64; 2], other: [f64; 2]| one[0] * other[0] + one[1] * other[1];
    count - (cc * dot(along, along) + 2.0 * cs * dot(along, across) + ss * dot(across, across))
}

#[cfg(test)]
mod tests {
    use super::*;
    use trueaxis::roundness::ProbeAngles;

    const BAND: Band = Band { first: 2, last: 100 };
    const ANYWHERE: Limits = Limits { apart: 1, within: usize::MAX };

    fn best(points: usize, band: Band, probes: usize, limits: Limits, starts: u64) -> Placed {
        let search = PlaceSearch::new(points, band, probes, limits).unwrap();
        search.ranked((0..starts).filter_map(|start| search.from_start(start)), 1).remove(0)
    }

    /// The closed form of three probes, and N Nᵀ of four by hand: the probes at 0, 90, 180, 270° have two readings without
    /// motion, (h1 + h3)/√2 and (h2 + h4)/√2.
    #[test]
    fn the_gain_is_that_of_readings_without_motion() {
        for (phi2, phi3) in [(90.0, 181.05), (60.82, 240.12), (59.41406, 66.09375)] {
            let gain = ProbeAngles::Degrees { phi2, phi3 }.resolve(1024).unwrap();
            let probes = ProbePlaces::new(&[0.0, phi2, (phi2 + phi3) % 360.0]).unwrap();
            for k in BAND.iter().map(usize::from) {
                assert!((probes.gain(k) * gain.noise_gain(k) - 1.0).abs() < 1e-9, "{phi2} {phi3} {k}");
            }
            assert_eq!(probes.worst_without_one(BAND), None);
        }
        let square = ProbePlaces::new(&[0.0, 90.0, 180.0, 270.0]).unwrap();
        for k in 2..20 {
            let quarter = TAU * k as f64 / 4.0;
            let pair = 1.0 + libm::cos(2.0 * quarter);
            assert!((square.gain(k).powi(2) - 2.0 * pair).abs() < 1e-9, "{k}");
        }
        assert_eq!(square.worst(Band { first: 2, last: 5 }), (3, f64::INFINITY));
    }

    /// Scatter of the amplitudes that least squares finds from noise alone, by normal equations over every θ.
    #[test]
    fn the_noise_gain_is_the_scatter_of_least_squares() {
        const N: usize = 64;
        let degrees = [0.0, 33.75, 140.625, 208.125];
        let probes = ProbePlaces::new(&degrees).unwrap();
        let k = 7;
        // Unknowns a, b of r = a cos kθ + b sin kθ, and R_X, R_Y at every θ. Eliminated θ by θ, what is left of the two columns is
        // their projection; its inverse Gram matrix is the covariance.
        let (mut aa, mut ab, mut bb) = (0.0, 0.0, 0.0);
        let units: Vec<[f64; 2]> = degrees.iter().map(|d: &f64| [d.to_radians().cos(), d.to_radians().sin()]).collect();
        for i in 0..N {
            let theta = TAU * i as f64 / N as f64;
            let columns = [f64::cos as fn(f64) -> f64, f64::sin].map(|of| {
                let column: Vec<f64> = degrees.iter().map(|d| of(k as f64 * (theta + d.to_radians()))).collect();
                // Gram-Schmidt against both columns of the motion.
                let mut basis: Vec<Vec<f64>> = Vec::new();
                for axis in 0..2 {
                    let mut own: Vec<f64> = units.iter().map(|unit| unit[axis]).collect();
                    for known in &basis {
                        let share: f64 = own.iter().zip(known).map(|(a, b)| a * b).sum();
                        own.iter_mut().zip(known).for_each(|(a, b)| *a -= share * b);
                    }
                    let norm = own.iter().map(|a| a * a).sum::<f64>().sqrt();
                    basis.push(own.iter().map(|a| a / norm).collect());
                }
                basis.iter().fold(column, |mut left, known| {
                    let share: f64 = left.iter().zip(known).map(|(a, b)| a * b).sum();
                    left.iter_mut().zip(known).for_each(|(a, b)| *a -= share * b);
                    left
                })
            });
            let dot = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
            aa += dot(&columns[0], &columns[0]);
            ab += dot(&columns[0], &columns[1]);
            bb += dot(&columns[1], &columns[1]);
        }
        let variance = bb / (aa * bb - ab * ab);
        // The amplitude of a harmonic read directly by one probe scatters by √(2/N).
        assert!((probes.noise_gain(k) - (variance * N as f64 / 2.0).sqrt()).abs() < 1e-9);
    }

    /// Every arrangement of a small circle.
    #[test]
    fn no_arrangement_of_a_small_circle_is_better() {
        let band = Band { first: 2, last: 12 };
        let search = PlaceSearch::new(32, band, 4, ANYWHERE).unwrap();
        let mut all = 0.0_f64;
        for a in 1..30 {
            for b in a + 1..31 {
                for c in b + 1..32 {
                    let degrees = [0, a, b, c].map(|slot| 360.0 * f64::from(slot) / 32.0);
                    all = all.max(ProbePlaces::new(&degrees).map_or(0.0, |probes| 1.0 / probes.worst(band).1));
                }
            }
        }
        let found = best(32, band, 4, ANYWHERE, 200);
        assert!((found.worst_gain - all).abs() < 1e-9, "{found:?} {all}");
        assert_eq!(search.canonical(&found.slots), found.slots);
    }

    /// The published bounds of the best three, four and five on 1024 points.
    #[test]
    fn more_probes_see_better() {
        let worst = [3, 4, 5].map(|probes| 1.0 / best(1024, BAND, probes, ANYWHERE, 150).worst_gain);
        assert!(worst[0] < 3.4 && worst[1] < 1.3 && worst[2] < 0.85, "{worst:?}");
    }

    #[test]
    fn limits_are_kept() {
        let limits = Limits { apart: 60, within: 500 };
        let found = best(1024, BAND, 4, limits, 20);
        assert!(found.slots.windows(2).all(|two| two[1] - two[0] >= 60), "{found:?}");
        let search = PlaceSearch::new(1024, BAND, 4, limits).unwrap();
        assert!(search.gaps(&found.slots).iter().any(|gap| 1024 - gap <= 500), "{found:?}");
        // Room for one arrangement only.
        let tight = best(1024, Band { first: 2, last: 3 }, 4, Limits { apart: 100, within: 300 }, 1);
        assert_eq!(tight.slots, [0, 100, 200, 300]);
    }

    #[test]
    fn bad_places_are_refused() {
        let refused = |degrees: &[f64]| ProbePlaces::new(degrees).unwrap_err();
        assert_eq!(refused(&[0.0, 90.0]).found, 2.0);
        assert_eq!(refused(&[0.0; 7]).found, 7.0);
        assert_eq!(refused(&[0.0, 90.0, 450.0]).found, 450.0);
        assert!(refused(&[0.0, 90.0, f64::NAN]).found.is_nan());
        assert_eq!(refused(&[0.0, 90.0, -270.0]).index, Some(2));
        assert_eq!(refused(&[10.0, 370.0 - 360.0, 5.0]).index, Some(1));
        let search = |probes, limits| PlaceSearch::new(128, Band { first: 2, last: 20 }, probes, limits);
        assert!(search(2, ANYWHERE).is_err() && search(7, ANYWHERE).is_err());
        assert!(search(4, Limits { apart: 33, within: 128 }).is_err());
        assert!(search(4, Limits { apart: 10, within: 29 }).is_err());
        assert!(PlaceSearch::new(128, Band { first: 2, last: 64 }, 4, ANYWHERE).is_err());
    }
}
