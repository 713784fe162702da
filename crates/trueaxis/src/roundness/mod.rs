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
//! # Example
//!
//! ```
//! use trueaxis::roundness::{ProbeAngles, Probes, Roundness, RoundnessSettings};
//!
//! let angles = ProbeAngles::Slots { p: 44, q: 57 };
//! let settings = RoundnessSettings::with_defaults(256, angles, 1 << 20);
//! let gauge = Roundness::<f32, 256>::build(&settings, 100_000)?; // refuses angles that are blind to a harmonic
//! let mut state = gauge.start();
//!
//! // From here on the servo interrupt, or ServoLoop::step_with_gauge:
//! for count in (0..4 << 20).step_by(500) {
//!     let turned = count >> 20 != (count - 500) >> 20;
//!     let index = turned.then_some(count & !((1 << 20) - 1));
//!     let probes = Probes { readings: [0.4, 0.4, 0.4], spindle: count, index, ..Probes::default() };
//!     let cycle = gauge.update(&mut state, &probes, false);
//!     if cycle.finished {
//!         let of = state.latest().unwrap();
//!         assert!(of.flags.is_empty() && of.peak_to_valley_um < 1e-4);
//!     }
//! }
//! assert_eq!(state.counts().evaluated, 2); // of four turns: up to the first index, two whole ones, one in work
//! # Ok::<(), trueaxis::ConfigError>(())
//! ```
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
#[cfg(feature = "rustfft")]
pub mod offline;
#[cfg(feature = "std")]
pub mod pair_search;
mod resample;
mod settings;
#[cfg(feature = "std")]
pub mod spindle_offline;
mod transform;
mod work;

pub use angles::{Band, Gain, ProbeAngles};
pub use arm::{Arm, arm_angle};
pub use flags::Flags;
pub use motion::ErrorMotion;
pub use settings::{
    ArmSettings, FEWEST_POINTS, INFEED_NOISE_GAIN_LIMIT, InfeedSettings, MOST_COUNTS, MOST_POINTS, NOISE_GAIN_LIMIT,
    ProbeSettings, RoundnessSettings, SpindleEncoder, gain_limit,
};
pub use work::HARMONICS;

use crate::error::{ConfigError, Field};
use crate::real::Real;
use infeed::Infeed;
use resample::{Angles, POINTS_PER_CYCLE, Resampler, ResamplerState};
use work::{ARM_CHECKS, Outcome, Plan, Revolution, Task, Use, Work};

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
#[repr(C)]
pub struct Roundness<R, const N: usize> {
    units_per_cycle: u8,
    resampler: Resampler<R, N>,
    infeed: Option<Infeed<R>>,
    arm: Option<Arm>,
    gain: Gain,
    band: Band,
    noise_gain_limit: f64,
    plan: Plan<R, N>,
}

/// The mutable half: what one cycle hands to the next, and the results. Large (17 N scalars): a static's place.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RoundnessState<R, const N: usize> {
    /// The one of the two revolutions that is worked on; the other is being sampled.
    worked: usize,
    resampler: ResamplerState<R>,
    sampling: Sampling<R>,
    latest: Outcome<R>,
    counts: Counts,
    speed: Speed<R>,
    work: Work<R, N>,
    revolutions: [Revolution<R, N>; 2],
    /// Weighted sums of the three probes; of the one that is worked on, their spectrum.
    sums: [[R; N]; 2],
}

/// How fast the surface turns.
#[derive(Clone, Copy, Debug)]
struct Speed<R> {
    /// θ of the last cycle in which it was known.
    theta: Option<u32>,
    /// Change of θ per cycle, 2^−32 turns, smoothed over some 64 cycles.
    per_cycle: R,
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
struct Sampling<R> {
    running: bool,
    points: usize,
    flags: Flags,
    /// Weighted sums added up.
    total: R,
    /// Their mean over the revolution before, if that was whole.
    before: Option<R>,
    /// The cycle in which it began.
    began: u32,
    /// Quarter of a turn of α, from 1 (0: not known), the cycle in which it began, fewest and most cycles that one took.
    quarter: u32,
    entered: u32,
    fewest: u32,
    most: u32,
    /// Cycles in which the infeed axis was limited.
    limited: u32,
}

impl<R: Real> Sampling<R> {
    const NEW: Sampling<R> = Sampling {
        running: false,
        points: 0,
        flags: Flags(0),
        total: R::ZERO,
        before: None,
        began: 0,
        quarter: 0,
        entered: 0,
        fewest: 0,
        most: 0,
        limited: 0,
    };

