//! Uncertainty of the ISO 230-2 figures due to the instrument.
//!
//! The reference is the figure that an ideal instrument would have given for the same runs (ISO/TR 230-9 counts instrument and
//! set-up, not the machine's scatter, which the figures describe). With y_ij the readings and x_ij the true values,
//!
//! ```text
//! y_ij = x_ij + ε p_i + e_ij        ε ~ u_scale, common to all;  e_ij ~ u_reading, independent
//! ```
//!
//! A, R and B are maxima and spreads: on average, errors of reading increase them. Intervals y ± k u, or new errors added to
//! y, therefore do not reach their coverage (`docs/uncertainty.md` has the counts). The trials draw x given y instead: the
//! readings of a position about their mean m_i, the reversal B_i and the means about theirs, each with the machine's share of
//! its scatter:
//!
//! ```text
//! x = m + λ (y − m) + √λ u z,      λ = 1 − u²/s²,      s²: scatter as measured, drawn with its own degrees of freedom, above u²
//! ```
//!
//! u² is u_reading² for a reading, 2 u_reading²/n for a reversal, u_reading²/(2n) for a mean of both directions. The figures
//! of the drawn x form the distribution; the result is its central interval. The coverage falls short if the machine's scatter
//! is below a third of u_reading, which [`Positioning::drowned`] reports.
//!
//! Sources: ISO 230-2:2014; ISO/TR 230-9:2005 (terms); JCGM 101:2008, clause 7; B. Efron, C. Morris,
//! 10.1080/01621459.1973.10481350 (shrinkage towards a mean, with the variances of the data).

use super::{Draws, Interval, quantile};
use crate::accuracy::{Accuracy, AccuracyError, AtPosition, Direction, Measurement, evaluate, from_positions};
use serde::Serialize;
use std::vec::Vec;

/// Attempts to draw a variance above a bound before the bound is used.
const ATTEMPTS: usize = 30;

/// Standard uncertainties of an instrument.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Instrument {
    /// Proportional to length, µm per mm (µrad per degree): calibration, temperature, expansion, misalignment.
    pub per_length: f64,
    /// For a single reading, µm (µrad): resolution, environmental variation.
    pub reading: f64,
}

/// A figure with its uncertainty band.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Band {
    /// Symbol in ISO 230-2: `A`, `A_up`, `A_down`, `E`, … `M`, `B`, `B_mean`.
    pub figure: &'static str,
    /// As measured, µm (µrad).
    pub value: f64,
    /// Expanded uncertainty U: half of the interval.
    pub expanded: f64,
    /// Interval that contains the figure with the given coverage.
    pub interval: Interval,
}

/// Bands of all figures of a measurement.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Positioning {
    /// Coverage, 0 … 1.
    pub coverage: f64,
    /// Number of draws.
    pub trials: usize,
    /// Bands of the figures that the measurement has.
    pub figures: Vec<Band>,
    /// Whether the instrument dominates the scatter of the readings: the bands of A, R and B may then fall short of their
    /// coverage.
    pub drowned: bool,
}

impl Positioning {
    /// Returns the band of a figure by its symbol.
    pub fn of(&self, figure: &str) -> Option<&Band> {
        self.figures.iter().find(|band| band.figure == figure)
    }
}

/// Reads a figure if the measurement has it.
pub type Take = fn(&Accuracy) -> Option<f64>;

/// The figures of ISO 230-2 by their symbols, as in [`Band::figure`].
pub const FIGURES: [(&str, Take); 12] = [
    ("A", |a| Some(a.both?.accuracy)),
    ("A_up", |a| Some(a.up?.accuracy)),
    ("A_down", |a| Some(a.down?.accuracy)),
    ("E", |a| Some(a.both?.systematic)),
    ("E_up", |a| Some(a.up?.systematic)),
    ("E_down", |a| Some(a.down?.systematic)),
    ("R", |a| Some(a.both?.repeatability)),
    ("R_up", |a| Some(a.up?.repeatability)),
    ("R_down", |a| Some(a.down?.repeatability)),
    ("M", |a| Some(a.both?.mean_range)),
    ("B", |a| Some(a.both?.reversal)),
    ("B_mean", |a| Some(a.both?.mean_reversal)),
];

/// Readings at the positions: deviations from the mean, and the means, by direction.
struct Read {
    positions: Vec<f64>,
    runs: usize,
    /// By position and measured direction: the readings minus their mean.
    beyond: Vec<Vec<Vec<f64>>>,
    /// Mean over the directions, and half of the reversal (0 in one direction).
    middle: Vec<f64>,
    half: Vec<f64>,
}

impl Read {
    fn new(measurement: &Measurement) -> Read {
        let (mut beyond, mut middle, mut half) = (Vec::new(), Vec::new(), Vec::new());
        for &position in &measurement.positions {
            let mut means = Vec::new();
            let of_position = measurement.directions.iter().map(|&direction| {
                let readings: Vec<f64> = measurement.deviations(position, direction).collect();
                let mean = readings.iter().sum::<f64>() / readings.len() as f64;
                means.push(mean);
                readings.iter().map(|reading| reading - mean).collect()
            });
            beyond.push(of_position.collect());
            let (first, last) = (means.first().copied().unwrap_or(0.0), means.last().copied().unwrap_or(0.0));
            middle.push(0.5 * (first + last));
            half.push(0.5 * (first - last));
        }
        Read { positions: measurement.positions.clone(), runs: measurement.runs, beyond, middle, half }
    }
}

