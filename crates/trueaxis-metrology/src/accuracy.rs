//! Accuracy and repeatability of positioning after ISO 230-2:2014.
//!
//! With x_ij the deviation (actual − target) of run j = 1…n at position i = 1…m, ↑ in positive and ↓ in negative direction:
//!
//! ```text
//! x̄_i↑ = Σ_j x_ij↑ / n            x̄_i = (x̄_i↑ + x̄_i↓)/2          B_i = x̄_i↑ − x̄_i↓
//! s_i↑ = √(Σ_j (x_ij↑ − x̄_i↑)²/(n − 1))                            R_i↑ = 4 s_i↑
//! R_i = max(2 s_i↑ + 2 s_i↓ + |B_i|, R_i↑, R_i↓)
//! B = max |B_i|     B̄ = Σ_i B_i / m     R = max R_i    R↑ = max R_i↑
//! E↑ = max x̄_i↑ − min x̄_i↑     E = max(x̄_i↑, x̄_i↓) − min(x̄_i↑, x̄_i↓)     M = max x̄_i − min x̄_i
//! A↑ = max(x̄_i↑ + 2 s_i↑) − min(x̄_i↑ − 2 s_i↑)                     A the same over both directions
//! ```
//!
//! All values are in µm for linear and µrad for rotary axes. They exclude the measurement uncertainty.
//!
//! ```
//! use trueaxis::Axis;
//! use trueaxis_metrology::accuracy::{Approach, Direction, Measurement, evaluate, evaluate_compensated};
//!
//! let approach = |run, direction, deviation| Approach { position: 0.0, run, direction, deviation };
//! let (up, down) = (Direction::Up, Direction::Down);
//! let approaches = [approach(1, up, 1.0), approach(2, up, 1.0), approach(1, down, 4.0), approach(2, down, 4.0)];
//! let measurement = Measurement::new(Axis::X, approaches.into())?;
//! assert_eq!(evaluate(&measurement)?.both.unwrap().reversal, 3.0);
//! let backlash = |_, direction| if direction == Direction::Down { 3.0 } else { 0.0 };
//! assert_eq!(evaluate_compensated(&measurement, backlash)?.both.unwrap().reversal, 0.0);
//! # Ok::<(), trueaxis_metrology::accuracy::AccuracyError>(())
//! ```

use core::fmt;
use serde::Serialize;
use std::collections::BTreeSet;
use std::vec::Vec;
use trueaxis::Axis;

/// Direction in which a target is approached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Direction {
    /// In positive direction, ↑ in ISO 230-2.
    Up,
    /// In negative direction, ↓ in ISO 230-2.
    Down,
}

/// One approach of a target position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Target position, mm (degrees).
    pub position: f64,
    /// Run, from 1.
    pub run: u32,
    /// Direction of approach.
    pub direction: Direction,
    /// Actual − target position, µm (µrad).
    pub deviation: f64,
}

/// A measurement of one axis, with each run at each position in each measured direction exactly once.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// The axis.
    pub axis: Axis,
    /// All approaches, in the order of measurement.
    pub approaches: Vec<Approach>,
    /// Target positions, increasing, mm (degrees).
    pub positions: Vec<f64>,
    /// Number of runs.
    pub runs: usize,
    /// Measured directions, `Up` first.
    pub directions: Vec<Direction>,
}

