//! Roundness and spindle error, separated by three probes while the servo loop runs.
//!
//! ```text
//! probes ──────┐
//! spindle, arm ┴─► counter ─► resample ─► one revolution ─► transform, 1/G, inverse ─► profile ─► harmonics, LSC
//!                  counts      to θ        (the one before     in units of a fixed   └► R_X, R_Y ─► spindle error
//!                  to angles   θ = α + β    is worked on)      size, some a cycle    └► infeed of the next revolutions
//! ```
//!
//! Three displacement probes look at a turning workpiece from angles φ1 = 0, φ2, φ2 + φ3. Each reads the profile r under
//! it and the motion of the workpiece's centre:
//!
//! ```text
//! h1(θ) = r(θ)           + R_Y cos β            + R_X sin β
//! h2(θ) = r(θ + φ2)      + R_Y cos(φ2 + β)      + R_X sin(φ2 + β)
//! h3(θ) = r(θ + φ2 + φ3) + R_Y cos(φ2 + φ3 + β) + R_X sin(φ2 + φ3 + β)
//! ```
//!
//! Weighted as in [`Gain`] the three sum to something that the centre's motion is not in; divided by G in the frequency
//! domain it is the profile; and what the profile leaves of two readings is the motion:
//!
//! ```text
//! R_X = [cos β (h2 − r(θ+φ2)) − cos(φ2+β) (h1 − r(θ))] / sin φ2
//! R_Y = [sin(φ2+β) (h1 − r(θ)) − sin β (h2 − r(θ+φ2))] / sin φ2
//! ```
//!
//! Y lies along probe 1 at β = 0. Lengths here are µm, angles at the interface degrees.
//!
//! [`Roundness`] is the immutable half, built once; [`RoundnessState`] the other. [`Roundness::update`] takes a cycle's
//! readings in bounded time; a revolution is evaluated while the next one is sampled. A revolution in which anything was
//! wrong is discarded whole ([`Flags`]), one that comes while the work is not finished is skipped whole; both are counted.
//!
//! Source: Tian Y., Li M., CN1927535 (arm and separation; R_Y corrected here: the published one does not solve the
//! equations); ISO 12181-1, ISO 16610-21 (roundness, filter); ISO 230-7 (spindle).

mod angles;
mod arm;
#[cfg(feature = "std")]
pub mod circles;
mod counter;
pub mod filter;
mod flags;
mod infeed;
mod motion;
mod resample;
mod settings;
mod transform;
mod work;

pub use angles::{Band, Gain, ProbeAngles};
pub use arm::{Arm, arm_angle};
pub use flags::Flags;
pub use motion::ErrorMotion;
pub use settings::{
    ArmSettings, FEWEST_POINTS, InfeedSettings, MOST_COUNTS, MOST_POINTS, NOISE_GAIN_LIMIT, ProbeSettings,
    RoundnessSettings, SpindleEncoder, gain_limit,
};
pub use work::HARMONICS;

use crate::error::{ConfigError, Field};
use crate::real::Real;
use infeed::Infeed;
use resample::{Passed, Resampler, ResamplerState};
use work::{ARM_CHECKS, Plan, Revolution, Work};

/// Readings of one cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Probes<R> {
    /// Raw values of the three probes, in the unit of their gain.
    pub readings: [R; 3],
    /// Counts of the spindle's encoder, wrapping.
    pub spindle: i32,
    /// Counts latched by an index pulse since the last cycle; without a latch, the counts of this cycle.
    pub index: Option<i32>,
    /// Counts of the arm's encoder, 0 where the arm points along the line of centres; unused without an arm.
    pub arm: i32,
    /// Another workpiece: correction back to zero (through the limiter), evaluation of the spindle begun anew.
    pub new_part: bool,
}

/// What is known about one revolution.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Evaluation<R> {
    /// Counts whole revolutions that were sampled, from 1, wrapping.
    pub revolution: u32,
    /// What this revolution met.
    pub flags: Flags,
    /// Peak-to-valley roundness about the least-squares circle, after the filter if there is one, µm.
    pub peak_to_valley_um: R,
    /// Error motion along X (across probe 1), over the last full window.
    pub x: ErrorMotion<R>,
    /// Error motion along Y (along probe 1), over the last full window.
    pub y: ErrorMotion<R>,
    /// Revolutions in that window; 0 until one is full.
    pub revolutions: u16,
}

