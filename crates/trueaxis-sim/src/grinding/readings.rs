//! Readings of three probes on a rough-turned pin, as recorded by a gauge on the bench.

use super::outcome::alpha_at;
use super::{Grinding, Linkage, Noise, Workpiece, probe_angles};
use crate::error::Result;
use std::f64::consts::TAU;

/// Readings of probes 1, 2, 3 in µm at the points of `revolutions` revolutions, equidistant in θ from 0; the pin is not
/// ground.
///
/// Surface, motion of the centre and noise are those of a run with that seed.
///
/// # Errors
/// The machine has no gauge with infeed correction.
pub fn readings(grinding: &Grinding, revolutions: u32) -> Result<Vec<[f64; 3]>> {
    let gauge = grinding.gauge()?;
    let (linkage, phi) = (Linkage::of(gauge), probe_angles(gauge));
    let pin = Workpiece::turned(grinding.seed);
    let motion = &grinding.process.motion;
    let (mut noise, mut probe_noise) = (Noise::new(grinding.seed, 101), Noise::new(grinding.seed, 102));
    let points = u32::from(gauge.points);
    let at = |i: u32| {
        let theta = TAU * f64::from(i) / f64::from(points);
        let alpha = alpha_at(&linkage, theta);
        let [x, y] = motion.at(alpha).map(|part| part + noise.next(motion.noise_um));
        phi.map(|phi| {
            let (sin, cos) = libm::sincos(phi + theta - alpha);
            pin.at(theta + phi) + y * cos + x * sin + probe_noise.next(grinding.process.probe_noise_um)
        })
    };
    Ok((0..revolutions * points).map(at).collect())
}
