//! Figures of both runs side by side.

use super::result::Run;
use super::spindle::sum;
use super::{Grinding, Linkage};
use crate::error::Result;
use std::f64::consts::TAU;
use trueaxis::roundness::ErrorMotion;

/// Results of grinding without and with correction.
#[derive(Debug)]
pub struct Outcome {
    /// Correction off, the gauge measuring.
    pub uncorrected: Run,
    /// Correction on.
    pub corrected: Run,
    /// True error motion of the corrected pin's centre, X and Y: the spindle's, and the eccentricity with which the pin has
    /// been ground.
    pub motion: [ErrorMotion<f64>; 2],
    /// Motion of that centre over θ in a mean revolution, [R_X, R_Y], µm.
    pub orbit: Vec<[f64; 2]>,
}

/// Spindle angle at an angle of the surface, by fixed-point iteration of θ = α + β(α).
pub(super) fn alpha_at(linkage: &Linkage, theta: f64) -> f64 {
    (0..60).fold(theta, |alpha, _| theta - linkage.beta(alpha))
}

/// Points over θ at which the true motion is evaluated.
const MOTION_POINTS: usize = 1024;

/// Motion of the pin's centre over θ in a mean revolution, [R_X, R_Y], µm.
///
/// The first harmonic a cos s + b sin s of the pin's surface is a displacement of its centre, which rotates with it: R_Y += a
/// cos α + b sin α, R_X += b cos α − a sin α.
fn true_orbit(grinding: &Grinding, run: &Run) -> Result<Vec<[f64; 2]>> {
    let linkage = Linkage::of(grinding.gauge()?);
    let motion = &grinding.process.motion;
    let [a, b] = run.average.get(1).copied().unwrap_or_default();
    let at = |n: usize| {
        let alpha = alpha_at(&linkage, TAU * n as f64 / MOTION_POINTS as f64);
        let (sin, cos) = libm::sincos(alpha);
        let ground = [b * cos - a * sin, a * cos + b * sin];
        std::array::from_fn(|i| {
            ground[i] + sum(&motion.eccentricity[i..=i], alpha) + sum(&motion.synchronous[i], alpha)
        })
    };
    Ok((0..MOTION_POINTS).map(at).collect())
}

/// Figures of the true motion over the window of the gauge, by their definitions, without white noise.
fn true_motion(grinding: &Grinding, run: &Run) -> Result<[ErrorMotion<f64>; 2]> {
    let gauge = grinding.gauge()?;
    let linkage = Linkage::of(gauge);
    let window = u32::from(gauge.revolutions).min(grinding.revolutions);
    let orbit = true_orbit(grinding, run)?;
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
    };
    let of = |i: usize| {
        let n = MOTION_POINTS as f64;
        let (mut mean, mut a, mut b) = (0.0, 0.0, 0.0);
        for (k, point) in orbit.iter().enumerate() {
            let (sin, cos) = libm::sincos(TAU * k as f64 / n);
            mean += point[i] / n;
            a += 2.0 * point[i] * cos / n;
            b += 2.0 * point[i] * sin / n;
        }
        let (mut left, mut widest, mut total) = (Vec::new(), 0.0_f64, [f64::INFINITY, f64::NEG_INFINITY]);
        for (k, point) in orbit.iter().enumerate() {
            let theta = TAU * k as f64 / n;
            let (sin, cos) = libm::sincos(theta);
            let rest = point[i] - mean - a * cos - b * sin;
            left.push(rest);
            let alpha = alpha_at(&linkage, theta);
            let turn = |m: u32| alpha + TAU * f64::from(grinding.revolutions - window + m);
            let [low, high] = range(&mut (0..window).map(|m| sum(&grinding.process.motion.asynchronous[i], turn(m))));
            widest = widest.max(high - low);
            total = [total[0].min(rest + low), total[1].max(rest + high)];
        }
        let [low, high] = range(&mut left.iter().copied());
        ErrorMotion {
            synchronous_um: high - low,
            asynchronous_um: widest,
            once_per_revolution_um: [a, b],
            total_um: total[1] - total[0],
        }
    };
    Ok([of(0), of(1)])
}

impl Outcome {
    pub(super) fn new(grinding: &Grinding, uncorrected: Run, corrected: Run) -> Result<Outcome> {
        Ok(Outcome {
            motion: true_motion(grinding, &corrected)?,
            orbit: true_orbit(grinding, &corrected)?,
            uncorrected,
            corrected,
        })
    }

    /// Synchronous imprint with correction divided by that without.
    pub fn imprint_ratio(&self) -> f64 {
        self.corrected.imprint_um / self.uncorrected.imprint_um
    }

    /// Cycles of both runs in which a correction exceeded a limit.
    pub fn limits_exceeded(&self) -> u64 {
        self.uncorrected.limits_exceeded + self.corrected.limits_exceeded
    }
}
