//! The work on one revolution, in slices of a fixed size.
//!
//! ```text
//! Linkage (another wheel) ─► Level (drift) ─► Forward ─► Spread, Inverse (profile at θ + φ2) ─► Spread, Inverse (profile) ─► Arm ─► Orbit
//!        ─► Evaluate, Express (once a window) ─► Spread, Inverse, Judge, Commit (infeed) ─► Spread, Inverse (filter) ─► Range
//! ```
//!
//! The tasks that a gauge needs are chosen when it is built; a slice is bounded for any data. The work of each task in
//! a slice and its number of slices are in the table of `tasks.rs`; the order of tasks is in [`Plan::next`].

use super::angles::Gain;
use super::arm_angle;
use super::filter;
use super::flags::GaugeFlags;
use super::infeed::Infeed;
use super::motion::{ErrorMotion, Motion};
use super::settings::GaugeSettings;
use super::transform::{
    AMPLITUDE_SCALE, Complex, Progress, circle, forward_slice, inverse_slice, multipliers, pair_slice,
};
use crate::real::Real;

/// Harmonics 0 to 127 of the profile are kept as amplitudes.
pub const HARMONICS: usize = 128;
/// Points of a revolution at which the arm's reading is compared with the linkage.
pub(super) const ARM_CHECKS: usize = 16;
/// Revolutions in a row in which the infeed axis was limited before the correction is made smaller.
const PATIENCE: u8 = 4;
/// The radius drifts steadily where its change per revolution itself changes by less than this and a quarter, µm.
const STEADY_UM: f64 = 0.2;
/// Points in a slice of the passes that only compare or add.
pub(super) const POINTS_PER_SLICE: usize = 4;

/// Readings of one revolution; turned into the motion of the centre while it is worked on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Revolution<R, const N: usize> {
    /// Probe 1; then R_X.
    pub(super) first: [R; N],
    /// Probe 2; then R_Y.
    pub(super) second: [R; N],
    /// β at `ARM_CHECKS` points, in 2^−32 turns.
    pub(super) beta: [i32; ARM_CHECKS],
}

impl<R: Real, const N: usize> Revolution<R, N> {
    pub(super) const fn new() -> Self {
        Revolution { first: [R::ZERO; N], second: [R::ZERO; N], beta: [0; ARM_CHECKS] }
    }
}

/// Uses of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    Shifted,
    Profile,
    Infeed,
    Filtered,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Task {
    Idle,
    Forward,
    Spread(Use),
    Inverse(Use),
    Arm,
    Orbit,
    Evaluate,
    Express,
    Judge,
    Commit,
    Clear,
    Range,
    /// β at every point, for another radius of the wheel.
    Linkage,
    /// The drift of the radius out of the weighted sum.
    Level,
    /// From one task to the next: a slice of its own.
    Switch,
}

/// Immutable: multipliers of the four uses, and constants.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan<R, const N: usize> {
    pub(super) circle: [Complex<R>; N],
    profile: [R; N],
    pub(super) shifted: Option<[R; N]>,
    pub(super) infeed: Option<[R; N]>,
    pub(super) filtered: Option<[R; N]>,
    /// φ2 in whole slots, where it has not a transform of its own.
    slots: usize,
    cos2: R,
    sin2: R,
    per_sin2: R,
    pub(super) has_arm: bool,
    /// λ of the arm as set.
    ratio: R,
    arm_tolerance: R,
    revolutions: u16,
    per_revolutions: R,
    /// 1/G(0), from the mean of the weighted sum to that of the radius; 0 where the probes do not see it.
    per_mean: R,
    /// Change of the drift that is treated as zero, in the weighted sum.
    pub(super) steady: R,
}

/// A whole revolution as it is handed over.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beginning<R> {
    pub(super) revolution: u32,
    pub(super) flags: GaugeFlags,
    /// The infeed axis could not follow.
    pub(super) limited: bool,
    /// Mean of the weighted sum, and its change from the revolution before.
    pub(super) mean: R,
    pub(super) drift: R,
}

/// Result of a revolution while it is worked on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome<R> {
    pub(super) revolution: u32,
    pub(super) flags: GaugeFlags,
    pub(super) peak_to_valley_um: R,
}

impl<R: Real> Outcome<R> {
    pub(super) const NONE: Outcome<R> = Outcome { revolution: 0, flags: GaugeFlags(0), peak_to_valley_um: R::ZERO };
}

