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
use super::motion::{Bundle, Direction, ErrorMotion, gather};
use super::settings::GaugeSettings;
use super::transform::{
    AMPLITUDE_SCALE, Complex, Pairs, circle, multipliers, pair_slice, slices, slices_of_twos, spectrum, without_mean,
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

/// Every stage of a transform is a task, so that its distances are constants of a slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Task {
    Idle,
    Forward0,
    Forward1,
    Forward2,
    Forward3,
    Forward4,
    ForwardTwos,
    SpreadShifted,
    SpreadProfile,
    SpreadInfeed,
    SpreadFiltered,
    /// Amplitudes of the profile.
    Harmonics,
    InverseTwos,
    Inverse4,
    Inverse3,
    Inverse2,
    Inverse1,
    Inverse0,
    Arm,
    Orbit,
    /// Before, between and after the two passes over a full window, a slice each.
    Open,
    Evaluate,
    Scale,
    Express,
    Close,
    Judge,
    Commit,
    Clear,
    Range,
    /// β at every point, for another radius of the wheel.
    Linkage,
    /// The drift of the radius out of the weighted sum.
    Level,
}

/// Immutable: multipliers of the four uses, and constants.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan<R, const N: usize> {
    pub(super) circle: [Complex<R>; N],
    profile: [R; N],
    pub(super) shifted: Option<[R; N]>,
    pub(super) infeed: Option<[R; N]>,
    pub(super) filtered: Option<[R; N]>,
    /// Buffer with the profile as probe 2 sees it: one of its own, or the profile itself, φ2 in whole slots further on.
    ahead: usize,
    slots: usize,
    cot2: R,
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
    /// Slices of the task that are left.
    pub(super) left: usize,
    pairs: Pairs,
    /// Buffer in which the inverse goes on: 0 the profile, 1 the other.
    into: usize,
    pub(super) task: Task,
    /// Use of the spectrum that is being worked out.
    of: Use,
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
    /// Radius at the first point and its change from point to point, against the probes' zeros, µm.
    radius: [R; 2],
    /// Motion along X and Y, over all points.
    directions: [Direction<R>; 2],
    /// Error motions along X and Y over the last full window, and its revolutions.
    pub(super) error_motion: [ErrorMotion<R>; 2],
    pub(super) window: u16,
    /// Spectrum of the profile, in the scale of the multipliers.
    harmonics: [Complex<R>; HARMONICS],
    /// The profile, and what another use of the spectrum gives.
    buffers: [[R; N]; 2],
    /// X and Y of the motion at every point, over the revolutions of the window.
    bundles: [[Bundle<R>; 2]; N],
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
            ahead: usize::from(gain.slots().is_none()),
            cot2: R::of(cos2 / sin2),
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

    /// The task that comes after the one just done, and the use of the spectrum for which it is.
    fn next(&self, work: &Work<R, N>) -> (Task, Use) {
        let task = match work.task {
            Task::Linkage if work.drift != R::ZERO => Task::Level,
            Task::Linkage | Task::Level => Task::Forward0,
            Task::SpreadProfile => Task::Harmonics,
            Task::Inverse0 => match work.of {
                Use::Shifted => return Use::Profile.spread(),
                Use::Profile if self.has_arm => Task::Arm,
                Use::Profile => Task::Orbit,
                Use::Infeed => Task::Judge,
                Use::Filtered => Task::Range,
            },
            Task::Arm => Task::Orbit,
            Task::Orbit if work.gathered >= self.revolutions => Task::Open,
            Task::Open => Task::Evaluate,
            Task::Evaluate => Task::Scale,
            Task::Scale => Task::Express,
            Task::Express => Task::Close,
            Task::Orbit | Task::Close if self.infeed.is_some() => return Use::Infeed.spread(),
            Task::Judge if !work.result.flags.has(GaugeFlags::INFEED_FROZEN) || work.gives_way() => Task::Commit,
            Task::Orbit | Task::Close | Task::Judge | Task::Commit if self.filtered.is_some() => {
                return Use::Filtered.spread();
            }
            Task::Orbit | Task::Close | Task::Judge | Task::Commit => Task::Range,
            Task::Range | Task::Clear | Task::Idle => Task::Idle,
            of_transform => match following::<N>(of_transform) {
                Some(task) => task,
                None if self.shifted.is_some() => return Use::Shifted.spread(),
                None => return Use::Profile.spread(),
            },
        };
        (task, work.of)
    }
}

