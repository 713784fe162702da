//! Error motion of a spindle over recorded revolutions (ISO 230-7:2015), one direction.
//!
//! ```text
//! m(θ)          mean over the revolutions
//! position      mean of m; eccentricity: first harmonic of m; both removed from everything below
//! synchronous   max m − min m
//! asynchronous  max over θ of (max − min over the revolutions at θ)
//! total         max − min over all points
//! ```

use core::f64::consts::TAU;
use std::vec::Vec;
use trueaxis::error::{ConfigError, Field};

/// Error motion in one direction, in the unit of the readings.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorMotion {
    /// Mean over all points: the position of the axis.
    pub position: f64,
    /// Amplitude of the once-per-revolution part: eccentricity of the part and fundamental of the axis, which are inseparable.
    pub once_per_revolution: f64,
    /// Phase of the once-per-revolution part in rad, −π to π: `amplitude · cos(θ + phase)`.
    pub once_per_revolution_phase: f64,
    /// Synchronous error motion value.
    pub synchronous: f64,
    /// Asynchronous error motion value; `None` for a single revolution.
    pub asynchronous: Option<f64>,
    /// Total error motion value.
    pub total: f64,
    /// Mean contour without position and once-per-revolution part, N values.
    pub mean_contour: Vec<f64>,
    /// All revolutions minus position and once-per-revolution part of the mean contour, N values each, in sequence.
    pub revolutions: Vec<f64>,
    /// Largest distance of each revolution from the mean contour.
    pub departure: Vec<f64>,
}

/// Evaluates whole revolutions of `points` values each, in sequence.
///
/// # Errors
/// There are fewer than four points per revolution, no revolution, or an incomplete one.
pub fn error_motion(values: &[f64], points: usize) -> Result<ErrorMotion, ConfigError> {
    if points < 4 {
        return Err(ConfigError::new(Field::Points, points as f64, "at least 4 points a revolution"));
    }
    if values.is_empty() || !values.len().is_multiple_of(points) {
        return Err(ConfigError::new(Field::Points, values.len() as f64, "whole revolutions of N values"));
    }
    let count = values.len() / points;
    let mut mean = std::vec![0.0; points];
    for revolution in values.chunks(points) {
        mean.iter_mut().zip(revolution).for_each(|(sum, value)| *sum += value);
    }
    mean.iter_mut().for_each(|sum| *sum /= count as f64);
    let position = mean.iter().sum::<f64>() / points as f64;
    let turns: Vec<[f64; 2]> = (0..points)
        .map(|i| {
            let theta = TAU * i as f64 / points as f64;
            [libm::cos(theta), libm::sin(theta)]
        })
        .collect();
    // Subtracts the position first: the sums of a large mean times cosine would cancel only to rounding.
    let [mut cos, mut sin] = [0.0; 2];
    for (m, [c, s]) in mean.iter().zip(&turns) {
        cos += 2.0 * (m - position) * c / points as f64;
        sin += 2.0 * (m - position) * s / points as f64;
    }
    let setting: Vec<f64> = turns.iter().map(|[c, s]| position + cos * c + sin * s).collect();
    let mean_contour: Vec<f64> = mean.iter().zip(&setting).map(|(m, setting)| m - setting).collect();
    let revolutions: Vec<f64> = values.iter().zip(setting.iter().cycle()).map(|(v, setting)| v - setting).collect();
    let departure = revolutions
        .chunks(points)
        .map(|revolution| revolution.iter().zip(&mean_contour).map(|(v, m)| (v - m).abs()).fold(0.0, f64::max))
        .collect();
    let mut between = std::vec![[f64::INFINITY, f64::NEG_INFINITY]; points];
    for revolution in values.chunks(points) {
        for ([least, most], value) in between.iter_mut().zip(revolution) {
            (*least, *most) = (least.min(*value), most.max(*value));
        }
    }
    let asynchronous = (count > 1).then(|| between.iter().map(|[least, most]| most - least).fold(0.0, f64::max));
    Ok(ErrorMotion {
        position,
        once_per_revolution: libm::hypot(cos, sin),
        once_per_revolution_phase: libm::atan2(-sin, cos),
        synchronous: range(mean_contour.iter().copied()),
        asynchronous,
        total: range(revolutions.iter().copied()),
        mean_contour,
        revolutions,
        departure,
    })
}

fn range(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().fold(f64::NEG_INFINITY, f64::max) - values.fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Position 7, eccentricity 50 at −30°, third harmonic 2, and ±0.75 at one angle in alternating revolutions.
    #[test]
    fn components_are_separated() {
        let points = 96;
        let motion = |revolution: usize, i: usize| {
            let theta = TAU * i as f64 / points as f64;
            let jump = if i == 8 { [0.75, -0.75][revolution % 2] } else { 0.0 };
            7.0 + 50.0 * (theta - TAU / 12.0).cos() + 2.0 * (3.0 * theta).cos() + jump
        };
        let values: Vec<f64> = (0..4 * points).map(|row| motion(row / points, row % points)).collect();
        let found = error_motion(&values, points).unwrap();
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        close(found.position, 7.0);
        close(found.once_per_revolution, 50.0);
        close(found.once_per_revolution_phase, -TAU / 12.0);
        close(found.synchronous, 4.0);
        close(found.asynchronous.unwrap(), 1.5);
        // At i = 8 the third harmonic is 0, so the jump is between its crests and troughs.
        close(found.total, 4.0);
        assert!(found.departure.iter().all(|d| (d - 0.75).abs() < 1e-12) && found.departure.len() == 4);
        close(found.mean_contour[16], -2.0);
        close(found.revolutions[points + 8], -0.75);
    }

    #[test]
    fn one_revolution_has_no_asynchronous_part() {
        let values: Vec<f64> = (0..64).map(|i| (TAU * f64::from(i) / 16.0).sin()).collect();
        let found = error_motion(&values, 64).unwrap();
        assert_eq!(found.asynchronous, None);
        assert!((found.synchronous - 2.0).abs() < 1e-12 && (found.total - 2.0).abs() < 1e-12);
        assert!(
            error_motion(&values, 60).is_err() && error_motion(&[], 64).is_err() && error_motion(&values, 2).is_err()
        );
    }
}
