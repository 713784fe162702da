//! An axis of one or two masses in its loops, simulated along recorded commands.
//!
//! ```text
//! r  = K_v (c − y)(t − t_s) + k_ff c'(t − t_f)      position loop; t_s: age of what it compares
//! q' = (r − v_M)/τ                                  integrator of the velocity loop, closed on the motor
//! m' = (K_vp (r − v_M + q) − m)/t_c                 current loop
//! X' = V,   V' = m − R                              common centre
//! δ' = w,   w' = m/(1 − σ) + R/σ − 2 ζ ω_r w − ω_r² δ
//! R  = F + d v_L,   v_M = V + σ w,   v_L = V − (1 − σ) w
//! y  = X − (1 − σ) δ (scale on the load),   X + σ δ (encoder on the motor)
//! ```
//!
//! F is the friction of the load as in [`super::super::drive`], whose method this is: exact over a step with command, friction
//! and the change of y over its age linear in time.

use crate::friction::drive::level;
use nalgebra::SMatrix;
use std::vec::Vec;
use trueaxis::machine::{DriveFigures, FrictionSettings};

/// States X, V, δ, w, q, m.
const STATES: usize = 6;
/// The inputs position error of the command, friction and age of y, each followed by its rate; then the fed velocity.
const INPUTS: usize = 7;
const SIZE: usize = STATES + INPUTS;

/// Motor and load against each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Masses {
    /// ω_r, both masses free, 1/s.
    pub(super) omega: f64,
    /// ζ, share of critical.
    pub(super) damping: f64,
    /// σ, mass of the load over that of both.
    pub(super) share: f64,
    /// Whether a scale on the load is read, or else an encoder on the motor.
    pub(super) scale: bool,
}

/// A simulated axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plant {
    pub(super) drive: DriveFigures,
    pub(super) friction: FrictionSettings,
    /// State of friction before the first motion, −1 to 1.
    pub(super) rest: f64,
    /// t_f: lag of the feed-forward behind the command, s.
    pub(super) feed_lag_s: f64,
    /// t_s: age of the position and the command that the position loop compares, s.
    pub(super) age_s: f64,
    /// `None`: one rigid mass.
    pub(super) masses: Option<Masses>,
}

impl Plant {
    /// y of the states X and δ.
    fn read(&self, state: &[f64; STATES]) -> f64 {
        let Some(masses) = self.masses else { return state[0] };
        let arm = if masses.scale { masses.share - 1.0 } else { masses.share };
        state[0] + arm * state[2]
    }

    /// v_L of the velocities V and w.
    fn load_velocity(&self, velocity: f64, rate: f64) -> f64 {
        velocity - self.masses.map_or(0.0, |masses| (1.0 - masses.share) * rate)
    }

