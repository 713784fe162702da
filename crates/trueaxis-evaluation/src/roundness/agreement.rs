//! Detects probes that contradict one another because the polarity, sensitivity or angle of one is not as stated.
//!
//! Four to six probes are compared over all harmonics by [`Agreement`].
//!
//! With three, for any motion of the spindle, s = h1 + k2 h2 + k3 h3 contains only the profile: it has no first harmonic, and
//! repeats in every revolution. The check compares departures from both with the noise σ of the probes, estimated from their second
//! differences (variance 6 σ²).

use trueaxis_metrology::separation::{Agreement, Arrangement, Separation};
use trueaxis_report::number::significant;

/// Share of the once-per-revolution signal that s may still contain: the effect of 1 % in a probe's sensitivity or 0.6° in its
/// angle.
const LEFT: f64 = 0.01;
/// If reversing one probe leaves no more than this share, that probe is the cause.
const REVERSED: f64 = 0.05;
/// Deviations within this many standard deviations of noise are ignored.
const NOISE: f64 = 5.0;
/// Share of the profile by which revolutions may differ.
const SPREAD: f64 = 0.05;

/// Contradiction of four to six probes, as a multiple of what their noise explains, from which it is reported.
const REDUNDANT: f64 = 2.0;

/// Contradictions in the readings of whole revolutions, a sentence each; `kept` are the harmonics of the profile.
pub(super) fn contradictions(
    arrangement: &Arrangement,
    points: usize,
    probes: &[Vec<f64>],
    separations: &[Separation],
    kept: impl Iterator<Item = u16>,
) -> Vec<String> {
    let mut found = Vec::new();
    let noise = match (arrangement, probes) {
        (Arrangement::Three(gain), [h1, h2, h3]) => {
            let (weights, probes) = ([1.0, gain.k2(), gain.k3()], [h1, h2, h3]);
            let parts = weights.iter().zip(probes).map(|(weight, probe)| weight * weight * variance(probe));
            let noise = parts.sum::<f64>().sqrt();
            found.extend(once_per_revolution(weights, probes, points, noise));
            noise / gain.norm()
        }
        _ => noise(probes),
    };
    let gains: f64 = kept.map(|k| arrangement.noise_gain(usize::from(k)).powi(2)).sum();
    found.extend(between_revolutions(separations, noise * (2.0 * gains / points as f64).sqrt()));
    found
}

/// Noise of a reading, the mean of the probes: root mean square.
pub(super) fn noise(probes: &[Vec<f64>]) -> f64 {
    (probes.iter().map(|probe| variance(probe)).sum::<f64>() / probes.len().max(1) as f64).sqrt()
}

/// Reports four to six probes that disagree by more than their noise.
pub(super) fn disagreement(agreement: &Agreement, noise: f64) -> Option<String> {
    let found = significant(agreement.noise, 2);
    if let Some(probe) = agreement.disagreeing {
        let rest = agreement.noise_without.get(probe).copied().flatten().unwrap_or_default();
        return Some(format!(
            "probe {} disagrees with the others: the contradiction is that of {found} µm of noise with it and of {} µm without it",
            probe + 1,
            significant(rest, 2)
        ));
    }
    (agreement.noise > REDUNDANT * noise).then(|| {
        let which = if agreement.residual.len() == 4 { "; four probes do not tell which" } else { "" };
        format!(
            "the probes contradict one another like {found} µm of noise, where theirs is {} µm: the angle, the sensitivity or the \
             readings of one or several are not as stated{which}",
            significant(noise, 2)
        )
    })
}

/// Variance of white noise in a smooth signal.
fn variance(readings: &[f64]) -> f64 {
    let squares = readings.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).powi(2));
    squares.sum::<f64>() / (6.0 * readings.len().saturating_sub(2).max(1) as f64)
}

fn once_per_revolution(weights: [f64; 3], probes: [&Vec<f64>; 3], points: usize, noise: f64) -> Option<String> {
    let rows = probes[0].len();
    let per_row = std::f64::consts::TAU / points as f64;
    let turn: Vec<(f64, f64)> = (0..points).map(|row| (per_row * row as f64).sin_cos()).collect();
    // k_i H_i(1), real and imaginary part.
    let parts: [[f64; 2]; 3] = std::array::from_fn(|probe| {
        let readings = probes[probe].chunks(points).flat_map(|revolution| revolution.iter().zip(&turn));
        let sums = readings.fold([0.0; 2], |[re, im], (value, (sin, cos))| [re + value * cos, im - value * sin]);
        sums.map(|sum| 2.0 * weights[probe] * sum / rows as f64)
    });
    let left = |reversed: Option<usize>| {
        let sign = |probe| if reversed == Some(probe) { -1.0 } else { 1.0 };
        let sum = |k: usize| (0..3).map(|probe| sign(probe) * parts[probe][k]).sum::<f64>();
        sum(0).hypot(sum(1))
    };
    let signal = parts.as_flattened().iter().map(|part| part * part).sum::<f64>().sqrt();
    if left(None) <= (LEFT * signal).max(NOISE * 2.0 * noise / (rows as f64).sqrt()) {
        return None;
    }
    let reversed = (0..3).find(|probe| left(Some(*probe)) < REVERSED * signal);
    let cause = match reversed {
        Some(probe) => format!("probe {} has the other polarity", probe + 1),
        None => "the polarity, the sensitivity or the angle of a probe is not the stated one".to_owned(),
    };
    Some(format!(
        "{} % of the once-per-revolution signal remains where the three probes must cancel it: {cause}",
        significant(100.0 * left(None) / signal, 2)
    ))
}

fn between_revolutions(separations: &[Separation], expected: f64) -> Option<String> {
    let profiles = || separations.iter().map(|parts| parts.profile.as_slice());
    let (count, points) = (separations.len(), profiles().next()?.len());
    if count < 2 {
        return None;
    }
    let mean = super::document::mean(profiles(), points, count);
    let squares: f64 = mean.iter().map(|mean| mean * mean).sum();
    let from_mean =
        |profile: &[f64]| profile.iter().zip(&mean).map(|(value, mean)| (value - mean).powi(2)).sum::<f64>();
    let apart: f64 = profiles().map(from_mean).sum();
    let profile = (squares / points as f64).sqrt();
    let spread = (apart / (points * (count - 1)) as f64).sqrt();
    (spread > (NOISE * expected).max(SPREAD * profile)).then(|| {
        format!(
            "the profile differs from revolution to revolution by {} µm RMS, of which the probes' noise explains {} µm: a probe of \
             wrong polarity or sensitivity lets motion of the spindle into it, or a probe or the part has moved",
            significant(spread, 2),
            significant(expected, 2)
        )
    })
}
