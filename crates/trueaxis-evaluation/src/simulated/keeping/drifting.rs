//! A machine that drifts over a shift.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis::machine::Axis;
use trueaxis_sim::warming::{SHIFT_S, drift_of_shift};
use trueaxis_tables::Machine;

/// Length of the tool, mm.
const TOOL_MM: f64 = 100.0;
/// Two positions that determine the drift's offsets and slopes: the drift is linear in X and in Z.
const PLACES: [[f64; 4]; 2] = [[0.0, 0.0, 0.0, TOOL_MM], [100.0, 0.0, -100.0, TOOL_MM]];
/// Standard deviation of a location error's change over a shift, mm and rad.
const WANDER: [f64; 2] = [0.005, 15e-6];
/// Time constant of the change, s.
const SETTLES_S: f64 = 9_000.0;

/// The machine at the start of the shift, and its drift.
pub(super) struct Drifting {
    machine: Machine,
    moments: Vec<Vec<[f64; 3]>>,
    every_s: u32,
    /// Random factors of C0Y, and of the components of A and C.
    wander: [f64; 13],
}

impl Drifting {
    /// A machine over a shift; `every_s` is the time between two parts.
    pub(super) fn new(machine: Machine, seed: u64, every_s: u32) -> Drifting {
        let mut dice = ChaCha8Rng::seed_from_u64(seed ^ 0xd21f7);
        let wander = std::array::from_fn(|_| StandardNormal.sample(&mut dice));
        Drifting { machine, moments: drift_of_shift(seed, every_s, &PLACES), every_s, wander }
    }

    /// Maximum number of parts in a shift.
    pub(super) fn most(every_s: u32) -> u32 {
        SHIFT_S / every_s
    }

    /// The true machine after `parts` parts.
    pub(super) fn after(&self, parts: u32) -> Machine {
        let mut machine = self.machine.clone();
        let Some([zero, other]) = self.moments.get(parts as usize).map(|at| [at[0], at[1]]) else { return machine };
        for (slot, axis) in machine.settings.axes.iter().map(|own| own.axis).enumerate() {
            let k = axis.index();
            let Some(table) = machine.tables.get_mut(slot).and_then(Option::as_mut) else { continue };
            let slope = match axis {
                Axis::X => (other[0] - zero[0]) / (PLACES[1][0] - PLACES[0][0]),
                Axis::Z => (other[2] - zero[2]) / (PLACES[1][2] - PLACES[0][2]),
                _ => 0.0,
            };
            for row in &mut table.rows {
                let by = zero[k] + slope * row.position;
                row.forward[k] += by;
                row.reverse[k] += by;
            }
        }
        let share = 1.0 - (-f64::from(parts * self.every_s) / SETTLES_S).exp();
        let location = &mut machine.settings.location;
        let rotary = |axis: Axis| self.machine.settings.axis(axis).is_some();
        if !rotary(Axis::C) {
            location.c0y += share * WANDER[1] * self.wander[0];
        }
        for (which, axis, across) in [(0, Axis::A, [1, 2, 4, 5]), (2, Axis::C, [0, 1, 3, 4])] {
            for component in across.into_iter().filter(|_| rotary(axis)) {
                let size = WANDER[usize::from(component >= 3)];
                location.rotary[which][component] += share * size * self.wander[1 + which * 3 + component];
            }
        }
        machine
    }
}
