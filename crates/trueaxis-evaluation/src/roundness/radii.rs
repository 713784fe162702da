//! A section as radii over the angle, with or without a filter.

use super::resampled;
use crate::circle::Evaluation;
use anyhow::{Result, anyhow};
use std::path::Path;
use trueaxis::roundness::filter;
use trueaxis_metrology::separation::filtered;

/// Radii of a section over the angle.
#[derive(Clone, Debug, PartialEq)]
pub struct Radii {
    /// Angles, degrees.
    pub theta_deg: Vec<f64>,
    /// Radii, filtered if a filter was requested, mm.
    pub radius_mm: Vec<f64>,
    /// Doubts about the trace.
    pub notes: Vec<String>,
}

impl Radii {
    /// A trace from radii in mm at these angles in degrees, or at equidistant angles over one revolution; `upr` is the cut-off
    /// of a Gaussian filter (ISO 16610-21) in undulations per revolution. With a filter, radii at given angles are first
    /// resampled to as many equidistant ones for a revolution as there are.
    ///
    /// # Errors
    /// A radius that is not above 0, a cut-off that ISO 12181-2 does not list; with a filter, angles that do not increase or do
    /// not go all round.
    pub fn of(radius_mm: &[f64], theta_deg: Option<&[f64]>, upr: Option<u16>) -> Result<Radii> {
        if let Some((index, radius)) = radius_mm.iter().enumerate().find(|(_, radius)| **radius <= 0.0) {
            return Err(anyhow!("radius_mm[{index}]: found {radius}, needed a radius above 0"));
        }
        let count = radius_mm.len();
        let even = || (0..count).map(|i| 360.0 * i as f64 / count as f64).collect();
        let Some(upr) = upr else {
            let theta_deg = theta_deg.map_or_else(even, <[f64]>::to_vec);
            return Ok(Radii { theta_deg, radius_mm: radius_mm.to_vec(), notes: Vec::new() });
        };
        let refused =
            |error: trueaxis::error::ConfigError| anyhow!("upr: found {}, needed {}", error.found, error.needed);
        filter::check(upr).map_err(refused)?;
        let radii = match theta_deg {
            Some(angles) => resampled(radius_mm, angles, count, upr)?,
            None => radius_mm.to_vec(),
        };
        let radius_mm = filtered(&radii, upr)
            .map_err(|error| anyhow!("radius_mm: found {count} radii, needed {}", error.needed))?;
        let few = (!filter::has_enough_points(count, upr)).then(|| {
            format!("{count} points a revolution, fewer than seven for each of {upr} undulations (ISO 12181-2)")
        });
        Ok(Radii { theta_deg: even(), radius_mm, notes: few.into_iter().collect() })
    }

    /// Fits the circles; `file` is only named in errors.
    ///
    /// # Errors
    /// As [`Evaluation::of`].
    pub fn evaluate(&self, file: &Path) -> Result<Evaluation> {
        let point = |(theta, radius): (&f64, &f64)| {
            let (sin, cos) = theta.to_radians().sin_cos();
            [radius * cos, radius * sin]
        };
        let points: Vec<[f64; 2]> = self.theta_deg.iter().zip(&self.radius_mm).map(point).collect();
        let lines = (0..points.len() as u32).collect();
        Evaluation::of(points, lines, file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const COUNT: usize = 1440;

    /// Three lobes of 2 µm and fifty waves of 1 µm on a radius of 25 mm, at these angles.
    fn radii(theta_deg: &[f64]) -> Vec<f64> {
        let radius = |theta: &f64| {
            let turn = theta / 360.0 * TAU;
            25.0 + 1e-3 * (2.0 * (3.0 * turn).cos() + (50.0 * turn).cos())
        };
        theta_deg.iter().map(radius).collect()
    }

    fn zone_um(trace: &Radii) -> f64 {
        let document = trace.evaluate(Path::new("trace")).unwrap().document();
        document.lsc.unwrap().zone_um
    }

    /// Half of the waves at the cut-off is left, and the lobes but for 2^−(3/50)²: 2·2·H(3) + 2·0.5 µm, within what the grid of
    /// angles leaves of the extremes.
    #[test]
    fn the_filter_takes_half_of_the_waves_at_its_cut_off() {
        let even: Vec<f64> = (0..COUNT).map(|i| 360.0 * i as f64 / COUNT as f64).collect();
        let lobes = 4.0 * 2.0_f64.powf(-(3.0_f64 / 50.0).powi(2));
        let found = Radii::of(&radii(&even), None, Some(50)).unwrap();
        assert!((zone_um(&found) - lobes - 1.0).abs() < 0.03, "{}", zone_um(&found));
        assert!((zone_um(&Radii::of(&radii(&even), None, None).unwrap()) - 6.0).abs() < 0.06);
        // Uneven angles give the same, by resampling.
        let uneven: Vec<f64> = even.iter().map(|theta| theta + 3.0 * (theta / 360.0 * TAU).sin() + 0.07).collect();
        let again = Radii::of(&radii(&uneven), Some(&uneven), Some(50)).unwrap();
        assert!((zone_um(&again) - zone_um(&found)).abs() < 2e-3, "{} {}", zone_um(&again), zone_um(&found));
    }

    #[test]
    fn what_cannot_be_filtered_is_refused() {
        let refused = |radii: &[f64], theta: Option<&[f64]>, upr| Radii::of(radii, theta, upr).unwrap_err().to_string();
        assert_eq!(refused(&[25.0, 0.0], None, None), "radius_mm[1]: found 0, needed a radius above 0");
        assert!(refused(&[25.0; 9], None, Some(40)).starts_with("upr: found 40, needed a cut-off of 15, 50"));
        assert!(refused(&[25.0; 9], Some(&[0.0; 9]), Some(15)).starts_with("theta_deg[1]: found 0, needed"));
        assert!(!Radii::of(&[25.0; 90], None, Some(15)).unwrap().notes.is_empty());
    }
}
