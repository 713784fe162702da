//! Errors that repeat within a period of an axis: screw, motor, gear tooth, worm.

use super::Axis;
use core::f64::consts::TAU;
use heapless::Vec;

/// Largest number of periods of a machine, all axes together.
pub const PERIODIC_CAPACITY: usize = 6;
/// Largest number of harmonics of a period.
pub const PERIODIC_HARMONICS: usize = 6;

/// Error of an axis that repeats with its position, added to the own error of its table:
///
/// ```text
/// E(q) = Σ_h a_h cos(2πhq/P) + b_h sin(2πhq/P)
/// ```
///
/// The phase follows the position q, so that a homed axis needs no index. In mm (degrees, in the sense of the table).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PeriodicSettings {
    /// The axis.
    pub axis: Axis,
    /// Period P, mm (deg). On a rotary axis that part of a turn which is nearest: [`PeriodicSettings::length`].
    pub period: f64,
    /// `[a_h, b_h]` of the harmonics 1, 2, … in positive travel, and in negative travel unless `reverse` states others.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub harmonics: Vec<[f64; 2], PERIODIC_HARMONICS>,
    /// `[a_h, b_h]` in negative travel; empty: the same as in positive travel.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub reverse: Vec<[f64; 2], PERIODIC_HARMONICS>,
}

impl PeriodicSettings {
    /// Harmonics in one direction of travel.
    pub fn travelling(&self, negative: bool) -> &[[f64; 2]] {
        if negative && self.is_two_sided() { &self.reverse } else { &self.harmonics }
    }

    /// Length of a period, mm (deg): of a rotary axis the whole part of a turn that is nearest to `period`.
    pub fn length(&self) -> f64 {
        if self.axis.is_rotary() { 360.0 / libm::round(360.0 / self.period) } else { self.period }
    }

    /// Whether the directions of travel differ.
    pub fn is_two_sided(&self) -> bool {
        !self.reverse.is_empty()
    }

    /// Number of the highest harmonic.
    pub fn highest(&self) -> usize {
        self.harmonics.len().max(self.reverse.len())
    }

    /// Error and its slope at a position, mm and mm/mm (deg, deg/deg).
    pub fn error_and_slope(&self, position: f64, negative: bool) -> [f64; 2] {
        let [mut error, mut slope] = [0.0; 2];
        for (number, [a, b]) in (1..).map(f64::from).zip(self.travelling(negative)) {
            let rate = TAU * number / self.length();
            let (sin, cos) = libm::sincos(rate * position);
            error += a * cos + b * sin;
            slope += rate * (b * cos - a * sin);
        }
        [error, slope]
    }

    /// Upper bound of |E| (`order` 0), of its slope (1) or curvature (2), mm per mm^order (deg): the sum over the harmonics.
    pub fn bound(&self, order: i32) -> f64 {
        [false, true].map(|negative| self.sum(self.travelling(negative), order)).into_iter().fold(0.0, f64::max)
    }

    /// Upper bound of the difference between the directions of travel, mm (deg).
    pub fn most_lost(&self) -> f64 {
        if !self.is_two_sided() {
            return 0.0;
        }
        let [mut forward, mut reverse] = [self.harmonics.iter(), self.reverse.iter()];
        let differences = (0..self.highest()).map(|_| {
            let [[a, b], [c, d]] = [forward.next(), reverse.next()].map(|pair| pair.copied().unwrap_or_default());
            libm::hypot(c - a, d - b)
        });
        differences.sum()
    }

    fn sum(&self, harmonics: &[[f64; 2]], order: i32) -> f64 {
        let amplitudes = harmonics.iter().map(|[a, b]| libm::hypot(*a, *b));
        let rates = (1..).map(f64::from).map(|number| TAU * number / self.length());
        amplitudes.zip(rates).map(|(amplitude, rate)| (0..order).fold(amplitude, |sum, _| sum * rate)).sum()
    }
}
