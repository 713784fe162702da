//! A plan: the touches of a task in their order, and the ways between them.

use super::task::Task;
use trueaxis::machine::AXES;

/// A touch as planned.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// Index of the artefact.
    pub artefact: usize,
    /// Index of its place.
    pub place: usize,
    /// What of the artefact there: ball of a plate, face of a gauge, arm of a square, pose of a ball.
    pub feature: usize,
    /// Where the probing move starts: X, Y, Z, A, B, C, mm and degrees.
    pub start: [f64; AXES],
    /// Where it ends if nothing is touched.
    pub end: [f64; AXES],
    /// Where every axis comes from before it: X, Y, Z.
    pub take_up: [f64; 3],
    /// 1 for an axis that arrives in negative travel, else 0; X, Y, Z.
    pub reverse: [f64; 3],
    /// Time from the start of the program, s, pauses left out.
    pub time_s: f64,
    /// Visit that it belongs to.
    pub visit: usize,
}

/// A step of the program.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// The operator does something; the program waits.
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

/// A stay at an artefact without a pause.
#[derive(Clone, Debug, PartialEq)]
pub struct Visit {
    /// Index of the artefact.
    pub artefact: usize,
    /// Index of its place.
    pub place: usize,
    /// Whether it is there to see the drift.
    pub reference: bool,
    /// Set-up that it belongs to: between two of them there is a pause.
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
    /// Number that names the touches: the same for the same touches.
    pub identity: u32,
}

impl Plan {
    /// [`Plan::identity`] as program, log and history name it: eight hexadecimal digits.
    pub fn number(&self) -> String {
        format!("{:08x}", self.identity)
    }

    /// Time of the whole program, minutes, pauses left out.
    pub fn minutes(&self) -> f64 {
        self.touches.last().map_or(0.0, |touch| touch.time_s / 60.0)
    }

    /// Lowest and highest position of X, Y, Z that is touched at the poses where A, B, C stand as at first, mm.
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