impl Measurement {
    /// Groups the approaches of an axis into positions, runs and directions.
    ///
    /// # Errors
    /// No approach, or one repeated or missing.
    pub fn new(axis: Axis, approaches: Vec<Approach>) -> Result<Measurement, AccuracyError> {
        let key = |position: f64, run, direction| ((position + 0.0).to_bits(), run, direction);
        let mut given = BTreeSet::new();
        for (index, &approach) in approaches.iter().enumerate() {
            if !given.insert(key(approach.position, approach.run, approach.direction)) {
                return Err(AccuracyError::Twice { index, approach });
            }
        }
        if approaches.is_empty() {
            return Err(AccuracyError::Empty);
        }
        let mut positions: Vec<f64> = approaches.iter().map(|approach| approach.position).collect();
        positions.sort_by(f64::total_cmp);
        positions.dedup();
        let runs: BTreeSet<u32> = approaches.iter().map(|approach| approach.run).collect();
        let directions: BTreeSet<Direction> = approaches.iter().map(|approach| approach.direction).collect();
        for &position in &positions {
            for &run in &runs {
                for &direction in &directions {
                    if !given.contains(&key(position, run, direction)) {
                        return Err(AccuracyError::Missing { position, run, direction });
                    }
                }
            }
        }
        let directions = directions.into_iter().collect();
        Ok(Measurement { axis, approaches, positions, runs: runs.len(), directions })
    }

    /// Returns the deviations at a position in a direction, µm (µrad), in the order of measurement.
    pub fn deviations(&self, position: f64, direction: Direction) -> impl Iterator<Item = f64> {
        self.approaches
            .iter()
            .filter(move |approach| approach.position == position && approach.direction == direction)
            .map(|approach| approach.deviation)
    }

    /// Returns the mean deviation at a position in a direction, µm (µrad); `None` if it was not measured.
    pub fn mean(&self, position: f64, direction: Direction) -> Option<f64> {
        let (sum, count) = self
            .deviations(position, direction)
            .fold((0.0, 0_u32), |(sum, count), deviation| (sum + deviation, count + 1));
        (count > 0).then(|| sum / f64::from(count))
    }

    /// If the directions differ no more than the scatter of the runs explains, returns the root mean square of B_i and the
    /// value that scatter alone would cause, µm (µrad). `None` if they differ by more, or without a basis for the decision:
    /// one run, one direction.
    ///
    /// ```text
    /// v = 2 s²/n,  s² = mean of all s_i↑², s_i↓²,  ν = 2m(n − 1):   |Σ B_i/m| ≤ 2 √(v/m)  and  Σ B_i²/m ≤ v (1 + 2 √(2/m + 2/ν))
    /// ```
    ///
    /// The mean detects lost motion that is constant along the axis, the squares detect changes; both limits are two standard
    /// deviations.
    pub fn reversal_within_scatter(&self) -> Option<[f64; 2]> {
        let found = evaluate(self).ok()?;
        let (m, n) = (found.positions.len() as f64, self.runs as f64);
        let (mut sum, mut squares, mut scatter) = (0.0, 0.0, 0.0);
        for at in &found.positions {
            let (reversal, up, down) = (at.reversal?, at.up?, at.down?);
            sum += reversal;
            squares += reversal * reversal;
            scatter += up.s * up.s + down.s * down.s;
        }
        let (variance, freedom) = (scatter / (m * n), 2.0 * m * (n - 1.0));
        let within = (sum / m).abs() <= 2.0 * (variance / m).sqrt()
            && squares / m <= variance * (1.0 + 2.0 * (2.0 / m + 2.0 / freedom).sqrt());
        within.then(|| [squares / m, variance].map(f64::sqrt))
    }
}

/// Result at one target position in one direction; µm (µrad).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OneWayAtPosition {
    /// Mean deviation x̄_i↑ or x̄_i↓.
    pub mean: f64,
    /// Estimator of the repeatability s_i↑ or s_i↓.
    pub s: f64,
    /// Repeatability R_i↑ = 4 s_i↑ (R_i↓).
    pub repeatability: f64,
}

/// Result at one target position; µm (µrad).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AtPosition {
    /// Target position, mm (degrees).
    pub position: f64,
    /// Approached in positive direction.
    pub up: Option<OneWayAtPosition>,
    /// Approached in negative direction.
    pub down: Option<OneWayAtPosition>,
    /// Mean bidirectional deviation x̄_i.
    pub mean: Option<f64>,
    /// Reversal error B_i.
    pub reversal: Option<f64>,
    /// Bidirectional repeatability R_i.
    pub repeatability: Option<f64>,
}

