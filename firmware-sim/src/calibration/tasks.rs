//! Tasks of the simulated calibrations.

use std::path::Path;

/// A ring of 150 mm and a ball of 25 mm in a mill of 500 × 400 × 300 mm: the ring flat at five places, upright at eight.
pub const MILL: &str = include_str!("mill.toml");

/// The same artefacts on a trunnion machine: the ring for the linear axes, the ball at five places, eighteen poses at each.
pub const FIVE_AXES: &str = include_str!("five-axes.toml");

/// The same mill by two step gauges and a square of unknown angle, turned over in all three planes; a ball for the drift.
pub const GAUGE_AND_SQUARE: &str = include_str!("gauge-and-square.toml");

/// The same mill by a ball plate, flat and upright.
pub const BALL_PLATE: &str = include_str!("ball-plate.toml");

/// The text of a task, with its file as errors name it.
#[derive(Clone, Copy, Debug)]
pub struct TaskText<'t> {
    /// The file.
    pub file: &'t Path,
    /// The text.
    pub text: &'t str,
}

impl<'t> TaskText<'t> {
    /// The text of a file; of `task.toml` where none is given.
    pub fn of(file: Option<&'t Path>, text: &'t str) -> Self {
        TaskText { file: file.unwrap_or(Path::new("task.toml")), text }
    }
}

impl<'t> From<&'t str> for TaskText<'t> {
    fn from(text: &'t str) -> Self {
        TaskText::of(None, text)
    }
}
