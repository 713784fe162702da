//! Least-squares sphere of points.
//!
//! min Σ (|p_i − c| − r)², by Gauss-Newton from the algebraic sphere |p|² = 2 c·p + (r² − |c|²), which is exact for the points
//! of a perfect sphere.
//!
//! Source: A. B. Forbes, NPL Report DITC 140/89 (1989), 6.

use crate::linear_fit::LinearFit;
use core::fmt;
use std::vec::Vec;

/// Most Gauss-Newton steps: it converges in two or three if the points scatter by less than a thousandth of the radius.
const ROUNDS: usize = 12;

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sphere {
    /// Centre, in the points' unit.
    pub centre: [f64; 3],
    /// Radius.
    pub radius: f64,
    /// Largest − smallest distance of a point from the centre.
    pub zone: f64,
    /// Standard deviation of a distance.
    pub sigma: f64,
    /// Standard errors of the centre.
    pub centre_errors: [f64; 3],
    /// Standard error of the radius.
    pub radius_error: f64,
}

/// Why points have no sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum NoSphere {
    /// There are fewer than five points.
    TooFew,
    /// The points are coplanar or coincident.
    Flat,
}

impl fmt::Display for NoSphere {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            NoSphere::TooFew => "found fewer than 5 points, needed 5 (25 in ISO 230-10)",
            NoSphere::Flat => "found points in one plane, needed points all over the half of a sphere",
        })
    }
}

impl core::error::Error for NoSphere {}

/// Fits the least-squares sphere.
///
/// # Errors
/// [`NoSphere`].
pub fn least_squares(points: &[[f64; 3]]) -> Result<Sphere, NoSphere> {
    if points.len() < 5 {
        return Err(NoSphere::TooFew);
    }
    let n = points.len() as f64;
    let mean = [0, 1, 2].map(|k| points.iter().map(|p| p[k] / n).sum::<f64>());
    let local: Vec<[f64; 3]> = points.iter().map(|p| [p[0] - mean[0], p[1] - mean[1], p[2] - mean[2]]).collect();
    let mut fit = LinearFit::new(4);
    for p in &local {
        fit.add(&[2.0 * p[0], 2.0 * p[1], 2.0 * p[2], 1.0], p.iter().map(|x| x * x).sum(), 1.0);
    }
    let found = fit.solve();
    if found.rank < 4 || found.condition > 1e6 {
        return Err(NoSphere::Flat);
    }
    let mut centre = [found.values[0], found.values[1], found.values[2]];
    let mut radius = (found.values[3] + centre.iter().map(|x| x * x).sum::<f64>()).max(0.0).sqrt();
    let distance = |p: &[f64; 3], c: &[f64; 3]| (0..3).map(|k| (p[k] - c[k]).powi(2)).sum::<f64>().sqrt();
    let mut last = None;
    for _ in 0..ROUNDS {
        let mut fit = LinearFit::new(4);
        for p in &local {
            let d = distance(p, &centre);
            let out = [0, 1, 2].map(|k| (p[k] - centre[k]) / d.max(f64::MIN_POSITIVE));
            fit.add(&[out[0], out[1], out[2], 1.0], d - radius, 1.0);
        }
        let step = fit.solve();
        if step.rank < 4 {
            return Err(NoSphere::Flat);
        }
        centre = [0, 1, 2].map(|k| centre[k] + step.values[k]);
        radius += step.values[3];
        let moved = step.values.iter().map(|v| v.abs()).fold(0.0, f64::max);
        last = Some(step);
        if moved < 1e-13 * radius {
            break;
        }
    }
    let distances = || local.iter().map(|p| distance(p, &centre));
    let sigma = (distances().map(|d| (d - radius).powi(2)).sum::<f64>() / (n - 4.0)).sqrt();
    let factors = last.map(|step| step.error_factors).unwrap_or_default();
    let factor = |k: usize| sigma * factors.get(k).copied().unwrap_or(0.0);
    Ok(Sphere {
        centre: [0, 1, 2].map(|k| mean[k] + centre[k]),
        radius,
        zone: distances().fold(f64::MIN, f64::max) - distances().fold(f64::MAX, f64::min),
        sigma,
        centre_errors: [0, 1, 2].map(factor),
        radius_error: factor(3),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn half_sphere(centre: [f64; 3], radius: impl Fn(usize) -> f64) -> Vec<[f64; 3]> {
        (0..25)
            .map(|k| {
                let (height, turn) = (k as f64 / 25.0, 2.4 * k as f64);
                let flat = (1.0 - height * height).sqrt();
                let r = radius(k);
                [centre[0] + r * flat * turn.cos(), centre[1] + r * flat * turn.sin(), centre[2] + r * height]
            })
            .collect()
    }

    #[test]
    fn a_perfect_half_sphere_far_away_is_found() {
        let found = least_squares(&half_sphere([800.0, -300.0, 120.0], |_| 12.5)).unwrap();
        for (found, truth) in found.centre.into_iter().zip([800.0, -300.0, 120.0]) {
            assert!((found - truth).abs() < 1e-10);
        }
        assert!((found.radius - 12.5).abs() < 1e-10 && found.zone < 1e-10);
    }

    /// Small radial errors: checks the least-squares condition, a zero gradient.
    #[test]
    fn the_gradient_vanishes() {
        let points = half_sphere([1.0, 2.0, 3.0], |k| 10.0 + 0.002 * (k as f64 * 1.9).sin());
        let found = least_squares(&points).unwrap();
        let mut gradient = [0.0; 4];
        for p in &points {
            let d: [f64; 3] = [0, 1, 2].map(|k| p[k] - found.centre[k]);
            let r = d.iter().map(|x| x * x).sum::<f64>().sqrt();
            for k in 0..3 {
                gradient[k] += (r - found.radius) * d[k] / r;
            }
            gradient[3] += r - found.radius;
        }
        assert!(gradient.iter().all(|g| g.abs() < 1e-12), "{gradient:?}");
    }

    #[test]
    fn points_in_a_plane_have_none() {
        let flat: Vec<[f64; 3]> = (0..12).map(|k| [f64::from(k).cos(), f64::from(k).sin(), 0.0]).collect();
        assert_eq!(least_squares(&flat), Err(NoSphere::Flat));
        assert_eq!(least_squares(&flat[..4]), Err(NoSphere::TooFew));
    }
}
