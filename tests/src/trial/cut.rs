//! Load of a cut on a plant: a side load and chatter.

use serde::Serialize;
use std::f64::consts::TAU;
use trueaxis_testing::noise::Noise;

/// Largest side load, mm/s²: about the Coulomb friction of the family.
const SIDE_LOAD: f64 = 400.0;
/// Time in which a side load grows, s: a tool that enters.
const ENTRY_S: f64 = 0.01;

/// Side load and chatter on X and Y.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Cut {
    /// Force on the loads per moved mass, mm/s²; zero without side load.
    pub side_load: [f64; 2],
    /// When the tool enters, share of the track's time.
    pub entry: f64,
    /// Amplitudes of the loads, mm, whatever the drives do; zero without chatter.
    pub chatter_mm: [f64; 2],
    /// Frequency of the chatter, Hz.
    pub chatter_hz: f64,
}

impl Cut {
    /// Draws a cut: a side load on half of the plants; on half of them chatter of 1 to 30 µm at 80 to 900 Hz.
    pub(super) fn draw(random: &mut Noise) -> Cut {
        let loaded = random.below(2) == 1;
        let side_load = vector(random.range(0.0, SIDE_LOAD), random.unit());
        let entry = random.range(0.2, 0.8);
        let chatters = random.below(2) == 1;
        let chatter_mm = vector(1e-3 * 30.0_f64.powf(random.unit()), random.unit());
        let chatter_hz = 80.0 * 11.25_f64.powf(random.unit());
        Cut {
            side_load: if loaded { side_load } else { [0.0; 2] },
            entry,
            chatter_mm: if chatters { chatter_mm } else { [0.0; 2] },
            chatter_hz,
        }
    }

    /// The cut without side load and chatter.
    pub(super) fn quiet(self) -> Cut {
        Cut { side_load: [0.0; 2], chatter_mm: [0.0; 2], ..self }
    }

    /// Whether there is a side load.
    pub fn is_loaded(&self) -> bool {
        self.side_load != [0.0; 2]
    }

    /// Whether there is chatter.
    pub fn chatters(&self) -> bool {
        self.chatter_mm != [0.0; 2]
    }

    /// The side load at a time of a track that takes `duration_s`.
    pub(super) fn load_at(&self, time_s: f64, duration_s: f64) -> [f64; 2] {
        let grown = ((time_s - self.entry * duration_s) / ENTRY_S).clamp(0.0, 1.0);
        self.side_load.map(|load| grown * load)
    }

    /// Displacement of the loads by the chatter, mm.
    pub(super) fn chatter_at(&self, time_s: f64) -> [f64; 2] {
        let sin = (TAU * self.chatter_hz * time_s).sin();
        self.chatter_mm.map(|amplitude| amplitude * sin)
    }
}

fn vector(size: f64, turn: f64) -> [f64; 2] {
    let (sin, cos) = (TAU * turn).sin_cos();
    [size * cos, size * sin]
}