/// The stage of a transform that follows a stage or a pair pass; none behind the last of the forward transform.
const fn following<const N: usize>(task: Task) -> Option<Task> {
    match task {
        Task::Forward0 => const { first_of::<N>(&FORWARD, 1) },
        Task::Forward1 => const { first_of::<N>(&FORWARD, 2) },
        Task::Forward2 => const { first_of::<N>(&FORWARD, 3) },
        Task::Forward3 => const { first_of::<N>(&FORWARD, 4) },
        Task::Forward4 => const { first_of::<N>(&FORWARD, 5) },
        Task::ForwardTwos => None,
        Task::InverseTwos => const { first_of::<N>(&INVERSE, 1) },
        Task::Inverse4 => const { first_of::<N>(&INVERSE, 2) },
        Task::Inverse3 => const { first_of::<N>(&INVERSE, 3) },
        Task::Inverse2 => const { first_of::<N>(&INVERSE, 4) },
        Task::Inverse1 => const { first_of::<N>(&INVERSE, 5) },
        _ => const { first_of::<N>(&INVERSE, 0) },
    }
}

/// The first of some stages, from an index on, that N points have.
const fn first_of<const N: usize>(stages: &[(Task, Stage); 6], mut index: usize) -> Option<Task> {
    while index < stages.len() {
        let (task, stage) = stages[index];
        let slices = match stage {
            Stage::Four(stage) => slices::<N>(stage),
            Stage::Two => slices_of_twos::<N>(),
        };
        if slices > 0 {
            return Some(task);
        }
        index += 1;
    }
    None
}

/// A stage of a transform: one of radix 4, or that of radix 2.
#[derive(Clone, Copy, Debug)]
enum Stage {
    Four(usize),
    Two,
}

/// The forward transform's stages in their order.
const FORWARD: [(Task, Stage); 6] = [
    (Task::Forward0, Stage::Four(0)),
    (Task::Forward1, Stage::Four(1)),
    (Task::Forward2, Stage::Four(2)),
    (Task::Forward3, Stage::Four(3)),
    (Task::Forward4, Stage::Four(4)),
    (Task::ForwardTwos, Stage::Two),
];

/// The inverse transform's stages in their order.
const INVERSE: [(Task, Stage); 6] = [
    (Task::InverseTwos, Stage::Two),
    (Task::Inverse4, Stage::Four(4)),
    (Task::Inverse3, Stage::Four(3)),
    (Task::Inverse2, Stage::Four(2)),
    (Task::Inverse1, Stage::Four(1)),
    (Task::Inverse0, Stage::Four(0)),
];

impl Use {
    /// The pair pass for a use.
    const fn spread(self) -> (Task, Use) {
        let task = match self {
            Use::Shifted => Task::SpreadShifted,
            Use::Profile => Task::SpreadProfile,
            Use::Infeed => Task::SpreadInfeed,
            Use::Filtered => Task::SpreadFiltered,
        };
        (task, self)
    }
}

