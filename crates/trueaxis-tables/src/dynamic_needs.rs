//! Magnitudes that the parts of the dynamic correction need, beside its limit, axis by axis.

use crate::Machine;
use crate::text::{micro, short};
use serde::Serialize;
use std::fmt;
use trueaxis::machine::{AxisSettings, DriveFigures, DynamicSettings};

/// Magnitude limit of an axis' dynamic correction, and the magnitudes that its parts need. Lengths in µm (rotary: µrad), feeds
/// in mm/min (degrees/min), accelerations in mm/s² (degrees/s²). `None`: the axis does not have the part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DynamicNeed {
    /// The axis.
    pub axis: char,
    /// Unit of feeds: mm/min or deg/min.
    pub feed_unit: &'static str,
    /// Unit of `limit_micro` and all needs: um or urad.
    pub micro_unit: &'static str,
    /// Magnitude limit of the dynamic correction.
    pub limit_micro: f64,
    /// Declared highest feed.
    pub max_feed_per_min: f64,
    /// Lag that is compensated, ms.
    pub lag_ms: Option<f64>,
    /// Whether all axes compensate this lag because their drives do not differ significantly.
    pub lag_is_common: bool,
    /// Feed at which lag alone meets the limit.
    pub lag_meets_limit_at_feed_per_min: Option<f64>,
    /// Magnitude that lag needs at the declared feed.
    pub lag_needs_micro: Option<f64>,
    /// Magnitude that lag needs at the highest feed with contour feedback; linear axes.
    pub lag_needs_at_feedback_feed_micro: Option<f64>,
    /// Acceleration from rest at which its part alone meets the limit.
    pub acceleration_meets_limit_at_per_s2: Option<f64>,
    /// Magnitude that a reversal of friction needs at most.
    pub friction_needs_micro: Option<f64>,
}

/// The needs of every axis with a dynamic correction by lag, acceleration or friction.
pub fn dynamic_needs(machine: &Machine) -> Vec<DynamicNeed> {
    let feedback = machine.settings.contour.feedback.map(|feedback| feedback.max_feed_per_s);
    machine.settings.axes.iter().filter_map(|own| need(own, feedback)).collect()
}

fn need(own: &AxisSettings, feedback_feed_per_s: Option<f64>) -> Option<DynamicNeed> {
    let (axis, drive) = (own.axis, own.servo.drive.as_ref()?);
    let dynamic = own.servo.dynamic.unwrap_or(DynamicSettings::with_defaults(axis));
    let friction = own.servo.friction;
    if !dynamic.lag && !dynamic.acceleration && friction.is_none() {
        return None;
    }
    let (limit, peak) = (dynamic.limits.magnitude, peak_s(drive));
    let lag_s = dynamic.lag.then(|| dynamic.lag_s(drive));
    let at_feedback = feedback_feed_per_s.filter(|_| !axis.is_rotary());
    Some(DynamicNeed {
        axis: axis.letter(),
        feed_unit: if axis.is_rotary() { "deg/min" } else { "mm/min" },
        micro_unit: if axis.is_rotary() { "urad" } else { "um" },
        limit_micro: micro(axis, limit),
        max_feed_per_min: own.max_feed_per_s * 60.0,
        lag_ms: lag_s.map(|lag| lag * 1e3),
        lag_is_common: dynamic.lag && dynamic.lag_s > 0.0,
        lag_meets_limit_at_feed_per_min: lag_s.filter(|lag| *lag > 0.0).map(|lag| limit / lag * 60.0),
        lag_needs_micro: lag_s.map(|lag| micro(axis, lag * own.max_feed_per_s)),
        lag_needs_at_feedback_feed_micro: lag_s.zip(at_feedback).map(|(lag, feed)| micro(axis, lag * feed)),
        acceleration_meets_limit_at_per_s2: dynamic.acceleration.then(|| limit * drive.velocity_gain_per_s / peak),
        friction_needs_micro: friction.map(|friction| {
            let force = 2.0 * friction.coulomb_per_s * (1.0 + friction.stribeck_share);
            micro(axis, force * peak)
        }),
    })
}

/// Largest position offset per step of the force, in the velocities of the drive's figures, s: the maximum over t of
///
/// ```text
/// (e^(−t/τ) − e^(−K_v t/k_ff)) / (K_v − k_ff/τ)         1/K_v for k_ff = 0
/// ```
fn peak_s(drive: &DriveFigures) -> f64 {
    let (kv, tau, shared) = (drive.position_gain_per_s, drive.reset_time_s, drive.velocity_feed_forward);
    if shared == 0.0 {
        return 1.0 / kv;
    }
    let (fast, slow) = (kv / shared, 1.0 / tau);
    if (fast - slow).abs() < 1e-6 * slow {
        return tau / (shared * std::f64::consts::E);
    }
    let at = (fast / slow).ln() / (fast - slow);
    ((-at * slow).exp() - (-at * fast).exp()) / (shared * (fast - slow))
}

impl fmt::Display for DynamicNeed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let per_s2 = if self.feed_unit == "mm/min" { "mm/s²" } else { "deg/s²" };
        let (unit, micro) = (self.feed_unit, if self.micro_unit == "um" { "µm" } else { "µrad" });
        write!(f, "axis {}: dynamic correction limited to {:.1} {micro}", self.axis, self.limit_micro)?;
        if let (Some(needed), Some(lag)) = (self.lag_needs_micro, self.lag_ms) {
            let common = if self.lag_is_common { " common to all axes" } else { "" };
            write!(f, "; lag of {lag:.3} ms{common} needs {needed:.1} {micro}")?;
            write!(f, " at {} {unit}", short(self.max_feed_per_min))?;
            if let Some(feed) = self.lag_meets_limit_at_feed_per_min {
                write!(f, ", meets the limit at {} {unit}", short(feed.round()))?;
            }
        }
        if let Some(acceleration) = self.acceleration_meets_limit_at_per_s2 {
            write!(f, "; acceleration meets it at {} {per_s2}", short(acceleration.round()))?;
        }
        match self.friction_needs_micro {
            Some(needed) => write!(f, "; friction needs {needed:.1} {micro}"),
            None => Ok(()),
        }
    }
}