/// State of the work, and its results. What every slice needs stands first, within reach of short offsets.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Work<R, const N: usize> {
    progress: Progress,
    at: usize,
    pub(super) task: Task,
    /// The task that has just been done.
    done: Task,
    /// Revolutions in the window of the motion so far.
    pub(super) gathered: u16,
    /// λ of the arm, where the wheel's radius has been set since, and that for which the linkage holds.
    pub(super) ratio: Option<R>,
    linked: R,
    /// λ for which the linkage is being worked out.
    linking: R,
    /// Smallest and largest value of a pass.
    range: [R; 2],
    worst: R,
    pub(super) result: Outcome<R>,
    clear: bool,
    /// Revolutions in a row in which the infeed axis was limited.
    limited_for: u8,
    /// Change of the weighted sum in a revolution.
    drift: R,
    /// Mean radius and its change in a revolution, against the probes' zeros, µm.
    radius: [R; 2],
    /// Error motions along X and Y over the last full window, and its revolutions.
    pub(super) error_motion: [ErrorMotion<R>; 2],
    pub(super) window: u16,
    /// Spectrum of the profile, in the scale of the multipliers.
    harmonics: [Complex<R>; HARMONICS],
    pub(super) profile: [R; N],
    other: [R; N],
    motion: [Motion<R, N>; 2],
    pub(super) correction: [R; N],
    /// [cos β − 1, sin β] at every point: all zero is an arm that stands still.
    linkage: [Complex<R>; N],
}

impl<R: Real, const N: usize> Plan<R, N> {
    /// Of settings that have been checked.
    pub(super) fn new(settings: &GaugeSettings, gain: &Gain) -> Self {
        let seen = |k: usize| {
            u16::try_from(k).is_ok_and(|k| settings.band.contains(k)) && gain.noise_gain(k) <= settings.noise_gain_limit
        };
        let quotient = |k: usize| {
            if !seen(k) {
                return [0.0; 2];
            }
            let [re, im] = gain.of(k);
            let square = re * re + im * im;
            [re / square, -im / square]
        };
        let turned = |k: usize| {
            let ([a, b], [c, d]) = (quotient(k), gain.phase2(k));
            [a * c - b * d, a * d + b * c]
        };
        let (sin2, cos2) = (libm::sin(gain.phi2()), libm::cos(gain.phi2()));
        // G(0) is real.
        let [mean, _] = gain.of(0);
        let sees_mean = libm::fabs(mean) > 1e-6 * gain.norm();
        Plan {
            circle: circle::<R, N>(),
            profile: multipliers(quotient),
            shifted: gain.slots().is_none().then(|| multipliers(turned)),
            infeed: settings.infeed.map(|infeed| {
                let corrected = |k: usize| {
                    let inside = u16::try_from(k).is_ok_and(|k| infeed.band.contains(k));
                    inside && gain.noise_gain(k) <= infeed.noise_gain_limit
                };
                multipliers(|k| if corrected(k) { quotient(k) } else { [0.0; 2] })
            }),
            filtered: settings
                .filter
                .map(|cut_off| multipliers(|k| quotient(k).map(|part| part * filter::transmission(k, cut_off)))),
            slots: gain.slots().map_or(0, |[p, _]| p),
            cos2: R::of(cos2),
            sin2: R::of(sin2),
            per_sin2: R::of(1.0 / sin2),
            has_arm: settings.arm.is_some(),
            ratio: R::of(settings.arm.and_then(|arm| arm.lengths.ratio().ok()).unwrap_or(0.0)),
            arm_tolerance: R::of(settings.arm.map_or(0.0, |arm| libm::sin(arm.tolerance_deg.to_radians()))),
            revolutions: settings.revolutions,
            per_revolutions: R::of(1.0 / f64::from(settings.revolutions)),
            steady: R::of(STEADY_UM * libm::fabs(mean)),
            per_mean: R::of(if sees_mean { 1.0 / mean } else { 0.0 }),
        }
    }

    pub(super) fn multipliers(&self, of: Use) -> &[R; N] {
        let table = match of {
            Use::Profile => None,
            Use::Shifted => self.shifted.as_ref(),
            Use::Infeed => self.infeed.as_ref(),
            Use::Filtered => self.filtered.as_ref(),
        };
        table.unwrap_or(&self.profile)
    }

