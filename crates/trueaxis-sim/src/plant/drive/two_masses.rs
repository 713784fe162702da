//! Motor and load, coupled by a spring, a damper and a play.
//!
//! ```text
//! (1 − σ) x_M'' = F − p          σ x_L'' = p − R          p = k e + c e'
//! ```
//!
//! x_M, x_L: positions of motor and load; F, R: the motor's force and the load's friction; σ: share of the load. Forces and
//! stiffness are per mass of motor and load together. e is the deflection of the spring: δ = x_M − x_L without play; with a
//! play b, e = δ while the motor pushes forwards (δ > 0), e = δ + b while it pushes back (δ < −b), and p = 0 between. The play
//! can push but not pull.
//!
//! In coordinates of the common centre, X = (1 − σ) x_M + σ x_L, and of δ the two motions are independent of each other:
//!
//! ```text
//! X'' = F − R          δ'' + 2 ζ ω_r δ' + ω_r² δ = F/(1 − σ) + R/σ
//!
//! ω_r² = k (1/(1 − σ) + 1/σ)    resonance: motor and load against each other, both free
//! ω_a² = k/σ = ω_r² (1 − σ)     antiresonance: the load on its spring, the motor held
//! ζ    = c/(2 σ (1 − σ) ω_r)    of the resonance; that of the antiresonance is ζ √(1 − σ)
//! ```
//!
//! Both are solved exactly for forces that are constant over a step, so that steps of any length are stable.

use super::DriveSettings;
use std::f64::consts::TAU;

/// Solution of the resonance over one step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    dt: f64,
    /// Exponential decay times cosine, sine over the damped frequency.
    cos: f64,
    sin: f64,
    decay: f64,
    square: f64,
}

impl Step {
    pub(super) fn new(dt: f64, settings: &DriveSettings) -> Step {
        let omega = TAU * settings.resonance_hz;
        let decay = settings.resonance_damping * omega;
        let damped = (omega * omega - decay * decay).sqrt();
        let (sin, cos) = libm::sincos(damped * dt);
        let left = libm::exp(-decay * dt);
        Step { dt, cos: left * cos, sin: left * sin / damped, decay, square: omega * omega }
    }

    pub(super) fn dt(&self) -> f64 {
        self.dt
    }

    /// Deflection and its rate after the step, under the constant acceleration `u`.
    fn spring(&self, deflection: f64, rate: f64, u: f64) -> (f64, f64) {
        let rest = u / self.square;
        let off = deflection - rest;
        let next = self.cos * off + self.sin * (rate + self.decay * off);
        (rest + next, self.cos * rate - self.sin * (self.square * off + self.decay * rate))
    }
}

/// State of motor and load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct TwoMasses {
    centre: f64,
    velocity: f64,
    /// x_M − x_L and its rate.
    apart: f64,
    rate: f64,
}

impl TwoMasses {
    /// Both at rest at `position`, last moved in positive direction.
    pub(super) fn at(position: f64) -> TwoMasses {
        TwoMasses { centre: position, ..TwoMasses::default() }
    }

    pub(super) fn motor(&self, s: &DriveSettings) -> f64 {
        self.centre + s.load_share * self.apart
    }

    pub(super) fn load(&self, s: &DriveSettings) -> f64 {
        self.centre - (1.0 - s.load_share) * self.apart
    }

    pub(super) fn motor_velocity(&self, s: &DriveSettings) -> f64 {
        self.velocity + s.load_share * self.rate
    }

    pub(super) fn load_velocity(&self, s: &DriveSettings) -> f64 {
        self.velocity - (1.0 - s.load_share) * self.rate
    }

    /// One step under the motor's `force` and the load's `drag`.
    pub(super) fn advance(&mut self, force: f64, drag: f64, step: &Step, s: &DriveSettings) {
        let dt = step.dt;
        let common = force - drag;
        self.centre += (self.velocity + 0.5 * common * dt) * dt;
        self.velocity += common * dt;
        let u = force / (1.0 - s.load_share) + drag / s.load_share;
        match self.contact(step, s.gear_play_mm) {
            Some(end) => {
                let (deflection, rate) = step.spring(self.apart - end, self.rate, u);
                (self.apart, self.rate) = (end + deflection, rate);
            }
            None => {
                self.apart += (self.rate + 0.5 * u * dt) * dt;
                self.rate += u * dt;
            }
        }
    }

