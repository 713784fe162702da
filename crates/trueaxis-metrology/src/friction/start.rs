//! Starting values: the best of a coarse grid, each with its best-fitting Coulomb friction.

use super::parameters::{COULOMB, FEED_FORWARD, POSITION_GAIN, PRESLIDING, Problem, READING_LAG, RESET_TIME, Values};
use std::vec::Vec;
use trueaxis::machine::{DriveFigures, FrictionSettings};

/// Initial friction: Stribeck share and velocity are typical of slideways.
const TYPICAL: FrictionSettings = FrictionSettings {
    coulomb_per_s: 0.3,
    stribeck_share: 0.2,
    stribeck_velocity_per_s: 2.0,
    presliding: 0.005,
    viscous: 0.0,
    lead_s: 0.0,
    adapt: 0.0,
};
/// Initial drive; current loop and dead time are not fitted.
pub(super) const DRIVE: DriveFigures = DriveFigures {
    position_gain_per_s: 60.0,
    velocity_gain_per_s: 500.0,
    reset_time_s: 0.01,
    velocity_feed_forward: 0.5,
    current_loop_s: 2.5e-4,
    dead_time_s: 0.0,
    resonance_hz: 0.0,
    resonance_damping: 0.0,
    lowest_resonance_hz: 0.0,
    gain_without_notch: 0.0,
};
const PRESLIDINGS: [f64; 3] = [0.002, 0.008, 0.04];
const POSITION_GAINS: [f64; 4] = [15.0, 40.0, 90.0, 200.0];
const RESET_TIMES: [f64; 3] = [0.004, 0.012, 0.04];

/// Best starting values on a coarse grid; `given` are the drive's figures if known.
pub(super) fn start(problem: &Problem, given: Option<&DriveFigures>) -> Values {
    let lag_s = lag(problem);
    let mut candidates: Vec<Values> = Vec::new();
    match given {
        Some(drive) => {
            let mut values = Values::new(drive, &TYPICAL);
            values.0[READING_LAG] = lag_s - (1.0 - drive.velocity_feed_forward) / drive.position_gain_per_s;
            candidates.push(values);
        }
        None => {
            let read_s = problem.read_after_s.map_or(0.0, |after| -after);
            for gain in POSITION_GAINS {
                for reset in RESET_TIMES {
                    let mut values = Values::new(&DRIVE, &TYPICAL);
                    values.0[POSITION_GAIN] = gain;
                    values.0[RESET_TIME] = reset;
                    values.0[READING_LAG] = read_s;
                    values.0[FEED_FORWARD] = (1.0 - gain * (lag_s - read_s)).clamp(0.0, 1.0);
                    candidates.push(values);
                }
            }
        }
    }
    let tried = candidates.iter().flat_map(|values| PRESLIDINGS.map(|z| scaled(problem, values, z)));
    let best = tried.min_by(|one, other| one.0.total_cmp(&other.0));
    best.map_or_else(|| Values::new(given.unwrap_or(&DRIVE), &TYPICAL), |(_, values)| values)
}

/// Cost and values for this pre-sliding travel, with the Coulomb friction whose linear response fits best.
fn scaled(problem: &Problem, values: &Values, presliding: f64) -> (f64, Values) {
    let mut values = *values;
    values.0[PRESLIDING] = presliding;
    let mut none = values;
    none.0[COULOMB] = 0.0;
    let calm = problem.model(&none);
    let slipping = problem.model(&values);
    let [mut product, mut square] = [0.0; 2];
    for k in (0..calm.len()).filter(|k| problem.counts(*k)) {
        let response = slipping[k] - calm[k];
        product += response * (problem.error[k] - calm[k]);
        square += response * response;
    }
    let factor = if square > 0.0 { (product / square).clamp(0.01, 100.0) } else { 1.0 };
    values.0[COULOMB] *= factor;
    let cost = problem.residuals(&values).iter().map(|r| r * r).sum();
    (cost, values)
}

/// Following error per commanded velocity, s: (1 − k_ff)/K_v plus the lag of the reading.
fn lag(problem: &Problem) -> f64 {
    let samples: Vec<f64> = problem.command.iter().copied().step_by(problem.fine).collect();
    let [mut product, mut square] = [0.0; 2];
    for (k, (pair, error)) in samples.windows(2).zip(&problem.error).enumerate() {
        if !problem.counts(k) {
            continue;
        }
        let velocity = (pair[1] - pair[0]) / problem.sample_s();
        product += velocity * error;
        square += velocity * velocity;
    }
    if square > 0.0 { product / square } else { 0.0 }
}
