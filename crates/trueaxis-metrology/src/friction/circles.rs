//! Effect of friction on the recorded circles: radial deviation over the angle.
//!
//! ```text
//! ρ(θ) = −(d₁ cos θ + d₂ sin θ),   θ = atan2(c₂ − m₂, c₁ − m₁)
//! ```
//!
//! with d the deviations of the two axes ([`Deviation`]), c their commands and m the circle's centre. The sign is that of a
//! ballbar: positive outwards.

use super::glitch::Deviation;
use super::{FrictionRefusal, Identified, Record};
use std::f64::consts::TAU;
use std::vec::Vec;

/// Number of stretches over which samples are averaged: 0.5° each.
const BINS: usize = 720;
/// Speed at which the axes count as moving, as a share of the record's fastest.
const MOVING: f64 = 0.02;
/// The speed along the circle counts as even within this share of its median.
const EVEN: f64 = 0.02;
/// Distances from the centre agree within this share on a circle; so do the radii and feeds of one size.
const ROUND: f64 = 0.02;
/// Least number of turns of a circle.
const TURNS: f64 = 0.95;

/// Radial deviation along the circles of one size and direction, averaged over their turns.
#[derive(Clone, Debug, PartialEq)]
pub struct Circle {
    /// Commanded radius, mm.
    pub radius: f64,
    /// Commanded speed, mm/s.
    pub feed_per_s: f64,
    /// Whether the direction is from the first axis of the plane to the second.
    pub counterclockwise: bool,
    /// Number of turns averaged.
    pub turns: f64,
    /// Angles from the positive first axis, rad, ascending; stretches without a sample are omitted.
    pub angle: Vec<f64>,
    /// As recorded, mm.
    pub before: Vec<f64>,
    /// As predicted by the identified friction, mm.
    pub predicted: Vec<f64>,
    /// Recorded deviation minus the part that the feed-forward removes, mm.
    pub after: Vec<f64>,
}

/// Evaluates the circles of a record, in the order in which they were travelled; empty if it contains no whole circle. `found`
/// may come from another record of the same axes.
///
/// # Errors
/// A record that [`super::identify`] would refuse before fitting.
///
/// Cost: six simulations of the record.
pub fn circles(record: &Record, found: &[Identified; 2]) -> Result<Vec<Circle>, FrictionRefusal> {
    let deviations = [found[0].deviation(record, 0)?, found[1].deviation(record, 1)?];
    let every = (deviations[0].sample_s / record.period_s).round().max(1.0) as usize;
    let commands = [0, 1].map(|i| record.axes[i].command.iter().copied().step_by(every).collect::<Vec<f64>>());
    let mut sizes: Vec<Sums> = Vec::new();
    for stretch in stretches(&commands) {
        let Some(turn) = Turn::of(&commands, stretch, deviations[0].sample_s) else { continue };
        let place = sizes.iter().position(|sums| sums.turn.is_alike(&turn)).unwrap_or_else(|| {
            sizes.push(Sums::new(turn.clone()));
            sizes.len() - 1
        });
        sizes[place].add(&turn, &commands, &deviations);
    }
    Ok(sizes.into_iter().map(Sums::circle).collect())
}

fn way(commands: &[Vec<f64>; 2], k: usize) -> f64 {
    (commands[0][k + 1] - commands[0][k]).hypot(commands[1][k + 1] - commands[1][k])
}

/// Stretches of motion between stops.
fn stretches(commands: &[Vec<f64>; 2]) -> Vec<[usize; 2]> {
    let steps = commands[0].len().saturating_sub(1);
    let fastest = (0..steps).fold(0.0, |top: f64, k| top.max(way(commands, k)));
    let mut stretches = Vec::new();
    let mut since = None;
    for k in 0..steps {
        match (since, way(commands, k) > MOVING * fastest) {
            (None, true) => since = Some(k),
            (Some(from), false) => {
                stretches.push([from, k]);
                since = None;
            }
            _ => {}
        }
    }
    stretches.extend(since.map(|from| [from, steps]));
    stretches
}

