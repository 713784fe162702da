//! The program as the plugin's path: spans, and the reference on them.

mod drawn;
mod planned;
mod reference;
mod sliding;
mod spans;

pub use drawn::{DrawnPoint, drawn};
pub use planned::{PlannedPath, check};
pub use sliding::SlidingPath;
pub use spans::MOST_SPANS;
