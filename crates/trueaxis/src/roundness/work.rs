//! The work on one revolution, in slices of fixed size.
//!
//! ```text
//! Linkage (another wheel) ─► Level (drift) ─► Forward ─► Spread, Inverse (profile at θ + φ2)
//!   ─► Spread, Harmonics, Inverse (profile) ─► Arm ─► Orbit ─► Open, Evaluate, Scale, Express, Close (once a window)
//!   ─► Spread, Inverse, Judge, Commit (infeed) ─► Spread, Inverse (filter) ─► Range
//! ```
//!
//! Building the gauge selects the tasks that it needs; a slice is bounded for any data. The table in `tasks.rs` lists
//! the work of each task in a slice and its number of slices; `Work::next` determines the order of tasks.

use super::arm_angle;
use super::flags::GaugeFlags;
use super::infeed::Infeed;
use super::motion::{Bundle, Direction, ErrorMotion, gather};
use super::plan::{Plan, Task, Use, following};
use super::transform::{AMPLITUDE_SCALE, Complex, Pairs, pair_slice, spectrum, without_mean};
use crate::real::Real;

/// Harmonics 0 to 127 of the profile are stored as amplitudes.
pub const HARMONICS: usize = 128;
/// Points of a revolution at which the arm's reading is compared with the linkage.
pub(super) const ARM_CHECKS: usize = 16;
/// Consecutive revolutions with a limited infeed axis before the correction is reduced.
const PATIENCE: u8 = 4;
/// Points per slice in passes that only compare or add.
pub(super) const POINTS_PER_SLICE: usize = 4;

/// Readings of one revolution; the work replaces them by the motion of the centre.
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

/// A whole revolution, as handed over to the work.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beginning<R> {
    pub(super) revolution: u32,
    pub(super) flags: GaugeFlags,
    /// Whether the infeed axis was limited.
    pub(super) limited: bool,
    /// Mean of the weighted sum, and its change from the previous revolution.
    pub(super) mean: R,
    pub(super) drift: R,
}

/// Result of the revolution being processed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome<R> {
    pub(super) revolution: u32,
    pub(super) flags: GaugeFlags,
    pub(super) peak_to_valley_um: R,
}

impl<R: Real> Outcome<R> {
    pub(super) const NONE: Outcome<R> = Outcome { revolution: 0, flags: GaugeFlags(0), peak_to_valley_um: R::ZERO };
}

