//! Intervals from random draws.

use serde::Serialize;
use std::vec::Vec;

/// An interval, ends included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Low end.
    pub low: f64,
    /// High end.
    pub high: f64,
}

impl Interval {
    /// Whether a value lies in the interval.
    pub fn contains(&self, value: f64) -> bool {
        value >= self.low && value <= self.high
    }
}

/// Returns the value below which a share `p` of the sorted values lies; NaN without values.
///
/// Interpolates linearly between two values (JCGM 101:2008, 7.7 uses the nearer one).
pub fn quantile(sorted: &[f64], p: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let at = p.clamp(0.0, 1.0) * last as f64;
    let (below, share) = (at.floor(), at.fract());
    let value = |index: f64| sorted.get(index as usize).copied();
    let low = value(below).unwrap_or(f64::NAN);
    low + share * (value(below + 1.0).unwrap_or(low) - low)
}

/// Returns the half-width of the interval about zero that contains a share `p` of the values.
pub fn half_width(values: impl IntoIterator<Item = f64>, p: f64) -> f64 {
    let mut sizes: Vec<f64> = values.into_iter().map(f64::abs).collect();
    sizes.sort_by(f64::total_cmp);
    quantile(&sizes, p)
}