    /// Follows the speed by the time that every quarter of a turn takes.
    #[inline(always)]
    fn time(&mut self, alpha: u32, clock: u32) {
        let quarter = (alpha >> 30) + 1;
        if quarter == self.quarter {
            return;
        }
        // The first one seen is not whole.
        if self.quarter != 0 {
            let took = clock.wrapping_sub(self.entered);
            self.fewest = if self.most == 0 { took } else { self.fewest.min(took) };
            self.most = self.most.max(took);
        }
        (self.quarter, self.entered) = (quarter, clock);
    }
}

impl<R: Real, const N: usize> RoundnessState<R, N> {
    /// Before the first cycle. All of it is zero: a static of it takes no flash.
    #[allow(clippy::new_without_default)]
    pub const fn new() -> Self {
        RoundnessState {
            resampler: ResamplerState::new(),
            revolutions: [Revolution::new(), Revolution::new()],
            sums: [[R::ZERO; N]; 2],
            worked: 0,
            sampling: Sampling::NEW,
            work: Work::new(),
            latest: Outcome::NONE,
            counts: Counts { sampled: 0, evaluated: 0, skipped: 0, discarded: 0 },
            speed: Speed { theta: None, per_cycle: R::ZERO },
        }
    }

    /// The latest revolution evaluated.
    pub fn latest(&self) -> Option<Evaluation<R>> {
        let Outcome { revolution, flags, peak_to_valley_um } = self.latest;
        let ([x, y], revolutions) = (self.work.error_motion, self.work.window);
        (self.counts.evaluated > 0).then_some(Evaluation { revolution, flags, peak_to_valley_um, x, y, revolutions })
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

    /// Amplitudes of cos kθ and sin kθ in the profile, µm; zero outside the band, where suppressed, and from
    /// [`HARMONICS`] on.
    pub fn harmonic(&self, harmonic: usize) -> [R; 2] {
        self.work.harmonic(harmonic)
    }

    /// Motion of the centre in the latest revolution, R_X and R_Y, µm; while no work is under way and until the next
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
    fn work_and_revolution(&mut self) -> (&mut Work<R, N>, &mut Revolution<R, N>) {
        (&mut self.work, &mut self.revolutions[self.worked & 1])
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

    /// A fresh state.
    pub fn start(&self) -> RoundnessState<R, N> {
        RoundnessState::new()
    }

    /// Makes a state new in its place: nothing is measured or fed in until another revolution is whole.
    pub fn restart(&self, state: &mut RoundnessState<R, N>) {
        *state = RoundnessState::new();
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

    /// Sets the wheel's radius R_S, mm (wear, dressing); in force from the next revolution that is worked on.
    ///
    /// # Errors
    /// There is no arm, or the linkage could not close.
    pub fn set_wheel(&self, state: &mut RoundnessState<R, N>, wheel_mm: f64) -> core::result::Result<(), ConfigError> {
        let Some(arm) = self.arm else {
            return Err(ConfigError::new(Field::Arm, wheel_mm, "a gauge with a following arm"));
        };
        state.work.ratio = Some(R::of(Arm { wheel_mm, ..arm }.ratio()?));
        Ok(())
    }

    /// One servo cycle: cannot fail, panic, allocate, block, or loop without a fixed bound.
    ///
    /// `limited` tells whether the infeed axis' correction was limited in the cycle before. The three stages can be
    /// called by themselves, [`Roundness::work`] for instance in the background.
    #[inline]
    pub fn update(&self, state: &mut RoundnessState<R, N>, probes: &Probes<R>, limited: bool) -> Cycle<R> {
        let flags = self.sample(state, probes, limited);
        let finished = self.work(state);
        Cycle { infeed: self.infeed(state), flags, finished }
    }

    /// First stage: a cycle's readings, resampled; gives what it met.
    #[inline]
    pub fn sample(&self, state: &mut RoundnessState<R, N>, probes: &Probes<R>, limited: bool) -> Flags {
        if probes.new_part {
            state.work.clear();
            state.sampling = Sampling::NEW;
        }
        let mut flags = Flags::default();
        let passed = self.resampler.update(&mut state.resampler, probes, &mut flags);
        if flags.discards() && state.sampling.running {
            state.sampling.running = false;
            state.counts.discarded = state.counts.discarded.wrapping_add(1);
        }
        state.sampling.limited = state.sampling.limited.wrapping_add(u32::from(limited));
        if let Some(points) = passed {
            if points > 0 {
                self.pass(state, &probes.readings, points, &mut flags);
            }
            Resampler::<R, N>::keep(&mut state.resampler, &probes.readings);
        }
        flags
    }

    /// θ has passed a point, or two.
    #[inline(never)]
    fn pass(&self, state: &mut RoundnessState<R, N>, readings: &[R; 3], points: usize, flags: &mut Flags) {
        let Some(Angles { theta, alpha, beta }) = state.resampler.angles else { return };
        state.sampling.time(alpha, state.resampler.clock);
        let mut angle = Resampler::<R, N>::last(&state.resampler);
        for _ in 0..points.min(POINTS_PER_CYCLE) {
            let point = self.resampler.point(&mut state.resampler, theta, readings, &mut angle);
            if point.place == 0 {
                self.turn(state, flags);
            }
            if !state.sampling.running {
                continue;
            }
            let revolution = &mut state.revolutions[!state.worked & 1];
            let n = point.place & (N - 1);
            revolution.first[n] = point.h1;
            revolution.second[n] = point.h2;
            state.sums[!state.worked & 1][n] = point.sum;
            state.sampling.total += point.sum;
            if n & (N / ARM_CHECKS - 1) == 0 {
                revolution.beta[(n / (N / ARM_CHECKS)) & (ARM_CHECKS - 1)] = beta;
            }
            state.sampling.points = state.sampling.points.wrapping_add(1);
        }
    }

    /// θ passes zero: a revolution ends, the next begins.
    #[inline(never)]
    fn turn(&self, state: &mut RoundnessState<R, N>, flags: &mut Flags) {
        let sampling = state.sampling;
        let mut before = None;
        if sampling.running && sampling.points == N {
            let mean = sampling.total * R::of(1.0 / N as f64);
            before = Some(mean);
            state.counts.sampled = state.counts.sampled.wrapping_add(1);
            let mut of_revolution = sampling.flags;
            // A quarter of the time, and a cycle of rounding at either end.
            if sampling.most > sampling.fewest.saturating_add(sampling.fewest / 4).saturating_add(2) {
                of_revolution.set(Flags::SPEED);
            }
            if sampling.limited > state.resampler.clock.wrapping_sub(sampling.began) / 64 {
                of_revolution.set(Flags::INFEED_FROZEN);
            }
            flags.set(of_revolution);
            if state.work.is_idle() {
                state.worked ^= 1;
                let drift = sampling.before.map_or(R::ZERO, |before| mean - before);
                state.work.begin(&self.plan, state.counts.sampled, of_revolution, mean, drift);
            } else {
                state.counts.skipped = state.counts.skipped.wrapping_add(1);
                flags.set(Flags::SKIPPED);
            }
        }
        let skipped = if flags.has(Flags::SKIPPED) { Flags::SKIPPED } else { Flags::default() };
        state.sampling = Sampling {
            running: !flags.discards(),
            flags: skipped,
            before,
            began: state.resampler.clock,
            ..Sampling::NEW
        };
    }

    /// Second stage: the units of work of a cycle; true when a revolution has just been evaluated.
    #[inline]
    pub fn work(&self, state: &mut RoundnessState<R, N>) -> bool {
        if self.units_per_cycle == 1 { self.unit(state) } else { self.units(state) }
    }

    #[inline(never)]
    fn units(&self, state: &mut RoundnessState<R, N>) -> bool {
        let mut finished = false;
        for _ in 0..self.units_per_cycle {
            finished |= self.unit(state);
        }
        finished
    }

    /// One unit. Every task is a function of its own, so that nothing is prepared before it is known which one it is.
    #[inline(never)]
    fn unit(&self, state: &mut RoundnessState<R, N>) -> bool {
        match state.work.task {
            Task::Idle => false,
            Task::Forward => self.forward(state),
            Task::Spread(Use::Profile) => self.spread_profile(state),
            Task::Spread(of) => self.spread(state, of),
            Task::Inverse(of) => self.inverse(state, of),
            Task::Arm => self.compare_arm(state),
            Task::Orbit => self.orbit(state),
            Task::Evaluate => self.evaluate(state),
            Task::Express => self.express(state),
            Task::Judge => self.judge(state),
            Task::Commit => self.commit(state),
            Task::Clear => self.zero(state),
            Task::Range => self.measure(state),
            Task::Linkage => self.link(state),
            Task::Level => self.level(state),
            Task::Turn => self.finish(state),
        }
    }

    #[inline(never)]
    fn forward(&self, state: &mut RoundnessState<R, N>) -> bool {
        let (work, sum) = (&mut state.work, &mut state.sums[state.worked & 1]);
        if work.forward(&self.plan, sum) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn spread_profile(&self, state: &mut RoundnessState<R, N>) -> bool {
        let (work, sum) = (&mut state.work, &mut state.sums[state.worked & 1]);
        if work.spread_profile(&self.plan, sum) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn spread(&self, state: &mut RoundnessState<R, N>, of: Use) -> bool {
        let (work, sum) = (&mut state.work, &mut state.sums[state.worked & 1]);
        if work.spread(&self.plan, sum, self.plan.multipliers(of)) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn inverse(&self, state: &mut RoundnessState<R, N>, of: Use) -> bool {
        let work = &mut state.work;
        if work.inverse(&self.plan, of) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn compare_arm(&self, state: &mut RoundnessState<R, N>) -> bool {
        let (work, revolution) = state.work_and_revolution();
        if work.compare_arm(revolution) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn orbit(&self, state: &mut RoundnessState<R, N>) -> bool {
        let (work, revolution) = state.work_and_revolution();
        if work.orbit(&self.plan, revolution) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn evaluate(&self, state: &mut RoundnessState<R, N>) -> bool {
        let work = &mut state.work;
        if work.evaluate(&self.plan) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn express(&self, state: &mut RoundnessState<R, N>) -> bool {
        let work = &mut state.work;
        if work.express(&self.plan) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn judge(&self, state: &mut RoundnessState<R, N>) -> bool {
        let work = &mut state.work;
        if work.judge(self.infeed.as_ref()) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn commit(&self, state: &mut RoundnessState<R, N>) -> bool {
        let work = &mut state.work;
        if work.commit(self.infeed.as_ref()) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn zero(&self, state: &mut RoundnessState<R, N>) -> bool {
        let work = &mut state.work;
        if work.zero() {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn measure(&self, state: &mut RoundnessState<R, N>) -> bool {
        let work = &mut state.work;
        if work.measure(&self.plan) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn link(&self, state: &mut RoundnessState<R, N>) -> bool {
        let work = &mut state.work;
        if work.link(&self.plan) {
            work.end();
        }
        false
    }

    #[inline(never)]
    fn level(&self, state: &mut RoundnessState<R, N>) -> bool {
        if state.work.level(&mut state.sums[state.worked & 1]) {
            state.work.end();
        }
        false
    }

    /// From one task to the next; true when it was the last of a revolution.
    #[inline(never)]
    fn finish(&self, state: &mut RoundnessState<R, N>) -> bool {
        let finished = state.work.finish(&self.plan);
        if finished {
            state.latest = state.work.result;
            state.counts.evaluated = state.counts.evaluated.wrapping_add(1);
        }
        finished
    }

    /// Third stage: infeed correction of this cycle, mm in the sense of its axis.
    #[inline]
    pub fn infeed(&self, state: &mut RoundnessState<R, N>) -> R {
        let (Some(infeed), Some(angles)) = (&self.infeed, state.resampler.angles) else { return R::ZERO };
        let speed = &mut state.speed;
        if let Some(theta) = speed.theta {
            let change = R::of_i32(angles.theta.wrapping_sub(theta) as i32);
            speed.per_cycle += (change - speed.per_cycle) * R::of(1.0 / 64.0);
        }
        speed.theta = Some(angles.theta);
        if state.work.is_cleared() {
            return R::ZERO;
        }
        infeed.at(&state.work.correction, |place| state.work.cos_beta(place), angles, speed.per_cycle)
    }
}

#[cfg(test)]
mod tests;
