//! Error motion of the spindle over several revolutions (ISO 230-7).
//!
//! Of the motion R(θ) of the workpiece's centre in one direction, over M revolutions:
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
pub struct ErrorMotion<R> {
    /// Synchronous error motion value, without the once-per-revolution part.
    pub synchronous_um: R,
    /// Asynchronous error motion value; 0 over a single revolution.
    pub asynchronous_um: R,
    /// Amplitudes of cos θ and sin θ: eccentricity and fundamental, which cannot be told apart.
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

/// One direction, point by point, over the revolutions of a window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion<R, const N: usize> {
    sum: [R; N],
    low: [R; N],
    high: [R; N],
    /// Σ m, Σ m cos θ, Σ m sin θ; then a0, a, b.
    fundamental: [R; 3],
    /// Ranges found so far: of s, and of everything.
    synchronous: [R; 2],
    total: [R; 2],
    asynchronous: R,
}

impl<R: Real, const N: usize> Motion<R, N> {
    pub(super) const fn new() -> Self {
        Motion {
            sum: [R::ZERO; N],
            low: [R::ZERO; N],
            high: [R::ZERO; N],
            fundamental: [R::ZERO; 3],
            synchronous: [R::ZERO; 2],
            total: [R::ZERO; 2],
            asynchronous: R::ZERO,
        }
    }

    /// Adds a point of a revolution; the first revolution of a window begins it.
    #[inline(always)]
    pub(super) fn add(&mut self, index: usize, value: R, first: bool) {
        let (Some(sum), Some(low), Some(high)) =
            (self.sum.get_mut(index), self.low.get_mut(index), self.high.get_mut(index))
        else {
            return;
        };
        *sum = value + if first { R::ZERO } else { *sum };
        *low = if first { value } else { R::min(value, *low) };
        *high = if first { value } else { R::max(value, *high) };
    }

    /// Before the points of a full window are evaluated.
    #[inline(always)]
    pub(super) fn begin(&mut self) {
        self.fundamental = [R::ZERO; 3];
        self.synchronous = [R::MAX, -R::MAX];
        self.total = [R::MAX, -R::MAX];
        self.asynchronous = R::ZERO;
    }

    /// First pass: mean and first harmonic of the mean contour, width of the bundle.
    #[inline(always)]
    pub(super) fn evaluate(&mut self, index: usize, [cos, sin]: [R; 2], per_revolution: R) {
        let (Some(sum), Some(low), Some(high)) = (self.sum.get_mut(index), self.low.get(index), self.high.get(index))
        else {
            return;
        };
        let mean = *sum * per_revolution;
        *sum = mean;
        let [a0, a, b] = &mut self.fundamental;
        *a0 += mean;
        *a += mean * cos;
        *b += mean * sin;
        self.asynchronous = R::max(*high - *low, self.asynchronous);
    }

    /// Between the passes: sums to amplitudes.
    #[inline(always)]
    pub(super) fn express(&mut self) {
        let scale = R::of(1.0 / N as f64);
        let [a0, a, b] = self.fundamental;
        self.fundamental = [a0 * scale, R::TWO * a * scale, R::TWO * b * scale];
    }

    /// Second pass: the remainder without mean and first harmonic.
    #[inline(always)]
    pub(super) fn range(&mut self, index: usize, [cos, sin]: [R; 2]) {
        let (Some(mean), Some(low), Some(high)) = (self.sum.get(index), self.low.get(index), self.high.get(index))
        else {
            return;
        };
        let [a0, a, b] = self.fundamental;
        let fundamental = a0 + a * cos + b * sin;
        let left = *mean - fundamental;
        let [least, most] = self.synchronous;
        self.synchronous = [R::min(left, least), R::max(left, most)];
        let [least, most] = self.total;
        self.total = [R::min(*low - fundamental, least), R::max(*high - fundamental, most)];
    }

    /// Results of both passes.
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
