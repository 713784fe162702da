//! Measures how close a correction comes to the limits of its axes, cycle by cycle.

use trueaxis::machine::Limits;

/// Corrections of `N` axes, cycle by cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LimitWatch<const N: usize> {
    limits: [Option<Limits>; N],
    period_s: f64,
    /// Correction in the previous cycle, mm or degrees.
    pub(crate) last: [f64; N],
    steps: [f64; N],
    /// Largest step in a cycle.
    pub(crate) largest_step: f64,
    /// Largest velocity or acceleration, as a share of its limit.
    pub(crate) of_limits: f64,
}

impl<const N: usize> LimitWatch<N> {
    /// Starts from a correction of zero at rest.
    pub(crate) fn new(limits: [Option<Limits>; N], period_s: f64) -> LimitWatch<N> {
        let zero = [0.0; N];
        LimitWatch { limits, period_s, last: zero, steps: zero, largest_step: 0.0, of_limits: 0.0 }
    }

    /// Records the correction of the next cycle.
    pub(crate) fn take(&mut self, correction: [f64; N]) {
        for slot in 0..N {
            let step = correction[slot] - self.last[slot];
            if let Some(limits) = self.limits[slot] {
                let velocity = step.abs() / self.period_s / limits.slope_per_s;
                let acceleration =
                    (step - self.steps[slot]).abs() / self.period_s / self.period_s / limits.acceleration_per_s2;
                self.of_limits = self.of_limits.max(velocity).max(acceleration);
            }
            self.largest_step = self.largest_step.max(step.abs());
            self.steps[slot] = step;
        }
        self.last = correction;
    }
}