    /// The task that comes after the one just done.
    #[inline(always)]
    fn next(&self, work: &Work<R, N>) -> Task {
        let window_is_full = work.gathered >= self.revolutions;
        match work.done {
            Task::Linkage if work.drift != R::ZERO => Task::Level,
            Task::Linkage | Task::Level => Task::Forward,
            Task::Forward if self.shifted.is_some() => Task::Spread(Use::Shifted),
            Task::Forward | Task::Inverse(Use::Shifted) => Task::Spread(Use::Profile),
            Task::Spread(of) => Task::Inverse(of),
            Task::Inverse(Use::Profile) if self.has_arm => Task::Arm,
            Task::Inverse(Use::Profile) | Task::Arm => Task::Orbit,
            Task::Orbit if window_is_full => Task::Evaluate,
            Task::Evaluate => Task::Express,
            Task::Orbit | Task::Express if self.infeed.is_some() => Task::Spread(Use::Infeed),
            Task::Inverse(Use::Infeed) => Task::Judge,
            Task::Judge if !work.result.flags.has(GaugeFlags::INFEED_FROZEN) || work.gives_way() => Task::Commit,
            Task::Orbit | Task::Express | Task::Judge | Task::Commit if self.filtered.is_some() => {
                Task::Spread(Use::Filtered)
            }
            Task::Orbit | Task::Express | Task::Judge | Task::Commit | Task::Inverse(Use::Filtered) => Task::Range,
            Task::Range | Task::Clear | Task::Idle | Task::Switch => Task::Idle,
        }
    }
}

impl<R: Real, const N: usize> Work<R, N> {
    pub(super) const fn new() -> Self {
        Work {
            task: Task::Idle,
            done: Task::Idle,
            progress: Progress::NONE,
            at: 0,
            profile: [R::ZERO; N],
            other: [R::ZERO; N],
            harmonics: [[R::ZERO; 2]; HARMONICS],
            motion: [Motion::new(), Motion::new()],
            gathered: 0,
            correction: [R::ZERO; N],
            range: [R::ZERO; 2],
            worst: R::ZERO,
            result: Outcome::NONE,
            clear: false,
            limited_for: 0,
            drift: R::ZERO,
            radius: [R::ZERO; 2],
            error_motion: [ErrorMotion::NONE; 2],
            window: 0,
            ratio: None,
            linked: R::ZERO,
            linking: R::ZERO,
            linkage: [[R::ZERO; 2]; N],
        }
    }

    pub(super) fn is_idle(&self) -> bool {
        self.task == Task::Idle
    }

    /// The correction is being set to zero, or waits for it.
    pub(super) fn is_cleared(&self) -> bool {
        self.clear
    }

    /// A new part: drops what is being worked on and sets the correction to zero.
    #[cold]
    pub(super) fn clear(&mut self) {
        (self.task, self.at, self.gathered, self.clear) = (Task::Clear, 0, 0, true);
        (self.error_motion, self.window) = ([ErrorMotion::NONE; 2], 0);
    }

    /// Takes over a revolution.
    #[inline(always)]
    pub(super) fn begin(&mut self, plan: &Plan<R, N>, beginning: Beginning<R>) {
        let Beginning { revolution, flags, limited, mean, drift } = beginning;
        let first = if self.linked != self.ratio(plan) {
            Task::Linkage
        } else if drift != R::ZERO {
            Task::Level
        } else {
            Task::Forward
        };
        self.drift = drift;
        self.radius = [mean * plan.per_mean, drift * plan.per_mean];
        self.limited_for = if limited { self.limited_for.saturating_add(1) } else { 0 };
        self.linking = self.ratio(plan);
        (self.task, self.progress, self.at) = (first, Progress::forward(), 0);
        self.result = Outcome { revolution, flags, ..Outcome::NONE };
    }

    /// The axis cannot follow the correction, revolution after revolution: frozen for good it would never come free.
    fn gives_way(&self) -> bool {
        self.limited_for >= PATIENCE
    }

    /// Amplitudes of cos kθ and sin kθ in the profile.
    pub(super) fn harmonic(&self, harmonic: usize) -> [R; 2] {
        let [re, im] = self.harmonics.get(harmonic).copied().unwrap_or([R::ZERO; 2]);
        [re * R::of(AMPLITUDE_SCALE), im * R::of(-AMPLITUDE_SCALE)]
    }

    /// The last slice of a task.
    #[inline(always)]
    pub(super) fn end(&mut self) {
        (self.done, self.task) = (self.task, Task::Switch);
    }

