//! Tasks of the simulated calibrations.

use std::path::Path;

/// A ring of 150 mm and a ball of 25 mm in a mill of 500 × 400 × 300 mm: the ring flat in five positions, upright in eight.
pub const MILL: &str = include_str!("../mill.toml");

/// A trunnion machine with the same artefacts: the ring for the linear axes, the ball in five positions with eighteen
/// poses each.
pub const FIVE_AXES: &str = include_str!("../five-axes.toml");

/// The mill with two step gauges and a square of unknown angle, turned over in all three planes; a ball for the drift.
pub const GAUGE_AND_SQUARE: &str = include_str!("../gauge-and-square.toml");

/// The mill with a ball plate, flat and upright.
pub const BALL_PLATE: &str = include_str!("../ball-plate.toml");

/// The text of a task, and its file name for error messages.
#[derive(Clone, Copy, Debug)]
pub struct TaskText<'t> {
    /// The file.
    pub file: &'t Path,
    /// The text.
    pub text: &'t str,
}

impl<'t> TaskText<'t> {
    /// The text of a task, with the name of its file or else `task.toml`.
    pub fn of(file: Option<&'t Path>, text: &'t str) -> Self {
        TaskText { file: file.unwrap_or(Path::new("task.toml")), text }
    }
}

impl<'t> From<&'t str> for TaskText<'t> {
    fn from(text: &'t str) -> Self {
        TaskText::of(None, text)
    }
}
