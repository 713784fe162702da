//! The part of the lag and acceleration feed-forward that all axes have in common, and the share of it that is sent.
//!
//! A lag of the same time on every axis makes the tool late on its path; it does not move it off the path. Where a limit
//! does not admit the whole correction, this part gives way, by one factor λ for all axes: then d stays parallel to the
//! path, while a limit that binds axis by axis turns a harmless error along the path into one across it.
//!
//! ```text
//! m  <- (m + ΔA) e^(−T/τ)           A = a/K_vp, with the means of K_vp and τ
//! q  <- κ q + (m/K + L v)(1 − κ)    κ = e^(−T/t), L, t, 1/K: the means of (1 − k_ff)/K_v, k_ff/K_v, 1/K_v
//! d wanted = w − (1 − λ) q          w: the sum of all parts
//! ```
//!
//! with the same constants on every axis that compensates its lag, rotary ones included: q is a function of time alone,
//! applied to each coordinate. λ is the largest number from 0 to 1 for which
//!
//! ```text
//! |w − (1 − λ) q| <= C of d,  |c + w − (1 − λ) q| <= C of the axis,  |Δ(λ q)| <= V
//! ```
//!
//! hold on every axis towards which q points; it does not fall faster than V permits either. Without a limit that binds
//! λ = 1, and w passes bit for bit. Friction, the differences of the axes from their mean, feedback and the rest of w are
//! not scaled. Cost: 70 instructions a cycle on a Cortex-M4F, for three axes; while a limit binds, also up to three divisions
//! per axis.

#![deny(clippy::indexing_slicing)]

use super::Dynamics;
use super::feed_forward::Shares;
use crate::machine::{AxisSettings, DriveFigures};
use crate::real::Real;

/// Constants of the common part, lengths per period.
#[derive(Clone, Copy, Debug)]
pub(super) struct Common<R> {
    keep: R,
    /// L (1 − κ)/T.
    lag: R,
    /// (1 − κ)/(K K_vp T²): multiplies a change of the velocity.
    acceleration: R,
    /// e^(−T/τ).
    decay: R,
}

/// Common part of an axis.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shared<R> {
    /// q, mm (deg), and its value of the cycle before.
    offset: R,
    before: R,
    /// m (1 − κ)/K, and A likewise.
    missing: R,
    force: R,
}

/// Limits of an axis, mm (deg) and per period.
#[derive(Clone, Copy, Debug)]
pub(super) struct Room<R> {
    /// C of d and of the axis.
    pub(super) magnitude: R,
    pub(super) whole: R,
    /// V.
    pub(super) slope: R,
}

/// What an axis wants in a cycle, mm (deg).
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted<R> {
    /// w.
    pub(super) sum: R,
    /// c.
    pub(super) geometric: R,
}

impl<R: Real> Common<R> {
    /// The common part of these axes; `None` if none of them compensates its lag.
    pub(super) fn new<'m>(axes: impl Iterator<Item = &'m AxisSettings>, period_s: f64) -> Option<Self> {
        let mut sums = [0.0; 5];
        let (mut count, mut accelerates) = (0.0, true);
        for settings in axes.filter(|settings| shares(settings)) {
            let (Some(drive), Some(dynamic)) = (&settings.servo.drive, &settings.servo.dynamic) else { continue };
            let DriveFigures { position_gain_per_s: kv, velocity_gain_per_s: kvp, .. } = *drive;
            let figures =
                [dynamic.lag_s(drive), drive.velocity_feed_forward / kv, 1.0 / kv, 1.0 / kvp, drive.reset_time_s];
            sums.iter_mut().zip(figures).for_each(|(sum, figure)| *sum += figure);
            count += 1.0;
            accelerates &= dynamic.acceleration;
        }
        if count == 0.0 {
            return None;
        }
        let [lag_s, filter_s, per_gain, per_velocity_gain, reset_s] = sums.map(|sum| sum / count);
        let keep = if filter_s > 0.0 { libm::exp(-period_s / filter_s) } else { 0.0 };
        let acceleration = (1.0 - keep) * per_gain / period_s * per_velocity_gain / period_s;
        Some(Common {
            keep: R::of(keep),
            lag: R::of((1.0 - keep) * lag_s / period_s),
            acceleration: R::of(if accelerates { acceleration } else { 0.0 }),
            decay: R::of(libm::exp(-period_s / reset_s)),
        })
    }

    /// Moves the common part of an axis by a cycle in which it moves by `way`, `change` more than before. `supplied`: the
    /// drive already supplies the present force.
    #[inline(always)]
    pub(super) fn advance(
        &self,
        state: &mut Shared<R>,
        (way, change): (R, R),
        parts: Dynamics,
        supplied: bool,
        shares: Option<&Shares<R>>,
    ) {
        let force = if parts.has(Dynamics::ACCELERATION) { self.acceleration * change } else { R::ZERO };
        let mut rise = if supplied { R::ZERO } else { force - state.force };
        let mut lag = if parts.has(Dynamics::LAG) { self.lag * way } else { R::ZERO };
        if let Some(shares) = shares {
            (rise, lag) = (shares.acceleration * rise, shares.lag * lag);
        }
        state.missing = (state.missing + rise) * self.decay;
        state.before = state.offset;
        state.offset = state.offset * self.keep + (state.missing + lag);
        state.force = force;
    }
}

/// Whether an axis takes part: it compensates its lag.
pub(super) fn shares(settings: &AxisSettings) -> bool {
    settings.servo.drive.is_some() && settings.servo.dynamic.is_some_and(|dynamic| dynamic.lag)
}

impl<R: Real> Shared<R> {
    /// Sets the axis to rest.
    #[inline(always)]
    pub(super) fn rest(&mut self) {
        self.missing = R::ZERO;
    }

    /// What is not sent of q at this λ.
    #[inline(always)]
    pub(super) fn withheld(&self, share: R) -> R {
        (R::ONE - share) * self.offset
    }
}

/// λ of a cycle, from that of the cycle before.
#[inline(never)]
pub(super) fn share<R: Real, const N: usize>(
    before: R,
    axes: &[Shared<R>; N],
    wanted: &[Wanted<R>; N],
    rooms: &[Room<R>; N],
) -> R {
    let mut share = R::ONE;
    for ((axis, Wanted { sum, geometric }), room) in axes.iter().zip(wanted).zip(rooms) {
        let size = axis.offset.abs();
        let (sum, geometric) = if axis.offset < R::ZERO { (-*sum, -*geometric) } else { (*sum, *geometric) };
        // What remains of the magnitudes in the direction of q.
        let beyond = sum - room.magnitude.min(room.whole - geometric);
        if beyond > (R::ONE - share) * size {
            share = if beyond < size { R::ONE - beyond / size } else { R::ZERO };
        }
        let fastest = axis.sent(before) + room.slope;
        if share * size > fastest {
            share = fastest.max(R::ZERO) / size;
        }
    }
    // Falling too fast would move the other axes off the path, which is worse than one that its limiter holds back.
    for (axis, room) in axes.iter().zip(rooms) {
        let (size, slowest) = (axis.offset.abs(), axis.sent(before) - room.slope);
        if share * size < slowest {
            share = if slowest < size { slowest / size } else { R::ONE };
        }
    }
    share
}

impl<R: Real> Shared<R> {
    /// λ q of the cycle before, in the direction of q.
    #[inline(always)]
    fn sent(&self, share: R) -> R {
        let sent = share * self.before;
        if self.offset < R::ZERO { -sent } else { sent }
    }
}
