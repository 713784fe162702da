//! Power of readings over frequency, at uneven positions.

use nalgebra::Complex;
use std::f64::consts::TAU;
use std::vec::Vec;

/// Products of readings and frequencies at most: a second of a desktop.
const MOST: usize = 200_000_000;
/// Frequencies on each side, 1/L apart from 1.5/L on, that give the power near a harmonic.
const NEAR: usize = 8;

/// Amplitudes over frequency.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spectrum {
    /// Frequencies, ascending, periods in a unit of the position.
    pub frequency: Vec<f64>,
    /// Amplitude at each, in the unit of the values.
    pub amplitude: Vec<f64>,
}

/// Returns the amplitudes of waves in `values` at `positions`, from two waves over the length up to half a wave between points
/// `spacing` apart; frequencies are half a wave over the length apart.
///
/// Cost: four multiplications for each value and frequency, of which there are at most 2e8 together.
pub fn spectrum(positions: &[f64], values: &[f64], length: f64, spacing: f64) -> Spectrum {
    let step = 0.5 / length;
    let count = ((0.5 / spacing / step) as usize).min(MOST / positions.len().max(1)).saturating_sub(3);
    let turn = |frequency: f64| positions.iter().map(move |q| Complex::from_polar(1.0, TAU * frequency * q));
    let rotation: Vec<Complex<f64>> = turn(step).collect();
    let mut phasor: Vec<Complex<f64>> = turn(4.0 * step).zip(values).map(|(phasor, value)| phasor * *value).collect();
    let mut found = Spectrum::default();
    for k in 0..count {
        let sum: Complex<f64> = phasor.iter().sum();
        found.frequency.push((k + 4) as f64 * step);
        found.amplitude.push(2.0 * sum.norm() / positions.len() as f64);
        phasor.iter_mut().zip(&rotation).for_each(|(own, turn)| *own *= turn);
    }
    found
}

/// Mean power near a frequency of `values`, each multiplied by its `share`, relative to that of the shares: for white noise its
/// variance. The frequencies of `fitted`, at which a residual has none, are left out. `None` if too few remain.
pub(super) fn near(parts: &[Part], frequency: f64, length: f64, fitted: &[f64]) -> Option<f64> {
    let all: f64 = parts.iter().map(|part| part.share * part.share).sum();
    let turn = |frequency: f64| parts.iter().map(move |part| Complex::from_polar(1.0, TAU * frequency * part.position));
    let from = frequency - (NEAR as f64 + 0.5) / length;
    let rotation: Vec<Complex<f64>> = turn(1.0 / length).collect();
    let mut phasor: Vec<Complex<f64>> =
        turn(from).zip(parts).map(|(phasor, part)| phasor * (part.share * part.value)).collect();
    let mut powers = Vec::new();
    for k in 0..2 * NEAR + 2 {
        let at = from + k as f64 / length;
        if at > 1.5 / length && fitted.iter().all(|own| (own - at).abs() * length > 1.0) {
            powers.push(phasor.iter().sum::<Complex<f64>>().norm_sqr() / all);
        }
        phasor.iter_mut().zip(&rotation).for_each(|(own, turn)| *own *= turn);
    }
    (powers.len() >= NEAR / 2).then(|| powers.iter().sum::<f64>() / powers.len() as f64)
}

/// A residual at a position, and the share of a harmonic in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub(super) position: f64,
    pub(super) share: f64,
    pub(super) value: f64,
}