impl<R: Real> Evaluation<R> {
    const NO_MOTION: ErrorMotion<R> = ErrorMotion {
        synchronous_um: R::ZERO,
        asynchronous_um: R::ZERO,
        once_per_revolution_um: [R::ZERO; 2],
        total_um: R::ZERO,
    };

    const fn none() -> Self {
        Evaluation {
            revolution: 0,
            flags: Flags(0),
            peak_to_valley_um: R::ZERO,
            x: Self::NO_MOTION,
            y: Self::NO_MOTION,
            revolutions: 0,
        }
    }
}

/// What a cycle gives back.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Cycle<R> {
    /// Infeed correction, mm in the sense of its axis; 0 without one, or while θ is unknown.
    pub infeed: R,
    /// What this cycle met.
    pub flags: Flags,
    /// A revolution has just been evaluated.
    pub finished: bool,
}

/// The immutable half: angles, multipliers, limits. `N` is the number of points of a revolution.
#[derive(Clone, Copy, Debug)]
pub struct Roundness<R, const N: usize> {
    resampler: Resampler<R, N>,
    plan: Plan<R, N>,
    infeed: Option<Infeed<R>>,
    arm: Option<Arm>,
    gain: Gain,
    band: Band,
    noise_gain_limit: f64,
    units_per_cycle: u8,
}

/// The mutable half: what one cycle hands to the next, and the results. Large (15 N scalars): a static's place.
#[derive(Clone, Copy, Debug)]
pub struct RoundnessState<R, const N: usize> {
    resampler: ResamplerState<R>,
    revolutions: [Revolution<R, N>; 2],
    /// The second of them is being sampled.
    second: bool,
    sampling: Sampling,
    work: Work<R, N>,
    /// λ of the arm, as the wheel is now.
    ratio: R,
    latest: Evaluation<R>,
    counts: Counts,
}

/// How whole revolutions fared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counts {
    /// Sampled whole.
    pub sampled: u32,
    /// Evaluated.
    pub evaluated: u32,
    /// Skipped whole, because the work on one before was not finished.
    pub skipped: u32,
    /// Discarded whole, because of something in [`Flags`].
    pub discarded: u32,
}

/// The revolution that is being sampled.
#[derive(Clone, Copy, Debug)]
struct Sampling {
    running: bool,
    points: usize,
    flags: Flags,
    /// Sixteenth of a turn of α, cycles since it began, fewest and most cycles that one took.
    sixteenth: u32,
    elapsed: u32,
    fewest: u32,
    most: u32,
    /// Cycles, and those of them in which the infeed axis was limited.
    cycles: u32,
    limited: u32,
}

impl Sampling {
    const NEW: Sampling = Sampling {
        running: false,
        points: 0,
        flags: Flags(0),
        sixteenth: 0,
        elapsed: 0,
        fewest: u32::MAX,
        most: 0,
        cycles: 0,
        limited: 0,
    };

    /// Follows the speed by the time that every sixteenth of a turn takes.
    #[inline(always)]
    fn time(&mut self, alpha: u32) {
        self.elapsed = self.elapsed.saturating_add(1);
        let sixteenth = alpha >> 28;
        if sixteenth == self.sixteenth {
            return;
        }
        // The first one seen is not whole.
        if self.sixteenth != u32::MAX {
            self.fewest = self.fewest.min(self.elapsed);
            self.most = self.most.max(self.elapsed);
        }
        (self.sixteenth, self.elapsed) = (sixteenth, 0);
    }
}

impl<R: Real, const N: usize> RoundnessState<R, N> {
    /// Before the first cycle; fit for a static. The wheel's radius is that of the settings from the first cycle on.
    #[allow(clippy::new_without_default)]
    pub const fn new() -> Self {
        RoundnessState {
            resampler: ResamplerState::new(),
            revolutions: [Revolution::new(), Revolution::new()],
            second: false,
            sampling: Sampling::NEW,
            work: Work::new(),
            ratio: R::ZERO,
            latest: Evaluation::none(),
            counts: Counts { sampled: 0, evaluated: 0, skipped: 0, discarded: 0 },
        }
    }

    /// The latest revolution evaluated.
    pub fn latest(&self) -> Option<&Evaluation<R>> {
        (self.counts.evaluated > 0).then_some(&self.latest)
    }