/// Mean, and variance about it.
fn scatter(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, squares / (values.len() as f64 - 1.0).max(1.0))
}

/// λ: the machine's share of a measured variance with `nu` degrees of freedom, of which `noise` is due to the instrument.
fn share(draws: &mut Draws, measured: f64, nu: f64, noise: f64) -> f64 {
    if noise <= 0.0 {
        return 1.0;
    }
    let mut total = measured;
    for _ in 0..ATTEMPTS {
        total = measured * draws.spread(nu).powi(2);
        if total > noise {
            break;
        }
    }
    if total > noise { 1.0 - noise / total } else { 0.0 }
}

/// Computes the figures of a measurement with bands of coverage `coverage`, by `trials` draws from `seed`.
///
/// Cost: a normal number and some ten operations per reading and trial.
///
/// # Errors
/// As [`evaluate`].
pub fn positioning(
    measurement: &Measurement,
    instrument: Instrument,
    coverage: f64,
    trials: usize,
    seed: u64,
) -> Result<Positioning, AccuracyError> {
    let measured = evaluate(measurement)?;
    let read = Read::new(measurement);
    let (n, ways, count) = (read.runs as f64, measurement.directions.len() as f64, read.positions.len() as f64);
    let noise = instrument.reading * instrument.reading;
    let nu = count * ways * (n - 1.0);
    let squares: f64 = read.beyond.iter().flatten().flatten().map(|beyond| beyond * beyond).sum();
    let (middle_mean, middle_variance) = scatter(&read.middle);
    let (half_mean, half_variance) = scatter(&read.half);
    // Variance of the half reversal, and of the mean of both directions.
    let of_mean = noise / (ways * n);
    let nu_of_positions = (count - 1.0).max(1.0);
    let mut drawn: Vec<Vec<f64>> = FIGURES.iter().map(|_| Vec::with_capacity(trials)).collect();
    let mut draws = Draws::new(seed, 0);
    for _ in 0..trials {
        let within = share(&mut draws, squares / nu, nu, noise);
        let of_middle = share(&mut draws, middle_variance, nu_of_positions, of_mean);
        let of_half = if ways > 1.0 { share(&mut draws, half_variance, nu_of_positions, of_mean) } else { 1.0 };
        let scale = instrument.per_length * draws.normal();
        // Uncertainty of the mean over all positions: it shifts all of them.
        let common = draws.normal() * ((1.0 - of_half) * of_mean / count).sqrt();
        let mut positions: Vec<AtPosition> = Vec::with_capacity(read.positions.len());
        for (i, &position) in read.positions.iter().enumerate() {
            let spread = |draws: &mut Draws, share: f64| (share * of_mean).sqrt() * draws.normal();
            let middle = middle_mean + of_middle * (read.middle[i] - middle_mean) + spread(&mut draws, of_middle);
            let middle = middle + scale * position;
            let half = match ways > 1.0 {
                true => half_mean + of_half * (read.half[i] - half_mean) + spread(&mut draws, of_half) + common,
                false => 0.0,
            };
            let mut found = [None; 2];
            for (direction, beyond) in measurement.directions.iter().zip(&read.beyond[i]) {
                let values: Vec<f64> = beyond
                    .iter()
                    .map(|beyond| within * beyond + within.sqrt() * instrument.reading * draws.normal())
                    .collect();
                let (_, variance) = scatter(&values);
                let (slot, mean) = match direction {
                    Direction::Up => (0, middle + half),
                    Direction::Down => (1, middle - half),
                };
                found[slot] = Some((mean, variance.sqrt()));
            }
            positions.push(AtPosition::of(position, found));
        }
        let figures = from_positions(measurement.axis, read.runs, positions);
        for (values, (_, take)) in drawn.iter_mut().zip(FIGURES) {
            values.extend(take(&figures));
        }
    }
    let tail = 0.5 * (1.0 - coverage);
    let band = |values: &mut Vec<f64>, (figure, take): (&'static str, Take)| {
        let value = take(&measured)?;
        values.sort_by(f64::total_cmp);
        let interval = Interval { low: quantile(values, tail), high: quantile(values, 1.0 - tail) };
        Some(Band { figure, value, expanded: 0.5 * (interval.high - interval.low), interval })
    };
    let figures = drawn.iter_mut().zip(FIGURES).filter_map(|(values, figure)| band(values, figure)).collect();
    // The machine's scatter is below a third of the instrument's: 1 + 1/9 of its variance.
    let drowned = noise > 0.0 && squares / nu < noise * (1.0 + 1.0 / 9.0);
    Ok(Positioning { coverage, trials, figures, drowned })
}
