//! The curves drawn: following errors of the record, spikes at the reversals, circles.

use super::Recording;
use anyhow::{Result, anyhow};
use serde::Serialize;
use trueaxis_metrology::friction::{self, Glitch, Identified, Record};

/// The mean spike of the circles of one size; positive against the new direction of travel.
#[derive(Clone, Debug, Serialize)]
pub struct SpikeCurves {
    /// Letter of the axis.
    pub axis: String,
    /// Acceleration at the reversal (feed²/radius), mm/s².
    pub acceleration_mm_per_s2: f64,
    /// Number of reversals averaged.
    pub reversals: usize,
    /// Time after the reversal, ms.
    pub time_ms: Vec<f64>,
    /// Recorded spike, µm.
    pub before_um: Vec<f64>,
    /// Spike predicted from the friction found, µm.
    pub predicted_um: Vec<f64>,
    /// Recorded spike minus the part that the feed-forward removes in the model, µm.
    pub after_um: Vec<f64>,
}

/// The spikes of an axis, from the slowest circles to the fastest.
pub fn spikes(found: &Identified, glitch: &Glitch) -> Vec<SpikeCurves> {
    let curve = |spike: &friction::Spike| SpikeCurves {
        axis: found.axis.letter().to_string(),
        acceleration_mm_per_s2: spike.acceleration,
        reversals: spike.reversals,
        time_ms: scaled(&spike.time_s),
        before_um: scaled(&spike.before),
        predicted_um: scaled(&spike.predicted),
        after_um: scaled(&spike.after),
    };
    glitch.spikes.iter().map(curve).collect()
}

/// Radial deviation along the circles of one size and direction, positive outward.
#[derive(Clone, Debug, Serialize)]
pub struct CircleCurves {
    /// Commanded radius, mm.
    pub radius_mm: f64,
    /// Commanded speed, mm/min.
    pub feed_mm_per_min: f64,
    /// Whether the circle turns from the first axis of the plane to the second.
    pub counterclockwise: bool,
    /// Number of turns averaged.
    pub turns: f64,
    /// Angles from the positive first axis, degrees, ascending.
    pub angle_deg: Vec<f64>,
    /// Recorded deviation, µm.
    pub before_um: Vec<f64>,
    /// Deviation predicted from the friction found, µm.
    pub predicted_um: Vec<f64>,
    /// Recorded deviation minus the part that the feed-forward removes in the model, µm.
    pub after_um: Vec<f64>,
}

/// The circles of a record with the effect of friction on them; `found` may come from another record of the same axes.
/// `source` names the record in the error.
///
/// # Errors
/// As [`friction::circles`].
pub fn circles(record: &Record, source: &str, found: &[Identified; 2]) -> Result<Vec<CircleCurves>> {
    let circles = friction::circles(record, found).map_err(|refused| anyhow!("{source}: {refused}"))?;
    let curves = |circle: friction::Circle| CircleCurves {
        radius_mm: circle.radius,
        feed_mm_per_min: 60.0 * circle.feed_per_s,
        counterclockwise: circle.counterclockwise,
        turns: circle.turns,
        angle_deg: circle.angle.iter().map(|angle| angle.to_degrees()).collect(),
        before_um: scaled(&circle.before),
        predicted_um: scaled(&circle.predicted),
        after_um: scaled(&circle.after),
    };
    Ok(circles.into_iter().map(curves).collect())
}

fn scaled(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| 1e3 * value).collect()
}

/// Following errors of a record, thinned for drawing.
#[derive(Clone, Debug, Serialize)]
pub struct Trace {
    /// Time after the first sample, s.
    pub time_s: Vec<f64>,
    /// Command minus reading of the two axes, µm.
    pub following_error_um: [Vec<f64>; 2],
}

impl Recording {
    /// Following errors in at most `points` points: the smallest and the largest of each stretch of an axis, in the order in
    /// which they occurred.
    pub fn trace(&self, points: usize) -> Trace {
        let count = self.record.axes[0].command.len();
        let stretch = (2 * count).div_ceil(points.max(2)).max(2);
        let starts = || (0..count).step_by(stretch);
        let half = 0.5 * stretch as f64;
        let time_s =
            starts().flat_map(|from| [from as f64, from as f64 + half]).map(|k| k * self.record.period_s).collect();
        let following_error_um = [0, 1].map(|i| {
            let own = &self.record.axes[i];
            let error = |k: usize| 1e3 * (own.command[k] - own.reading[k]);
            let ends = |from: usize| {
                let to = (from + stretch).min(count);
                let [low, high] = (from..to).fold([from; 2], |[low, high], k| {
                    [if error(k) < error(low) { k } else { low }, if error(k) > error(high) { k } else { high }]
                });
                [error(low.min(high)), error(low.max(high))]
            };
            starts().flat_map(ends).collect()
        });
        Trace { time_s, following_error_um }
    }
}