impl<R: Real, const N: usize> Work<R, N> {
    pub(super) const fn new() -> Self {
        Work {
            task: Task::Idle,
            left: 0,
            pairs: Pairs::NONE,
            into: 0,
            of: Use::Shifted,
            buffers: [[R::ZERO; N]; 2],
            harmonics: [[R::ZERO; 2]; HARMONICS],
            bundles: [[[R::ZERO; 3]; 2]; N],
            directions: [Direction::NEW; 2],
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
        self.start(Task::Clear);
        (self.gathered, self.clear) = (0, true);
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
            Task::Forward0
        };
        self.drift = drift;
        // From the first point on; the mean is that of the middle.
        let step = drift * plan.per_mean * R::of(1.0 / N as f64);
        self.radius = [mean * plan.per_mean - step * R::of((N as f64 - 1.0) / 2.0), step];
        self.limited_for = if limited { self.limited_for.saturating_add(1) } else { 0 };
        self.linking = self.ratio(plan);
        self.start(first);
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

    /// The profile.
    pub(super) fn profile(&self) -> &[R; N] {
        &self.buffers[0]
    }

    /// Before the first slice of a task.
    #[inline(always)]
    fn start(&mut self, task: Task) {
        (self.task, self.left) = (task, Plan::<R, N>::slices_of(task));
    }

    /// The buffer in which an inverse goes on.
    #[inline(always)]
    pub(super) fn buffer(&mut self) -> &mut [R; N] {
        &mut self.buffers[self.into & 1]
    }

    /// From one task to the next; true when the result stands.
    #[inline(always)]
    pub(super) fn finish(&mut self, plan: &Plan<R, N>, infeed: Option<&Infeed<R>>) -> bool {
        let finished = self.task;
        if finished == Task::Judge && infeed.is_some_and(|infeed| self.worst > infeed.limit) {
            self.result.flags.set(GaugeFlags::INFEED_FROZEN);
        }
        match finished {
            Task::Arm if self.worst > plan.arm_tolerance => {
                self.result.flags.set(GaugeFlags::ARM);
                self.result.flags.set(GaugeFlags::INFEED_FROZEN);
            }
            // A motion by a linkage that is contradicted says nothing: the window begins anew.
            Task::Orbit if self.result.flags.has(GaugeFlags::ARM) => self.gathered = 0,
            Task::Orbit => self.gathered = self.gathered.saturating_add(1),
            Task::Clear => (self.clear, self.limited_for) = (false, 0),
            Task::Judge if self.gives_way() => self.result.flags.set(GaugeFlags::INFEED_REDUCED),
            Task::Linkage => self.linked = self.linking,
            Task::SpreadShifted | Task::SpreadProfile | Task::SpreadInfeed | Task::SpreadFiltered => {
                without_mean(self.buffer());
            }
            Task::Range => {
                let [low, high] = self.range;
                self.result.peak_to_valley_um = high - low;
            }
            _ => {}
        }
        let (task, of) = plan.next(self);
        self.start(task);
        self.of = of;
        self.worst = R::ZERO;
        self.range = [R::MAX, -R::MAX];
        self.pairs = Pairs::START;
        self.into = usize::from(self.of != Use::Profile);
        finished == Task::Range
    }

    /// One pair of the profile.
    #[inline(always)]
    pub(super) fn spread_profile(&mut self, plan: &Plan<R, N>, sum: &[R; N], at: usize) {
        let [profile, _] = &mut self.buffers;
        pair_slice(sum, profile, &plan.circle, &plan.profile, &mut self.pairs, at);
    }

    /// One pair, for another use.
    #[inline(always)]
    pub(super) fn spread(&mut self, plan: &Plan<R, N>, sum: &[R; N], multipliers: Option<&[R; N]>, at: usize) {
        if let ([_, other], Some(multipliers)) = (&mut self.buffers, multipliers) {
            pair_slice(sum, other, &plan.circle, multipliers, &mut self.pairs, at);
        }
    }

    /// One amplitude of the profile.
    #[inline(always)]
    pub(super) fn keep_harmonic(&mut self, plan: &Plan<R, N>, at: usize) {
        let k = at + 1;
        let [profile, _] = &self.buffers;
        if let Some(kept) = self.harmonics.get_mut(k) {
            *kept = spectrum(profile, &plan.circle, k);
        }
    }

    /// Harmonics that are kept, without the mean.
    pub(super) const AMPLITUDES: usize = if HARMONICS < N / 2 { HARMONICS - 1 } else { N / 2 - 1 };

    /// Before the first pass over a full window.
    pub(super) fn open(&mut self) {
        self.directions.iter_mut().for_each(Direction::begin);
    }

    /// Between the passes.
    pub(super) fn scale(&mut self) {
        self.directions.iter_mut().for_each(|direction| direction.express(N));
    }

    /// After the passes.
    pub(super) fn close(&mut self) {
        self.error_motion = self.directions.map(|direction| direction.result());
        (self.window, self.gathered) = (self.gathered, 0);
    }

    /// Takes a steady change of the radius out of the weighted sum: it is no harmonic, but would look like all of them.
    #[inline(always)]
    pub(super) fn level(&mut self, sum: &mut [R; N], at: usize) {
        for i in 0..POINTS_PER_SLICE {
            let n = (POINTS_PER_SLICE * at + i) & (N - 1);
            sum[n] -= self.drift * Self::turned(n);
        }
    }

    /// Fraction of the revolution at a point, from its middle.
    #[inline(always)]
    fn turned(n: usize) -> R {
        R::of_i32(n as i32) * R::of(1.0 / N as f64) - R::of((N as f64 - 1.0) / (2.0 * N as f64))
    }

    /// β at one point.
    #[inline(always)]
    pub(super) fn link(&mut self, plan: &Plan<R, N>, at: usize) {
        let n = at & (N - 1);
        let [cos, sin] = plan.circle[n];
        let [cos, sin] = arm_angle(self.linking, [cos, -sin]);
        self.linkage[n] = [cos - R::ONE, sin];
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
    pub(super) fn compare_arm(&mut self, revolution: &Revolution<R, N>, at: usize) {
        let at = at & (ARM_CHECKS - 1);
        let [_, expected] = self.linkage[(at * (N / ARM_CHECKS)) & (N - 1)];
        let beta = R::of_i32(revolution.beta[at]) * R::of(core::f64::consts::TAU / 4_294_967_296.0);
        let square = beta * beta;
        let found = beta
            * (R::ONE - square * (R::of(1.0 / 6.0) - square * (R::of(1.0 / 120.0) - square * R::of(1.0 / 5040.0))));
        self.worst = R::max((found - expected).abs(), self.worst);
    }

    /// Motion of the centre at one point; it joins those of the window.
    ///
    /// With t = (h2 − r(θ + φ2) − cos φ2 (h1 − r(θ)))/sin φ2: R_X = t cos β + (h1 − r) sin β, R_Y = (h1 − r) cos β − t sin β.
    #[inline(always)]
    pub(super) fn orbit(&mut self, plan: &Plan<R, N>, revolution: &mut Revolution<R, N>, at: usize) {
        let n = at & (N - 1);
        let [less, sin] = self.linkage[n];
        let cos = less + R::ONE;
        let ahead = self.buffers[plan.ahead & 1][(n + plan.slots) & (N - 1)];
        let [begin, step] = self.radius;
        let radius = begin + R::of_i32(n as i32) * step;
        let first = revolution.first[n] - self.buffers[0][n] - radius;
        let second = revolution.second[n] - ahead - radius;
        let across = second * plan.per_sin2 - first * plan.cot2;
        let x = cos * across + sin * first;
        let y = cos * first - sin * across;
        (revolution.first[n], revolution.second[n]) = (x, y);
        let begins = self.gathered == 0;
        let [of_x, of_y] = &mut self.bundles[n];
        (*of_x, *of_y) = (gather(*of_x, x, begins), gather(*of_y, y, begins));
    }

    #[inline(always)]
    pub(super) fn evaluate(&mut self, plan: &Plan<R, N>, at: usize) {
        let n = at & (N - 1);
        let [cos, sin] = plan.circle[n];
        for (direction, bundle) in self.directions.iter_mut().zip(&mut self.bundles[n]) {
            direction.evaluate(bundle, [cos, -sin], plan.per_revolutions);
        }
    }

    #[inline(always)]
    pub(super) fn express(&mut self, plan: &Plan<R, N>, at: usize) {
        let n = at & (N - 1);
        let [cos, sin] = plan.circle[n];
        for (direction, bundle) in self.directions.iter_mut().zip(&self.bundles[n]) {
            direction.range(*bundle, [cos, -sin]);
        }
    }

    /// Largest value that the correction would reach.
    #[inline(always)]
    pub(super) fn judge(&mut self, infeed: Option<&Infeed<R>>, at: usize) {
        let Some(infeed) = infeed else { return };
        for i in 0..POINTS_PER_SLICE {
            let n = (POINTS_PER_SLICE * at + i) & (N - 1);
            self.worst = R::max((self.correction[n] + infeed.gain * self.buffers[1][n]).abs(), self.worst);
        }
    }

    #[inline(always)]
    pub(super) fn commit(&mut self, infeed: Option<&Infeed<R>>, at: usize) {
        let Some(infeed) = infeed else { return };
        let (keep, gain) = if self.gives_way() { (R::ONE - infeed.gain, R::ZERO) } else { (R::ONE, infeed.gain) };
        for i in 0..POINTS_PER_SLICE {
            let n = (POINTS_PER_SLICE * at + i) & (N - 1);
            self.correction[n] = keep * self.correction[n] + gain * self.buffers[1][n];
        }
    }

    #[inline(always)]
    pub(super) fn zero(&mut self, at: usize) {
        for i in 0..POINTS_PER_SLICE {
            self.correction[(POINTS_PER_SLICE * at + i) & (N - 1)] = R::ZERO;
        }
    }

    /// Peak to valley about the least-squares circle: mean and first harmonic are not in the profile.
    #[inline(always)]
    pub(super) fn measure(&mut self, plan: &Plan<R, N>, at: usize) {
        let profile = &self.buffers[usize::from(plan.filtered.is_some())];
        let [mut low, mut high] = self.range;
        for i in 0..POINTS_PER_SLICE {
            let value = profile[(POINTS_PER_SLICE * at + i) & (N - 1)];
            low = R::min(value, low);
            high = R::max(value, high);
        }
        self.range = [low, high];
    }
}
