//! The machine's bodies as lumped masses that exchange heat: C dT/dt = P + Σ G (T_other − T).

use super::duty::{Conditions, Shift};
use super::{NIGHT_S, STEP_S};

/// Nodes: skin and core of every body, so that no body has a single time constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Node {
    NoseCore,
    NoseSkin,
    HeadCore,
    HeadSkin,
    ColumnFront,
    ColumnBack,
    BedTop,
    BedBottom,
    Screw,
    Table,
    Tank,
}

const NODES: usize = 11;
/// Heat capacity, J/K: 470 J/(kg K) of steel and iron; 45 litres in the tank.
const CAPACITY: [f64; NODES] = [3_200.0, 4_200.0, 17_000.0, 14_000.0, 120e3, 130e3, 250e3, 350e3, 9_000.0, 60e3, 190e3];

/// Conductance between two nodes, W/K.
const JOINTS: [(Node, Node, f64); 10] = [
    (Node::NoseCore, Node::NoseSkin, 16.0),
    (Node::NoseSkin, Node::HeadCore, 11.0),
    (Node::HeadCore, Node::HeadSkin, 15.0),
    (Node::HeadSkin, Node::ColumnFront, 10.0),
    (Node::ColumnFront, Node::ColumnBack, 30.0),
    (Node::ColumnBack, Node::BedBottom, 14.0),
    (Node::ColumnFront, Node::BedTop, 12.0),
    (Node::BedTop, Node::BedBottom, 45.0),
    (Node::Screw, Node::BedTop, 5.0),
    (Node::Table, Node::BedTop, 6.0),
];

/// Conductance to the air, W/K.
const TO_AIR: [(Node, f64); 8] = [
    (Node::NoseSkin, 3.0),
    (Node::HeadSkin, 7.0),
    (Node::ColumnFront, 8.0),
    (Node::ColumnBack, 11.0),
    (Node::BedTop, 9.0),
    (Node::Table, 6.0),
    (Node::Screw, 3.0),
    (Node::Tank, 9.0),
];

/// Temperatures of all nodes, °C.
#[derive(Clone, Debug)]
pub(super) struct Bodies([f64; NODES]);

impl Bodies {
    /// All nodes in equilibrium at one temperature.
    pub(super) fn at(temperature_c: f64) -> Bodies {
        Bodies([temperature_c; NODES])
    }

    /// Temperature of a node, °C.
    pub(super) fn of(&self, node: Node) -> f64 {
        self.0[node as usize]
    }

    /// Advances by `dt_s`, explicitly: the shortest time constant is two minutes.
    pub(super) fn pass(&mut self, dt_s: f64, now: &Conditions) {
        let mut heat = [0.0; NODES];
        let mut give = |node: Node, watts: f64| heat[node as usize] += watts;
        for (one, other, conductance) in JOINTS {
            let watts = conductance * (self.of(one) - self.of(other));
            give(one, -watts);
            give(other, watts);
        }
        for (node, conductance) in TO_AIR {
            give(node, conductance * (now.air_c - self.of(node)));
        }
        // Friction of the bearings and losses of the motor; the rotating nose acts as a fan.
        let speed = now.rpm / 12_000.0;
        give(Node::NoseCore, 70.0 * speed + 190.0 * speed * speed);
        give(Node::HeadCore, 40.0 * speed);
        give(Node::NoseSkin, 3.0 * speed * (now.air_c - self.of(Node::NoseSkin)));
        give(Node::Screw, 45.0 * now.feed);
        give(Node::BedBottom, 9.0 * (19.5 - self.of(Node::BedBottom)));
        if now.coolant {
            give(Node::Tank, 120.0);
            for (node, conductance) in [(Node::Table, 35.0), (Node::BedTop, 20.0), (Node::NoseSkin, 2.0)] {
                let watts = conductance * (self.of(Node::Tank) - self.of(node));
                give(node, watts);
                give(Node::Tank, -watts);
            }
        }
        for ((temperature, heat), capacity) in self.0.iter_mut().zip(heat).zip(CAPACITY) {
            *temperature += dt_s * heat / capacity;
        }
    }

    /// The night after a shift, with everything off.
    pub(super) fn rest(&mut self, shift: &Shift) {
        let night = Conditions { rpm: 0.0, feed: 0.0, coolant: false, air_c: shift.night_c() };
        for _ in 0..NIGHT_S / STEP_S {
            self.pass(f64::from(STEP_S), &night);
        }
    }
}
