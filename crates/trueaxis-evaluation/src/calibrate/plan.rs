//! A plan: the touches of a task in order, and the moves between them.

use super::task::{Probe, Task};
use trueaxis::machine::AXES;

/// A planned touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// Index of the artefact.
    pub artefact: usize,
    /// Index of its place.
    pub place: usize,
    /// Feature of the artefact: ball of a plate, face of a gauge, arm of a square, pose of a ball.
    pub feature: usize,
    /// Where the probing move starts: X, Y, Z, A, B, C, mm and degrees.
    pub start: [f64; AXES],
    /// Where the probing move ends if nothing is touched.
    pub end: [f64; AXES],
    /// Where every axis comes from before the start: X, Y, Z.
    pub take_up: [f64; 3],
    /// 1 for an axis that arrives in negative travel, else 0; X, Y, Z.
    pub reverse: [f64; 3],
    /// Time from the start of the program, s, excluding pauses.
    pub time_s: f64,
    /// Index of the visit.
    pub visit: usize,
}

/// A step of the program.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// The program waits for the operator.
    Pause(String),
    /// A remark.
    Remark(String),
    /// A rapid move of these axes.
    Rapid([Option<f64>; AXES]),
    /// A move at the feed between touches, X, Y, Z.
    Feed([f64; 3]),
    /// A probing move: index of the touch.
    Probe(usize),
}

/// An uninterrupted series of touches on an artefact.
#[derive(Clone, Debug, PartialEq)]
pub struct Visit {
    /// Index of the artefact.
    pub artefact: usize,
    /// Index of its place.
    pub place: usize,
    /// Whether the visit serves to measure drift.
    pub reference: bool,
    /// Index of the set-up; the program pauses between two set-ups.
    pub set_up: usize,
}

/// The whole program.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Steps in order.
    pub steps: Vec<Step>,
    /// Touches in order.
    pub touches: Vec<Planned>,
    /// Visits in order.
    pub visits: Vec<Visit>,
    /// Number that identifies the touches: equal touches give an equal number.
    pub identity: u32,
}

impl Plan {
    /// [`Plan::identity`] as program, log and history write it: eight hexadecimal digits.
    pub fn number(&self) -> String {
        format!("{:08x}", self.identity)
    }

    /// Time of the whole program, minutes, excluding pauses.
    pub fn minutes(&self) -> f64 {
        self.touches.last().map_or(0.0, |touch| touch.time_s / 60.0)
    }

    /// Axis positions at the touches if every artefact is where the task says: X, Y, Z, A, B, C.
    pub(super) fn nominal(&self, probe: &Probe) -> Vec<[f64; AXES]> {
        let share = probe.approach_mm / (probe.approach_mm + probe.overtravel_mm);
        let at = |touch: &Planned| std::array::from_fn(|k| touch.start[k] + share * (touch.end[k] - touch.start[k]));
        self.touches.iter().map(at).collect()
    }

    /// Lowest and highest position of X, Y, Z in the probing moves at places with a single pose of A, B, C, mm; 0 without any.
    pub fn reach_mm(&self, task: &Task) -> [[f64; 2]; 3] {
        let still = |touch: &&Planned| {
            let poses = task.artefacts.get(touch.artefact).and_then(|a| a.places.get(touch.place));
            poses.is_none_or(|place| place.rotary_deg.len() == 1)
        };
        std::array::from_fn(|axis| {
            let all = self.touches.iter().filter(still).flat_map(|touch| [touch.start[axis], touch.end[axis]]);
            let ends = all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], q| [low.min(q), high.max(q)]);
            if ends[0] <= ends[1] { ends } else { [0.0; 2] }
        })
    }
}
