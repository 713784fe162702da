//! Rows and columns of the fit.

use super::sampling::Line;
use super::slow::Slow;
use super::{Place, Reading};
use crate::linear_fit::{LinearFit, Solution};
use std::f64::consts::TAU;
use std::vec;
use std::vec::Vec;

/// Directions that a harmonic describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Both,
    Positive,
    Negative,
}

impl Side {
    pub(super) fn has(self, is_negative: bool) -> bool {
        match self {
            Side::Both => true,
            Side::Positive => !is_negative,
            Side::Negative => is_negative,
        }
    }
}

/// A harmonic of the axis in some directions, two columns: cosine and sine.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wave {
    pub(super) line: Line,
    pub(super) side: Side,
}

/// Unknowns of a fit, in the order of its columns: slow error, lost motion of a circle in each pass, harmonics of the axis,
/// harmonics of the other axis.
#[derive(Clone, Debug)]
pub(super) struct Design {
    pub(super) slow: Slow,
    /// Passes that have lost motion; 0 for a scan.
    lost: usize,
    pub(super) waves: Vec<Wave>,
    others: Vec<Line>,
}

/// A fit with its residual.
#[derive(Clone, Debug)]
pub(super) struct Fitted {
    pub(super) design: Design,
    pub(super) solution: Solution,
    pub(super) residual: Vec<f64>,
    /// Slow error, lost motion and the other axis' harmonics.
    pub(super) rest: Vec<f64>,
}

fn wave(line: &Line, place: &Place) -> [f64; 2] {
    let (sine, cosine) = (TAU * line.frequency() * place.position).sin_cos();
    [place.share * cosine, place.share * sine]
}

impl Design {
    /// `lines` of the second axis are those of the first; a scan has none.
    pub(super) fn new(readings: &[Reading], segments: usize, waves: Vec<Wave>) -> Design {
        let slow = Slow::new(readings, segments);
        let on_circle = readings.iter().any(|own| own.other.is_some());
        let passes = readings.iter().map(|own| own.pass + 1).max().unwrap_or(0);
        let mut others: Vec<Line> = Vec::new();
        for wave in waves.iter().filter(|_| on_circle) {
            if !others.contains(&wave.line) {
                others.push(wave.line);
            }
        }
        Design { slow, lost: if on_circle { passes } else { 0 }, waves, others }
    }

    pub(super) fn columns(&self) -> usize {
        self.first() + 2 * (self.waves.len() + self.others.len())
    }

    /// Column of the first harmonic.
    pub(super) fn first(&self) -> usize {
        self.slow.columns() + 2 * self.lost
    }

    fn row(&self, reading: &Reading, row: &mut [f64]) {
        row.fill(0.0);
        self.slow.row(reading, |column, value| row[column] = value);
        let lost = self.slow.columns() + 2 * reading.pass;
        let sign = |place: &Place| if place.is_negative { -place.share } else { place.share };
        let first = self.first();
        if let Some(other) = &reading.other {
            row[lost] = sign(&reading.own);
            row[lost + 1] = sign(other);
            let from = first + 2 * self.waves.len();
            for (k, line) in self.others.iter().enumerate() {
                row[from + 2 * k..from + 2 * k + 2].copy_from_slice(&wave(line, other));
            }
        }
        for (k, own) in self.waves.iter().enumerate() {
            if own.side.has(reading.own.is_negative) {
                row[first + 2 * k..first + 2 * k + 2].copy_from_slice(&wave(&own.line, &reading.own));
            }
        }
    }

    pub(super) fn fit(self, readings: &[Reading]) -> Fitted {
        let mut row = vec![0.0; self.columns()];
        let mut fit = LinearFit::new(row.len());
        for reading in readings {
            self.row(reading, &mut row);
            fit.add(&row, reading.error, 1.0);
        }
        let solution = fit.solve();
        let (first, last) = (self.first(), self.first() + 2 * self.waves.len());
        let (mut residual, mut rest) = (Vec::new(), Vec::new());
        for reading in readings {
            self.row(reading, &mut row);
            let sum = |from: usize, to: usize| -> f64 {
                row[from..to].iter().zip(&solution.values[from..to]).map(|(a, x)| a * x).sum()
            };
            let own = sum(0, first) + sum(last, row.len());
            rest.push(own);
            residual.push(reading.error - own - sum(first, last));
        }
        Fitted { design: self, solution, residual, rest }
    }
}

impl Fitted {
    pub(super) fn squares(&self) -> f64 {
        self.residual.iter().map(|own| own * own).sum()
    }

    /// Column of the cosine of a harmonic.
    pub(super) fn column(&self, wave: usize) -> usize {
        self.design.first() + 2 * wave
    }
}