    /// Readings at the samples of a command with period `step_s`, from a start at rest or in even motion. `begin`: position
    /// and velocity there, if they are known.
    pub(super) fn positions(&self, command: &[f64], step_s: f64, begin: Option<[f64; 2]>) -> Vec<f64> {
        let dead = self.drive.dead_time_s;
        let [Some(&first), Some(&second)] = [command.first(), command.get(1)] else { return command.to_vec() };
        let ago = |seconds: f64| -> Vec<f64> {
            (0..command.len()).map(|k| past(command, k, seconds / step_s, second - first)).collect()
        };
        let (late, fed) = (ago(dead + self.age_s), ago(dead + self.feed_lag_s));
        let next = self.transition(step_s);
        let gain = self.drive.velocity_gain_per_s;
        let velocity = begin.map_or((second - first) / step_s, |[_, velocity]| velocity);
        let mut shift = if velocity == 0.0 { self.rest } else { velocity.signum() };
        let mut force = gain * level(&self.friction, velocity) * shift;
        let held = force + self.friction.viscous * gain * velocity;
        let lag = (1.0 - self.drive.velocity_feed_forward) * velocity / self.drive.position_gain_per_s;
        let apart = self.masses.map_or(0.0, |m| held / (m.share * (1.0 - m.share) * m.omega * m.omega));
        let mut state = [0.0, velocity, apart, 0.0, held / gain, held];
        state[0] = begin.map_or(late[0] + self.age_s * velocity - lag, |[position, _]| position) - self.read(&state);
        let ago = self.age_s / step_s;
        let mut out = Vec::with_capacity(late.len());
        out.push(self.read(&state));
        let mut change = -self.age_s * velocity;
        let mut slope = 0.0;
        for (k, (pair, fed)) in late.windows(2).zip(fed.windows(2)).enumerate() {
            let mut inputs =
                [pair[0], (pair[1] - pair[0]) / step_s, force, 0.0, change, slope, (fed[1] - fed[0]) / step_s];
            let predicted = [1, 3].map(|i| row(&next[i], &state, &inputs));
            let ends = [self.load_velocity(state[1], state[3]), self.load_velocity(predicted[0], predicted[1])];
            let mean = 0.5 * (ends[0] + ends[1]);
            let way = mean.signum();
            shift = way + (shift - way) * (-mean.abs() * step_s / self.friction.presliding).exp();
            let after = gain * level(&self.friction, ends[1]) * shift;
            inputs[3] = (after - force) / step_s;
            state = std::array::from_fn(|i| row(&next[i], &state, &inputs));
            force = after;
            out.push(self.read(&state));
            let aged = past(&out, k + 1, ago, velocity * step_s) - out[k + 1];
            slope = (aged - change) / step_s;
            change = aged;
        }
        out
    }

    /// Rows of e^(A h).
    fn transition(&self, step_s: f64) -> [[f64; SIZE]; STATES] {
        let drive = &self.drive;
        let [kv, kvp, feed] = [drive.position_gain_per_s, drive.velocity_gain_per_s, drive.velocity_feed_forward];
        let [per_reset, per_current] = [1.0 / drive.reset_time_s, 1.0 / drive.current_loop_s];
        let viscous = self.friction.viscous * kvp;
        let (share, arm) = self.masses.map_or((0.0, 0.0), |m| (m.share, if m.scale { m.share - 1.0 } else { m.share }));
        // The load's velocity, that of the motor, and y, in terms of the states.
        let load = [(1, 1.0), (3, share - 1.0)];
        let load = if self.masses.is_some() { &load[..] } else { &load[..1] };
        let motor = [(1, 1.0), (3, share)];
        let read = [(0, 1.0), (2, arm)];
        let mut a = SMatrix::<f64, SIZE, SIZE>::zeros();
        let mut add = |row: usize, factor: f64, values: &[(usize, f64)]| {
            for &(column, value) in values {
                a[(row, column)] += factor * value * step_s;
            }
        };
        add(0, 1.0, &[(1, 1.0)]);
        add(1, 1.0, &[(5, 1.0), (8, -1.0)]);
        add(1, -viscous, load);
        if let Some(Masses { omega, damping, .. }) = self.masses {
            add(2, 1.0, &[(3, 1.0)]);
            add(
                3,
                1.0,
                &[(5, 1.0 / (1.0 - share)), (8, 1.0 / share), (2, -omega * omega), (3, -2.0 * damping * omega)],
            );
            add(3, viscous / share, load);
        }
        // r − v_M, and with the integrator the force that the velocity loop asks for.
        for (row, factor) in [(4, per_reset), (5, kvp * per_current)] {
            add(row, factor * kv, &[(6, 1.0), (10, -1.0)]);
            add(row, -factor * kv, &read);
            add(row, factor * feed, &[(12, 1.0)]);
            add(row, -factor, &motor);
        }
        add(5, kvp * per_current, &[(4, 1.0)]);
        add(5, -per_current, &[(5, 1.0)]);
        for input in [6, 8, 10] {
            add(input, 1.0, &[(input + 1, 1.0)]);
        }
        let whole = a.exp();
        std::array::from_fn(|i| std::array::from_fn(|j| whole[(i, j)]))
    }
}

fn row(next: &[f64; SIZE], state: &[f64; STATES], inputs: &[f64; INPUTS]) -> f64 {
    let of_state: f64 = next[..STATES].iter().zip(state).map(|(a, b)| a * b).sum();
    let of_inputs: f64 = next[STATES..].iter().zip(inputs).map(|(a, b)| a * b).sum();
    of_state + of_inputs
}

