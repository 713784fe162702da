//! One lag for all axes, where the uncertainties of their drives' figures explain the differences.
//!
//! An axis compensates the lag L = (1 − k_ff)/K_v. A lag that all axes have in common does not move the tool off its path,
//! but a difference that exists only in the figures does. With the standard uncertainty of each lag,
//!
//! ```text
//! u²(L) = (L u(K_v)/K_v)² + (u(k_ff)/K_v)²       mean L = Σ L/u² / Σ 1/u²       χ² = Σ (L − mean L)²/u²
//! ```
//!
//! the axes take the mean if χ² does not exceed its 95 % quantile for n − 1 degrees of freedom. An axis without stated
//! uncertainty counts as exact: then every axis keeps its own lag.

use trueaxis::machine::MachineSettings;
use trueaxis_metrology::uncertainty::chi_squared_quantile;

/// Standard uncertainties of a drive's figures; 0: taken as exact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct DriveUncertainty {
    pub(super) position_gain_per_s: f64,
    pub(super) velocity_feed_forward: f64,
}

/// Gives every axis that compensates its lag the mean, if the differences are not significant. `uncertain`: one entry per
/// axis. A lag that the machine states itself stays.
pub(super) fn apply(settings: &mut MachineSettings, uncertain: &[DriveUncertainty]) {
    let own = settings.axes.iter().zip(uncertain).filter_map(|(axis, uncertain)| {
        let (drive, dynamic) = (axis.servo.drive?, axis.servo.dynamic.filter(|dynamic| dynamic.lag)?);
        let (lag, gain) = (drive.lag_s(), drive.position_gain_per_s);
        let parts = [lag * uncertain.position_gain_per_s / gain, uncertain.velocity_feed_forward / gain];
        Some((lag, parts[0].hypot(parts[1]), dynamic.lag_s > 0.0))
    });
    let own: Vec<(f64, f64, bool)> = own.collect();
    if own.iter().any(|(_, uncertainty, stated)| *uncertainty <= 0.0 || *stated) {
        return;
    }
    if own.len() < 2 {
        return;
    }
    let weights: f64 = own.iter().map(|(_, u, _)| 1.0 / (u * u)).sum();
    let mean = own.iter().map(|(lag, u, _)| lag / (u * u)).sum::<f64>() / weights;
    let spread: f64 = own.iter().map(|(lag, u, _)| ((lag - mean) / u).powi(2)).sum();
    if mean > 0.0 && spread <= chi_squared_quantile(0.95, own.len() as f64 - 1.0) {
        let dynamics = settings.axes.iter_mut().filter_map(|axis| axis.servo.dynamic.as_mut());
        dynamics.filter(|dynamic| dynamic.lag).for_each(|dynamic| dynamic.lag_s = mean);
    }
}
