//! The gauge, built once, and its cycle of three stages.

use super::infeed::Infeed;
use super::plan::Plan;
use super::resample::Resampler;
use super::{Arm, Band, Cycle, Followed, Gain, GaugeSettings, GaugeState, Probes};
use crate::error::{ConfigError, Field};
use crate::part::{self, Part};
use crate::real::Real;

/// The immutable half: angles, multipliers, limits. `N` is the number of points of a revolution.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Gauge<R, const N: usize> {
    pub(super) slices_per_cycle: u8,
    pub(super) resampler: Resampler<R, N>,
    pub(super) infeed: Option<Infeed<R>>,
    pub(super) arm: Option<Arm>,
    pub(super) gain: Gain,
    pub(super) band: Band,
    pub(super) noise_gain_limit: f64,
    pub(super) plan: Plan<R, N>,
    _part: part::Gauge,
}

impl<R: Real, const N: usize> Gauge<R, N> {
    /// Checks the settings once and precomputes the values that a cycle needs.
    ///
    /// # Errors
    /// The first setting that is wrong, with the value found and the one needed; `N` different from the settings' number of
    /// points.
    #[doc(hidden)]
    pub fn build(settings: &GaugeSettings, period_ns: u32) -> Result<Self, ConfigError> {
        let part = part::GAUGE.ok_or_else(|| ConfigError::left_out(Part::Gauge, Field::Points))?;
        if usize::from(settings.points) != N {
            return Err(ConfigError::new(Field::Points, f64::from(settings.points), "the capacity of this build"));
        }
        if !(1_000..=100_000_000).contains(&period_ns) {
            return Err(ConfigError::new(Field::Period, f64::from(period_ns) * 1e-9, "1e-6 s to 0.1 s"));
        }
        let gain = settings.check()?;
        let period_s = f64::from(period_ns) * 1e-9;
        Ok(Gauge {
            resampler: Resampler::new(settings, &gain, period_s),
            plan: Plan::new(settings, &gain),
            infeed: settings.infeed.as_ref().map(|infeed| Infeed::new(infeed, period_s)),
            arm: settings.arm.map(|arm| arm.lengths),
            gain,
            band: settings.band,
            noise_gain_limit: settings.noise_gain_limit,
            slices_per_cycle: settings.slices_per_cycle,
            _part: part,
        })
    }

    /// A fresh state.
    pub fn start(&self) -> GaugeState<R, N> {
        GaugeState::new()
    }

    /// Resets a state in place: the gauge neither measures nor corrects the infeed until another revolution is whole,
    /// and the wheel is that of the settings.
    pub fn restart(&self, state: &mut GaugeState<R, N>) {
        *state = GaugeState::new();
    }

    /// Gain of the probes for each harmonic.
    #[doc(hidden)]
    pub fn gain(&self) -> &Gain {
        &self.gain
    }

    /// Harmonics of the profile that the gauge separates.
    #[doc(hidden)]
    pub fn band(&self) -> Band {
        self.band
    }

    /// Whether the gauge suppresses a harmonic of the band because of its noise gain.
    #[doc(hidden)]
    pub fn is_suppressed(&self, harmonic: usize) -> bool {
        let noise_gain = self.gain.noise_gain(harmonic);
        noise_gain.is_nan() || noise_gain > self.noise_gain_limit
    }

    /// Most cycles that the work on a revolution takes; revolutions that end sooner are skipped whole.
    pub fn cycles_of_work(&self) -> usize {
        self.plan.slices().div_ceil(usize::from(self.slices_per_cycle.max(1)))
    }

    /// Slot of the axis that the infeed correction moves.
    pub fn infeed_slot(&self) -> Option<usize> {
        self.infeed.as_ref().map(|infeed| infeed.slot)
    }

    /// Sets the wheel's radius R_S, mm (wear, dressing); takes effect with the next revolution that is processed.
    ///
    /// # Errors
    /// The gauge has no arm, or the linkage cannot close.
    pub fn set_wheel(&self, state: &mut GaugeState<R, N>, wheel_mm: f64) -> Result<(), ConfigError> {
        let Some(arm) = self.arm else {
            return Err(ConfigError::new(Field::ArmWheel, wheel_mm, "a gauge with a following arm"));
        };
        state.work.ratio = Some(R::of(Arm { wheel_mm, ..arm }.ratio()?));
        Ok(())
    }

    /// Processes one servo cycle; cannot fail, panic, allocate, block, or loop without a fixed bound.
    ///
    /// `followed` states how far the drive followed the infeed of the previous cycle; the law learns only from
    /// revolutions in which it followed. The three stages can be called separately, for instance [`Gauge::work`] in the
    /// background.
    #[inline]
    pub fn update(&self, state: &mut GaugeState<R, N>, probes: &Probes<R>, followed: Followed) -> Cycle<R> {
        let flags = self.sample(state, probes, followed);
        let finished = self.work(state);
        Cycle { infeed: self.infeed(state), flags, finished }
    }

    /// Third stage: infeed correction in this cycle, mm in the sense of its axis.
    #[inline]
    pub fn infeed(&self, state: &mut GaugeState<R, N>) -> R {
        let (Some(infeed), Some(theta)) = (&self.infeed, state.resampler.theta()) else {
            // When θ is known again, its change does not show the speed.
            state.speed.theta = None;
            return R::ZERO;
        };
        let speed = &mut state.speed;
        if let Some(before) = speed.theta {
            let change = R::of_i32(theta.wrapping_sub(before) as i32);
            speed.per_cycle += (change - speed.per_cycle) * R::of(1.0 / 64.0);
        }
        speed.theta = Some(theta);
        if state.work.is_cleared() {
            return R::ZERO;
        }
        infeed.at(&state.work.correction, |index| state.work.cos_beta(index), theta, speed.per_cycle)
    }
}
