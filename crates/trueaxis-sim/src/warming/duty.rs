//! Load of a shift on the machine: spells of speed, feed and coolant, and the air of the hall.

use super::SHIFT_S;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

/// Kinds of shifts: they differ in speeds and spells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Recorded,
    Judged,
}

/// Conditions that act on the machine at a moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Conditions {
    pub(super) rpm: f64,
    /// Share of the time in which the axes move, 0 to 1.
    pub(super) feed: f64,
    pub(super) coolant: bool,
    pub(super) air_c: f64,
}

#[derive(Clone, Copy, Debug)]
struct Spell {
    until_s: u32,
    rpm: f64,
    feed: f64,
    coolant: bool,
}

/// One shift.
#[derive(Clone, Debug)]
pub(super) struct Shift {
    spells: Vec<Spell>,
    /// Morning temperature, rise over the day, and time at which the gate opens.
    morning_c: f64,
    rise_k: f64,
    gate_s: u32,
}

/// Uniform in `low` … `high`.
fn range(random: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

impl Shift {
    /// Draws shift `number` from a seed.
    pub(super) fn drawn(seed: u64, number: u32, kind: Kind) -> Shift {
        let mut random = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(1_000) + u64::from(number));
        let (speeds, spells): (&[f64], [f64; 2]) = match kind {
            Kind::Recorded => (&[0.0, 3_000.0, 6_000.0, 9_000.0, 12_000.0], [900.0, 3_000.0]),
            Kind::Judged => (&[0.0, 4_500.0, 7_500.0, 10_500.0], [1_500.0, 5_400.0]),
        };
        let (mut spells_of, mut until_s) = (Vec::new(), 0);
        while until_s <= SHIFT_S {
            until_s += range(&mut random, spells[0], spells[1]) as u32;
            let speed = speeds[range(&mut random, 0.0, speeds.len() as f64) as usize];
            let feed = if speed > 0.0 { range(&mut random, 0.1, 0.9) } else { 0.0 };
            let coolant = speed > 0.0 && range(&mut random, 0.0, 1.0) < 0.6;
            spells_of.push(Spell { until_s, rpm: speed, feed, coolant });
        }
        Shift {
            spells: spells_of,
            morning_c: range(&mut random, 18.5, 21.5),
            rise_k: range(&mut random, 2.0, 5.0),
            gate_s: range(&mut random, 7_200.0, 21_600.0) as u32,
        }
    }

    /// Conditions at a time of the shift, s.
    pub(super) fn at(&self, t_s: u32) -> Conditions {
        let spell = self.spells.iter().find(|spell| t_s < spell.until_s);
        let (rpm, feed, coolant) = spell.map_or((0.0, 0.0, false), |spell| (spell.rpm, spell.feed, spell.coolant));
        Conditions { rpm, feed, coolant, air_c: self.air_c(t_s) }
    }

    /// Air temperature: it rises towards the afternoon, ripples with the heating, and is three kelvin lower just after the
    /// gate opened.
    fn air_c(&self, t_s: u32) -> f64 {
        let t = f64::from(t_s);
        let day = self.rise_k * libm::sin(1.6 * t / f64::from(SHIFT_S));
        let heating = 0.4 * libm::sin(t / 520.0);
        let since = t - f64::from(self.gate_s);
        let gate = if since > 0.0 { 3.0 * (libm::exp(-since / 1_500.0) - libm::exp(-since / 200.0)) } else { 0.0 };
        self.morning_c + day + heating - gate
    }

    /// Air temperature in the night after the shift.
    pub(super) fn night_c(&self) -> f64 {
        self.morning_c
    }
}
