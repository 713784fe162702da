//! Plan of the work on a revolution: the tasks, their order, and the constants they need.

use super::angles::Gain;
use super::filter;
use super::settings::GaugeSettings;
use super::transform::{Complex, circle, multipliers, slices, slices_of_twos};
use crate::real::Real;

/// The radius drifts steadily if its change per revolution varies by less than this plus a quarter of it, µm.
const STEADY_UM: f64 = 0.2;
/// Uses of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    Shifted,
    Profile,
    Infeed,
    Filtered,
}

/// Every stage of a transform is a separate task, so that its distances are constants in a slice.
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
    /// One slice each before, between and after the two passes over a full window.
    Open,
    Evaluate,
    Scale,
    Express,
    Close,
    Judge,
    Commit,
    Clear,
    Range,
    /// Computes β at every point for another radius of the wheel.
    Linkage,
    /// Removes the drift of the radius from the weighted sum.
    Level,
}

/// Immutable: multipliers of the four uses, and constants.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan<R, const N: usize> {
    pub(super) circle: [Complex<R>; N],
    pub(super) profile: [R; N],
    pub(super) shifted: Option<[R; N]>,
    pub(super) infeed: Option<[R; N]>,
    pub(super) filtered: Option<[R; N]>,
    /// Buffer with the profile as probe 2 sees it: a separate one, or the profile itself, φ2 further on in whole slots.
    pub(super) ahead: usize,
    pub(super) slots: usize,
    pub(super) cot2: R,
    pub(super) per_sin2: R,
    pub(super) has_arm: bool,
    /// λ of the arm from the settings.
    pub(super) ratio: R,
    pub(super) arm_tolerance: R,
    pub(super) revolutions: u16,
    pub(super) per_revolutions: R,
    /// 1/G(0), from the mean of the weighted sum to the mean of the radius; 0 if the probes are blind to it.
    pub(super) per_mean: R,
    /// Change of the drift that is treated as zero, in the weighted sum.
    pub(super) steady: R,
}

impl<R: Real, const N: usize> Plan<R, N> {
    /// Builds the plan from checked settings.
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
}

/// Transform stage that follows a stage or a pair pass; `None` after the last of the forward transform.
pub(super) const fn following<const N: usize>(task: Task) -> Option<Task> {
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

/// The first stage, from an index on, that N points have.
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

/// A stage of a transform: one of radix 4, or the one of radix 2.
#[derive(Clone, Copy, Debug)]
enum Stage {
    Four(usize),
    Two,
}

/// Stages of the forward transform in their order.
const FORWARD: [(Task, Stage); 6] = [
    (Task::Forward0, Stage::Four(0)),
    (Task::Forward1, Stage::Four(1)),
    (Task::Forward2, Stage::Four(2)),
    (Task::Forward3, Stage::Four(3)),
    (Task::Forward4, Stage::Four(4)),
    (Task::ForwardTwos, Stage::Two),
];

/// Stages of the inverse transform in their order.
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
    pub(super) const fn spread(self) -> (Task, Use) {
        let task = match self {
            Use::Shifted => Task::SpreadShifted,
            Use::Profile => Task::SpreadProfile,
            Use::Infeed => Task::SpreadInfeed,
            Use::Filtered => Task::SpreadFiltered,
        };
        (task, self)
    }
}
