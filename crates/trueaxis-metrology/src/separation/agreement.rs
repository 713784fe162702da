//! How far the readings of four to six probes disagree.

use super::least_squares::{gains, without_motion};
use super::{Arrangement, Separator};
use crate::linear_fit::LinearFit;
use crate::probe_places::ProbePlaces;
use realfft::num_complex::Complex;
use std::vec::Vec;
use trueaxis::error::ConfigError;

/// A probe is named only if the others agree this many times better without it.
const BETTER: f64 = 2.0;
/// And only if its share of the contradiction is this many standard deviations above that of noise.
const CERTAIN: f64 = 5.0;

/// How far the redundant readings of a record disagree, in the unit of the readings.
///
/// Over the harmonics k of the profile, t = Nᵀ F{h} − g gᴴ Nᵀ F{h}/|g|² contains neither profile nor motion of the centre,
/// only noise and what the probes do wrong; m − 3 values of each harmonic are independent.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Agreement {
    /// Contradiction in each probe's readings, root mean square.
    pub residual: Vec<f64>,
    /// Standard deviation of a reading's noise that would explain the contradiction.
    pub noise: f64,
    /// That deviation without each probe in turn; `None` if fewer than four remain, or if those lie on one line.
    pub noise_without: Vec<Option<f64>>,
    /// The probe, from 0, without which the others agree at least twice as well, if chance does not explain it.
    pub disagreeing: Option<usize>,
    /// Errors of the probes' mounting that explain the contradiction best, without probe 1, whose angle and sensitivity are
    /// the reference.
    pub mounting: Vec<Mounting>,
}

/// Errors of a probe's mounting with standard errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    /// Its true angle less the stated one, against probe 1, rad.
    pub angle: [f64; 2],
    /// Its sensitivity relative to that of probe 1, less 1.
    pub sensitivity: [f64; 2],
}

/// Spectra of all probes in one revolution.
type Spectra = Vec<Vec<Complex<f64>>>;

impl Separator {
    /// Compares the readings of four to six probes with one another: whole revolutions of N readings of each. Costs m transforms
    /// a revolution, and a fit of 2 m − 2 unknowns. `None` with three probes, whose readings any profile and motion
    /// explain, and for readings of another number of probes.
    ///
    /// # Errors
    /// A probe with fewer readings than the first one.
    pub fn agreement(&self, probes: &[&[f64]]) -> Result<Option<Agreement>, ConfigError> {
        let Arrangement::Places(places) = &self.arrangement else { return Ok(None) };
        if places.angles().len() < 4 || probes.len() != places.angles().len() {
            return Ok(None);
        }
        let revolutions = probes.first().map_or(0, |probe| probe.len() / self.points);
        let spectra: Vec<Spectra> = (0..revolutions)
            .map(|turn| {
                let from = turn * self.points;
                let of = |probe: &&[f64]| self.spectrum(probe.get(from..from + self.points).unwrap_or_default());
                probes.iter().map(|probe| Ok(of(probe)?.spectrum)).collect::<Result<_, ConfigError>>()
            })
            .collect::<Result<_, ConfigError>>()?;
        Ok(self.compared(places, &spectra))
    }

    fn compared(&self, places: &ProbePlaces, spectra: &[Spectra]) -> Option<Agreement> {
        let harmonics: Vec<usize> = self.band.iter().filter(|k| self.keeps(*k)).map(usize::from).collect();
        let pairs = (harmonics.len() * spectra.len()) as f64;
        if pairs == 0.0 {
            return None;
        }
        let count = places.angles().len();
        let all: Vec<usize> = (0..count).collect();
        let whole = Contradiction::of(places, &all, &harmonics, spectra);
        // The variance of an unscaled spectrum is N σ².
        let noise =
            |squares: f64, independent: usize| libm::sqrt(squares / (pairs * independent as f64 * self.points as f64));
        let degrees = places.degrees();
        let squares_without: Vec<Option<f64>> = (0..count)
            .map(|left_out| {
                let kept: Vec<usize> = all.iter().copied().filter(|probe| *probe != left_out).collect();
                let angles: Vec<f64> = kept.iter().filter_map(|probe| degrees.get(*probe).copied()).collect();
                let rest = ProbePlaces::new(&angles).ok().filter(|rest| rest.angles().len() >= 4)?;
                Some(Contradiction::of(&rest, &kept, &harmonics, spectra).squares)
            })
            .collect();
        let disagreeing = named(&squares_without, whole.squares, pairs, count);
        let scale = libm::sqrt(2.0) / self.points as f64;
        let mounting = self.mounting(places, &harmonics, spectra, pairs);
        Some(Agreement {
            residual: whole.by_probe.iter().map(|sum| scale * libm::sqrt(sum / spectra.len() as f64)).collect(),
            noise: noise(whole.squares, count - 3),
            noise_without: squares_without.iter().map(|squares| squares.map(|sum| noise(sum, count - 4))).collect(),
            disagreeing,
            mounting,
        })
    }

