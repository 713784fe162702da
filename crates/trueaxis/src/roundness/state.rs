//! A gauge's state from cycle to cycle, and its results.

use super::resample::ResamplerState;
use super::work::{Outcome, Revolution, Work};
use super::{Evaluation, GaugeFlags};
use crate::real::Real;

/// The mutable half: state from cycle to cycle, and the results. Large (17 N scalars): store it in a static.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GaugeState<R, const N: usize> {
    /// Index of the revolution being processed; the other of the two is being sampled.
    pub(super) worked: usize,
    pub(super) resampler: ResamplerState<R>,
    pub(super) sampling: Sampling<R>,
    pub(super) latest: Outcome<R>,
    pub(super) counts: Counts,
    pub(super) speed: Speed<R>,
    /// Drift of the weighted sum over the previous revolution.
    pub(super) drift: Option<R>,
    pub(super) work: Work<R, N>,
    pub(super) revolutions: [Revolution<R, N>; 2],
    /// Weighted sums of the three probes; for the revolution being processed, their spectrum.
    pub(super) sums: [[R; N]; 2],
}

/// Counts of whole revolutions by outcome.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counts {
    /// Sampled whole.
    pub sampled: u32,
    /// Evaluated.
    pub evaluated: u32,
    /// Skipped whole because the work on a previous one was not finished.
    pub skipped: u32,
    /// Discarded whole because of an event in [`GaugeFlags`].
    pub discarded: u32,
}

/// The revolution being sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sampling<R> {
    pub(super) running: bool,
    pub(super) points: usize,
    /// Records whether revolutions before it were skipped.
    pub(super) flags: GaugeFlags,
    /// Total of the weighted sums.
    pub(super) total: R,
    /// Mean of the weighted sums over the previous revolution, if that one was whole.
    pub(super) before: Option<R>,
    /// The cycle in which it began.
    pub(super) began: u32,
    /// Quarter of a turn of α, from 1 (0: unknown), the cycle in which it began, and the fewest and most cycles that a quarter
    /// took.
    pub(super) quarter: u32,
    pub(super) entered: u32,
    pub(super) fewest: u32,
    pub(super) most: u32,
    /// Numbers of cycles that the infeed law does not learn from: limited, and not followed or idle.
    pub(super) limited: u32,
    pub(super) ineffective: u32,
}

impl<R: Real> Sampling<R> {
    pub(super) const NEW: Sampling<R> = Sampling {
        running: false,
        points: 0,
        flags: GaugeFlags(0),
        total: R::ZERO,
        before: None,
        began: 0,
        quarter: 0,
        entered: 0,
        fewest: 0,
        most: 0,
        limited: 0,
        ineffective: 0,
    };

    /// Counts a cycle that the infeed law does not learn from.
    #[inline(never)]
    pub(super) fn count(&mut self, limited: bool) {
        let counter = if limited { &mut self.limited } else { &mut self.ineffective };
        *counter = counter.wrapping_add(1);
    }

    /// Whether α is still within the quarter of a turn being timed.
    #[inline(always)]
    pub(super) fn is_timed(&self, alpha: u32) -> bool {
        (alpha >> 30) + 1 == self.quarter
    }

    /// Tracks the speed by timing every quarter of a turn.
    pub(super) fn time(&mut self, alpha: u32, clock: u32) {
        // The first one seen is incomplete.
        if self.quarter != 0 {
            let took = clock.wrapping_sub(self.entered);
            self.fewest = if self.most == 0 { took } else { self.fewest.min(took) };
            self.most = self.most.max(took);
        }
        (self.quarter, self.entered) = ((alpha >> 30) + 1, clock);
    }
}

/// Speed of the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Speed<R> {
    /// θ in the last cycle in which it was known.
    pub(super) theta: Option<u32>,
    /// Change of θ per cycle, 2^−32 turns, smoothed over some 64 cycles.
    pub(super) per_cycle: R,
}

impl<R: Real, const N: usize> GaugeState<R, N> {
    /// The state before the first cycle. All of its bytes are zero, so a static of it takes no flash.
    #[allow(clippy::new_without_default)]
    pub const fn new() -> Self {
        GaugeState {
            resampler: ResamplerState::new(),
            revolutions: [Revolution::new(), Revolution::new()],
            sums: [[R::ZERO; N]; 2],
            worked: 0,
            sampling: Sampling::NEW,
            work: Work::new(),
            latest: Outcome::NONE,
            counts: Counts { sampled: 0, evaluated: 0, skipped: 0, discarded: 0 },
            speed: Speed { theta: None, per_cycle: R::ZERO },
            drift: None,
        }
    }

    /// Result of the latest evaluated revolution of this part. Like the results below, it is consistent only while no
    /// work is in progress ([`GaugeState::is_settled`]).
    pub fn latest(&self) -> Option<Evaluation<R>> {
        let Outcome { revolution, flags, peak_to_valley_um } = self.latest;
        let ([x, y], revolutions) = (self.work.error_motion, self.work.window);
        (revolution > 0).then_some(Evaluation { revolution, flags, peak_to_valley_um, x, y, revolutions })
    }

    /// Counts of whole revolutions so far.
    #[doc(hidden)]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Profile r of the latest revolution, µm, before the filter; consistent only while no work is in progress
    /// ([`GaugeState::is_settled`]).
    pub fn profile(&self) -> &[R; N] {
        self.work.profile()
    }

    /// Amplitudes of cos kθ and sin kθ in the profile, µm; zero outside the band, for suppressed harmonics, and from
    /// [`super::HARMONICS`] on.
    pub fn harmonic(&self, harmonic: usize) -> [R; 2] {
        self.work.harmonic(harmonic)
    }

    /// Motion of the centre in the latest revolution, R_X and R_Y, µm; valid while no work is in progress, until the next
    /// revolution is whole.
    pub fn motion(&self) -> [&[R; N]; 2] {
        let evaluated = &self.revolutions[self.worked & 1];
        [&evaluated.first, &evaluated.second]
    }

    /// Infeed correction over the surface, c(θ), µm.
    pub fn correction(&self) -> &[R; N] {
        &self.work.correction
    }

    #[inline(always)]
    pub(super) fn work_and_revolution(&mut self) -> (&mut Work<R, N>, &mut Revolution<R, N>) {
        (&mut self.work, &mut self.revolutions[self.worked & 1])
    }

    /// Whether no work is in progress: results then stay the same until the next revolution is whole.
    pub fn is_settled(&self) -> bool {
        self.work.is_idle()
    }
}
