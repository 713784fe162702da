//! Parts of the dynamic correction that the step's watch withdrew.

use super::sample::Moment;
use trueaxis::telemetry::Status;

/// Bits of the status that report a part as withdrawn, with the part and the reason in words.
const PARTS: [(Status, &str, &str); 3] = [
    (
        Status::FEEDBACK_OUT,
        "contour feedback",
        "the contour error oscillated, or an oscillation was larger with it than without it",
    ),
    (Status::FRICTION_OUT, "friction part", HARM),
    (Status::LAG_OUT, "lag or acceleration part", HARM),
];
const HARM: &str = "the contour error was larger with it than without it";

/// Most withdrawals that a run lists.
const MOST: usize = 20;

/// A part withdrawn during a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Withdrawn {
    part: &'static str,
    why: &'static str,
    /// First cycle without it, counted from the start of the program.
    cycle: u64,
    /// Program line.
    line: u32,
}

impl Withdrawn {
    /// A sentence with the part, the time, the line and the reason.
    pub(super) fn note(&self, period_s: f64) -> String {
        let Withdrawn { part, why, cycle, line } = self;
        let time_s = *cycle as f64 * period_s;
        format!("the watch withdrew the {part} at {time_s:.4} s, line {line}: {why}")
    }
}

/// Withdrawals so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Withdrawals {
    last: u8,
    pub(super) found: Vec<Withdrawn>,
}

impl Withdrawals {
    /// Adds the parts that a cycle's status reports for the first time.
    pub(super) fn add(&mut self, status: Status, moment: &Moment) {
        for (bit, part, why) in PARTS {
            if status.has(bit) && self.last & bit.0 == 0 && self.found.len() < MOST {
                self.found.push(Withdrawn { part, why, cycle: moment.cycle, line: moment.line });
            }
        }
        self.last = status.0;
    }
}
