//! Iterative learning along a repeated path: the residual contour error of one part corrects the next.
//!
//! With e the contour error (tip − foot, machine directions) and u the correction over path length, from part to part
//!
//! ```text
//! u  <-  f u − L Q e         f forgetting, L gain, Q a low-pass without phase, cut-off wavelength λ_c
//! e   =  e₀ + P u            P: response of drives and contour feedback to a correction
//! ```
//!
//! so that each part moves the component of e at wavelength λ toward (1 − f) e₀/(1 − f + L Q P) by the factor `|f − L Q P|`
//! ([`Law::contraction`]). The error falls if that factor is below 1: for all plants with the phase of P within 90° and |P| <
//! 2/L up to the cut-off, and beyond it if L Q |P| < 1 − f, whatever the phase. With the default gain of 0.7 the factor is
//! 0.02 to 0.56 for plants of 0.6 to 1.4. Forgetting 2 % per part leaves 3 % of a constant error, and removes corrections of
//! errors that no longer recur.
//!
//! The record is resampled to equidistant nodes, averaging the errors near each node, which also reduces noise; the correction
//! fades to zero within a cut-off of either end.
//!
//! Sources: S. Arimoto, S. Kawamura, F. Miyazaki, Bettering operation of robots by learning, J. Robotic Systems 1 (1984),
//! 10.1002/rob.4620010203 (the law); D. Bristow, M. Tharayil, A. Alleyne, A survey of iterative learning control, IEEE
//! Control Systems 26 (2006), 10.1109/MCS.2006.1636313 (Q and the condition); ISO 16610-21 (the Gaussian filter).

mod error;
mod lesson;
mod low_pass;
mod resample;
mod table;

pub use error::NotLearned;
pub use lesson::{Identity, Lesson};
pub use low_pass::{low_pass, transmission};
pub use resample::{GAP_OF_CUTOFF, LARGEST_ERROR_MM, MeasuredError, Resampled, resample};
pub use table::{MOST_NODES, encode};

use nalgebra::Complex;
use std::vec::Vec;

/// Default gain L.
pub const DEFAULT_GAIN: f64 = 0.7;
/// Default forgetting factor f.
pub const DEFAULT_FORGET: f64 = 0.98;
/// Default cut-off wavelength, mm.
pub const DEFAULT_CUTOFF_MM: f64 = 0.4;
/// Nodes per cut-off wavelength: the polygon through a wave at the cut-off is within 2 % of its amplitude.
pub const NODES_IN_CUTOFF: f64 = 16.0;

/// Learning law from one part to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// L, above 0 and below 2 (from 2 on, even a plant of gain 1 oscillates from part to part).
    pub gain: f64,
    /// f, above 0 to 1; 1 forgets nothing.
    pub forget: f64,
    /// Wavelength λ_c that Q transmits by half, mm, 0.01 to 1000.
    pub cutoff_mm: f64,
}

impl Default for Law {
    fn default() -> Self {
        Law { gain: DEFAULT_GAIN, forget: DEFAULT_FORGET, cutoff_mm: DEFAULT_CUTOFF_MM }
    }
}

impl Law {
    /// Refuses values out of range.
    ///
    /// # Errors
    /// The first value out of range, with its range.
    pub fn check(&self) -> Result<(), NotLearned> {
        let setting = |key, found, needed| Err(NotLearned::Setting { key, found, needed });
        if !(self.gain > 0.0 && self.gain < 2.0) {
            return setting("gain", self.gain, "above 0 and below 2");
        }
        if !(self.forget > 0.0 && self.forget <= 1.0) {
            return setting("forget", self.forget, "above 0, at most 1");
        }
        if !(0.01..=1000.0).contains(&self.cutoff_mm) {
            return setting("cutoff-mm", self.cutoff_mm, "0.01 to 1000");
        }
        Ok(())
    }

    /// Returns the spacing of the nodes on a path of this length, mm: at most a sixteenth of the cut-off, a whole number of
    /// nm, with the last node at the path's end or less than a spacing beyond it.
    pub fn spacing_mm(&self, length_mm: f64) -> f64 {
        let most = self.cutoff_mm / NODES_IN_CUTOFF;
        let even = length_mm / (length_mm / most).ceil().max(1.0);
        (even * 1e6).ceil().max(1.0) * 1e-6
    }

    /// Returns the factor `|f − L Q P|` by which an error of wavelength `wavelength_mm` shrinks from part to part, with P the
    /// plant's response there; below 1 the error falls.
    pub fn contraction(&self, wavelength_mm: f64, plant: Complex<f64>) -> f64 {
        (self.forget - plant * (self.gain * transmission(wavelength_mm, self.cutoff_mm))).norm()
    }

    /// Computes the next part's correction from `before` (`None`: zero) and the errors of the part made with it, both at nodes
    /// `spacing_mm` apart; mm. It is zero at both ends and fades in over a cut-off wavelength.
    ///
    /// Cost: some forty multiplications per node and direction at the default spacing.
    ///
    /// # Errors
    /// Values of the law out of range; a previous correction with another number of nodes.
    pub fn update(
        &self,
        before: Option<&[[f64; 3]]>,
        errors_mm: &[[f64; 3]],
        spacing_mm: f64,
    ) -> Result<Vec<[f64; 3]>, NotLearned> {
        self.check()?;
        if let Some(before) = before.filter(|before| before.len() != errors_mm.len()) {
            return Err(NotLearned::Nodes { found: before.len(), needed: errors_mm.len() });
        }
        let filtered = low_pass(errors_mm, spacing_mm, self.cutoff_mm);
        let last = errors_mm.len().saturating_sub(1);
        let faded = filtered.iter().enumerate().map(|(k, error)| {
            let old = before.and_then(|before| before.get(k)).copied().unwrap_or_default();
            let fade = fade(k.min(last - k) as f64 * spacing_mm / self.cutoff_mm);
            core::array::from_fn(|i| fade * (self.forget * old[i] - self.gain * error[i]))
        });
        Ok(faded.collect())
    }
}

/// Smooth transition from 0 to 1, at `share` of the way.
fn fade(share: f64) -> f64 {
    let t = share.min(1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests;