    /// Angle and sensitivity of each probe but the first from the contradiction, which is linear in small errors:
    /// ∂h_i/∂φ_i = j k r e^{jkφ_i} − sin φ_i one + cos φ_i across, and ∂h_i/∂s_i = h_i, without profile and motion. Both are
    /// taken from the fit: the readings' own noise, which is also in the contradiction, would bias the sensitivities.
    fn mounting(&self, places: &ProbePlaces, harmonics: &[usize], spectra: &[Spectra], pairs: f64) -> Vec<Mounting> {
        let (count, columns) = (places.angles().len(), without_motion(places));
        let unknowns = 2 * (count - 1);
        let mut fit = LinearFit::new(unknowns);
        for k in harmonics {
            let seen = Seen::of(places, &columns, *k);
            for readings in spectra.iter().map(|spectra| at(spectra, *k)) {
                let found = seen.solve(&readings);
                let along = motion(places, &readings, *k, found.profile);
                let derivatives: Vec<Vec<Complex<f64>>> = (1..count)
                    .flat_map(|probe| {
                        let angle = places.angles().get(probe).copied().unwrap_or_default();
                        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
                        let profile = found.profile * Complex::cis(*k as f64 * angle);
                        let turned = Complex::new(0.0, *k as f64) * profile + along[1] * cos - along[0] * sin;
                        let scaled = profile + along[0] * cos + along[1] * sin;
                        [turned, scaled].map(|value| seen.left(seen.of_probe(probe, value)).0)
                    })
                    .collect();
                for (row, left) in found.left.iter().enumerate() {
                    let of = |part: fn(&Complex<f64>) -> f64| {
                        derivatives.iter().filter_map(|of| of.get(row)).map(part).collect::<Vec<f64>>()
                    };
                    fit.add(&of(|value| value.re), left.re, 1.0);
                    fit.add(&of(|value| value.im), left.im, 1.0);
                }
            }
        }
        let solution = fit.solve();
        // One of the m − 2 rows of a harmonic depends on the others, since the profile is taken out.
        let freedom = (2.0 * pairs * (count - 3) as f64 - solution.rank as f64).max(1.0);
        let sigma = libm::sqrt(solution.squares / freedom);
        let of = |unknown: usize| {
            let value = solution.values.get(unknown).copied().unwrap_or(f64::NAN);
            let is_seen = !solution.unseen.contains(&unknown);
            let error = solution.error_factors.get(unknown).filter(|_| is_seen).map_or(f64::INFINITY, |of| of * sigma);
            [value, error]
        };
        (0..count - 1).map(|probe| Mounting { angle: of(2 * probe), sensitivity: of(2 * probe + 1) }).collect()
    }
}

/// The probe without which the contradiction is least, if that is certain; the sums of squares are those of `pairs` harmonics.
fn named(without: &[Option<f64>], all: f64, pairs: f64, probes: usize) -> Option<usize> {
    let rests = without.iter().enumerate().filter_map(|(probe, squares)| Some((probe, (*squares)?)));
    let (probe, rest) = rests.min_by(|one, other| one.1.total_cmp(&other.1))?;
    let (own_freedom, rest_freedom) = (2.0 * pairs, 2.0 * pairs * (probes - 4) as f64);
    let variance = rest / rest_freedom;
    let chance = 1.0 + CERTAIN * libm::sqrt(2.0 / own_freedom + 2.0 / rest_freedom);
    let whole = all / (own_freedom + rest_freedom);
    ((all - rest) / own_freedom > chance * variance && whole > BETTER * BETTER * variance).then_some(probe)
}