/// State of the work, and its results. The fields that every slice needs come first, within reach of short offsets.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Work<R, const N: usize> {
    /// Slices left in the task.
    pub(super) left: usize,
    pairs: Pairs,
    /// Buffer in which the inverse continues: 0 the profile, 1 the other.
    into: usize,
    pub(super) task: Task,
    /// Use of the spectrum that the current inverse computes.
    pub(super) of: Use,
    /// Revolutions in the window of the motion so far.
    pub(super) gathered: u16,
    /// λ of the arm, if the wheel's radius was set later, and the λ for which the linkage was computed.
    pub(super) ratio: Option<R>,
    linked: R,
    /// λ for which the linkage is being computed.
    linking: R,
    /// Smallest and largest value of a pass.
    range: [R; 2],
    worst: R,
    pub(super) result: Outcome<R>,
    clear: bool,
    /// Consecutive revolutions in which the infeed axis was limited.
    limited_for: u8,
    /// Change of the weighted sum per revolution.
    pub(super) drift: R,
    /// Radius at the first point and its change from point to point, relative to the probes' zeros, µm.
    radius: [R; 2],
    /// Motion along X and Y, over all points.
    directions: [Direction<R>; 2],
    /// Error motions along X and Y over the last full window, and the number of its revolutions.
    pub(super) error_motion: [ErrorMotion<R>; 2],
    pub(super) window: u16,
    /// Spectrum of the profile, in the scale of the multipliers.
    harmonics: [Complex<R>; HARMONICS],
    /// The profile, and the result of another use of the spectrum.
    buffers: [[R; N]; 2],
    /// X and Y of the motion at every point, over the revolutions of the window.
    bundles: [[Bundle<R>; 2]; N],
    pub(super) correction: [R; N],
    /// [cos β − 1, sin β] at every point; all zero for a fixed arm.
    linkage: [Complex<R>; N],
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

    /// Whether the correction is being cleared or is due to be cleared.
    pub(super) fn is_cleared(&self) -> bool {
        self.clear
    }

    /// For a new part: drops the work in progress and sets the correction to zero.
    #[cold]
    pub(super) fn clear(&mut self) {
        self.start(Task::Clear);
        (self.gathered, self.clear) = (0, true);
        (self.error_motion, self.window) = ([ErrorMotion::NONE; 2], 0);
    }

    /// Starts the work on a revolution.
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
        // The radius counts from the first point; the mean applies at the middle.
        let step = drift * plan.per_mean * R::of(1.0 / N as f64);
        self.radius = [mean * plan.per_mean - step * R::of((N as f64 - 1.0) / 2.0), step];
        self.limited_for = if limited { self.limited_for.saturating_add(1) } else { 0 };
        self.linking = self.ratio(plan);
        self.start(first);
        self.result = Outcome { revolution, flags, ..Outcome::NONE };
    }

    /// Whether the axis has been unable to follow for several revolutions: freezing the correction would then keep it
    /// limited permanently.
    pub(super) fn gives_way(&self) -> bool {
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

    /// Starts a task at its first slice.
    #[inline(always)]
    fn start(&mut self, task: Task) {
        (self.task, self.left) = (task, Plan::<R, N>::slices_of(task));
    }

    /// The buffer in which an inverse continues.
    #[inline(always)]
    pub(super) fn buffer(&mut self) -> &mut [R; N] {
        &mut self.buffers[self.into & 1]
    }

    /// Task after the one just finished, and the use of the spectrum that it serves.
    fn next(&self, plan: &Plan<R, N>) -> (Task, Use) {
        let task = match self.task {
            Task::Linkage if self.drift != R::ZERO => Task::Level,
            Task::Linkage | Task::Level => Task::Forward0,
            Task::SpreadProfile => Task::Harmonics,
            Task::Inverse0 => match self.of {
                Use::Shifted => return Use::Profile.spread(),
                Use::Profile if plan.has_arm => Task::Arm,
                Use::Profile => Task::Orbit,
                Use::Infeed => Task::Judge,
                Use::Filtered => Task::Range,
            },
            Task::Arm => Task::Orbit,
            Task::Orbit if self.gathered >= plan.revolutions => Task::Open,
            Task::Open => Task::Evaluate,
            Task::Evaluate => Task::Scale,
            Task::Scale => Task::Express,
            Task::Express => Task::Close,
            Task::Orbit | Task::Close if plan.infeed.is_some() => return Use::Infeed.spread(),
            Task::Judge if !self.result.flags.has(GaugeFlags::INFEED_FROZEN) || self.gives_way() => Task::Commit,
            Task::Orbit | Task::Close | Task::Judge | Task::Commit if plan.filtered.is_some() => {
                return Use::Filtered.spread();
            }
            Task::Orbit | Task::Close | Task::Judge | Task::Commit => Task::Range,
            Task::Range | Task::Clear | Task::Idle => Task::Idle,
            of_transform => match following::<N>(of_transform) {
                Some(task) => task,
                None if plan.shifted.is_some() => return Use::Shifted.spread(),
                None => return Use::Profile.spread(),
            },
        };
        (task, self.of)
    }

    /// Moves from one task to the next; returns true when the result is complete.
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
            // Motion from a contradicted linkage is meaningless: the window starts over.
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
        let (task, of) = self.next(plan);
        self.start(task);
        self.of = of;
        self.worst = R::ZERO;
        self.range = [R::MAX, -R::MAX];
        self.pairs = Pairs::START;
        self.into = usize::from(self.of != Use::Profile);
        finished == Task::Range
    }

    /// Computes one pair of the profile.
    #[inline(always)]
    pub(super) fn spread_profile(&mut self, plan: &Plan<R, N>, sum: &[R; N], at: usize) {
        let [profile, _] = &mut self.buffers;
        pair_slice(sum, profile, &plan.circle, &plan.profile, &mut self.pairs, at);
    }

    /// Computes one pair for another use.
    #[inline(always)]
    pub(super) fn spread(&mut self, plan: &Plan<R, N>, sum: &[R; N], multipliers: Option<&[R; N]>, at: usize) {
        if let ([_, other], Some(multipliers)) = (&mut self.buffers, multipliers) {
            pair_slice(sum, other, &plan.circle, multipliers, &mut self.pairs, at);
        }
    }

    /// Stores one amplitude of the profile.
    #[inline(always)]
    pub(super) fn keep_harmonic(&mut self, plan: &Plan<R, N>, at: usize) {
        let k = at + 1;
        let [profile, _] = &self.buffers;
        if let Some(kept) = self.harmonics.get_mut(k) {
            *kept = spectrum(profile, &plan.circle, k);
        }
    }

    /// Number of harmonics stored, without the mean.
    pub(super) const AMPLITUDES: usize = if HARMONICS < N / 2 { HARMONICS - 1 } else { N / 2 - 1 };

    /// Prepares the first pass over a full window.
    pub(super) fn open(&mut self) {
        self.directions.iter_mut().for_each(Direction::begin);
    }

    /// Prepares the second pass.
    pub(super) fn scale(&mut self) {
        self.directions.iter_mut().for_each(|direction| direction.express(N));
    }

    /// Stores the results of the passes.
    pub(super) fn close(&mut self) {
        self.error_motion = self.directions.map(|direction| direction.result());
        (self.window, self.gathered) = (self.gathered, 0);
    }

    /// Removes a steady change of the radius from the weighted sum: the change is not periodic and would leak into all
    /// harmonics.
    #[inline(always)]
    pub(super) fn level(&mut self, sum: &mut [R; N], at: usize) {
        for i in 0..POINTS_PER_SLICE {
            let n = (POINTS_PER_SLICE * at + i) & (N - 1);
            sum[n] -= self.drift * Self::turned(n);
        }
    }

    /// Fraction of the revolution at a point, measured from the middle.
    #[inline(always)]
    fn turned(n: usize) -> R {
        R::of_i32(n as i32) * R::of(1.0 / N as f64) - R::of((N as f64 - 1.0) / (2.0 * N as f64))
    }

    /// Computes β at one point.
    #[inline(always)]
    pub(super) fn link(&mut self, plan: &Plan<R, N>, at: usize) {
        let n = at & (N - 1);
        let [cos, sin] = plan.circle[n];
        let [cos, sin] = arm_angle(self.linking, [cos, -sin]);
        self.linkage[n] = [cos - R::ONE, sin];
    }

    /// λ of the arm for the present wheel.
    #[inline(always)]
    fn ratio(&self, plan: &Plan<R, N>) -> R {
        self.ratio.unwrap_or(plan.ratio)
    }

    /// cos β at a point.
    #[inline(always)]
    pub(super) fn cos_beta(&self, index: usize) -> R {
        self.linkage.get(index).map_or(R::ONE, |[less, _]| *less + R::ONE)
    }

    /// Compares sin β of the reading with sin β of the linkage, at one of the [`ARM_CHECKS`] points.
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

    /// Computes the motion of the centre at one point and adds it to the window.
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

    /// Finds the largest value that the correction would reach.
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

    /// Measures peak to valley about the least-squares circle: the profile contains no mean and no first harmonic.
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