    /// From one task to the next; true when the result stands.
    #[inline(always)]
    pub(super) fn finish(&mut self, plan: &Plan<R, N>) -> bool {
        let finished = self.done;
        match finished {
            Task::Arm if self.worst > plan.arm_tolerance => {
                self.result.flags.set(GaugeFlags::ARM);
                self.result.flags.set(GaugeFlags::INFEED_FROZEN);
            }
            // A motion by a linkage that is contradicted says nothing: the window begins anew.
            Task::Orbit if self.result.flags.has(GaugeFlags::ARM) => self.gathered = 0,
            Task::Orbit => self.gathered = self.gathered.saturating_add(1),
            Task::Evaluate => self.motion.iter_mut().for_each(Motion::express),
            Task::Express => {
                for (to, motion) in self.error_motion.iter_mut().zip(&self.motion) {
                    *to = motion.result();
                }
                self.window = self.gathered;
            }
            Task::Clear => (self.clear, self.limited_for) = (false, 0),
            Task::Judge if self.gives_way() => self.result.flags.set(GaugeFlags::INFEED_REDUCED),
            Task::Linkage => self.linked = self.linking,
            _ => {}
        }
        self.task = plan.next(self);
        if finished == Task::Express {
            self.gathered = 0;
        }
        self.at = 0;
        self.worst = R::ZERO;
        self.range = [R::MAX, -R::MAX];
        self.progress = match self.task {
            Task::Forward => Progress::forward(),
            Task::Inverse(_) => Progress::inverse::<N>(),
            _ => Progress::pairs(),
        };
        if self.task == Task::Evaluate {
            self.motion.iter_mut().for_each(Motion::begin);
        }
        finished == Task::Range
    }

    /// One slice of the forward transform.
    #[inline(always)]
    pub(super) fn forward(&mut self, plan: &Plan<R, N>, sum: &mut [R; N]) -> bool {
        forward_slice(sum, &plan.circle, &mut self.progress)
    }

    /// One slice of an inverse transform.
    #[inline(always)]
    pub(super) fn inverse(&mut self, plan: &Plan<R, N>, of: Use) -> bool {
        let z = if of == Use::Profile { &mut self.profile } else { &mut self.other };
        inverse_slice(z, &plan.circle, &mut self.progress)
    }

    /// One pair of the profile; its harmonics are kept.
    #[inline(always)]
    pub(super) fn spread_profile(&mut self, plan: &Plan<R, N>, spectrum: &[R; N]) -> bool {
        let (pair, last) = pair_slice(spectrum, &mut self.profile, &plan.circle, &plan.profile, &mut self.progress);
        for (k, [re, im]) in [(pair.low, pair.at_low), (pair.high, pair.at_high)] {
            if let Some(amplitude) = self.harmonics.get_mut(k) {
                *amplitude = [re, im];
            }
        }
        last
    }

    /// One pair, for another use.
    #[inline(always)]
    pub(super) fn spread(&mut self, plan: &Plan<R, N>, spectrum: &[R; N], multipliers: &[R; N]) -> bool {
        pair_slice(spectrum, &mut self.other, &plan.circle, multipliers, &mut self.progress).1
    }

    /// Takes a steady change of the radius out of the weighted sum: it is no harmonic, but would look like all of them.
    #[inline(always)]
    pub(super) fn level(&mut self, sum: &mut [R; N]) -> bool {
        for i in 0..POINTS_PER_SLICE {
            let n = (self.at + i) & (N - 1);
            sum[n] -= self.drift * Self::turned(n);
        }
        self.at += POINTS_PER_SLICE;
        self.at >= N
    }

    /// Fraction of the revolution at a point, from its middle.
    #[inline(always)]
    fn turned(n: usize) -> R {
        R::of_i32(n as i32) * R::of(1.0 / N as f64) - R::of((N as f64 - 1.0) / (2.0 * N as f64))
    }

    /// β at one point.
    #[inline(always)]
    pub(super) fn link(&mut self, plan: &Plan<R, N>) -> bool {
        let n = self.at & (N - 1);
        let [cos, sin] = plan.circle[n];
        let [cos, sin] = arm_angle(self.linking, [cos, -sin]);
        self.linkage[n] = [cos - R::ONE, sin];
        self.at = n + 1;
        self.at >= N
    }

    /// λ of the arm, as the wheel is now.
    #[inline(always)]
    fn ratio(&self, plan: &Plan<R, N>) -> R {
        self.ratio.unwrap_or(plan.ratio)
    }

    /// cos β at a point.
    #[inline(always)]
    pub(super) fn cos_beta(&self, index: usize) -> R {
        self.linkage.get(index).map_or(R::ONE, |[less, _]| *less + R::ONE)
    }

