//! Drift of a mandrel in the tests of ISO 230-3, on the same bodies.

use super::bodies::{Bodies, Node};
use super::drift::drift;
use super::duty::{Conditions, Kind, Shift};
use super::instruments::Probe;
use super::{STARTS_C, STEP_S};
use std::fmt::Write;

/// What warms the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load {
    /// The air of the hall alone.
    Air,
    /// The spindle at this speed, 1/min, for the first two thirds of the test.
    Spindle(f64),
    /// The axes, moving for this share of the time in the first two thirds of the test.
    Axes(f64),
}

/// A test with five probes at a mandrel: X and Y at two heights, Z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IsoTest {
    /// The load.
    pub load: Load,
    /// Duration, s.
    pub duration_s: u32,
    /// Interval of the readings, s, an even number.
    pub every_s: u32,
    /// Length of the mandrel from the spindle's nose, and the distance of the upper probes from its tip, mm.
    pub mandrel_mm: [f64; 2],
    /// X, Y, Z of the mandrel, mm; of both positions if an axis moves.
    pub at_mm: [[f64; 3]; 2],
    /// Standard deviation of a reading, µm.
    pub noise_um: f64,
    /// Seed of the hall's air and of the noise.
    pub seed: u64,
}

impl IsoTest {
    /// The record in the format that `trueaxis evaluate thermal` reads.
    pub fn record(&self) -> String {
        let shift = Shift::drawn(self.seed, 0, Kind::Judged);
        let mut bodies = Bodies::at(STARTS_C);
        let mut probe = Probe::new(self.seed, self.noise_um);
        let moves = matches!(self.load, Load::Axes(_));
        let mut text = String::from("t_s,position,x1_um,y1_um,z_um,x2_um,y2_um,ambient_c,spindle_c,machine_c\n");
        let [length, apart] = self.mandrel_mm;
        let now =
            |bodies: &Bodies, [x, y, z]: [f64; 3]| [length, length - apart].map(|tool| drift(bodies, [x, y, z, tool]));
        let zero = self.at_mm.map(|at| now(&bodies, at));
        for t in (0..=self.duration_s).step_by(STEP_S as usize) {
            let air_c = shift.at(t).air_c;
            let loaded = 3 * u64::from(t) < 2 * u64::from(self.duration_s);
            let (rpm, feed) = match self.load {
                Load::Spindle(rpm) if loaded => (rpm, 0.0),
                Load::Axes(share) if loaded => (0.0, share),
                _ => (0.0, 0.0),
            };
            if t.is_multiple_of(self.every_s.max(STEP_S)) {
                for (number, (at, zero)) in (1..).zip(self.at_mm.iter().zip(&zero)).take(if moves { 2 } else { 1 }) {
                    let [low, high] = now(&bodies, *at);
                    let mut um = |value: f64, zero: f64| 1e3 * probe.read(value - zero);
                    let [x1, y1, z] = [0, 1, 2].map(|axis| um(low[axis], zero[0][axis]));
                    let [x2, y2] = [0, 1].map(|axis| um(high[axis], zero[1][axis]));
                    let [spindle, machine] = [Node::NoseSkin, Node::ColumnFront].map(|node| bodies.of(node));
                    // The second position is reached a second later.
                    let time = t + number - 1;
                    let _ = writeln!(
                        text,
                        "{time},{number},{x1:.3},{y1:.3},{z:.3},{x2:.3},{y2:.3},{air_c:.2},{spindle:.2},{machine:.2}"
                    );
                }
            }
            bodies.pass(f64::from(STEP_S), &Conditions { rpm, feed, coolant: false, air_c });
        }
        text
    }
}
