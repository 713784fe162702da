//! The slow error: a cubic spline for each pass, by B-splines over equal segments.

use super::Reading;
use std::vec::Vec;

/// Degree of the spline.
const DEGREE: usize = 3;
/// Most segments of a pass.
pub(super) const MOST: usize = 64;

/// Splines of all passes, with the same number of segments.
#[derive(Clone, Debug)]
pub(super) struct Slow {
    /// Ends of each pass; `None` for a number without readings.
    ends: Vec<Option<[f64; 2]>>,
    /// Segments of a pass; 0 for a straight line.
    pub(super) segments: usize,
}

impl Slow {
    pub(super) fn new(readings: &[Reading], segments: usize) -> Slow {
        let passes = readings.iter().map(|own| own.pass + 1).max().unwrap_or(0);
        let mut ends: Vec<Option<[f64; 2]>> = std::vec![None; passes];
        for own in readings {
            let [low, high] = ends[own.pass].unwrap_or([own.along; 2]);
            ends[own.pass] = Some([low.min(own.along), high.max(own.along)]);
        }
        Slow { ends, segments }
    }

    /// Columns of a pass.
    fn own(&self) -> usize {
        if self.segments == 0 { 2 } else { self.segments + DEGREE }
    }

    pub(super) fn columns(&self) -> usize {
        self.ends.iter().flatten().count() * self.own()
    }

    /// Calls `put` with the columns of a reading that are not zero.
    pub(super) fn row(&self, reading: &Reading, mut put: impl FnMut(usize, f64)) {
        let Some(Some([low, high])) = self.ends.get(reading.pass) else { return };
        let first = self.ends[..reading.pass].iter().flatten().count() * self.own();
        let share = (reading.along - low) / (high - low).max(f64::MIN_POSITIVE);
        if self.segments == 0 {
            put(first, 1.0);
            put(first + 1, 2.0 * share - 1.0);
            return;
        }
        let at = share * self.segments as f64;
        let segment = (at.floor() as usize).min(self.segments - 1);
        let t = at - segment as f64;
        let (u, t2, t3) = (1.0 - t, t * t, t * t * t);
        // The cubic B-spline over equal segments.
        let weights = [u * u * u, 3.0 * t3 - 6.0 * t2 + 4.0, -3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0, t3];
        for (k, weight) in weights.into_iter().enumerate() {
            put(first + segment + k, weight / 6.0);
        }
    }
}

/// Most segments of a pass: each at least two of the longest period long, and four readings for each of its columns.
pub(super) fn most(readings: &[Reading], longest: f64) -> usize {
    let passes = readings.iter().map(|own| own.pass + 1).max().unwrap_or(0);
    let of_pass = |pass: usize| {
        let mut own: Vec<[f64; 2]> =
            readings.iter().filter(|own| own.pass == pass).map(|own| [own.along, own.own.position]).collect();
        own.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let travel: f64 = own.windows(2).map(|pair| (pair[1][1] - pair[0][1]).abs()).sum();
        (!own.is_empty()).then(|| ((0.5 * travel / longest) as usize).min((own.len() / 4).saturating_sub(DEGREE)))
    };
    (0..passes).filter_map(of_pass).min().unwrap_or(0).min(MOST)
}
