//! The curves drawn: following errors of the record, spikes at the reversals, circles.

use super::Recording;
use crate::shown::{Around, Curve, Plot, Polar};
use anyhow::{Result, anyhow};
use serde::Serialize;
use trueaxis::Axis;
use trueaxis_metrology::friction::{self, Circle, Identified, Record, Spike};
use trueaxis_report::number::{decimals, significant};

/// Largest ratio of the accelerations of one size of circle, estimated in two records; those of other circles differ by 1.5.
const ALIKE: f64 = 1.4;
/// Radii and feeds that differ by at most this share count as equal.
const SAME: f64 = 0.05;

/// A plot of the spikes of an axis at reversals with one acceleration.
fn spike_plot(axis: Axis, of: &Spike, caption: &'static str, curves: &[(&str, usize, &[f64])]) -> Plot {
    let length = curves.iter().map(|(.., values)| values.len()).min().unwrap_or(0).min(of.time_s.len());
    let curve = |(name, colour, values): &(&str, usize, &[f64])| Curve::new(*name, *colour, micro(&values[..length]));
    let (letter, acceleration) = (axis.letter(), significant(of.acceleration, 3));
    Plot {
        section: "Spikes at the reversals",
        title: format!("Axis {letter}, {acceleration} mm/s² at the reversal, mean of {}", of.reversals),
        x: ("time after the reversal".into(), "ms"),
        y: ("following error", "µm"),
        caption,
        at: micro(&of.time_s[..length]),
        curves: curves.iter().map(curve).collect(),
        ..Plot::default()
    }
}

/// The spikes of all axes, from the slowest circles to the fastest.
pub fn spikes(found: &[Identified]) -> Vec<Plot> {
    let plot = |own: &Identified, spike: &Spike| {
        let curves: [(&str, usize, &[f64]); 3] = [
            ("before, recorded", 5, &spike.before),
            ("predicted by the model", 8, &spike.predicted),
            ("after, expected", 6, &spike.after),
        ];
        let caption = "Turned into the new direction of travel. After: the record minus the effect of the feed-forward with the \
                       parameters found, in the model.";
        spike_plot(own.axis, spike, caption, &curves)
    };
    found.iter().flat_map(|own| own.glitch.spikes.iter().map(move |spike| plot(own, spike))).collect()
}

/// The spikes of an axis in two passes of the same circles.
pub fn spikes_again(axis: Axis, before: &[Spike], after: &[Spike]) -> Vec<Plot> {
    let plot = |spike: &Spike| {
        let ratio = |one: &Spike| (one.acceleration / spike.acceleration).ln().abs();
        let nearest = after.iter().min_by(|one, other| ratio(one).total_cmp(&ratio(other)));
        let again = nearest.filter(|nearest| ratio(nearest) < ALIKE.ln()).map(|again| again.before.as_slice());
        let curves = std::iter::once(("before, simulated", 5, spike.before.as_slice()));
        let curves: Vec<_> = curves.chain(again.map(|again| ("after, simulated", 6, again))).collect();
        spike_plot(axis, spike, "", &curves)
    };
    before.iter().map(plot).collect()
}

/// A polar plot of the circles of one size and direction.
fn circle_plot(axes: [Axis; 2], of: &Circle, curves: impl IntoIterator<Item = Around>) -> Polar {
    let way = if of.counterclockwise { "counterclockwise" } else { "clockwise" };
    let (radius, feed) = (significant(of.radius, 4), decimals(60.0 * of.feed_per_s, 0));
    Polar {
        section: "Radial deviation by friction, positive outward",
        title: format!("R {radius} mm, {feed} mm/min, {way}"),
        axes: axes.map(|axis| axis.letter().to_string()),
        curves: curves.into_iter().collect(),
    }
}

fn around(of: &Circle, name: &'static str, colour: usize, values: &[f64]) -> Around {
    let angle_deg = of.angle.iter().map(|angle| angle.to_degrees()).collect();
    Around { name, colour, angle_deg, um: micro(values) }
}

/// The circles of a record with the effect of friction on them. `source` names the record in the error.
///
/// # Errors
/// As [`friction::circles`].
pub fn circles(record: &Record, source: &str, found: &[Identified; 2]) -> Result<Vec<Polar>> {
    let plot = |of: &Circle| {
        let curves = [
            around(of, "before, recorded", 5, &of.before),
            around(of, "predicted by the model", 8, &of.predicted),
            around(of, "after, expected", 6, &of.after),
        ];
        circle_plot(found.each_ref().map(|own| own.axis), of, curves)
    };
    Ok(travelled(record, source, found)?.iter().map(plot).collect())
}

/// The circles of two records of the same circles.
///
/// # Errors
/// As [`friction::circles`].
pub fn circles_again(records: [&Record; 2], source: &str, found: &[Identified; 2]) -> Result<Vec<Polar>> {
    let [before, after] = records.map(|record| travelled(record, source, found));
    let (before, after) = (before?, after?);
    let same = |one: f64, other: f64| (one - other).abs() <= SAME * one.max(other);
    let plot = |of: &Circle| {
        let again = after.iter().find(|again| {
            again.counterclockwise == of.counterclockwise
                && same(again.radius, of.radius)
                && same(again.feed_per_s, of.feed_per_s)
        });
        let again = again.map(|again| around(again, "after, simulated", 6, &again.before));
        let curves = std::iter::once(around(of, "before, simulated", 5, &of.before)).chain(again);
        circle_plot(found.each_ref().map(|own| own.axis), of, curves)
    };
    Ok(before.iter().map(plot).collect())
}

fn travelled(record: &Record, source: &str, found: &[Identified; 2]) -> Result<Vec<Circle>> {
    friction::circles(record, found).map_err(|refused| anyhow!("{source}: {refused}"))
}

/// A thousand times the values: mm in µm, s in ms.
fn micro(values: &[f64]) -> Vec<f64> {
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
