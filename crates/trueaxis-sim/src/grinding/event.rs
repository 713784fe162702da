//! Events while a pin is ground.

/// An event; times are turns of the spindle since its first index pulse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// The spindle brakes, stands, and comes up again.
    Stop {
        /// When it begins to brake.
        at: f64,
        /// From then until it is to turn again, s.
        for_s: f64,
    },
    /// The index pulse of a turn does not come.
    MissingIndex {
        /// Number of the turn.
        turn: i64,
    },
    /// A probe reads far outside its range, as one does that was knocked off.
    ProbeOut {
        /// Index of the probe.
        probe: usize,
        /// From when.
        at: f64,
        /// For how many turns.
        turns: f64,
    },
    /// Another rough pin, larger than the last became; it is reported to the step, and feeding begins anew.
    NewPart {
        /// When.
        at: f64,
    },
    /// The wheel is dressed to another radius within a turn.
    Wheel {
        /// When.
        at: f64,
        /// Radius afterwards, mm.
        wheel_mm: f64,
        /// Reported to the gauge at the end of that turn.
        told: bool,
    },
}