    /// How whole revolutions fared so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Profile r of the latest revolution, µm, before the filter; whole while no work is under way
    /// ([`RoundnessState::is_settled`]).
    pub fn profile(&self) -> &[R; N] {
        &self.work.profile
    }

    /// Amplitudes of cos kθ and sin kθ in the profile, µm, k = 0 to 127; zero outside the band and where suppressed.
    pub fn harmonics(&self) -> &[[R; 2]; HARMONICS] {
        &self.work.harmonics
    }

    /// Motion of the centre in the latest revolution, R_X and R_Y, µm; while no work is under way and until the next
    /// revolution is whole.
    pub fn motion(&self) -> [&[R; N]; 2] {
        let [first, second] = &self.revolutions;
        let evaluated = if self.second { first } else { second };
        [&evaluated.first, &evaluated.second]
    }

    /// Infeed correction over the surface, c(θ), µm.
    pub fn correction(&self) -> &[R; N] {
        &self.work.correction
    }

    /// No work is under way: results do not change until the next revolution is whole.
    pub fn is_settled(&self) -> bool {
        self.work.is_idle()
    }
}

impl<R: Real, const N: usize> Roundness<R, N> {
    /// Checks the settings once and precomputes what a cycle needs.
    ///
    /// # Errors
    /// What is wrong, with the figure found and what is needed; `N` other than the settings' number of points.
    pub fn build(settings: &RoundnessSettings, period_ns: u32) -> core::result::Result<Self, ConfigError> {
        if usize::from(settings.points) != N {
            return Err(ConfigError::new(Field::Points, f64::from(settings.points), "the capacity of this build"));
        }
        if !(1_000..=100_000_000).contains(&period_ns) {
            return Err(ConfigError::new(Field::Period, f64::from(period_ns) * 1e-9, "1e-6 s to 0.1 s"));
        }
        let gain = settings.check()?;
        let period_s = f64::from(period_ns) * 1e-9;
        Ok(Roundness {
            resampler: Resampler::new(settings, &gain, period_s),
            plan: Plan::new(settings, &gain),
            infeed: settings.infeed.as_ref().map(|infeed| Infeed::new(infeed, period_s)),
            arm: settings.arm.map(|arm| arm.lengths),
            gain,
            band: settings.band,
            noise_gain_limit: settings.noise_gain_limit,
            units_per_cycle: settings.units_per_cycle,
        })
    }

    /// A state for the wheel's radius of the settings.
    pub fn start(&self) -> RoundnessState<R, N> {
        let mut state = RoundnessState::new();
        self.restart(&mut state);
        state
    }

    /// Makes a state new in its place, for one that is too large to be moved.
    pub fn restart(&self, state: &mut RoundnessState<R, N>) {
        *state = RoundnessState::new();
        let ratio = self.arm.and_then(|arm| arm.ratio().ok());
        state.ratio = R::of(ratio.unwrap_or(0.0));
    }

    /// What the probes see of each harmonic.
    pub fn gain(&self) -> &Gain {
        &self.gain
    }

    /// Harmonics of the profile that are separated.
    pub fn band(&self) -> Band {
        self.band
    }

    /// A harmonic of the band that is left out because of its noise gain.
    pub fn is_suppressed(&self, harmonic: usize) -> bool {
        let noise_gain = self.gain.noise_gain(harmonic);
        noise_gain.is_nan() || noise_gain > self.noise_gain_limit
    }

    /// Cycles that the work on a revolution takes at most; revolutions that are shorter are skipped whole in between.
    pub fn cycles_of_work(&self) -> usize {
        self.plan.units().div_ceil(usize::from(self.units_per_cycle.max(1)))
    }

    /// Place of the axis that the infeed correction moves.
    pub fn infeed_place(&self) -> Option<usize> {
        self.infeed.as_ref().map(|infeed| infeed.place)
    }

    /// Sets the wheel's radius R_S, mm (wear, dressing); not part of the step.
    ///
    /// # Errors
    /// There is no arm, or the linkage could not close.
    pub fn set_wheel(&self, state: &mut RoundnessState<R, N>, wheel_mm: f64) -> core::result::Result<(), ConfigError> {
        let Some(arm) = self.arm else {
            return Err(ConfigError::new(Field::Arm, wheel_mm, "a gauge with a following arm"));
        };
        state.ratio = R::of(Arm { wheel_mm, ..arm }.ratio()?);
        Ok(())
    }

