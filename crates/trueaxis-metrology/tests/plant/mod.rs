//! A drive with friction and its encoder on circles, integrated independently of the crate.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;
use trueaxis::machine::{DriveFigures, FrictionSettings};

/// A circle: radius in mm, feed in mm/s (positive counterclockwise), turns.
pub(crate) type Circle = (f64, f64, f64);

/// Commands for circles about the origin, each from rest to rest with a sine-squared ramp of the feed over `ramp_s`.
pub(crate) fn commands(circles: &[Circle], period_s: f64, ramp_s: f64) -> [Vec<f64>; 2] {
    let mut angle = 0.3;
    let mut command = [Vec::new(), Vec::new()];
    let mut put = |angle: f64, radius: f64| {
        command[0].push(radius * angle.cos());
        command[1].push(radius * angle.sin());
    };
    for &(radius, feed, turns) in circles {
        for _ in 0..(0.1 / period_s) as usize {
            put(angle, radius);
        }
        let length = TAU * radius * turns;
        let duration = length / feed.abs() + ramp_s;
        for k in 0..(duration / period_s) as usize {
            let t = k as f64 * period_s;
            let edge = (t.min(duration - t) / ramp_s).min(1.0);
            angle += feed / radius * period_s * (0.25 * TAU * edge).sin().powi(2);
            put(angle, radius);
        }
    }
    command
}

/// Encoder of the plant: subdivisional error, noise, counts.
struct Encoder(ChaCha8Rng);

impl Encoder {
    fn read(&mut self, x: f64) -> f64 {
        let phase = TAU * x / 0.02;
        let noise: f64 = StandardNormal.sample(&mut self.0);
        ((x + 30e-6 * phase.sin() + 15e-6 * (2.0 * phase).sin() + 5e-6 * noise) / 10e-6).round() * 10e-6
    }
}

/// Position, velocity, integrator, torque and friction of a drive, integrated over `h` by Heun's method; `wanted` is the
/// velocity setpoint at the beginning and at the end, as a function of the position there.
fn carried_on(
    state: [f64; 5],
    h: f64,
    drive: &DriveFigures,
    friction: &FrictionSettings,
    wanted: [&dyn Fn(f64) -> f64; 2],
) -> [f64; 5] {
    let kvp = drive.velocity_gain_per_s;
    let slope = |[_, v, q, m, f]: [f64; 5], r: f64| {
        let ratio = v / friction.stribeck_velocity_per_s;
        let level = kvp * friction.coulomb_per_s * (1.0 + friction.stribeck_share / (1.0 + ratio * ratio));
        [
            v,
            m - level * f - kvp * friction.viscous * v,
            (r - v) / drive.reset_time_s,
            (kvp * (r - v + q) - m) / drive.current_loop_s,
            (v - v.abs() * f) / friction.presliding,
        ]
    };
    let one = slope(state, wanted[0](state[0]));
    let there: [f64; 5] = std::array::from_fn(|i| state[i] + h * one[i]);
    let two = slope(there, wanted[1](there[0]));
    std::array::from_fn(|i| state[i] + 0.5 * h * (one[i] + two[i]))
}

/// Readings of a drive with a digital position loop of this period; the inner loops are integrated in steps of at most 25 µs,
/// friction by the differential equation.
pub(crate) fn readings(
    command: &[f64],
    period_s: f64,
    drive: &DriveFigures,
    friction: &FrictionSettings,
    seed: u64,
) -> Vec<f64> {
    let steps = (period_s / 25e-6).ceil() as usize;
    let h = period_s / steps as f64;
    let mut encoder = Encoder(ChaCha8Rng::seed_from_u64(seed));
    let mut state = [command[0], 0.0, 0.0, 0.0, 0.0];
    let mut before = command[0];
    let mut reading = command[0];
    let mut out = Vec::new();
    for &now in command {
        let r =
            drive.position_gain_per_s * (before - reading) + drive.velocity_feed_forward * (now - before) / period_s;
        for _ in 0..steps {
            state = carried_on(state, h, drive, friction, [&|_| r, &|_| r]);
        }
        before = now;
        reading = encoder.read(state[0]);
        out.push(reading);
    }
    out
}

/// How a drive takes the commands of a record.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Commands {
    /// Held for a cycle, with the position loop closed once per cycle.
    Sampled,
    /// Held for a cycle, with the position loop closed continuously.
    Held,
    /// Linear from one command to the next.
    Linear,
}

/// Readings of a drive whose encoder is read after this share of each cycle.
pub(crate) fn read_within(
    command: &[f64],
    period_s: f64,
    (drive, friction): (&DriveFigures, &FrictionSettings),
    seed: u64,
    (commands, share): (Commands, f64),
) -> Vec<f64> {
    let steps = (period_s / 25e-6).ceil() as usize;
    let (gain, feed) = (drive.position_gain_per_s, drive.velocity_feed_forward / period_s);
    let mut encoder = Encoder(ChaCha8Rng::seed_from_u64(seed));
    let mut state = [command[0], 0.0, 0.0, 0.0, 0.0];
    let mut out = Vec::new();
    for (k, &now) in command.iter().enumerate() {
        let [before, next] = [command[k.saturating_sub(1)], command[(k + 1).min(command.len() - 1)]];
        let sampled = state[0];
        let wanted = |part: f64| {
            move |x: f64| match commands {
                Commands::Sampled => gain * (now - sampled) + feed * (now - before),
                Commands::Held => gain * (now - x) + feed * (now - before),
                Commands::Linear => gain * (now + part * (next - now) - x) + feed * (next - now),
            }
        };
        let mut reading = None;
        for i in 0..steps {
            let [from, to] = [i, i + 1].map(|i| i as f64 / steps as f64);
            reading = reading.or((from >= share).then_some(state[0]));
            state = carried_on(state, period_s / steps as f64, drive, friction, [&wanted(from), &wanted(to)]);
        }
        out.push(encoder.read(reading.unwrap_or(state[0])));
    }
    out
}

