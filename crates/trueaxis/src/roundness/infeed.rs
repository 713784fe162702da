//! Infeed correction of the next revolutions from the separated profile.
//!
//! An integrating law over the surface, with one update per processed revolution:
//!
//! ```text
//! c(θ) ← c(θ) + g r̂(θ)                  r̂: harmonics of the profile in the band, suppressed ones left out
//! infeed = c(θ + ψ + ωτ) / cos β         ψ from probe 1 to the wheel's contact, τ delay of the drive
//! ```
//!
//! r > 0 is high and needs more infeed. θ is the angle over the surface, α + β, not the spindle's. A revolution in which the
//! correction was limited, or after which it would exceed its bound, changes nothing.

#![deny(clippy::indexing_slicing)]

use super::settings::InfeedSettings;
use crate::real::Real;

/// Infeed settings in the form that a cycle needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Infeed<R> {
    /// Slot of the axis (for a linear axis, its index).
    pub(super) slot: usize,
    /// g.
    pub(super) gain: R,
    /// Largest |c|, µm.
    pub(super) limit: R,
    /// mm of command per µm of infeed, with the sign of the axis.
    scale: R,
    /// ψ in 2^−32 turns.
    contact: u32,
    /// τ in cycles.
    lead: R,
}

impl<R: Real> Infeed<R> {
    pub(super) fn new(settings: &InfeedSettings, period_s: f64) -> Self {
        let turns = settings.contact_deg / 360.0;
        Infeed {
            slot: settings.axis.index(),
            gain: R::of(settings.gain),
            limit: R::of(settings.limit_um),
            scale: R::of(f64::from(settings.direction) * 1e-3),
            contact: ((turns - libm::floor(turns)) * 4_294_967_296.0) as u64 as u32,
            lead: R::of(settings.drive_delay_s / period_s),
        }
    }

    /// Infeed in this cycle, mm in the sense of the axis.
    ///
    /// Between the points c is the cubic through the nearest four: its error is 2e-4 for harmonic N/20, 0.9 % for N/8.
    #[inline(always)]
    pub(super) fn at<const N: usize>(&self, table: &[R; N], cos_beta: impl Fn(usize) -> R, theta: u32, speed: R) -> R {
        let shift = u32::BITS - N.trailing_zeros();
        let lead = (self.lead * speed).to_i32();
        let angle = theta.wrapping_add(self.contact).wrapping_add_signed(lead);
        let index = (angle >> shift) as usize;
        let within = angle & (1u32 << shift).wrapping_sub(1);
        let t = R::of_i32(within as i32) * R::of(1.0 / (1u64 << shift) as f64);
        let value = |offset: usize| table.get(index.wrapping_add(offset) & (N - 1)).copied().unwrap_or(R::ZERO);
        let [before, low, high, after] = [value(N - 1), value(0), value(1), value(2)];
        // Lagrange's cubic through −1, 0, 1, 2.
        let sixth = R::of(1.0 / 6.0);
        let outer = (after - before) * sixth + (low - high) * R::HALF;
        let bend = (before + high) * R::HALF - low;
        let slope = high - low - bend - outer;
        let c = low + t * (slope + t * (bend + t * outer));
        c * self.scale / cos_beta((theta >> shift) as usize)
    }
}