    /// One servo cycle: cannot fail, panic, allocate, block, or loop without a fixed bound.
    ///
    /// `limited` tells whether the infeed axis' correction was limited in the cycle before.
    #[inline]
    pub fn update(&self, state: &mut RoundnessState<R, N>, probes: &Probes<R>, limited: bool) -> Cycle<R> {
        if probes.new_part {
            state.work.clear();
            state.sampling = Sampling::NEW;
        }
        let mut flags = Flags::default();
        let passed = self.resampler.update(&mut state.resampler, probes, &mut flags);
        self.sample(state, &passed, limited, &mut flags);
        let finished = self.work(state);
        Cycle { infeed: self.infeed(state), flags, finished }
    }

    /// Keeps the points passed; hands a whole revolution over.
    #[inline(always)]
    fn sample(&self, state: &mut RoundnessState<R, N>, passed: &Passed<R>, limited: bool, flags: &mut Flags) {
        let sampling = &mut state.sampling;
        if flags.discards() && sampling.running {
            sampling.running = false;
            state.counts.discarded = state.counts.discarded.wrapping_add(1);
        }
        sampling.cycles = sampling.cycles.wrapping_add(1);
        sampling.limited = sampling.limited.wrapping_add(u32::from(limited));
        let Some(angles) = state.resampler.angles() else { return };
        sampling.time(angles.alpha);
        for point in passed.iter().flatten() {
            if point.place == 0 {
                Self::turn(state, flags);
            }
            if !state.sampling.running {
                continue;
            }
            let [first, second] = &mut state.revolutions;
            let revolution = if state.second { second } else { first };
            let n = point.place & (N - 1);
            revolution.first[n] = point.h1;
            revolution.second[n] = point.h2;
            revolution.sum[n] = point.sum;
            if n & (N / ARM_CHECKS - 1) == 0 {
                revolution.beta[(n / (N / ARM_CHECKS)) & (ARM_CHECKS - 1)] = angles.beta;
            }
            state.sampling.points = state.sampling.points.wrapping_add(1);
        }
    }

    /// θ passes zero: a revolution ends, the next begins.
    #[inline(never)]
    fn turn(state: &mut RoundnessState<R, N>, flags: &mut Flags) {
        let sampling = state.sampling;
        if sampling.running && sampling.points == N {
            state.counts.sampled = state.counts.sampled.wrapping_add(1);
            let mut of_revolution = sampling.flags;
            // A quarter of the time, and a cycle of rounding at either end.
            if sampling.most > sampling.fewest.saturating_add(sampling.fewest / 4).saturating_add(2) {
                of_revolution.set(Flags::SPEED);
            }
            if sampling.limited > sampling.cycles / 64 {
                of_revolution.set(Flags::INFEED_FROZEN);
            }
            flags.set(of_revolution);
            if state.work.is_idle() {
                state.second = !state.second;
                state.work.begin(Evaluation { revolution: state.counts.sampled, flags: of_revolution, ..state.latest });
            } else {
                state.counts.skipped = state.counts.skipped.wrapping_add(1);
                flags.set(Flags::SKIPPED);
            }
        }
        let skipped = if flags.has(Flags::SKIPPED) { Flags::SKIPPED } else { Flags::default() };
        state.sampling = Sampling {
            running: !flags.discards(),
            flags: skipped,
            sixteenth: u32::MAX,
            elapsed: sampling.elapsed,
            ..Sampling::NEW
        };
    }

    #[inline(always)]
    fn work(&self, state: &mut RoundnessState<R, N>) -> bool {
        let [first, second] = &mut state.revolutions;
        let evaluated = if state.second { first } else { second };
        let mut finished = false;
        for _ in 0..self.units_per_cycle {
            if let Some(result) = state.work.unit(&self.plan, evaluated, self.infeed.as_ref(), state.ratio) {
                state.latest = result;
                state.counts.evaluated = state.counts.evaluated.wrapping_add(1);
                finished = true;
            }
        }
        finished
    }

    #[inline(always)]
    fn infeed(&self, state: &RoundnessState<R, N>) -> R {
        match (&self.infeed, state.resampler.angles()) {
            (Some(infeed), Some(angles)) if !state.work.is_cleared() => {
                infeed.at(&state.work.correction, &self.plan.circle, state.ratio, angles, state.resampler.speed())
            }
            _ => R::ZERO,
        }
    }
}

#[cfg(test)]
mod tests;
