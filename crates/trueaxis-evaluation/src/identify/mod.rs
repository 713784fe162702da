//! Errors of a rotary axis from a ball held in place: the measured file as a test, and what was found as the axis' table.
//!
//! The mathematics is [`trueaxis_metrology::identification`].

mod readings;
mod table;

pub use readings::{COLUMNS, Readings, SAME_ANGLE_DEG};
pub use table::table;
