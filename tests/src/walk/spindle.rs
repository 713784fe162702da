//! Spindle, workpiece and probes of a leg with a gauge.

use super::dice::Dice;
use super::scalar::Scalar;
use trueaxis::Axis;
use trueaxis::roundness::{Band, GaugeSettings, InfeedSettings, ProbeAngles, Probes};

/// Counts per revolution.
const COUNTS: i32 = 1 << 16;

/// Turns the spindle and generates the probes' readings.
#[derive(Clone, Debug)]
pub(super) struct Spindle<R> {
    counts: i32,
    pub(super) turning: i32,
    profile: [R; 256],
}

impl<R: Scalar> Spindle<R> {
    pub(super) fn draw(dice: &mut Dice) -> Self {
        let amplitudes: [f64; 6] = std::array::from_fn(|_| 4.0 * dice.unit());
        let profile = std::array::from_fn(|k| {
            let angle = std::f64::consts::TAU * k as f64 / 256.0;
            R::of((0..6).map(|n| amplitudes[n] * ((n + 2) as f64 * angle + n as f64).cos()).sum())
        });
        // Occasionally slow enough for one cycle at each of many points.
        let turning = if dice.one_in(2) { 100 + dice.below(900) } else { 10 + dice.below(90) };
        Spindle { counts: dice.below(1 << 20) as i32, turning: turning as i32, profile }
    }

    /// Advances one cycle.
    pub(super) fn turn(&mut self) -> Probes<R> {
        let before = self.counts;
        self.counts = self.counts.wrapping_add(self.turning);
        let (turn, last) = (self.counts.div_euclid(COUNTS), before.div_euclid(COUNTS));
        let crossed = if self.turning > 0 { turn } else { last };
        let at = |slots: i32| self.profile[((self.counts >> 8) + 4 * slots) as usize & 255];
        Probes {
            readings: [at(0), at(11), at(24)],
            spindle: self.counts,
            index: (turn != last).then(|| crossed.wrapping_mul(COUNTS)),
            ..Probes::default()
        }
    }
}

/// A gauge with `points` points per revolution and fast work.
pub(super) fn settings(dice: &mut Dice, points: u16) -> GaugeSettings {
    let scale = points / 64;
    let angles = ProbeAngles::Slots { p: 11 * scale, q: 13 * scale };
    let band = Band { first: 2, last: 12 };
    GaugeSettings {
        band,
        slices_per_cycle: 4 + dice.below(13) as u8,
        stop_s: 0.01,
        filter: dice.one_in(2).then_some(15),
        revolutions: 1 + dice.below(6) as u16,
        infeed: (!dice.one_in(5)).then(|| {
            let axis = dice.one_of(&[Axis::X, Axis::Y, Axis::Z]);
            InfeedSettings {
                direction: dice.one_of(&[1, -1]),
                gain: 0.2,
                drive_delay_s: 0.001,
                limit_um: dice.factor(0.3, 20.0),
                ..InfeedSettings::with_defaults(axis, Band { first: 2, last: 6 })
            }
        }),
        ..GaugeSettings::with_defaults(points, angles, COUNTS as u32)
    }
}