/// Result of the axis in one direction; µm (µrad).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OneWay {
    /// Unidirectional accuracy A↑ or A↓.
    pub accuracy: f64,
    /// Unidirectional systematic positioning error E↑ or E↓.
    pub systematic: f64,
    /// Unidirectional repeatability R↑ or R↓.
    pub repeatability: f64,
}

/// Result of the axis over both directions; µm (µrad).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BothWays {
    /// Bidirectional accuracy A.
    pub accuracy: f64,
    /// Bidirectional systematic positioning error E.
    pub systematic: f64,
    /// Bidirectional repeatability R.
    pub repeatability: f64,
    /// Range of the mean bidirectional deviation M.
    pub mean_range: f64,
    /// Reversal error B.
    pub reversal: f64,
    /// Mean reversal error B̄, with sign.
    pub mean_reversal: f64,
}

/// Evaluation of one axis after ISO 230-2:2014.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Accuracy {
    /// Letter of the axis.
    pub axis: char,
    /// Unit of all values except the positions: `um` or `urad`.
    pub unit: &'static str,
    /// Number of runs n (ISO 230-2 requires 5).
    pub runs: usize,
    /// One entry per target position, increasing.
    pub positions: Vec<AtPosition>,
    /// In positive direction, if measured.
    pub up: Option<OneWay>,
    /// In negative direction, if measured.
    pub down: Option<OneWay>,
    /// Over both directions, if both were measured.
    pub both: Option<BothWays>,
}

/// Why a measurement is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum AccuracyError {
    /// There is only one run; a standard deviation needs two values.
    TooFewRuns,
    /// No approaches.
    Empty,
    /// A position is repeated in the same run and direction.
    Twice {
        /// Index of the second approach.
        index: usize,
        /// The approach.
        approach: Approach,
    },
    /// A run lacks a position that another run has, or one of its directions.
    Missing {
        /// Target position, mm (degrees).
        position: f64,
        /// Run, from 1.
        run: u32,
        /// Direction of approach.
        direction: Direction,
    },
}

impl fmt::Display for AccuracyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = |direction| if direction == Direction::Up { "+" } else { "-" };
        match *self {
            AccuracyError::TooFewRuns => f.write_str("found one run, needed at least two (ISO 230-2: five)"),
            AccuracyError::Empty => f.write_str("found no approaches, needed at least one"),
            AccuracyError::Twice { approach: Approach { position, run, direction, .. }, .. } => {
                let sign = sign(direction);
                write!(f, "found position {position}, run {run}, direction {sign} again, needed each approach once")
            }
            AccuracyError::Missing { position, run, direction } => {
                let sign = sign(direction);
                write!(f, "found no approach of {position} in run {run}, direction {sign}, ")?;
                f.write_str("needed every run at every position in the measured directions")
            }
        }
    }
}

impl core::error::Error for AccuracyError {}

/// Evaluates the deviations as measured.
///
/// # Errors
/// [`AccuracyError::TooFewRuns`] for a single run.
pub fn evaluate(measurement: &Measurement) -> Result<Accuracy, AccuracyError> {
    evaluate_compensated(measurement, |_, _| 0.0)
}

/// Evaluates the deviations that a compensation would leave: x_ij − `error(position, direction)`.
///
/// `error` is the axis' own error as the table predicts it, actual − ideal, in µm (µrad), at a position in mm (degrees). The
/// evaluation is first-order: it looks the table up at the target, from which the compensated axis differs by the error
/// itself.
///
/// # Errors
/// [`AccuracyError::TooFewRuns`] for a single run.
pub fn evaluate_compensated(
    measurement: &Measurement,
    error: impl Fn(f64, Direction) -> f64,
) -> Result<Accuracy, AccuracyError> {
    if measurement.runs < 2 {
        return Err(AccuracyError::TooFewRuns);
    }
    let positions: Vec<AtPosition> =
        measurement.positions.iter().map(|&position| at_position(measurement, position, &error)).collect();
    Ok(from_positions(measurement.axis, measurement.runs, positions))
}

