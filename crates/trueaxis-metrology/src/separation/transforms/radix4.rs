//! Transforms by one complex transform of rustfft: powers of two.

use realfft::num_complex::Complex;
use rustfft::algorithm::Radix4;
use rustfft::algorithm::butterflies::{Butterfly4, Butterfly8};
use rustfft::{Fft, FftDirection};
use std::sync::Arc;
use trueaxis::error::{ConfigError, Field};

pub(in crate::separation) struct Transforms {
    points: usize,
    transform: Radix4<f64>,
}

impl Transforms {
    pub(in crate::separation) fn new(points: usize) -> Result<Transforms, ConfigError> {
        if !points.is_power_of_two() || points < 8 {
            return Err(ConfigError::new(Field::Points, points as f64, "a power of two of at least 8 in a browser"));
        }
        let power = points.trailing_zeros();
        let direction = FftDirection::Forward;
        // The smallest innermost transforms; the others are large.
        let (base, inner): (u32, Arc<dyn Fft<f64>>) = match power % 2 {
            0 => (2, Arc::new(Butterfly4::new(direction))),
            _ => (3, Arc::new(Butterfly8::new(direction))),
        };
        Ok(Transforms { points, transform: Radix4::new_with_base((power - base) / 2, inner) })
    }

    /// Length of the memory for both directions.
    pub(in crate::separation) fn scratch(&self) -> usize {
        self.points + self.transform.get_inplace_scratch_len()
    }

    /// Computes the spectrum of a real series.
    pub(in crate::separation) fn forward(
        &self,
        real: &mut [f64],
        spectrum: &mut [Complex<f64>],
        scratch: &mut [Complex<f64>],
    ) {
        let (all, scratch) = scratch.split_at_mut(self.points);
        for (to, value) in all.iter_mut().zip(real) {
            *to = Complex::new(*value, 0.0);
        }
        self.transform.process_with_scratch(all, scratch);
        for (to, value) in spectrum.iter_mut().zip(all) {
            *to = *value;
        }
    }

    /// Computes the real series of amplitudes; those of mean and Nyquist frequency are real. A real series is the transform of
    /// the conjugate amplitudes.
    pub(in crate::separation) fn backward(
        &self,
        amplitudes: &mut [Complex<f64>],
        series: &mut [f64],
        scratch: &mut [Complex<f64>],
    ) {
        let (all, scratch) = scratch.split_at_mut(self.points);
        for (to, value) in all.iter_mut().zip(amplitudes.iter()) {
            *to = value.conj();
        }
        for (to, value) in all.iter_mut().rev().zip(amplitudes.iter().skip(1)).take(self.points / 2 - 1) {
            *to = *value;
        }
        self.transform.process_with_scratch(all, scratch);
        for (to, value) in series.iter_mut().zip(all) {
            *to = value.re;
        }
    }
}
