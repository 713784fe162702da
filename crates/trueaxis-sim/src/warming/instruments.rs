//! Temperature sensors, and the probe.

use super::bodies::{Bodies, Node};
use super::duty::{Conditions, Shift};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Names of the sensors, in the order of their readings.
pub const SENSORS: [&str; 9] =
    ["nose", "head", "column_front", "column_back", "bed", "screw", "table", "coolant", "air"];

/// Noise and step of a sensor, K: a digital one reads in sixteenths of a kelvin.
const NOISE_K: f64 = 0.02;
const STEP_K: f64 = 0.0625;
/// Lag of a sensor, s.
const LAG_S: f64 = 25.0;

/// The sensors, each behind a separate lag.
#[derive(Clone, Debug)]
pub(super) struct Sensors {
    followed: [f64; SENSORS.len()],
    random: ChaCha8Rng,
}

/// Temperatures at the sensors: on skins, none in a core.
fn places(bodies: &Bodies, now: &Conditions) -> [f64; SENSORS.len()] {
    let of = |node| bodies.of(node);
    [
        // In the bearing's seat, between core and skin.
        0.5 * of(Node::NoseCore) + 0.5 * of(Node::NoseSkin),
        of(Node::HeadSkin),
        of(Node::ColumnFront),
        of(Node::ColumnBack),
        of(Node::BedTop),
        of(Node::Screw),
        of(Node::Table),
        of(Node::Tank),
        now.air_c,
    ]
}

impl Sensors {
    pub(super) fn new(seed: u64, bodies: &Bodies, shift: &Shift) -> Sensors {
        Sensors { followed: places(bodies, &shift.at(0)), random: ChaCha8Rng::seed_from_u64(seed ^ 0x7e3) }
    }

    pub(super) fn follow(&mut self, dt_s: f64, bodies: &Bodies, now: &Conditions) {
        for (followed, place) in self.followed.iter_mut().zip(places(bodies, now)) {
            *followed += (place - *followed) * dt_s / LAG_S;
        }
    }

    /// Readings of the sensors, °C.
    pub(super) fn read(&mut self) -> [f64; SENSORS.len()] {
        let random = &mut self.random;
        self.followed.map(|temperature| {
            let noise: f64 = StandardNormal.sample(random);
            libm::round((temperature + NOISE_K * noise) / STEP_K) * STEP_K
        })
    }
}

/// A probe at the measuring points.
#[derive(Clone, Debug)]
pub(super) struct Probe {
    sigma_mm: f64,
    random: ChaCha8Rng,
}

impl Probe {
    pub(super) fn new(seed: u64, noise_um: f64) -> Probe {
        Probe { sigma_mm: 1e-3 * noise_um, random: ChaCha8Rng::seed_from_u64(seed ^ 0xb0be) }
    }

    pub(super) fn read(&mut self, truth_mm: f64) -> f64 {
        let noise: f64 = StandardNormal.sample(&mut self.random);
        truth_mm + self.sigma_mm * noise
    }
}
