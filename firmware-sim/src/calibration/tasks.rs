//! Tasks of the simulated calibrations.

/// A ring of 150 mm and a ball of 25 mm in a mill of 500 × 400 × 300 mm: the ring flat at five places, upright at eight.
pub const MILL: &str = include_str!("mill.toml");

/// The same artefacts on a trunnion machine: the ring for the linear axes, the ball on the table at sixteen poses.
pub const FIVE_AXES: &str = include_str!("five-axes.toml");
