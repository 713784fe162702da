//! Errors that repeat within a pitch: of a screw, a motor, a gear or a rack, told apart from the axis' slow error.
//!
//! ```text
//! e(q) = S(q) + Σ_P Σ_h a_h cos(2πhq/P) + b_h sin(2πhq/P)
//! ```
//!
//! q: position of the axis; P: a period, in the unit of q; S: a cubic spline, one for each direction of travel, with bends at
//! least 2 P apart, as many as the Bayesian information criterion justifies. Spline and harmonics are fitted together by least
//! squares. A harmonic is kept if the chance of one as large in noise is that of three standard deviations; each direction gets
//! its own harmonics where they differ by as much. On a circle, a ballbar reads the error of either axis by its share:
//!
//! ```text
//! Δr = S(θ) + cos θ E_x(x) + sin θ E_y(y)        x = x_c + R cos θ
//! ```
//!
//! A period is then a chirp in θ, and still one wave in x. S is a spline over θ, with the steps that lost motion makes.
//!
//! Standard errors come from the residual: its mean square, or where it is larger, its power near the harmonic's frequency,
//! which drift and vibration raise.
//!
//! Refused: scans of fewer than three periods, fewer than four points in a period of a harmonic, periods closer together than
//! the scan resolves (1/L in frequency).
//!
//! Sources: G. Schwarz, Estimating the dimension of a model, Annals of Statistics 6 (1978), 10.1214/aos/1176344136 (selection
//! of the bends); P. Vaníček, Further development and properties of the spectral analysis by least squares, Astrophysics and
//! Space Science 12 (1971), 10.1007/BF00656134 (harmonics and other terms in one fit over uneven points).

mod design;
mod fit;
mod refused;
mod sampling;
mod slow;
mod spectrum;

pub use fit::{identify, least_amplitude};
pub use refused::{AliasOf, PeriodicRefusal};
pub use spectrum::{Spectrum, spectrum};

use std::vec::Vec;

/// Most harmonics of a period: as many as a machine has.
pub const MOST_HARMONICS: usize = trueaxis::machine::PERIODIC_HARMONICS;
/// Fewest periods in a scan.
pub const LEAST_PERIODS: f64 = 3.0;
/// Fewest points in a period of the highest harmonic.
pub const LEAST_POINTS: f64 = 4.0;

/// An axis while a reading is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Position of the axis, mm or degrees.
    pub position: f64,
    /// Whether the axis moves in negative direction.
    pub is_negative: bool,
    /// Share of the axis' error in the reading: 1 of a scan, cos θ or sin θ of a circle.
    pub share: f64,
}

/// One reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// The axis whose periods are sought.
    pub own: Place,
    /// The second axis of a circle, whose errors of the same periods are fitted too; `None` for a scan.
    pub other: Option<Place>,
    /// Argument of the slow error: position of a scan, angle on a circle.
    pub along: f64,
    /// Number of the slow error that the reading contains: 0 for positive travel or counterclockwise, 1 for the reverse.
    pub pass: usize,
    /// The reading, actual − commanded, µm or µrad.
    pub error: f64,
}

/// Error of a harmonic: a cos(2πhq/P) + b sin(2πhq/P).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Harmonic {
    /// h, from 1.
    pub number: usize,
    /// a and b, µm or µrad; zero if the harmonic is not kept.
    pub value: [f64; 2],
    /// Standard errors of a and b; of a harmonic that is not kept, the scatter that it was compared with.
    pub standard_error: [f64; 2],
    /// Whether the harmonic exceeds its scatter.
    pub is_kept: bool,
}

impl Harmonic {
    /// Returns the amplitude √(a² + b²).
    pub fn amplitude(&self) -> f64 {
        self.value[0].hypot(self.value[1])
    }

    /// Returns the phase φ of A cos(2πhq/P − φ), rad.
    pub fn phase_rad(&self) -> f64 {
        self.value[1].atan2(self.value[0])
    }
}

/// One period.
#[derive(Clone, Debug, PartialEq)]
pub struct Period {
    /// The period, mm or degrees.
    pub period: f64,
    /// Harmonics that were tried, from 1, in positive travel; of both directions if `reverse` is `None`.
    pub forward: Vec<Harmonic>,
    /// Harmonics in negative travel, if the directions differ.
    pub reverse: Option<Vec<Harmonic>>,
    /// Harmonics that were not tried, because they coincide with one of another period: the other's period and harmonic.
    pub coincide: Vec<(usize, (f64, usize))>,
}

impl Period {
    /// Returns the highest harmonic that is kept, 0 if none is.
    pub fn highest(&self) -> usize {
        let all = self.forward.iter().chain(self.reverse.iter().flatten());
        all.filter(|own| own.is_kept).map(|own| own.number).max().unwrap_or(0)
    }

    /// Returns the error at a position, µm or µrad.
    pub fn error(&self, position: f64, is_negative: bool) -> f64 {
        let own = if is_negative { self.reverse.as_ref().unwrap_or(&self.forward) } else { &self.forward };
        let wave = |own: &Harmonic| {
            let (sine, cosine) = (std::f64::consts::TAU * own.number as f64 * position / self.period).sin_cos();
            own.value[0] * cosine + own.value[1] * sine
        };
        own.iter().map(wave).sum()
    }

    /// Returns the largest less the smallest error over one period, in one direction.
    pub fn peak_to_valley(&self, is_negative: bool) -> f64 {
        let points = 64 * self.highest().max(1);
        let errors = (0..points).map(|k| self.error(self.period * k as f64 / points as f64, is_negative));
        let [low, high] =
            errors.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], own| [low.min(own), high.max(own)]);
        high - low
    }
}

/// A wave that the residual contains besides the periods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Left {
    /// Its period, mm or degrees.
    pub period: f64,
    /// Its amplitude, µm or µrad.
    pub amplitude: f64,
}

/// Result of [`identify`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Found {
    /// The periods, in the order given.
    pub periods: Vec<Period>,
    /// Bends of the slow error.
    pub bends: usize,
    /// Range of the positions, mm or degrees.
    pub length: f64,
    /// Distance between neighbouring points, mm or degrees.
    pub spacing: f64,
    /// Slow error and residual of each reading, in their order, µm or µrad.
    pub slow: Vec<f64>,
    /// Residual of each reading.
    pub residual: Vec<f64>,
    /// Root mean square that remains of the record without harmonics: slow error fitted alone.
    pub before: f64,
    /// Root mean square of the residual.
    pub left: f64,
    /// Share of the mean square of `before` that the harmonics explain.
    pub explained: f64,
    /// Readings less unknowns.
    pub degrees_of_freedom: usize,
    /// Largest factor by which the residual's power near a harmonic widens its standard errors; 1 for white noise.
    pub widened: f64,
    /// The strongest wave of the residual shorter than two of the longest period, if noise does not explain it.
    pub remains: Option<Left>,
}