/// A stretch that is a circle.
#[derive(Clone, Debug)]
struct Turn {
    stretch: [usize; 2],
    centre: [f64; 2],
    radius: f64,
    /// Median travel per sample, mm.
    step: f64,
    feed_per_s: f64,
    /// Number of turns, signed.
    turns: f64,
}

impl Turn {
    fn of(commands: &[Vec<f64>; 2], stretch: [usize; 2], sample_s: f64) -> Option<Turn> {
        let [from, to] = stretch;
        let ends = |values: &[f64]| {
            values.iter().fold([f64::MAX, f64::MIN], |[low, high], &value| [low.min(value), high.max(value)])
        };
        let centre = [0, 1].map(|i| {
            let [low, high] = ends(&commands[i][from..=to]);
            0.5 * (low + high)
        });
        let distance = |k: usize| (commands[0][k] - centre[0]).hypot(commands[1][k] - centre[1]);
        let radii: Vec<f64> = (from..=to).map(distance).collect();
        let [low, high] = ends(&radii);
        let radius = radii.iter().sum::<f64>() / radii.len() as f64;
        if high - low > ROUND * radius {
            return None;
        }
        let mut steps: Vec<f64> = (from..to).map(|k| way(commands, k)).collect();
        let middle = steps.len() / 2;
        let step = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
        let swept = |k: usize| {
            let [a, b] = [k, k + 1].map(|k| [commands[0][k] - centre[0], commands[1][k] - centre[1]]);
            (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1])
        };
        let turns = (from..to).map(swept).sum::<f64>() / TAU;
        (turns.abs() >= TURNS).then_some(Turn { stretch, centre, radius, step, feed_per_s: step / sample_s, turns })
    }

    fn is_alike(&self, other: &Turn) -> bool {
        let same = |a: f64, b: f64| (a - b).abs() <= ROUND * a.max(b);
        same(self.radius, other.radius)
            && same(self.feed_per_s, other.feed_per_s)
            && (self.turns > 0.0) == (other.turns > 0.0)
    }
}

/// Running sums over the circles of one size and direction.
struct Sums {
    turn: Turn,
    turns: f64,
    /// For each bin: number of samples; sums of angle, before, predicted, after.
    bins: Vec<(usize, [f64; 4])>,
}

impl Sums {
    fn new(turn: Turn) -> Sums {
        Sums { turn, turns: 0.0, bins: Vec::from([(0, [0.0; 4]); BINS]) }
    }

    fn add(&mut self, turn: &Turn, commands: &[Vec<f64>; 2], [first, second]: &[Deviation; 2]) {
        self.turns += turn.turns.abs();
        let [from, to] = turn.stretch;
        for k in (from..to).filter(|&k| (way(commands, k) - turn.step).abs() <= EVEN * turn.step) {
            let [x, y] = [0, 1].map(|i| commands[i][k] - turn.centre[i]);
            let angle = y.atan2(x).rem_euclid(TAU);
            let bin = ((angle / TAU * BINS as f64) as usize).min(BINS - 1);
            let [cos, sin] = [x / x.hypot(y), y / x.hypot(y)];
            let outward = |one: &[f64], other: &[f64]| -(one[k] * cos + other[k] * sin);
            let (count, sums) = &mut self.bins[bin];
            *count += 1;
            sums[0] += angle;
            sums[1] += outward(&first.before, &second.before);
            sums[2] += outward(&first.predicted, &second.predicted);
            sums[3] += outward(&first.after, &second.after);
        }
    }

    fn circle(self) -> Circle {
        let filled: Vec<[f64; 4]> = self
            .bins
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, sums)| sums.map(|sum| sum / *count as f64))
            .collect();
        let column = |i: usize| filled.iter().map(|means| means[i]).collect();
        Circle {
            radius: self.turn.radius,
            feed_per_s: self.turn.feed_per_s,
            counterclockwise: self.turn.turns > 0.0,
            turns: self.turns,
            angle: column(0),
            before: column(1),
            predicted: column(2),
            after: column(3),
        }
    }
}