/// Motor and load of a drive, and where it is read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mechanics {
    /// Frequency with both masses free, Hz, and its damping, share of critical. 0: one rigid mass.
    pub(crate) resonance_hz: f64,
    pub(crate) damping: f64,
    /// Mass of the load over that of both.
    pub(crate) share: f64,
    /// Whether a scale on the load is read, or else an encoder on the motor.
    pub(crate) scale: bool,
    /// Play between motor and load, mm.
    pub(crate) play: f64,
    /// Standard deviation of a reading, mm.
    pub(crate) noise: f64,
    /// Smallest step of a reading, mm.
    pub(crate) count: f64,
    /// A second resonance of the load, of a tenth of its mass: frequency with the rest held, Hz; 0: none.
    pub(crate) second_hz: f64,
}

/// Readings of a motor that moves a load through a spring and a damper, with a digital position loop of this period. Positions
/// and velocities of motor and load are integrated separately, by the method of Runge and Kutta of fourth order.
pub(crate) fn elastic_readings(
    command: &[f64],
    period_s: f64,
    (drive, friction, mechanics): (&DriveFigures, &FrictionSettings, &Mechanics),
    seed: u64,
) -> Vec<f64> {
    let Mechanics { resonance_hz, damping, share, scale, play, noise, count, second_hz } = *mechanics;
    let steps = (period_s / 25e-6).ceil() as usize;
    let h = period_s / steps as f64;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let omega = TAU * resonance_hz;
    let reduced = share * (1.0 - share);
    let (stiffness, damper) = (reduced * omega * omega, 2.0 * reduced * damping * omega);
    let kvp = drive.velocity_gain_per_s;
    let push = |apart: f64, rate: f64| {
        let over = if apart > 0.0 { apart } else { (apart + play).min(0.0) };
        let force = stiffness * over + damper * rate;
        // Within the play nothing pushes, and a contact does not pull.
        if play > 0.0 && (over == 0.0 || force * over < 0.0) { 0.0 } else { force }
    };
    let small = 0.1 * share;
    let (hung, hung_damper) = (small * (TAU * second_hz).powi(2), 0.04 * small * TAU * second_hz);
    // Motor, load, mass that hangs on the load; integrator, torque, friction.
    let slope = |s: &[f64; 9], r: f64| -> [f64; 9] {
        let [x_m, v_m, x_l, v_l, x_h, v_h, q, m, f] = *s;
        let rigid = resonance_hz == 0.0;
        let v = if rigid { v_m } else { v_l };
        let ratio = v / friction.stribeck_velocity_per_s;
        let level = kvp * friction.coulomb_per_s * (1.0 + friction.stribeck_share / (1.0 + ratio * ratio));
        let drag = level * f + kvp * friction.viscous * v;
        let q_dot = (r - v_m) / drive.reset_time_s;
        let m_dot = (kvp * (r - v_m + q) - m) / drive.current_loop_s;
        let f_dot = (v - v.abs() * f) / friction.presliding;
        if rigid {
            return [v_m, m - drag, v_m, m - drag, 0.0, 0.0, q_dot, m_dot, f_dot];
        }
        let p = push(x_m - x_l, v_m - v_l);
        let pull = if second_hz > 0.0 { hung * (x_h - x_l) + hung_damper * (v_h - v_l) } else { 0.0 };
        let mass = if second_hz > 0.0 { share - small } else { share };
        [v_m, (m - p) / (1.0 - share), v_l, (p - drag + pull) / mass, v_h, -pull / small, q_dot, m_dot, f_dot]
    };
    let at = |s: &[f64; 9]| if scale && resonance_hz > 0.0 { s[2] } else { s[0] };
    let mut state = [command[0], 0.0, command[0], 0.0, command[0], 0.0, 0.0, 0.0, 0.0];
    let (mut before, mut reading) = (command[0], command[0]);
    let mut out = Vec::new();
    for &now in command {
        let r =
            drive.position_gain_per_s * (before - reading) + drive.velocity_feed_forward * (now - before) / period_s;
        for _ in 0..steps {
            let on = |k: &[f64; 9], part: f64| -> [f64; 9] { std::array::from_fn(|i| state[i] + part * h * k[i]) };
            let a = slope(&state, r);
            let b = slope(&on(&a, 0.5), r);
            let c = slope(&on(&b, 0.5), r);
            let d = slope(&on(&c, 1.0), r);
            state = std::array::from_fn(|i| state[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
        }
        before = now;
        let deviation: f64 = StandardNormal.sample(&mut random);
        let read = at(&state) + noise * deviation;
        reading = if count > 0.0 { (read / count).round() * count } else { read };
        out.push(reading);
    }
    out
}