/// Figures of an axis from the results at its positions.
pub(crate) fn from_positions(axis: Axis, runs: usize, positions: Vec<AtPosition>) -> Accuracy {
    let up = one_way(positions.iter().filter_map(|at| at.up));
    let down = one_way(positions.iter().filter_map(|at| at.down));
    let both = both_ways(&positions);
    let unit = if axis.is_rotary() { "urad" } else { "um" };
    Accuracy { axis: axis.letter(), unit, runs, positions, up, down, both }
}

fn at_position(measurement: &Measurement, position: f64, error: impl Fn(f64, Direction) -> f64) -> AtPosition {
    let found = [Direction::Up, Direction::Down].map(|direction| {
        let predicted = error(position, direction);
        let mean = measurement.mean(position, direction)? - predicted;
        let squares =
            measurement.deviations(position, direction).map(|deviation| (deviation - predicted - mean).powi(2));
        let s = (squares.sum::<f64>() / (measurement.runs as f64 - 1.0)).sqrt();
        Some((mean, s))
    });
    AtPosition::of(position, found)
}

impl AtPosition {
    /// From mean and standard deviation in positive and negative direction.
    pub(crate) fn of(position: f64, found: [Option<(f64, f64)>; 2]) -> AtPosition {
        let [up, down] = found.map(|found| found.map(|(mean, s)| OneWayAtPosition { mean, s, repeatability: 4.0 * s }));
        let pair = up.zip(down);
        let reversal = pair.map(|(up, down)| up.mean - down.mean);
        let repeatability = pair.map(|(up, down)| {
            let across = 2.0 * up.s + 2.0 * down.s + (up.mean - down.mean).abs();
            across.max(up.repeatability).max(down.repeatability)
        });
        let mean = pair.map(|(up, down)| 0.5 * (up.mean + down.mean));
        AtPosition { position, up, down, mean, reversal, repeatability }
    }
}

fn one_way(results: impl Iterator<Item = OneWayAtPosition> + Clone) -> Option<OneWay> {
    results.clone().next()?;
    Some(OneWay {
        accuracy: accuracy(results.clone()),
        systematic: range(results.clone().map(|at| at.mean)),
        repeatability: results.map(|at| at.repeatability).fold(0.0, f64::max),
    })
}

fn both_ways(positions: &[AtPosition]) -> Option<BothWays> {
    let reversals: Vec<f64> = positions.iter().map(|at| at.reversal).collect::<Option<_>>()?;
    let results = positions.iter().flat_map(|at| [at.up, at.down]).flatten();
    Some(BothWays {
        accuracy: accuracy(results.clone()),
        systematic: range(results.map(|at| at.mean)),
        repeatability: positions.iter().filter_map(|at| at.repeatability).fold(0.0, f64::max),
        mean_range: range(positions.iter().filter_map(|at| at.mean)),
        reversal: reversals.iter().map(|reversal| reversal.abs()).fold(0.0, f64::max),
        mean_reversal: reversals.iter().sum::<f64>() / reversals.len() as f64,
    })
}

fn accuracy(results: impl Iterator<Item = OneWayAtPosition> + Clone) -> f64 {
    let high = results.clone().map(|at| at.mean + 2.0 * at.s).fold(f64::NEG_INFINITY, f64::max);
    let low = results.map(|at| at.mean - 2.0 * at.s).fold(f64::INFINITY, f64::min);
    high - low
}

fn range(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().fold(f64::NEG_INFINITY, f64::max) - values.fold(f64::INFINITY, f64::min)
}
