//! Values that a program sets and that stay in force, beside those of the interpreter itself.

use super::arc::Plane;

/// A feed as programmed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Feed {
    /// The F word.
    pub(super) number: f64,
    /// The number in mm, if it counts lengths.
    pub(super) mm: f64,
}

/// What the program has said about spindle and coolant, for the parameters that tell it.
#[derive(Debug, Default)]
pub(super) struct Spindle {
    /// M3, M4 or M5; 0 before the first.
    pub(super) word: u16,
    pub(super) speed: f64,
    /// G96.
    pub(super) surface_speed: bool,
    pub(super) mist: bool,
    pub(super) flood: bool,
}

/// What M70 saves: all modes but the motion word.
#[derive(Clone, Debug)]
pub(super) struct Modes {
    pub(super) plane: Plane,
    pub(super) inch: bool,
    pub(super) incremental: bool,
    pub(super) absolute_center: bool,
    pub(super) inverse_time: bool,
    pub(super) diameter: bool,
    pub(super) feed: Option<Feed>,
    pub(super) retract_to_start: bool,
    pub(super) exact_stop: bool,
    pub(super) system: usize,
    pub(super) tool: bool,
}

/// What a subprogram has saved.
#[derive(Clone, Debug, Default)]
pub(super) struct Saved {
    pub(super) modes: Option<Modes>,
    /// M73: restored where the subprogram ends.
    pub(super) on_return: bool,
}
