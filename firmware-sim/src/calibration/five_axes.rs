//! Centre lines of a five-axis machine.

use super::{Conditions, run};
use anyhow::Result;
use serde::Serialize;
use trueaxis_sim::calibration::{Class, random_five_axis};

/// How far the centre lines that were found are from the true ones.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FiveAxes {
    /// Seed.
    pub seed: u64,
    /// Largest error of a centre line's place, µm.
    pub place_um: f64,
    /// Largest error of a tilt, µrad.
    pub tilt_urad: f64,
    /// The largest of either that was there to be found.
    pub true_um_urad: [f64; 2],
}

/// Calibrates the five-axis machine of a seed by a task, like [`FIVE_AXES`].
///
/// # Errors
/// Whatever planning, probing or solving refuses.
pub fn five_axes(seed: u64, task: &str, class: &Class, conditions: &Conditions) -> Result<FiveAxes> {
    let truth = random_five_axis(seed, class);
    let calibrated = run(task, &truth, seed, conditions)?;
    let (true_ones, found) = (truth.settings.location.rotary, calibrated.known.settings.location.rotary);
    let mut outcome = FiveAxes { seed, place_um: 0.0, tilt_urad: 0.0, true_um_urad: [0.0; 2] };
    for (axis, free) in [(0, [1, 2, 4, 5]), (2, [0, 1, 3, 4])] {
        for component in free {
            let (truth, away) = (true_ones[axis][component], found[axis][component] - true_ones[axis][component]);
            if component < 3 {
                outcome.place_um = outcome.place_um.max(1e3 * away.abs());
                outcome.true_um_urad[0] = outcome.true_um_urad[0].max(1e3 * truth.abs());
            } else {
                outcome.tilt_urad = outcome.tilt_urad.max(1e6 * away.abs());
                outcome.true_um_urad[1] = outcome.true_um_urad[1].max(1e6 * truth.abs());
            }
        }
    }
    Ok(outcome)
}
