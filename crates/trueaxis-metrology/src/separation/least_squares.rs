//! Least squares over the readings of all probes: [`Separator::of_places`].

use super::{Separation, Separator, Workspace};
use crate::probe_places::ProbePlaces;
use realfft::num_complex::Complex;
use std::vec::Vec;

/// Sum of squared gains from which the mean radius is seen, as a share of the number of probes.
const SEES_MEAN: f64 = 1e-12;

/// Factors of a plan.
pub(super) struct LeastSquares {
    places: ProbePlaces,
    /// Columns of N: weights of the probes, orthonormal and without motion of the centre; m − 2 of them.
    without_motion: Vec<Vec<f64>>,
    /// By harmonic from 0 to the band's last, and by column of N: factors from an unscaled spectrum of s_l to the profile; a
    /// suppressed harmonic has none. The factors of harmonic 0 give the mean radius.
    factors: Vec<Vec<Complex<f64>>>,
    /// By harmonic: Σ cos φ_i e^{jkφ_i} and Σ sin φ_i e^{jkφ_i}, the profile's share in Cᵀ h.
    in_motion: Vec<[Complex<f64>; 2]>,
}

impl LeastSquares {
    pub(super) fn new(places: &ProbePlaces, points: usize, kept: &[bool]) -> LeastSquares {
        let without_motion = without_motion(places);
        let phases = |k: usize| places.angles().iter().map(move |angle| Complex::cis(k as f64 * angle));
        let factors = (0..).zip(kept).map(|(k, kept)| {
            let (gains, squares) = gains(places, &without_motion, k);
            let mean = k == 0 && squares > SEES_MEAN * places.angles().len() as f64;
            let used = if *kept || mean { gains } else { Vec::new() };
            used.iter().map(|gain| gain.conj() / (squares * points as f64)).collect()
        });
        let in_motion = (0..kept.len()).map(|k| {
            let units = || places.angles().iter().map(|angle| (libm::cos(*angle), libm::sin(*angle)));
            let sum = |weights: &mut dyn Iterator<Item = f64>| phases(k).zip(weights).map(|(e, w)| e * w).sum();
            [sum(&mut units().map(|(cos, _)| cos)), sum(&mut units().map(|(_, sin)| sin))]
        });
        LeastSquares {
            places: places.clone(),
            factors: factors.collect(),
            in_motion: in_motion.collect(),
            without_motion,
        }
    }

    pub(super) fn separate(&self, plan: &Separator, workspace: &mut Workspace, probes: &[&[f64]]) -> Separation {
        workspace.sums.fill(Complex::default());
        for (column, weights) in self.without_motion.iter().enumerate() {
            combine(&mut workspace.real, weights, probes);
            plan.transform(workspace);
            let Workspace { sums, spectrum, .. } = &mut *workspace;
            for ((sum, value), factors) in sums.iter_mut().zip(spectrum).zip(&self.factors) {
                *sum += factors.get(column).map_or(Complex::default(), |factor| *value * factor);
            }
        }
        workspace.spectrum.copy_from_slice(&workspace.sums);
        let mut profile = std::vec![0.0; plan.points];
        let one = Complex::new(1.0, 0.0);
        let without_mean = core::iter::once(Complex::default()).chain(core::iter::repeat(one));
        plan.synthesis(workspace, &mut profile, without_mean);
        let units: [Vec<f64>; 2] =
            [libm::cos, libm::sin].map(|of| self.places.angles().iter().map(|a| of(*a)).collect());
        // Cᵀ (h − r), at first in the places of the motion.
        let mut motion = [0, 1].map(|column| {
            let mut left = std::vec![0.0; plan.points];
            combine(&mut left, &units[column], probes);
            let mut series = core::mem::take(&mut workspace.ahead);
            plan.synthesis(workspace, &mut series, self.in_motion.iter().map(|of| of[column]));
            left.iter_mut().zip(&series).for_each(|(left, seen)| *left -= seen);
            workspace.ahead = series;
            left
        });
        let [cc, cs, ss] = self.places.inverse();
        let [x, y] = &mut motion;
        for ((x, y), [cos, sin]) in x.iter_mut().zip(y).zip(&plan.arm) {
            let (one, across) = (cc * *x + cs * *y, cs * *x + ss * *y);
            (*x, *y) = (cos * across + sin * one, cos * one - sin * across);
        }
        let [x, y] = motion;
        Separation { profile, x, y }
    }
}

/// Gains g_l(k) of the columns of N, and the sum of their squares.
pub(super) fn gains(places: &ProbePlaces, columns: &[Vec<f64>], k: usize) -> (Vec<Complex<f64>>, f64) {
    let phases = || places.angles().iter().map(|angle| Complex::cis(k as f64 * angle));
    let gain = |weights: &Vec<f64>| phases().zip(weights).map(|(phase, weight)| phase * *weight).sum();
    let gains: Vec<Complex<f64>> = columns.iter().map(gain).collect();
    let squares = gains.iter().map(Complex::norm_sqr).sum();
    (gains, squares)
}

/// Weighted sum of the probes' readings.
fn combine(sum: &mut [f64], weights: &[f64], probes: &[&[f64]]) {
    sum.fill(0.0);
    for (weight, probe) in weights.iter().zip(probes) {
        sum.iter_mut().zip(*probe).for_each(|(sum, value)| *sum += weight * value);
    }
}

/// Columns orthogonal to C and to one another: the unit vectors without their parts along the columns before, the longest
/// rest first.
pub(super) fn without_motion(places: &ProbePlaces) -> Vec<Vec<f64>> {
    let angles = places.angles();
    let count = angles.len();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let rest = |basis: &[Vec<f64>], mut of: Vec<f64>| {
        // Twice, so that rounding leaves nothing.
        for column in basis.iter().chain(basis) {
            let along: f64 = column.iter().zip(&of).map(|(a, b)| a * b).sum();
            of.iter_mut().zip(column).for_each(|(value, part)| *value -= along * part);
        }
        of
    };
    let unit = |of: Vec<f64>| {
        let length = libm::sqrt(of.iter().map(|value| value * value).sum());
        of.into_iter().map(|value| value / length).collect::<Vec<f64>>()
    };
    for of in [libm::cos, libm::sin] {
        let column = rest(&basis, angles.iter().map(|angle| of(*angle)).collect());
        basis.push(unit(column));
    }
    while basis.len() < count {
        let rests = (0..count).map(|i| rest(&basis, (0..count).map(|j| f64::from(u8::from(i == j))).collect()));
        let square = |of: &Vec<f64>| of.iter().map(|value| value * value).sum::<f64>();
        let Some(longest) = rests.max_by(|one, other| square(one).total_cmp(&square(other))) else { break };
        basis.push(unit(longest));
    }
    basis.split_off(2)
}
