//! The drive of an axis and its friction in continuous time, simulated along recorded commands.
//!
//! ```text
//! r  = K_v (c(t − t_d) − x) + k_ff c'(t − t_d − t_f)
//! q' = (r − v)/τ                                    integrator of the velocity loop
//! m' = (K_vp (r − v + q) − m)/t_c                   current loop
//! v' = m − F − d v,   x' = v
//! F  = F_c (1 + s/(1 + (v/v_s)²)) f,   f' = (v − |v| f)/z
//! ```
//!
//! The linear part is exact over a step (exponential of its matrix, command and friction linear in time within the step). f is
//! exact for the mean velocity of the step, which a first pass with constant friction predicts, so the method is of second
//! order. This code serves only the fit and is independent of the simulator's plant and of the servo step.

use nalgebra::SMatrix;
use std::vec::Vec;
use trueaxis::machine::{DriveFigures, FrictionSettings};

/// States x, v, q, m; then the inputs c, c', F, F' and the fed-forward velocity.
const SIZE: usize = 9;
const STATES: usize = 4;
const INPUTS: usize = SIZE - STATES;

/// A simulated axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    pub(super) drive: DriveFigures,
    pub(super) friction: FrictionSettings,
    /// t_f: lag of the feed-forward behind the command, s.
    pub(super) feed_lag_s: f64,
    /// State of friction before the first motion, −1 to 1.
    pub(super) rest: f64,
}

/// Positions at the samples of a command with period `step_s`, starting at rest or in even motion.
pub(super) fn positions(axis: &Axis, command: &[f64], step_s: f64) -> Vec<f64> {
    let late = delayed(command, axis.drive.dead_time_s / step_s);
    let [Some(&first), Some(&second)] = [late.first(), late.get(1)] else { return late };
    let fed = delayed(command, (axis.drive.dead_time_s + axis.feed_lag_s) / step_s);
    let next = transition(axis, step_s);
    let gain = axis.drive.velocity_gain_per_s;
    let z = axis.friction.presliding;
    let velocity = (second - first) / step_s;
    let mut shift = if velocity == 0.0 { axis.rest } else { velocity.signum() };
    let mut force = gain * level(&axis.friction, velocity) * shift;
    let held = force + axis.friction.viscous * gain * velocity;
    let lag = (1.0 - axis.drive.velocity_feed_forward) * velocity / axis.drive.position_gain_per_s;
    let mut state = [first - lag, velocity, held / gain, held];
    let mut out = Vec::with_capacity(late.len());
    out.push(state[0]);
    for (pair, fed) in late.windows(2).zip(fed.windows(2)) {
        let mut inputs = [pair[0], (pair[1] - pair[0]) / step_s, force, 0.0, (fed[1] - fed[0]) / step_s];
        let predicted = row(&next[1], &state, &inputs);
        let mean = 0.5 * (state[1] + predicted);
        let way = mean.signum();
        shift = way + (shift - way) * (-mean.abs() * step_s / z).exp();
        let after = gain * level(&axis.friction, predicted) * shift;
        inputs[3] = (after - force) / step_s;
        state = [0, 1, 2, 3].map(|i| row(&next[i], &state, &inputs));
        force = after;
        out.push(state[0]);
    }
    out
}

/// Sliding friction at a velocity, over K_vp: F_c (1 + s/(1 + (v/v_s)²))/K_vp.
pub(super) fn level(friction: &FrictionSettings, velocity: f64) -> f64 {
    let ratio = velocity / friction.stribeck_velocity_per_s;
    friction.coulomb_per_s * (1.0 + friction.stribeck_share / (1.0 + ratio * ratio))
}

/// Values delayed by `samples` (which may be fractional), linear between samples; the first and last value extend beyond the
/// ends.
pub(super) fn delayed(values: &[f64], samples: f64) -> Vec<f64> {
    if samples == 0.0 || values.is_empty() {
        return values.to_vec();
    }
    let last = values.len() - 1;
    let at = |k: usize| {
        let place = (k as f64 - samples).max(0.0).min(last as f64);
        let (index, part) = ((place as usize).min(last), place.fract());
        values[index] + part * (values[(index + 1).min(last)] - values[index])
    };
    (0..values.len()).map(at).collect()
}

fn row(next: &[f64; SIZE], state: &[f64; STATES], inputs: &[f64; INPUTS]) -> f64 {
    let [x, v, q, m, c, rate, force, change, fed] = *next;
    x * state[0]
        + v * state[1]
        + q * state[2]
        + m * state[3]
        + c * inputs[0]
        + rate * inputs[1]
        + force * inputs[2]
        + change * inputs[3]
        + fed * inputs[4]
}

/// Rows x, v, q, m of e^(A h).
fn transition(axis: &Axis, step_s: f64) -> [[f64; SIZE]; STATES] {
    let drive = &axis.drive;
    let [kv, kvp, feed] = [drive.position_gain_per_s, drive.velocity_gain_per_s, drive.velocity_feed_forward];
    let [per_reset, per_current] = [1.0 / drive.reset_time_s, 1.0 / drive.current_loop_s];
    let mut a = SMatrix::<f64, SIZE, SIZE>::zeros();
    let mut set = |row: usize, values: &[(usize, f64)]| {
        for &(column, value) in values {
            a[(row, column)] = value * step_s;
        }
    };
    set(0, &[(1, 1.0)]);
    set(1, &[(1, -axis.friction.viscous * kvp), (3, 1.0), (6, -1.0)]);
    set(2, &[(0, -kv * per_reset), (1, -per_reset), (4, kv * per_reset), (8, feed * per_reset)]);
    let force = kvp * per_current;
    set(3, &[(0, -force * kv), (1, -force), (2, force), (3, -per_current), (4, force * kv), (8, force * feed)]);
    set(4, &[(5, 1.0)]);
    set(6, &[(7, 1.0)]);
    let whole = a.exp();
    std::array::from_fn(|i| std::array::from_fn(|j| whole[(i, j)]))
}

/// Position offset u that feeds the friction of `command` forward, the law for a drive with K_v, τ and k_ff:
///
/// ```text
/// h <- (h + ΔF/K_vp) e^(−T/τ),   u <- u + T (h − K_v u)/k_ff      (k_ff = 0: u = h/K_v)
/// ```
pub(super) fn feed_forward(axis: &Axis, command: &[f64], step_s: f64) -> Vec<f64> {
    let (drive, friction) = (&axis.drive, &axis.friction);
    let fade = (-step_s / drive.reset_time_s).exp();
    let [mut shift, mut before, mut wanted, mut offset] = [axis.rest, f64::NAN, 0.0, 0.0];
    let mut out = Vec::with_capacity(command.len());
    for k in 0..command.len() {
        let velocity = if k == 0 { 0.0 } else { (command[k] - command[k - 1]) / step_s };
        let travel = velocity * step_s / friction.presliding;
        shift = (shift + travel) / (1.0 + travel.abs());
        let force = level(friction, velocity) * shift + friction.viscous * velocity;
        wanted = if before.is_nan() { 0.0 } else { (wanted + force - before) * fade };
        before = force;
        let kff = drive.velocity_feed_forward;
        offset = if kff > 0.0 {
            // Implicit: stable for every k_ff.
            (offset + step_s * wanted / kff) / (1.0 + step_s * drive.position_gain_per_s / kff)
        } else {
            wanted / drive.position_gain_per_s
        };
        out.push(offset);
    }
    out
}
