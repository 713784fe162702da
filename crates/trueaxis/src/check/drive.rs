//! A servo drive as a linear system: its characteristic polynomial, and its stability.

use crate::machine::{DriveFigures, FrictionSettings};

/// Stiffness of pre-sliding friction at rest over the moved mass, 1/s²: K_vp (F_c/K_vp) (1 + s)/z.
pub(super) fn stiffness(drive: &DriveFigures, friction: &FrictionSettings) -> f64 {
    drive.velocity_gain_per_s * friction.coulomb_per_s * (1.0 + friction.stribeck_share) / friction.presliding
}

/// Characteristic polynomial of a drive with its position loop, velocity loop (proportional and integral), current loop
/// and a mass on a spring of `stiffness`, from the constant term on, times τ:
///
/// ```text
/// τ s (1 + s t_c)(s² + k) + K_vp (τ s + 1)(s + K_v)
/// ```
pub(super) fn characteristic(drive: &DriveFigures, stiffness: f64) -> [f64; 5] {
    let DriveFigures {
        position_gain_per_s: kv, velocity_gain_per_s: kvp, reset_time_s: tau, current_loop_s: tc, ..
    } = *drive;
    [kvp * kv, tau * stiffness + kvp * (1.0 + tau * kv), tau * (tc * stiffness + kvp), tau, tau * tc]
}

/// Whether all roots of the characteristic polynomial lie to the left of the imaginary axis (Routh).
pub(super) fn is_stable(drive: &DriveFigures, stiffness: f64) -> bool {
    let [a0, a1, a2, a3, a4] = characteristic(drive, stiffness);
    let b = a2 * a3 - a4 * a1;
    b > 0.0 && b * a1 > a3 * a3 * a0
}