    /// sin β of the reading against sin β of the linkage, at one of the points compared.
    #[inline(always)]
    pub(super) fn compare_arm(&mut self, revolution: &Revolution<R, N>) -> bool {
        let at = self.at & (ARM_CHECKS - 1);
        let [_, expected] = self.linkage[(at * (N / ARM_CHECKS)) & (N - 1)];
        let beta = R::of_i32(revolution.beta[at]) * R::of(core::f64::consts::TAU / 4_294_967_296.0);
        let square = beta * beta;
        let found = beta
            * (R::ONE - square * (R::of(1.0 / 6.0) - square * (R::of(1.0 / 120.0) - square * R::of(1.0 / 5040.0))));
        self.worst = R::max((found - expected).abs(), self.worst);
        self.at = at + 1;
        self.at >= ARM_CHECKS
    }

    /// Motion of the centre at one point; it joins those of the window.
    #[inline(always)]
    pub(super) fn orbit(&mut self, plan: &Plan<R, N>, revolution: &mut Revolution<R, N>) -> bool {
        let n = self.at & (N - 1);
        let [less, sin] = self.linkage[n];
        let cos = less + R::ONE;
        let ahead = match plan.shifted {
            Some(_) => self.other[n],
            None => self.profile[(n + plan.slots) & (N - 1)],
        };
        let [mean, drift] = self.radius;
        let radius = mean + drift * Self::turned(n);
        let first = revolution.first[n] - self.profile[n] - radius;
        let second = revolution.second[n] - ahead - radius;
        let cos2 = plan.cos2 * cos - plan.sin2 * sin;
        let sin2 = plan.sin2 * cos + plan.cos2 * sin;
        let x = (cos * second - cos2 * first) * plan.per_sin2;
        let y = (sin2 * first - sin * second) * plan.per_sin2;
        (revolution.first[n], revolution.second[n]) = (x, y);
        let begins = self.gathered == 0;
        let [of_x, of_y] = &mut self.motion;
        of_x.add(n, x, begins);
        of_y.add(n, y, begins);
        self.at = n + 1;
        self.at >= N
    }

    #[inline(always)]
    pub(super) fn evaluate(&mut self, plan: &Plan<R, N>) -> bool {
        let n = self.at & (N - 1);
        let [cos, sin] = plan.circle[n];
        for motion in &mut self.motion {
            motion.evaluate(n, [cos, -sin], plan.per_revolutions);
        }
        self.at = n + 1;
        self.at >= N
    }

    #[inline(always)]
    pub(super) fn express(&mut self, plan: &Plan<R, N>) -> bool {
        let n = self.at & (N - 1);
        let [cos, sin] = plan.circle[n];
        for motion in &mut self.motion {
            motion.range(n, [cos, -sin]);
        }
        self.at = n + 1;
        self.at >= N
    }

    /// Largest value that the correction would reach.
    #[inline(always)]
    pub(super) fn judge(&mut self, infeed: Option<&Infeed<R>>) -> bool {
        let Some(infeed) = infeed else { return true };
        for i in 0..POINTS_PER_SLICE {
            let n = (self.at + i) & (N - 1);
            self.worst = R::max((self.correction[n] + infeed.gain * self.other[n]).abs(), self.worst);
        }
        self.at += POINTS_PER_SLICE;
        let done = self.at >= N;
        if done && self.worst > infeed.limit {
            self.result.flags.set(GaugeFlags::INFEED_FROZEN);
        }
        done
    }

    #[inline(always)]
    pub(super) fn commit(&mut self, infeed: Option<&Infeed<R>>) -> bool {
        let Some(infeed) = infeed else { return true };
        let (keep, gain) = if self.gives_way() { (R::ONE - infeed.gain, R::ZERO) } else { (R::ONE, infeed.gain) };
        for i in 0..POINTS_PER_SLICE {
            let n = (self.at + i) & (N - 1);
            self.correction[n] = keep * self.correction[n] + gain * self.other[n];
        }
        self.at += POINTS_PER_SLICE;
        self.at >= N
    }

    #[inline(always)]
    pub(super) fn zero(&mut self) -> bool {
        for i in 0..POINTS_PER_SLICE {
            self.correction[(self.at + i) & (N - 1)] = R::ZERO;
        }
        self.at += POINTS_PER_SLICE;
        self.at >= N
    }

    /// Peak to valley about the least-squares circle: mean and first harmonic are not in the profile.
    #[inline(always)]
    pub(super) fn measure(&mut self, plan: &Plan<R, N>) -> bool {
        let profile = if plan.filtered.is_some() { &self.other } else { &self.profile };
        let [mut low, mut high] = self.range;
        for i in 0..POINTS_PER_SLICE {
            let value = profile[(self.at + i) & (N - 1)];
            low = R::min(value, low);
            high = R::max(value, high);
        }
        self.range = [low, high];
        self.result.peak_to_valley_um = high - low;
        self.at += POINTS_PER_SLICE;
        self.at >= N
    }
}
