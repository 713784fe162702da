//! Distances and angles between poses.

/// Distance between two points.
pub(super) fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.into_iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// Angle between two unit vectors, rad, from the distance of their ends.
pub(super) fn angle(apart: f64) -> f64 {
    2.0 * (0.5 * apart).min(1.0).asin()
}