/// The value `ago` samples before index `k`, linear between samples; before the first, it moved by `way` per sample.
fn past(values: &[f64], k: usize, ago: f64, way: f64) -> f64 {
    let place = k as f64 - ago;
    if place < 0.0 {
        return values[0] + place * way;
    }
    let index = (place as usize).min(values.len() - 1);
    let next = values.get(index + 1).unwrap_or(&values[index]);
    values[index] + (place - index as f64).min(1.0) * (next - values[index])
}

/// Values `ago` samples before each index (negative: after), by the cubic through the four nearest samples: a ring at a tenth
/// of the rate keeps its amplitude within 1 %.
pub(super) fn shifted(values: &[f64], ago: f64) -> Vec<f64> {
    let last = values.len().saturating_sub(1) as isize;
    let whole = ago.ceil();
    let part = whole - ago;
    let at = |k: isize| values[k.clamp(0, last) as usize];
    let cubic = |k: usize| {
        let from = k as isize - whole as isize;
        let [a, b, c, d] = [at(from - 1), at(from), at(from + 1), at(from + 2)];
        let u = part;
        -u * (u - 1.0) * (u - 2.0) / 6.0 * a + (u * u - 1.0) * (u - 2.0) / 2.0 * b - u * (u + 1.0) * (u - 2.0) / 2.0 * c
            + u * (u * u - 1.0) / 6.0 * d
    };
    (0..values.len()).map(cubic).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values from `tests/reference/two_masses.py`: exact, in positions and velocities of both masses.
    const AT: [usize; 6] = [4, 8, 21, 26, 31, 60];
    const MOTOR: [f64; 6] = [
        0.012_954_169_194_474_3,
        0.072_432_058_571_182_2,
        0.393_528_833_087_946,
        0.472_343_033_996_628,
        0.490_607_628_012_37,
        0.487_344_529_339_545,
    ];
    const SCALE: [f64; 6] = [
        0.001_511_052_062_052_17,
        0.064_036_693_340_854_5,
        0.396_882_963_385_766,
        0.494_287_174_905_062,
        0.481_654_824_565_79,
        0.487_318_413_114_976,
    ];

    #[test]
    fn a_ramp_is_followed_as_the_equations_of_motion_say() {
        let friction = FrictionSettings {
            coulomb_per_s: 0.0,
            stribeck_share: 0.0,
            stribeck_velocity_per_s: 2.0,
            presliding: 0.006,
            viscous: 0.01,
            lead_s: 0.0,
            adapt: 0.0,
        };
        let drive = DriveFigures { velocity_feed_forward: 0.7, ..DriveFigures::with_defaults(60.0, 350.0, 0.012) };
        let command: Vec<f64> = (0..=60).map(|k| 0.025 * f64::from((k - 2).clamp(0, 20))).collect();
        for (scale, expected) in [(false, MOTOR), (true, SCALE)] {
            let masses = Some(Masses { omega: std::f64::consts::TAU * 120.0, damping: 0.03, share: 0.4, scale });
            let plant = Plant { drive, friction, rest: 0.0, feed_lag_s: 0.0, age_s: 0.0, masses };
            let read = plant.positions(&command, 1e-3, None);
            for (k, expected) in AT.into_iter().zip(expected) {
                assert!((read[k] - expected).abs() < 1e-9, "{scale} {k}: {} {expected}", read[k]);
            }
        }
    }

    #[test]
    fn values_between_samples_keep_the_amplitude_of_a_ring() {
        let values: Vec<f64> = (0..200).map(|k| (0.1 * std::f64::consts::TAU * f64::from(k)).sin()).collect();
        for ago in [-1.3, -0.5, 0.0, 0.25, 1.75] {
            let moved = shifted(&values, ago);
            for (k, moved) in moved.iter().enumerate().take(190).skip(10) {
                let exact = (0.1 * std::f64::consts::TAU * (k as f64 - ago)).sin();
                assert!((moved - exact).abs() < 0.01, "{ago} {k}: {moved} {exact}");
            }
        }
    }
}
