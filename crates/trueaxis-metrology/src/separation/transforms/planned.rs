//! Transforms by realfft: any number of points, half the work of complex ones.

use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use std::sync::Arc;
use trueaxis::error::ConfigError;

pub(in crate::separation) struct Transforms {
    forward: Arc<dyn RealToComplex<f64>>,
    backward: Arc<dyn ComplexToReal<f64>>,
}

impl Transforms {
    pub(in crate::separation) fn new(points: usize) -> Result<Transforms, ConfigError> {
        let mut planner = RealFftPlanner::new();
        Ok(Transforms { forward: planner.plan_fft_forward(points), backward: planner.plan_fft_inverse(points) })
    }

    /// Length of the memory for both directions.
    pub(in crate::separation) fn scratch(&self) -> usize {
        self.forward.get_scratch_len().max(self.backward.get_scratch_len())
    }

    /// Computes the spectrum of a real series, which is overwritten.
    pub(in crate::separation) fn forward(
        &self,
        real: &mut [f64],
        spectrum: &mut [Complex<f64>],
        scratch: &mut [Complex<f64>],
    ) {
        let done = self.forward.process_with_scratch(real, spectrum, scratch);
        debug_assert!(done.is_ok(), "every length is the planner's");
    }

    /// Computes the real series of amplitudes, which are overwritten; those of mean and Nyquist frequency are real.
    pub(in crate::separation) fn backward(
        &self,
        amplitudes: &mut [Complex<f64>],
        series: &mut [f64],
        scratch: &mut [Complex<f64>],
    ) {
        let done = self.backward.process_with_scratch(amplitudes, series, scratch);
        debug_assert!(done.is_ok(), "every length is the planner's");
    }
}