/// Sums over harmonics and revolutions.
struct Contradiction {
    squares: f64,
    by_probe: Vec<f64>,
}

impl Contradiction {
    /// Compares the probes `kept`, which stand at `places`.
    fn of(places: &ProbePlaces, kept: &[usize], harmonics: &[usize], spectra: &[Spectra]) -> Contradiction {
        let columns = without_motion(places);
        let mut by_probe = std::vec![0.0; kept.len()];
        for k in harmonics {
            let seen = Seen::of(places, &columns, *k);
            for spectra in spectra {
                let readings = at(spectra, *k);
                let readings: Vec<_> = kept.iter().filter_map(|probe| readings.get(*probe).copied()).collect();
                let left = seen.solve(&readings).left;
                for (probe, sum) in by_probe.iter_mut().enumerate() {
                    let weights = columns.iter().map(|weights| weights.get(probe).copied().unwrap_or_default());
                    let residual: Complex<f64> = left.iter().zip(weights).map(|(left, weight)| left * weight).sum();
                    *sum += residual.norm_sqr();
                }
            }
        }
        Contradiction { squares: by_probe.iter().sum(), by_probe }
    }
}

/// How the columns of N see one harmonic.
struct Seen<'c> {
    columns: &'c [Vec<f64>],
    gains: Vec<Complex<f64>>,
    squares: f64,
}

struct Solved {
    profile: Complex<f64>,
    left: Vec<Complex<f64>>,
}

impl<'c> Seen<'c> {
    fn of(places: &ProbePlaces, columns: &'c [Vec<f64>], k: usize) -> Seen<'c> {
        let (gains, squares) = gains(places, columns, k);
        Seen { columns, gains, squares }
    }

    fn solve(&self, readings: &[Complex<f64>]) -> Solved {
        let combined = self.columns.iter().map(|weights| readings.iter().zip(weights).map(|(h, w)| h * *w).sum());
        let (left, profile) = self.left(combined.collect());
        Solved { profile, left }
    }

    /// Nᵀ of a change in the readings of one probe.
    fn of_probe(&self, probe: usize, value: Complex<f64>) -> Vec<Complex<f64>> {
        self.columns.iter().map(|weights| value * weights.get(probe).copied().unwrap_or_default()).collect()
    }

    /// Takes the part along the gains out of a vector; returns the rest and the factor of that part.
    fn left(&self, mut of: Vec<Complex<f64>>) -> (Vec<Complex<f64>>, Complex<f64>) {
        let along: Complex<f64> = self.gains.iter().zip(&of).map(|(gain, value)| gain.conj() * value).sum();
        let factor = if self.squares > 0.0 { along / self.squares } else { Complex::default() };
        of.iter_mut().zip(&self.gains).for_each(|(value, gain)| *value -= gain * factor);
        (of, factor)
    }
}

/// Harmonic `k` of every probe.
fn at(spectra: &Spectra, k: usize) -> Vec<Complex<f64>> {
    spectra.iter().map(|spectrum| spectrum.get(k).copied().unwrap_or_default()).collect()
}

/// Motion along and across the direction of probe 1, by least squares of the readings without the profile.
fn motion(places: &ProbePlaces, readings: &[Complex<f64>], k: usize, profile: Complex<f64>) -> [Complex<f64>; 2] {
    let mut sums = [Complex::default(); 2];
    for (angle, reading) in places.angles().iter().zip(readings) {
        let left = reading - profile * Complex::cis(k as f64 * angle);
        sums[0] += left * libm::cos(*angle);
        sums[1] += left * libm::sin(*angle);
    }
    let [cc, cs, ss] = places.inverse();
    [sums[0] * cc + sums[1] * cs, sums[0] * cs + sums[1] * ss]
}
