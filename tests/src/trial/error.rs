//! Remaining error on a track: the contour error and the vibration in it.

use serde::Serialize;
use std::f64::consts::TAU;

/// Frequency above which a motion counts as vibration, Hz.
const VIBRATION_HZ: f64 = 10.0;

/// Contour error of the load, µm.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Size {
    /// Exceeded in one cycle of a thousand.
    pub p999: f64,
    /// Root of the mean square.
    pub rms: f64,
}

impl Size {
    /// Size of signed errors, µm.
    pub(super) fn of(errors: &[f64]) -> Size {
        let mut sizes: Vec<f64> = errors.iter().map(|error| error.abs()).collect();
        let at = sizes.len() - 1 - sizes.len() / 1000;
        let p999 = *sizes.select_nth_unstable_by(at, f64::total_cmp).1;
        Size { p999, rms: rms(errors) }
    }
}

/// RMS in the last quarter of the part of a signed error above [`VIBRATION_HZ`] (high-pass of first order): an instability,
/// also one that the force limits of the drives bound.
pub(super) fn late_vibration(errors: &[f64], period_s: f64) -> f64 {
    let share = 1.0 - (-TAU * VIBRATION_HZ * period_s).exp();
    let mut slow = errors.first().copied().unwrap_or(0.0);
    let fast: Vec<f64> = errors
        .iter()
        .map(|error| {
            slow += share * (error - slow);
            error - slow
        })
        .collect();
    rms(&fast[fast.len() - fast.len() / 4..])
}

/// Amplitude at a frequency of a series sampled every `period_s`, under a Hann window: a slow motion of any size leaks little.
pub(super) fn amplitude(series: &[f64], period_s: f64, hz: f64) -> f64 {
    let count = series.len() as f64;
    let (mut re, mut im) = (0.0, 0.0);
    for (k, value) in series.iter().enumerate() {
        let window = 1.0 - (TAU * (k as f64 + 0.5) / count).cos();
        let (sin, cos) = (TAU * (hz * period_s * k as f64).fract()).sin_cos();
        re += window * value * cos;
        im += window * value * sin;
    }
    2.0 * re.hypot(im) / count
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_amplitude_is_found_beside_a_slow_motion_and_beyond_half_the_sampling_rate() {
        for hz in [83.0, 412.0, 890.0] {
            let series: Vec<f64> = (0..1600)
                .map(|k| {
                    let t = f64::from(k) * 1e-3;
                    5.0 * (TAU * hz * t).sin() + 40.0 * (TAU * 0.7 * t).sin()
                })
                .collect();
            let found = amplitude(&series, 1e-3, hz);
            assert!((found - 5.0).abs() < 0.02, "{hz} Hz: {found}");
        }
    }

    #[test]
    fn a_late_vibration_is_what_oscillates_at_the_end() {
        let growing = |k: u32| (f64::from(k) * 1e-3 - 1.0).exp() * (TAU * 50.0 * f64::from(k) * 1e-3).sin();
        let series = |vibrates: f64| -> Vec<f64> { (0..2000).map(|k| 30.0 + vibrates * growing(k)).collect() };
        assert!(late_vibration(&series(0.0), 1e-3) < 1e-9);
        let found = late_vibration(&series(1.0), 1e-3);
        assert!((1.0..2.0).contains(&found), "{found}");
    }
}
