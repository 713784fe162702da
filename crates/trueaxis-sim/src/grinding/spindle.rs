//! Rotation of the work spindle, motion of its centre, counts of its encoders.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;
use trueaxis::roundness::GaugeSettings;

/// One term `amplitude · cos(order · α + phase)` of a motion, µm and rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// Cycles per revolution; whole numbers are synchronous, others are not.
    pub order: f64,
    /// µm.
    pub amplitude: f64,
    /// rad.
    pub phase: f64,
}

const fn term(order: f64, amplitude: f64, phase: f64) -> Term {
    Term { order, amplitude, phase }
}

/// Sum of terms at a spindle angle counted over all turns.
pub fn sum(terms: &[Term], alpha: f64) -> f64 {
    terms.iter().map(|t| t.amplitude * libm::cos(t.order * alpha + t.phase)).sum()
}

/// Motion of the pin's centre in machine directions: across probe 1 (X) and along it (Y) at β = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct CentreMotion {
    /// Once per revolution: eccentricity.
    pub eccentricity: [Term; 2],
    /// Motion at whole multiples of the spindle's rotation.
    pub synchronous: [Vec<Term>; 2],
    /// Motion at other multiples.
    pub asynchronous: [Vec<Term>; 2],
    /// Standard deviation of white noise, µm.
    pub noise_um: f64,
}

impl Default for CentreMotion {
    fn default() -> Self {
        CentreMotion {
            eccentricity: [term(1.0, 6.0, 0.4), term(1.0, 4.5, 1.4)],
            synchronous: [
                vec![term(2.0, 0.9, 1.0), term(3.0, 0.5, 2.0), term(5.0, 0.3, 0.7), term(11.0, 0.15, 0.1)],
                vec![term(2.0, 1.6, 0.3), term(3.0, 1.1, 1.7), term(5.0, 0.6, 1.0), term(11.0, 0.3, 2.2)],
            ],
            asynchronous: [
                vec![term(0.427, 0.05, 0.0), term(2.389, 0.04, 1.0)],
                vec![term(0.427, 0.04, 2.0), term(4.617, 0.04, 0.5)],
            ],
            noise_um: 0.005,
        }
    }
}

impl CentreMotion {
    /// `[R_X, R_Y]` at a spindle angle counted over all turns, µm, without noise.
    pub fn at(&self, alpha: f64) -> [f64; 2] {
        std::array::from_fn(|i| {
            sum(&self.eccentricity[i..=i], alpha) + sum(&self.synchronous[i], alpha) + sum(&self.asynchronous[i], alpha)
        })
    }
}

/// One independent stream of noise: for a given seed it is the same whatever else is simulated.
#[derive(Clone, Debug)]
pub struct Noise(ChaCha8Rng);

impl Noise {
    /// Creates a stream for a seed.
    pub fn new(seed: u64, stream: u64) -> Noise {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        Noise(random)
    }

    /// The next value, with standard deviation `rms`.
    pub fn next(&mut self, rms: f64) -> f64 {
        let normal: f64 = StandardNormal.sample(&mut self.0);
        rms * normal
    }
}

/// The true linkage that makes the probes follow the pin: `R sin α = (R_S + R_W) sin β`, lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linkage {
    /// Crank throw R; 0 for a fixed arm.
    pub crank_mm: f64,
    /// Wheel radius R_S.
    pub wheel_mm: f64,
    /// Pin radius R_W.
    pub pin_mm: f64,
}

impl Linkage {
    /// The linkage of a gauge; a fixed one if the gauge has no arm.
    pub fn of(gauge: &GaugeSettings) -> Linkage {
        gauge.arm.map_or(Linkage { crank_mm: 0.0, wheel_mm: 1.0, pin_mm: 1.0 }, |arm| Linkage {
            crank_mm: arm.lengths.crank_mm,
            wheel_mm: arm.lengths.wheel_mm,
            pin_mm: arm.lengths.pin_mm,
        })
    }

    /// β at α, rad.
    pub fn beta(&self, alpha: f64) -> f64 {
        libm::asin(self.crank_mm * libm::sin(alpha) / (self.wheel_mm + self.pin_mm))
    }
}

/// Raw counts of an encoder at an angle counted over all turns: whole, wrapping, in its mounted direction.
pub fn counts(angle: f64, per_turn: u32, direction: i8) -> i32 {
    let counts = (angle / TAU * f64::from(per_turn)).floor() as i64 * i64::from(direction);
    // Counters wrap.
    counts as i32
}

/// Rotation of the spindle: ramps up over a fifth of a second, with a ripple of 1 % once and 0.4 % 3.3 times per turn.
#[derive(Clone, Debug)]
pub struct Turning {
    full: f64,
    speed: f64,
    alpha: f64,
    period_s: f64,
}

/// Time in which the drive accelerates from rest to full speed, s.
const RAMP_S: f64 = 0.2;

impl Turning {
    /// At rest at `alpha` (rad), about to turn at `speed_rpm`.
    pub fn new(alpha: f64, speed_rpm: f64, period_s: f64) -> Turning {
        Turning { full: speed_rpm / 60.0 * TAU, speed: 0.0, alpha, period_s }
    }

    /// Angle counted over all turns, rad.
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// One servo period; brakes to rest if `go` is false.
    pub fn cycle(&mut self, go: bool) {
        let change = self.full / RAMP_S * self.period_s;
        let wanted = if go { self.full } else { 0.0 };
        self.speed += (wanted - self.speed).clamp(-change, change);
        let ripple = 1.0 + 0.01 * libm::cos(self.alpha) + 0.004 * libm::cos(3.3 * self.alpha);
        self.alpha += self.speed * ripple * self.period_s;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_linkage_closes_and_the_spindle_comes_up_and_stops() {
        let linkage = Linkage { crank_mm: 45.0, wheel_mm: 300.0, pin_mm: 27.5 };
        for i in 0..100 {
            let alpha = 0.1 * f64::from(i);
            assert!((45.0 * alpha.sin() - 327.5 * linkage.beta(alpha).sin()).abs() < 1e-12);
        }
        let mut turning = Turning::new(-0.3, 60.0, 1e-4);
        (0..10_000).for_each(|_| turning.cycle(true));
        // 0.9 turns: one second minus half the ramp.
        assert!(((turning.alpha() + 0.3) / TAU - 0.9).abs() < 0.01, "{}", turning.alpha());
        (0..2_100).for_each(|_| turning.cycle(false));
        let stood = turning.alpha();
        (0..100).for_each(|_| turning.cycle(false));
        assert_eq!(turning.alpha(), stood);
    }

    #[test]
    fn counts_wrap_and_run_either_way() {
        assert_eq!(counts(TAU * 2.5, 1000, 1), 2500);
        assert_eq!(counts(TAU * 2.5, 1000, -1), -2500);
        assert_eq!(counts(-1e-9, 1000, 1), -1);
        assert_eq!(counts(TAU * 16.0, 1 << 28, 1), 0);
    }
}
