//! Events while a pin is ground.

/// An event; times are turns of the spindle since its first index pulse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// The spindle brakes, rests, and accelerates again.
    Stop {
        /// Start of braking.
        at: f64,
        /// Time from then until the spindle turns again, s.
        for_s: f64,
    },
    /// The index pulse of a turn is missing.
    MissingIndex {
        /// Number of the turn.
        turn: i64,
    },
    /// A probe reads far outside its range, as if it had been knocked off.
    ProbeOut {
        /// Index of the probe.
        probe: usize,
        /// Start.
        at: f64,
        /// Duration in turns.
        turns: f64,
    },
    /// Another rough pin, larger than the finished size of the last; it is reported to the step, and feeding restarts.
    NewPart {
        /// Time of the change.
        at: f64,
    },
    /// The wheel is dressed to another radius within a turn.
    Wheel {
        /// Time of dressing.
        at: f64,
        /// Radius afterwards, mm.
        wheel_mm: f64,
        /// Whether it is reported to the gauge at the end of that turn.
        reported: bool,
    },
}
