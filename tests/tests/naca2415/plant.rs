//! The axes of the published benchmark: their transfer functions from command to position.
//!
//! ```text
//!           b2 s² + b1 s + b0
//! G(s) = ─────────────────────────────         (table of servo parameters in doi 10.2478/msr-2025-0031)
//!        s⁴ + a3 s³ + a2 s² + a1 s + a0
//! ```

/// Longest integration step, s: 1 % of the fastest time constant.
const STEP_S: f64 = 25e-6;

/// Coefficients of one axis, lowest power first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TransferFunction {
    /// a0 to a3; a4 is 1.
    pub(crate) a: [f64; 4],
    /// b0 to b2.
    pub(crate) b: [f64; 3],
}

/// X and Y as published.
pub(crate) const PUBLISHED: [TransferFunction; 2] = [
    TransferFunction { a: [1.938e9, 3.538e7, 2.135e5, 6.984e2], b: [1.938e9, 3.476e7, 1.471e5] },
    TransferFunction { a: [1.904e9, 3.496e7, 2.120e5, 6.948e2], b: [1.904e9, 3.435e7, 1.466e5] },
];

/// One axis in controllable canonical form: x'''' + a3 x''' + a2 x'' + a1 x' + a0 x = command, position = b2 x'' + b1 x' + b0 x.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plant {
    of: TransferFunction,
    state: [f64; 4],
    command: f64,
}

impl Plant {
    /// The axis at rest.
    pub(crate) fn at(of: TransferFunction, position: f64) -> Plant {
        Plant { of, state: [position / of.a[0], 0.0, 0.0, 0.0], command: position }
    }

    /// Position, mm.
    pub(crate) fn position(&self) -> f64 {
        self.of.b.iter().zip(&self.state).map(|(b, x)| b * x).sum()
    }

    /// Advances one period, at whose end the command is `command`; the drive interpolates (fourth-order Runge–Kutta).
    pub(crate) fn advance(&mut self, command: f64, period_s: f64) {
        let steps = (period_s / STEP_S).ceil();
        let h = period_s / steps;
        let rate = |x: [f64; 4], command: f64| {
            let fed_back: f64 = self.of.a.iter().zip(&x).map(|(a, x)| a * x).sum();
            [x[1], x[2], x[3], command - fed_back]
        };
        let after = |x: [f64; 4], k: [f64; 4], h: f64| std::array::from_fn(|i| x[i] + h * k[i]);
        let mut x = self.state;
        let rise = (command - self.command) / steps;
        for step in 0..steps as u32 {
            let from = self.command + rise * f64::from(step);
            let [middle, end] = [from + 0.5 * rise, from + rise];
            let k1 = rate(x, from);
            let k2 = rate(after(x, k1, 0.5 * h), middle);
            let k3 = rate(after(x, k2, 0.5 * h), middle);
            let k4 = rate(after(x, k3, h), end);
            x = std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
        (self.state, self.command) = (x, command);
    }
}

/// The cascade with exactly this transfer function: position loop K_v with velocity feed-forward k_ff, velocity loop K_vp (1 +
/// 1/(τ s)), current loop of time constant T_c, mass with viscous friction d.
///
/// ```text
/// T_c s⁴ + (1 + d T_c) s³ + (d + K_vp) s² + K_vp (1/τ + K_v) s + K_vp K_v/τ     denominator
/// K_vp k_ff s² + K_vp (K_v + k_ff/τ) s + K_vp K_v/τ                             numerator
/// ```
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cascade {
    pub(crate) position_gain: f64,
    pub(crate) feed_forward: f64,
    pub(crate) velocity_gain: f64,
    pub(crate) reset_time: f64,
    pub(crate) current_loop: f64,
    pub(crate) viscous: f64,
}

impl Cascade {
    /// Solves the six coefficients for the six figures. There are two solutions (the zeros −1/τ and −K_v/k_ff can be
    /// exchanged); returns the one with the longer reset time and the faster current loop.
    pub(crate) fn of(TransferFunction { a, b }: &TransferFunction) -> Cascade {
        let zero = (b[1] - (b[1] * b[1] - 4.0 * b[2] * b[0]).sqrt()) / (2.0 * b[2]);
        // K = K_vp/T_c: a1 − b1 = K (1 − k_ff)/τ and b2 = K k_ff.
        let gain = (a[1] - b[1]) / zero + b[2];
        let feed_forward = b[2] / gain;
        let rest = a[2] - gain;
        let rate = 0.5 * (a[3] + (a[3] * a[3] - 4.0 * rest).sqrt());
        Cascade {
            position_gain: b[0] / (gain * zero),
            feed_forward,
            velocity_gain: gain / rate,
            reset_time: 1.0 / zero,
            current_loop: 1.0 / rate,
            viscous: rest / rate,
        }
    }

    /// The transfer function of the cascade.
    pub(crate) fn transfer_function(&self) -> TransferFunction {
        let Cascade { position_gain, feed_forward, velocity_gain, reset_time, current_loop, viscous } = *self;
        let per = |x: f64| x / current_loop;
        let constant = per(velocity_gain * position_gain / reset_time);
        TransferFunction {
            a: [
                constant,
                per(velocity_gain * (1.0 / reset_time + position_gain)),
                per(viscous + velocity_gain),
                per(1.0) + viscous,
            ],
            b: [
                constant,
                per(velocity_gain * (position_gain + feed_forward / reset_time)),
                per(velocity_gain * feed_forward),
            ],
        }
    }
}

#[test]
fn the_published_axes_are_cascades() {
    for published in &PUBLISHED {
        let cascade = Cascade::of(published);
        let found = cascade.transfer_function();
        let pairs = published.a.iter().chain(&published.b).zip(found.a.iter().chain(&found.b));
        assert!(pairs.clone().all(|(p, f)| (f / p - 1.0).abs() < 1e-9), "{cascade:?} {found:?}");
    }
}

#[test]
fn the_plant_follows_its_transfer_function() {
    // A sine: amplitude and phase follow from G(iω).
    for of in PUBLISHED {
        let (period_s, omega) = (1e-4, 60.0_f64);
        let mut plant = Plant::at(of, 0.0);
        let [re, im] = response(&of, omega);
        for k in 0..30_000 {
            let time = f64::from(k) * period_s;
            plant.advance((omega * (time + period_s)).sin(), period_s);
            let angle = omega * (time + period_s);
            let expected = re * angle.sin() + im * angle.cos();
            assert!(time < 1.0 || (plant.position() - expected).abs() < 2e-5, "{time} {} {expected}", plant.position());
        }
    }
}

#[cfg(test)]
fn response(of: &TransferFunction, w: f64) -> [f64; 2] {
    let [p, q] = [of.b[0] - of.b[2] * w * w, of.b[1] * w];
    let [r, s] = [of.a[0] - of.a[2] * w * w + w.powi(4), of.a[1] * w - of.a[3] * w.powi(3)];
    let size = r * r + s * s;
    [(p * r + q * s) / size, (q * r - p * s) / size]
}
