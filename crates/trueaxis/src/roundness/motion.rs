//! Error motion of the spindle over several revolutions (ISO 230-7).
//!
//! For the motion R(θ) of the workpiece's centre in one direction, over M revolutions:
//!
//! ```text
//! m(θ) = mean over the revolutions       m(θ) = a0 + a cos θ + b sin θ + s(θ)
//! once per revolution: [a, b]            synchronous: range of s(θ)
//! asynchronous: max over θ of (max − min over the revolutions) of R(θ)
//! total: range over θ and revolutions of R(θ) − a0 − a cos θ − b sin θ
//! ```

#![deny(clippy::indexing_slicing)]

use crate::real::Real;
use serde::{Deserialize, Serialize};

/// Error motion in one direction, µm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(not(feature = "bench"), non_exhaustive)]
pub struct ErrorMotion<R> {
    /// Synchronous error motion value, without the once-per-revolution part.
    pub synchronous_um: R,
    /// Asynchronous error motion value; 0 over a single revolution.
    pub asynchronous_um: R,
    /// Amplitudes of cos θ and sin θ: eccentricity and fundamental, which cannot be distinguished.
    pub once_per_revolution_um: [R; 2],
    /// Total error motion value.
    pub total_um: R,
}

impl<R: Real> ErrorMotion<R> {
    pub(super) const NONE: ErrorMotion<R> = ErrorMotion {
        synchronous_um: R::ZERO,
        asynchronous_um: R::ZERO,
        once_per_revolution_um: [R::ZERO; 2],
        total_um: R::ZERO,
    };
}

/// Sum, smallest and largest value at a point in one direction, over the revolutions of a window.
pub(super) type Bundle<R> = [R; 3];

/// Adds a revolution's value; the first revolution of a window overwrites the bundle.
#[inline(always)]
pub(super) fn gather<R: Real>([sum, low, high]: Bundle<R>, value: R, first: bool) -> Bundle<R> {
    if first { [value; 3] } else { [value + sum, R::min(value, low), R::max(value, high)] }
}

/// One direction over the points of a full window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Direction<R> {
    /// Σ m, Σ m cos θ, Σ m sin θ; then a0, a, b.
    fundamental: [R; 3],
    /// Ranges found so far: of s, and of everything.
    synchronous: [R; 2],
    total: [R; 2],
    asynchronous: R,
}

impl<R: Real> Direction<R> {
    pub(super) const NEW: Direction<R> =
        Direction { fundamental: [R::ZERO; 3], synchronous: [R::ZERO; 2], total: [R::ZERO; 2], asynchronous: R::ZERO };

    /// Resets the direction before the points of a full window are evaluated.
    #[inline(always)]
    pub(super) fn begin(&mut self) {
        self.fundamental = [R::ZERO; 3];
        self.synchronous = [R::MAX, -R::MAX];
        self.total = [R::MAX, -R::MAX];
        self.asynchronous = R::ZERO;
    }

    /// First pass: mean and first harmonic of the mean contour, width of the bundle. Replaces the sum by the mean.
    #[inline(always)]
    pub(super) fn evaluate(&mut self, [sum, low, high]: &mut Bundle<R>, [cos, sin]: [R; 2], per_revolution: R) {
        let mean = *sum * per_revolution;
        *sum = mean;
        let [a0, a, b] = &mut self.fundamental;
        *a0 += mean;
        *a += mean * cos;
        *b += mean * sin;
        widen(&mut self.asynchronous, *high - *low);
    }

    /// Between the passes: converts sums to amplitudes.
    #[inline(always)]
    pub(super) fn express(&mut self, points: usize) {
        let scale = R::of(1.0 / points as f64);
        let [a0, a, b] = self.fundamental;
        self.fundamental = [a0 * scale, R::TWO * a * scale, R::TWO * b * scale];
    }

    /// Second pass: the remainder without mean and first harmonic.
    #[inline(always)]
    pub(super) fn range(&mut self, [mean, low, high]: Bundle<R>, [cos, sin]: [R; 2]) {
        let [a0, a, b] = self.fundamental;
        let fundamental = a0 + a * cos + b * sin;
        let [least, most] = &mut self.synchronous;
        deepen(least, mean - fundamental);
        widen(most, mean - fundamental);
        let [least, most] = &mut self.total;
        deepen(least, low - fundamental);
        widen(most, high - fundamental);
    }

    /// Combines the results of both passes.
    #[inline(always)]
    pub(super) fn result(&self) -> ErrorMotion<R> {
        let [_, a, b] = self.fundamental;
        let width = |[low, high]: [R; 2]| high - low;
        ErrorMotion {
            synchronous_um: width(self.synchronous),
            asynchronous_um: self.asynchronous,
            once_per_revolution_um: [a, b],
            total_um: width(self.total),
        }
    }
}

/// Keeps the largest value so far; it rarely grows, so it is rarely written.
#[inline(always)]
fn widen<R: Real>(most: &mut R, value: R) {
    if value > *most {
        *most = value;
    }
}

/// Keeps the smallest value so far.
#[inline(always)]
fn deepen<R: Real>(least: &mut R, value: R) {
    if value < *least {
        *least = value;
    }
}