    /// The end of the play at which the spring acts; `None` within the play, and where the spring would pull.
    fn contact(&self, step: &Step, play: f64) -> Option<f64> {
        if play == 0.0 {
            return Some(0.0);
        }
        let push = |end: f64| step.square * (self.apart - end) + 2.0 * step.decay * self.rate;
        if self.apart >= 0.0 {
            return (push(0.0) >= 0.0).then_some(0.0);
        }
        (self.apart <= -play && push(-play) <= 0.0).then_some(-play)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 2.5e-5;

    fn settings() -> DriveSettings {
        DriveSettings { resonance_hz: 90.0, resonance_damping: 0.03, load_share: 0.3, ..DriveSettings::default() }
    }

    /// Pulled apart by 1 mm and let go; both masses free.
    fn free() -> TwoMasses {
        TwoMasses { apart: 1.0, ..TwoMasses::default() }
    }

    #[test]
    fn a_free_decay_has_the_stated_frequency_and_damping() {
        let s = settings();
        let step = Step::new(DT, &s);
        let mut masses = free();
        // Times at which motor and load swing through each other, and the peaks between.
        let (mut crossings, mut peaks, mut peak) = (Vec::new(), Vec::new(), 0_f64);
        let mut before = 1.0;
        for k in 1..8000 {
            masses.advance(0.0, 0.0, &step, &s);
            let apart = masses.motor(&s) - masses.load(&s);
            peak = peak.max(apart.abs());
            if (apart < 0.0) != (before < 0.0) {
                crossings.push((f64::from(k) - apart / (apart - before)) * DT);
                peaks.push(peak);
                peak = 0.0;
            }
            before = apart;
        }
        let halves = crossings.len() - 1;
        let hz = 0.5 * halves as f64 / (crossings[halves] - crossings[0]);
        assert!((hz / (90.0 * (1.0 - 0.03_f64.powi(2)).sqrt()) - 1.0).abs() < 1e-5, "{hz} Hz");
        // Logarithmic decrement per half period: π ζ/√(1 − ζ²).
        let decrement = (peaks[1] / peaks[21]).ln() / 20.0;
        let damping = decrement / decrement.hypot(std::f64::consts::PI);
        assert!((damping / 0.03 - 1.0).abs() < 1e-3, "{damping}");
    }

    #[test]
    fn momentum_changes_by_the_outer_forces_alone() {
        for play in [0.0, 0.02] {
            let s = DriveSettings { gear_play_mm: play, ..settings() };
            let step = Step::new(DT, &s);
            let (mut masses, mut impulse) = (free(), 0.0);
            for k in 0..20_000 {
                let (force, drag) = (300.0 * (0.01 * f64::from(k)).sin(), 100.0 * (0.003 * f64::from(k)).cos());
                masses.advance(force, drag, &step, &s);
                impulse += (force - drag) * DT;
                let momentum = 0.7 * masses.motor_velocity(&s) + 0.3 * masses.load_velocity(&s);
                assert!((momentum - impulse).abs() < 1e-10, "{k}: {momentum} {impulse}");
            }
        }
    }

    /// Kinetic and spring energy of the motion against each other, per mass.
    fn energy(masses: &TwoMasses, s: &DriveSettings) -> f64 {
        let (over, under) = (masses.apart.max(0.0), (masses.apart + s.gear_play_mm).min(0.0));
        let omega = TAU * s.resonance_hz;
        0.5 * s.load_share * (1.0 - s.load_share) * (masses.rate.powi(2) + (omega * over.max(-under)).powi(2))
    }

    #[test]
    fn contacts_in_the_play_lose_energy_even_with_the_least_damping() {
        for (resonance_damping, resonance_hz) in [(0.002, 25.0), (0.002, 300.0), (0.02, 80.0)] {
            let s = DriveSettings { gear_play_mm: 0.01, resonance_damping, resonance_hz, ..settings() };
            let step = Step::new(0.01 / resonance_hz, &s);
            let mut masses = TwoMasses { apart: 0.05, ..TwoMasses::default() };
            let begun = energy(&masses, &s);
            let mut last = begun;
            // Windows of ten periods; a slow load may stay within its play for longer.
            for window in 0..50 {
                (0..1000).for_each(|_| masses.advance(0.0, 0.0, &step, &s));
                let left = energy(&masses, &s);
                assert!(left <= last, "{resonance_damping} {resonance_hz} Hz, window {window}: {left} after {last}");
                last = left;
            }
            assert!(last < 0.1 * begun, "{resonance_damping} {resonance_hz} Hz: {last} of {begun}");
        }
    }

    #[test]
    fn steps_of_any_length_end_at_the_same_place() {
        let s = settings();
        let (fine, coarse) = (Step::new(DT, &s), Step::new(400.0 * DT, &s));
        let (mut slow, mut quick) = (free(), free());
        (0..400).for_each(|_| slow.advance(50.0, 20.0, &fine, &s));
        quick.advance(50.0, 20.0, &coarse, &s);
        for (a, b) in [(slow.motor(&s), quick.motor(&s)), (slow.load_velocity(&s), quick.load_velocity(&s))] {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
}
